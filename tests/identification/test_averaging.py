"""Averages of growing length, as in SG13's Fig. 5."""

import numpy as np
import pytest

from baroarma.identification.averaging import averaging_study
from baroarma.noise_model import NoiseModel

T = np.arange(30000) / 50


def bmp085(seed):
    """Ten minutes of the simulated sensor: SG13's noise at 50 Hz in steps of 1 Pa (8.43 cm there)."""
    noise = NoiseModel(0.27, 0.75, 0.46, 0.01, rate_hz=50)
    return 0.0843 * np.round((100 + noise.simulate(T, seed)) / 0.0843)


def test_averages_longer_than_the_decimation_do_not_fit_as_in_figure_5():
    studies = [averaging_study(T, bmp085(seed), (1, 4, 8, 16)) for seed in range(4)]
    rejected = {
        m: np.mean([s.rows[k].bartlett_failures for s in studies]) for k, m in enumerate((1, 4, 8, 16))
    }
    outside = {m: np.mean([s.rows[k].outside for s in studies]) for k, m in enumerate((1, 4, 8, 16))}
    ljung = {m: np.mean([s.rows[k].ljung_box_failures for s in studies]) for k, m in enumerate((1, 4, 8, 16))}
    # Of 80 windows: nearly none where the model holds, nearly all where it can't; between them Bartlett's
    # test is blind, and Ljung-Box and the region speak (trial values 2, 47, 79 %; 3 sds of 80 draws: 17 %).
    assert max(rejected[1], rejected[4], outside[4]) <= 0.05
    assert rejected[8] <= 0.10
    assert ljung[8] == pytest.approx(0.47, abs=0.17)
    assert outside[8] == pytest.approx(0.79, abs=0.17)
    assert rejected[16] == pytest.approx(0.86, abs=0.17)
    assert outside[16] == 1.0
    for study in studies:
        one, four = study.rows[:2]
        assert four.theory_white_sd == pytest.approx(one.white_sd.mean / 2)
        assert four.white_sd.mean == pytest.approx(four.theory_white_sd, rel=0.1)  # 4 % low, +- 2 %
        assert four.total_sd.mean < one.total_sd.mean
    assert "Bartlett" in studies[0].summary()
