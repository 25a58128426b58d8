"""The rule by which a reproduced number is judged against the published one.

    |reproduced - published| <= k * published SD,   k = 1: "within 1 SD",  k = 2: "within 2 SD"

and otherwise "differs: why".  The SD is the published one, not widened by our own standard error: a reader
can check it with two columns of the table.  Where the paper prints no SD, the number is one draw from what
repeating the run would give, and the SD of *our* trials stands in for it, or half a unit of the last printed
digit if that is more; for a number that is printed as "about", the tolerance in the data file, with its
reason.  A claim such as "p < 0.01" is met or not.

No number of ours is adjusted to any of this.  The reasons are sentences in ``published/reasons.csv``, written
after looking; a difference that nobody understands says "not explained".
"""

from __future__ import annotations

from baroarma.experiments.literature import Published, reason

UNKNOWN = "not explained"


def judge(number: Published, reproduced: float | None, reproduced_sd: float | None, trials: int) -> str:
    """Return the verdict on one number.

    Parameters
    ----------
    number : Published
        The published number.
    reproduced, reproduced_sd : float or None
        Mean over our trials and its SD.
    trials : int
        Number of trials.

    Examples
    --------
    >>> where = "sg14-table-2", "SG14", "Table 2", "A", "height RMSE (m)"
    >>> number = Published(*where, value=0.4, sd=0.15, rounding=0.005, tolerance=None, bound="", note="")
    >>> judge(number, 0.3, 0.1, 10), judge(number, 0.15, 0.1, 10), judge(number, 0.0, 0.1, 10)
    ('within 1 SD', 'within 2 SD', 'differs: not explained')
    """
    if reproduced is None:
        return "not judged: there is no result"
    if number.bound:
        return _judge_claim(number, reproduced, trials)
    assert number.value is not None
    yardstick = number.sd if number.sd is not None else number.tolerance
    if yardstick is None:
        yardstick = max(reproduced_sd or 0.0, number.rounding)
    distance = abs(reproduced - number.value)
    for k in (1, 2):
        if distance <= k * yardstick:
            return f"within {k} SD"
    return _differs(number)


def _judge_claim(number: Published, reproduced: float, trials: int) -> str:
    least = 2 / 2**trials  # of a two-sided signed-rank test
    limit = float(number.bound[1:])
    below = number.bound[0] == "<"
    if below and "Wilcoxon" in number.quantity and least > limit:
        return f"not judged: {trials} pairs cannot give p < {limit:g}; more trials can"
    met = reproduced < limit if below else reproduced > limit
    return f"agrees: published {number.bound}" if met else f"{_differs(number)} (published {number.bound})"


def _differs(number: Published) -> str:
    return f"differs: {reason(number.experiment, *number.key) or UNKNOWN}"
