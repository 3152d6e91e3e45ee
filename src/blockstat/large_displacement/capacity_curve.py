"""The capacity curve: load multiplier against displacement, from the first motion to the end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.point_law import last_law
from blockstat.errors import InputError, check_choice, known_options
from blockstat.large_displacement.contacts import first_contacts
from blockstat.large_displacement.jump import statuses
from blockstat.large_displacement.linkage import Control, Linkage
from blockstat.large_displacement.loading import Structure, control_of, loading
from blockstat.large_displacement.path import Begin, Follower, PathEnd, PathEvent, State
from blockstat.large_displacement.pose import Pose, rest
from blockstat.large_displacement.statics import LACKING, limiting
from blockstat.large_displacement.steps import Left, follow, of_steps
from blockstat.result import Result, Sentence, finite
from blockstat.solve.dispatch import CHOICES
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Contacts that move apart at less than this in the first mechanism, whose fastest corner moves at 1, stick.
STILL = 1e-5


#: A bracket at rest wider than this, relative, is told.
WIDE = 1e-3


class CapacityOutcome(Sentence):
    """How a capacity curve ends; each value is the sentence a user reads."""

    ZERO = "Zero: the multiplier reaches zero; beyond this displacement the weight alone drives the mechanism."
    REACHED = "Reached: the displacement asked for is reached."
    COLLAPSE = "Collapse: no admissible state with a positive multiplier follows at this displacement."
    LOST = "Lost: the mechanism could not be followed any further; what lies beyond is not known."
    INTERRUPTED = "Interrupted: the curve is known up to here."


@dataclass(frozen=True, eq=False)
class CapacityPoint:
    """One state on a capacity curve."""

    displacement: float  #: of the control [m]
    lower: float  #: multiplier that forces carry
    upper: float  #: multiplier at which the mechanism moves
    pose: Pose  #: where the blocks are
    mechanism: Floats  #: rate of the pose for a unit rate of the displacement, shape (n_blocks, 6)
    opened: Ints  #: joints that are open somewhere, numbers of interfaces


@dataclass(frozen=True, eq=False)
class CapacityCurve(Result):
    """A load multiplier against the displacement of a control, with a bracket at each point."""

    outcome: CapacityOutcome
    points: tuple[CapacityPoint, ...]
    events: tuple[PathEvent, ...]  #: changes of the mechanism, in order; two points of the curve stand at each
    control: str  #: what the displacement is
    limit: LimitLoad  #: the limit load that the curve starts from
    warnings: tuple[str, ...]
    timings: dict[str, float]

    @property
    def displacement(self) -> Floats:
        """Displacement of the control, shape (k,) [m].

        Twice the same where the mechanism jumps. It ascends on a linkage; followed by steps it may go back.
        """
        return np.array([point.displacement for point in self.points])

    @property
    def lower(self) -> Floats:
        """Multipliers that forces carry, shape (k,)."""
        return np.array([point.lower for point in self.points])

    @property
    def upper(self) -> Floats:
        """Multipliers at which the mechanism moves, shape (k,)."""
        return np.array([point.upper for point in self.points])

    @property
    def assembly(self) -> Assembly:
        """The blocks at rest."""
        return self.limit.assembly

    @property
    def interfaces(self) -> Interfaces:
        """The joints at rest."""
        return self.limit.interfaces

    def at(self, displacement: float) -> tuple[float, float]:
        """Return the bracket at a displacement, on straight lines between points.

        Parameters
        ----------
        displacement : float
            Of the control [m], between 0 and that of the last point. At a jump, what follows it.

        Returns
        -------
        lower, upper : float
            The multipliers.

        Raises
        ------
        InputError
            For a displacement that is not on the curve.
        """
        there = self.displacement
        if not 0 <= displacement <= there.max():
            raise InputError(f"displacement is {displacement!r}; the curve is known from 0 to {there.max():.6g} m")
        last = int(np.flatnonzero(there <= displacement)[-1])
        if last + 1 == len(there) and there[last] < displacement:  # the control has come back from there
            last = int(np.flatnonzero((there[:-1] - displacement) * (there[1:] - displacement) <= 0)[-1])
        rows = slice(last, last + 2)
        lower, upper = (float(np.interp(displacement, there[rows], of[rows])) for of in (self.lower, self.upper))
        return lower, upper

    def explain(self) -> str:
        """Return the answer in words.

        Returns
        -------
        str
            One fact a line.
        """
        first, last = self.points[0], self.points[-1]
        most = f", {first.upper:.6g} with associated friction," if first.upper > (1.0 + WIDE) * first.lower else ""
        lines = [
            self.outcome.value,
            f"Displacement: {self.control}.",
            f"Multiplier {first.lower:.6g}{most} at rest, {last.lower:.6g} at {last.displacement:.6g} m, "
            f"{len(self.points)} points.",
        ]
        for event in self.events:
            after = "no admissible state follows" if event.after is None else f"to {event.after:.6g}"
            opened, shut = (", ".join(self._called(joints)) for joints in (event.opened, event.shut))
            what = "; ".join(text for text in (opened and f"opens {opened}", shut and f"shuts {shut}") if text)
            lines.append(
                f"{event.kind.capitalize()} at {event.parameter:.6g} m from {event.before:.6g}: {after}"
                + (f" ({what})." if what else ".")
            )
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

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
            "control": self.control,
            "displacement": self.displacement.tolist(),
            "lower": [finite(value) for value in self.lower],
            "upper": [finite(value) for value in self.upper],
            "open": [[list(self._pair(k)) for k in point.opened] for point in self.points],
            "events": [
                {
                    "kind": event.kind,
                    "displacement": event.parameter,
                    "before": event.before,
                    "after": event.after,
                    "opens": [list(self._pair(k)) for k in event.opened],
                    "shuts": [list(self._pair(k)) for k in event.shut],
                }
                for event in self.events
            ],
            "blocks": self.assembly.n_blocks,
            "interfaces": self.interfaces.n_interfaces,
            "warnings": list(self.warnings),
            "timings": self.timings,
        }

    def _pair(self, joint: int) -> tuple[str, str]:
        a, b = self.interfaces.pair[joint]
        return self.assembly.names[a], self.assembly.names[b]

    def _called(self, joints: tuple[int, ...]) -> list[str]:
        return ["-".join(self._pair(k)) for k in joints[:4]] + (["..."] if len(joints) > 4 else [])


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
    each: Callable[[CapacityPoint | PathEvent | Left], None] | None = None,
) -> CapacityCurve:
    """Follow the mechanism of a limit load to large displacements: multiplier against displacement.

    Parameters
    ----------
    assembly : Assembly
        The blocks, their supports, friction, ties and joint laws.
    load : array_like or sequence
        What the multiplier multiplies: three numbers, the direction of an acceleration as strong as gravity, a wrench
        on each block, shape (n_blocks, 6) [N, N m], or a sequence of (block, point, force). Forces keep their direction
        and act at the same points of the blocks: those of an acceleration and of wrenches at centroids.
    control : str, int or (block, point), optional
        Whose displacement the curve is drawn against. A block means its centroid, a group the centroid of all its
        mass, a block and a point that point of it [m], "mean" the mean of all displacements weighted by the load, which
        is conjugate to it. By default it is the corner that moves most along the load when motion begins (of several,
        that which moves most in all). In all cases it is the component along the load.
    loads : array_like or sequence, optional
        Permanent loads besides the weight, given like `load`, but no acceleration.
    friction, gap, interfaces, solver : optional
        As in `blockstat.limit_load`.
    flow : str, optional
        "coulomb": joints slide without opening. "associated": they open by friction times slip as they slide.
    displacement : float, optional
        Where to stop [m]; by default where the multiplier is zero.
    steps : int, optional
        About how many points the curve has. Steps become shorter where it bends.
    tolerance : float, optional
        Largest deviation of the curve from straight lines between points, relative to the multiplier where a piece
        begins; a hundredth of it, relative to a step, is how well changes of the mechanism are located.
    progress : callable, optional
        Told displacement and multiplier at each point.
    each : callable, optional
        Told each point, each change of the mechanism and all blocks that fall out, in order and as soon as they are
        known. So they are kept whatever happens to the rest. Of two changes at one place the curve keeps the last.

    Returns
    -------
    CapacityCurve
        Up to where it was interrupted, if it was.

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
    At each point forces at the displaced geometry prove the lower bound and the mechanism there the upper one. Several
    admissible states may exist at one displacement. The one that is followed leaves rest continuously, and at a jump
    falls along the joint that newly opens, at constant displacement, until a joint shuts. Where the mechanism is no
    linkage, it is followed by finite steps (`large_displacement.steps`): the pose then depends on their length, and
    more `steps` tell by how much.

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
    _check_numbers(steps=steps, tolerance=tolerance, displacement=displacement)
    assembly = assembly if friction is None else assembly.with_(friction=friction)
    start = rest(assembly)
    dead, live = loading(assembly, loads), loading(assembly, load, live=True)
    limit = _started(assembly, live.at(assembly, start), dead.at(assembly, start), gap, interfaces, solver)
    structure = Structure(limit.assembly, limit.interfaces, dead, live, solver)
    linkage = _first_linkage(limit, control_of(limit, live, control), dilates=flow == "associated")
    follower = Follower(structure, structure.multiplier, _begin(structure), displacement or np.inf, np.inf, tolerance)
    follower = replace(follower, step=_first_step(follower, linkage, start, limit, steps))
    found, events, left, outcome = _followed(follower, linkage, start, limit, steps, progress, each)
    states, points = [state for state, _ in found], tuple(point for _, point in found)
    unproven = sum(not state.forces.proven for state in states)
    warnings = list(limit.warnings)
    if unproven:
        warnings.append(f"at {unproven} of {len(states)} points forces balance to the solver's tolerance only")
    warnings += of_steps(states, assembly)
    for item in left:
        names = ", ".join(f'"{assembly.names[block]}"' for block in item.blocks)
        warnings.append(f"{names}: fallen out at {item.parameter:.4g} m and left out from there on")
    seconds = {"limit": limit.timings["total"], "total": process_time() - began}
    assert linkage.control is not None
    return CapacityCurve(outcome, points, tuple(events), linkage.control.name, limit, tuple(warnings), seconds)


