"""Which order?  Every ARMA(p, q) up to some order, compared by FPE, AIC and BIC [SG13, Sec. 2.5]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from baroarma.identification.arma_fit import ArmaFit, fit_arma

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, repr=False)
class OrderTable:
    """Hold the fits of all orders up to (max_p, max_q), by order.

    Parameters
    ----------
    fits : dict of (int, int) to ArmaFit
        The fits by (p, q).

    Examples
    --------
    >>> from baroarma import ArmaModel
    >>> sg13 = ArmaModel(ar=(-0.86,), ma=(-0.52,), sd=0.2746, dt=0.1)
    >>> table = order_table(sg13.simulate(600, rng=1), 0.1, max_p=1, max_q=1)
    >>> table
    <OrderTable of 4 ARMA orders, best by FPE (1, 1), AIC (1, 1), BIC (1, 1)>
    >>> table.fits[1, 1].fpe < table.fits[1, 0].fpe < table.fits[0, 0].fpe
    True
    """

    fits: dict[tuple[int, int], ArmaFit]

    def __repr__(self) -> str:
        best = ", ".join(f"{name.upper()} {self.best(name)}" for name in ("fpe", "aic", "bic"))
        return f"<OrderTable of {len(self.fits)} ARMA orders, best by {best}>"

    def best(self, criterion: str = "fpe") -> tuple[int, int]:
        """Return the order with the smallest ``"fpe"``, ``"aic"`` or ``"bic"``.

        Raises
        ------
        ValueError
            For another criterion.
        """
        if criterion not in ("fpe", "aic", "bic"):
            raise ValueError(f"criterion {criterion!r} is unknown; choose 'fpe', 'aic' or 'bic'")
        return min(self.fits, key=lambda order: float(getattr(self.fits[order], criterion)))

    def summary(self) -> str:
        """Return a table with one row per order; a star marks the smallest of each column."""
        lines = [f"{'order':8}{'FPE, m²':>13}{'AIC':>12}{'BIC':>12}"]
        for order, fit in self.fits.items():
            cells = [
                f"{getattr(fit, name):.{digits}f}{'*' if self.best(name) == order else ' '}"
                for name, digits in (("fpe", 6), ("aic", 2), ("bic", 2))
            ]
            end = "" if fit.converged else "   did not converge"
            lines.append(f"{order!s:8}{cells[0]:>13}{cells[1]:>12}{cells[2]:>12}{end}")
        return "\n".join(lines)

    def to_frame(self) -> pd.DataFrame:
        """Return the table as a pandas DataFrame, a row per order."""
        import pandas as pd

        return pd.DataFrame(
            [
                {"p": p, "q": q, "fpe_m2": f.fpe, "aic": f.aic, "bic": f.bic, "converged": f.converged}
                for (p, q), f in self.fits.items()
            ]
        )

    def _repr_html_(self) -> str:
        from baroarma.notebook import tables
        from baroarma.page import Table

        rows = []
        for order, fit in self.fits.items():
            cells = (("fpe", 6), ("aic", 2), ("bic", 2))
            texts = [f"{getattr(fit, c):.{d}f}{' *' * (self.best(c) == order)}" for c, d in cells]
            rows.append((str(order), *texts, "" if fit.converged else "did not converge"))
        head = ("order (p, q)", "FPE (m²)", "AIC", "BIC", "")
        return tables(Table(head, tuple(rows), "ARMA orders; * smallest of its column"))


def order_table(y: ArrayLike, dt: float, max_p: int = 3, max_q: int = 3) -> OrderTable:
    """Fit every ARMA(p, q) up to (max_p, max_q) to one series and compare them.

    SG13 defends ARMA(1,1) by Akaike's final prediction error.  Slow: one statsmodels fit per order.

    Parameters
    ----------
    y : array_like, shape (n,)
        Detrended heights in m, one every `dt` seconds.
    dt : float
        Sampling interval, s.
    max_p, max_q : int
        Largest orders.

    Returns
    -------
    OrderTable
        (max_p + 1)(max_q + 1) fits.

    Examples
    --------
    >>> from baroarma import ArmaModel
    >>> wander = ArmaModel(ar=(-0.9,), ma=(), sd=0.1, dt=0.1).simulate(600, rng=1)
    >>> order_table(wander, 0.1, max_p=1, max_q=1).best("bic")
    (1, 0)
    """
    orders = [(p, q) for p in range(max_p + 1) for q in range(max_q + 1)]
    return OrderTable({order: fit_arma(y, dt, order) for order in orders})
