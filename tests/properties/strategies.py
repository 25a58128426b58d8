"""What the property tests draw from: values that are valid, however unlikely.

The gate draws a few examples, always the same ones; ``BAROARMA_EXAMPLES=2000 pytest tests/properties`` draws
so many, new ones every time.
"""

import os

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from baroarma import ArmaModel, Finding, NoiseModel, Recording
from baroarma.atmosphere import STANDARD_GRAVITY
from baroarma.presets import PRESETS

GIVEN = os.environ.get("BAROARMA_EXAMPLES")
SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.function_scoped_fixture]


def examples(gate=25):
    """Settings of a property test that draws `gate` examples in the gate."""
    drawn = int(GIVEN) if GIVEN else gate
    return settings(max_examples=drawn, derandomize=not GIVEN, deadline=None, suppress_health_check=SLOW)


ONLINE = [name for name, preset in PRESETS.items() if preset.height is not None]
COMPILED = [name for name in ONLINE if PRESETS[name].height != "inertial-ekf"]

sds = st.floats(1e-6, 100.0)
times = st.floats(1e-3, 1e5)
rates = st.floats(0.01, 1e4)
angles = st.floats(-np.pi, np.pi)
rotations = st.tuples(angles, angles, angles).map(lambda xyz: Rotation.from_euler("xyz", xyz))


@st.composite
def noise_models(draw):
    """Any model: each term there or not, with or without intervals, verdicts and sources."""
    gm = draw(st.booleans())
    values = {
        "correlated_sd": draw(sds) if gm else 0.0,
        "correlation_time": draw(times) if gm else 0.0,
        "white_sd": draw(st.just(0.0) | sds),
        "drift_rate": draw(st.just(0.0) | sds),
    }
    spread = draw(st.none() | st.floats(1.0, 3.0))
    ci95 = None if spread is None else {k: (v / spread, v * spread) for k, v in values.items()}
    texts = st.text(max_size=20)
    finding = st.builds(Finding, texts, st.sampled_from(["info", "warning", "error"]), texts)
    return NoiseModel(
        **values,
        rate_hz=draw(rates),
        ci95=ci95,
        sensor=draw(texts),
        verdict=tuple(draw(st.lists(finding, max_size=2))),
        whiteness_p=draw(st.none() | st.fixed_dictionaries({"bartlett": st.floats(0, 1)})),
        source=draw(st.none() | st.fixed_dictionaries({"name": texts, "duration_s": times})),
    )


@st.composite
def arma11(draw):
    """An ARMA(1,1) that Gauss-Markov plus white noise can have: a < b < 0."""
    a = draw(st.floats(-0.999, -1e-3))
    b = a * draw(st.floats(1e-3, 0.999))
    return ArmaModel((a,), (b,), draw(sds), draw(st.floats(1e-3, 10.0)))


NAN = st.just(np.nan)
DTS = st.sampled_from([0.02, 1e-6, 10.0]) | st.floats(1e-6, 10.0)
RANGES = {"pressure": (30_000.0, 110_000.0), "accel": (-157.0, 157.0), "gyro": (-35.0, 35.0)}
"""What sensors can say: 300 to 1100 hPa, 16 g, 2000 °/s; in SI units."""


def samples(name, n, width=None):
    """n rows of a sensor: any number that it can say, or NaN anywhere."""
    shape = n if width is None else (n, width)
    usual = 101_325.0 if name == "pressure" else 0.0
    return arrays(float, shape, elements=NAN | st.floats(*RANGES[name]), fill=st.just(usual))


@st.composite
def streams(draw, longest=40):
    """A second of rest, and then whatever sensors can say: a Recording at uneven times."""
    n = draw(st.integers(1, longest))
    dt = draw(arrays(float, n, elements=DTS, fill=st.just(0.02)))
    rng = np.random.default_rng(0)
    rest = np.array([0.0, 0.0, STANDARD_GRAVITY]) + 0.02 * rng.normal(size=(51, 3))
    still = 0.002 * rng.normal(size=(51, 3))
    t = np.concatenate([np.arange(51) / 50, 1.0 + np.cumsum(dt)])
    return Recording(
        t=t,
        pressure=np.concatenate([np.full(51, 101_325.0), draw(samples("pressure", n))]),
        accel=np.concatenate([rest, draw(samples("accel", n, 3))]),
        gyro=np.concatenate([still, draw(samples("gyro", n, 3))]),
    )
