"""The tracker: the same numbers on-line and in batch, whatever the samples look like."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import baroarma as ba
from baroarma.atmosphere import STANDARD_GRAVITY, altitude_pressure, pressure_altitude
from baroarma.presets import PRESETS
from baroarma.recording import Recording
from baroarma.simulation import BMP085, simulate
from baroarma.tracker import Tracker

ONLINE = [name for name, preset in PRESETS.items() if preset.height is not None]
SLOW = ("sonoh15", "zhang12")  # not compiled: they see less of the real recordings
COLUMNS = ("height", "velocity", "height_sd", "velocity_sd", "acceleration")
ELEVATOR_NOISE = ba.NoiseModel(0.143, 0.26, 0.211, 0.097, rate_hz=10)


@pytest.fixture(scope="module")
def squat():
    return simulate("squat", duration=14, seed=1)


@pytest.fixture(scope="module")
def elevator(shared_data):
    folder = shared_data / "srp_altimu10_elevator_rocket"
    return ba.read(*(folder / f"elevator_{stream}.csv.gz" for stream in ("baro", "acc", "gyr")))


@pytest.fixture(scope="module")
def hand_motions(shared_data):
    names = ("lift30cm_a", "lift30cm_b", "setdown_c", "air_d", "tilt_e", "rest_f", "rest_400hz_g")
    return [ba.read(shared_data / "stampfly_tof_handheld" / f"{name}.csv.gz") for name in names]


def steps(tracker, recording, rows=None):
    """Call `step` for the rows; the first interval is nonsense on purpose."""
    rows = range(len(recording)) if rows is None else rows
    dt = np.diff(recording.t, prepend=recording.t[0] - 99.0)
    return [
        tracker.step(
            dt=float(dt[k]),
            pressure=float(recording.pressure[k]),
            accel=None if recording.accel is None else recording.accel[k],
            gyro=None if recording.gyro is None else recording.gyro[k],
            attitude=None if recording.reference_attitude is None else recording.reference_attitude[k],
        )
        for k in rows
    ]


def agree(track, states, first=0):
    """`step` = `run` to 1e-9; answers of None are the alignment's rows, 0 in `run`."""
    aligning = sum(state is None for state in states)
    assert all(state is None for state in states[:aligning])
    assert not track.height[first : first + aligning].any()
    online = np.array(states[aligning:]).T
    batch = np.array([getattr(track, c)[first + aligning : first + len(states)] for c in COLUMNS])
    np.testing.assert_allclose(online, batch, rtol=1e-9, atol=1e-9)
    return aligning


def awkward(kind):
    """Return a recording with one thing that real recordings have."""
    recording = simulate("squat", duration=8, seed=3)
    t, pressure, n = recording.t, recording.pressure.copy(), len(recording)
    rng = np.random.default_rng(7)
    if kind == "missing":
        pressure[rng.random(n) < 0.2] = np.nan
    if kind == "slow":
        pressure[np.arange(n) % 5 != 0] = np.nan
    if kind == "late":
        pressure[t < 2.5] = np.nan
    recording = replace(recording, pressure=pressure)
    if kind == "uneven":
        return replace(recording, t=t + rng.uniform(-0.009, 0.009, n))
    if kind == "gap":
        return recording.rows((t < 3.5) | (t > 6.5))
    if kind == "merged":  # a barometer's own rows have no IMU
        blank = np.where((np.arange(n) % 7 == 3)[:, None], np.nan, 1.0)
        return replace(recording, accel=recording.accel * blank, gyro=recording.gyro * blank)
    if kind == "unix-time":
        return replace(recording, t=np.round(t + 1.7e9, 6))
    return recording


@pytest.mark.parametrize("kind", ["missing", "slow", "late", "uneven", "gap", "merged", "unix-time"])
@pytest.mark.parametrize("preset", ONLINE)
def test_step_is_run_whatever_the_samples_look_like(preset, kind):
    recording = awkward(kind)
    track = Tracker.preset(preset, noise=BMP085.noise).run(recording)
    aligning = agree(track, steps(Tracker.preset(preset, noise=BMP085.noise), recording))
    elapsed = recording.t - recording.t[0]
    # t = 1 s is the first row after the alignment, even where a double says 0.9999998 s
    assert aligning == np.count_nonzero(elapsed < 1 - 4e-7)


