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
    points: Ints  #: contacts that carry it
    sign: Ints  #: 1 where the body is block b of the contact, else -1


def balanced_forces(structure: Structure, force: Floats, slack: Floats, multiplier: Fraction) -> Exact:
    """Correct forces so that they balance every block exactly.

    Parameters
    ----------
    structure
        The blocks, contacts and loads.
    force
        On block b of each contact, along the axes, shape (n, 3) [N], balanced to rounding.
    slack
        By how much the normal force of each contact may fall, shape (n,) [N]; those without stay as they are.
    multiplier
        Of the live load.

    Returns
    -------
    Exact
        Shape (n, 3) [N].

    Raises
    ------
    ArithmeticError
        Where contacts with slack cannot carry what is left.
    """
    size = float(np.linalg.norm(force, axis=1).mean()) or 1.0
    places = PLACES - int(np.floor(np.log10(size)))
    found = rounded(force, places)
    slippery = structure.friction == 0  # forces along the normal as it is given, and nothing else
    along = (force[slippery] * structure.normal[slippery].astype(float)).sum(axis=1)
    found[slippery] = rounded(along, places)[:, None] * structure.normal[slippery]
    left = structure.balance(found, multiplier)
    for step in _steps(structure, slack):
        residual = left[step.blocks].sum(axis=0)
        if not residual.any():
            continue
        change = _carried(structure.point[step.points], _weights(slack[step.points]), -residual)
        change = step.sign[:, None] * change
        found[step.points] = found[step.points] + change
        structure.act(left, step.points, change)
    if left.any():
        raise ArithmeticError("contacts with slack do not join every block to a support")
    return found


def _weights(slack: Floats) -> Exact:
    """Powers of two near the slack."""
    return np.array([Fraction(2) ** int(np.round(np.log2(value / slack.max()))) for value in slack], dtype=object)


def _carried(point: Exact, weight: Exact, wrench: Exact) -> Exact:
    """Forces at points with the given resultant about the origin, shape (n, 3)."""
    total = weight.sum()
    centre = (weight[:, None] * point).sum(axis=0) / total
    arm = point - centre
    square = (weight[:, None] * arm * arm).sum()
    inertia = square * np.eye(3, dtype=int) - (weight[:, None] * arm).T @ arm
    moment = wrench[3:] - np.cross(centre, wrench[:3])
    line = arm[np.abs(arm.astype(float)).sum(axis=1).argmax()]
    for matrix in (inertia, inertia + np.outer(line, line)):
        cofactors = np.array([np.cross(matrix[(i + 1) % 3], matrix[(i + 2) % 3]) for i in range(3)])
        determinant = matrix[0] @ cofactors[0]
        if determinant:
            break
    spin = moment @ cofactors / determinant if determinant else 0 * moment
    if (inertia @ spin != moment).any():
        raise ArithmeticError("a block rests on a line that its load does not meet exactly")
    return weight[:, None] * (wrench[:3] / total + np.cross(spin, arm))


def _steps(structure: Structure, slack: Floats) -> list[Step]:
    """The order in which bodies hand on their residuals: the largest bodies first, and leaves of each tree first."""
    fixed, n = structure.fixed, len(structure.fixed)
    usable = np.flatnonzero((slack > 0) & (structure.friction > 0))
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
        cost = _cost(structure.point[points].astype(float), slack[points], lines)
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


def _cost(point: Floats, slack: Floats, lines: bool) -> float:
    """How large the forces are that carry a wrench, relative to the slack; inf for points on a line unless allowed."""
    weight = slack / slack.sum()
    arm = point - weight @ point
    spread = np.linalg.eigvalsh((weight[:, None] * arm).T @ arm)[1]
    reach = np.abs(arm).max(initial=0.0)
    if len(point) < 3 or spread <= (SPREAD * reach) ** 2:
        return 1.0 / float(slack.max()) if lines else np.inf
    return float((1.0 + reach / np.sqrt(spread)) / slack.max())
