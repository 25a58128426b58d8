"""What averages of growing length do to the noise, and to its ARMA(1,1) [SG13, Sec. 3.1, Fig. 5]."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from baroarma.arma import Split
from baroarma.identification.arma_fit import fit_windows
from baroarma.identification.preprocessing import (
    Trimmed,
    WindowSettings,
    condition,
    new_samples,
    trimmed_mean,
)
from baroarma.identification.whiteness import whiteness_of_windows

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class AveragingRow:
    """One length of the moving average in the study of SG13, Fig. 5; sds in m.

    Parameters
    ----------
    average : int
        M, samples.
    total_sd, correlated_sd, white_sd : Trimmed
        Trimmed mean and SD over windows, m.
    theory_white_sd : float
        What 1/sqrt(M) makes of the white sd of the first row, m.
    bartlett_failures, ljung_box_failures : float
        Share of the windows that the test rejects at 5 %.
    outside : float
        Share of the windows whose coefficients are no Gauss-Markov plus white noise.

    Examples
    --------
    >>> from baroarma import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> row = averaging_study(np.arange(15000) / 50, noise.simulate(15000, 1), averages=(4,)).rows[0]
    >>> round(row.white_sd.mean, 2), row.outside  # 0.46 m/sqrt(4) = 0.23 m, in windows of 300 samples 4 % low
    (0.22, 0.0)
    """

    average: int
    total_sd: Trimmed
    correlated_sd: Trimmed
    white_sd: Trimmed
    theory_white_sd: float
    """What 1/sqrt(M) makes of the white sd of the first row."""
    bartlett_failures: float
    """Fraction of windows that Bartlett's test rejects at 5 %."""
    ljung_box_failures: float
    outside: float
    """Fraction of windows whose coefficients are no Gauss-Markov plus white noise."""


@dataclass(frozen=True, repr=False)
class AveragingStudy:
    """Hold what averages of growing length do to the noise [SG13, Fig. 5].

    Parameters
    ----------
    rows : tuple of AveragingRow
        One per length.

    Examples
    --------
    >>> from baroarma import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> study = averaging_study(np.arange(15000) / 50, noise.simulate(15000, 1), averages=(1, 4, 16))
    >>> study
    <AveragingStudy of M = 1, 4, 16 samples>
    >>> first, second, _ = study.to_frame()["theory_white_sd_m"]
    >>> round(first / second, 9)  # sqrt(4/1)
    2.0
    """

    rows: tuple[AveragingRow, ...]

    def __repr__(self) -> str:
        return f"<AveragingStudy of M = {', '.join(str(row.average) for row in self.rows)} samples>"

    def summary(self) -> str:
        """Return a table with one row per length M."""
        lines = [
            "  M   sigma_s   sigma_c   sigma_u   1/sqrt(M)   Bartlett   Ljung-Box   outside",
            "           m         m         m           m   rejects     rejects",
        ]
        lines += [
            f"{r.average:3d}{r.total_sd.mean:10.3f}{_cell(r.correlated_sd)}{_cell(r.white_sd)}"
            f"{r.theory_white_sd:12.3f}{r.bartlett_failures:10.0%}{r.ljung_box_failures:12.0%}{r.outside:10.0%}"
            for r in self.rows
        ]
        return "\n".join(lines)

    def to_frame(self) -> pd.DataFrame:
        """Return the table as a pandas DataFrame, a row per length."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "average": r.average,
                    "total_sd_m": r.total_sd.mean,
                    "correlated_sd_m": r.correlated_sd.mean,
                    "white_sd_m": r.white_sd.mean,
                    "theory_white_sd_m": r.theory_white_sd,
                    "bartlett_failures": r.bartlett_failures,
                    "ljung_box_failures": r.ljung_box_failures,
                    "outside": r.outside,
                }
                for r in self.rows
            ]
        )

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        rows = []
        for r in self.rows:
            sds = (r.total_sd.mean, r.correlated_sd.mean, r.white_sd.mean, r.theory_white_sd)
            shares = (r.bartlett_failures, r.ljung_box_failures, r.outside)
            cells = ("–" if sd != sd else f"{sd:.3f}" for sd in sds)
            rows.append((str(r.average), *cells, *(f"{share:.0%}" for share in shares)))
        head = (
            "M",
            "total sd (m)",
            "Gauss-Markov sd (m)",
            "white sd (m)",
            "white by 1/√M (m)",
            "Bartlett rejects",
            "Ljung-Box rejects",
            "outside",
        )
        return tables(Table(head, tuple(rows), "Averages of M samples; shares of windows"))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the sds over the length; see `baroarma.plotting.plot_averaging`."""
        from baroarma.plotting import plot_averaging

        return plot_averaging(self, ax)


