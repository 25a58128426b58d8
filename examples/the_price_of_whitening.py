"""What does a whitening filter do to noise, and what to height?  `python examples/the_price_of_whitening.py`

A lift rides 12 m up.  Method A fuses the averaged barometer, Method B the whitened one, ours carries the
noise in the filter's state.  Draws the_price_of_whitening.png: the whitened height has the least noise, and
misses the ride.
"""

import matplotlib as mpl
import numpy as np

import baroarma as ba
from baroarma.plotting import plot_traces
from baroarma.simulation import BMP085, simulate, simulate_rest

mpl.use("Agg")
import matplotlib.pyplot as plt

noise = ba.identify(simulate_rest(600, seed=1)).model
whitening = noise.whitening_filter()
print(whitening)

still = BMP085.noise.simulate(30_000, 2)
for name, signal in (("raw", still), ("whitened", whitening(still))):
    lag = 10  # 0.2 s: well inside the correlation time
    correlation = np.corrcoef(signal[lag:], signal[:-lag])[0, 1]
    print(f"{name:9} sd {np.std(signal):.3f} m, correlation 0.2 s later {correlation:+.3f}")

ride = simulate("lift", duration=120, seed=3)
bake_off = ba.compare(ride, presets=("sg14-a", "sg14-b", "baroarma"), noise=noise)
print(bake_off)

figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained")
whitening.plot(left)
plot_traces(bake_off, right, "height")
figure.savefig("the_price_of_whitening.png", dpi=100)