def _check_numbers(*, steps: Any, tolerance: Any, displacement: Any) -> None:
    if isinstance(steps, bool) or not isinstance(steps, (int, np.integer)) or steps < 1:
        raise InputError(f"steps is {steps!r}; it must be a whole number of at least 1")
    if not (isinstance(tolerance, (int, float)) and 0 < tolerance <= 0.1):
        raise InputError(f"tolerance is {tolerance!r}; it must be above 0 and at most 0.1")
    if displacement is not None and not (isinstance(displacement, (int, float)) and 0 < displacement < np.inf):
        raise InputError(f"displacement is {displacement!r}; it must be above 0")


def _started(
    assembly: Assembly, live: Floats, dead: Floats, gap: float | str, interfaces: Interfaces | None, solver: str
) -> LimitLoad:
    """The limit load, if there is a mechanism to follow."""
    limit = limit_load(assembly, live, loads=dead, gap=gap, interfaces=interfaces, solver=solver)
    if limit.outcome is LoadOutcome.UNBOUNDED:
        raise InputError(f'"{assembly.name}" carries any multiple of the load: no mechanism to follow')
    if limit.outcome is not LoadOutcome.LIMIT:
        raise InputError(f'"{assembly.name}": no limit load to start from. {limit.outcome.value}')
    if any(law is not None and law.compression is not None for law in last_law(limit.assembly, limit.interfaces)):
        raise InputError("joints with compressive strength crush at their hinges, which is not followed; leave it out")
    return limit


