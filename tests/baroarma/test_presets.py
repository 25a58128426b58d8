"""Presets hold what the papers print, and say what we chose."""

import inspect
import math

import pytest

from baroarma.estimators import attitude_estimator, height_estimator
from baroarma.presets import PRESETS, find_preset
from baroarma.tracker import DEFAULT_NOISE

G = 9.80665
# SG14, Table 1, as printed: degree/s, 1e-4 m/s³, 1/s, mg, mg, cm, cm, mg
SG14_TABLE_1 = {
    "gyro_noise_sd": math.radians(1),
    "bias_walk_sd": 5e-4,
    "bias_decay": 0.0,
    "accel_noise_sd": 10e-3 * G,
    "acceleration_sd": 15e-3 * G,
    "gate": 150e-3 * G,
}


@pytest.mark.parametrize(("name", "altitude_sd"), [("sg14-a", 0.30), ("sg14-b", 0.15)])
def test_sg14s_constants_are_those_of_table_1(name, altitude_sd):
    constants = PRESETS[name].constants()
    printed = {key: c.value for key, c in constants.items() if c.origin == "printed"}
    assert printed == pytest.approx({**SG14_TABLE_1, "altitude_sd": altitude_sd}, rel=1e-12)
    # P0 is not in the paper: diag(1e-4 x4, 1e-6 x3) is ours
    chosen = {key: c.value for key, c in constants.items() if c.origin == "chosen"}
    assert chosen == {"initial_quaternion_sd": 1e-2, "initial_bias_sd": 1e-3}


def test_tanigawas_constants_are_those_that_sg14_quotes():
    constants = PRESETS["tanigawa08"].constants()
    assert constants["acceleration_sd"].value == pytest.approx(0.8e-3 * G)
    assert constants["altitude_sd"].value == 1.0
    assert constants["altitude_sd"].origin == "printed"


def test_lees_zero_velocity_rule_is_equation_14():
    for name in ("lee16", "lee16-kf"):
        rule = PRESETS[name].constants()
        assert (rule["zupt_steps"].value, rule["zupt_threshold"].value) == (12, 0.1)
        assert rule["zupt_steps"].origin == rule["zupt_threshold"].origin == "printed"
    assert "zupt_steps" not in PRESETS["zihajehzadeh15"].constants()


def test_the_table_of_chains_is_the_documented_one():
    chains = {name: (p.attitude, p.conditioning, p.height) for name, p in PRESETS.items()}
    assert chains.pop("baroarma")[1:] == ("none", "coloured-kalman")
    assert chains == {
        "sg14-a": ("quaternion-ekf", "average", "complementary"),
        "sg14-b": ("quaternion-ekf", "average+whitening", "complementary"),
        "lee16": ("tilt-kalman", "none", "complementary"),
        "lee16-kf": ("tilt-kalman", "none", "kalman"),
        "zihajehzadeh15": ("tilt-kalman", "none", "kalman"),
        "tanigawa08": ("tilt-kalman", "none", "kalman"),
        "sonoh15": (None, "none", "inertial-ekf"),
        "zhang12": (None, "none", "inertial-ekf"),
        "bourke08": (None, "none", None),
    }


@pytest.mark.parametrize("preset", PRESETS.values(), ids=PRESETS)
def test_every_constant_is_a_setting_of_its_estimator_and_has_a_reason(preset):
    for constant in preset.constants().values():
        assert constant.origin in ("printed", "chosen")
        assert len(constant.why) > 5
    if preset.attitude:
        attitude_estimator(preset.attitude, **{k: c.value for k, c in preset.attitude_settings.items()})
    if preset.height:
        settings = {k: c.value for k, c in preset.height_settings.items()}
        height_estimator(preset.height, noise=DEFAULT_NOISE, dt=0.02, **settings)


def test_tightly_coupled_presets_estimate_what_their_papers_do():
    defaults = inspect.signature(type(height_estimator("inertial-ekf", dt=0.02)).__init__).parameters
    estimated = ("accel_bias_sd", "accel_scale_sd", "gyro_bias_sd", "baseline_sd")
    assert all(defaults[name].default == 0 for name in estimated)  # what a preset leaves out is not estimated
    assert set(PRESETS["sonoh15"].height_settings) == {"accel_bias_sd", "accel_scale_sd"}
    assert set(PRESETS["zhang12"].height_settings) == {"accel_bias_sd", "gyro_bias_sd", "baseline_sd"}


def test_an_unknown_preset_is_answered_with_those_there_are():
    with pytest.raises(ValueError, match=r"no preset 'SG14'; there are baroarma, sg14-a, .*bourke08"):
        find_preset("SG14")
