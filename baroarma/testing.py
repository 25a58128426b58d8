"""Contracts that every estimator keeps, as test classes to inherit: ours do, and so should a plug-in's.

    from baroarma.testing import HeightEstimatorContract

    class TestMyFilter(HeightEstimatorContract):
        def make(self):
            return MyFilter(noise=None, dt=0.02)

pytest then runs every `test_` method of the class.  Nothing here needs pytest itself.
"""

from __future__ import annotations

import pickle
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from baroarma.atmosphere import STANDARD_GRAVITY

if TYPE_CHECKING:
    from baroarma.estimators.base import AttitudeEstimator, HeightEstimator

Signal = NDArray[np.float64]

EQUAL: Final = 1e-9
"""`run` against `step`: the same numbers but for the order of summation."""
CLOCK: Final = 1e-6
"""Runs whose time stamps are rounded differently: 1e-13 s of 1000 s, with room to spare."""


class HeightEstimatorContract:
    """What every height estimator keeps; override `make`.

    Examples
    --------
    pytest calls the tests; by hand, one that keeps silent, and one that doesn't:

    >>> from baroarma.estimators import height_estimator
    >>> class TestMine(HeightEstimatorContract):
    ...     def make(self):
    ...         return height_estimator("complementary")
    >>> TestMine().test_run_is_the_repetition_of_step()
    >>> class TestLeaky(HeightEstimatorContract):
    ...     def make(self):
    ...         estimator = height_estimator("complementary")
    ...         estimator.reset = lambda alignment=None: None  # forgets to forget
    ...         return estimator
    >>> TestLeaky().test_reset_makes_it_new()
    Traceback (most recent call last):
        ...
    AssertionError...
    """

    def make(self) -> HeightEstimator:
        """Return a new estimator, always with the same settings.

        Raises
        ------
        NotImplementedError
            Unless it is overridden.
        """
        raise NotImplementedError("override make() and return a new height estimator")

    def test_run_is_the_repetition_of_step(self) -> None:
        """`run` gives what `step` gives, missing samples, gaps and uneven intervals included."""
        for seed in (0, 1):
            samples = height_samples(seed)
            _close(self._run(self.make(), samples), _steps(self.make(), samples), EQUAL)

    def test_step_goes_on_where_run_ended(self) -> None:
        """Half of the samples by `run` and half by `step` are the same as all by `step`."""
        samples, estimator = height_samples(2), self.make()
        n = len(samples["t"]) // 2
        first = self._run(estimator, {name: values[:n] for name, values in samples.items()})
        second = _steps(estimator, samples, start=n)
        together = [np.concatenate(pair) for pair in zip(first, second, strict=True)]
        _close(together, _steps(self.make(), samples), EQUAL)

    def test_reset_makes_it_new(self) -> None:
        """After `reset` an estimator has forgotten what it saw."""
        samples, estimator = height_samples(3), self.make()
        first = self._run(estimator, samples)
        estimator.reset()
        _close(self._run(estimator, samples), first, 0.0)
        estimator.reset()
        _close(_steps(estimator, samples), first, EQUAL)

    def test_it_is_deterministic(self) -> None:
        """The same samples give the same numbers."""
        samples = height_samples(4)
        _close(self._run(self.make(), samples), self._run(self.make(), samples), 0.0)

    def test_it_can_be_saved_and_resumed(self) -> None:
        """A pickled estimator goes on exactly where it was, and leaves the original alone."""
        samples, estimator = height_samples(10), self.make()
        n = len(samples["t"]) // 2
        self._run(estimator, {name: values[:n] for name, values in samples.items()})
        saved = pickle.dumps(estimator)
        expected = _steps(estimator, samples, start=n)
        _close(_steps(pickle.loads(saved), samples, start=n), expected, 0.0)

    def test_estimates_are_finite_and_sds_positive(self) -> None:
        """Whatever is missing, there is an estimate with an honest sd."""
        samples = height_samples(5)
        nothing = {**samples, **{name: np.full_like(samples[name], np.nan) for name in _HEIGHT_SENSORS}}
        no_barometer = {**samples, "altitude": np.full_like(samples["altitude"], np.nan)}
        late = {**samples, "altitude": np.where(samples["t"] < 2, np.nan, samples["altitude"])}
        for case in (samples, nothing, no_barometer, late):
            result = self._run(self.make(), case)
            assert all(np.isfinite(values).all() for values in result)
            assert (result[2] > 0).all()
            assert (result[3] > 0).all()

    def test_it_starts_at_height_zero_and_gets_lost_without_a_barometer(self) -> None:
        """Integration alone knows the height less and less."""
        samples = height_samples(6)
        samples["altitude"][:] = np.nan
        height, _, height_sd, _ = self._run(self.make(), samples)
        assert height[0] == 0
        assert height_sd[-1] > height_sd[0]

    def test_inputs_stay_untouched(self) -> None:
        """`run` and `step` read their samples and leave them alone."""
        samples = height_samples(7)
        before = {name: values.copy() for name, values in samples.items()}
        self._run(self.make(), samples)
        _steps(self.make(), samples)
        assert all(np.array_equal(before[name], samples[name], equal_nan=True) for name in before)

    def test_the_origin_of_time_has_no_effect(self) -> None:
        """A clock that starts at 1000 s changes nothing."""
        samples = height_samples(8)
        shifted = {**samples, "t": samples["t"] + 1000}
        _close(self._run(self.make(), shifted), self._run(self.make(), samples), CLOCK)

    def test_the_first_interval_has_no_effect(self) -> None:
        """There is nothing before the first sample to step from."""
        sample = {name: values[0] for name, values in height_samples(9).items() if name != "t"}
        sample["altitude"] = 0.1
        assert self.make().step(dt=0.02, **sample) == self.make().step(dt=100.0, **sample)

    def test_no_samples_give_no_rows(self) -> None:
        """An empty recording has an empty track."""
        samples = {name: values[:0] for name, values in height_samples(0).items()}
        assert all(len(values) == 0 for values in self._run(self.make(), samples))

    @staticmethod
    def _run(estimator: HeightEstimator, samples: dict[str, Any]) -> list[Signal]:
        return list(estimator.run(**samples))


