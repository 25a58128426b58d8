"""Recordings and tracks as xarray datasets: every variable with its unit and a name for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    import xarray

    from baroarma.recording import Recording
    from baroarma.track import Track

VARIABLES: Final[dict[str, tuple[str, ...]]] = {
    "pressure": ("Pa", "pressure"),
    "accel": ("m s-2", "specific force", "axis"),
    "gyro": ("rad s-1", "angular rate", "axis"),
    "temperature": ("degC", "temperature of the sensor"),
    "reference": ("m", "reference height, up"),
    "reference_velocity": ("m s-1", "reference velocity, up"),
    "reference_attitude": ("1", "reference attitude, body to world", "component"),
    "height": ("m", "height, up"),
    "velocity": ("m s-1", "vertical velocity, up"),
    "height_sd": ("m", "standard deviation of the height"),
    "velocity_sd": ("m s-1", "standard deviation of the velocity"),
    "acceleration": ("m s-2", "vertical acceleration, up"),
}
"""Unit (as UDUNITS and CF write it), name and second dimension of the signals of `Recording` and `Track`."""


def dataset(signals: Recording | Track, **attributes: Any) -> xarray.Dataset:
    """Return the signals as an xarray Dataset over time.

    Parameters
    ----------
    signals : Recording or Track
        What to convert; signals that are absent stay so.
    **attributes
        Attributes of the dataset beside its name.

    Returns
    -------
    xarray.Dataset
        Variables by the names of the fields, over ``t`` (s); vectors also over ``axis`` (x, y, z),
        quaternions over ``component`` (x, y, z, w).

    Raises
    ------
    ImportError
        If xarray is not installed.
    """
    try:
        import xarray
    except ImportError as error:
        raise ImportError("to_xarray needs xarray; pip install 'baroarma[xarray]'") from error
    described = {"units": "s", "long_name": "time"}
    found = xarray.Dataset(
        coords={"t": ("t", signals.t, described)}, attrs={"name": signals.name, **attributes}
    )
    for name, (unit, long_name, *more) in VARIABLES.items():
        values = getattr(signals, name, None)
        if values is not None and not callable(values):  # a recording's height is a method
            found[name] = (("t", *more), values, {"units": unit, "long_name": long_name})
            found = found.assign_coords({dim: list("xyzw"[: found.sizes[dim]]) for dim in more})
    return found
