"""ROS bags of every storage, written by rosbags' own writers."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from baroarma.formats import UnreadableError, read

rosbag1 = pytest.importorskip("rosbags.rosbag1", reason="the extra `ros` is not installed")
rosbag2 = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")

EPOCH = 1_770_000_000
STAMP = 1e-9 + 2.0**-22
"""Resolution in s: a stamp is rounded to ns, then to one of the floats at 1.7e9 s."""
PRESSURE, IMU = "sensor_msgs/msg/FluidPressure", "sensor_msgs/msg/Imu"
ROS1, ROS2 = typesys.Stores.ROS1_NOETIC, typesys.Stores.ROS2_JAZZY
UNKNOWN, NONE = np.zeros(9), np.array([-1.0, *np.zeros(8)])


def header(types, ns):
    time = types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    extra = {"seq": 0} if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__ else {}
    return types["std_msgs/msg/Header"](stamp=time, frame_id="imu", **extra)


def pressure(types, ns, value):
    return types[PRESSURE](header=header(types, ns), fluid_pressure=value, variance=0.0)


def imu(types, ns, accel, gyro, accel_covariance=UNKNOWN):
    vector = types["geometry_msgs/msg/Vector3"]
    return types[IMU](
        header=header(types, ns),
        orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=NONE,
        angular_velocity=vector(*map(float, gyro)),
        angular_velocity_covariance=UNKNOWN,
        linear_acceleration=vector(*map(float, accel)),
        linear_acceleration_covariance=accel_covariance,
    )


def stamps(t):
    return [EPOCH * 10**9 + round(x * 1e9) for x in t]


def write(path, topics, storage="mcap"):
    """Write {topic: (type, [(ns, message maker)])}, and return the path to read."""
    store = typesys.get_typestore(ROS1 if storage == "bag" else ROS2)
    if storage == "bag":
        path = path.with_name(path.name + ".bag")
        writer = rosbag1.Writer(path)
    else:
        plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    serialize = store.serialize_ros1 if storage == "bag" else store.serialize_cdr
    with writer:
        for topic, (kind, messages) in topics.items():
            connection = writer.add_connection(topic, kind, typestore=store)
            for received, make in messages:
                writer.write(connection, received, serialize(make(store.types), kind))
    return path


def barometer(t, values):
    values = np.broadcast_to(values, np.shape(t))
    return PRESSURE, [
        (ns + 10**6, lambda types, ns=ns, v=v: pressure(types, ns, float(v)))
        for ns, v in zip(stamps(t), values, strict=True)
    ]


def inertial(t, accel, gyro, **options):
    return IMU, [
        (ns + 10**6, lambda types, ns=ns, a=a, g=g: imu(types, ns, a, g, **options))
        for ns, a, g in zip(stamps(t), accel, gyro, strict=True)
    ]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3", "bag"])
def test_a_bag_gives_the_noise_model_of_the_recording(streams, assert_same, tmp_path, storage):
    topics = {
        "/baro": barometer(streams.baro_t, streams.pressure),
        "/imu": inertial(streams.imu_t, streams.accel, streams.gyro),
    }
    found = read(write(tmp_path / "2026.02.02-rest", topics, storage))
    assert_same(found, stamp=STAMP, epoch=EPOCH, float32=False)
    assert found.name == "2026.02.02-rest"


@pytest.fixture
def still():
    t = 1 + np.arange(40) / 10
    return SimpleNamespace(t=t, accel=np.tile((0, 0, 9.8), (40, 1)), gyro=np.tile((0, 0, 0.1), (40, 1)))


@pytest.mark.parametrize(("storage", "suffix"), [("mcap", ".mcap"), ("sqlite3", ".db3")])
def test_the_file_inside_a_bag_is_the_bag(still, tmp_path, storage, suffix):
    folder = write(tmp_path / "bag", {"/baro": barometer(still.t, 1e5)}, storage)
    (inner,) = folder.glob(f"*{suffix}")
    np.testing.assert_array_equal(read(inner).t, read(folder).t)


def test_an_airspeed_sensor_is_not_taken_for_the_barometer(still, tmp_path):
    topics = {
        "/diff_pressure": barometer(still.t, 30.0),
        "/static_pressure": barometer(still.t, 1e5),
        "/imu/data": inertial(still.t, still.accel, still.gyro),
        "/imu/data_raw": inertial(still.t, 2 * still.accel, still.gyro),
    }
    found = read(write(tmp_path / "bag", topics))
    assert set(found.pressure) == {1e5}
    assert found.accel[20] == pytest.approx([0, 0, 9.8])
    assert [note.message for note in found.notes] == [
        "bag has 2 pressure topics: /static_pressure was taken and /diff_pressure left out.",
        "bag has 2 IMU topics: /imu/data was taken and /imu/data_raw left out.",
    ]


def test_a_pressure_in_hpa_is_read_and_named(still, tmp_path):
    found = read(write(tmp_path / "bag", {"/baro": barometer(still.t, 1013.0)}))
    assert [(note.code, note.severity) for note in found.notes] == [("units", "error")]


def test_a_covariance_of_minus_one_means_no_measurement(still, tmp_path):
    without = inertial(still.t, still.accel, still.gyro, accel_covariance=NONE)
    found = read(write(tmp_path / "bag", {"/baro": barometer(still.t, 1e5), "/imu": without}))
    assert found.accel is None
    assert found.gyro[20] == pytest.approx([0, 0, 0.1])


def test_a_driver_without_stamps_gets_the_time_of_receipt(still, tmp_path):
    unstamped = [(ns, lambda types, v=v: pressure(types, 0, 1e5 + v)) for v, ns in enumerate(stamps(still.t))]
    found = read(write(tmp_path / "bag", {"/baro": (PRESSURE, unstamped)}))
    np.testing.assert_allclose(found.t - EPOCH, still.t, rtol=0, atol=STAMP)
    np.testing.assert_array_equal(found.pressure, 1e5 + np.arange(40))


def test_messages_that_arrive_late_take_their_place_in_time(still, tmp_path):
    kind, messages = barometer(still.t, 1e5 + np.arange(40))
    received = [ns for ns, _ in messages]
    shuffled = np.random.default_rng(0).permutation(40)
    late = [(ns, messages[k][1]) for ns, k in zip(received, shuffled, strict=True)]
    found = read(write(tmp_path / "bag", {"/baro": (kind, late)}))
    np.testing.assert_array_equal(found.pressure, 1e5 + np.arange(40))


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "a.bag"])
def test_what_is_no_bag_is_refused_in_a_sentence(tmp_path, name, refusal):
    path = tmp_path / name
    assert "no such file" in refusal(path)
    for content in (b"", b"time_s,pressure_pa\n", bytes(1000)):
        path.write_bytes(content)
        assert f"{name}: this is not a ROS bag, or it is damaged" in refusal(path)


def test_a_bag_without_pressure_or_without_reader_is_refused(still, tmp_path, monkeypatch, refusal):
    path = write(tmp_path / "bag", {"/imu": inertial(still.t, still.accel, still.gyro)})
    assert "no topic of type sensor_msgs/msg/FluidPressure" in refusal(path)
    (path / "metadata.yaml").write_text("nonsense: [")
    assert "this is not a ROS bag" in refusal(path)
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    assert "pip install 'baroarma[ros]'" in refusal(path)


@pytest.mark.parametrize(("storage", "suffix"), [("mcap", ".mcap"), ("sqlite3", ".db3"), ("bag", ".bag")])
def test_a_bag_cut_off_anywhere_is_refused_or_read(still, tmp_path, storage, suffix, capfd):
    whole = write(tmp_path / "bag", {"/baro": barometer(still.t, 1e5)}, storage)
    content = (whole if whole.is_file() else next(whole.glob(f"*{suffix}"))).read_bytes()
    cut, refused = tmp_path / f"cut{suffix}", 0
    for end in np.linspace(0, len(content) - 1, 25).astype(int):
        cut.write_bytes(content[:end])
        try:
            assert 0 < len(read(cut)) <= 40
        except UnreadableError:
            refused += 1
    assert refused > 0
    assert capfd.readouterr() == ("", "")
