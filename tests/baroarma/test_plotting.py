"""Plots: what is drawn agrees with the numbers, says its units and survives any name and any log."""

import math
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from scipy import signal
from statsmodels.tsa.stattools import acovf

import baroarma as ba
from baroarma import plotting
from baroarma.atmosphere import altitude_pressure
from baroarma.estimators.calibration import Calibration
from baroarma.experiments.result import Result, Row
from baroarma.identification.whiteness import cumulative_periodogram_test
from baroarma.identification.windows import identify_windows
from baroarma.plotting import canvas
from baroarma.plotting.canvas import envelope, svg
from baroarma.plotting.estimates import autocovariance, cumulative_periodogram, spectrum, without_levels
from baroarma.plotting.evidence import SIMULATIONS, acf_of_data_and_model, allan_band
from baroarma.simulation import simulate, simulate_rest
from baroarma.track import Track

mpl.use("Agg")
import matplotlib.pyplot as plt

NOISE = ba.NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
NAME = "cost $x_1$ <script>alert(1)</script> & 気圧"
EVIDENCE = [plotting.plot_acf, plotting.plot_psd, plotting.plot_allan, plotting.plot_residuals]


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def found():
    return ba.identify(simulate_rest(120, seed=1))


def known(model, t, seed):
    """An identification whose model is the truth."""
    height = 100 + model.simulate(t, seed)
    return ba.Identification(
        ba.Recording(t=t, pressure=altitude_pressure(height)), model, (), "structural", residuals=height
    )


def test_an_envelope_keeps_the_extremes_and_thins_the_rest():
    y = np.random.default_rng(0).normal(size=100_003)
    t, thin = envelope(np.arange(len(y)) * 0.02, y, bins=500)
    assert len(thin) == 1000
    assert (thin.min(), thin.max()) == (y.min(), y.max())
    assert np.all(np.diff(t) >= 0)


def test_an_enlargeable_picture_keeps_more_detail_and_only_that_one():
    y = np.random.default_rng(0).normal(size=10_000)
    with canvas.detailed(2000):
        assert len(envelope(np.arange(10_000.0), y)[1]) == 4000
    assert len(envelope(np.arange(10_000.0), y)[1]) == 2 * canvas.STILL


def test_a_gap_interrupts_the_line():
    t = np.concatenate((np.arange(100.0), 200 + np.arange(100.0)))
    drawn_t, drawn = envelope(t, np.ones(200))
    assert drawn_t[np.isnan(drawn)].tolist() == [200.0]


def test_autocovariance_of_a_regular_series_is_that_of_statsmodels():
    x = np.random.default_rng(1).normal(size=500)
    ours = autocovariance(np.arange(500) / 50, x, 1 / 50, 30)
    theirs = acovf(x, adjusted=True, demean=False, nlag=30)
    assert ours == pytest.approx(theirs, abs=1e-13)  # both exact but for rounding


def test_gaps_cost_the_autocovariance_pairs_and_nothing_else():
    rng = np.random.default_rng(2)
    x, kept = rng.normal(size=200), rng.random(200) > 0.4
    x[~kept] = np.nan
    ours = autocovariance(np.flatnonzero(kept) / 50, x[kept], 1 / 50, 10)
    by_hand = [np.nanmean(x[k:] * x[: len(x) - k]) for k in range(11)]
    assert ours == pytest.approx(by_hand, abs=1e-13)


def test_levels_are_removed_from_equal_blocks():
    t = np.arange(1000) * 0.1
    x = without_levels(t, 1e5 + t**2, 25.0).reshape(4, 250)
    assert x.mean(axis=1) == pytest.approx(np.zeros(4), abs=1e-9)  # rounding of values near 1e4


