"""What stands in a `noise.json`: bounded, checked key by key, and said in a sentence where it is wrong.

Files of every version that was ever written stay readable; a version from the future asks for an update.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from typing import Any, Final, NoReturn, get_args

from baroarma.finding import Finding, Severity

FORMAT: Final = "baroarma.noise-model"
VERSION: Final = 1
LARGEST: Final = 1 << 20
"""Bytes of a file; a noise model takes two thousand."""


def read_object(path: str | os.PathLike[str]) -> Any:
    """Return the JSON document in a file.

    Parameters
    ----------
    path : str or path
        A file or a pipe; no more than `LARGEST` bytes of it are read.

    Raises
    ------
    ValueError
        If it is no JSON, has a key twice or a number that isn't finite, or is too large.
    """
    with open(path, "rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(
            f"{path} is larger than {LARGEST} bytes; it can't be a noise model, name another file"
        )
    try:
        return json.loads(content.decode("utf-8-sig"), object_pairs_hook=_unique, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise ValueError(
            f"{path} is no JSON ({reason}); `baroarma identify --out` writes noise models"
        ) from error


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"the key {max(names, key=names.count)[:40]!r} stands there twice")
    return found


def _refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number")


def model_fields(data: Any, keys: Mapping[str, str]) -> dict[str, Any]:
    """Return what the document says as arguments of `NoiseModel`, each of the right kind.

    Parameters
    ----------
    data : object
        The document.
    keys : mapping of str to str
        JSON keys of the parameters -> the model's names for them.

    Raises
    ------
    ValueError
        If the format, the version or a value is not as documented; the message names it.

    Examples
    --------
    >>> model_fields({"format": "baroarma.noise-model", "version": 3}, {})
    Traceback (most recent call last):
    ...
    ValueError: version 3 was written by a newer baroarma; update: pip install --upgrade baroarma
    """
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise ValueError(f'this is no noise model: the key "format" must be "{FORMAT}"')
    _refuse_version(data.get("version"))
    if missing := [key for key in (*keys, "rate_hz") if key not in data]:
        needed = ", ".join((*keys, "rate_hz"))
        raise ValueError(f"this noise model lacks the key {missing[0]!r}; it needs {needed}")
    found = {name: _number(key, data[key]) for key, name in {**keys, "rate_hz": "rate_hz"}.items()}
    return {
        **found,
        "ci95": _optional(data, "ci95", lambda value: _intervals(value, keys)),
        "method": _text("method", data.get("method", "by hand")),
        "sensor": _text("sensor", data.get("sensor", "")),
        "verdict": tuple(_finding(finding) for finding in _kind("verdict", data.get("verdict", []), list)),
        "whiteness_p": _optional(data, "whiteness_p", _numbers),
        "source": _optional(data, "source", lambda value: _kind("source", value, dict)),
    }


def _refuse_version(version: Any) -> None:
    if isinstance(version, bool) or not isinstance(version, int) or version < 1:
        raise ValueError(f"there is no version {version!r:.40} of noise models; the file must say {VERSION}")
    if version > VERSION:
        raise ValueError(
            f"version {version!s:.40} was written by a newer baroarma; update: pip install --upgrade baroarma"
        )


def _optional(data: dict[str, Any], key: str, convert: Callable[[Any], Any]) -> Any:
    value = data.get(key)
    return None if value is None else convert(value)


def _kind(key: str, value: Any, kind: type) -> Any:
    if not isinstance(value, kind):
        names: dict[type, str] = {dict: "an object", list: "a list", str: "a text"}
        raise ValueError(f"{key} is of the wrong kind: {value!r:.60} is not {names[kind]}")
    return value


def _text(key: str, value: Any) -> str:
    return str(_kind(key, value, str))


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{key} is of the wrong kind: {value!r:.60} is not a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{key} must be finite, but it is {number}")
    return number


def _numbers(value: Any) -> dict[str, float]:
    return {key: _number(f"whiteness_p {key}", p) for key, p in _kind("whiteness_p", value, dict).items()}


def _intervals(value: Any, keys: Mapping[str, str]) -> dict[str, tuple[float, float]]:
    if missing := [key for key in keys if key not in _kind("ci95", value, dict)]:
        raise ValueError(f"ci95 lacks the key {missing[0]!r}")
    return {name: _interval(f"ci95 of {key}", value[key]) for key, name in keys.items()}


def _interval(key: str, value: Any) -> tuple[float, float]:
    if len(_kind(key, value, list)) != 2:
        raise ValueError(f"{key} is of the wrong kind: it needs two numbers, but has {len(value)}")
    low, high = (_number(key, end) for end in value)
    if not 0 <= low <= high:
        raise ValueError(f"{key} must be [low, high] with 0 <= low <= high, but it is [{low:g}, {high:g}]")
    return low, high


def _finding(value: Any) -> Finding:
    parts = {key: _text("a finding's " + key, _kind("verdict", value, dict).get(key)) for key in FINDING}
    if parts["severity"] not in get_args(Severity):
        raise ValueError(f"a finding's severity is {parts['severity']!r:.40}; it is info, warning or error")
    return Finding(**parts)  # type: ignore[arg-type]


FINDING: Final = ("code", "severity", "message")
