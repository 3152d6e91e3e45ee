"""A mechanism that is a mixture of others which begin at the same multiplier, and is in unstable equilibrium.

A square pier that is pushed along its diagonal tips about either of two edges, and rocks on their corner, at the same
multiplier. The last is a mixture of the other two, and a solver that finds the middle of all motions finds it. Rocking
on its corner the pier is in equilibrium as a ball on a ridge is: its potential energy at a given displacement of the
control is largest there, and it rolls off sideways onto an edge. There the multiplier falls faster.

So where a mechanism leaves the blocks free to move aside at the same displacement of the control, the live load is
nudged to either side. Of the mechanisms found, those count whose multiplier under the load itself is the same, and the
one is followed whose multiplier falls fastest.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.verdict import corner_speed, unit_motion
from blockstat.large_displacement.displaced.pose import free_sizes, rest_pose
from blockstat.large_displacement.linkage.kinematics import motion_at_fixed_parameter
from blockstat.large_displacement.linkage.linkage import Linkage, linkage_at_rest
from blockstat.large_displacement.linkage.state_solver import A_LITTLE_WAY, StateSolver
from blockstat.typing import Floats

#: Speeds below this say that blocks are not free to move aside. Relative to the fastest corner. Chosen: far above what
#: solvers leave.
FREE = 1e-3
#: The nudge, relative to the live load. Chosen: far above the accuracy of a limit load. It changes the multiplier to
#: the same order only, which is not used.
NUDGE = 1e-4
#: Multipliers that differ by less are the same. Relative to the larger. Chosen: far above what solvers leave.
SAME_VALUE = 1e-6


def without_unstable_mixture(
    states: StateSolver,
    linkage: Linkage,
    limit: LimitLoad,
    live: Floats,
    dead: Floats,
    *,
    gap: float | str,
    solver: str,
) -> tuple[Linkage, LimitLoad]:
    """Return the mechanism that begins, or the one onto which it would roll off.

    Parameters
    ----------
    states
        Finds states of linkages of the structure.
    linkage
        Of the mechanism of the limit load, at rest.
    limit
        The limit load.
    live, dead
        The load that grows and the loads that stay beside the weight, shape (n_blocks, 6) [N, N m].
    gap, solver
        As in `blockstat.limit_load`.

    Returns
    -------
    linkage : Linkage
        The given one where the blocks are not free to move aside, where joints slide, and where no other mechanism has
        a multiplier that is the same and falls faster.
    limit : LimitLoad
        With the mechanism of the linkage.
    """
    if linkage.sliding.any() or linkage.control is None:
        return linkage, limit
    assembly, start = limit.assembly, rest_pose(limit.assembly)
    up = -assembly.gravity / max(float(np.linalg.norm(assembly.gravity)), 1e-300)
    across = np.zeros_like(limit.mechanism)
    across[:, 3:] = np.cross(limit.mechanism[:, 3:], up)
    aside = motion_at_fixed_parameter(linkage, start, 0.0, across)
    if float(corner_speed(assembly, aside).max(initial=0.0)) <= FREE * float(corner_speed(assembly, across).max()):
        return linkage, limit
    push = np.zeros_like(live)
    push[:, :3] = assembly.mass[:, None] * aside[:, :3]
    push *= NUDGE * np.linalg.norm(live[:, :3]) / max(float(np.linalg.norm(push)), 1e-300)
    found = [(linkage, limit)]
    for side in (1.0, -1.0):
        options: dict[str, Any] = {"loads": dead, "interfaces": limit.interfaces, "gap": gap, "solver": solver}
        nudged = limit_load(assembly, live + side * push, optimum=True, **options)
        own = states.structure.multiplier(start, 0.0, nudged.mechanism)
        if nudged.outcome is LoadOutcome.LIMIT and own <= (1 + SAME_VALUE) * limit.upper:
            other = replace(limit, mechanism=unit_motion(assembly, nudged.mechanism), upper=max(limit.upper, own))
            begun = linkage_at_rest(states.structure, other.mechanism, linkage.control, associated=linkage.associated)
            found.append((replace(begun, left_at_rest=linkage.left_at_rest), other))
    return min(found, key=lambda each: _a_little_way_on(states, *each))


def _a_little_way_on(states: StateSolver, linkage: Linkage, limit: LimitLoad) -> float:
    """The multiplier of a linkage a little way from rest; infinite where it cannot be followed."""
    state = states.first(linkage, rest_pose(limit.assembly), limit.mechanism)
    if state is None or not state.forces.admissible:
        return np.inf
    ahead = states.point_at(state, A_LITTLE_WAY * float(free_sizes(limit.assembly).max()))
    return np.inf if ahead is None else ahead.value
