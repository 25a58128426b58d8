"""Contents: whether a recording's values can be what their columns say, and whether its sensors were alive.

Each check is one function that returns its findings; `docs/faults.md` is their catalogue.  `read` makes all
of them; who builds a `Recording` by hand may pass it through `examined`.
"""

from __future__ import annotations

from baroarma.climb_evidence import climb_findings
from baroarma.finding import Finding
from baroarma.formats.units import imu_unit_findings, unit_findings
from baroarma.glance import busiest_part
from baroarma.recording import Recording
from baroarma.saturation import saturation_findings
from baroarma.spikes import drop_spikes
from baroarma.standstill import dead_barometer, stuck_axes
from baroarma.tilt_evidence import tilt_findings

Findings = tuple[Finding, ...]


def examined(recording: Recording) -> Recording:
    """Return the recording as `read` does: spikes blanked, and everything else that is wrong in its notes.

    Examples
    --------
    >>> import numpy as np
    >>> from dataclasses import replace
    >>> from baroarma.simulation import simulate
    >>> log = simulate("squat", duration=60, seed=1)
    >>> in_degrees = replace(log, gyro=np.rad2deg(log.gyro))
    >>> [(note.code, note.severity) for note in examined(in_degrees).notes]
    [('units', 'warning')]
    """
    recording = drop_spikes(recording)
    return recording.noting(*content_findings(recording))


def content_findings(recording: Recording) -> Findings:
    """Return what a recording's values say against it.

    Parameters
    ----------
    recording : Recording
        Its spikes and held samples already blanked, if it has any.

    Returns
    -------
    tuple of Finding
        Empty for an honest recording.

    Examples
    --------
    >>> from baroarma.simulation import simulate
    >>> content_findings(simulate("stairs", duration=30, seed=1))
    ()
    """
    units = unit_findings(recording)
    if any(finding.severity == "error" for finding in units):
        return units
    new = recording.is_new
    dead = tuple(dead_barometer(recording.t[new], recording.pressure[new], severity="warning"))
    busiest, wrong = busiest_part(recording), any(finding.severity == "warning" for finding in units)
    imu = _imu(recording, busiest, compare=not wrong)
    climb = () if dead or wrong or imu else tuple(climb_findings(busiest))
    return (*units, *dead, *imu, *climb)


def imu_findings(recording: Recording) -> Findings:
    """Return what accelerometer and gyro say against themselves, in a recording or a part of one."""
    units = imu_unit_findings(recording)
    return (*units, *_imu(recording, busiest_part(recording), compare=not units))


def _imu(recording: Recording, busiest: Recording, *, compare: bool) -> Findings:
    """Return the IMU's faults but for its units; where one is wrong, ranges and tilts tell nothing."""
    hung = stuck_axes(recording)
    if not compare:
        return tuple(hung)
    return (*hung, *saturation_findings(recording), *([] if hung else tilt_findings(busiest)))