def test_the_spectrum_averages_the_periodogram_of_scipy():
    x = np.cumsum(np.random.default_rng(3).normal(size=3000))
    t = np.arange(3000) / 20
    taper = np.sin(np.pi * np.arange(3000) / 2999) ** 2
    f, p = signal.periodogram(x, 20, window=taper, detrend="linear")
    f, p = f[2:1500], p[2:1500]
    cell = np.floor(10 * np.log10(f))
    expected = [p[cell == c].mean() for c in np.unique(cell)]
    assert spectrum(t, x).density == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("uneven", [False, True])
def test_the_band_of_the_spectrum_holds_the_density_19_times_of_20(uneven):
    noise = ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
    rng = np.random.default_rng(4)
    inside = []
    for _ in range(30):
        t = np.arange(4000) / 50
        if uneven:  # every third sample missing at random, so that no stretch is long
            t = t[rng.random(4000) > 0.34]
        found = spectrum(t, noise.simulate(t, rng))
        assert found.regular is not uneven
        density = replace(noise, rate_hz=found.rate_hz).psd(found.frequency)
        inside.append((found.low < density) & (density < found.high))
    inside = np.concatenate(inside)
    # binomial: 3 sd about 0.95, bins being nearly independent; uneven sampling leaks a little power from
    # low to high frequencies, which may cost another 2 %
    tolerance = 3 * math.sqrt(0.95 * 0.05 / inside.size)
    assert 0.95 - tolerance - 0.02 * uneven < inside.mean() < 0.95 + tolerance


def test_the_cumulative_periodogram_is_the_one_that_is_tested():
    x = np.random.default_rng(5).normal(size=2001)
    _, off = cumulative_periodogram(x)
    # the test leaves the last ordinate out and looks at both sides of each step, each worth one in q
    assert np.abs(off).max() == pytest.approx(cumulative_periodogram_test(x).statistic, abs=2 / 1000)


