"""The parts of supports that move: found by the names of blocks and groups, or by regions, with the joints on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.errors import InputError, check_vector
from blockstat.joint import fits
from blockstat.loads import numbers
from blockstat.program.ties import tied_pairs
from blockstat.typing import Floats, Ints

#: What sticks out of a region by less than this, relative to the block on the support, is rounding.
ROUNDING = 1e-6


class Foundation(NamedTuple):
    """A part of the supports that moves as one."""

    name: str
    displacement: Floats  #: shape (3,) [m]
    joints: Ints  #: numbers of the interfaces on it
    reaction: Floats  #: force of the assembly on it, with bonds and ties, shape (3,) [N]


def parts_that_move(problem: Problem, moves: Mapping[Any, Sequence[float]]) -> list[tuple[Foundation, Ints]]:
    """Return the parts of the supports that move.

    Parameters
    ----------
    problem : Problem
        The posed problem.
    moves : mapping
        As in `blockstat.settle`.

    Returns
    -------
    list of (Foundation, array of int)
        Each part, without a reaction yet, and the supports that move whole with it.

    Raises
    ------
    InputError
        For a part that is nowhere or that two moves share, and for a region that cuts a joint of a support.
    """
    parts = []
    for where, given in moves.items():
        displacement = check_vector(f"{_called(where)}: displacement", given)
        supports, joints = _part(problem, where)
        parts.append((Foundation(_called(where), displacement, joints, np.zeros(3)), supports))
    counts = np.bincount(np.concatenate([part.joints for part, _ in parts]), minlength=problem.interfaces.n_interfaces)
    if (counts > 1).any():
        names = " and ".join(f'"{problem.assembly.names[i]}"' for i in problem.interfaces.pair[np.argmax(counts)])
        raise InputError(f"two moves share the joint of {names}; let each joint belong to one of them")
    whole, times = np.unique(np.concatenate([supports for _, supports in parts]), return_counts=True)
    if (times > 1).any():
        name = problem.assembly.names[whole[np.argmax(times)]]
        raise InputError(f'two moves share the support "{name}"; let each support belong to one of them')
    return parts


def on_supports(problem: Problem) -> np.ndarray:
    """Tell which interfaces are between a support and a free block.

    Parameters
    ----------
    problem : Problem
        The posed problem.

    Returns
    -------
    array of bool, shape (n_interfaces,)
        True for those.
    """
    return problem.assembly.support[problem.interfaces.pair].sum(axis=1) == 1


def _part(problem: Problem, where: Any) -> tuple[Ints, Ints]:
    """Supports that move whole, and the joints that move with them."""
    assembly, faces = problem.assembly, problem.interfaces
    between = on_supports(problem)
    if isinstance(where, tuple):
        lower, upper = np.sort(np.asarray(where, dtype=float).reshape(2, 3), axis=0)
        inside = [_lies_in(problem, k, lower, upper, _called(where)) for k in np.flatnonzero(between).tolist()]
        found = np.flatnonzero(between)[np.array(inside, dtype=bool)]
        if not len(found):
            raise InputError(f"{_called(where)}: no joint of a support lies in this box")
        return np.empty(0, dtype=np.int64), found
    named = np.zeros(assembly.n_blocks, dtype=bool)
    if isinstance(where, str) and where not in assembly.names:
        named |= np.array([fits(where, group) for group in assembly.groups])
    if not named.any():
        named[assembly.blocks_named(where, "foundations")] = True
    # A group that holds supports and what stands on them means the supports.
    supports = np.flatnonzero(named & assembly.support)
    sides = named & assembly.support if len(supports) else named
    found = np.flatnonzero(between & sides[faces.pair].any(axis=1))
    ends = tied_pairs(assembly)
    anchors = ends[~assembly.support[ends].all(axis=1)]
    if not len(found) and not np.isin(anchors, supports).any():
        what = "nothing rests on it or is tied to it" if len(supports) else "it does not stand on a support"
        raise InputError(f"{_called(where)}: {what}, so no support can move there")
    return supports, found


def _lies_in(problem: Problem, joint: int, lower: Floats, upper: Floats, called: str) -> bool:
    """Whether a joint lies in a box, or beside it; one that lies partly in it is refused."""
    assembly, pair = problem.assembly, problem.interfaces.pair[joint]
    corners = problem.interfaces.outline(joint)
    low, high = corners.min(axis=0), corners.max(axis=0)
    slack = ROUNDING * float(assembly.size[pair[~assembly.support[pair]]].min())
    beyond = np.maximum(lower - low, high - upper)
    if (beyond <= slack).all():
        return True
    # Where the joint is flat it may lie in a face of the box; where it is wide, touching a face is to lie beside it.
    margin = np.where(high - low > 2 * slack, slack, -slack)
    if not len(_cut_to(corners, lower + margin, upper - margin)):
        return False
    k = int(np.argmax(beyond))
    a, b = (assembly.names[block] for block in pair)
    ends = np.round([[low[k], high[k]], [lower[k], upper[k]]], 9) + 0.0  # no -0
    joint_ends, box_ends = (f"from {one:.7g} to {two:.7g} m" for one, two in ends)
    raise InputError(
        f'{called}: the joint of "{a}" and "{b}" lies partly in this box: it is {joint_ends} in {"xyz"[k]}, the box '
        f"{box_ends}; the box must hold whole joints, so divide the support or the block there, or take a box that "
        "holds the joint"
    )


def _cut_to(corners: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return the corners of the part of a convex polygon, or of a line, that lies in a box."""
    for axis in range(3):
        for side, bound in ((1.0, lower[axis]), (-1.0, upper[axis])):
            inside = side * (corners[:, axis] - bound)
            follow, then = np.roll(corners, -1, axis=0), np.roll(inside, -1)
            crossed = inside * then < 0
            share = inside / np.where(crossed, inside - then, 1.0)
            both = np.stack([corners, corners + share[:, None] * (follow - corners)], axis=1)
            corners = both[np.stack([inside >= 0, crossed], axis=1)]
    return corners


def _called(where: Any) -> str:
    if isinstance(where, tuple):
        if numbers(where).shape != (6,) or not np.isfinite(numbers(where)).all():
            raise InputError(f"a region is {where!r}; it must be six numbers, x0, y0, z0, x1, y1, z1")
        return f"region ({in_words(where)})"
    if not isinstance(where, (str, int, np.integer)):
        raise InputError(f"a part that moves is {where!r}; it must be a block, a group or the six numbers of a region")
    return f'"{where}"'


def in_words(values: Any) -> str:
    """Write numbers with four digits.

    Parameters
    ----------
    values
        The numbers.

    Returns
    -------
    str
        With commas between them.
    """
    return ", ".join(f"{float(part):.4g}" for part in values)
