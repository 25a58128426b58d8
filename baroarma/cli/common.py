"""What the commands share: options, reading, writing, progress."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from baroarma.atomic import replacing
from baroarma.cli.loudness import is_watched, say
from baroarma.cli.names import InputFile

if TYPE_CHECKING:
    from baroarma.recording import Recording

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")


class OutputFile(click.Path):
    """A file to write, refused before any work is done if that can't succeed."""

    def __init__(self) -> None:
        super().__init__(dir_okay=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the path, or fail with a sentence."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        if not path.parent.is_dir():
            self.fail(f"{path}: there is no folder {path.parent}; make it first", param, ctx)
        if not os.access(path.parent, os.W_OK):
            self.fail(f"{path}: the folder {path.parent} can't be written to", param, ctx)
        return str(path)


class Refusal(Exception):  # noqa: N818 -- the program works; it is the data that refuse
    """The data don't support the request: exit code 1."""


def json_option(command: F) -> F:
    """Add ``--json``."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")(command)


def recordings_argument(command: F) -> F:
    """Add the files, ``--map``, ``--start`` and ``--stop``."""
    for decorate in (
        click.option("--stop", type=float, metavar="S", help="Use the rows before this time, in s."),
        click.option("--start", type=float, metavar="S", help="Use the rows from this time on, in s."),
        click.option(
            "--map",
            "mapping",
            multiple=True,
            metavar="COLUMN=NAME",
            help="Say what the file calls a column, such as pressure_pa=BaroPress (repeatable).",
        ),
        click.argument("files", nargs=-1, required=True, type=InputFile(), metavar="RECORDING..."),
    ):
        command = decorate(command)
    return command


def noise_option(*, is_required: bool = False) -> Callable[[F], F]:
    """Add ``--noise``."""
    return click.option(
        "--noise",
        "noise_file",
        type=InputFile(),
        required=is_required,
        metavar="N.json",
        help="Noise model that `baroarma identify` wrote.",
    )


def read_recordings(
    files: Sequence[str], mapping: Sequence[str], start: float | None, stop: float | None
) -> list[Recording]:
    """Read the files; one with pressure starts a recording, those without belong to the one before."""
    from baroarma.formats import read_all

    with busy(f"reading {', '.join(files)}"):
        recordings = read_all(files, mapping=pairs(mapping))
    if start is None and stop is None:
        return recordings
    cut = [recording.between(*span(start, stop)) for recording in recordings]
    for recording in cut:
        if not len(recording):
            raise click.UsageError(f"{recording.name} has no rows from {start} s to {stop} s")
    return cut


def same_recordings(
    files: Sequence[str], mapping: Sequence[str], start: float | None, stop: float | None
) -> list[str]:
    """Return the words that ask another command for the same recordings."""
    words = [*files, *(word for pair in mapping for word in ("--map", pair))]
    for option, seconds in (("--start", start), ("--stop", stop)):
        words += [] if seconds is None else [option, repr(seconds)]
    return words


def span(start: float | None, stop: float | None) -> tuple[float, float]:
    """Return ``--start`` and ``--stop`` as times, in s."""
    return -math.inf if start is None else start, math.inf if stop is None else stop


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a file complete or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def print_json(value: object) -> None:
    """Print one JSON document; NaN in it is a bug, not an output."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def with_progress(items: Iterable[T], total: int, what: str) -> Iterator[T]:
    """Iterate with a progress bar on stderr, or a line for one item, if there is a terminal to see it."""
    if total < 2 or not is_watched():
        with busy(what):
            yield from items
        return
    from rich.console import Console
    from rich.progress import track

    console = Console(stderr=True)
    tracked: Iterable[T] = track(items, description=what, total=total, console=console, transient=True)
    yield from tracked


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """Give a function of how much is done, and how much there is, which shows it on a terminal's stderr."""
    if not is_watched():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bars:
        bar = bars.add_task(what, total=None)
        yield lambda done, total: bars.update(bar, completed=done, total=total)


@cache
def announce_compiling() -> object:
    """Say once when something is compiled, which happens on first use after installation or a change.

    Returns numba's listener, for who wants to unregister it.
    """
    from numba.core import event

    class Announcer(event.Listener):
        def on_start(self, event_: object) -> None:
            if not said:
                said.append(True)
                say("baroarma: compiling for this machine, once; later calls start at once")

        def on_end(self, event_: object) -> None:
            pass

    said: list[bool] = []
    listener = Announcer()
    event.register("numba:compile", listener)  # type: ignore[no-untyped-call]
    return listener


def jobs_option(command: F) -> F:
    """Add ``--jobs``."""
    text = "Processes that share several recordings."
    return click.option(
        "--jobs", type=click.IntRange(1), default=1, show_default=True, metavar="N", help=text
    )(command)


def busy(what: str) -> AbstractContextManager[object]:
    """Show on stderr what takes a while, until it is done, if there is a terminal to see it."""
    if not is_watched():
        return nullcontext()
    from rich.console import Console
    from rich.markup import escape

    return Console(stderr=True).status(escape(what))


def pairs(mapping: Sequence[str]) -> dict[str, str] | None:
    """Return our column name -> the file's; None without any."""
    found = dict(pair.split("=", 1) for pair in mapping if "=" in pair)
    if len(found) != len(mapping):
        raise click.UsageError(f"--map takes COLUMN=NAME once per column, but got {', '.join(mapping)}")
    return found or None
