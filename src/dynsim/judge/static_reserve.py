"""What statics prove about an assembly: how much a run has to resolve, and whether friction beyond Coulomb's matters.

Bullet bounds the friction of a contact point in two directions at right angles. Where the slip is oblique to both,
that is up to sqrt(2) times Coulomb friction. So a run may stand on forces that are beyond the friction cone at points
of a joint. Others within it may hold the blocks as well, as in most walls: statics can tell. The resultant on a plane
between two blocks cannot leave the cone if the force at each point is in its own, so it tells where statics cannot be
asked.

Blocks that fit exactly overlap in Bullet by what its shapes are rounded to, and contacts push such overlaps apart.
Where no motion takes them away, as in a dovetail, the push is not used up, and joints carry many times what all loads
press.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.limit_load import limit_load
from blockstat.analysis.verdict import Outcome
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.loads import horizontal
from blockstat.typing import Floats
from dynsim.engine.friction import STICKY, block_friction, common_friction, has_own_friction
from dynsim.judge.criteria import default_threshold
from dynsim.judge.run import Run
from dynsim.judge.verdict import DynamicOutcome, DynamicVerdict
from dynsim.loads.ground import Pulse, Record
from dynsim.loads.load import Load
from dynsim.loads.loading import Constant, Push

#: Bullet's own error of limits, as a share of the weight (docs/bullet.md): what has more reserve does not fall by it.
OWN_ERROR = 0.02
#: Resolution of a run where statics do not prove that much.
FINE = 1e-4
#: Relative width of the brackets of the sideways limits.
TOLERANCE = 1e-2
#: Friction of a joint above the coefficient by more than this share is beyond the cone. The forces of a run are exact
#: to rounding; Bullet's limit of a block that slides along one of the two directions is exact to a quarter of it. By
#: this share a joint is pressed by more than all weight.
BEYOND = 1e-2
#: Begins what a verdict says about such friction.
OBLIQUE = "in Bullet the stand needs friction that Coulomb's law does not give"
#: Begins what it says where blocks creep.
SLOWED = "in Bullet the blocks only creep on friction that Coulomb's law does not give"
#: Begins what a verdict says of joints that are pressed by no load.
WEDGED = "in Bullet the blocks are wedged"


class StaticReserve:
    """Two facts about an assembly under its weight, each found when it is first asked for."""

    def __init__(self, assembly: Assembly, interfaces: Interfaces) -> None:
        self._assembly, self._interfaces = assembly, interfaces

    @cached_property
    def equilibrium(self) -> bool:
        """Whether there is a certified equilibrium with Coulomb friction."""
        return assess(self._assembly, flow="coulomb", interfaces=self._interfaces).outcome is Outcome.STABLE

    @cached_property
    def sideways(self) -> float:
        """Least horizontal acceleration [g] that force fields carry towards +x, -x, +y and -y."""
        least = float("inf")
        for axis in horizontal(self._assembly):
            for direction in (axis, -axis):
                found = limit_load(self._assembly, direction, interfaces=self._interfaces, tolerance=TOLERANCE)
                least = min(least, found.lower)
        return least

    def resolution(self, asked: float) -> float:
        """Return the imbalance that a run has to be able to see.

        Parameters
        ----------
        asked : float
            What was asked for, as a share of the weight.

        Returns
        -------
        float
            The same where an equilibrium with Coulomb friction is proven and the reserve to the sides exceeds Bullet's
            own error, so that a slow collapse is excluded by statics; at most `FINE` elsewhere.
        """
        return asked if self.sideways >= OWN_ERROR and self.equilibrium else min(asked, FINE)


@dataclass(frozen=True)
class FrictionExcess:
    """The joint whose friction is furthest beyond Coulomb's."""

    joint: tuple[str, str]  #: its blocks
    ratio: float  #: of friction over pressure
    friction: float  #: the coefficient
    joints: int  #: beyond their cones
    by_statics: bool  #: whether statics were asked for an equilibrium, and proved none
    creeps: bool = False  #: whether the blocks were still moving

    @property
    def factor(self) -> float:
        """How many times the coefficient the ratio is."""
        return self.ratio / self.friction

    @property
    def warning(self) -> str:
        """What a verdict must say."""
        more = f" (and {self.joints - 1} more)" * (self.joints > 1)
        begins, so = (SLOWED, "they may slide") if self.creeps else (OBLIQUE, "the stand is not proven")
        return (
            f'{begins}: the joint between "{self.joint[0]}" and "{self.joint[1]}"{more} carries friction of '
            f"{self.ratio:.3g} times its pressure, and its coefficient is {self.friction:.3g}"
            + ("; statics prove no equilibrium with Coulomb friction either" * self.by_statics)
            + f", so {so}"
        )