def _first_linkage(limit: LimitLoad, control: Control, *, dilates: bool) -> Linkage:
    """The linkage of the mechanism of a limit load."""
    assembly = limit.assembly
    contacts = first_contacts(assembly, limit.interfaces)
    everything = np.ones(contacts.number, dtype=bool)
    whole = Linkage(assembly, contacts, everything, ~everything, np.empty(0, dtype=np.int64), control, dilates)
    pinned, sliding = statuses(whole, rest(assembly), 0.0, limit.mechanism, still=STILL)
    endless = np.array([k for k, tie in enumerate(assembly.ties) if np.isinf(tie.greatest)], dtype=np.int64)
    return replace(whole, pinned=pinned, sliding=sliding, ties=endless)


def _begin(structure: Structure) -> Begin:
    """How a mechanism is found where contacts have closed: that of the limit load at the displaced geometry."""

    def begin(linkage: Linkage, pose: Pose, parameter: float, still: float) -> tuple[Linkage, Floats] | None:
        found = limiting(structure, linkage.contacts, linkage.pinned | linkage.sliding, pose, parameter)
        if found is None:
            return None
        pinned, sliding = statuses(linkage, pose, parameter, found[1], still=still)
        return replace(linkage, pinned=pinned, sliding=sliding), found[1]

    return begin


