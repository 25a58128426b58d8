"""Four ways to treat coloured altimeter noise: `python benchmarks/noise_treatment.py [--runs 2000]`.

Linear runs of one minute at 50 Hz: white acceleration noise, SG13's altimeter noise without drift, nothing
else.  A filter that knows its errors has a mean NEES of 2 (height and velocity, at the end) and a mean NIS of
1 (first 6 s of a fifth of the runs), both inside the 95 % chi-square band of so many.
"""

import argparse

import numpy as np
from scipy.stats import chi2

from baroarma import NoiseModel
from baroarma.estimators import height_estimator

SG13 = NoiseModel(0.27, 0.75, 0.46, rate_hz=50)
PURE_GM = NoiseModel(0.27, 0.75, 0.0, rate_hz=50)
ROWS = 3000
EXACT = {"bias_sd": 0.0, "bias_walk": 0.0, "offset_sd": 0.0, "midpoint": False}
WAYS = {
    "white: correlation ignored": ("kalman", {"correlation": "ignore"}),
    "white: R inflated": ("kalman", {"correlation": "inflate"}),
    "differenced, white part ignored": ("differenced-kalman", {**EXACT, "carry_white": False}),
    "differenced, white part carried": ("differenced-kalman", EXACT),
    "augmented": ("coloured-kalman", EXACT),
}


def consistency(way, noise, runs):
    """Mean NEES, mean NIS and rms errors of one way of treating the noise."""
    name, settings = WAYS[way]
    rng = np.random.default_rng(0)
    t = np.arange(ROWS) / 50
    nees, nis, squares = [], [], []
    for i in range(runs):
        z, a = noise.simulate(t, rng), rng.normal(scale=0.025, size=ROWS)
        kf = height_estimator(name, noise=noise, acceleration_sd=0.025, initial_velocity_sd=1e-3, **settings)
        for k in range(300 if i % 5 == 0 else 0):  # the filterpy steps, whose innovations we want
            if k:
                kf.predict(a[k - 1])
            kf.update(z[k])
            nis.append(kf.mahalanobis**2)
        kf.reset()
        run = kf.run(t, z, a)
        error = np.array([run.height[-1], run.velocity[-1]])
        nees.append(error @ np.linalg.solve(kf.P[:2, :2], error))
        squares.append([np.mean(run.height**2), np.mean(run.velocity**2)])
    return np.mean(nees), np.mean(nis), np.sqrt(np.mean(squares, axis=0))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=2000)
    runs = parser.parse_args().runs
    for title, noise in (("SG13's noise", SG13), ("pure Gauss-Markov noise", PURE_GM)):
        print(f"\n### {title}, {runs} runs\n")
        print("| treatment | NEES | NIS | rms height m | rms velocity m/s |\n|---|---|---|---|---|")
        for way in WAYS:
            if noise is PURE_GM and way.startswith("white"):
                continue
            nees, nis, rms = consistency(way, noise, runs)
            print(f"| {way} | {nees:.2f} | {nis:.3f} | {rms[0]:.3f} | {rms[1]:.4f} |")
        low, high = chi2.ppf([0.025, 0.975], 2 * runs) / runs
        nis_low, nis_high = chi2.ppf([0.025, 0.975], 60 * runs) / (60 * runs)
        print(f"| 95 % band | {low:.2f} - {high:.2f} | {nis_low:.3f} - {nis_high:.3f} | | |")


if __name__ == "__main__":
    main()
