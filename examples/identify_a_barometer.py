"""What is the noise of my barometer?  `python examples/identify_a_barometer.py [rest.csv]`

Reads a log of the motionless sensor (without one: simulates ten minutes of SG13's BMP085), prints the noise
model with intervals and verdict, and draws what supports it into identify_a_barometer.png.
"""

import sys

import matplotlib as mpl

import baroarma as ba
from baroarma.simulation import simulate_rest

mpl.use("Agg")

rest = ba.read(sys.argv[1]) if len(sys.argv) > 1 else simulate_rest(600, seed=1)
found = ba.identify(rest)
print(found.summary())
if found.model is None:
    sys.exit(1)

# the two numbers that most filters ask for
print(f"\nR for one raw sample: {found.model.white_sd**2:.4g} m²")
print(f"and, if the filter has no state for it, an error of {found.model.correlated_sd:.3g} m")
print(f"that averaging over less than {found.model.correlation_time:.3g} s does not reduce.")
found.plot().savefig("identify_a_barometer.png", dpi=100)