@pytest.mark.parametrize("noise", [None, BMP085.noise], ids=["no noise", "noise"])
@pytest.mark.parametrize("preset", list(PRESETS))
def test_every_preset_tracks_rest_and_squats(preset, noise):
    for motion in ("rest", "squat"):
        recording = simulate(motion, duration=12, seed=2)
        track = Tracker.preset(preset, noise=noise).run(recording)
        assert len(track) == len(recording)
        assert (track.height_sd > 0).all()
        assert (track.velocity_sd > 0).all()
        # plausible: half a metre of coloured noise, a squat of 0.6 m, no runaway
        assert np.abs(track.height).max() < 3


@pytest.mark.parametrize("preset", list(PRESETS))
def test_every_preset_tracks_real_hand_motions_and_a_ride(preset, hand_motions, elevator):
    for recording in hand_motions:
        recording = recording.between(0, 4) if preset in SLOW else recording
        track = Tracker.preset(preset).run(recording)
        assert len(track) == len(recording)
        assert track.height[0] == 0
        assert preset == "bourke08" or track.velocity[0] == 0  # off-line, it knows a hand that already moves
        # hand motions of 0.3 m; Tanigawa's 1 m takes a tilted accelerometer for motion
        assert np.abs(track.height).max() < 4
    ride = elevator.between(0, 9) if preset in SLOW else elevator
    assert len(Tracker.preset(preset, noise=ELEVATOR_NOISE).run(ride)) == len(ride)


@pytest.mark.parametrize("preset", ["sg14-a", "lee16", "lee16-kf", "zihajehzadeh15", "baroarma"])
def test_the_elevator_comes_back_to_its_floor(preset, elevator):
    track = Tracker.preset(preset, noise=ELEVATOR_NOISE).run(elevator)
    bottom, top = (track.t > 12) & (track.t < 20), (track.t > 55) & (track.t < 62)
    # README: the top is 80.8 m up, the end 0.17 m below the bottom; walking tilts the sensor, and the
    # filters' memory of a mistaken acceleration is a second or two: 2.5 m
    assert track.height[top].mean() - track.height[bottom].mean() == pytest.approx(80.8, abs=2.5)
    assert track.height[track.t > 104.5].mean() - track.height[bottom].mean() == pytest.approx(-0.17, abs=2.5)


def test_the_elevators_streams_give_the_same_numbers_on_line(elevator):
    part = elevator.between(0, 30)
    for preset in ("sg14-a", "baroarma"):
        make = Tracker.preset(preset, noise=ELEVATOR_NOISE)
        agree(make.run(part), steps(Tracker.preset(preset, noise=ELEVATOR_NOISE), part))


@pytest.mark.parametrize("preset", ONLINE)
def test_a_saved_tracker_goes_on_exactly(preset, squat, tmp_path):
    tracker, file = Tracker.preset(preset, noise=BMP085.noise), tmp_path / "tracker.pickle"
    for stop in (20, 300):  # while aligning, and after
        tracker.reset()
        steps(tracker, squat, range(stop))
        tracker.save(file)
        there = steps(Tracker.load(file), squat, range(stop, stop + 100))
        assert there == steps(tracker, squat, range(stop, stop + 100))


def test_a_file_that_holds_no_tracker_is_refused_in_a_sentence(tmp_path):
    file = tmp_path / "x.pickle"
    for content in (b"", b"no pickle", pickle.dumps({"format": "another"}), pickle.dumps(3)):
        file.write_bytes(content)
        with pytest.raises(ValueError, match=r"x\.pickle holds no tracker"):
            Tracker.load(file)


def test_reference_attitude_works_on_line(squat):
    settings = {"preset": "lee16", "attitude": "reference"}
    track = Tracker(**settings).run(squat)
    agree(track, steps(Tracker(**settings), squat))
    # with the true tilt only sensor errors are left: 2 mg of bias per axis, three axes, 3 sd
    off = track.acceleration[100:] - np.gradient(squat.reference_velocity, squat.t)[100:]
    assert abs(off.mean()) < 3 * 2e-3 * STANDARD_GRAVITY
    with pytest.raises(ValueError, match="no reference attitude"):
        Tracker(**settings).run(replace(squat, reference_attitude=None))


