"""A finding is the same on a page, in a table and in a program."""

from dataclasses import FrozenInstanceError

import pytest

from baroarma.finding import Finding

GAPS = Finding("gaps", "warning", "3 gaps, the longest 2.6 s.")


def test_people_read_severity_code_and_sentence():
    assert str(GAPS) == "warning (gaps): 3 gaps, the longest 2.6 s."


def test_json_has_its_three_fields_and_gives_it_back():
    assert GAPS.to_dict() == {
        "code": "gaps",
        "severity": "warning",
        "message": "3 gaps, the longest 2.6 s.",
    }
    assert Finding(**GAPS.to_dict()) == GAPS


def test_it_can_be_kept_in_a_set_and_not_be_changed():
    assert len({GAPS, Finding("gaps", "warning", "3 gaps, the longest 2.6 s.")}) == 1
    with pytest.raises(FrozenInstanceError):
        GAPS.code = "other"
