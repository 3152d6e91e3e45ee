"""Connected components of the contact graph, solved side by side: they do not interact.

This is exact, since the penalty program of the whole is the sum of those of its components. They are assigned to as
many parts as there are processors, so that a field of a thousand small stacks does not become a thousand programs.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from blockstat.certificate.interior_motions import Motions, no_motions
from blockstat.geometry.components import connected_components
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer, Status
from blockstat.typing import Floats, Ints


def parts(program: PenaltyProgram, most: int) -> list[Ints]:
    """Deal the connected components out to parts of about one size, none touching another.

    Parameters
    ----------
    program
        The penalty program of the whole.
    most
        The greatest number of parts.

    Returns
    -------
    list of Ints
        Rows of the blocks of each part.
    """
    n = len(program.load) // 6
    a, b = program.point_blocks.T
    both = (a >= 0) & (b >= 0)
    count, label = connected_components(n, program.point_blocks[both])
    size = np.bincount(label, minlength=count)
    part, filled = np.zeros(count, dtype=np.int64), np.zeros(min(most, count))
    for component in np.argsort(-size, kind="stable"):
        part[component] = np.argmin(filled)
        filled[part[component]] += size[component]
    return [np.flatnonzero(part[label] == k) for k in range(len(filled))]


def solve_by_components(
    program: PenaltyProgram,
    solve: Callable[[PenaltyProgram, Motions], Answer],
    motions: Motions = no_motions,
    most: int | None = None,
) -> Answer:
    """Solve a penalty program part by part, side by side.

    Parameters
    ----------
    program
        The program of the whole, in space.
    solve
        Solves the program of a part, given the motions of its blocks.
    motions
        Gives twists of the whole that may open every joint, shape (6 n,) each; a part is handed its blocks'.
    most
        The greatest number of parts; as many as there are processors by default.

    Returns
    -------
    Answer
        Forces, adhesion and mechanism of the whole.
    """
    most = most or os.cpu_count() or 1
    found = parts(program, most)
    if len(found) < 2:
        return solve(program, motions)
    owner = np.empty(len(program.load) // 6, dtype=np.int64)
    for k, blocks in enumerate(found):
        owner[blocks] = k
    first = program.point_blocks.max(axis=1)
    of_point = np.where(first >= 0, owner[first], 0)
    points = [np.flatnonzero(of_point == k) for k in range(len(found))]
    pieces = [_piece(program, *chosen) for chosen in zip(found, points, strict=True)]
    own_motions = [partial(_of_blocks, motions, blocks) for blocks in found]
    with ThreadPoolExecutor(len(pieces)) as pool:
        answers = list(pool.map(solve, pieces, own_motions))
    status = {answer.status for answer in answers}
    whole = Answer(
        force=np.zeros((len(of_point), 3)),
        twist=np.zeros_like(program.load),
        status=status.pop() if len(status) == 1 else Status.MIXED,
        iterations=max(answer.iterations for answer in answers),
        solver="; ".join(dict.fromkeys(answer.solver for answer in answers)),
        adhesion=np.zeros(program.n_points),
        bounded=all(answer.bounded for answer in answers),
    )
    for blocks, own, answer in zip(found, points, answers, strict=True):
        whole.force[own] = answer.force
        whole.adhesion[own[own < program.n_points]] = answer.adhesion
        whole.twist.reshape(-1, 6)[blocks] = answer.twist.reshape(-1, 6)
    return whole


def _of_blocks(motions: Motions, blocks: Ints) -> list[Floats]:
    """Motions of some blocks."""
    return [motion.reshape(-1, 6)[blocks].reshape(-1) for motion in motions()]


def _piece(program: PenaltyProgram, blocks: Ints, points: Ints) -> PenaltyProgram:
    """The program of some blocks and all points on them, in the units of the whole."""
    row = np.full(len(program.load) // 6 + 1, -1)
    row[blocks] = np.arange(len(blocks))
    six = (6 * blocks[:, None] + np.arange(6)).reshape(-1)
    three = (3 * points[:, None] + np.arange(3)).reshape(-1)
    return replace(
        program,
        local=program.local[three],
        load=program.load[six],
        friction=program.friction[points],
        shift=program.shift[points],
        lower=program.lower[points],
        upper=program.upper[points],
        point_blocks=row[program.point_blocks[points]],
        n_points=int((points < program.n_points).sum()),
        plane=None,
    )