@pytest.mark.parametrize("preset", ONLINE)
def test_neither_the_clocks_origin_nor_the_level_matters(preset, squat):
    track = Tracker.preset(preset, noise=BMP085.noise).run(squat)
    later = Tracker.preset(preset, noise=BMP085.noise).run(replace(squat, t=squat.t + 1024.0))
    # times of 1024 s are rounded to 1e-13 s, against intervals of 0.02 s and speeds of 0.5 m/s
    np.testing.assert_allclose(later.height, track.height, atol=1e-8)
    higher = replace(squat, pressure=altitude_pressure(squat.height() + 300.0))
    # converting 300 m to Pa and back costs 1e-10 m, which a second's mean does not grow
    np.testing.assert_allclose(
        Tracker.preset(preset, noise=BMP085.noise).run(higher).height, track.height, atol=1e-8
    )


@pytest.mark.parametrize(
    ("preset", "tolerance"),
    # Lee's tilt filter has no preferred axis: rounding only.  The EKFs linearise, and normalise, in body
    # axes or a quaternion's four numbers: second-order terms, (1 degree)² of P0, far below a millimetre.
    # (SG14's gate is per axis, but these squats stay inside its 150 mg.)  `robust` knows the gyro's scale,
    # 1 %, axis by axis.
    [("lee16", 1e-12), ("tanigawa08", 1e-12), ("baroarma", 1e-6), ("zhang12", 1e-5), ("sg14-a", 1e-5)],
)
def test_the_mounting_does_not_matter(preset, tolerance, squat):
    turn = Rotation.from_rotvec([0.4, -1.9, 0.8])
    turned = replace(squat, accel=turn.apply(squat.accel.copy()), gyro=turn.apply(squat.gyro.copy()))
    one, other = (Tracker.preset(preset, noise=BMP085.noise).run(r) for r in (squat, turned))
    np.testing.assert_allclose(other.height, one.height, atol=tolerance)


def test_the_whitening_filter_reports_a_rise_times_its_dc_gain():
    # sixty seconds at rest, a rise of 5 m in 5 s, and two minutes above: the accelerometer carries the
    # rise for some seconds (time constant 1 s), then the height is what the whitened altitude says
    t = np.arange(0, 120, 0.02)
    u = np.clip((t - 20) / 5, 0, 1)
    height = 5 * u**3 * (10 - 15 * u + 6 * u**2)
    acceleration = 5 / 25 * (60 * u - 180 * u**2 + 120 * u**3)
    rise = Recording(
        t=t,
        pressure=altitude_pressure(100 + height),
        accel=np.outer(acceleration + STANDARD_GRAVITY, (0, 0, 1)),
        gyro=np.zeros((len(t), 3)),
    )
    without, whitened = Tracker.preset("sg14-a").run(rise), Tracker.preset("sg14-b").run(rise)
    gain = ba.ArmaModel(ar=(-0.87,), ma=(-0.50,), sd=1, dt=0.1).whitening_filter(rate_hz=50, unity_gain_hz=25)
    # 90 s after the rise both filters have settled (time constants 1.4 s and 1/(2 pi 0.24 Hz) = 0.7 s)
    assert without.height[-1] == pytest.approx(5.0, abs=1e-3)
    assert whitened.height[-1] == pytest.approx(5.0 * gain.dc_gain, abs=1e-3)
    assert gain.dc_gain == pytest.approx(0.2086, abs=1e-4)
    assert [f.code for f in whitened.findings] == ["dc-gain"]
    assert f"only {gain.dc_gain:.3g} times" in whitened.findings[0].message
    assert not without.findings


def test_whitening_is_synthesised_at_the_barometers_own_rate():
    slow = awkward("slow")
    tracker = Tracker.preset("sg14-b", noise=BMP085.noise)
    track = tracker.run(slow)
    expected = BMP085.noise.whitening_filter(rate_hz=10).dc_gain
    assert f"only {expected:.3g} times" in next(f for f in track.findings if f.code == "dc-gain").message
    assert next(f for f in track.findings if f.code == "noise-rate").severity == "warning"


