"""What a path consists of: states, events between them, and its end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from blockstat.large_displacement.displaced.pose import Pose
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.statics.equilibrium import EquilibriumForces
from blockstat.large_displacement.statics.limit_state import LimitState
from blockstat.result import Sentence
from blockstat.typing import Floats

#: Finds the mechanism that begins at a pose: given a linkage whose closed contacts are the active set, the pose, the
#: parameter and the speed below which contacts stick, returns the linkage of the mechanism and its motion, shape
#: (n_blocks, 6). Where there is none it returns the end of the path there: `COLLAPSE`, `LOCKED` or `LOST`.
FindMechanism = Callable[[Linkage, Pose, float, float], "tuple[Linkage, Floats] | PathEnd"]


class PathEnd(Sentence):
    """How a path ends; each value is a sentence."""

    ZERO = "Zero: the multiplier reaches zero."
    REACHED = "Reached: the displacement asked for is reached."
    COLLAPSE = "Collapse: no admissible state follows at this displacement."
    LOCKED = "Locked: the blocks lock each other, and no motion follows."
    LOST = "Lost: the mechanism could not be followed any further; what lies beyond is not known."
    INTERRUPTED = "Interrupted: the path is known up to here."


def end_at(limit: LimitState) -> PathEnd | None:
    """Return how a path ends at a limit state.

    Parameters
    ----------
    limit
        Of a pose on the path.

    Returns
    -------
    PathEnd or None
        `COLLAPSE` where it is proven that blocks fall, `LOST` where neither that nor a mechanism is found, `LOCKED`
        where the blocks lock each other; None where the path goes on.
    """
    if limit.multiplier is None:
        return PathEnd.COLLAPSE if limit.mechanism.any() else PathEnd.LOST
    return PathEnd.LOCKED if np.isinf(limit.multiplier) else None


@dataclass(frozen=True, eq=False)
class PathPoint:
    """A pose on a path, and the motion there."""

    parameter: float  #: displacement of the control, or movement of the supports [m]
    pose: Pose
    tangent: Floats  #: rate of the pose for a unit rate of the parameter, shape (n_blocks, 6)
    value: float  #: the multiplier, or the force on the moving supports [N]
    linkage: Linkage | None = None  #: with new contact points, where joints slide against friction
    forces: EquilibriumForces | None = None  #: those that determine the value there


@dataclass(frozen=True, eq=False)
class PathState:
    """A point on a path with its linkage and the forces in equilibrium."""

    point: PathPoint
    linkage: Linkage
    forces: EquilibriumForces
    #: on a path of finite steps, the largest gap of contacts that count as closed [m]; None on a linkage
    residual_gap: float | None = None
    upper: float | None = None  #: the multiplier with associated flow, where it is not that of the state


@dataclass(frozen=True)
class PathEvent:
    """A change of the mechanism."""

    #: "jump", "closing" (a contact closes) or "change" (a joint ceases to slide, or a tie that has yielded turns back)
    kind: str
    parameter: float  #: where [m]
    before: float  #: multiplier or force before it
    after: float | None  #: the same after it; None where no admissible state follows, infinite where the blocks lock
    opened: tuple[int, ...]  #: joints that open, numbers of interfaces
    shut: tuple[int, ...]  #: joints that close, numbers of interfaces


@dataclass(frozen=True)
class PathFault:
    """A pose with joints that no analysis takes, a fault of the program: it ends what was followed up to there."""

    parameter: float  #: of the last state before it [m]
    why: str

    @property
    def told(self) -> str:
        """What a reader must know of it."""
        return f"from {self.parameter:.4g} m on the blocks come to a pose whose joints cannot be analysed: {self.why}"