def _cell(found: Trimmed) -> str:
    """Return a mean for the table; a dash where no window had the component."""
    return "-".rjust(10) if math.isnan(found.mean) else f"{found.mean:10.3f}"


def averaging_study(
    t: ArrayLike,
    height: ArrayLike,
    averages: Sequence[int] = (1, 2, 4, 8, 16, 32, 64, 128, 256),
    settings: WindowSettings | None = None,
    *,
    split: Split = "exact",
) -> AveragingStudy:
    """Repeat the identification with moving averages of growing length [SG13, Sec. 3.1, Fig. 5].

    Averages longer than the decimation put their own shape into the data, which an ARMA(1,1) cannot follow:
    the whiteness tests reject and the coefficients leave the region of Gauss-Markov plus white noise.

    Parameters
    ----------
    t, height : array_like, shape (n,)
        Times in s and heights in m of new samples at rest.
    averages : sequence of int
        Lengths M of the moving average in raw samples.
    settings : WindowSettings, optional
        The other settings; default: those for the rate.
    split : {"exact", "bilinear"}
        How coefficients become components.

    Returns
    -------
    AveragingStudy
        A row per length.

    Raises
    ------
    ValueError
        If no gap-free window is left.

    Examples
    --------
    After averages of 16 samples no window is one of Gauss-Markov plus white noise any more; after those of 4,
    as SG13 has it, each is:

    >>> from baroarma import NoiseModel
    >>> noise = NoiseModel(correlated_sd=0.27, correlation_time=0.75, white_sd=0.46, rate_hz=50)
    >>> study = averaging_study(np.arange(15000) / 50, noise.simulate(15000, 1), averages=(4, 16))
    >>> [row.outside for row in study.rows], [row.ljung_box_failures for row in study.rows]
    ([0.0, 1.0], [0.0, 1.0])
    """
    t, height = new_samples(t, height)
    settings = settings or WindowSettings.for_rate(1 / float(np.median(np.diff(t))))
    rows: list[AveragingRow] = []
    for m in averages:
        cut = condition(t, height, replace(settings, average=m))
        if not len(cut.windows):
            raise ValueError(f"the recording has no gap-free window left after an average of {m} samples")
        fits = fit_windows(cut.windows, cut.dt, split)
        white = trimmed_mean(fits.white_sd, settings.trim)
        first = (rows[0].theory_white_sd * math.sqrt(rows[0].average)) if rows else white.mean * math.sqrt(m)
        bartlett, ljung = whiteness_of_windows(fits)
        rows.append(
            AveragingRow(
                average=m,
                total_sd=trimmed_mean(fits.total_sd, settings.trim),
                correlated_sd=trimmed_mean(fits.correlated_sd, settings.trim),
                white_sd=white,
                theory_white_sd=first / math.sqrt(m),
                bartlett_failures=float(np.mean(bartlett < 0.05)),
                ljung_box_failures=float(np.mean(ljung < 0.05)),
                outside=float(np.mean(~fits.inside)),
            )
        )
    return AveragingStudy(tuple(rows))