def test_data_from_the_model_rank_evenly_among_its_simulations():
    """Data and simulations are treated alike, so that the data's rank is uniform whatever the lag."""
    t = np.arange(1500) / 50
    ranks = []
    for seed in range(40):
        lag, data, simulated = acf_of_data_and_model(known(NOISE, t, seed), seed + 1000)
        ranks.append((simulated[:, [0, 1, len(lag) // 2]] < data[[0, 1, len(lag) // 2]]).mean(axis=0))
    z = (np.mean(ranks, axis=0) - 0.5) * math.sqrt(12 * len(ranks))
    assert np.abs(z).max() < 3


def test_data_leave_the_band_of_a_model_with_half_the_correlated_noise():
    found = known(NOISE, np.arange(10_000) / 50, 1)
    wrong = replace(found, model=replace(NOISE, correlated_sd=0.13, drift_rate=0.0))
    lag, data, simulated = acf_of_data_and_model(wrong)
    early = (lag > 0) & (lag < NOISE.correlation_time)
    assert simulated.shape == (SIMULATIONS, len(lag))
    assert np.all(data[early] > np.quantile(simulated, 0.975, axis=0)[early])


def test_the_allan_band_of_white_noise_is_its_interval():
    none = dict.fromkeys(("correlated_sd", "correlation_time", "drift_rate"), (0, 0))
    white = ba.NoiseModel(0, 0, 0.4, rate_hz=50, ci95={"white_sd": (0.36, 0.4444), **none})
    low, high = allan_band(white, np.array([1.0]), draws=2000)
    scale = math.sqrt(1 / 50)
    # a 2.5 % quantile of 2000 normal draws has the sd 0.06 sd; the interval is +-1.96 sd, so 3 sd are 10 %
    assert np.log(high / low)[0] == pytest.approx(math.log(0.4444 / 0.36), rel=0.1)
    assert math.sqrt(low[0] * high[0]) == pytest.approx(0.4 * scale, rel=0.01)


def test_every_plot_returns_its_axes_with_units(found):
    whitening = found.model.whitening_filter()
    drawn = [plot(found) for plot in (plotting.plot_record, *EVIDENCE)]
    drawn += [plotting.plot_noise_model(found.model), plotting.plot_whitening(whitening)]
    drawn.append(plotting.plot_recording(found.recording))
    units = ("(m)", "(m²)", "(m²/Hz)", "(%)", "(dB)", "(s)", "(Hz)")
    for ax in drawn:
        assert ax.get_xlabel().endswith(units)
        assert ax.get_ylabel().endswith(units)
        assert ax.get_title(loc="left")


def arguments(found):
    """What each plot of one object is given, by the plot's name; those not here take no axes of ours."""
    model, t = found.model, np.arange(0, 9, 0.02)
    one = np.ones(len(t))
    row = Row("walk", "height RMSE (m)", 0.4, 0.15, 0.37, 0.12, 10, "")
    three = (0.1, 0.2, 0.3)
    tuned = ba.tune("sg14-a", model, duration=5.0)
    return {
        **dict.fromkeys(("record", "acf", "psd", "allan", "residuals", "identification"), found),
        **dict.fromkeys(("noise_model", "model_allan"), model),
        **dict.fromkeys(("whitening", "step_response"), model.whitening_filter()),
        "recording": found.recording,
        "arma": model.arma(0.1),
        "track": Track(t, one, one, one, one, one),
        "prediction": tuned.before,
        "tuning": tuned,
        "averaging": found.averaging_study(),
        "windows": identify_windows(*found.samples()),
        "calibration": Calibration(three, three, three, three, three, three, 8, 0.02),
        "result": Result("sg14-table-2", "walks", (), (row,)),
    }


def test_every_plot_draws_where_it_is_told_and_leaves_style_and_other_figures_alone(found):
    given = arguments(found)
    others = {"comparison", "traces", "errors", "climb", "warm_up"}  # they have tests of their own
    assert {f"plot_{name}" for name in {*given, *others}} >= set(plotting.__all__)
    before, first = dict(mpl.rcParams), plt.figure()
    for name, value in given.items():
        plot = getattr(plotting, f"plot_{name}")
        of_figure = name in ("identification", "windows", "calibration", "result")
        target = plt.figure() if of_figure else plt.figure().subplots()
        opened = plt.get_fignums()
        assert plot(value, target) is target
        assert plt.get_fignums() == opened
        made = plot(value)
        assert plt.get_fignums() == [*opened, opened[-1] + 1]
        for ax in (made if of_figure else made.figure).axes:
            assert any(one.get_xlabel() for one in ax.get_shared_x_axes().get_siblings(ax)), name
            assert ax.get_ylabel() or ax.get_yticklabels()[0].get_text().isalpha(), name
        plt.close(target if of_figure else target.figure)
        plt.close(made if of_figure else made.figure)
    svg(lambda ax: plotting.plot_record(found, ax), "one")
    assert plt.fignum_exists(first.number)
    assert dict(mpl.rcParams) == before


def test_the_terms_add_up_to_the_model():
    ax = plotting.plot_noise_model(NOISE)
    lines = {line.get_label(): line.get_ydata() for line in ax.get_lines()}
    terms = lines["white"] + lines["Gauss-Markov"] + lines["drift"]
    assert lines["model"] == pytest.approx(terms, rel=1e-12)


def test_the_whitening_plot_marks_what_the_filter_says():
    whitening = NOISE.whitening_filter(unity_gain_hz=1.0)
    curve, dc, zero, pole, unity = plotting.plot_whitening(whitening).get_lines()
    assert dc.get_ydata()[0] == pytest.approx(20 * math.log10(whitening.dc_gain))
    assert (zero.get_xdata()[0], pole.get_xdata()[0]) == (whitening.zero_hz, whitening.pole_hz)
    f, gain = curve.get_data()
    assert np.interp(unity.get_xdata()[0], f, gain) == pytest.approx(0, abs=0.01)  # dB, between drawn points


def test_a_filter_that_is_1_is_drawn_as_such():
    white = ba.NoiseModel(0, 0, 0.4, rate_hz=50)
    ax = plotting.plot_whitening(white.whitening_filter())
    assert "nothing to whiten" in ax.get_title(loc="left")
    assert np.all(ax.get_lines()[0].get_ydata() == 0)


def test_the_reference_is_drawn_beside_the_barometer():
    rec = simulate("squat", duration=20, seed=1)
    barometer, reference = plotting.plot_recording(rec).get_lines()
    truth = rec.reference - rec.reference[rec.t < 1].mean()
    assert reference.get_ydata() == pytest.approx(truth, abs=1e-12)
    # the reference explains the motion: what is left is the barometer's noise, 0.53 m and its drift
    assert np.std(barometer.get_ydata() - reference.get_ydata()) == pytest.approx(0.53, abs=0.1)


def test_a_long_record_is_drawn_by_few_points():
    t = np.arange(1_000_000) / 50
    rec = ba.Recording(t=t, pressure=101325 + np.random.default_rng(0).normal(size=len(t)))
    assert len(plotting.plot_recording(rec).get_lines()[0].get_xdata()) < 2000


def test_any_name_is_drawn_as_it_is(found):
    named = replace(found, recording=replace(found.recording, name=NAME.removesuffix(" & 気圧")))
    figure = plotting.plot_identification(named)
    figure.canvas.draw()
    assert figure.get_suptitle() == NAME.removesuffix(" & 気圧")
    assert len(figure.axes) == 6


def test_a_name_of_broken_characters_is_replaced_and_shortened():
    rec = ba.Recording(t=[0, 1], pressure=[101325, 101326], name="a\udcff\n" + 100 * "b")
    title = plotting.plot_recording(rec).get_title(loc="left")
    assert title.startswith("a?\ufffdb")
    assert len(title) < 100


def test_a_refused_recording_is_drawn_under_its_reason():
    t = np.arange(3000) / 50
    found = ba.identify(ba.Recording(t=t, pressure=altitude_pressure(NOISE.simulate(t, 1) + 0.4 * t)))
    assert found.model is None
    figure = plotting.plot_identification(found)
    assert len(figure.axes) == 1
    assert "This is no rest recording" in figure.get_suptitle()
    for plot in EVIDENCE:
        with pytest.raises(ValueError, match="no noise model to draw"):
            plot(found)


def test_a_recording_without_samples_has_an_empty_record():
    found = ba.identify(ba.Recording(t=[0, 1], pressure=[math.nan, math.nan]))
    assert "not one pressure sample" in plotting.plot_record(found).get_title(loc="left")


def test_an_uneven_log_keeps_its_spectrum_and_says_what_it_lacks():
    rng = np.random.default_rng(6)
    t = np.arange(6000) / 50
    uneven = known(NOISE, t[rng.random(6000) > 0.5], 1)
    labels = plotting.plot_psd(uneven).get_legend_handles_labels()[1]
    assert "data, all uneven samples" in labels
    assert "no gap-free data" in plotting.plot_allan(uneven).get_title(loc="left")


def test_a_figure_in_a_page_refers_to_nothing_and_is_escaped(found):
    from xml.etree import ElementTree

    rec = replace(found.recording, name="$x_1$ <script>")
    drawn = svg(lambda ax: plotting.plot_recording(rec, ax), "one")
    assert "http" not in drawn
    assert "<script" not in drawn
    texts = ["".join(e.itertext()) for e in ElementTree.fromstring(drawn).iter("text")]
    assert any(text.startswith("$x_1$ <script>") for text in texts)


def test_figures_of_one_page_have_ids_of_their_own(found):
    import re

    ids = [re.findall(r' id="(.*?)"', svg(found.recording.plot, name)) for name in ("one", "two")]
    assert ids[0]
    assert not set(ids[0]) & set(ids[1])
