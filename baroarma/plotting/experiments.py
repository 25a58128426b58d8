"""Plot of an experiment: the published numbers beside the reproduced ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from baroarma.plotting.canvas import DATA, finish, ink, legend_text, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from baroarma.experiments.result import Result, Row

COLUMNS: Final = 3
"""Most panels beside each other."""


def plot_result(result: Result, figure: Figure | None = None) -> Figure:
    """Draw each quantity of an experiment, a line per row: published and ours, with their SDs.

    p-values stay in the table: there the question is on which side of 0.05 they lie, not by how much.

    Parameters
    ----------
    result : Result
        What an experiment returned.
    figure : matplotlib.figure.Figure, optional
        Where to draw; default: a new pyplot figure.

    Returns
    -------
    matplotlib.figure.Figure
        An axes per quantity, those with most rows first.

    Raises
    ------
    ValueError
        If the experiment has p-values only.

    Examples
    --------
    >>> from baroarma.experiments.result import Result, Row
    >>> row = Row("Method A", "height RMSE (m)", 0.40, 0.15, 0.37, 0.12, 10, "within 1 SD")
    >>> [ax.get_xlabel() for ax in plot_result(Result("sg14-table-2", "walks", (), (row,))).axes]
    ['height RMSE (m)']
    """
    panels: dict[str, list[Row]] = {}
    for row in result.rows:
        if not row.quantity.endswith("(p)"):
            panels.setdefault(row.quantity, []).append(row)
    if not panels:
        raise ValueError(f"{result.experiment} has p-values only, which the table shows best (summary)")
    tall_first = sorted(panels.items(), key=lambda panel: -len(panel[1]))
    across = min(len(panels), COLUMNS)
    heights = [1.0 + 0.3 * len(rows) for _, rows in tall_first[::across]]
    figure = figure or new_figure(1.5 + 3.7 * across, 0.8 + sum(heights))
    axes = figure.subplots(len(heights), across, squeeze=False, height_ratios=heights)
    for ax, (quantity, rows) in zip(axes.ravel(), tall_first, strict=False):
        _draw(ax, quantity, rows)
    for ax in axes.ravel()[len(panels) :]:
        ax.remove()
    figure.suptitle(f"{result.experiment}: {result.title}", parse_math=False, fontsize="large")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return figure


def _draw(ax: Axes, quantity: str, rows: list[Row]) -> None:
    for offset, name, style in ((-0.15, "published", _published()), (0.15, "reproduced", OURS)):
        known = [(i, row) for i, row in enumerate(rows) if getattr(row, name) is not None]
        values = [getattr(row, name) for _, row in known]
        sds = [getattr(row, f"{name}_sd") or 0.0 for _, row in known]
        at = [i + offset for i, _ in known]
        ax.errorbar(values, at, xerr=sds, capsize=2, markersize=4, elinewidth=1, **style)
    ax.set_yticks(range(len(rows)), [legend_text(row.label) for row in rows], fontsize="small")
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.locator_params(axis="x", nbins=5)
    finish(ax, "", quantity, "")


OURS: Final[dict[str, Any]] = {"fmt": "o", "color": DATA, "label": "ours"}


def _published() -> dict[str, Any]:
    return {"fmt": "s", "color": ink(), "markerfacecolor": "none", "label": "published"}
