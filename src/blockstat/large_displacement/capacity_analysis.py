"""The capacity analysis: from the limit load along the mechanism until the multiplier is zero."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.verdict import unit_motion
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.tolerance import ROUNDING
from blockstat.errors import InputError, check_choice, known_options
from blockstat.large_displacement.capacity_curve import CapacityCurve, CapacityOutcome, CapacityPoint
from blockstat.large_displacement.displaced.common_beds import in_common_planes
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED_AT_REST
from blockstat.large_displacement.displaced.control import Control, read_control
from blockstat.large_displacement.displaced.loads import moved_with_centroids, read_loads
from blockstat.large_displacement.displaced.local_origin import control_about, structure_about_middle
from blockstat.large_displacement.displaced.pose import Pose, free_sizes, rest_pose
from blockstat.large_displacement.displaced.structure import Structure, why_not_followed
from blockstat.large_displacement.finite_steps.fall import FallenBlocks
from blockstat.large_displacement.finite_steps.whole_path import follow_path, path_options, warnings_on_accuracy
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.linkage import Linkage, linkage_at_rest
from blockstat.large_displacement.linkage.parts import part_that_moves_control
from blockstat.large_displacement.linkage.path import PathEnd, PathEvent, PathFault, PathState
from blockstat.large_displacement.linkage.state_solver import A_LITTLE_WAY, StateSolver
from blockstat.large_displacement.mechanism_finder import MechanismFinder
from blockstat.large_displacement.self_stress import (
    carried_below_the_beginning,
    carried_without_self_stress,
    told_of_self_stress,
)
from blockstat.large_displacement.shared_slip import joints_that_slide_alone
from blockstat.large_displacement.statics.limit_state import associated_multiplier
from blockstat.large_displacement.strength import warning_of_strength
from blockstat.result import listed
from blockstat.solve.dispatch import CHOICES
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Step with which the slope of the curve at rest is measured. Relative to the largest step. Chosen: large enough for
#: the change of the multiplier to be above rounding.
SLOPE_STEP = 1e-4
#: Half way to the probe the multiplier is off the straight line by less than this part of its change. Chosen: on a
#: smooth curve it is off by `SLOPE_STEP`, and where the multiplier leaps on the way, and there is no slope, by a half.
STRAIGHT = 0.25
#: How far a curve goes at most, relative to the extent of the assembly. Chosen: what has moved so far has left it, as a
#: block that a load lifts.
FAR = 2.0
FAR_AWAY = "no displacement was asked for: the curve ends twice the extent of the assembly away, and not at zero"
#: Finite steps begin at the limit load when they begin no lower than by this, relative to it. Chosen: what corners that
#: miss planes may take from it where their distance is small beside the blocks.
SAME_BEGINNING = 1e-2
#: Blocks that a warning names at most. Chosen.
MOST_NAMES = 5
#: What is told of a curve while it is followed.
Item = CapacityPoint | PathEvent | FallenBlocks


@known_options
def capacity(
    assembly: Assembly,
    load: Any,
    *,
    control: str | int | tuple[str | int, Sequence[float]] | None = None,
    loads: Any = None,
    friction: float | None = None,
    flow: str = "coulomb",
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    displacement: float | None = None,
    steps: int = 30,
    tolerance: float = 1e-4,
    solver: str = "auto",
    progress: Callable[[float, float], None] | None = None,
    each: Callable[[CapacityPoint | PathEvent | FallenBlocks], None] | None = None,
) -> CapacityCurve:
    """Follow the mechanism of a limit load to large displacements: multiplier against displacement.

    Parameters
    ----------
    assembly : Assembly
        The blocks, their supports, friction, ties and joint laws.
    load : array_like or sequence
        The load that the multiplier multiplies: three numbers, the direction of an acceleration as strong as gravity, a
        wrench on each block, shape (n_blocks, 6) [N, N m], or a sequence of (block, point, force). Forces keep their
        direction and their point of application on the block; those of an acceleration and of wrenches act at
        centroids.
    control : str, int or (block, point), optional
        The point whose displacement along the load the curve is drawn against. A block means its centroid, a group the
        centroid of all its mass, a block and a point that point of it [m]. "mean" is the mean of all displacements
        weighted by the load, which is conjugate to it. By default it is the corner that moves most along the load when
        motion begins; of several such corners, the one that moves most in all.
    loads : array_like or sequence, optional
        Permanent loads besides the weight, given like `load`, but no acceleration.
    friction, gap, interfaces, solver : optional
        As in `blockstat.limit_load`.
    flow : str, optional
        "coulomb": joints slide without opening (non-associated flow). "associated": they open by friction times slip as
        they slide.
    displacement : float, optional
        Where to stop [m]; by default where the multiplier is zero, or twice the extent of the assembly away.
    steps : int, optional
        About how many points the curve has. Steps become shorter where it bends.
    tolerance : float, optional
        Largest deviation of the curve from straight lines between points, relative to the multiplier where a piece
        begins. Changes of the mechanism are located to a hundredth of it, relative to a step.
    progress : callable, optional
        Called with displacement and multiplier at each point.
    each : callable, optional
        Called with each point, each change of the mechanism and all blocks that fall out, in order and as soon as they
        are known. So they are kept whatever happens to the rest. Of two changes at one place the curve keeps the last.

    Returns
    -------
    CapacityCurve
        If it was interrupted, up to there.

    Raises
    ------
    InputError
        When there is no limit load, for a control that does not move, or for a law that is not followed.

    References
    ----------
    Circolare 21 gennaio 2019, n. 7 C.S.LL.PP., C8.7.1.2.1. Livesley: Limit analysis of structures formed from rigid
    blocks, 1978.

    Notes
    -----
    At each point forces at the displaced geometry prove the lower bound, and the mechanism there proves the upper one.
    Several admissible states may exist at one displacement. The one that is followed leaves rest continuously. At a
    jump it falls along the joint that newly opens, at constant displacement, until a joint closes. Of equal mechanisms
    that do not touch, the one that moves the control is followed, and a warning names the others. Where the mechanism
    is no linkage, it is followed by finite steps (`large_displacement.finite_steps`): the pose then depends on their
    length, and a curve with more `steps` shows by how much.

    Examples
    --------
    A block of 0.5 m by 2 m turns about its toe: tan(angle of its diagonal less its turn), zero when that is vertical.

    >>> from blockstat import Assembly, box, capacity
    >>> blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="block")]
    >>> curve = capacity(Assembly.from_blocks(blocks, supports=["ground"]), (1, 0, 0), control="block")
    >>> print(curve.outcome.word, f"{curve.lower[0]:.6f} {curve.displacement[-1]:.6f}")
    zero 0.250000 0.250000
    """
    began = process_time()
    check_choice("solver", solver, CHOICES)
    check_choice("flow", flow, FLOWS)
    tolerance, displacement = path_options(steps=steps, tolerance=tolerance, displacement=displacement)
    assembly = assembly if friction is None else assembly.with_(friction=friction)
    start = rest_pose(assembly)
    dead, live = read_loads(assembly, loads), read_loads(assembly, load, live=True)
    wrenches = live.wrenches(assembly), dead.wrenches(assembly)
    limit = _checked_limit_load(assembly, *wrenches, friction, gap, interfaces, solver, flow)
    moved = read_control(limit, live, control)
    structure, origin = structure_about_middle(limit.assembly, limit.interfaces, dead, live, solver)
    near = control_about(moved, origin)
    linkage, begun = _linkage_that_begins(structure, limit, near, associated=flow == "associated")
    states = StateSolver(structure, structure.multiplier)
    finder = MechanismFinder(states)
    linkage, begun = _without_unstable_mixture(finder, linkage, begun)
    alone = joints_that_slide_alone(states, linkage, start, begun.mechanism)
    linkage, motion = (linkage, begun.mechanism) if alone is None else alone[:2]
    first = states.first(linkage, start, motion)
    end = displacement or FAR * float(np.ptp(assembly.vertices, axis=0).max())
    step = _first_step(states, first, limit.assembly, end, steps)
    step = step if alone is None else alone.step(step)
    follower = LinkageFollower(states, finder, end, step, tolerance)
    record = _followed(follower, linkage, start, motion, begun, first, steps, progress, each)
    if not record.points:
        raise InputError(f'"{assembly.name}": the mechanism of the limit load cannot be followed from rest')
    all_move, equal = _equal_parts(record, limit, linkage.left_at_rest)
    told = [
        *([] if alone is None else [alone.told]),
        *warning_of_strength(structure, record.states),
        *moved_with_centroids(assembly, {"load": load, "loads": loads}),
        *equal,
        *([FAR_AWAY] if displacement is None and record.outcome is CapacityOutcome.REACHED else []),
    ]
    carried = None
    if record.outcome is not CapacityOutcome.INTERRUPTED and _may_hold_by_self_stress(linkage):
        carried, more = _below_the_beginning(limit, *wrenches, solver, record.points[0].lower)
        told += more
    seconds = {"limit": limit.timings["total"], "total": process_time() - began}
    return CapacityCurve(
        outcome=record.outcome,
        points=tuple(record.points),
        events=tuple(record.events),
        control=moved.name,
        limit=limit if all_move else begun,
        warnings=_warnings(record, limit, structure, told),
        timings=seconds,
        fallen=tuple(record.fallen),
        without_self_stress=carried,
    )


def _checked_limit_load(
    assembly: Assembly,
    live: Floats,
    dead: Floats,
    friction: float | None,
    gap: float | str,
    interfaces: Interfaces | None,
    solver: str,
    flow: str,
) -> LimitLoad:
    """The limit load, if it has a mechanism that can be followed."""
    limit = limit_load(assembly, live, loads=dead, friction=friction, gap=gap, interfaces=interfaces, solver=solver)
    joints = in_common_planes(limit.assembly, limit.interfaces)
    if joints is not limit.interfaces:
        again = limit_load(assembly, live, loads=dead, friction=friction, gap=gap, interfaces=joints, solver=solver)
        limit = replace(again, warnings=tuple(dict.fromkeys(limit.warnings + again.warnings)))
    if limit.outcome is LoadOutcome.UNBOUNDED:
        told, own = "", (limit.assembly, live, dead, limit.interfaces, solver)
        found = carried_without_self_stress(*own) if flow == "coulomb" else None
        if found is not None and np.isfinite(found[1]):
            told = (
                ", as joints that open as they slide wedge the blocks. Without dilatancy and self-stress "
                f'limit_load(flow="coulomb") finds that {found[0]:.4g} to {found[1]:.4g} is carried'
            )
        raise InputError(f'"{assembly.name}" carries any multiple of the load: no mechanism to follow{told}')
    if limit.outcome is not LoadOutcome.LIMIT:
        raise InputError(f'"{assembly.name}": no limit load to start from. {limit.outcome.value}')
    if reason := why_not_followed(limit.assembly, limit.interfaces):
        raise InputError(reason)
    return limit


def _linkage_that_begins(
    structure: Structure, limit: LimitLoad, control: Control, *, associated: bool
) -> tuple[Linkage, LimitLoad]:
    """The linkage at rest, and the limit load with its mechanism: that of the control alone where others are equal."""
    linkage = linkage_at_rest(structure, limit.mechanism, control, associated=associated)
    part = part_that_moves_control(linkage, limit.mechanism)
    if part is None:
        return linkage, limit
    motion, left = part
    own = structure.multiplier(rest_pose(structure.assembly), 0.0, motion)
    alone = replace(limit, mechanism=unit_motion(limit.assembly, motion), upper=max(limit.upper, own))
    linkage = linkage_at_rest(structure, alone.mechanism, control, associated=associated)
    return replace(linkage, left_at_rest=left), alone


def _below_the_beginning(
    limit: LimitLoad, live: Floats, dead: Floats, solver: str, begins: float
) -> tuple[tuple[float, float] | None, list[str]]:
    """What is carried without self-stress where the curve begins above it, and what to tell of that.

    An interrupt ends the question, and the curve is kept.
    """
    try:
        found = carried_below_the_beginning(limit.assembly, live, dead, limit.interfaces, solver, begins)
    except KeyboardInterrupt:
        return None, ["interrupted before it was known whether the curve begins by self-stress alone"]
    return found, [] if found is None else [told_of_self_stress(found, begins)]


def _may_hold_by_self_stress(linkage: Linkage) -> bool:
    """Whether joints slide without opening where a curve begins, or ties hold it back."""
    return not linkage.associated and (linkage.slides_with_friction or bool(linkage.assembly.ties))


def _equal_parts(record: _Record, limit: LimitLoad, left: Ints) -> tuple[bool, list[str]]:
    """Whether blocks that were to be left at rest have moved after all, and what is told of them."""
    fast = limit.moving[np.isin(limit.moving, left)]
    moved = record.points[-1].pose.displacement - record.points[0].pose.displacement
    size = float(free_sizes(limit.assembly).max())
    moves = bool((np.abs(moved[left]) > CORNER_TOLERANCE * size).any())
    if not len(fast):
        return moves, []
    fast = np.sort(fast)
    names = listed([f'"{limit.assembly.names[block]}"' for block in fast], MOST_NAMES)
    fate = "move too" if moves else "are left at rest"
    return moves, [f"other parts begin to move at the same multiplier and {fate}: {names}"]


def _without_unstable_mixture(finder: MechanismFinder, linkage: Linkage, begun: LimitLoad) -> tuple[Linkage, LimitLoad]:
    """The mechanism at rest, or the one onto which it would roll off."""
    shut = replace(linkage, sticking=np.ones_like(linkage.sticking), sliding=np.zeros_like(linkage.sliding))
    start, own = rest_pose(begun.assembly), (linkage, begun.mechanism)
    rolled, motion = finder.without_unstable_mixture(shut, start, 0.0, STICKING_SPEED_AT_REST, own)
    if rolled is linkage:
        return linkage, begun
    value = linkage.structure.multiplier(start, 0.0, motion)
    return rolled, replace(begun, mechanism=unit_motion(begun.assembly, motion), upper=max(begun.upper, value))


def _first_step(states: StateSolver, state: PathState | None, assembly: Assembly, end: float, steps: int) -> float:
    """The largest step [m]: a part of the way to where the tangent at rest meets zero, or of the assembly's extent."""
    extent = float(np.ptp(assembly.vertices[~assembly.support[assembly.vertex_block]], axis=0).max())
    largest = min(extent, end) / steps
    if state is None or not state.forces.admissible:  # followed by finite steps, which shorten where the value changes
        return largest
    if state.point.value <= 0:  # the joints that open lose their tension, and the path ends
        return largest
    probe = SLOPE_STEP * largest
    half, ahead = (states.point_at(state, part * probe) for part in (0.5, 1.0))
    if half is None or ahead is None:
        return largest
    lost = state.point.value - ahead.value
    bend = abs(half.value - 0.5 * (state.point.value + ahead.value))
    if not lost > 0 or bend > STRAIGHT * lost:
        return largest
    return min(largest, state.point.value / (lost / probe) / steps)


