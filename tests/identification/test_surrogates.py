import numpy as np
import pytest

from baroarma.arma import ArmaModel
from baroarma.identification.surrogates import whitened_surrogate, zero_pole_cancellation
from baroarma.noise_model import NoiseModel

T = np.arange(30000) / 50
NOISE = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
BY_DENSITY = NOISE.whitening_filter(unity_gain_hz=25)
BY_PAPER = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1).whitening_filter(
    rate_hz=50, unity_gain_hz=25
)


def day(number, whitening):
    """SG13's day: six recordings of ten minutes in steps of 1 Pa (8.43 cm), whitened."""
    seeds = range(1000 + 6 * number, 1006 + 6 * number)
    records = (0.0843 * np.round((100 + NOISE.simulate(T, seed)) / 0.0843) for seed in seeds)
    return [whitened_surrogate(T, record, whitening) for record in records]


@pytest.fixture(scope="module")
def days():
    return {
        "density": [day(k, BY_DENSITY) for k in range(10)],
        "paper": [day(k, BY_PAPER) for k in range(10)],
    }


def test_the_filter_from_the_raw_density_cancels_pole_and_zero(days):
    passed = sum(zero_pole_cancellation(d).p > 0.1 for d in days["density"])
    assert passed >= 7  # perfect whiteness passes p > 0.1 in 90 %; fewer than 7 of 10 then have 1.3 %


def test_the_filter_designed_at_ten_hertz_hardly_ever_does(days):
    passed = sum(zero_pole_cancellation(d).p > 0.1 for d in days["paper"])
    assert passed <= 2  # 10 to 20 % of days in earlier trials, 0 of 40 in ours
    assert all(
        zero_pole_cancellation(d).statistic < 0 for d in days["paper"]
    )  # a < b: too little was removed


def test_a_single_recording_forgives_the_design_at_ten_hertz_more_often_than_a_day(days):
    single = [zero_pole_cancellation([s]).p > 0.1 for d in days["paper"] for s in d]
    assert 0.05 <= np.mean(single) <= 0.40  # 20 % of recordings; three sds of 60 draws are 15 %


def test_whitened_surrogates_have_the_sds_of_table_3(days):
    # SG13, Table 3, six tests: sigma_u 0.22 0.23 0.22 0.22 0.23 0.21 (SD 0.02-0.03); sigma_s 0.24 0.24 0.23
    # 0.25 0.25 0.24 (SD 0.01).  The paper's own filter.
    white = np.mean([s.white_sd.mean for d in days["paper"] for s in d])
    total = np.mean([s.total_sd.mean for d in days["paper"] for s in d])
    assert abs(white - 0.2217) < 0.023
    assert abs(total - 0.2417) < 0.01


def test_without_whitening_pole_and_zero_do_not_cancel():
    nothing = NoiseModel(0.0, 0.0, 0.46, rate_hz=50).whitening_filter()
    outcome = zero_pole_cancellation([whitened_surrogate(T, NOISE.simulate(T, 1), nothing)])
    assert outcome.p < 1e-6
    assert "correlation is left" in outcome.message


def test_a_filter_for_another_rate_is_refused():
    with pytest.raises(ValueError, match="for 25 Hz, but the recording has 50 Hz"):
        whitened_surrogate(T, np.sin(T), NOISE.whitening_filter(rate_hz=25))


def test_one_window_is_too_few_for_a_t_test():
    surrogate = whitened_surrogate(T[:1600], NOISE.simulate(T[:1600], 2), BY_DENSITY)
    with pytest.raises(ValueError, match="too few"):
        zero_pole_cancellation([surrogate])
