"""Every published number has ours beside it, and the probes show what they should."""

import pytest

from baroarma.experiments import NAMES, experiments, run_experiments, tally
from baroarma.experiments.literature import published_in
from baroarma.experiments.methods import SENSORS, identified_noise


@pytest.fixture(scope="module")
def results():
    found = run_experiments(list(experiments().values()), trials=1, presets=("zihajehzadeh15",))
    return {result.experiment: result for result in found}


def value(result, label, quantity):
    return next(r.reproduced for r in result.rows if (r.label, r.quantity) == (label, quantity))


def test_every_published_number_stands_beside_ours_with_a_verdict(results):
    assert tuple(results) == NAMES
    rows = [
        (r, n) for result in results.values() for r in result.rows for n in [r.published] if n is not None
    ]
    assert len(rows) >= 80
    assert all(row.reproduced is not None for row, _ in rows)
    assert all(row.verdict.startswith(("within 1 SD", "within 2 SD", "differs: ")) for row, _ in rows)
    for name, result in results.items():
        keys = [(row.label, row.quantity) for row in result.rows]
        assert len(set(keys)) == len(keys)
        assert set(published_in(name)) <= set(keys)
        assert result.assumptions


@pytest.mark.parametrize("name", [n for n in NAMES if experiments()[n].tracks])
def test_presets_stand_in_the_same_table(results, name):
    ours = [row for row in results[name].rows if row.label.startswith("zihajehzadeh15")]
    assert ours
    assert all(row.published is None and row.verdict == "" for row in ours)
    assert all(row.reproduced is not None for row in ours)


def test_a_prior_does_what_the_whitening_filter_does_at_rest(results):
    # Method A behind 0.21 x barometer: the noise of Method A times 0.21, whatever it is
    rest = results["sg14-table-2"]
    a, b, fed = (
        value(rest, label, "height RMSE (m)")
        for label in ("Method A", "Method B", "Method A fed with 0.21 x barometer")
    )
    assert b < a
    assert fed < b
    assert fed == pytest.approx(0.2086 * a, abs=0.01)  # the accelerometer's share: 5 mm (next row)
    assert value(rest, "Method A fed with 0 x barometer", "height RMSE (m)") < 0.01


def test_the_midpoint_lowers_the_velocity_error_on_a_fast_circle(results):
    # Euler's lag of T/2 alone makes omega² L T/2/sqrt(2) = 0.13 m/s at 1.25 Hz
    circle = results["sg14-table-4"]
    for letter in "AB":
        euler = value(circle, f"Method {letter}, 1.25 Hz", "velocity RMSE (m/s)")
        midpoint = value(circle, f"Method {letter}, midpoint, 1.25 Hz", "velocity RMSE (m/s)")
        assert midpoint < euler


def test_a_free_bias_loses_the_tilt_in_squats(results):
    squats = results["sg14-squat"]
    free, frozen, true = (
        value(squats, f"Method A, {how}, ten squats", "velocity RMSE (m/s)")
        for how in ("bias free (0.03 m/s²)", "bias frozen", "true attitude")
    )
    assert frozen == pytest.approx(true, abs=0.01)  # what is left is the barometer's, the same in both
    assert free > 3 * true


def test_the_matched_filter_whitens_where_the_papers_does_not(results):
    # a p-value of one day each; over days see docs/identification.md: 90 % against 0 % above 0.1
    table = results["sg13-table-4"]
    paper = value(table, "all six tests", "zero-pole cancellation (p)")
    matched = value(table, "all six tests, filter from the raw density", "zero-pole cancellation (p)")
    assert paper < 0.1 < matched


def test_zeroing_over_the_run_brings_table_6_back(results):
    # SG13's 0.53 m: white 0.46, Gauss-Markov 0.27 and the steps of 1 Pa; 2 min hold the drift to some cm
    table = results["sg13-table-6"]
    for frequency in ("0.5", "1", "1.25", "1.5"):
        raw = value(table, f"Method A, zeroed over the run, {frequency} Hz", "altitude RMSE (m)")
        assert raw == pytest.approx(0.53, abs=0.03)


def test_averages_of_lee16_are_those_of_its_rows(results):
    table = results["lee16-table-2"]
    tests = [value(table, f"a_KF + CF, Test {test}", "height RMSE (cm)") for test in "ABCDE"]
    assert value(table, "a_KF + CF, average", "height RMSE (cm)") == pytest.approx(sum(tests) / 5)
    two = [value(table, f"a_OPT + KF, Test {test}", "height RMSE (cm)") for test in "DE"]
    assert value(table, "a_OPT + KF, average", "height RMSE (cm)") == pytest.approx(sum(two) / 2)


def test_text_and_json_hold_the_same_rows(results):
    result = results["sg14-table-3"]
    document = result.to_dict()
    assert list(document) == ["experiment", "assumptions", "rows"]
    assert set(document["rows"][0]) == {
        "label", "quantity", "published", "published_sd", "reproduced", "reproduced_sd", "trials", "verdict"
    }  # fmt: skip
    lines = result.summary(100).splitlines()
    for row in document["rows"]:
        assert any(row["label"] in line and row["quantity"] in line for line in lines)
    assert result.tally() in lines[1]


def test_oddities_of_the_print_are_told(results):
    notes = results["sg13-table-5"].notes
    assert any("almost surely 3.79" in note for note in notes)
    assert "* Table 5, Method A, floor 2" in results["sg13-table-5"].summary()
    assert len(results["sg13-table-6"].notes) == 1  # twelve rows share one oddity


def test_every_number_that_differs_has_a_numbered_reason(results):
    for result in results.values():
        cells, reasons = result.cells()
        cited = {c[4].partition("[")[2].partition("]")[0] for c in cells if c[4].startswith("differs")}
        assert cited == {str(i + 1) for i in range(len(reasons))}


def test_the_tally_counts_every_published_number(results):
    text = tally(list(results.values()))
    total, *counts = (int(word) for word in text.partition(";")[0].replace(":", "").split() if word.isdigit())
    within = [counts[0], counts[2], counts[4]]  # "n within 1 SD, n within 2 SD, n differ"
    assert (
        sum(within)
        == total
        == sum(len([r for r in x.rows if r.published is not None]) for x in results.values())
    )


def test_the_noise_of_presets_is_identified_not_given():
    found, truth = identified_noise("SG14", 0), SENSORS["SG14"].barometer.noise
    assert found.ci95 is not None
    assert found.white_sd != truth.white_sd
    assert found.white_sd == pytest.approx(truth.white_sd, rel=0.02)  # 1/sqrt(2 n) = 0.4 %, and 1 Pa steps
