"""The encoder tells the rod's angle on a clock of its own."""

import numpy as np
import pytest

from baroarma.simulation import simulate, simulate_with_encoder


def start_of(recording, encoder, frequency):
    """When the encoder started, from its steady turning and the truth's: angle = 2 pi f (t + start - 6)."""
    late = encoder.t > 10
    turns = encoder.angle[late] / (2 * np.pi) - frequency * encoder.t[late]
    return turns.mean() / frequency + 6


@pytest.mark.parametrize("frequency", [0.25, 1.25])
def test_the_encoders_angle_gives_the_true_height(frequency):
    """SG14 Eq. 36, once the clocks are aligned."""
    recording, encoder = simulate_with_encoder(duration=30, frequency_hz=frequency, counts=0, seed=3)
    start = start_of(recording, encoder, frequency)
    assert 0 < start < 2
    inside = (recording.t > start) & (recording.t < start + encoder.t[-1])
    angle = np.interp(recording.t[inside], encoder.t + start, encoder.angle)
    # linear interpolation over 4 ms: 0.3 m times the angular acceleration, 6 rad/s², times (4 ms)²/8
    assert 0.3 * np.sin(angle) == pytest.approx(recording.reference[inside], abs=1e-5)


def test_the_start_is_another_one_with_another_seed():
    starts = [
        start_of(*simulate_with_encoder(duration=20, counts=0, seed=seed, imu=None), 0.5) for seed in range(4)
    ]
    assert np.ptp(starts) > 0.1


def test_an_incremental_encoder_counts_steps():
    _, fine = simulate_with_encoder(duration=20, counts=0, seed=1, imu=None)
    _, coarse = simulate_with_encoder(duration=20, counts=500, seed=1, imu=None)
    step = 2 * np.pi / 500
    assert coarse.angle / step == pytest.approx(np.round(coarse.angle / step), abs=1e-9)
    assert np.abs(coarse.angle - fine.angle).max() <= step / 2 + 1e-12
    assert np.diff(fine.t) == pytest.approx(1 / 250)  # printed


def test_the_recording_is_the_one_without_the_encoder():
    recording, _ = simulate_with_encoder(duration=20, device="wimu", frequency_hz=1.0, seed=7)
    alone = simulate("circle", duration=20, device="wimu", frequency_hz=1.0, seed=7)
    assert np.array_equal(recording.accel, alone.accel)
    assert np.array_equal(recording.pressure, alone.pressure)
