"""The three terms of a barometer's noise over a minute, and their spectra."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from baroarma import NoiseModel

BMP085 = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, drift_rate=0.03, rate_hz=50)
NONE = NoiseModel(0.0, 0.0, 0.0, rate_hz=50)
TERMS = {
    "white": (replace(NONE, white_sd=0.46), "0.55"),
    "Gauss-Markov": (replace(NONE, correlated_sd=0.27, correlation_time=0.75), "#D55E00"),
    "drift": (replace(NONE, drift_rate=0.03), "#0072B2"),
}

figure, (left, right) = plt.subplots(1, 2, width_ratios=(3, 2))
t, f = np.arange(3000) / 50, np.geomspace(0.005, 25, 300)
for seed, (name, (term, colour)) in enumerate(TERMS.items(), start=1):
    left.plot(t, term.simulate(t, rng=seed), color=colour, lw=0.4 if name == "white" else 1.2, label=name)
    right.loglog(f, term.psd(f), color=colour, ls="-" if name == "white" else "--")
right.loglog(f, BMP085.psd(f), color="black", lw=1.6, label="sum")
left.set(xlabel="time (s)", ylabel="height error (m)")
right.set(xlabel="frequency (Hz)", ylabel="density (m²/Hz)", ylim=(1e-4, 30))
for line in left.legend(loc="upper right", ncols=3, fontsize="small").get_lines():
    line.set_linewidth(1.6)
right.legend(fontsize="small")
