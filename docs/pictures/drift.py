"""How sure a filter that knows its barometer's drift is of the height, over an hour without rests."""

import matplotlib.pyplot as plt
import numpy as np

from baroarma import NoiseModel
from baroarma.estimators import height_estimator

figure, ax = plt.subplots(figsize=(7.5, 3.2))
t = np.arange(0, 3600, 0.1)
for drift, style in ((0.0, "-"), (0.01, "--"), (0.03, ":")):
    noise = NoiseModel(0.27, 0.75, 0.46, drift, rate_hz=50).at_rate(10)
    kalman = height_estimator("coloured-kalman", noise=noise, acceleration_sd=0.025, offset_sd=1e-3)
    run = kalman.run(t, np.zeros(len(t)), np.zeros(len(t)))
    label = f"drift {drift:g} m/√s" if drift else "no drift"
    ax.loglog(t[10:], run.height_sd[10:], ls=style, color="#0072B2", label=label)
ax.set(xlabel="time (s)", ylabel="sd of the height (m)")
ax.legend(fontsize="small")
