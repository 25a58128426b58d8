"""What a whitening filter does to the noise, and to a walk up three floors."""

import matplotlib.pyplot as plt
import numpy as np

from baroarma import NoiseModel

BMP085 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)

figure, (left, right) = plt.subplots(1, 2)
f, t = np.geomspace(0.005, 25, 300), np.arange(0, 90, 0.02)
floors = 1.7 * sum(np.clip((t - start) / 7, 0, 1) for start in (10, 35, 60))
right.plot(t, floors, color="black", lw=1.6, label="true height")
for unity, colour, style in ((25, "#D55E00", "-"), (0, "#0072B2", "--")):
    w = BMP085.whitening_filter(unity_gain_hz=unity)
    left.loglog(f, np.abs(w.response(f)), color=colour, ls=style, label=f"gain 1 at {unity} Hz")
    right.plot(t, w(floors), color=colour, ls=style, label=f"whitened, gain 1 at {unity} Hz")
left.set(xlabel="frequency (Hz)", ylabel="gain")
left.set_yticks([0.2, 0.5, 1, 2, 5], ["0.2", "0.5", "1", "2", "5"])
left.minorticks_off()
right.set(xlabel="time (s)", ylabel="height (m)")
left.legend(fontsize="small")
right.legend(fontsize="small")
