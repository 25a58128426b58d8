"""Whatever sensors can say, the answers are numbers, with honest covariances, and `step` is `run`."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from baroarma import Tracker
from baroarma.simulation import BMP085, simulate

spec = importlib.util.spec_from_file_location("strategies", Path(__file__).with_name("strategies.py"))
drawn = importlib.util.module_from_spec(spec)
spec.loader.exec_module(drawn)

COLUMNS = ("height", "velocity", "height_sd", "velocity_sd", "acceleration")


def tracked(preset, recording):
    tracker = Tracker.preset(preset, noise=BMP085.noise)
    return tracker, tracker.run(recording)


def stepped(preset, recording):
    tracker = Tracker.preset(preset, noise=BMP085.noise)
    samples = zip(np.diff(recording.t, prepend=recording.t[0]), recording.pressure, recording.accel,
                  recording.gyro, strict=True)  # fmt: skip
    states = [tracker.step(dt=float(d), pressure=float(p), accel=a, gyro=g) for d, p, a, g in samples]
    return np.array([state for state in states if state is not None]).T


def is_covariance(P):
    """Symmetric and positive semidefinite to rounding: of its correlations, or of its largest variance.

    The second is for a vertical, a unit vector whose variance along itself is 0 and whose correlations
    therefore are rounding over rounding.
    """
    variances = np.diag(P)
    if not (np.isfinite(P).all() and (variances >= 0).all()):
        return False
    sds = np.sqrt(np.where(variances > 0, variances, 1.0))
    # sixteen digits, of which an update by what is 1e6 times as sure takes twelve from the least eigenvalue
    scaled = [(P / np.outer(sds, sds), 1e-6), (P / variances.max(initial=1e-300), 1e-12)]
    return any(np.abs(S - S.T).max() < 1e-9 and np.linalg.eigvalsh(S).min() > -tol for S, tol in scaled)


def covariances(tracker):
    """Covariances of the height and the attitude estimator, where they have one."""
    for estimator in (tracker.estimator, tracker._chain.attitude):
        for name in ("P", "_P"):
            if (P := getattr(estimator, name, None)) is not None:
                yield np.asarray(P)


@pytest.mark.parametrize("preset", drawn.ONLINE)
def test_the_state_is_finite_and_its_covariance_is_one(preset):
    @drawn.examples(15)
    @given(drawn.streams())
    def holds(recording):
        tracker, track = tracked(preset, recording)
        assert all(np.isfinite(getattr(track, name)).all() for name in COLUMNS)
        assert (track.height_sd >= 0).all()
        assert (track.velocity_sd >= 0).all()
        for P in covariances(tracker):
            assert is_covariance(P)

    holds()


@pytest.mark.parametrize("preset", drawn.COMPILED)
def test_step_is_run(preset):
    @drawn.examples(15)
    @given(drawn.streams())
    def holds(recording):
        _, track = tracked(preset, recording)
        steps = stepped(preset, recording)
        for row, name in zip(steps, COLUMNS, strict=True):
            column = getattr(track, name)[-steps.shape[1] :]
            # the same sums in another order: rounding of the largest number that went through
            np.testing.assert_allclose(row, column, rtol=1e-8, atol=1e-8 * (1 + np.abs(column).max()))

    holds()


@pytest.mark.parametrize("preset", ["baroarma", "sg14-a", "lee16"])
@pytest.mark.parametrize("broken", [np.inf, -np.inf, 1e100, -1e100, 1e9])
def test_one_broken_sample_is_forgotten(preset, broken):
    """A single number that no sensor of motion says leaves no trace of its own size."""
    usual = simulate("squat", duration=20, seed=3)
    track = Tracker.preset(preset, noise=BMP085.noise).run(usual)
    for name in ("accel", "gyro"):
        values = np.array(getattr(usual, name))
        values[500, 1] = broken
        other = Tracker.preset(preset, noise=BMP085.noise).run(replace(usual, **{name: values}))
        # the row is one without sample: 20 ms of a squat's acceleration, 1.5 m/s² at most, are missed
        assert np.abs(other.velocity - track.velocity).max() < 0.03
