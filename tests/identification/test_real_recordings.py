"""Real barometers at rest, and some that are not: what the method makes of other people's logs."""

from dataclasses import replace

import pytest

import baroarma as ba
from baroarma.identification.verdict import SIGNIFICANT

MS5611 = "ms5611_static_80hz/rest_baro"
BMP180 = [f"bmp180_stm32_rest_and_stairs/rest_oss{i}_baro" for i in range(4)]
PAD = "srp_altimu10_elevator_rocket/rocket"
ELEVATOR = "srp_altimu10_elevator_rocket/elevator"
STAIRS = [
    f"bmp180_stm32_rest_and_stairs/stairs_{way}_{house}_baro"
    for way in ("up", "down")
    for house in ("b5", "kapitol")
]


@pytest.fixture(scope="module")
def read(shared_data):
    def read(*names):
        return ba.read(*(shared_data / f"{name}.csv.gz" for name in names))

    return read


def codes(found, *severities):
    return {f.code for f in found.verdict if f.severity in severities}


@pytest.mark.parametrize("name", [MS5611, *BMP180])
def test_white_noise_and_drift_explain_the_indoor_logs(read, name):
    rest = read(name)
    found = ba.identify(rest)
    assert found.fits[0].terms == ("white", "drift")
    assert min(found.model.whiteness_p.values()) > SIGNIFICANT
    assert codes(found, "warning", "error") == set()
    windows = ba.identify(rest, method="windows")
    # the white density stands far above the wander, and 8 to 13 windows find it to 1 to 10 % of its sd
    assert windows.model.white_sd == pytest.approx(found.model.white_sd, rel=0.1)


@pytest.mark.parametrize("name", BMP180)
def test_the_start_up_artefact_in_row_0_does_not_matter(read, name):
    rest = read(name)
    with_it, without = ba.identify(rest), ba.identify(rest.rows(slice(1, None)))
    assert with_it.fits[0].terms == without.fits[0].terms
    for parameter in ("white_sd", "drift_rate"):
        low, high = with_it.model.ci95[parameter]
        change = getattr(without.model, parameter) - getattr(with_it.model, parameter)
        assert abs(change) < 0.1 * (high - low)  # one sample of 2600 may move it by far less than its sd


def test_the_launch_pad_needs_a_gauss_markov_component(read):
    pad = read(f"{PAD}_baro").between(0, 960)
    found = ba.identify(pad)
    assert set(found.fits[0].terms) >= {"white", "drift", "gm"}
    assert min(found.model.whiteness_p.values()) > SIGNIFICANT
    # method.md's independent fit of the same rows: printed to two or three digits
    assert found.model.white_sd == pytest.approx(0.211, abs=0.002)
    assert found.model.correlated_sd == pytest.approx(0.143, abs=0.002)
    assert found.model.correlation_time == pytest.approx(0.26, abs=0.01)
    assert found.model.drift_rate == pytest.approx(0.097, abs=0.002)
    assert {"two-time-constants", "held-samples", "gaps"} <= codes(found, "info", "warning")
    assert codes(found, "error") == set()


def test_the_pads_windows_leave_structure_and_say_so(read):
    found = ba.identify(read(f"{PAD}_baro").between(0, 960), method="windows")
    assert "not-white" in codes(found, "warning")


def test_the_pads_re_reads_would_spoil_the_model(read):
    pad = read(f"{PAD}_baro").between(0, 960)
    held = pad.pressure.copy()
    for row in range(1, len(held)):
        if held[row] != held[row]:
            held[row] = held[row - 1]
    spoilt = ba.identify(replace(pad, pressure=held, notes=()))
    assert "not-white" in codes(spoilt, "warning")


def test_the_pad_rests_by_its_imu_until_the_launch(read):
    whole = read(*(f"{PAD}_{sensor}" for sensor in ("baro", "acc", "gyr")))
    found = ba.identify(whole)
    assert not found.ok
    assert "moving" in codes(found, "error")
    assert ba.identify(whole.between(0, 960)).ok


@pytest.mark.parametrize("sensors", [("baro",), ("baro", "acc", "gyr")])
def test_the_elevator_ride_is_refused(read, sensors):
    found = ba.identify(read(*(f"{ELEVATOR}_{sensor}" for sensor in sensors)))
    assert not found.ok
    assert codes(found, "error") == {"moving"}


@pytest.mark.parametrize("name", STAIRS)
def test_stairs_are_moving_by_pressure_alone(read, name):
    found = ba.identify(read(name))
    assert not found.ok
    assert codes(found, "error") == {"moving"}


def test_the_pixracers_gaps_and_warm_up_are_named(read):
    found = ba.identify(read("pixracer_ms5611_pendulum/pendulum_baro"))
    assert {"gaps", "warm-up", "not-white"} <= codes(found, "info", "warning")


@pytest.mark.parametrize("name", ["rest_f", "rest_400hz_g"])
def test_half_a_minute_of_a_held_sensor_is_too_short(read, name):
    found = ba.identify(read(f"stampfly_tof_handheld/{name}"))
    assert {"held-samples", "too-short"} <= codes(found, "warning")


@pytest.mark.parametrize("name", ["lift30cm_a", "lift30cm_b", "setdown_c", "air_d", "tilt_e"])
def test_motion_in_the_hand_is_seen_by_the_imu(read, name):
    found = ba.identify(read(f"stampfly_tof_handheld/{name}"))
    assert codes(found, "error") == {"moving"}
