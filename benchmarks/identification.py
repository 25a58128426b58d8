"""How good is the identification?  `python benchmarks/identification.py [--seeds 300]` prints the tables.

1. The structural method on SG13's noise: bias, spread against the Cramér-Rao bound, coverage of intervals.
2. How often `terms="auto"` keeps each term, for several truths.
3. SG13's windows recipe against its Tables 1 and 2, whitened surrogates against Tables 3 and 4, and how often
   zero and pole cancel with the filter from the raw density and with the paper's 10 Hz design.
"""

import argparse
import os
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from baroarma import ArmaModel, NoiseModel
from baroarma.identification.bound import cramer_rao_bound
from baroarma.identification.intervals import intervals
from baroarma.identification.preprocessing import trimmed_mean
from baroarma.identification.structural import Problem, fit_terms, select_terms
from baroarma.identification.surrogates import whitened_surrogate, zero_pole_cancellation
from baroarma.identification.windows import identify_windows
from baroarma.simulation import BMP085, Barometer, simulate_rest

NAMES = ("white_sd", "drift_rate", "correlated_sd", "correlation_time")
TRUTHS = {
    "white": NoiseModel(0, 0, 0.46, rate_hz=50),
    "white + drift": NoiseModel(0, 0, 0.46, 0.01, rate_hz=50),
    "white + GM": NoiseModel(0.27, 0.75, 0.46, rate_hz=50),
    "white + GM + drift (SG13)": BMP085.noise,
    "the same, drift 0.03": NoiseModel(0.27, 0.75, 0.46, 0.03, rate_hz=50),
    "weak GM: 0.05 m / 0.75 s": NoiseModel(0.05, 0.75, 0.46, 0.01, rate_hz=50),
    "GM + drift, no white": NoiseModel(0.27, 0.75, 0, 0.03, rate_hz=50),
}


def rest_problem(noise, seed):
    quantum = 0.0 if noise.white_sd == 0 else 1.0
    rest = simulate_rest(600, seed=seed, barometer=Barometer(noise, quantum))
    return Problem(rest.t, rest.height())


def forced(seed):
    problem = rest_problem(BMP085.noise, seed)
    fit = fit_terms(problem, ("white", "drift", "gm"))
    found = intervals(problem, fit)
    return fit.theta, [found[name] for name in NAMES]


def automatic(args):
    name, seed = args
    return name, select_terms(rest_problem(TRUTHS[name], seed))[0].terms


PAPERS_FILTER = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1).whitening_filter(
    rate_hz=50, unity_gain_hz=25
)
FILTERS = {
    "from the raw density": BMP085.noise.whitening_filter(),
    "the paper's, from 10 Hz": PAPERS_FILTER,
}


def windows_of(seed):
    """Tables of one recording for both splits, and its whitened surrogates for both filters."""
    rest = simulate_rest(600, seed=seed)
    t, height = rest.t, rest.height()
    tables = {split: identify_windows(t, height, split=split).table for split in ("exact", "bilinear")}
    return tables, {name: whitened_surrogate(t, height, w) for name, w in FILTERS.items()}


def print_windows(results):
    published = {  # SG13, Tables 1-2 (all twelve tests) and 3-4: mean of the rows' means and of their SDs
        "correlation_time": (0.807, 0.298),
        "correlated_sd": (0.271, 0.034),
        "white_sd": (0.239, 0.012),
        "total_sd": (0.345, 0.035),
    }
    print(f"\n### Windows recipe, {len(results)} recordings (conditioned, T = 0.1 s)\n")
    print("| quantity | SG13 Tables 1-2 | exact split | bilinear split (SG13's) |\n|---|---|---|---|")
    for name, (mean, sd) in published.items():
        cells = [
            f"{np.mean([r[0][split][name].mean for r in results]):.3f} ± "
            f"{np.mean([r[0][split][name].sd for r in results]):.3f}"
            for split in ("exact", "bilinear")
        ]
        print(f"| {name} | {mean:.3f} ± {sd:.3f} | {cells[0]} | {cells[1]} |")
    print("\n### Whitened surrogates: SG13 Tables 3-4 print sigma_u 0.22 ± 0.02, sigma_s 0.24 ± 0.02\n")
    print("| whitening filter | sigma_u | sigma_s | p > 0.1, one recording | p > 0.1, day of six |")
    print("|---|---|---|---|---|")
    for name in FILTERS:
        found = [r[1][name] for r in results]
        days = [found[i : i + 6] for i in range(0, len(found) - 5, 6)]
        one = 100 * np.mean([zero_pole_cancellation([s]).p > 0.1 for s in found])
        day = 100 * np.mean([zero_pole_cancellation(d).p > 0.1 for d in days])
        white = trimmed_mean([s.white_sd.mean for s in found])
        total = trimmed_mean([s.total_sd.mean for s in found])
        print(f"| {name} | {white.mean:.3f} | {total.mean:.3f} | {one:.0f} % | {day:.0f} % |")
    print("\nPerfectly white surrogates pass in 90 % by construction (p > 0.1).")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=300)
    seeds = range(parser.parse_args().seeds)
    forced(0)  # compile before the clock starts
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        start = time.perf_counter()
        results = list(pool.map(forced, seeds, chunksize=10))
        seconds = time.perf_counter() - start
        windows = list(pool.map(windows_of, seeds, chunksize=6))
        kept = list(pool.map(automatic, [(n, s) for n in TRUTHS for s in seeds], chunksize=10))
    theta, interval = np.array([r[0] for r in results]), np.array([r[1] for r in results])
    noise = BMP085.noise
    # what the raw samples really have: rounding to 1 Pa adds quantum^2/12 to the white variance
    truth = np.array([np.hypot(noise.white_sd, 0.0841 / 12**0.5), *(getattr(noise, n) for n in NAMES[1:])])
    bound = cramer_rao_bound(noise, 600)
    print(
        f"\n### Structural method, SG13's noise, {len(seeds)} recordings of 10 min at 50 Hz "
        f"({seconds:.0f} s)\n"
    )
    print("| parameter | truth | mean | bias | SD | Cramér-Rao | SD / bound | 95 % covers |")
    print("|---|---|---|---|---|---|---|---|")
    inside = (interval[..., 0] <= truth) & (truth <= interval[..., 1])
    for i, name in enumerate(NAMES):
        mean, sd = theta[:, i].mean(), theta[:, i].std(ddof=1)
        print(
            f"| {name} | {truth[i]:.4g} | {mean:.4g} | {100 * (mean / truth[i] - 1):+.2f} % | {sd:.2g} | "
            f"{bound[name]:.2g} | {sd / bound[name]:.2f} | {100 * inside[:, i].mean():.1f} % |"
        )
    print(f"\nPooled coverage: {100 * inside.mean():.1f} %.")
    print(f'\n### Terms that `terms="auto"` keeps, {len(seeds)} recordings each, percent\n')
    print("| truth | white | GM | drift | exactly the truth's |")
    print("|---|---|---|---|---|")
    for name, model in TRUTHS.items():
        terms = [set(t) for n, t in kept if n == name]
        right = {
            term
            for term, value in (
                ("white", model.white_sd),
                ("gm", model.correlated_sd),
                ("drift", model.drift_rate),
            )
            if value
        }
        share = [100 * np.mean([term in t for t in terms]) for term in ("white", "gm", "drift")]
        exact = 100 * np.mean([t == right for t in terms])
        print(f"| {name} | {share[0]:.0f} | {share[1]:.0f} | {share[2]:.0f} | {exact:.0f} |")
    print_windows(windows)


if __name__ == "__main__":
    main()
