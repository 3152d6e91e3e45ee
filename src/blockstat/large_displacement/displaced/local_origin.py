"""A structure about its own middle: far from the origin, as in map coordinates, poses would lose their last digits.

Poses, gaps and rates do not depend on where the origin is, but their rounding does: neighbouring numbers at 4.6e6 m are
1e-9 m apart, as far as a gap may be from zero. Differences of such numbers are exact, so nothing is lost here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.large_displacement.displaced.control import Control
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.loading.placed import PlacedForces
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


def structure_about_middle(
    assembly: Assembly,
    interfaces: Interfaces,
    dead: PlacedForces,
    live: PlacedForces | None,
    solver: str,
    support_motion: Floats | None = None,
) -> tuple[Structure, Floats]:
    """Return a structure whose origin is the middle of the box of its blocks that are no supports.

    Parameters
    ----------
    assembly, interfaces, dead, live, solver
        As `Structure` has them, about any origin.
    support_motion
        The same; None where no support moves whole.

    Returns
    -------
    structure : Structure
        The same structure about its own middle.
    origin : Floats
        Where that is, shape (3,) [m].
    """
    corners = assembly.vertices[~assembly.support[assembly.vertex_block]]
    origin = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    ties = [replace(tie, points=tuple((point - origin).tolist() for point in tie.points)) for tie in assembly.ties]
    outlines, patches = interfaces.outlines, interfaces.patches
    here = Structure(
        replace(assembly, vertices=assembly.vertices - origin, ties=tuple(ties)),
        replace(
            interfaces,
            point=interfaces.point - origin,
            outlines=None if outlines is None else tuple(outline - origin for outline in outlines),
            patches=None if patches is None else replace(patches, origin=patches.origin - origin),
        ),
        replace(dead, point=dead.point - origin),
        None if live is None else replace(live, point=live.point - origin),
        solver,
        np.zeros((assembly.n_blocks, 6)) if support_motion is None else support_motion,
    )
    return here, origin


def control_about(control: Control, origin: Floats) -> Control:
    """Return a control about another origin.

    Parameters
    ----------
    control
        About the old origin.
    origin
        The new one, shape (3,) [m].

    Returns
    -------
    Control
        The same displacement of the same points.
    """
    return replace(control, point=control.point - origin)
