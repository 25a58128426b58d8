"""ArduPilot's dataflash logs, written by pymavlink's own message writer."""

import sys

import numpy as np
import pytest

from baroarma.formats import UnreadableError, read

DFReader = pytest.importorskip("pymavlink.DFReader", reason="the extra `ardupilot` is not installed")

MICROSECOND = 1e-6
FMT = DFReader.DFFormat(0x80, "FMT", 89, "BBnNZ", "Type,Length,Name,Format,Columns")
BARO = ("QBffcfIffB", "TimeUS,I,Alt,Press,Temp,CRt,SMS,Offset,GndTemp,Health")
OLD_BARO = ("QffcfIff", "TimeUS,Alt,Press,Temp,CRt,SMS,Offset,GndTemp")
IMU = ("QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz")
RATE = ("QBHd", "TimeUS,I,N,R")


def us(t):
    return np.round(np.asarray(t) / MICROSECOND).astype(np.int64).tolist()


def baro(t, pressure, instance=0):
    """Return (name, layout, rows): 21.5 C is logged as 2150."""
    pressure = np.broadcast_to(pressure, np.shape(t)).tolist()
    return (
        "BARO",
        BARO,
        [(t, instance, 1.0, p, 2150, 0, 0, 0, 0, 1) for t, p in zip(us(t), pressure, strict=True)],
    )


def imu(t, accel, gyro, instance=0):
    rows = zip(us(t), np.asarray(gyro).tolist(), np.asarray(accel).tolist(), strict=True)
    return "IMU", IMU, [(t, instance, *g, *a, 0, 0, 30.0, 1, 1, 1000, 1000) for t, g, a in rows]


def dataflash(folder, *messages):
    """Return a log: the format of formats, the formats, the messages."""
    names = list(dict.fromkeys((name, layout) for name, layout, _ in messages))
    formats = {name: DFReader.DFFormat(100 + k, name, 0, *layout) for k, (name, layout) in enumerate(names)}
    seed = folder / "seed.bin"
    seed.write_bytes(FMT_BYTES)
    with DFReader.DFReader_binary(str(seed)) as writer:
        parts = [FMT_BYTES, *(writer.make_format_msgbuf(fmt) for fmt in formats.values())]
        parts += [writer.make_msgbuf(formats[name], row) for name, _, rows in messages for row in rows]
    return b"".join(parts)


FMT_BYTES = DFReader.struct.pack(
    "<BBB" + FMT.msg_struct[1:],
    0xA3,
    0x95,
    0x80,
    0x80,
    89,
    b"FMT",
    b"BBnNZ",
    b"Type,Length,Name,Format,Columns",
)


def test_a_log_gives_the_noise_model_of_the_recording(streams, assert_same, tmp_path):
    path = tmp_path / "00000042.BIN"
    messages = baro(streams.baro_t, streams.pressure), imu(streams.imu_t, streams.accel, streams.gyro)
    path.write_bytes(dataflash(tmp_path, *messages))
    found = read(path)
    assert_same(found, stamp=MICROSECOND)
    assert found.name == "00000042"
    assert found.temperature[found.is_new] == pytest.approx(21.5)


def level(n=40):
    t = 1 + np.arange(n) / 10
    return t, np.tile((0, 0, -9.8), (n, 1)), np.tile((0, 0, 0.1), (n, 1))


def test_a_level_vehicle_reads_up_along_minus_z(tmp_path):
    path, (t, accel, gyro) = tmp_path / "a.bin", level()
    path.write_bytes(dataflash(tmp_path, baro(t, 1e5), imu(t, accel, gyro)))
    found = read(path)
    assert found.accel[20] == pytest.approx([0, 0, -9.8])
    assert found.gyro[20] == pytest.approx([0, 0, 0.1])


def test_the_first_instance_is_taken_and_the_others_are_named(tmp_path):
    path, (t, accel, gyro) = tmp_path / "a.bin", level()
    messages = baro(t, 1e5), baro(t, 9e4, 1), imu(t, accel, gyro), imu(t, 2 * accel, gyro, 1)
    path.write_bytes(dataflash(tmp_path, *messages))
    found = read(path)
    assert set(found.pressure[found.is_new]) == {1e5}
    assert found.accel[20] == pytest.approx([0, 0, -9.8])
    texts = [note.message for note in found.notes]
    assert texts == [
        "a.bin has 2 barometers: the first was taken and number 1 left out.",
        "a.bin has 2 IMUs: the first was taken and number 1 left out.",
    ]


def test_old_logs_without_instances_are_read(tmp_path):
    path, (t, _, _) = tmp_path / "a.bin", level()
    messages = [
        (name, OLD_BARO, [(t, 0, p, 2150, 0, 0, 0, 0) for t in us(t)])
        for name, p in (("BARO", 1e5), ("BAR2", 9e4))
    ]
    path.write_bytes(dataflash(tmp_path, *messages))
    found = read(path)
    assert set(found.pressure) == {1e5}
    assert found.accel is None
    assert [note.message for note in found.notes] == [
        "a.bin has 2 barometers: the first was taken and BAR2 left out."
    ]


def test_what_is_no_log_with_pressure_is_refused_in_a_sentence(tmp_path, monkeypatch, refusal):
    path = tmp_path / "a.bin"
    assert "no such file" in refusal(path)
    for content in (b"", b"time_s,pressure_pa\n", bytes(1000)):
        path.write_bytes(content)
        assert "a.bin: this is not a dataflash log" in refusal(path)
    path.write_bytes(dataflash(tmp_path, imu(*level())))
    assert "no BARO message" in refusal(path)
    path.write_bytes(dataflash(tmp_path, ("BARO", RATE, [(1, 0, 0, 0.0)])))
    assert "BARO is not as ArduPilot writes it" in refusal(path)
    monkeypatch.setitem(sys.modules, "pymavlink.DFReader", None)
    assert "pip install 'baroarma[ardupilot]'" in refusal(path)


def test_a_log_cut_off_anywhere_gives_what_was_there_or_a_sentence(tmp_path, capfd):
    path, (t, accel, gyro) = tmp_path / "a.bin", level()
    content = dataflash(tmp_path, baro(t, 1e5), imu(t, accel, gyro))
    lengths = []
    for end in range(0, len(content) + 1, 61):
        path.write_bytes(content[:end])
        try:
            lengths.append(len(read(path)))
        except UnreadableError:
            lengths.append(0)
    assert lengths == sorted(lengths)
    assert lengths[-1] == 40
    assert capfd.readouterr() == ("", "")


def test_damage_is_noted_or_refused_but_never_a_traceback(tmp_path, capfd):
    path, (t, accel, gyro) = tmp_path / "a.bin", level(150)
    content = dataflash(tmp_path, baro(t, 1e5), imu(t, accel, gyro))
    rng, outcomes = np.random.default_rng(0), set()
    for _ in range(60):
        damaged = bytearray(content)
        for position in rng.integers(2, len(content), 20):
            damaged[position] = rng.integers(256)
        path.write_bytes(damaged)
        try:
            outcomes |= {note.code for note in read(path).notes}
        except UnreadableError:
            outcomes.add("refused")
    assert {"damaged", "refused"} <= outcomes
    assert capfd.readouterr() == ("", "")