@dataclass(eq=False)
class _Record:
    """What has been found of a curve."""

    states: list[PathState] = field(default_factory=list)
    points: list[CapacityPoint] = field(default_factory=list)
    events: list[PathEvent] = field(default_factory=list)
    fallen: list[FallenBlocks] = field(default_factory=list)
    faults: list[PathFault] = field(default_factory=list)
    outcome: CapacityOutcome = CapacityOutcome.INTERRUPTED


def _followed(
    follower: LinkageFollower,
    linkage: Linkage,
    pose: Pose,
    motion: Floats,
    limit: LimitLoad,
    first: PathState | None,
    steps: int,
    progress: Callable[[float, float], None] | None,
    each: Callable[[Item], None] | None,
) -> _Record:
    """The whole path, or what was found of it when it was interrupted."""
    record = _Record()
    tell = each or (lambda _: None)
    try:
        for item in follow_path(follower, linkage, pose, motion, first, change=1.0 / steps):
            if isinstance(item, FallenBlocks):
                record.fallen.append(item)
                tell(item)
            elif isinstance(item, PathState):
                point = _capacity_point(item, limit)
                record.states.append(item)
                record.points.append(point)
                tell(point)
                if progress is not None:
                    progress(item.point.parameter, item.point.value)
            elif isinstance(item, PathEvent):
                last = record.events[-1] if record.events else None
                if last is not None and item.kind == last.kind == "change" and follower.coincide(item, last):
                    item = replace(item, before=record.events.pop().before)  # a mixture of two mechanisms was between
                record.events.append(item)
                tell(item)
            elif isinstance(item, PathFault):
                record.faults.append(item)
            else:
                assert isinstance(item, PathEnd)
                record.outcome = CapacityOutcome[item.name]
    except KeyboardInterrupt:
        if not record.points:
            raise
    return record


