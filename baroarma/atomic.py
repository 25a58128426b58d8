"""Files that are complete or not there."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

_COUNT = count()


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside `path`, and put what was written there in its place at the end.

    If the block fails, an older file stays as it was and nothing new is left.  A process that is killed may
    leave its temporary file, ``.baroarma-NUMBER-NUMBER.tmp``.  Of several writers the last one wins.  A link
    stays a link; a device or a pipe stays what it is and gets all that was written, at the end.

    Raises
    ------
    ValueError
        If the folder does not exist.
    OSError
        If the disk is full or the like; it names `path`.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with replacing(folder / "a.txt") as temporary:
    ...     _ = temporary.write_text("done")
    >>> [(p.name, p.read_text()) for p in folder.iterdir()]
    [('a.txt', 'done')]
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise ValueError(f"{target}: there is no folder {target.parent}; make it first")
    write = _through if target.exists() and not target.is_file() else _beside
    try:
        with write(target) as temporary:
            yield temporary
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(temporary)):
            raise
        reason = f"the file can't be written ({os.strerror(error.errno)}); make room, or write elsewhere"
        raise OSError(error.errno, reason, str(target)) from error


@contextmanager
def _beside(target: Path) -> Iterator[Path]:
    place = Path(os.path.realpath(target))
    temporary = place.with_name(f".baroarma-{os.getpid()}-{next(_COUNT)}.tmp")
    try:
        yield temporary
        if place.exists():
            shutil.copymode(place, temporary)
        temporary.replace(place)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def _through(target: Path) -> Iterator[Path]:
    """Replacing a device would remove it: fill it."""
    with tempfile.TemporaryDirectory() as folder:
        temporary = Path(folder) / "whole"
        yield temporary
        with temporary.open("rb") as whole, target.open("wb") as device:
            shutil.copyfileobj(whole, device)
