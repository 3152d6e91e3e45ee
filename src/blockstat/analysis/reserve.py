"""What a stable verdict has in reserve: whether it is balanced, and whether it rests on slivers.

An assembly withstands any small load more if and only if `-w` lies inside `A K`, the loads that the contacts can
balance. It does not where a block can move without moving a contact point (`blockstat.certificate.neutral`), or where
no forces in equilibrium have slack at every contact point. Then there is a neutral motion: no joint closes under it,
and the loads do no work.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.analysis.decision import solve_margin_locally
from blockstat.analysis.problem import Problem
from blockstat.analysis.verdict import corner_speed
from blockstat.certificate.check import FORCE_TOLERANCE, balance, force_errors
from blockstat.certificate.neutral import loose_blocks
from blockstat.contact.interfaces import Interfaces
from blockstat.geometry.polyhedron import members
from blockstat.solve.answer import Answer
from blockstat.typing import Floats, Ints

#: A joint narrower than this share of the smaller block (cube root of volume) is a sliver: 0.2 mm on a brick, less than
#: stone is cut or measured to.
SLIVER = 1e-3
#: Frictionless joints are lent this friction: that blocks slide on them freely is not worth a word.
LENT = 1e-3
#: Corners slower than this fraction of the fastest are at rest.
SLOW = 0.01


def neutral_blocks(problem: Problem, checked: Answer, *, solver: str = "auto") -> Ints:
    """Find the blocks of a stable assembly that a neutral motion moves.

    Parameters
    ----------
    problem
        The posed problem.
    checked
        The forces that prove it stable, with their certificate.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    Ints
        Their numbers, ascending.

    Notes
    -----
    Forces with slack at every point show that there is nothing to look for beyond loose blocks. Only where those at
    hand have none is the largest slack asked for, by one more program. Slack of less than `FORCE_TOLERANCE` of a
    block's load is none: equilibrium is proven no better than that.
    """
    program = problem.program
    assert program is not None
    loose = loose_blocks(problem.assembly.support, problem.interfaces, problem.eq.blocks, problem.bonds)
    if checked.certificate.slack > FORCE_TOLERANCE:
        return loose
    lent = replace(program, friction=np.maximum(program.friction, LENT))
    widest = solve_margin_locally(lent, solver=solver)
    if force_errors(lent, balance(lent, widest.force)).slack > FORCE_TOLERANCE:
        return loose
    speed = corner_speed(problem.assembly, problem.to_blocks(widest.twist))
    return np.union1d(loose, np.flatnonzero(speed > SLOW * speed.max(initial=0.0)))


def neutral_warning(problem: Problem, neutral: Ints, limit: int = 3) -> list[str]:
    """Say that a stable assembly has no reserve.

    Parameters
    ----------
    problem
        The posed problem.
    neutral
        The blocks that a neutral motion moves.
    limit
        Most blocks that are named.

    Returns
    -------
    list of str
        A sentence, or none.
    """
    if not len(neutral):
        return []
    names = ", ".join(f'"{problem.assembly.names[i]}"' for i in neutral[:limit])
    more = f" and {len(neutral) - limit} more" if len(neutral) > limit else ""
    return [f"balanced: in equilibrium without reserve; nothing resists a small push that moves {names}{more}"]


def loaded_slivers(problem: Problem, forces: Floats) -> Ints:
    """Find the joints that are slivers and carry load.

    Parameters
    ----------
    problem
        The posed problem.
    forces
        Shape (n_points, 3) [N].

    Returns
    -------
    Ints
        Numbers of the interfaces, ascending.
    """
    interfaces, assembly = problem.interfaces, problem.assembly
    if not interfaces.n_interfaces:
        return np.empty(0, dtype=np.int64)
    first = interfaces.start[:-1]
    box = np.maximum.reduceat(interfaces.point, first) - np.minimum.reduceat(interfaces.point, first)
    size = assembly.size[interfaces.pair].min(axis=1)
    narrow = (interfaces.area > 0) & (interfaces.area < SLIVER * size * np.linalg.norm(box, axis=1))
    if not narrow.any():
        return np.flatnonzero(narrow)
    carried = np.add.reduceat(np.linalg.norm(forces, axis=1), first)
    own = np.where(assembly.support, np.inf, np.linalg.norm(problem.load[:, :3], axis=1))
    return np.flatnonzero(narrow & (carried > FORCE_TOLERANCE * own[interfaces.pair].min(axis=1)))


def without(interfaces: Interfaces, left_out: Ints) -> Interfaces:
    """Return interfaces without some of them.

    Parameters
    ----------
    interfaces
        All of them.
    left_out
        Numbers of those to leave out.

    Returns
    -------
    Interfaces
        The others, in the same order.
    """
    kept = np.setdiff1d(np.arange(interfaces.n_interfaces), left_out)
    count = np.diff(interfaces.start)[kept]
    points = members(interfaces.start[kept], count)[1]
    changes = {
        name: value[kept]
        for name in ("pair", "frame", "area", "gap", "kind")
        if (value := getattr(interfaces, name, None)) is not None
    }
    outlines = None if interfaces.outlines is None else tuple(interfaces.outlines[k] for k in kept)
    share = None if interfaces.share is None else interfaces.share[points]
    start = np.concatenate([[0], np.cumsum(count)])
    return replace(interfaces, **changes, point=interfaces.point[points], start=start, outlines=outlines, share=share)


def sliver_warning(problem: Problem, slivers: Ints, limit: int = 3) -> list[str]:
    """Say which slivers a verdict rests on.

    Parameters
    ----------
    problem
        The posed problem.
    slivers
        Numbers of the interfaces, at least one.
    limit
        Most joints that are named.

    Returns
    -------
    list of str
        One sentence.
    """
    names = problem.assembly.names
    pairs = [f'"{names[a]}" to "{names[b]}"' for a, b in problem.interfaces.pair[slivers[:limit]].tolist()]
    more = f" and {len(slivers) - limit} more" if len(slivers) > limit else ""
    return [
        f"stable only with joints narrower than {SLIVER:g} of their smaller block: {', '.join(pairs)}{more}; without "
        "them it is not proven stable"
    ]
