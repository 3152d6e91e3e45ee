"""Supports that move until the assembly falls: reaction and cracks against the movement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.large_displacement.contacts import Contacts, first_contacts, gaps
from blockstat.large_displacement.jump import statuses
from blockstat.large_displacement.linkage import Linkage
from blockstat.large_displacement.loading import Structure, loading
from blockstat.large_displacement.path import Begin, Follower, PathEvent, State
from blockstat.large_displacement.pose import Pose, rest
from blockstat.large_displacement.statics import settled
from blockstat.large_displacement.steps import Left, follow, of_steps
from blockstat.result import Result, Sentence, plain
from blockstat.studies.foundations import Settlement, settle
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Contacts that move apart at less than this in the first mechanism, relative to the supports, stick.
STILL = 1e-5
#: How far from rest the mechanism that leaves it is looked for, relative to the size of the assembly, and how often.
#: There, mechanisms of the same energy at rest differ by about that part of it. Programs are solved to 1e-8, so of the
#: dearer ones 1e-8 / NEAR is left, which must not be more than STILL.
NEAR, TRIALS = 1e-8 / STILL, 5
#: Lengths below this fraction of the largest block are rounding.
ROUNDING = 1e-9


class PathOutcome(Sentence):
    """How a settlement ends; each value is the sentence a user reads."""

    COLLAPSE = "Collapse: beyond this movement of the supports no admissible forces exist, and the assembly falls."
    REACHED = "Reached: the assembly stands at the movement asked for."
    FOLLOWS = "Follows: nothing resists this movement; the assembly follows its supports as one body."
    LOST = "Lost: the mechanism jams or slides in a way that is not followed further; what lies beyond is not known."
    INTERRUPTED = "Interrupted: the path is known up to here."


@dataclass(frozen=True, eq=False)
class SettlementPath(Result):
    """The assembly on supports that move further and further."""

    outcome: PathOutcome
    first: Settlement  #: what happens when they begin to move
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
            At the last point up to this movement [m]; by default at the end.

        Returns
        -------
        list of ((str, str), float)
            Blocks and largest opening [m].
        """
        last = len(self.displacement) - 1
        if displacement is not None:
            last = max(int(np.searchsorted(self.displacement, displacement, side="right")) - 1, 0)
        width, names, pair = self.openings[last], self.first.assembly.names, self.first.interfaces.pair
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
            f"Movement {1e3 * self.displacement[-1]:.6g} mm; reaction along it {self.reaction[0]:.6g} N at first, "
            f"{self.reaction[-1]:.6g} N at the end.",
        ]
        lines += [f"{event.kind.capitalize()} at {1e3 * event.parameter:.6g} mm." for event in self.events]
        cracks = self.cracks()
        if cracks:
            lines.append(f"{len(cracks)} joints are open at the end. The widest are:")
            lines += [f"  {a} and {b}: {plain(1e3 * width)} mm" for (a, b), width in cracks[:limit]]
        return "\n".join([*lines, *warnings])

    @property
    def _rounding(self) -> float:
        """Openings and movements up to this are rounding [m]."""
        return ROUNDING * float(self.first.assembly.size.max())

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
        As `blockstat.settle`.

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
    assembly = assembly if friction is None else assembly.with_(friction=friction)
    dead, start = loading(assembly, loads), rest(assembly)
    at_rest = dead.at(assembly, start)
    first = settle(assembly, moves, loads=at_rest, gap=gap, interfaces=interfaces, solver=solver)
    structure = Structure(first.assembly, first.interfaces, dead, None, solver)
    motion = np.where(first.assembly.support[:, None], 0.0, first.mechanism) / first.displacement
    linkage = _linkage(first, motion)
    size = float(np.ptp(assembly.vertices[~assembly.support[assembly.vertex_block]], axis=0).max())
    end = size if displacement is None else displacement

    def value(pose: Pose, rate: Floats) -> float:
        return float((structure.dead_load(pose) * rate).sum()) + structure.tie_work(pose, rate)

    def begin(there: Linkage, pose: Pose, parameter: float, still: float) -> tuple[Linkage, Floats] | None:
        found = settled(structure, there.contacts, there.pinned | there.sliding, pose, parameter)
        if found.multiplier is None:
            return None
        pinned, sliding = statuses(there, pose, parameter, found.motion, drive=1.0, still=still, lift=found.lift)
        return replace(there, pinned=pinned, sliding=sliding), found.motion

    follower = Follower(structure, value, begin, end, end / steps, tolerance, ends_at_zero=False)
    linkage, motion = _leaving(begin, linkage, start, motion, size)
    if linkage.pinned.all():
        states, events, outcome = [follower.first(linkage, start, motion)], [], PathOutcome.FOLLOWS
    else:
        states, events, outcome = _followed(follower, linkage, start, motion, progress)
    return _path(first, structure, [state for state in states if state is not None], events, outcome)


