"""One recording at rest, as two sensors with clocks of their own saw it, for every format to carry."""

from types import SimpleNamespace

import numpy as np
import pytest

import baroarma as ba
from baroarma.formats import UnreadableError, read
from baroarma.simulation import simulate


@pytest.fixture
def refusal():
    """Read what can't be read, and return what is said."""

    def read_in_vain(path):
        with pytest.raises(UnreadableError) as caught:
            read(path)
        return str(caught.value)

    return read_in_vain


@pytest.fixture(scope="session")
def streams():
    """Barometer and IMU at 50 Hz, their stamps jittery and 7 ms apart: none is on a microsecond."""
    device = simulate("rest", device="bmp390-bmi270", duration=300, seed=8)
    jitter = np.random.default_rng(8).uniform(0, 2e-3, (2, len(device)))
    baro_t, imu_t = device.t + jitter[0], device.t + 0.007 + jitter[1]
    return SimpleNamespace(
        baro_t=baro_t, pressure=device.pressure, imu_t=imu_t, accel=device.accel, gyro=device.gyro
    )


@pytest.fixture(scope="session")
def expected(streams, tmp_path_factory):
    """The same two streams read from two CSV files."""
    folder = tmp_path_factory.mktemp("expected")
    heads = (
        "time_s,pressure_pa",
        "time_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2,gyr_x_rad_s,gyr_y_rad_s,gyr_z_rad_s",
    )
    columns = (streams.baro_t, streams.pressure), (streams.imu_t, streams.accel, streams.gyro)
    paths = (folder / "rest_baro.csv", folder / "rest_imu.csv")
    for path, head, values in zip(paths, heads, columns, strict=True):
        np.savetxt(path, np.column_stack(values), "%.17g", ",", header=head, comments="")
    return read(*paths)


@pytest.fixture(scope="session")
def expected_model(expected):
    return ba.identify(expected).model


@pytest.fixture
def assert_same(expected, expected_model):
    """Compare a recording with the expected one, and what is identified from both."""

    def compare(found, *, stamp, epoch=0.0, float32=True):
        """Compare; `stamp`: the resolution of the format's time, s; `epoch`: when it begins, s."""
        assert np.array_equal(found.is_new, expected.is_new)
        # A stamp is rounded by half a unit at most.
        np.testing.assert_allclose(found.t - epoch, expected.t, rtol=0, atol=0.501 * stamp)
        # The sensor's own steps of 1/64 Pa fit into a float32; the decimal formats round at 1e-9.
        np.testing.assert_allclose(found.pressure, expected.pressure, rtol=1e-9)
        for ours, theirs in ((found.accel, expected.accel), (found.gyro, expected.gyro)):
            # A float32 rounds by 6e-8 of the 9.8 m/s2, decimals by less; what is interpolated moves with the
            # stamps of row and sample, which are off by half a unit each.
            slope = np.nanmax(np.abs(np.diff(theirs, axis=0) / np.diff(expected.t)[:, None]))
            bound = (6e-7 if float32 else 1e-12) + slope * stamp
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=bound)
        model = ba.identify(found).model
        for name, (low, high) in expected_model.ci95.items():
            # What a format rounds away must vanish beside what 300 s can tell: 1 % of the interval.
            gap = abs(getattr(model, name) - getattr(expected_model, name))
            assert gap <= 0.01 * (high - low), name
        assert not [note for note in found.notes if note.severity != "info"]

    return compare
