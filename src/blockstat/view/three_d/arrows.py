"""Joint forces and the thrust on the supports as arrows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.typing import Floats
from blockstat.view.plot import joint_resultants, resultants

if TYPE_CHECKING:
    from blockstat.analysis.verdict import Verdict

FORCE = (178, 24, 43)
TORN = (33, 102, 172)
THRUST = (90, 20, 110)
#: Length of the longest arrow and radius of all shafts, relative to the extent of the free blocks.
REACH, RADIUS = 0.16, 0.0025


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows of one colour."""

    name: str
    tail: Floats  #: shape (n, 3) [m]
    head: Floats  #: shape (n, 3) [m]
    colour: tuple[int, int, int]
    radius: float  #: [m]
    longest: float  #: the force that the longest arrow stands for [N]


def force_arrows(verdict: Verdict) -> tuple[Arrows, Arrows]:
    """Return the resultant on the upper of the two blocks of each joint, through its centre of pressure.

    Parameters
    ----------
    verdict : Verdict
        The verdict.

    Returns
    -------
    tuple of Arrows
        The joints that press, and those that pull.
    """
    point, force, torn = resultants(verdict)
    upward = force @ verdict.assembly.gravity < 0
    force = np.where(upward[:, None], force, -force)
    longest = float(np.linalg.norm(force, axis=1).max(initial=0.0))
    pressed = _arrows(verdict, "forces", point[~torn], force[~torn], FORCE, longest)
    return pressed, _arrows(verdict, "tension", point[torn], force[torn], TORN, longest)


def thrust_arrows(verdict: Verdict) -> Arrows:
    """Return what each joint with a support presses on it with.

    Parameters
    ----------
    verdict : Verdict
        The verdict.

    Returns
    -------
    Arrows
        They end at the centres of pressure.
    """
    joint, point, force, _ = joint_resultants(verdict)
    first, second = verdict.assembly.support[verdict.interfaces.pair[joint]].T
    sign = second.astype(float) - first  # the force is that on the second block of the pair
    at = sign != 0
    force = force[at] * sign[at, None]
    longest = float(np.linalg.norm(force, axis=1).max(initial=0.0))
    arrows = _arrows(verdict, "thrust", point[at], force, THRUST, longest)
    return Arrows("thrust", arrows.tail - (arrows.head - point[at]), point[at], THRUST, arrows.radius, longest)


def _arrows(
    verdict: Verdict, name: str, point: Floats, force: Floats, colour: tuple[int, int, int], longest: float
) -> Arrows:
    """Arrows through their points, half before and half behind."""
    assembly = verdict.assembly
    lower, upper = assembly.bounds
    free = assembly.free
    extent = float((upper[free].max(axis=0) - lower[free].min(axis=0)).max()) if len(free) else 1.0
    half = force * (0.5 * REACH * extent / longest if longest > 0 else 0.0)
    return Arrows(name, point - half, point + half, colour, RADIUS * extent, longest)
