"""Whether the bodies of a mechanism belong together, or some of them are a mechanism without the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.analysis.limit_load import LimitLoad
from blockstat.analysis.problem import pose
from blockstat.certificate import check as certificate
from blockstat.certificate.interior_motions import with_interior_motion
from blockstat.code_check.pushed import acting_beside_weight
from blockstat.geometry.components import connected_components
from blockstat.program.ties import tied_pairs
from blockstat.typing import Floats, Ints

#: A part moves alone if it does under a multiplier that is larger than the upper bound by this fraction, at most.
LARGER = 1e-3


def a_part_moves_alone(limit: LimitLoad, bodies: Sequence[Ints], push: Floats) -> bool:
    """Return whether some bodies are a mechanism of the same multiplier while the others rest.

    Parameters
    ----------
    limit : LimitLoad
        With its mechanism and forces.
    bodies : sequence of array of int
        Blocks that move as one.
    push : array, shape (n_blocks, 6)
        The load of the limit [N, N m].

    Returns
    -------
    bool
        True where it is proven. The mechanism of the solver is then a mixture of mechanisms, and how far its bodies
        move beside each other is arbitrary.

    Notes
    -----
    Bodies that no joint ties to the others, but through supports and blocks that rest, are a mechanism for themselves:
    the powers of two such parts are zero together at the limit, and neither is above zero. One body, or all but one,
    is asked for: the mechanism of a part has the motions of its bodies and none of the others. It is one where the
    independent check proves that with it the structure falls under a multiplier larger by `LARGER`.
    """
    if _fall_apart(limit, bodies):
        return True
    acting = acting_beside_weight(limit)[0] + ((1.0 + LARGER) * limit.upper - limit.lower) * push
    acting[limit.assembly.support] = 0.0
    problem = pose(limit.assembly, friction=None, gravity=None, loads=acting, gap=0.0, interfaces=limit.interfaces)
    program = problem.program
    if program is None:
        return False
    no_force = np.zeros((len(program.friction), 3))
    lengths = np.repeat([1.0, program.length_unit], 3)
    for body in bodies:
        rest = np.concatenate([other for other in bodies if other is not body])
        for part in (body, rest):
            motion = np.zeros_like(limit.mechanism)
            motion[part] = limit.mechanism[part]
            twist = (motion[problem.eq.blocks] * lengths).reshape(-1)
            moved = with_interior_motion(program, twist, problem.motions())
            if certificate.check(program, no_force, moved).proves_unstable:
                return True
    return False


def _fall_apart(limit: LimitLoad, bodies: Sequence[Ints]) -> bool:
    """Whether no joint and no tie connects some of the bodies with the others."""
    body = np.full(limit.assembly.n_blocks, -1)
    for number, blocks in enumerate(bodies):
        body[blocks] = number
    pairs = body[np.concatenate([limit.interfaces.pair, tied_pairs(limit.assembly)])]
    return connected_components(len(bodies), pairs[(pairs >= 0).all(axis=1)])[0] > 1