def test_method_a_is_a_plain_loop_over_sg14s_equations(squat):
    """Eqs. 24-25 with the sign of K and the acceleration corrected, fed with the tracker's own a_z."""
    track = Tracker.preset("sg14-a").run(squat)
    start, T = 50, 0.02
    sigma_w, sigma_v = 15e-3 * 9.80665, 0.30  # SG14 Table 1
    k1, k2 = math.sqrt(2 * sigma_w / sigma_v), sigma_w / sigma_v
    altitude = pressure_altitude(squat.pressure)
    altitude = altitude - altitude[:start].mean()
    z = np.array([altitude[max(k - 3, 0) : k + 1].mean() for k in range(len(altitude))])
    h, v, heights, velocities = 0.0, 0.0, [0.0] * start, [0.0] * start
    heights.append(h)
    velocities.append(v)
    for k in range(start + 1, len(z)):
        e, a = z[k - 1] - h, track.acceleration[k - 1]
        h, v = h + T * v + (k1 + T / 2 * k2) * T * e + T * T / 2 * a, v + k2 * T * e + T * a
        heights.append(h)
        velocities.append(v)
    np.testing.assert_allclose(track.height, heights, atol=1e-9)
    np.testing.assert_allclose(track.velocity, velocities, atol=1e-9)


def test_without_imu_ours_gives_a_track_of_pressure_alone_and_the_others_refuse():
    recording = simulate("rest", duration=30, imu=None, seed=4)
    track = Tracker(noise=BMP085.noise).run(recording)
    assert "no-imu" in [f.code for f in track.findings]
    assert not track.acceleration.any()
    agree(track, steps(Tracker(noise=BMP085.noise), recording))
    for preset in set(PRESETS) - {"baroarma"}:
        with pytest.raises(ValueError, match="no accelerometer and gyro"):
            Tracker.preset(preset).run(recording)
    with pytest.raises(ValueError, match="no accelerometer and gyro"):
        Tracker.preset("lee16").step(dt=0, pressure=1e5)


def test_pressure_alone_follows_a_climb(shared_data):
    stairs = ba.read(shared_data / "bmp180_stm32_rest_and_stairs" / "stairs_up_b5_baro.csv.gz")
    rest = ba.NoiseModel(0, 0, 0.25, 0.03, rate_hz=stairs.rate_hz)
    track = Tracker(noise=rest).run(stairs)
    # its README: +30.6 m by the barometer itself; the filter must end there within its white noise
    assert track.height[-20:].mean() - track.height[:5].mean() == pytest.approx(30.6, abs=1.0)


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"preset": "sg14"}, "there is no preset 'sg14'; there are baroarma, sg14-a"),
        ({"attitude": "ekf"}, "there is no attitude estimator 'ekf'; there are robust, quaternion-ekf"),
        ({"height": "kalmann"}, "did you mean 'kalman'"),
        ({"conditioning": "mean"}, "there is no conditioning 'mean'; there are none, average"),
        ({"height_settings": {"sd": 1}}, "has no setting 'sd'; it has"),
        ({"preset": "sonoh15", "attitude": "vqf"}, "takes the IMU itself"),
        ({"preset": "sonoh15", "height": "kalman"}, "needs an attitude estimator"),
        ({"preset": "bourke08", "attitude": "tilt-kalman"}, "has no back-ends to choose"),
    ],
)
def test_what_does_not_exist_or_fit_is_told_at_once(settings, says):
    with pytest.raises(ValueError, match=says):
        Tracker(**settings)


@pytest.mark.parametrize("height", ["complementary", "kalman", "differenced-kalman", "inertial-ekf"])
@pytest.mark.parametrize("conditioning", ["none", "average", "average+whitening"])
def test_back_ends_are_swapped_by_name(height, conditioning, squat):
    tracker = Tracker(noise=BMP085.noise, height=height, conditioning=conditioning)
    track = tracker.run(squat)
    assert height in track.preset
    assert conditioning == "none" or conditioning in track.preset
    assert np.abs(track.height).max() < 3
    agree(track, steps(Tracker(noise=BMP085.noise, height=height, conditioning=conditioning), squat))


