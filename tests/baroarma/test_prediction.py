"""What is predicted comes true: linear runs, the whole tracker, and the document about it."""

import re
from pathlib import Path

import numpy as np
import pytest

import baroarma as ba
from baroarma.estimators import height_estimator
from baroarma.estimators.base import Alignment
from baroarma.estimators.conditioning import conditioner_of
from baroarma.presets import PRESETS
from baroarma.simulation import BMP085, DEVICES, simulate

NOISE = BMP085.noise
IMU = ba.ImuNoise.of_device("simple")
DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "prediction.md"
RESTLESS = {"lee16": {"zupt_steps": 0}, "lee16-kf": {"zupt_steps": 0}, "baroarma": {"confirm_rest": False}}
LINEAR = ("sg14-a", "sg14-b", "lee16", "zihajehzadeh15", "baroarma")


def close(squares, predicted, most):
    """Compare rms over runs (n, 2) with predicted ones: within `most`, and within 3.5 standard errors."""
    rms = np.sqrt(squares.mean(axis=0))
    error = squares.std(axis=0) / np.sqrt(len(squares)) / (2 * rms**2)  # of rms, relative
    ratio = rms / predicted
    assert np.all(error < most / 2.5), error  # enough runs for the claim
    assert np.all(abs(ratio - 1) < np.minimum(most, 3.5 * error)), (ratio, error)


@pytest.fixture(scope="module")
def linear_noise():
    """Altimeter noise and acceleration noise of 1500 runs of 8 s."""
    rng = np.random.default_rng(7)
    t = np.arange(400) / 50
    return t, [(NOISE.simulate(t, rng), IMU.accel_sd * rng.normal(size=400)) for _ in range(1500)]


@pytest.mark.parametrize("preset", LINEAR)
def test_linear_runs_err_as_predicted_within_5_percent(preset, linear_noise):
    """Conditioning and filter without a tracker around them; 1500 runs know the rms to 1-2 %."""
    chain = PRESETS[preset]
    settings = {name: c.value for name, c in chain.height_settings.items()} | RESTLESS.get(preset, {})
    height = height_estimator(chain.height, noise=NOISE, **settings)
    t, runs = linear_noise
    squares = []
    for n, w in runs:
        z = n - (n[:50].mean() if chain.bias_capture else n[0])
        if chain.conditioning != "none":
            z = conditioner_of(chain.conditioning, NOISE, 50.0).run(z)
        height.reset(Alignment(accel_sd=IMU.accel_sd, gyro_sd=IMU.gyro_sd))
        found = height.run(t[50:], z[50:], w[50:] - w[:50].mean())
        squares.append([np.sum(found.height**2), np.sum(found.velocity**2)])
    predicted = ba.predict_accuracy(NOISE, IMU, preset, 8.0)
    close(np.array(squares) / len(t), [predicted.height_rms, predicted.velocity_rms], 0.05)


@pytest.fixture(scope="module")
def rests():
    return [simulate("rest", duration=10, seed=seed) for seed in range(400)]


@pytest.mark.parametrize("preset", LINEAR)
def test_the_tracker_errs_as_predicted_within_7_percent(preset, rests):
    """400 recordings know the rms to 1.3-2.6 %; 7 % is what they can claim.  The benchmark claims 5 %."""
    tracker = ba.Tracker(
        preset=preset, noise=NOISE, attitude="reference", height_settings=RESTLESS.get(preset, {})
    )
    tracks = [tracker.run(recording) for recording in rests]
    squares = np.array([[np.mean(k.height**2), np.mean(k.velocity**2)] for k in tracks])
    predicted = ba.predict_accuracy(NOISE, "simple", preset, 10.0)
    close(squares, [predicted.height_rms, predicted.velocity_rms], 0.07)


def test_a_slow_barometer_and_a_wandering_accelerometer_err_as_predicted():
    """The GY-87's barometer has half the rate of its IMU; 60 runs know the rms to 6 %: 3.5 of these."""
    noise = DEVICES["gy-87"].barometer.noise
    predicted = ba.predict_accuracy(noise, "gy-87", "sg14-a", 20.0)
    squares = []
    for seed in range(60):
        recording = simulate("rest", duration=20, device="gy-87", seed=seed)
        track = ba.Tracker(preset="sg14-a", noise=noise, attitude="reference").run(recording)
        squares.append([np.mean(track.height**2), np.mean(track.velocity**2)])
    close(np.array(squares), [predicted.height_rms, predicted.velocity_rms], 0.21)


def test_the_optimal_filter_is_the_best_of_all_in_the_long_run():
    noise = ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
    ours = ba.predict_accuracy(
        noise, IMU, "baroarma", 120.0, height_settings={"bias_sd": 0.004, "bias_walk": 1e-6}
    )
    for preset in ("sg14-a", "lee16", "zihajehzadeh15", "tanigawa08"):
        theirs = ba.predict_accuracy(noise, IMU, preset, 120.0)
        assert ours.velocity_sd[-1] < theirs.velocity_sd[-1]
        assert ours.height_sd[-1] < theirs.height_sd[-1]