class AttitudeEstimatorContract:
    """What every attitude estimator keeps; override `make`.

    Examples
    --------
    >>> from baroarma.estimators import attitude_estimator
    >>> class TestMine(AttitudeEstimatorContract):
    ...     def make(self):
    ...         return attitude_estimator("accelerometer-norm")
    >>> TestMine().test_up_is_a_unit_vector()
    >>> class TestDoubled(AttitudeEstimatorContract):
    ...     def make(self):
    ...         estimator = attitude_estimator("accelerometer-norm")
    ...         run = estimator.run
    ...         estimator.run = lambda *samples, **more: run(*samples, **more)._replace(up=2 * np.eye(3))
    ...         return estimator
    >>> TestDoubled().test_up_is_a_unit_vector()
    Traceback (most recent call last):
        ...
    AssertionError...
    """

    def make(self) -> AttitudeEstimator:
        """Return a new estimator, always with the same settings.

        Raises
        ------
        NotImplementedError
            Unless it is overridden.
        """
        raise NotImplementedError("override make() and return a new attitude estimator")

    def test_run_is_the_repetition_of_step(self) -> None:
        """`run` gives what `step` gives, missing samples and uneven intervals included."""
        for seed in (0, 1):
            samples = attitude_samples(seed)
            _close(self._run(self.make(), samples), _steps(self.make(), samples), EQUAL)

    def test_step_goes_on_where_run_ended(self) -> None:
        """Half of the samples by `run` and half by `step` are the same as all by `step`."""
        samples, estimator = attitude_samples(2), self.make()
        n = len(samples["t"]) // 2
        first = self._run(estimator, {name: values[:n] for name, values in samples.items()})
        second = _steps(estimator, samples, start=n)
        together = [np.concatenate(pair) for pair in zip(first, second, strict=True)]
        _close(together, _steps(self.make(), samples), EQUAL)

    def test_reset_makes_it_new(self) -> None:
        """After `reset` an estimator has forgotten what it saw."""
        samples, estimator = attitude_samples(3), self.make()
        first = self._run(estimator, samples)
        estimator.reset()
        _close(self._run(estimator, samples), first, 0.0)

    def test_it_is_deterministic(self) -> None:
        """The same samples give the same numbers."""
        samples = attitude_samples(4)
        _close(self._run(self.make(), samples), self._run(self.make(), samples), 0.0)

    def test_up_is_a_unit_vector(self) -> None:
        """The vertical has length 1 in every row, whatever is missing."""
        up = self._run(self.make(), attitude_samples(5))[0]
        np.testing.assert_allclose(np.linalg.norm(up, axis=1), 1.0, atol=EQUAL)

    def test_there_is_an_acceleration_exactly_where_there_is_a_sample(self) -> None:
        """A row without accelerometer sample has no vertical acceleration, any other has one with its sd."""
        samples = attitude_samples(6)
        _, acceleration, sd = self._run(self.make(), samples)
        new = np.isfinite(samples["accel"]).all(axis=1)
        assert np.array_equal(np.isfinite(acceleration), new)
        assert np.isfinite(sd[new]).all()
        assert (sd[new] > 0).all()

    def test_inputs_stay_untouched(self) -> None:
        """`run` and `step` read their samples and leave them alone."""
        samples = attitude_samples(7)
        before = {name: values.copy() for name, values in samples.items()}
        self._run(self.make(), samples)
        _steps(self.make(), samples)
        assert all(np.array_equal(before[name], samples[name], equal_nan=True) for name in before)

    def test_the_origin_of_time_has_no_effect(self) -> None:
        """A clock that starts at 1000 s changes nothing."""
        samples = attitude_samples(8)
        shifted = {**samples, "t": samples["t"] + 1000}
        _close(self._run(self.make(), shifted), self._run(self.make(), samples), CLOCK)

    def test_at_rest_there_is_no_vertical_acceleration(self) -> None:
        """A level, resting sensor reads up = z and no acceleration."""
        n = 100
        samples = {
            "t": np.arange(n) / 50,
            "accel": np.tile([0.0, 0.0, STANDARD_GRAVITY], (n, 1)),
            "gyro": np.zeros((n, 3)),
            "attitude": np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)),
        }
        up, acceleration, _ = self._run(self.make(), samples)
        np.testing.assert_allclose(up, np.tile([0.0, 0.0, 1.0], (n, 1)), atol=EQUAL)
        np.testing.assert_allclose(acceleration, 0.0, atol=1e-6)  # single-precision back-ends included

    @staticmethod
    def _run(estimator: AttitudeEstimator, samples: dict[str, Any]) -> list[Signal]:
        return list(estimator.run(**samples))