def _first_step(follower: Follower, linkage: Linkage, pose: Pose, limit: LimitLoad, steps: int) -> float:
    """The part of the way to where the tangent at rest meets zero, and of the size of the assembly at most."""
    extent = float(np.ptp(limit.assembly.vertices[~limit.assembly.support[limit.assembly.vertex_block]], axis=0).max())
    largest = min(extent, follower.end) / steps
    state = follower.first(linkage, pose, limit.mechanism)
    if state is None:
        assert linkage.control is not None
        raise InputError(f"control: the {linkage.control.name} does not move the mechanism; choose another block")
    if state.forces.lacking > LACKING:  # finite steps, shorter where the multiplier changes much
        return largest
    probe = 1e-4 * largest
    ahead = follower.ahead(state, probe)
    slope = np.nan if ahead is None else (ahead.value - state.motion.value) / probe
    return min(largest, state.motion.value / -slope / steps) if slope < 0 else largest


def _followed(
    follower: Follower,
    linkage: Linkage,
    pose: Pose,
    limit: LimitLoad,
    steps: int,
    progress: Callable[[float, float], None] | None,
    each: Callable[[CapacityPoint | PathEvent | Left], None] | None,
) -> tuple[list[tuple[State, CapacityPoint]], list[PathEvent], list[Left], CapacityOutcome]:
    """All states with their points, the events, and how it ends; what is done when it is interrupted stays."""
    found: list[tuple[State, CapacityPoint]] = []
    events: list[PathEvent] = []
    left: list[Left] = []
    outcome = CapacityOutcome.INTERRUPTED
    tell = each or (lambda _: None)
    try:
        for item in follow(follower, linkage, pose, limit.mechanism, change=1.0 / steps):
            if isinstance(item, Left):
                left.append(item)
                tell(item)
            elif isinstance(item, State):
                point = _point(follower.structure, item, limit)
                found.append((item, point))
                tell(point)
                if progress is not None:
                    progress(item.motion.parameter, item.motion.value)
            elif isinstance(item, PathEvent):
                if events and item.kind == events[-1].kind == "change" and follower.meets(item, events[-1]):
                    item = replace(item, before=events.pop().before)  # the mixture of both was no mechanism
                events.append(item)
                tell(item)
            else:
                assert isinstance(item, PathEnd)
                outcome = CapacityOutcome[item.name]
    except KeyboardInterrupt:
        if not found:
            raise
    return found, events, left, outcome


def _point(structure: Structure, state: State, limit: LimitLoad) -> CapacityPoint:
    """A state as a point of the curve."""
    motion, linkage = state.motion, state.linkage
    lower = upper = motion.value
    if not motion.parameter and state.forces.lacking > LACKING:
        lower, upper = limit.lower, limit.upper  # no forces go with this mechanism without dilatancy
    elif not motion.parameter:
        lower, upper = min(limit.lower, lower), max(limit.upper, upper)
    elif state.open is not None:
        upper = max(upper, state.upper or upper)
    elif linkage.rubs:
        closed = linkage.pinned | linkage.sliding
        found = limiting(structure, linkage.contacts, closed, motion.pose, motion.parameter)
        upper = upper if found is None else max(upper, found[0])
    touching = np.bincount(linkage.contacts.joint, ~(linkage.pinned | linkage.sliding), limit.interfaces.n_interfaces)
    return CapacityPoint(motion.parameter, lower, upper, motion.pose, motion.rate, np.flatnonzero(touching))