def _linkage(first: Settlement, motion: Floats) -> Linkage:
    """The linkage of the first mechanism, on supports that move."""
    assembly, faces = first.assembly, first.interfaces
    contacts = first_contacts(assembly, faces)
    drive = np.zeros((contacts.number, 2, 3))
    for part in first.foundations:
        own = np.isin(contacts.joint, part.joints)
        side = assembly.support[contacts.pair]
        drive[own[:, None] & side] = part.displacement / first.displacement
    contacts = replace(contacts, drive=drive)
    everything = np.ones(contacts.number, dtype=bool)
    endless = np.array([k for k, tie in enumerate(assembly.ties) if np.isinf(tie.greatest)], dtype=np.int64)
    whole = Linkage(assembly, contacts, everything, ~everything, endless, None)
    pinned, sliding = statuses(whole, rest(assembly), 0.0, motion, drive=1.0, still=STILL)
    return replace(whole, pinned=pinned, sliding=sliding)


def _leaving(begin: Begin, linkage: Linkage, start: Pose, motion: Floats, size: float) -> tuple[Linkage, Floats]:
    """The mechanism that leaves rest: next to rest, where it has led itself, it is the mechanism still.

    At rest several may have the least potential energy: a symmetrical thrust line touches more joints than open.
    """
    everything = np.ones(linkage.contacts.number, dtype=bool)
    whole = replace(linkage, pinned=everything, sliding=~everything)
    found = begin(whole, start, 0.0, STILL)
    linkage, motion = found or (linkage, motion)
    for _ in range(0 if linkage.sliding.any() else TRIALS):
        speed = float(corner_speed(linkage.assembly, motion).max(initial=0.0))
        if not speed:
            break
        length = NEAR * size / speed
        near = linkage.shifted(start, length * linkage.of_bodies(motion), linkage.origins(start))
        found = begin(whole, near, length, STILL)
        if found is None or found[0].sliding.any():  # contact points of what slides are not those of rest
            break
        same = (found[0].pinned == linkage.pinned).all() and (found[0].sliding == linkage.sliding).all()
        linkage, motion = found
        if same:
            break
    return linkage, motion


def _followed(
    follower: Follower, linkage: Linkage, pose: Pose, motion: Floats, progress: Callable[[float, float], None] | None
) -> tuple[list[State | None], list[PathEvent], PathOutcome]:
    """All states and events, and how it ends; what is done when it is interrupted stays."""
    states: list[State | None] = []
    events: list[PathEvent] = []
    outcome = PathOutcome.INTERRUPTED
    try:
        for item in follow(follower, linkage, pose, motion, change=np.inf):
            if isinstance(item, State):
                states.append(item)
                if progress is not None:
                    progress(item.motion.parameter, item.motion.value)
            elif isinstance(item, PathEvent):
                events.append(item)
            elif not isinstance(item, Left):
                outcome = PathOutcome[item.name]
    except KeyboardInterrupt:
        if not states:
            raise
    return states, events, outcome


def _path(
    first: Settlement, structure: Structure, states: Sequence[State], events: Sequence[PathEvent], outcome: PathOutcome
) -> SettlementPath:
    if not states:
        raise InputError(f'"{first.assembly.name}": the blocks are jammed between the moving supports')
    widths = []
    for state in states:
        contacts: Contacts = state.linkage.contacts
        gap = gaps(structure.assembly, contacts, state.motion.pose, state.motion.parameter)
        gap = np.where(state.linkage.pinned | state.linkage.sliding, 0.0, np.maximum(gap, 0.0))
        width = np.zeros(first.interfaces.n_interfaces)
        np.maximum.at(width, contacts.joint, gap)
        widths.append(width)
    warnings = [*first.warnings, *of_steps(states, structure.assembly)]
    if structure.assembly.joints and any(law.compression is not None for law in structure.assembly.joints):
        warnings.append("crushing at hinges is not followed")
    return SettlementPath(
        outcome=outcome,
        first=first,
        displacement=np.array([state.motion.parameter for state in states]),
        reaction=np.array([state.motion.value for state in states]),
        openings=np.array(widths),
        poses=tuple(state.motion.pose for state in states),
        events=tuple(events),
        warnings=tuple(warnings),
    )
