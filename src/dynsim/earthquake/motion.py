"""Motions of the ground as incremental dynamic analysis needs them: named, measured and scaled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats
from dynsim.loads.ground import Pulse, Record

Motion: TypeAlias = Record | Pulse
#: What `incremental` takes: motions by name, or motions alone.
Motions: TypeAlias = Mapping[str, Motion] | Sequence[Motion]

#: Standard acceleration of gravity in records and codes, whatever the gravity of the scene [m/s2].
G = 9.81
#: Intensity measures and their units.
MEASURES = {"pga": "g", "pgv": "m/s"}
#: Points at which a pulse is sampled; its peak is met to 1e-6 of it.
SAMPLES = 2001


def named_motions(records: Motions) -> dict[str, Motion]:
    """Return motions by name.

    Parameters
    ----------
    records : mapping of str to Record or Pulse, or sequence of them
        A sequence gets the names "record 1", "record 2" and so on.

    Returns
    -------
    dict of str to Record or Pulse
        In the order given.

    Raises
    ------
    InputError
        For none, and for what is neither a record nor a pulse.
    """
    if isinstance(records, (Record, Pulse)):
        records = [records]
    if not isinstance(records, Mapping):
        records = {f"record {number}": motion for number, motion in enumerate(records, start=1)}
    if not records:
        raise InputError("incremental: no records; at least one is needed")
    for name, motion in records.items():
        if not isinstance(motion, (Record, Pulse)):
            raise InputError(f'incremental: "{name}" is {motion!r}; what is scaled is a Record or a Pulse')
    return dict(records)


def intensity_of(motion: Motion, down: Floats, measure: str) -> float:
    """Return the intensity measure of a motion as it was recorded.

    Parameters
    ----------
    motion : Record or Pulse
        The motion.
    down : array of float, shape (3,)
        Gravity of the scene: components along it do not count.
    measure : str
        "pga", the largest length of the horizontal acceleration vector [g, 9.81 m/s2]; or "pgv", that of the horizontal
        velocity vector [m/s], integrated from rest without a correction of its baseline. It is taken at the points of
        the record and where an acceleration changes its sign.

    Returns
    -------
    float
        0 for a motion that is only vertical.

    Examples
    --------
    >>> from dynsim import Pulse
    >>> round(intensity_of(Pulse((2.943, 0, 4.0), 0.5, "sine"), np.array([0, 0, -9.81]), "pga"), 6)
    0.3
    """
    if isinstance(motion, Record):
        times, values = motion.times, motion.acceleration
    else:
        times = motion.start + np.linspace(0.0, motion.duration, SAMPLES)
        values = np.array([motion.at(time) for time in times])
    axis = np.asarray(down, dtype=float) / np.linalg.norm(down)
    level = values - np.outer(values @ axis, axis)
    if measure == "pga":
        return float(np.linalg.norm(level, axis=1).max()) / G
    # The velocity is largest where an acceleration changes its sign, between two points of the record.
    share = level[:-1] / np.where(level[:-1] == level[1:], np.inf, level[:-1] - level[1:])
    between = (times[:-1, None] + share * np.diff(times)[:, None])[(share > 0) & (share < 1)]
    whole = np.union1d(times, between)
    level = np.stack([np.interp(whole, times, column) for column in level.T], axis=1)
    gained = np.diff(whole)[:, None] * (level[1:] + level[:-1]) / 2
    return float(np.linalg.norm(np.cumsum(gained, axis=0), axis=1).max())


def scaled(motion: Motion, factor: float) -> Motion:
    """Return a motion with its accelerations multiplied; its duration stays.

    Parameters
    ----------
    motion : Record or Pulse
        The motion.
    factor : float
        The factor, above 0.

    Returns
    -------
    Record or Pulse
        Of the same kind.

    Examples
    --------
    >>> from dynsim import Pulse
    >>> scaled(Pulse((2.0, 0, 0), 1.0), 1.5).peak.tolist()
    [3.0, 0.0, 0.0]
    """
    if isinstance(motion, Record):
        return replace(motion, acceleration=factor * motion.acceleration)
    return replace(motion, peak=factor * np.asarray(motion.peak, dtype=float))