def _capacity_point(state: PathState, limit: LimitLoad) -> CapacityPoint:
    """A state as a point of the curve, with its bracket."""
    point, linkage = state.point, state.linkage
    lower = upper = point.value
    if not point.parameter and not state.forces.admissible:
        lower, upper = limit.lower, limit.upper  # this mechanism of non-associated flow balances no forces
    elif not point.parameter:
        lower, upper = min(limit.lower, lower), max(limit.upper, upper)
    elif state.residual_gap is not None:
        upper = max(upper, state.upper or upper)
    elif linkage.slides_with_friction:
        found = associated_multiplier(linkage.configuration(point.pose, point.parameter))
        upper = upper if found is None else max(upper, found)
    closed_points = np.bincount(linkage.contacts.joint, linkage.closed, limit.interfaces.n_interfaces)
    points = np.bincount(linkage.contacts.joint, minlength=limit.interfaces.n_interfaces)
    open_joints = np.flatnonzero((closed_points < points) | (points == 0))  # faces that have left each other have none
    return CapacityPoint(point.parameter, lower, upper, point.pose, point.tangent, open_joints)


def _warnings(record: _Record, limit: LimitLoad, structure: Structure, told: Sequence[str]) -> tuple[str, ...]:
    warnings, assembly = [*limit.warnings, *told, *(fault.told for fault in record.faults)], limit.assembly
    unproven = sum(not state.forces.proven for state in record.states)
    if unproven:
        warnings.append(
            f"at {unproven} of {len(record.states)} points the forces balance to the solver's tolerance only"
        )
    warnings += warnings_on_accuracy(record.states, structure)
    warnings += _begins_too_low(record, limit, structure)
    end = record.points[-1].displacement  # what falls beyond it began to fall there
    for item in record.fallen:
        names, where = ", ".join(f'"{assembly.names[block]}"' for block in item.blocks), min(item.parameter, end)
        warnings.append(f"{names}: fallen out at {where:.4g} m and left out from there on")
    return tuple(warnings)


def _begins_too_low(record: _Record, limit: LimitLoad, structure: Structure) -> list[str]:
    """What is told of finite steps that begin near rest below the limit load, with corners that miss planes."""
    drawn, near = structure.outlines.drawn, A_LITTLE_WAY * float(free_sizes(structure.assembly).max())
    stepped = (k for k, state in enumerate(record.states) if state.residual_gap is not None)
    first = record.points[next(stepped, 0)]
    low = first.lower < (1.0 - SAME_BEGINNING) * limit.lower
    if drawn.tilt <= ROUNDING or not low or record.states[-1].residual_gap is None or first.displacement > near:
        return []
    return [
        f"the finite steps begin near rest at {first.lower:.4g}, and the limit load at rest is {limit.lower:.4g}. "
        f"Faces of joints miss planes by up to {1e3 * drawn.distance:.2g} mm, and that alone may take the difference: "
        "use no such curve before `repair` has brought the faces of neighbours into common planes"
    ]
