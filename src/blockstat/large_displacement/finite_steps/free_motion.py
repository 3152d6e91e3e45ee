"""Free motion on supports that move: what a mechanism does that neither the supports nor the loads ask for.

A block that hangs on bars may swing, and one that has lost all contact may turn. To first order such a motion does no
work, so a program of least potential energy answers with any of it. At a finite distance the swing lifts the block, and
no forces balance it there. The block stays at rest instead.

The free part v of a motion u is that which all equations of the linkage allow at a fixed parameter. Where no joint
slides against friction, u + s v is admissible for small s of both signs, and so is of the same energy, as u has the
least. Then u - v is taken, if it is admissible.
"""

from __future__ import annotations

from dataclasses import replace

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_status import contact_status, tie_status
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly
from blockstat.large_displacement.displaced.structure import KEPT_LENGTH
from blockstat.large_displacement.linkage.kinematics import motion_at_fixed_parameter
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.typing import Floats

#: Motions whose powers differ by less have the same energy. Relative to the power of the weight at the fastest speed.
#: Chosen: ten times the accuracy to which programs are solved.
SAME_ENERGY = 1e-7


def without_free_motion(
    linkage: Linkage, pose: Pose, parameter: float, motion: Floats, *, sticking_speed: float
) -> tuple[Linkage, Floats]:
    """Return the motion of least potential energy without its free part, and its linkage.

    Parameters
    ----------
    linkage
        Of the motion. Its supports move.
    pose, parameter
        Where it begins.
    motion
        For a unit rate of the supports' movement, shape (n_blocks, 6).
    sticking_speed
        As in `contact_status`.

    Returns
    -------
    linkage : Linkage
        Contacts stick that only the free part would open.
    motion : Floats
        Shape (n_blocks, 6). Both are the given ones where no part is free, where joints slide against friction, and
        where contacts would overlap without the free part.
    """
    if linkage.slides_with_friction:
        return linkage, motion
    free = motion_at_fixed_parameter(linkage, pose, parameter, motion)
    there = displaced_assembly(linkage.assembly, pose)
    moving = [float(corner_speed(there, each).max(initial=0.0)) for each in (motion, free)]
    speed = max(moving[0], 1.0)
    if moving[1] <= KEPT_LENGTH * speed:
        return linkage, motion
    rest = motion - free
    here, structure = linkage.configuration(pose, parameter), linkage.structure
    sticking, sliding = contact_status(here, rest, 1.0, sticking_speed=sticking_speed)
    power = [structure.dead_power(pose, parameter, each) for each in (motion, rest)]
    same = abs(power[1] - power[0]) <= SAME_ENERGY * speed * linkage.assembly.free_weight
    if (sliding & ~linkage.sliding).any() or not same:
        return linkage, motion
    ties, slack = tie_status(here, rest, 1.0, sticking_speed=sticking_speed)
    return replace(linkage, sticking=sticking, sliding=sliding, ties=ties, slack=slack), rest
