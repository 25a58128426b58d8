"""How functions are compiled here: by numba, once, and again when anything they were made of has changed.

numba keeps what it has compiled beside the source, and compiles anew when the *file of the function* changes.
What that function takes from other files, called functions and constants, is compiled into it, and a change
there would go unnoticed.  `njit` here is numba's, but its cache is also asked for what was imported: for the
compiled functions' own stamps, which hold those of what *they* import; for the values of constants; for the
fields of named tuples.  So a kernel may be spread over files like any other code.

Import such things by name, not through their module, or they are not seen.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., Any])


def njit(**options: Any) -> Callable[[Function], Function]:
    """Compile a function with numba's options; with ``cache=True`` the cache notices changes in other files.

    Where numba keeps its stamp elsewhere (another version), the cache is as good as numba's own.
    """
    decorate = numba.njit(**options)

    def compiled(function: Function) -> Function:
        dispatcher: Function = decorate(function)
        if index := _index(dispatcher):
            index._source_stamp = _stamp(index._source_stamp, function.__globals__)
        return dispatcher

    return compiled


def _index(dispatcher: Any) -> Any:
    """Return the cache's index of a compiled function; None: it has none."""
    index = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    return index if hasattr(index, "_source_stamp") else None


def _stamp(own: object, names: Mapping[str, Any]) -> str:
    """Return one stamp for a file and all that its functions may have compiled in."""
    parts = [repr(own)]
    for name, value in names.items():
        if index := _index(value):
            parts.append(f"{name}: {index._source_stamp}")
        elif isinstance(value, float | int | str | tuple) and not name.startswith("__"):
            parts.append(f"{name}: {value!r}")
        elif isinstance(value, type) and issubclass(value, tuple):
            parts.append(f"{name}: {getattr(value, '_fields', ())}")
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


fused = njit(cache=True, fastmath={"contract"}, error_model="numpy")
"""Compile with a b + c in one rounding; nothing else that a NaN could notice."""
inlined = njit(cache=True, fastmath={"contract"}, error_model="numpy", inline="always")
"""Likewise what is put into the functions that call it."""


def as_array(values: ArrayLike) -> Array:
    """Return a copy in the one layout that is compiled for: floats, writeable, row after row."""
    return np.array(values, dtype=float, order="C")


def as_rows(values: ArrayLike, width: int = 0) -> Array:
    """Return the values as a read-only view, (n,) or (n, `width`), without a copy where that can be."""
    rows = np.ascontiguousarray(values, float)
    rows = rows.reshape(-1, width) if width else rows.view()
    rows.flags.writeable = False
    return rows