def test_another_attitude_changes_the_track_and_its_name(squat):
    track = Tracker(preset="sg14-a", attitude="accelerometer-norm").run(squat)
    assert track.preset == "accelerometer-norm+average+complementary"
    assert not np.allclose(track.height, Tracker.preset("sg14-a").run(squat).height)


def test_own_settings_replace_the_presets_and_show_in_the_name(squat):
    track = Tracker.preset("sg14-a", height_settings={"altitude_sd": 3.0}).run(squat)
    assert track.preset == "sg14-a (own settings)"
    assert not np.allclose(track.height, Tracker.preset("sg14-a").run(squat).height)


def test_recordings_that_can_not_be_tracked_are_refused_in_a_sentence(squat):
    with pytest.raises(ValueError, match=r"lasts 0\.48 s, all of it needed to align"):
        Tracker().run(squat.rows(slice(25)))
    with pytest.raises(ValueError, match="no pressure sample"):
        Tracker().run(replace(squat, pressure=np.full(len(squat), np.nan)))
    with pytest.raises(ValueError, match="no accelerometer sample in the first 1 s"):
        Tracker().run(replace(squat, accel=np.full((len(squat), 3), np.nan)))
    with pytest.raises(ValueError, match="off-line"):
        Tracker.preset("bourke08").step(dt=0, pressure=1e5, accel=np.zeros(3), gyro=np.zeros(3))
    tracker = Tracker()
    steps(tracker, squat, range(3))
    with pytest.raises(ValueError, match=r"time since the previous sample .* it is -1"):
        tracker.step(dt=-1, pressure=1e5, accel=squat.accel[3], gyro=squat.gyro[3])


def spoilt(recording, how):
    pressure, t = recording.pressure.copy(), recording.t
    if how == "fifth":
        pressure[np.arange(len(t)) % 5 != 0] = np.nan
    if how == "missing":
        pressure[np.random.default_rng(0).random(len(t)) < 0.2] = np.nan
    if how == "gap":
        pressure[(t > 30) & (t < 33)] = np.nan
    return replace(recording, pressure=pressure)


@pytest.mark.parametrize("preset", ["sg14-a", "lee16", "baroarma"])
def test_fewer_barometer_samples_cost_little(preset):
    # the white density rises fivefold, from 0.004 to 0.021 m²/Hz, beside 0.11 of the Gauss-Markov noise at
    # frequency 0 and half of that at 0.2 Hz: up to 0.13/0.11 to 0.08/0.06 in variance, 9 to 17 % in rms, and
    # a tenth for the other draw of noise in 5 seeds
    rms = {}
    for how in ("all", "fifth", "missing", "gap"):
        off = []
        for seed in range(5):
            recording = simulate("squat", duration=60, seed=seed)
            track = Tracker.preset(preset, noise=BMP085.noise).run(spoilt(recording, how))
            off.append(np.mean((track.height - recording.reference) ** 2))
        rms[how] = math.sqrt(np.mean(off))
    assert max(rms.values()) < 1.28 * rms["all"]


def test_what_is_no_noise_model_or_recording_is_told_what_to_do():
    with pytest.raises(
        TypeError, match=r"noise is a NoiseModel, not 'noise.json'; NoiseModel.load reads one"
    ):
        Tracker(noise="noise.json")
    with pytest.raises(TypeError, match=r"run takes a Recording, not 'walk.csv'; baroarma.read makes one"):
        Tracker(noise=BMP085.noise).run("walk.csv")


def test_a_vector_of_two_components_is_refused_at_once():
    with pytest.raises(ValueError, match=r"accel is a vector of three components, but has shape \(2,\)"):
        Tracker(noise=BMP085.noise).step(dt=0.02, accel=[0, 9.8], gyro=[0, 0, 0], pressure=1e5)


def test_smoothing_is_nearer_to_the_truth_and_knows_it():
    squares = []
    for seed in range(3):
        log = simulate("stairs", duration=60, seed=seed)
        tracker = Tracker(noise=BMP085.noise)
        tracks = [tracker.run(log), tracker.smooth(log, lag=1.0), tracker.smooth(log)]
        squares.append([np.mean((x.velocity - log.reference_velocity)[100:] ** 2) for x in tracks])
    run, near, whole = np.mean(squares, axis=0)
    assert whole < run
    assert near < run
    # the sds of the last log's rows: later rows only add to what a row knows, but for what they reveal
    assert tracks[2].height_sd.mean() < tracks[0].height_sd.mean()


