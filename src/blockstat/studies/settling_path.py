"""Supports that move until the assembly falls: reaction and cracks against the movement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_number, known_options
from blockstat.large_displacement.displaced.common_beds import in_common_planes
from blockstat.large_displacement.displaced.contact_pairs import gaps
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED_AT_REST
from blockstat.large_displacement.displaced.loads import moved_with_centroids, read_loads
from blockstat.large_displacement.displaced.local_origin import structure_about_middle
from blockstat.large_displacement.displaced.pose import Pose, free_sizes, rest_pose
from blockstat.large_displacement.displaced.structure import Structure, why_not_followed
from blockstat.large_displacement.finite_steps.fall import FallenBlocks
from blockstat.large_displacement.finite_steps.free_motion import SAME_ENERGY
from blockstat.large_displacement.finite_steps.whole_path import follow_path, path_options, warnings_on_accuracy
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.kinematics import pose_at
from blockstat.large_displacement.linkage.linkage import Linkage, linkage_at_rest
from blockstat.large_displacement.linkage.path import PathEnd, PathEvent, PathFault, PathState
from blockstat.large_displacement.linkage.state_solver import StateSolver
from blockstat.large_displacement.mechanism_finder import MechanismFinder
from blockstat.large_displacement.shared_slip import joints_that_slide_alone
from blockstat.large_displacement.statics.settling_state import settling_state
from blockstat.large_displacement.strength import warning_of_strength
from blockstat.program.ties import bearing_ties, tied_pairs
from blockstat.result import Result, Sentence, plain
from blockstat.studies.foundations import Settlement, settle
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: How far from rest the mechanism that leaves it is looked for. Relative to the extent of the assembly. There,
#: mechanisms of the same energy at rest differ in energy by about that part of it. Programs are solved to 1e-8, so a
#: part 1e-8 / NEAR_REST of the mechanisms of more energy is left in the answer, which must stay below the speed at
#: which contacts stick.
NEAR_REST = 1e-8 / STICKING_SPEED_AT_REST
#: A reaction below this is none. Relative to the weight. Programs are solved to that accuracy.
ZERO_REACTION = 1e-8
#: Reactions that differ by less are the same. Relative to the larger. Chosen: the default tolerance of a path.
SAME_REACTION = 1e-4
#: How often that is repeated at most. Chosen: it settles after one or two.
MAX_TRIALS = 5
#: Openings and movements below this are rounding. Relative to the largest block. Chosen: far above rounding, far below
#: any crack.
ROUNDING = 1e-9
#: Movements up to this beyond the end of a path are its end. Relative to it. Chosen: ten times the default tolerance.
END = 1e-3


class PathOutcome(Sentence):
    """How a settlement ends; each value is the sentence a user reads."""

    COLLAPSE = "Collapse: beyond this movement of the supports no admissible forces exist, and the assembly falls."
    REACHED = "Reached: the assembly stands at the movement asked for."
    FOLLOWS = "Follows: what rests on the moving supports follows them; no joint opens or slides."
    LOST = "Lost: the mechanism jams or slides in a way that is not followed further; what lies beyond is not known."
    INTERRUPTED = "Interrupted: the path is known up to here."


@dataclass(frozen=True, eq=False)
class SettlementPath(Result):
    """The assembly on supports that move further and further."""

    outcome: PathOutcome
    first: Settlement  #: what happens when they begin to move; of motions with the same energy, that which is followed
    displacement: Floats  #: of the foundation that moves furthest, ascending, shape (k,) [m]
    #: force of the assembly on the moving supports along their movement, its work per unit of `displacement`, (k,) [N]
    reaction: Floats
    openings: Floats  #: largest opening of each joint, shape (k, n_interfaces) [m]
    poses: tuple[Pose, ...]  #: where the blocks are
    events: tuple[PathEvent, ...]  #: changes of the mechanism
    warnings: tuple[str, ...] = ()

    @property
    def collapse(self) -> float | None:
        """The largest movement that the assembly carries [m]; None where it does not fall on the path."""
        return float(self.displacement[-1]) if self.outcome is PathOutcome.COLLAPSE else None

    def cracks(self, displacement: float | None = None) -> list[tuple[tuple[str, str], float]]:
        """Return the joints that are open, the widest first.

        Parameters
        ----------
        displacement : float, optional
            At this movement [m]; by default at the end.

        Returns
        -------
        list of ((str, str), float)
            Blocks and largest opening [m]. Between two points of the path it lies on the straight line through them.

        Raises
        ------
        InputError
            For a movement that is no number, or that the path does not reach.
        """
        width = self.openings[-1] if displacement is None else self._openings_at(displacement)
        names, pair = self.first.assembly.names, self.first.interfaces.pair
        order = [k for k in np.argsort(-width, kind="stable") if width[k] > self._rounding]
        return [((names[pair[k, 0]], names[pair[k, 1]]), float(width[k])) for k in order]

    def explain(self, limit: int = 5) -> str:
        """Return the answer in words.

        Parameters
        ----------
        limit : int, optional
            Most cracks that are named.

        Returns
        -------
        str
            One fact a line.
        """
        warnings = [f"Warning: {text}" for text in self.warnings]
        if self.outcome is PathOutcome.LOST and self.displacement[-1] <= self._rounding:
            return "\n".join([self.outcome.value, *warnings])
        lines = [
            self.outcome.value,
            f"Movement {1e3 * self.displacement[-1]:.6g} mm; reaction along it, without dilatancy, "
            f"{self.reaction[0]:.6g} N at first, {self.reaction[-1]:.6g} N at the end.",
        ]
        lines += [f"{event.kind.capitalize()} at {1e3 * event.parameter:.6g} mm." for event in self.events]
        cracks = self.cracks()
        if cracks:
            end = f"{1e3 * self.displacement[-1]:.6g} mm"
            lines.append(f"Joints that are open at the end, after {end}: {len(cracks)}. The widest are:")
            lines += [f"  {a} and {b}: {plain(1e3 * width)} mm" for (a, b), width in cracks[:limit]]
        return "\n".join([*lines, *warnings])

    def _openings_at(self, displacement: float) -> Floats:
        """Largest opening of each joint at a movement, shape (n_interfaces,) [m].

        Blocks jump from one point to the next, so before a jump the line is that through the two points before it.
        """
        check_number("displacement", displacement)
        there = self.displacement
        if self.outcome is not PathOutcome.FOLLOWS:
            check_number("displacement", displacement, least=0.0, most=float(there[-1]) * (1.0 + END))
        after = int(np.searchsorted(there, displacement, side="right"))
        if not 0 < after < len(there):
            return self.openings[min(after, len(there) - 1)]
        if any(event.kind == "jump" and there[after - 1] < event.parameter <= there[after] for event in self.events):
            after -= after > 1
        low, high = there[after - 1], there[after]
        part = (displacement - low) / (high - low) if high > low else 0.0
        line: Floats = self.openings[after - 1] + part * (self.openings[after] - self.openings[after - 1])
        return line

    @property
    def _rounding(self) -> float:
        """Openings and movements up to this are rounding [m]."""
        return ROUNDING * float(free_sizes(self.first.assembly).max())

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "displacement": self.displacement.tolist(),
            "reaction": self.reaction.tolist(),
            "collapse": self.collapse,
            "cracks": [{"blocks": list(pair), "opening": width} for pair, width in self.cracks()],
            "events": [{"kind": event.kind, "displacement": event.parameter} for event in self.events],
            "warnings": list(self.warnings),
        }


@known_options
def settle_to_collapse(
    assembly: Assembly,
    moves: Mapping[Any, Sequence[float]],
    *,
    friction: float | None = None,
    loads: Any = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    displacement: float | None = None,
    steps: int = 30,
    tolerance: float = 1e-4,
    solver: str = "auto",
    progress: Callable[[float, float], None] | None = None,
) -> SettlementPath:
    """Move parts of the supports further and further, until the assembly falls.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand.
    moves : mapping
        Directions of the movements, as in `blockstat.settle`; several parts move in proportion.
    friction, gap, interfaces, solver : optional
        As in `blockstat.assess`.
    loads : optional
        As in `blockstat.capacity`.
    displacement : float, optional
        Of the part that moves furthest, where to stop [m]; by default the size of the assembly.
    steps : int, optional
        About how many points the path has.
    tolerance : float, optional
        As in `blockstat.capacity`, of the reaction.
    progress : callable, optional
        Told movement and reaction at each point.

    Returns
    -------
    SettlementPath
        Up to where it was interrupted, if it was.

    Raises
    ------
    InputError
        As `blockstat.settle`, for joints with compressive strength or cells, and for options that cannot be used.

    Notes
    -----
    The state has a memory: hinges stay where they have formed until no admissible forces are left with them.

    References
    ----------
    Ochsendorf, J. (2006). The masonry arch on spreading supports. The Structural Engineer 84(2).

    Examples
    --------
    A thin arch on a support that yields outwards opens three hinges, and falls when it is 5 % of its span away.

    >>> from blockstat import settle_to_collapse
    >>> from blockstat.model import arch, assemble
    >>> ring = assemble(arch(span=1.85, thickness=0.15, depth=0.5, voussoirs=10, springers=0.3), friction=0.7)
    >>> found = settle_to_collapse(ring, {"springer.right": (1, 0, 0)})
    >>> print(found.outcome.word, f"{found.collapse:.3f}")
    collapse 0.109
    """
    tolerance, displacement = path_options(steps=steps, tolerance=tolerance, displacement=displacement)
    assembly = assembly if friction is None else assembly.with_(friction=friction)
    dead, start = read_loads(assembly, loads), rest_pose(assembly)
    at_rest = dead.wrenches(assembly)
    options: dict[str, Any] = {"gap": gap, "interfaces": interfaces, "solver": solver}
    first = settle(assembly, moves, friction=friction, loads=at_rest, **options)
    joints = in_common_planes(first.assembly, first.interfaces)
    if joints is not first.interfaces:
        options["interfaces"] = joints
        again = settle(assembly, moves, friction=friction, loads=at_rest, **options)
        first = replace(again, warnings=tuple(dict.fromkeys(first.warnings + again.warnings)))
    if reason := why_not_followed(first.assembly, first.interfaces):
        raise InputError(reason)
    first = replace(first, warnings=(*first.warnings, *moved_with_centroids(assembly, {"loads": loads})))
    support, rates = first.assembly.support[:, None], first.mechanism / first.displacement
    acting = replace(first.assembly, ties=bearing_ties(first.assembly))
    moving = np.where(support, rates, 0.0)
    structure, _ = structure_about_middle(acting, first.interfaces, dead, None, solver, moving)
    motion = rates - moving
    linkage = linkage_at_rest(structure, motion, None, drive=_drive(first))
    size = float(np.ptp(assembly.vertices[~assembly.support[assembly.vertex_block]], axis=0).max())
    end = size if displacement is None else displacement
    states = StateSolver(structure, structure.dead_power)
    none = ZERO_REACTION * structure.assembly.free_weight
    finder = MechanismFinder(states)
    follower = LinkageFollower(states, finder, end, end / steps, tolerance, ends_at_zero=False, least=none)
    linkage, motion = _mechanism_that_leaves_rest(finder, linkage, start, motion, size)
    alone = joints_that_slide_alone(states, linkage, start, motion)
    if alone is not None:
        linkage, motion = alone[:2]
        follower = replace(follower, step=alone.step(follower.step))
        first = replace(first, warnings=(*first.warnings, alone.told))
    if linkage.sticking.all() and _moves_straight(acting, motion) and _ties_ride(acting, motion + moving):
        whole = states.first(linkage, start, motion)
        return _path(first, structure, [] if whole is None else [whole], [], PathOutcome.FOLLOWS)
    found, events, outcome, told = _followed(follower, linkage, start, motion, progress)
    first = replace(first, warnings=(*first.warnings, *told))
    return _path(first, structure, _with_strength_at_rest(found, linkage, start), events, outcome)


def _moves_straight(assembly: Assembly, motion: Floats) -> bool:
    """Whether no block turns. Blocks on edges and corners may turn while these stick, and slide as they turn on."""
    spin = np.abs(motion[:, 3:]).max(initial=0.0) * float(free_sizes(assembly).max())
    return bool(spin <= STICKING_SPEED_AT_REST * float(corner_speed(assembly, motion).max(initial=0.0)))


def _with_strength_at_rest(states: list[PathState], linkage: Linkage, start: Pose) -> list[PathState]:
    """The states of a path; at rest no joint is open, so that all have their tensile strength, which opening ends."""
    if not states or states[0].point.parameter > 0 or not any(law.strong for law in linkage.assembly.joints):
        return states
    closed = np.ones(linkage.contacts.number, dtype=bool)
    reaction = settling_state(replace(linkage, sticking=closed, sliding=~closed).configuration(start, 0.0)).multiplier
    if reaction is None or np.isinf(reaction):
        return states
    return [replace(states[0], point=replace(states[0].point, value=reaction)), *states[1:]]


def _ties_ride(assembly: Assembly, motion: Floats) -> bool:
    """Whether both ends of each tie move alike, so that it keeps its length."""
    ends = motion[tied_pairs(assembly)]
    return bool((np.abs(np.diff(ends, axis=1)) <= ROUNDING * np.abs(motion).max(initial=0.0)).all())


def _drive(first: Settlement) -> Floats:
    """Movement of the sides of each joint by a unit movement of the supports, shape (n_interfaces, 2, 3)."""
    drive = np.zeros((first.interfaces.n_interfaces, 2, 3))
    side = first.assembly.support[first.interfaces.pair]
    for part in first.foundations:
        own = np.isin(np.arange(len(drive)), part.joints)
        drive[own[:, None] & side] = part.displacement / first.displacement
    return drive


def _mechanism_that_leaves_rest(
    finder: MechanismFinder, linkage: Linkage, start: Pose, motion: Floats, size: float
) -> tuple[Linkage, Floats]:
    """The mechanism that is still the one of least energy at the pose near rest to which it has led.

    At rest several mechanisms may have the least potential energy: the thrust line of a symmetrical arch touches more
    edges than there are hinges in a mechanism. The pose is one of the linkage: along a straight line its ties would
    lengthen by the square of the way, as if they had yielded, or grow slack.
    """
    closed = np.ones(linkage.contacts.number, dtype=bool)
    whole = replace(linkage, sticking=closed, sliding=~closed)
    found = finder(whole, start, 0.0, STICKING_SPEED_AT_REST)
    linkage, motion = (linkage, motion) if isinstance(found, PathEnd) else found
    for _ in range(0 if linkage.sliding.any() else MAX_TRIALS):
        speed = float(corner_speed(linkage.assembly, motion).max(initial=0.0))
        if not speed:
            break
        length = NEAR_REST * size / speed
        near = pose_at(linkage, start, length, length * motion)
        if near is None:
            break
        found = finder(whole, near, length, STICKING_SPEED_AT_REST)
        # Contact points of joints that slide are not those of rest.
        if isinstance(found, PathEnd) or found[0].sliding.any():
            break
        same = (found[0].sticking == linkage.sticking).all() and (found[0].sliding == linkage.sliding).all()
        linkage, motion = found
        if same:
            break
    return linkage, motion


def _with_its_motion(first: Settlement, structure: Structure, begins: PathState) -> Settlement:
    """The settlement with the motion in which a path begins, if that is one of the least potential energy, too.

    A solver answers with a mixture of all that are, and the supports bear the same forces in each.
    """
    motion, linkage = begins.point.tangent, begins.linkage
    moving = np.where(first.assembly.support[:, None], first.mechanism, 0.0)
    rates = (first.mechanism - moving) / first.displacement
    power = [structure.dead_power(begins.point.pose, 0.0, each) for each in (rates, motion)]
    speed = max(float(corner_speed(first.assembly, motion).max(initial=0.0)), 1.0)
    same = abs(power[1] - power[0]) <= SAME_ENERGY * speed * first.assembly.free_weight
    if begins.point.parameter > 0 or linkage.sliding.any() or not same:
        return first
    return replace(first, mechanism=first.displacement * motion + moving)


def _followed(
    follower: LinkageFollower,
    linkage: Linkage,
    pose: Pose,
    motion: Floats,
    progress: Callable[[float, float], None] | None,
) -> tuple[list[PathState], list[PathEvent], PathOutcome, list[str]]:
    """All states and events, how the path ends and what is told of it; or what was found when it was interrupted."""
    states: list[PathState] = []
    told: list[str] = []
    events: list[PathEvent] = []
    before: list[int] = []  # states before each event
    outcome = PathOutcome.INTERRUPTED
    try:
        first = follower.solver.first(linkage, pose, motion)
        for item in follow_path(follower, linkage, pose, motion, first, change=np.inf):
            if isinstance(item, PathState):
                states.append(item)
                if progress is not None:
                    progress(item.point.parameter, item.point.value)
            elif isinstance(item, PathEvent):
                events.append(item)
                before.append(len(states))
            elif isinstance(item, PathFault):
                told.append(item.told)
            elif not isinstance(item, FallenBlocks):
                outcome = PathOutcome.LOST if item is PathEnd.LOCKED else PathOutcome[item.name]
    except KeyboardInterrupt:
        if not states:
            raise
    if outcome is PathOutcome.COLLAPSE:
        states, events = _before_the_fall(states, events, before, follower.tolerance * follower.step)
    return states, events, outcome, told


def _before_the_fall(
    states: list[PathState], events: list[PathEvent], before: list[int], near: float
) -> tuple[list[PathState], list[PathEvent]]:
    """The path without what the blocks pass as they fall: where a jump lands, and no movement of the supports follows.

    Forces may balance a pose in which blocks that fall meet, and none do as soon as the supports move on. That pose is
    no state in which the assembly stands, and its forces are not those that it fell at.
    """
    end = states[-1].point.parameter
    falls = [k for k, event in enumerate(events) if event.kind == "jump" and end - event.parameter <= near]
    if not falls or not before[falls[0]]:
        return states, events
    first = falls[0]
    return states[: before[first]], [*events[:first], replace(events[first], after=None)]


def _openings(states: Sequence[PathState], n_interfaces: int) -> Floats:
    """Largest opening of each joint in each state, shape (n_states, n_interfaces) [m].

    A joint whose faces have left each other, or whose blocks have fallen out, keeps the last that it had.
    """
    width = np.zeros((len(states), n_interfaces))
    for k, (state, own) in enumerate(zip(states, width, strict=True)):
        linkage, point = state.linkage, state.point
        gap = gaps(linkage.assembly, linkage.contacts, point.pose, point.parameter)
        np.maximum.at(own, linkage.contacts.joint, np.where(linkage.closed, 0.0, np.maximum(gap, 0.0)))
        lost = np.bincount(linkage.contacts.joint, minlength=n_interfaces) == 0
        own[lost] = width[k - 1, lost] if k else 0.0
    return width


def _warning_of_other_forces(first: Settlement, reaction: float, none: float) -> list[str]:
    """What a reader must know where the path begins with another reaction than `settle` has."""
    if abs(reaction - first.reaction) <= SAME_REACTION * max(abs(reaction), abs(first.reaction)) + none:
        return []
    return [
        f"at first the reaction is {reaction:.6g} N where joints slide without opening, and {first.reaction:.6g} N "
        "where they open by friction times slip, as `settle` has it. Both are in equilibrium at rest: `thrust_range` "
        "gives the least and the greatest reaction that is"
    ]


def _path(
    first: Settlement,
    structure: Structure,
    states: Sequence[PathState],
    events: Sequence[PathEvent],
    outcome: PathOutcome,
) -> SettlementPath:
    if not states:
        raise InputError(f'"{first.assembly.name}": the blocks are jammed between the moving supports')
    first = _with_its_motion(first, structure, states[0])
    warnings = [*first.warnings, *warning_of_strength(structure, states)]
    warnings += warnings_on_accuracy(states, structure)
    reaction = np.array([state.point.value for state in states])
    none = np.abs(reaction) <= ZERO_REACTION * structure.assembly.free_weight
    if states[0].point.parameter == 0:
        warnings += _warning_of_other_forces(first, float(reaction[0]), ZERO_REACTION * structure.assembly.free_weight)
    return SettlementPath(
        outcome=outcome,
        first=first,
        displacement=np.array([state.point.parameter for state in states]),
        reaction=np.where(none, 0.0, reaction),
        openings=_openings(states, first.interfaces.n_interfaces),
        poses=tuple(state.point.pose for state in states),
        events=tuple(events),
        warnings=tuple(warnings),
    )
