"""The published numbers are those of the papers."""

import pytest

from baroarma.experiments import NAMES
from baroarma.experiments.literature import published, published_in, reason

BY_HAND = [
    # copied from the printed tables for this test, not from the data files
    ("sg13-table-1", "indoors 2", "correlation time (s)", 0.87, 0.34),
    ("sg13-table-1", "outdoors 2", "total sd (m)", 0.36, 0.04),
    ("sg13-table-2", "outdoors 2", "correlation time (s)", 1.26, 0.39),
    ("sg13-table-2", "indoors 3", "white sd (m)", 0.27, 0.01),
    ("sg13-table-3", "outdoors 3", "white sd (m)", 0.21, 0.03),
    ("sg13-table-4", "indoors 3", "total sd (m)", 0.27, 0.02),
    ("sg13-table-5", "Method A, floor 2", "mean altitude (m)", 3.97, 0.53),
    ("sg13-table-5", "Method C, floor 3", "mean altitude (m)", 1.12, 0.12),
    ("sg13-table-6", "Method B, 1.25 Hz", "altitude RMSE (m)", 0.32, None),
    ("sg14-table-2", "Method A", "height RMSE (m)", 0.40, 0.15),
    ("sg14-table-3", "Method B", "velocity RMSE (m/s)", 0.13, 0.04),
    ("sg14-table-4", "Method B, 1.25 Hz", "height RMSE (m)", 0.68, 0.07),
    ("sg14-table-4", "Method A, 0.75 Hz", "velocity RMSE (m/s)", 0.11, 0.02),
    ("sg14-squat", "Method A", "maximum displacement (m)", 0.86, 0.39),
    ("lee16-table-2", "a_app + KF, Test A", "height RMSE (cm)", 86.9, None),
    ("lee16-table-2", "a_OPT + CF, Test D", "height RMSE (cm)", 16.8, None),
    ("lee16-table-2", "barometer alone, average", "height RMSE (cm)", 43.4, None),
    ("lee16-table-2", "CF against KF", "cost ratio (%)", 12.5, None),
]


@pytest.mark.parametrize(("experiment", "label", "quantity", "value", "sd"), BY_HAND)
def test_a_number_is_as_printed(experiment, label, quantity, value, sd):
    number = published_in(experiment)[label, quantity]
    assert (number.value, number.sd) == (value, sd)


def test_every_table_is_complete():
    # rows x columns of the printed tables, plus what the text adds
    counts = {name: sum(n.value is not None for n in published_in(name).values()) for name in NAMES}
    assert counts == {
        "sg13-table-1": 6 * 4 + 2,
        "sg13-table-2": 6 * 4,
        "sg13-table-3": 6 * 2 + 3,
        "sg13-table-4": 6 * 2,
        "sg13-figure-5": 4,
        "sg13-table-5": 3 * 4 * 2,
        "sg13-table-6": 3 * 4,
        "sg14-table-2": 4,
        "sg14-table-3": 4,
        "sg14-table-4": 5 * 4,
        "sg14-squat": 4,
        "lee16-table-2": 5 + 5 * 4 + 2 * 2 + 7 + 3,
    }


def test_a_number_stands_once_and_says_where():
    keys = [(n.experiment, *n.key) for n in published()]
    assert len(set(keys)) == len(keys)
    assert {n.experiment for n in published()} == set(NAMES)
    assert all(n.paper and n.table for n in published())


def test_a_number_is_a_value_or_a_claim():
    assert all((n.value is None) == (n.bound != "") for n in published())
    assert all(n.note for n in published() if n.tolerance is not None)  # a tolerance needs its reason


def test_the_papers_averages_are_those_of_their_rows():
    # Lee16, Table 2, rounded to 0.1: a transcription error of a millimetre in a mean of five would show
    numbers = published_in("lee16-table-2")
    for row in ("barometer alone", "a_KF + CF", "a_KF + KF", "a_app + CF", "a_app + KF"):
        tests = [numbers[f"{row}, Test {test}", "height RMSE (cm)"].value for test in "ABCDE"]
        average = numbers[f"{row}, average", "height RMSE (cm)"].value
        assert sum(tests) / 5 == pytest.approx(average, abs=0.051)


def test_rounding_is_half_the_last_printed_digit():
    assert published_in("sg13-table-6")["Method A, 1 Hz", "altitude RMSE (m)"].rounding == 0.005
    assert published_in("lee16-table-2")["barometer alone, Test A", "height RMSE (cm)"].rounding == 0.05


def test_a_reason_belongs_to_its_number():
    assert "half the gain" in reason("sg13-table-5", "Method C, floor 1", "SD of the altitude (m)")
    assert reason("sg14-table-2", "Method A", "height RMSE (m)") == ""