@pytest.mark.parametrize("worse", ["gyro_density", "gyro_bias_sd", "accel_bias_sd"])
def test_tilt_matters_only_with_horizontal_acceleration(worse):
    bad = ba.ImuNoise(**{"accel_density": 1e-3, "rate_hz": 50, worse: 0.05})
    good = ba.ImuNoise(accel_density=1e-3, rate_hz=50)
    rms = {
        (imu, a): ba.predict_accuracy(NOISE, imu, "sg14-a", 10.0, horizontal_acceleration=a).velocity_rms
        for imu in (good, bad)
        for a in (0.0, 1.0, 2.0)
    }
    assert rms[bad, 0.0] == rms[good, 0.0] == rms[good, 1.0]
    assert rms[good, 0.0] < rms[bad, 1.0] < rms[bad, 2.0]
    growth = [rms[bad, a] ** 2 - rms[bad, 0.0] ** 2 for a in (1.0, 2.0)]
    assert growth[1] == pytest.approx(4 * growth[0], rel=1e-6)  # a product: variance goes as a²


def test_a_rest_recording_stands_for_its_imu():
    rest = simulate("rest", duration=60, seed=1)
    found = ba.predict_accuracy(NOISE, rest, "sg14-a", 20.0)
    assert found.imu == ba.ImuNoise.from_recording(rest)
    # the accelerometer is not what matters: a tenth of its density moves the errors by less than a percent
    assert found.velocity_rms == pytest.approx(
        ba.predict_accuracy(NOISE, "simple", "sg14-a", 20.0).velocity_rms, rel=0.01
    )


def test_what_to_know_is_said_where_it_holds():
    notes = {name: " ".join(ba.predict_accuracy(NOISE, IMU, name, 20.0).notes) for name in LINEAR}
    assert all("drift can't be told from height" in note for note in notes.values())
    assert {name for name, note in notes.items() if "Rests are left out" in note} == {"lee16", "baroarma"}
    assert {name for name, note in notes.items() if "0.193 times its size" in note} == {"sg14-b"}
    steady = ba.predict_accuracy(ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50), IMU, "sg14-a", 20.0)
    assert steady.notes == ()
    assert steady.steady_height_sd == pytest.approx(steady.height_sd[-1], rel=0.02)
    fast = ba.predict_accuracy(ba.NoiseModel(0.0, 0.0, 0.1, rate_hz=75), IMU, "sg14-a", 20.0)
    assert "75 Hz" in " ".join(fast.notes)
    short = ba.predict_accuracy(NOISE, IMU, "tanigawa08", 10.0)
    assert "gains still change by the end" in " ".join(short.notes)
    odd = ba.predict_accuracy(ba.NoiseModel(0.0, 0.0, 0.1, rate_hz=30), IMU, "sg14-a", 10.0)
    assert "no whole ratio" in " ".join(odd.notes)


def test_a_clock_that_is_a_little_off_changes_little():
    """Rates are measured to a percent: still one sample a row, and errors that move by that percent."""
    off = ba.ImuNoise(IMU.accel_density, rate_hz=50.4)
    exact, near = (ba.predict_accuracy(NOISE, imu, "sg14-a", 20.0) for imu in (IMU, off))
    assert near.velocity_rms == pytest.approx(exact.velocity_rms, rel=0.01)
    assert near.steady_velocity_sd == pytest.approx(exact.steady_velocity_sd, rel=0.01)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"preset": "sonoh15"}, "errors of 'sonoh15' depend on the motion"),
        ({"preset": "bourke08"}, "errors of 'bourke08' depend on the motion"),
        ({"preset": "lee15"}, "no preset 'lee15'"),
        ({"imu": "nokia"}, "device 'nokia' is unknown"),
        ({"duration": 1.0}, "run of 1 s with 50 pressures"),
        ({"duration": float("nan")}, "run of nan s"),
        ({"horizontal_acceleration": -1.0}, "0 or more, but it is -1"),
        ({"height_settings": {"level_prior_sd": 0.2}}, "what level_prior_sd knows"),
        ({"height_settings": {"speed": 3}}, "no setting 'speed'"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else None,
)
def test_what_can_not_be_predicted_is_refused(arguments, says):
    with pytest.raises(ValueError, match=says):
        ba.predict_accuracy(**{"noise": NOISE, **arguments})


def test_other_arguments_are_named():
    with pytest.raises(TypeError, match=r"noise is a NoiseModel, not 'noise\.json'"):
        ba.predict_accuracy("noise.json")
    with pytest.raises(TypeError, match="imu is an ImuNoise, a Recording or a device's name, not 3"):
        ba.predict_accuracy(NOISE, 3)


def test_every_block_of_the_document_runs(capsys):
    blocks = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) >= 2
    names: dict[str, object] = {}
    for block in blocks:
        exec(block, names)
    assert "predicted errors" in capsys.readouterr().out
