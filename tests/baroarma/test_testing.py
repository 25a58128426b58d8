"""The contracts can fail: an estimator that breaks a promise is caught by the method of that name."""

import numpy as np
import pytest

from baroarma.estimators.height.complementary import Complementary
from baroarma.testing import HeightEstimatorContract


class DifferentRun(Complementary):
    def run(self, *args, **kwargs):
        result = super().run(*args, **kwargs)
        return result._replace(height=result.height + 1e-6)


class Forgetful(Complementary):
    def reset(self, alignment=None):
        if not hasattr(self, "_x"):
            super().reset(alignment)


class Vandal(Complementary):
    def run(self, t, altitude, *args, **kwargs):
        altitude[np.isnan(altitude)] = 0.0
        return super().run(t, altitude, *args, **kwargs)


class Poisoned(Complementary):
    def run(self, *args, **kwargs):
        result = super().run(*args, **kwargs)
        result.height[-1:] = np.nan
        return result


class ClockReader(Complementary):
    def run(self, t, *args, **kwargs):
        result = super().run(t, *args, **kwargs)
        return result._replace(height=result.height + 1e-3 * t)


@pytest.mark.parametrize(
    ("broken", "promise"),
    [
        (DifferentRun, "test_run_is_the_repetition_of_step"),
        (Forgetful, "test_reset_makes_it_new"),
        (Vandal, "test_inputs_stay_untouched"),
        (Poisoned, "test_estimates_are_finite_and_sds_positive"),
        (ClockReader, "test_the_origin_of_time_has_no_effect"),
    ],
)
def test_a_broken_promise_is_caught(broken, promise):
    contract = HeightEstimatorContract()
    contract.make = broken
    with pytest.raises(AssertionError):
        getattr(contract, promise)()
    contract.make = Complementary
    getattr(contract, promise)()


def test_a_contract_without_an_estimator_says_what_to_do():
    with pytest.raises(NotImplementedError, match=r"override make\(\)"):
        HeightEstimatorContract().test_it_is_deterministic()
