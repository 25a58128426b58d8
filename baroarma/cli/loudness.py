"""How much is said on stderr: `--quiet`, `--verbose`, and what a command says beside its result.

Every command takes both, before or after its name.  ``--verbose`` shows what the library's modules log, in
the standard library's way, under the name ``baroarma``; nobody hears them otherwise.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import click

from baroarma import __version__

LOUDNESS: Final = "baroarma.loudness"
"""Where a running command keeps what was asked for: "quiet" or "verbose"."""


def loudness_options() -> list[click.Option]:
    """Return ``--quiet`` and ``--verbose``, for a command's parameters."""
    texts = {
        "quiet": "Say nothing on stderr but errors.",
        "verbose": "Say on stderr what is read, cleaned and decided, and when.",
    }
    return [
        click.Option([f"--{name}"], is_flag=True, expose_value=False, callback=_choose, help=text)
        for name, text in texts.items()
    ]


def _choose(context: click.Context, option: click.Parameter, is_chosen: bool) -> None:
    if not is_chosen:
        return
    assert option.name is not None
    before = context.meta.setdefault(LOUDNESS, option.name)
    if before != option.name:
        raise click.UsageError("--quiet and --verbose exclude each other", context)
    if option.name == "verbose" and not context.meta.get("baroarma.log"):
        context.meta["baroarma.log"] = True
        context.find_root().with_resource(_log_on_stderr())


@contextmanager
def _log_on_stderr() -> Iterator[None]:
    """Show what is logged while the command runs, with ms since the logging began."""
    import logging

    logger, handler = logging.getLogger("baroarma"), logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("%(relativeCreated)6.0f ms  %(name)s: %(message)s"))
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    logger.info("%s", versions())
    try:
        yield
    finally:
        logger.setLevel(before)
        logger.removeHandler(handler)


def versions() -> str:
    """Return the versions that a report of a fault needs, in one line."""
    from importlib.metadata import version

    names = ("numpy", "scipy", "numba", "filterpy", "statsmodels")
    parts = ", ".join(f"{name} {version(name)}" for name in names)
    return f"baroarma {__version__} (Python {sys.version.split()[0]}, {parts})"


def loudness() -> str:
    """Return "quiet", "verbose" or ""."""
    context = click.get_current_context(silent=True)
    return str(context.meta.get(LOUDNESS, "")) if context else ""


def say(message: str) -> None:
    """Tell the user something that is not the result."""
    if loudness() != "quiet":
        click.echo(message, err=True)


def say_next(*words: object) -> None:
    """Tell the command of `baroarma` that comes next, as a shell takes it."""
    say(f"next: baroarma {shlex.join(str(word) for word in words)}")


def is_watched() -> bool:
    """Return True if progress on stderr is seen, and disturbs nothing else there."""
    return sys.stderr.isatty() and not loudness()
