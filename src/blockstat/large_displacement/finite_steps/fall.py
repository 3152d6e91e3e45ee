"""Blocks that fall: where no multiplier is carried, they move while the live load does no work or the supports rest."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly
from blockstat.large_displacement.finite_steps.step import stepped, trial_state_at
from blockstat.large_displacement.finite_steps.trial_state import TrialState
from blockstat.large_displacement.linkage.jump import FALLING_TOGETHER, MAX_PART_FALLEN
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.parts import hang_on_ties
from blockstat.large_displacement.linkage.path import PathEvent, PathPoint
from blockstat.large_displacement.linkage.root_finding import NoRootError
from blockstat.program.ties import tied_pairs
from blockstat.typing import Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: The first and shortest step of a fall. Relative to the longest step. Chosen: contacts that stop a fall may be near.
FALL_STEP = 1.0 / 4.0
#: Steps of a fall at most. Chosen: a fall without end is broken off.
MAX_STEPS = 2000
#: Blocks that have fallen so far without being stopped have left the structure. Relative to their size. Chosen: a block
#: that has fallen by half its size has lost its bearing.
FALLEN = 0.5
#: A projection has led back where the fastest corner has gone less than this part of a step. A shorter step is then
#: tried, down to the second number, a part of the shortest. Chosen: what a fall ends at may be that near.
LED_BACK, LEAST_STEP = 0.5, 1.0 / 1024.0
#: A fall is lost after so many steps in succession that take no corner further by the second number, a part of the
#: step: on its way with associated flow, from where the fall began without. Chosen: the first step on a new contact may
#: go nowhere, several do not.
MOST_IDLE, GETS_ON = 8, 0.1


@dataclass(frozen=True, eq=False)
class FallenBlocks:
    """Blocks that have fallen out of the structure."""

    parameter: float  #: where they begin to fall [m]
    blocks: Ints  #: their numbers


def fall(
    trial: TrialState, last: PathPoint, longest: float
) -> Generator[PathEvent | FallenBlocks, None, TrialState | None]:
    """Let blocks fall until a positive multiplier is carried; on supports that move, until forces balance.

    Parameters
    ----------
    trial
        A state in which blocks fall.
    last
        The last point of the path.
    longest
        Longest step of the fastest corner [m].

    Yields
    ------
    PathEvent or FallenBlocks
        The blocks that leave, then the jump.

    Returns
    -------
    TrialState or None
        Where the fall ends. None where the path ends: most of what the load moves has fallen, or, on supports that
        move, a block is not stopped, or only a negative multiplier is carried.

    Raises
    ------
    NoRootError
        When the solver finds no fall, the blocks jam or get nowhere, or they swing on ties. These come to rest at
        their lowest place, which is not looked for.

    Notes
    -----
    Blocks fall with associated flow, which has the proof. Where that leads nowhere, as joints that open while they
    slide are closed again by the projection, joints slide without opening.
    """
    try:
        items, end = _followed(trial, last, longest)
    except NoRootError:
        if trial.linkage.associated:
            raise
        none = np.zeros_like(trial.structure.interfaces.area)
        sliding = trial_state_at(trial.linkage, trial.pose, trial.parameter, none, dilates=False)
        items, end = _followed(sliding, last, longest)
    yield from items
    return end if end is None else replace(end, dilates=True)


def _followed(
    trial: TrialState, last: PathPoint, longest: float
) -> tuple[list[PathEvent | FallenBlocks], TrialState | None]:
    """What `fall` yields, and what it returns.

    Without opening, the solver only comes near a motion, and steps may go to and fro: what counts is how far they have
    led in the end.
    """
    items: list[PathEvent | FallenBlocks] = []
    shortest = FALL_STEP * longest
    settles = trial.structure.live is None
    start, step, way, idle, gone = trial, shortest, 0.0, 0, 0.0
    for _ in range(MAX_STEPS):
        standing = trial
        if not trial.limit.mechanism.any():
            raise NoRootError
        trial, step = _fallen_on(standing, step, shortest)
        before, way = way, way + _way(standing, trial) if trial.dilates else max(way, _way(start, trial))
        idle = idle + 1 if way - before < GETS_ON * step else 0
        step = min(2 * step, longest)
        moved = np.linalg.norm(trial.pose.displacement - start.pose.displacement, axis=1)
        most = np.flatnonzero(moved > FALLING_TOGETHER * moved.max())
        if not len(most):  # nothing has moved
            raise NoRootError
        if trial.limit.multiplier is None and way > FALLEN * float(trial.linkage.assembly.size[most].max()):
            if settles:
                if hang_on_ties(start.moving_linkage(), most):
                    raise NoRootError
                return items, None
            items.append(FallenBlocks(start.parameter, most))
            gone += trial.structure.part_of_live_power(last.pose, last.tangent, most)
            rest = without_blocks(standing.linkage, most)
            if rest is None or gone > MAX_PART_FALLEN:
                return items, None
            none = np.zeros_like(rest.structure.interfaces.area)
            pose = without_ties_of_blocks(standing.pose, standing.linkage.assembly, most)
            trial = trial_state_at(rest, pose, standing.parameter, none, dilates=trial.dilates)
            start, way, idle = trial, 0.0, 0
        multiplier = trial.limit.multiplier
        if multiplier is not None:
            carried = settles or multiplier > 0
            items.append(_jump(start, trial, last, multiplier if carried else None))
            return items, trial if carried else None
        if idle > MOST_IDLE:
            raise NoRootError
    raise NoRootError


def _way(start: TrialState, end: TrialState) -> float:
    """How far the fastest corner has gone [m]; less than the steps together where projections have led back."""
    here, there = (displaced_assembly(each.linkage.assembly, each.pose).vertices for each in (start, end))
    return float(np.linalg.norm(there - here, axis=1).max())


def _fallen_on(standing: TrialState, step: float, shortest: float) -> tuple[TrialState, float]:
    """The state after a step of a fall, and its length: so short that the closed joints do not change if it can be.

    It is shorter still where contacts that the step takes too far beyond each other lead back.
    """
    trial = stepped(standing, step)
    while step > shortest and trial.closed_joints() != standing.closed_joints():  # no block may be fallen through
        step = max(step / 2, shortest)
        trial = stepped(standing, step)
    while not trial.dilates and _led_back(standing, trial, step) and step > LEAST_STEP * shortest:
        step /= 2
        trial = stepped(standing, step)
    return trial, step


def _led_back(start: TrialState, end: TrialState, step: float) -> bool:
    """Whether blocks that still fall have gone far less than a step."""
    return end.limit.multiplier is None and _way(start, end) < LED_BACK * step


def _jump(start: TrialState, end: TrialState, last: PathPoint, after: float | None) -> PathEvent:
    opened, shut = start.closed_joints() - end.closed_joints(), end.closed_joints() - start.closed_joints()
    return PathEvent("jump", end.parameter, last.value, after, tuple(sorted(opened)), tuple(sorted(shut)))


def without_blocks(linkage: Linkage, blocks: Ints) -> Linkage | None:
    """Return the linkage without blocks, which become supports without contacts or ties.

    Parameters
    ----------
    linkage
        The linkage, which has a control.
    blocks
        Their numbers.

    Returns
    -------
    Linkage or None
        None where most of the control is on them, or nothing else is left that moves.
    """
    control = linkage.control
    assert control is not None
    gone = np.zeros(linkage.assembly.n_blocks, dtype=bool)
    gone[blocks] = True
    support = linkage.assembly.support | gone
    weight = np.linalg.norm(control.along, axis=1)
    if support.all() or weight[gone[control.block]].sum() > MAX_PART_FALLEN * weight.sum():
        return None
    held = _ties_of_others(linkage.assembly, blocks)
    ties = tuple(linkage.assembly.ties[tie] for tie in held)
    structure = replace(linkage.structure, assembly=replace(linkage.assembly, support=support, ties=ties))
    none = np.empty(0, dtype=np.int64)  # the next motion tells which ties hold, and which are slack
    kept = np.flatnonzero(~gone[linkage.contacts.pair].any(axis=1))
    return replace(
        linkage,
        structure=structure,
        contacts=linkage.contacts.select(kept),
        sticking=linkage.sticking[kept],
        sliding=linkage.sliding[kept],
        ties=none,
        slack=none,
    )


def without_ties_of_blocks(pose: Pose, assembly: Assembly, blocks: Ints) -> Pose:
    """Return a pose of an assembly from which blocks are left out, and the ties on them.

    Parameters
    ----------
    pose
        Of the whole assembly.
    assembly
        Its blocks and ties.
    blocks
        Numbers of the blocks, as `without_blocks` has them.

    Returns
    -------
    Pose
        What the other ties have yielded by is in their order.
    """
    kept = pose.yielded[_ties_of_others(assembly, blocks)] if len(pose.yielded) else pose.yielded
    return replace(pose, yielded=kept)


def _ties_of_others(assembly: Assembly, blocks: Ints) -> Ints:
    """Numbers of the ties that are on none of some blocks."""
    return np.flatnonzero(~np.isin(tied_pairs(assembly), blocks).any(axis=1))
