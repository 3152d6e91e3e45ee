"""Whether a mechanism is the only one of its multiplier, or a mixture of several.

The mechanisms of the least multiplier alpha0 are the motions u that close no joint, with l'u = 1 for the push l and
-w'u = alpha0 for the weight w. They form a convex set. A solver that comes from inside ends in the middle of it: its
mechanism is a mean of all of them. What follows from that:

- Rates of joints lie in convex cones without lines, so no rate is the opposite of another. A joint that stays closed in
  the middle, or a body that rests there, does so in all of the set. So the bodies of the mixture stay whole in each of
  its mechanisms, however many blocks they have.
- Some mechanism of the set moves less than the mixture: in it two bodies move as one, or one of them rests. So each
  joint between two bodies is closed in turn, the two made one, and each body is held at rest. Mechanisms are only lost
  by that, so what is left carries alpha0 at least. If it carries no more, such a mechanism exists; if it does each
  time, there is none.

So a mixture is found also where it is not in the middle. In an optimum to n digits, next to a tie, a body may move at a
thousandth of the speed of another because the digits end there. Without that motion the multiplier is no larger.

Next to a tie a mechanism of blocks that rest in this one may come as close. So all blocks but those of the bodies are
free, each by itself.

The share e* of a mixture is a number of the solver: it may be that of any mean of the mechanisms. The verification then
takes e* = 1, which no mechanism exceeds (Cauchy and Schwarz), so a0* = alpha0 g / FC is safe for each of them.

Joints of a capacity curve slide without opening, and such motions form no such set. Where these joints have no friction
what is left carries less than with any, so no mixture is missed; one mechanism may be taken for a mixture, on the safe
side.

Two mechanisms of the same bodies whose joints turn about other edges are not told apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from blockstat.analysis.decision import decide, outcome_of
from blockstat.analysis.limit_load import LimitLoad
from blockstat.analysis.problem import Problem, pose
from blockstat.analysis.verdict import Outcome, relative_motion
from blockstat.code_check.pushed import acting_beside_weight
from blockstat.program.penalty import PenaltyProgram
from blockstat.program.ties import tied_pairs
from blockstat.solve.penalty import solve_penalty
from blockstat.typing import Floats, Ints

#: Multipliers are the same that differ by this part. Stone is cut to a thousandth of a block. A multiplier is a
#: quotient of sums of weights times horizontal and times vertical arms, as b / h of a wall, so arms that are off by a
#: thousandth change it by as much, and which of two such mechanisms comes first is not known.
LARGER = 1e-3


def is_mixture(limit: LimitLoad, bodies: Sequence[Ints], push: Floats, unproven: float) -> bool:
    """Return whether some of the bodies of a mechanism, or all with a joint closed, are one of the same multiplier.

    Parameters
    ----------
    limit : LimitLoad
        With its mechanism and forces.
    bodies : sequence of array of int
        Blocks that move as one.
    push : array, shape (n_blocks, 6)
        The load of the limit [N, N m].
    unproven : float
        Speed up to which a motion is none [m].

    Returns
    -------
    bool
        False where it is proven that with a joint closed, or a body at rest, the others carry a multiplier that is
        larger by `LARGER`, whichever it is. How far the bodies move beside each other is then that of the mechanism,
        and else arbitrary.

    Notes
    -----
    One verdict for each body and for each two that touch, less than 2 m for a chain of m bodies. A verdict takes less
    time than the limit load did. The first that is a mechanism, or that is not proven, ends it.
    """
    assembly = limit.assembly
    acting = acting_beside_weight(limit)[0] + ((1.0 + LARGER) * limit.upper - limit.lower) * push
    acting[assembly.support] = 0.0
    problem = pose(assembly, friction=None, gravity=None, loads=acting, gap=0.0, interfaces=limit.interfaces)
    if problem.program is None:
        return True
    rate = relative_motion(assembly, limit.interfaces, limit.mechanism)
    slides = (np.abs(rate[:, 0]) <= unproven) & (np.hypot(rate[:, 1], rate[:, 2]) > unproven)
    friction = problem.program.friction.copy()
    friction[: problem.program.n_points][slides[problem.eq.points]] = 0.0
    program = replace(problem.program, friction=friction, plane=None)
    return not all(_stands(_of_bodies(problem, program, label)) for label in _closed(limit, bodies))


def _closed(limit: LimitLoad, bodies: Sequence[Ints]) -> Iterator[Ints]:
    """The body of each block, -1 for none: with each body at rest, and with each joint between two closed."""
    assembly = limit.assembly
    body = len(bodies) + np.arange(assembly.n_blocks)  # the others are free, each by itself
    body[assembly.support] = -1
    for number, blocks in enumerate(bodies):
        body[blocks] = number
    for number in range(len(bodies)):
        yield np.where(body == number, -1, body)
    pairs = np.sort(body[np.concatenate([limit.interfaces.pair, tied_pairs(assembly)])], axis=1)
    joined = (pairs[:, 0] >= 0) & (pairs[:, 0] < pairs[:, 1]) & (pairs[:, 1] < len(bodies))
    for one, other in np.unique(pairs[joined], axis=0):
        yield np.where(body == other, one, body)


def _of_bodies(problem: Problem, program: PenaltyProgram, body: Ints) -> PenaltyProgram:
    """The program of bodies in place of blocks.

    A block at the arm r from the first of its body moves at v + w x r, and turns as the body does: u = T z. The rates
    A'u are those of A'T, and the loads of the bodies are T'w.

    Parameters
    ----------
    problem
        The posed problem.
    program
        Of its blocks.
    body
        Of each block of the assembly, -1 for one that rests, shape (n_blocks,).
    """
    _, first, number = np.unique(own := body[problem.eq.blocks], return_index=True, return_inverse=True)
    number = np.where(own >= 0, number - int((own < 0).any()), -1)
    first = first[own[first] >= 0]
    centre = problem.assembly.centroid[problem.eq.blocks]
    arm = np.where(own[:, None] >= 0, centre - centre[first][number], 0.0) / program.length_unit
    along = np.zeros((len(own) + 1, 6, 6))  # the last, at -1, is that of supports
    along[:-1] = np.eye(6)
    along[:-1, :3, 3:] = np.cross(np.eye(3)[None], arm[:, None, :]).swapaxes(1, 2)
    along[:-1][own < 0] = 0.0
    local = program.local.reshape(-1, 3, 2, 6)
    pair = np.append(number, -1)[program.point_blocks]
    kept = pair[:, 0] != pair[:, 1]
    local = np.einsum("nkij,nijl->nkil", local[kept], along[program.point_blocks[kept]])
    load = np.zeros((len(first), 6))
    moves = own >= 0
    np.add.at(load, number[moves], np.einsum("nji,nj->ni", along[:-1], program.load.reshape(-1, 6))[moves])
    return replace(
        program,
        local=local.reshape(-1, 12),
        load=load.reshape(-1),
        friction=program.friction[kept],
        total_load=float(np.linalg.norm(load, axis=1).sum()) or 1.0,
        shift=program.shift[kept],
        lower=program.lower[kept],
        upper=program.upper[kept],
        point_blocks=pair[kept],
        n_points=int(kept[: program.n_points].sum()),
    )


def _stands(program: PenaltyProgram) -> bool:
    """Whether it is proven that bodies stand under their loads."""
    if not len(program.point_blocks):
        return False
    return outcome_of(decide(program, solve_penalty(program, stands=True)).certificate) is Outcome.STABLE
