"""The rule by which numbers are judged."""

import pytest

from baroarma.experiments.literature import Published
from baroarma.experiments.verdict import judge


def number(value=None, sd=None, tolerance=None, bound="", quantity="height RMSE (m)"):
    return Published("nowhere", "SG14", "Table 2", "row", quantity, value, sd, 0.005, tolerance, bound, "")


@pytest.mark.parametrize(
    ("reproduced", "verdict"),
    [
        (0.499, "within 1 SD"),
        (0.301, "within 1 SD"),
        (0.201, "within 2 SD"),
        (0.6001, "differs: not explained"),
    ],
)
def test_the_published_sd_is_the_yardstick(reproduced, verdict):
    assert judge(number(0.4, 0.1), reproduced, 5.0, 10) == verdict  # our own large sd excuses nothing


def test_without_a_published_sd_ours_stands_in():
    assert judge(number(0.4), 0.45, 0.06, 10) == "within 1 SD"
    assert judge(number(0.4), 0.45, 0.03, 10) == "within 2 SD"
    assert judge(number(0.4), 0.45, 0.01, 10).startswith("differs")


def test_rounding_is_no_difference():
    assert judge(number(0.40), 0.4049, 0.0, 10) == "within 1 SD"
    assert judge(number(0.40), 0.4049, None, 1) == "within 1 SD"


def test_about_has_a_tolerance():
    assert judge(number(1.0, tolerance=0.1), 1.06, 0.0, 10) == "within 1 SD"


def test_a_claim_is_met_or_not():
    wilcoxon = number(bound="<0.01", quantity="height RMSE, Wilcoxon (p)")
    assert judge(wilcoxon, 0.002, None, 10) == "agrees: published <0.01"
    assert judge(wilcoxon, 0.02, None, 10).startswith("differs")
    assert judge(number(bound=">0.05"), 0.2, None, 10) == "agrees: published >0.05"
    assert judge(number(bound=">0.05"), 0.02, None, 10).startswith("differs")


def test_too_few_trials_cannot_meet_a_claim():
    wilcoxon = number(bound="<0.01", quantity="height RMSE, Wilcoxon (p)")
    assert judge(wilcoxon, 0.0625, None, 5).startswith("not judged: 5 pairs")
    assert not judge(wilcoxon, 0.0625, None, 8).startswith("not judged")  # 2/2**8 < 0.01


def test_no_result_is_not_judged():
    assert judge(number(0.4, 0.1), None, None, 0).startswith("not judged")