_HEIGHT_SENSORS: Final = ("altitude", "acceleration", "acceleration_sd", "accel", "gyro")


def height_samples(seed: int, n: int = 200) -> dict[str, Signal]:
    """Simulate n rows of awkward input of a height estimator, by name of `run`'s parameters.

    Uneven intervals, a gap of 3 s in time, a third of the altitudes and a tenth of the IMU samples missing,
    20 rows without altitude, standard deviations given for half of the rows, a device nearly level.
    """
    rng = np.random.default_rng(seed)
    dt = rng.uniform(0.01, 0.03, n)
    dt[n // 3] = 3.0
    acceleration = rng.normal(scale=0.5, size=n)
    altitude = rng.normal(scale=0.5, size=n)
    altitude[rng.random(n) < 0.33] = np.nan
    altitude[n // 2 : n // 2 + 20] = np.nan
    accel = np.array([0.0, 0.0, STANDARD_GRAVITY]) + rng.normal(scale=0.3, size=(n, 3))
    gyro = rng.normal(scale=0.2, size=(n, 3))
    missing = rng.random(n) < 0.1
    acceleration[missing], accel[missing], gyro[missing] = np.nan, np.nan, np.nan
    acceleration_sd = np.where(rng.random(n) < 0.5, rng.uniform(0.02, 0.2, n), np.nan)
    return {
        "t": np.cumsum(dt),
        "altitude": altitude,
        "acceleration": acceleration,
        "acceleration_sd": acceleration_sd,
        "accel": accel,
        "gyro": gyro,
    }


def attitude_samples(seed: int, n: int = 200) -> dict[str, Signal]:
    """Simulate n rows of awkward input of an attitude estimator, by name of `run`'s parameters.

    Uneven intervals, a tenth of the accelerometer and of the gyro samples missing, and a reference attitude
    (unit quaternions, heading and tilt arbitrary) in every row.
    """
    rng = np.random.default_rng(seed)
    accel = np.array([0.0, 0.0, STANDARD_GRAVITY]) + rng.normal(scale=0.5, size=(n, 3))
    gyro = rng.normal(scale=0.3, size=(n, 3))
    accel[rng.random(n) < 0.1] = np.nan
    gyro[rng.random(n) < 0.1] = np.nan
    attitude = np.array([0.0, 0.0, 0.0, 1.0]) + rng.normal(scale=0.2, size=(n, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    t = np.cumsum(rng.uniform(0.01, 0.03, n))
    return {"t": t, "accel": accel, "gyro": gyro, "attitude": attitude}


def _steps(estimator: Any, samples: dict[str, Signal], start: int = 0) -> list[Signal]:
    """Call `step` for every row from `start` on; the columns of what it returned."""
    dt = np.diff(samples["t"], prepend=samples["t"][:1])
    rows = range(start, len(dt))
    states = [
        estimator.step(dt=float(dt[k]), **{name: v[k] for name, v in samples.items() if name != "t"})
        for k in rows
    ]
    return [np.array(column) for column in zip(*states, strict=True)]


def _close(actual: Any, expected: Any, tolerance: float) -> None:
    for one, other in zip(actual, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=tolerance, atol=tolerance)
