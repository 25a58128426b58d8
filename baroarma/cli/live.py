"""What `baroarma track -` does: a row comes, its answer goes, and a plot beside it for who watches.

The answer to a row is written before the next one is read.  A row that can't be read is skipped and told: a
cable loses a byte now and then, and that must not end a flight.  The plot is drawn by a thread of its own, a
few times a second, on stderr's terminal; the thread that answers only hands it numbers, and waits for nobody.
"""

from __future__ import annotations

import math
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from threading import Lock
from typing import TYPE_CHECKING, Final

import click

from baroarma.atomic import replacing
from baroarma.cli.common import Refusal
from baroarma.cli.loudness import say
from baroarma.cli.skipped_rows import SkippedRows

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

    from baroarma.track import Track
    from baroarma.tracker import Tracker

Answer = tuple[float, ...]
"""A row of ``track.csv``: time, height, velocity and their standard deviations."""
REFRESH_HZ: Final = 5.0
"""How often the plot is drawn."""
WINDOW: Final = 20.0
"""Seconds that it shows, unless asked for others."""
MOST_ROWS: Final = 2000
"""Answers per window that are kept for it: no terminal has more columns of dots."""
FINAL_LINES: Final = 24
"""Lines of the drawing that stays behind."""


def track_live(tracker: Tracker, lines: Iterable[str], out: str | None, plot: LivePlot | None) -> None:
    """Answer each line of CSV before the next one is read, and say at the end how it went.

    Parameters
    ----------
    tracker : Tracker
        Of a preset that works on-line.
    lines : iterable of str
        The header first.
    out : str, optional
        File for the answers, which keeps those given, however the stream ends; default: stdout.
    plot : LivePlot, optional
        Is shown each answer.  On one terminal with stdout it takes the answers' place.

    Raises
    ------
    Refusal
        If the data don't support the request, or end within the alignment; at the end, if rows were skipped.
    UnreadableError
        If the header can't be understood or not one row can be read, or time goes backwards.
    """
    from baroarma.track import COLUMNS

    answer, count, failure = None, 0, None
    is_silent = plot is not None and sys.stdout.isatty()
    skipped = SkippedRows(is_told_late=plot is not None)
    with skipped, _writer(out, is_silent=is_silent) as write, plot or nullcontext():
        write(",".join(COLUMNS))
        try:
            for answer in _answers(tracker, lines, skipped):
                write(",".join(map(repr, answer)))
                count += 1
                if plot:
                    plot.take(answer)
        except (ValueError, Refusal, KeyboardInterrupt) as error:
            failure = error
        if answer is None:
            raise failure or Refusal("the rows ended within the first second, which aligns; send more")
    say(_summary(answer, count, skipped.count) + (f" -> {out}" if out else ""))
    if skipped.count:
        failure = failure or Refusal(skipped.summary())
    if failure:
        raise failure


def _summary(answer: Answer, count: int, skipped: int) -> str:
    t, height, velocity, height_sd, velocity_sd = answer
    rows = f"{count} rows answered" + (f", {skipped} skipped" if skipped else "")
    return (
        f"{rows}; at {t:.2f} s height {height:+.3f} m (sd {height_sd:.2g}), velocity "
        f"{velocity:+.3f} m/s (sd {velocity_sd:.2g})"
    )


def _answers(tracker: Tracker, lines: Iterable[str], skipped: SkippedRows) -> Iterator[Answer]:
    """Yield the answer to each row as soon as it has come; those of the alignment have none."""
    from baroarma.formats.rows import sample_reader

    last = math.nan
    for sample in sample_reader(lines, skipped):
        try:
            state = tracker.step(
                dt=sample.t - last, pressure=sample.pressure, accel=sample.accel, gyro=sample.gyro
            )
        except ValueError as error:
            raise Refusal(str(error)) from error
        last = sample.t
        if state is not None:
            yield (sample.t, *map(float, state[:4]))


@contextmanager
def _writer(out: str | None, *, is_silent: bool) -> Iterator[Callable[[str], object]]:
    """Give a function that brings a line to where it belongs, at once."""
    if out is not None:
        with (
            replacing(out) as temporary,
            open(temporary, "w", encoding="utf-8", newline="\n", buffering=1) as file,
        ):
            yield lambda line: file.write(line + "\n")
    else:
        yield (lambda line: None) if is_silent else click.echo


class LivePlot:
    """Show the last seconds on a terminal while the `with` block lasts, and leave the last drawing there.

    Parameters
    ----------
    console : Console
        rich's, of the terminal.
    window : float
        Seconds to show.
    """

    def __init__(self, console: Console, window: float = WINDOW) -> None:
        from rich.live import Live

        self._console, self._window = console, window
        self._answers: deque[Answer] = deque()
        self._lock = Lock()
        self._live = Live(
            console=console,
            screen=True,
            refresh_per_second=REFRESH_HZ,
            redirect_stdout=False,
            redirect_stderr=False,
            get_renderable=lambda: self.drawing(console.height),
        )

    def __enter__(self) -> None:
        self._live.start()

    def __exit__(self, *failure: object) -> None:
        self._live.stop()
        if self._answers:
            self._console.print(self.drawing(min(FINAL_LINES, self._console.height - 2)))

    def take(self, answer: Answer) -> None:
        """Add an answer; of those in quick succession the last stays, and none that has left the window."""
        t, kept = answer[0], self._answers
        with self._lock:
            if len(kept) > 1 and t - kept[-2][0] < self._window / MOST_ROWS:
                kept.pop()
            kept.append(answer)
            while kept[0][0] < t - self._window:
                kept.popleft()

    def drawing(self, height: int) -> Text:
        """Return what there is to see now, in so many lines."""
        from rich.text import Text

        from baroarma.cli.terminal_plot import draw, rows_of

        with self._lock:
            answers = tuple(self._answers)
        if not answers:
            return Text("waiting for rows; the first second, at rest, aligns")
        has_braille = not self._console.options.ascii_only
        return draw(
            rows_of(answers),
            width=self._console.width,
            height=height,
            span=self._window,
            has_braille=has_braille,
        )


def show_track(track: Track, console: Console, window: float | None) -> None:
    """Draw a finished track, or the last `window` seconds of it."""
    from baroarma.cli.terminal_plot import Rows, draw

    shown = slice(None if window is None else int(track.t.searchsorted(track.t[-1] - window)), None)
    columns = (track.t, track.height, track.velocity, track.height_sd, track.velocity_sd)
    console.print(
        draw(
            Rows(*(column[shown] for column in columns)),
            width=console.width,
            height=min(FINAL_LINES, console.height - 2),
            has_braille=not console.options.ascii_only,
        )
    )


def terminal() -> Console | None:
    """Return stderr's terminal; None, said in a sentence, if there is none that can be drawn on."""
    if sys.stderr.isatty():
        from rich.console import Console

        console = Console(stderr=True)
        if not console.is_dumb_terminal:
            return console
    say("stderr is no terminal to draw on, so there is no plot")
    return None
