"""Forces that balance every block exactly, next to those of a solver.

Rounded forces leave a residual wrench r_k on each block. A spanning tree of the joints leads from every block to the
supports. Along it each block hands its residual, with those that it was handed, to the next one. Wrenches about one
origin add up without a division, so numbers stay short however long the way. A joint carries the wrench (R, M) by

    df_i = s_i (R / S + b x d_i),   d_i = p_i - c,   J b = M - c x R,   J = sum s_i (|d_i|^2 I - d_i d_i'),

with weights s_i from the slack of its points, their sum S and centre c: of all changes of the joint's forces the least
one in the weighted sense. These fractions are exact and stay in their joint. The changes are as small as rounding, so
forces with slack stay inside their cones.

Points on a line carry no moment about it. Blocks that only such contacts join to the rest, as edges do, wait until the
others have been joined to bodies: between bodies there may be points enough. Their wrenches are handed on first, then
those inside the bodies. What is then left stands on one line or point, and is balanced only if that is exactly so.

Where a bond has slack its couple takes the moment: df_i = s_i R / S, and M - c x R.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from blockstat.proof.rational import Exact, rounded
from blockstat.proof.structure import Structure
from blockstat.typing import Floats, Ints

#: Decimal places of forces behind the first digit of a mean one.
PLACES = 17
#: Points whose weighted spread beside a line is below this fraction of their reach lie on it.
SPREAD = 1e-6


@dataclass(frozen=True, eq=False)
class Step:
    """A body hands its residual to another one."""

    blocks: Ints  #: of the body
    points: Ints  #: contacts and bonds that carry it
    sign: Ints  #: 1 where the body is block b of the row, else -1


def balanced_forces(
    structure: Structure, force: Floats, slack: Floats, multiplier: Fraction, along: Exact | None = None
) -> Exact:
    """Correct forces so that they balance every block exactly.

    Parameters
    ----------
    structure
        The blocks, contacts and loads.
    force
        On block b of each row, along the axes, shape (n, 3) [N or N m], balanced to rounding.
    slack
        By how much each may change, shape (n,), positive; those without stay as they are.
    multiplier
        Of the live load.
    along
        A direction that forces and loads have, shape (3,), and that corrections keep; None for any.

    Returns
    -------
    Exact
        Shape (n, 3) [N or N m].

    Raises
    ------
    ArithmeticError
        Where contacts with slack cannot carry what is left.
    """
    size = float(np.linalg.norm(force, axis=1).mean()) if force.any() else 1.0
    places = PLACES - int(np.floor(np.log10(size)))
    found = rounded(force, places)
    slippery = (structure.friction == 0) & (structure.shear == 0)  # along the normal as it is given, and nothing else
    sizes = (force[slippery] * structure.normal[slippery].astype(float)).sum(axis=1)
    found[slippery] = rounded(sizes, places)[:, None] * structure.normal[slippery]
    if along is not None:
        sizes = force @ along.astype(float) / float(along @ along)
        found = rounded(sizes, places)[:, None] * along
    left = structure.balance(found, multiplier)
    for step in _steps(structure, slack, slippery & (along is None)):
        residual = left[step.blocks].sum(axis=0)
        if not residual.any():
            continue
        weight, rows = _weights(slack[step.points]), step.points
        if along is None:
            change = _carried(structure, rows, weight, -residual)
        else:
            change = _carried_along(structure.point[rows], weight, -residual, along)
        change = step.sign[:, None] * change
        found[step.points] = found[step.points] + change
        structure.act(left, step.points, change)
    if left.any():
        raise ArithmeticError("contacts with slack do not join every block to a support")
    return found


def _weights(slack: Floats) -> Exact:
    """Powers of two near the slack."""
    return np.array([Fraction(2) ** int(np.round(np.log2(value / slack.max()))) for value in slack], dtype=object)


def _carried(structure: Structure, rows: Ints, weight: Exact, wrench: Exact) -> Exact:
    """Forces and couples of rows with the given resultant about the origin, shape (n, 3)."""
    couple, point = structure.couple[rows], structure.point[rows]
    if couple.any():
        change = np.where(couple, 0, weight)[:, None] * wrench[:3] / weight[~couple].sum()
        turning = np.flatnonzero(couple)[weight[couple].argmax()]
        change[turning] = wrench[3:] - np.cross(point[~couple], change[~couple]).sum(axis=0)
        return change
    total = weight.sum()
    centre = (weight[:, None] * point).sum(axis=0) / total
    arm = point - centre
    square = (weight[:, None] * arm * arm).sum()
    inertia = square * np.eye(3, dtype=int) - (weight[:, None] * arm).T @ arm
    moment = wrench[3:] - np.cross(centre, wrench[:3])
    line = arm[np.abs(arm.astype(float)).sum(axis=1).argmax()]
    spin = _solved(inertia, moment, inertia + np.outer(line, line))
    return weight[:, None] * (wrench[:3] / total + np.cross(spin, arm))


def _carried_along(point: Exact, weight: Exact, wrench: Exact, along: Exact) -> Exact:
    """Forces of one direction at points with the given resultant about the origin, shape (n, 3)."""
    u, v = np.delete(np.arange(3), np.abs(along.astype(float)).argmax())
    arm = np.cross(point, along)
    parts = np.column_stack([weight**0, arm[:, u], arm[:, v]])
    matrix = (weight[:, None] * parts).T @ parts
    wanted = np.array([wrench[:3] @ along / (along @ along), wrench[3 + u], wrench[3 + v]])
    return (weight * (parts @ _solved(matrix, wanted)))[:, None] * along


def _solved(matrix: Exact, right: Exact, instead: Exact | None = None) -> Exact:
    """The solution of three equations with a symmetric matrix, or of those `instead` where it is singular."""
    found = 0 * right
    for trial in (matrix,) if instead is None else (matrix, instead):
        cofactors = np.array([np.cross(trial[(i + 1) % 3], trial[(i + 2) % 3]) for i in range(3)])
        determinant = trial[0] @ cofactors[0]
        if determinant:
            found = right @ cofactors / determinant
            break
    if (matrix @ found != right).any():
        raise ArithmeticError("a block rests on a line that its load does not meet exactly")
    return found


def _steps(structure: Structure, slack: Floats, slippery: np.ndarray) -> list[Step]:
    """The order in which bodies hand on their residuals: the largest bodies first, and leaves of each tree first.

    slippery : rows whose forces cannot change as others do, since nothing holds them across their normals
    """
    fixed, n = structure.fixed, len(structure.fixed)
    usable = np.flatnonzero((slack > 0) & ~slippery)
    body = np.where(fixed, n, np.arange(n))
    levels: list[list[Step]] = []
    for lines in (False, True):
        while True:
            steps, merged = _level(structure, slack, usable, body, lines)
            if not steps:
                break
            levels.append(steps)
            body = merged
    return [step for steps in reversed(levels) for step in steps]


def _level(structure: Structure, slack: Floats, usable: Ints, body: Ints, lines: bool) -> tuple[list[Step], Ints]:
    """Trees of bodies, and the bodies that they make. lines : whether points on a line join bodies too."""
    ground = len(body)
    sides = body[structure.pair[usable]]
    across = usable[sides[:, 0] != sides[:, 1]]
    if not len(across):
        return [], body
    pairs, which = np.unique(np.sort(body[structure.pair[across]], axis=1), axis=0, return_inverse=True)
    which = which.reshape(-1)
    groups = np.split(across[np.argsort(which, kind="stable")], np.cumsum(np.bincount(which))[:-1])
    joints = {}
    for pair, points in zip(pairs.tolist(), groups, strict=True):
        cost = _cost(structure, points, slack[points], lines)
        if np.isfinite(cost):
            joints[tuple(pair)] = cost, points
    if not joints:
        return [], body
    row, column = np.array(list(joints), dtype=np.int32).T  # scipy 1.15, the last for Python 3.10, takes no other
    graph = sparse.csr_array(([cost for cost, _ in joints.values()], (row, column)), shape=(ground + 1, ground + 1))
    tree = minimum_spanning_tree(graph)
    _, label = connected_components(tree, directed=False)
    steps = []
    present = np.unique(np.append(body, ground))
    for component in np.unique(label[present]):
        members = present[label[present] == component]
        order, before = breadth_first_order(tree, members.max(), directed=False)  # from the ground where it is there
        for own in order[:0:-1].tolist():
            points = joints[min(own, before[own]), max(own, before[own])][1]
            sign = np.where(body[structure.pair[points, 1]] == own, 1, -1)
            steps.append(Step(np.flatnonzero(body == own), points, sign))
    head = np.full(ground + 1, -1)
    np.maximum.at(head, label[present], present)
    return steps, head[label[body]]


def _cost(structure: Structure, rows: Ints, slack: Floats, lines: bool) -> float:
    """How large the forces are that carry a wrench, relative to the slack; inf for points on a line unless allowed."""
    couple, point = structure.couple[rows], structure.point[rows].astype(float)
    if couple.any():
        return np.inf if couple.all() else 1.0 / float(min(slack[couple].max(), slack[~couple].max()))
    weight = slack / slack.sum()
    arm = point - weight @ point
    spread = np.linalg.eigvalsh((weight[:, None] * arm).T @ arm)[1]
    reach = np.abs(arm).max(initial=0.0)
    if len(point) < 3 or spread <= (SPREAD * reach) ** 2:
        return 1.0 / float(slack.max()) if lines else np.inf
    return float((1.0 + reach / np.sqrt(spread)) / slack.max())