def friction_excess(
    run: Run, interfaces: Interfaces, loads: Sequence[Load], resolution: float, reserve: StaticReserve | None = None
) -> FrictionExcess | None:
    """Return the joint whose friction at the end of a run is furthest beyond Coulomb's, where that matters.

    Parameters
    ----------
    run : Run
        A run that ended without a fall.
    interfaces : Interfaces
        Joints of its assembly.
    loads : sequence of Load
        Those of the run.
    resolution : float
        Imbalance that the run would have shown, as a share of the weight: what is beyond by less of the weight of the
        lighter block is not counted.
    reserve : StaticReserve, optional
        Of the same blocks, where no loads act: what it knows is not asked again.

    Returns
    -------
    FrictionExcess or None
        None where the points of all joints are within their cones, where statics prove an equilibrium with Coulomb
        friction, and where the engine keeps no normals. Where statics cannot be asked, the resultants of the joints
        count, which are within the cone however the points share them.
    """
    if not (found := _beyond(run, interfaces, resolution, resultant=False)):
        return None
    held = held_by_statics(run, interfaces, loads, reserve)
    if held:
        return None
    # The resultant is the plainer evidence; where a block turns in a joint, its points alone are beyond.
    found = _beyond(run, interfaces, resolution, resultant=True) or (found if held is not None else [])
    if not found:
        return None
    _, ratio, friction, joint = max(found)
    return FrictionExcess(joint, ratio, friction, len(found), by_statics=held is not None)


@dataclass(frozen=True)
class Wedging:
    """The joint that is pressed most where the pressure is none that loads make."""

    joint: tuple[str, str]  #: its blocks
    share: float  #: its pressure, relative to all weight and loads

    @property
    def warning(self) -> str:
        """What a verdict must say."""
        return (
            f'{WEDGED}: the joint between "{self.joint[0]}" and "{self.joint[1]}" carries {self.share:.3g} times all '
            "weight and loads, and statics find no equilibrium with Coulomb friction without self-stress, so the stand "
            "is not proven"
        )


def wedging(
    run: Run, interfaces: Interfaces, loads: Sequence[Load], reserve: StaticReserve | None = None
) -> Wedging | None:
    """Return the joint that is pressed most at the end of a run, where that is self-stress.

    Parameters
    ----------
    run, interfaces, loads, reserve
        As in `friction_excess`.

    Returns
    -------
    Wedging or None
        None where no joint carries more than all weight and loads together, where statics prove an equilibrium with
        Coulomb friction, as in a flat arch, and where they cannot be asked.
    """
    assembly = run.assembly
    weight = assembly.free_weight
    given = float(np.linalg.norm(_constant(assembly, loads)[:, :3], axis=1).sum())
    most = max(run.contacts.planes(), key=lambda plane: plane.pressure, default=None)
    if most is None or most.pressure <= (1 + BEYOND) * (weight + given):
        return None
    if held_by_statics(run, interfaces, loads, reserve) is not False:
        return None
    names = assembly.names[most.pair[0]], assembly.names[most.pair[1]]
    return Wedging(names, most.pressure / (weight + given))


