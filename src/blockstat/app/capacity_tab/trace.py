"""What the page knows of a capacity curve: states and events in the order in which they were followed, plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from blockstat.assembly import Assembly
from blockstat.large_displacement.capacity_curve import CapacityPoint
from blockstat.large_displacement.finite_steps.fall import FallenBlocks
from blockstat.large_displacement.linkage.path import PathEvent
from blockstat.result import listed, millimetres, plain
from blockstat.typing import Floats
from blockstat.view.painter import posed

#: The control by default, the block that was clicked, and the mean weighted by the load; names come after these.
MOST: str = "the point that moves most"
CLICKED: str = "the block chosen"
MEAN = "mean"
#: Blocks that the list of controls names one by one: a browser takes a second to open a list of a thousand. Any other
#: block can be clicked.
MOST_NAMES = 300
NAMED = 4  #: blocks that an event names
MOST_EVENTS = 6  #: events that are written out


@dataclass(frozen=True, eq=False)
class Seen:
    """A state on the curve; the pose is in single precision, enough for a picture.

    Attributes
    ----------
    displacement : float
        Of the control [m].
    lower, upper : float
        Multiplier that forces carry, and multiplier at which the mechanism moves [g].
    moved : array of float, shape (n_blocks, 3)
        Displacements of the centroids [m].
    rotation : array of float, shape (n_blocks, 3, 3)
        Rotation matrices about the centroids.
    """

    displacement: float
    lower: float
    upper: float
    moved: np.ndarray = field(repr=False)
    rotation: np.ndarray = field(repr=False)

    @property
    def words(self) -> str:
        """Displacement and multiplier with their units."""
        low, high = plain(self.lower), plain(self.upper)
        multiplier = low if low == high else f"{low} to {high}"
        return f"displacement {millimetres(self.displacement)} mm, multiplier {multiplier} g"


@dataclass(frozen=True)
class Event:
    """A change on the curve.

    Attributes
    ----------
    kind : str
        "jump", "closing", "change" or "left".
    displacement : float
        Where, of the control [m].
    words : str
        What happens there.
    """

    kind: str
    displacement: float
    words: str


@dataclass(frozen=True)
class Finished:
    """A curve that was followed to its end.

    Attributes
    ----------
    sentence : str
        How it ends.
    control : str
        What the displacement is.
    events : tuple of Event
        Changes of the mechanism, without blocks that left; they replace those told on the way.
    warnings : tuple of str
        What a reader of the curve must know.
    """

    sentence: str
    control: str
    events: tuple[Event, ...]
    warnings: tuple[str, ...]


@dataclass(eq=False)
class Trace:
    """A curve as far as it is known.

    Attributes
    ----------
    push : str
        Direction of the load, a key of `blockstat.app.design.PUSHES`.
    states : list of Seen
        In order.
    events : list of Event
        In order.
    warnings : tuple of str
        Once the curve has been followed to its end.
    """

    push: str
    states: list[Seen] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    warnings: tuple[str, ...] = ()

    def take(self, message: Seen | Event | Finished) -> None:
        """Take in what the process tells that follows the curve.

        Parameters
        ----------
        message : Seen, Event or Finished
            Its message.
        """
        if isinstance(message, Seen):
            self.states.append(message)
        elif isinstance(message, Event):
            self.events.append(message)
        else:
            left = [event for event in self.events if event.kind == "left"]
            self.events = sorted([*message.events, *left], key=lambda event: event.displacement)
            self.warnings = message.warnings

    def plotted(self) -> tuple[Floats, Floats, Floats]:
        """Return what the figure shows.

        Returns
        -------
        displacement : array of float, shape (n_states,)
            Of the control [mm], in the order of the path; it may go back.
        lower, upper : array of float, shape (n_states,)
            The bracket on the multiplier [g], lower <= upper.

        Examples
        --------
        >>> import numpy as np
        >>> from blockstat.app.capacity_tab.trace import Seen, Trace
        >>> trace = Trace("+x")
        >>> trace.take(Seen(0.0125, 0.2, 0.21, np.zeros((1, 3)), np.eye(3)[None]))
        >>> [column.tolist() for column in trace.plotted()]
        [[12.5], [0.2], [0.21]]
        """
        rows = np.array([(1e3 * s.displacement, s.lower, s.upper) for s in self.states], dtype=float).reshape(-1, 3)
        lower, upper = np.minimum(rows[:, 1], rows[:, 2]), np.maximum(rows[:, 1], rows[:, 2])
        return rows[:, 0], lower, upper

    def vertices(self, assembly: Assembly, state: int) -> Floats:
        """Return where the vertices are in a state, in true scale.

        Parameters
        ----------
        assembly : Assembly
            The blocks at rest.
        state : int
            Number of the state.

        Returns
        -------
        array of float, shape (n_vertices, 3)
            [m].
        """
        at = self.states[state]
        return posed(assembly, at.moved, at.rotation)

    def notes(self) -> str:
        """Return the events and the warnings, a line each.

        Returns
        -------
        str
            HTML; empty where there are none.
        """
        events = [e for e in self.events if e.kind != "left" or not self.warnings]  # the warnings say who left
        rows = [f"{e.kind} at {millimetres(e.displacement)} mm: {e.words}" for e in events[:MOST_EVENTS]]
        if len(events) > MOST_EVENTS:
            rows.append(f"and {len(events) - MOST_EVENTS} more")
        rows += [f"Note: {text}." for text in self.warnings]
        return "".join(f"<div>{escape(row)}</div>" for row in rows)


def told(item: CapacityPoint | PathEvent | FallenBlocks, names: Sequence[str]) -> Seen | Event:
    """Return what the page is told of something on the path.

    Parameters
    ----------
    item : CapacityPoint, PathEvent or FallenBlocks
        As `blockstat.capacity` tells it.
    names : sequence of str
        Of the blocks.

    Returns
    -------
    Seen or Event
        Plain data.
    """
    if isinstance(item, CapacityPoint):
        moved, rotation = (array.astype(np.float32) for array in (item.pose.displacement, item.pose.rotation))
        return Seen(float(item.displacement), float(item.lower), float(item.upper), moved, rotation)
    if isinstance(item, PathEvent):
        after = "; no admissible state follows" if item.after is None else f" to {plain(item.after, 4)} g"
        after = "; any multiple is carried" if item.after == np.inf else after
        return Event(item.kind, float(item.parameter), f"from {plain(item.before, 4)} g{after}")
    gone = [names[int(block)] for block in item.blocks]
    return Event("left", float(item.parameter), listed(gone, NAMED))


def controls(assembly: Assembly) -> tuple[str, ...]:
    """Return the names by which the page offers controls.

    Parameters
    ----------
    assembly : Assembly
        The blocks.

    Returns
    -------
    tuple of str
        `MOST`, `CLICKED` and "mean", then the groups, and the free blocks where there are few.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> from blockstat.app.capacity_tab.trace import controls
    >>> blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="stone", group="wall")]
    >>> controls(Assembly.from_blocks(blocks, supports=["ground"]))
    ('the point that moves most', 'the block chosen', 'mean', 'wall', 'stone')
    """
    free = [int(block) for block in assembly.free]
    groups = sorted({assembly.groups[block] for block in free if assembly.groups[block]})
    blocks = [assembly.names[block] for block in free] if len(free) <= MOST_NAMES else []
    return tuple(dict.fromkeys([MOST, CLICKED, MEAN, *groups, *blocks]))
