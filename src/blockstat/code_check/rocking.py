"""Housner's parameters of a mechanism that is one rocking block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.code_check.linear import LEVEL
from blockstat.code_check.pushed import gravity_of, mass_points
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True)
class RockingBlock:
    """Housner's parameters of a mechanism that is one body turning about an axis."""

    radius: float  #: R, of the centroid from the axis [m]
    slenderness: float  #: angle of the diagonal, the arctangent of alpha0 [rad]
    frequency: float  #: p = sqrt(M g R / I), I about the axis [1/s]


def rocking_block(
    assembly: Assembly,
    mechanism: Floats,
    bodies: Sequence[Ints],
    masses: Sequence[tuple[int | str, Sequence[float], float]],
) -> RockingBlock | None:
    """Return Housner's parameters of a mechanism.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    mechanism : array, shape (n_blocks, 6)
        Virtual displacements [m, rad].
    bodies : sequence of array of int
        Blocks that move as one.
    masses : sequence of (block, point, weight)
        As in `blockstat.linear_check`.

    Returns
    -------
    RockingBlock or None
        None where it is not one body with its masses that turns about a horizontal axis.

    References
    ----------
    Housner: The behavior of inverted pendulum structures during earthquakes, 1963.
    """
    if len(bodies) != 1:
        return None
    blocks = bodies[0]
    motion: Floats = mechanism[blocks[0]]
    spin = np.linalg.norm(motion[3:])
    if not spin > 0 or abs(motion[:3] @ motion[3:]) > 1e-6 * spin * np.linalg.norm(motion[:3]):
        return None
    axis = motion[3:] / spin
    if abs(assembly.gravity @ axis) > LEVEL * np.linalg.norm(assembly.gravity):
        return None
    pole, gravity = assembly.centroid[blocks[0]] + np.cross(axis, motion[:3]) / spin, gravity_of(assembly)[0]
    points = [(place, weight / gravity) for block, place, weight in mass_points(assembly, masses) if block in blocks]
    mass = np.append(assembly.mass[blocks], [own for _, own in points])
    arm = np.array([*assembly.centroid[blocks], *(place for place, _ in points)]) - pole
    arm = arm - (arm @ axis)[:, None] * axis
    about = float((assembly.inertia[blocks] @ axis @ axis).sum() + mass @ (arm**2).sum(axis=1))
    centre = mass @ arm / mass.sum()
    radius, height = float(np.linalg.norm(centre)), -float(centre @ assembly.gravity) / np.linalg.norm(assembly.gravity)
    slenderness = float(np.arctan2(np.sqrt(max(radius**2 - height**2, 0.0)), height))
    return RockingBlock(radius, slenderness, float(np.sqrt(mass.sum() * gravity * radius / about)))