def doubted(
    verdict: DynamicVerdict, interfaces: Interfaces, loads: Sequence[Load], reserve: StaticReserve | None
) -> DynamicVerdict:
    """Return a verdict with what makes its stand doubtful.

    Parameters
    ----------
    verdict : DynamicVerdict
        As the blocks moved.
    interfaces, loads, reserve
        As in `friction_excess`.

    Returns
    -------
    DynamicVerdict
        With a warning and a `friction_excess`, or with a warning and `wedged`, where one of these applies.
    """
    if verdict.outcome is DynamicOutcome.FALLS:
        return verdict
    creeps = verdict.outcome is DynamicOutcome.CREEPS
    excess = friction_excess(verdict.run, interfaces, loads, verdict.resolution, reserve)
    if excess is not None:
        excess = replace(excess, creeps=creeps)
        return replace(verdict, warnings=(*verdict.warnings, excess.warning), friction_excess=excess.factor)
    wedge = None if creeps else wedging(verdict.run, interfaces, loads, reserve)
    if wedge is None:
        return verdict
    return replace(verdict, warnings=(*verdict.warnings, wedge.warning), wedged=wedge.share)


def _beyond(
    run: Run, interfaces: Interfaces, resolution: float, *, resultant: bool
) -> list[tuple[float, float, float, tuple[str, str]]]:
    """Joints beyond their cones: times the coefficient, ratio of friction over pressure, coefficient, blocks."""
    assembly = run.assembly
    own = has_own_friction(assembly, interfaces)
    rough = block_friction(assembly, interfaces) if own else common_friction(assembly)
    weight = np.where(assembly.support, np.inf, assembly.mass * np.linalg.norm(assembly.gravity))
    beyond = []
    for plane in run.contacts.planes():
        a, b = plane.pair
        friction = float(rough[a] * rough[b])
        if friction >= STICKY * (1 - BEYOND) or friction == 0:
            continue
        carried = plane.friction if resultant else plane.at_points
        allowed = np.tan(np.arctan(friction) + plane.spread) * plane.pressure
        if carried > (1 + BEYOND) * allowed + resolution * min(weight[a], weight[b]):
            ratio = carried / plane.pressure
            beyond.append((ratio / friction, ratio, friction, (assembly.names[a], assembly.names[b])))
    return beyond


def held_by_statics(
    run: Run, interfaces: Interfaces, loads: Sequence[Load], reserve: StaticReserve | None = None
) -> bool | None:
    """Return whether statics prove an equilibrium with Coulomb friction of the blocks as built.

    Parameters
    ----------
    run : Run
        A run that ended at rest.
    interfaces : Interfaces
        Joints of its assembly.
    loads : sequence of Load
        Those of the run.
    reserve : StaticReserve, optional
        Of the same blocks, where no loads act.

    Returns
    -------
    bool or None
        None where statics of the blocks as built do not apply: a load moved or removed supports or blocks or tilted the
        ground, blocks lie further away than the default threshold, or a joint law has no statics of this kind.
    """
    assembly = run.assembly
    moved = float(np.linalg.norm(run.displacement[-1], axis=1).max())
    if not all(isinstance(load, (Constant, Pulse, Record, Push)) for load in loads):
        return None
    if moved >= default_threshold(assembly):
        return None
    given = _constant(assembly, loads)
    try:
        if reserve is not None and not loads:
            return reserve.equilibrium
        found = assess(assembly, loads=given, flow="coulomb", interfaces=interfaces, score=False)
    except InputError:
        return None
    return found.outcome is Outcome.STABLE


def _constant(assembly: Assembly, loads: Sequence[Load]) -> Floats:
    """What acts from the beginning to the end, shape (n_blocks, 6) [N, N m]."""
    none = np.zeros((assembly.n_blocks, 6))
    return sum((load.wrenches(assembly) for load in loads if isinstance(load, Constant)), start=none)
