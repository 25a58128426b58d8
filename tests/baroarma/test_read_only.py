import numpy as np
import pytest

from baroarma.read_only import read_only


def test_what_can_be_written_is_copied():
    mine = np.arange(3.0)
    fixed = read_only(mine)
    mine[0] = 9.0
    assert fixed[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        fixed[0] = 1.0


def test_a_read_only_view_of_what_can_be_written_is_copied():
    mine = np.arange(3.0)
    view = mine[:]
    view.flags.writeable = False
    assert not np.shares_memory(read_only(view), mine)


def test_a_read_only_view_of_a_foreign_buffer_is_copied():
    buffer = bytearray(np.arange(3.0).tobytes())
    view = np.frombuffer(memoryview(buffer).toreadonly())
    fixed = read_only(view)
    buffer[:8] = np.array([7.0]).tobytes()
    assert fixed[0] == 0.0


def test_parts_of_what_nobody_can_write_share_its_memory():
    whole = read_only(np.arange(6.0).reshape(2, 3))
    assert np.shares_memory(read_only(whole[1]), whole)
    assert read_only(whole) is whole


def test_integers_become_floats():
    assert read_only([1, 2]).dtype == float
