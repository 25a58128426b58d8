"""How far a track went up and down: the result of `climb`."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Signal = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Climb:
    """Hold how far a track went up and down.

    Parameters
    ----------
    ascent, descent : float
        Sums of the swings up and down, m, both positive.
    ascent_sd, descent_sd : float
        Their standard deviations, m.
    floors_up, floors_down : int
        Floors climbed and descended.
    t, height : ndarray, shape (m,)
        Times in s and heights in m of the turning points, the first and last extreme among them; none when
        nothing moved.  What goes up between them is the ascent, what goes down the descent.
    name : str
        Name of the recording.

    Examples
    --------
    Up a stair of 3 m, down by half of it, up to 4 m; the ripple of 5 cm is no climbing:

    >>> from baroarma.climbing import climb
    >>> from baroarma.track import Track
    >>> t = np.linspace(0, 60, 601)
    >>> height = np.interp(t, [0, 20, 40, 60], [0, 3, 1.5, 4]) + 0.05 * np.sin(10 * t)
    >>> found = climb(Track(t, height, np.zeros(601), *np.full((2, 601), 0.05), np.zeros(601)), threshold=0.5)
    >>> round(found.ascent, 1), round(found.descent, 1)  # 3 + 2.5 and 1.5, and the ripple at the turns
    (5.6, 1.6)
    >>> found.t.round().tolist()
    [0.0, 20.0, 40.0, 60.0]
    """

    ascent: float
    descent: float
    ascent_sd: float
    descent_sd: float
    floors_up: int
    floors_down: int
    t: Signal
    height: Signal
    name: str = ""

    def __repr__(self) -> str:
        return (
            f"<Climb of {self.name!r}: up {self.ascent:.2f} ± {self.ascent_sd:.2f} m, down "
            f"{self.descent:.2f} ± {self.descent_sd:.2f} m, floors {self.floors_up} up, {self.floors_down} "
            "down>"
        )

    def summary(self) -> str:
        """Return the result as a sentence."""
        swings = len(self.t) - 1
        turns = f"in {swings} swing" + "s" * (swings > 1) if swings > 0 else "without a swing"
        return (
            f"climbs {self.ascent:.2f} m (sd {self.ascent_sd:.2g}), descends {self.descent:.2f} m (sd "
            f"{self.descent_sd:.2g}) {turns}; floors: {self.floors_up} up, {self.floors_down} down"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object: metres, floors, and the turning points as lists."""
        return {
            "ascent_m": self.ascent,
            "ascent_sd_m": self.ascent_sd,
            "descent_m": self.descent,
            "descent_sd_m": self.descent_sd,
            "floors_up": self.floors_up,
            "floors_down": self.floors_down,
            "turning_points": {"time_s": self.t.tolist(), "height_m": self.height.tolist()},
        }

    def _repr_html_(self) -> str:
        up = ("up", self.ascent, self.ascent_sd, self.floors_up)
        down = ("down", self.descent, self.descent_sd, self.floors_down)
        body = "".join(
            f"<tr><th>{word}</th><td>{metres:.2f}</td><td>{sd:.2f}</td><td>{floors}</td></tr>"
            for word, metres, sd, floors in (up, down)
        )
        head = "<tr><th></th><th>m</th><th>sd m</th><th>floors</th></tr>"
        return f"<table><caption>{escape(self.name)}</caption>{head}{body}</table>"

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the swings; see `baroarma.plotting.climb.plot_climb`."""
        from baroarma.plotting.climb import plot_climb

        return plot_climb(self, ax)
