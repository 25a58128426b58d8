"""What users type by name: listed in the help, completed by Tab, and when wrong, the nearest one told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    Parameter = click.ParamType[str]
else:  # older releases of click have no type arguments
    Parameter = click.ParamType


def _presets() -> tuple[str, ...]:
    from baroarma.presets import PRESETS

    return tuple(PRESETS)


def _attitudes() -> tuple[str, ...]:
    from baroarma.estimators.registry import attitude_names

    return attitude_names()


def _heights() -> tuple[str, ...]:
    from baroarma.estimators.registry import height_names

    return height_names()


def _motions() -> tuple[str, ...]:
    from baroarma.simulation import MOTIONS

    return tuple(MOTIONS)


def _devices() -> tuple[str, ...]:
    from baroarma.simulation import DEVICES

    return tuple(DEVICES)


def _experiments() -> tuple[str, ...]:
    from baroarma.experiments import experiments

    return (*experiments(), "all")


NAMES: Final[dict[str, Callable[[], tuple[str, ...]]]] = {
    "preset": _presets,
    "attitude estimator": _attitudes,
    "height estimator": _heights,
    "motion": _motions,
    "device": _devices,
    "experiment": _experiments,
}
"""What there is of each kind; looked up when the help is shown, when Tab is pressed, or to check a name."""
PLUG_INS: Final = ("attitude estimator", "height estimator")
"""Kinds that other packages add to; the registry itself says what is wrong with a name."""


class Name(Parameter):
    """A name of one kind.

    Parameters
    ----------
    kind : str
        A key of `NAMES`.
    metavar : str
        What stands in the help for one.
    or_file : bool
        Whether a file's name may stand there instead, so that nothing is checked here.
    """

    name = "name"

    def __init__(self, kind: str, metavar: str = "NAME", *, or_file: bool = False) -> None:
        self.kind, self.metavar, self.or_file = kind, metavar, or_file

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """Return what stands in the help."""
        return self.metavar

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name, or fail with those that there are."""
        if self.kind not in PLUG_INS and not self.or_file:
            check(self.kind, str(value))
        return str(value)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the names that begin so."""
        return _items(self.kind, incomplete) or ([CompletionItem(incomplete, type="file")] * self.or_file)


class Names(Name):
    """Names with commas between them."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return them as a tuple, each one once."""
        if isinstance(value, tuple):
            return value
        names = tuple(dict.fromkeys(name.strip() for name in value.split(",") if name.strip()))
        for name in names:
            check(self.kind, name)
        return names

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Complete the last one."""
        known, comma, last = incomplete.rpartition(",")
        return _items(self.kind, last, before=known + comma)


class Listing(click.Command):
    """A command whose help lists names, looked up only when asked.

    Parameters
    ----------
    lists : mapping of str to callable
        Heading -> function that returns the names, or a mapping of them to a few words each.
    """

    def __init__(self, *args: Any, lists: Mapping[str, Callable[[], Iterable[str]]], **options: Any) -> None:
        super().__init__(*args, **options)
        self.lists = lists

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the lists, and then the example."""
        for heading, look_up in self.lists.items():
            found = look_up()
            with formatter.section(heading):
                if isinstance(found, Mapping):
                    formatter.write_dl(list(found.items()))
                else:
                    formatter.write_text(", ".join(found))
        super().format_epilog(ctx, formatter)


def preset_titles() -> dict[str, str]:
    """Return the presets, each with what it is."""
    from baroarma.presets import PRESETS

    return {name: preset.title for name, preset in PRESETS.items()}


class InputFile(click.Path):
    """A file or folder to read; what is wrong with it is said by who reads it."""

    def __init__(self) -> None:
        super().__init__(allow_dash=True)


def check(kind: str, name: str) -> None:
    """Refuse a name that there isn't, and say which one is near.

    Raises
    ------
    click.UsageError
        With what there is.
    """
    names = NAMES[kind]()
    if name in names:
        return
    from difflib import get_close_matches

    close = get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    raise click.UsageError(f"there is no {kind} {name!r}; there are {', '.join(names)}{hint}")


def _items(kind: str, incomplete: str, before: str = "") -> list[CompletionItem]:
    return [CompletionItem(before + name) for name in NAMES[kind]() if name.startswith(incomplete)]