def test_a_smoothed_track_has_a_name_of_its_own_and_the_same_rows(squat):
    tracker = Tracker(noise=BMP085.noise)
    smoothed, track = tracker.smooth(squat), tracker.run(squat)
    assert smoothed.preset == "baroarma, smoothed"
    assert len(smoothed) == len(track)
    assert not smoothed.height[:50].any()
    np.testing.assert_array_equal(smoothed.acceleration, track.acceleration)
    assert all(np.isfinite(getattr(smoothed, column)).all() for column in COLUMNS)


def test_after_smoothing_steps_go_on_as_after_a_run(squat):
    more = simulate("squat", duration=1, seed=8)
    trackers = [Tracker(noise=BMP085.noise) for _ in range(2)]
    trackers[0].run(squat)
    trackers[1].smooth(squat, lag=0.5)
    first, second = (
        [
            tracker.step(dt=0.02, pressure=more.pressure[k], accel=more.accel[k], gyro=more.gyro[k])
            for k in range(50)
        ]
        for tracker in trackers
    )
    assert first == second


def test_pressure_alone_is_smoothed_too():
    log = simulate("lift", duration=60, imu=None, seed=4)
    track, smoothed = Tracker(noise=BMP085.noise).run(log), Tracker(noise=BMP085.noise).smooth(log)
    off, smooth_off = (np.std((x.height - log.reference)[250:]) for x in (track, smoothed))
    assert smooth_off < off


@pytest.mark.parametrize(
    ("preset", "says"),
    [
        ("sg14-a", "Complementary has no smoother; coloured-kalman has one"),
        ("sonoh15", "has no smoother; coloured-kalman has one"),
        ("bourke08", "bourke08 is off-line already, and can't smooth"),
    ],
)
def test_what_can_not_smooth_says_so(preset, says, squat):
    with pytest.raises(ValueError, match=says):
        Tracker.preset(preset).smooth(squat)


@pytest.mark.parametrize("lag", [-0.1, float("nan")])
def test_a_lag_that_is_no_time_is_refused_with_its_value(lag, squat):
    with pytest.raises(ValueError, match=f"the lag is a time in s, 0 or more, but it is {lag}"):
        Tracker().smooth(squat, lag=lag)


def test_the_estimator_can_be_looked_at_once_it_is_aligned(squat):
    tracker = Tracker(noise=BMP085.noise)
    with pytest.raises(ValueError, match="not aligned yet; run it, or step it for a second"):
        _ = tracker.estimator
    track = tracker.run(squat)
    kf = tracker.estimator
    assert kf.x[0, 0] == track.height[-1]
    assert np.isfinite(kf.evidence)
    tracker.reset()
    with pytest.raises(ValueError, match="not aligned yet"):
        _ = tracker.estimator


def test_two_samples_at_the_same_instant_do_no_harm(squat):
    tracker, twice = Tracker(noise=BMP085.noise), Tracker(noise=BMP085.noise)
    steps(tracker, squat, range(60))
    steps(twice, squat, range(60))
    row = {"pressure": float("nan"), "accel": squat.accel[60], "gyro": squat.gyro[60]}
    one = tracker.step(dt=0.02, **row)
    twice.step(dt=0.02, **row)
    again = twice.step(dt=0.0, **row)
    # no time has passed, nothing new was said but 'at rest' once more
    assert again[:2] == pytest.approx(one[:2], abs=1e-3)
    assert np.isfinite(again).all()


def test_a_filter_is_told_the_drift_that_a_short_rest_could_not_exclude(squat):
    ends = {"correlated_sd": (0.2, 0.3), "correlation_time": (0.5, 1.0), "white_sd": (0.4, 0.5)}
    short = ba.NoiseModel(0.27, 0.75, 0.46, rate_hz=50, ci95={**ends, "drift_rate": (0.0, 0.0392)})
    tracker = Tracker(noise=short)
    tracker.run(squat)
    assert tracker.estimator.noise.drift_rate == pytest.approx(0.02, rel=1e-3)
    assert tracker.noise is short
