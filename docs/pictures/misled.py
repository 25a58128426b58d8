"""The same noise through a filter that takes it for white and through one that has it in its state."""

import matplotlib.pyplot as plt
import numpy as np

from baroarma import NoiseModel
from baroarma.estimators import height_estimator

BMP085 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
ALONE = {"confirm_rest": False, "bias_sd": 1e-6, "bias_walk": 0.0, "offset_sd": 0.0}

rng = np.random.default_rng(4)
t = np.arange(3000) / 50
altitude, acceleration = BMP085.simulate(t, rng), rng.normal(0, 0.05, len(t))
white = height_estimator("kalman", noise=BMP085, acceleration_sd=0.05, altitude_sd=np.hypot(0.27, 0.46))
coloured = height_estimator("coloured-kalman", noise=BMP085, acceleration_sd=0.05, **ALONE)

figure, axes = plt.subplots(2, 1, sharex=True, sharey=True, figsize=(7.5, 4.4))
titles = ("noise taken for white", "correlation in the state")
for ax, estimator, title, colour in zip(axes, (white, coloured), titles, ("#D55E00", "#0072B2"), strict=True):
    run = estimator.run(t, altitude, acceleration)
    ax.fill_between(t, -2 * run.height_sd, 2 * run.height_sd, color="0.82", label="± 2 sd, as it believes")
    ax.plot(t, run.height, color=colour, label="its error")
    ax.set(ylabel="height (m)", title=title)
    ax.legend(loc="lower left", ncols=2, fontsize="small")
axes[1].set(xlabel="time (s)", ylim=(-0.6, 0.6))
