"""What the first line of a file says; the refusals are in the catalogue, `tests/faults/test_files.py`."""

import pytest

from baroarma.formats import UnreadableError
from baroarma.formats.first_line import OTHER_KINDS, first_line


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (b"time_s,pressure_pa\n", (",", ("time_s", "pressure_pa"))),
        (b'"time_s" ; "a,b";c', (";", ("time_s", "a,b", "c"))),
        (b"time_s\tx y\r\r\n", ("\t", ("time_s", "x y"))),
        ("time_s,H\u00f6he".encode("latin-1"), (",", ("time_s", "H\u00f6he"))),
        ("time_s,H\u00f6he".encode(), (",", ("time_s", "H\u00f6he"))),
        (b"time_s\n", (",", ("time_s",))),
    ],
)
def test_the_separator_and_the_names_are_told(line, expected):
    assert first_line("a.csv", line) == expected


@pytest.mark.parametrize("magic", OTHER_KINDS)
def test_other_kinds_of_files_are_named_packed_or_not(magic):
    for packed, subject in ((False, "this is"), (True, "what is packed in it is")):
        with pytest.raises(UnreadableError, match=f"^a.csv: {subject} no plain text but "):
            first_line("a.csv", magic + b"rest", packed=packed)


def test_a_column_that_begins_like_another_kind_is_a_column():
    for name in (b"PK", b"PAR1", b"ULog", b"SQLite"):
        assert first_line("a.csv", name + b",time_s")[1][0] == name.decode()
