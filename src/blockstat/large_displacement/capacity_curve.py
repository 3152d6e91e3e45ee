"""The capacity curve as a result: load multiplier against displacement, with a bracket at each point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError, check_number
from blockstat.large_displacement.displaced.pose import Pose
from blockstat.large_displacement.finite_steps.fall import FallenBlocks
from blockstat.large_displacement.linkage.path import PathEvent
from blockstat.result import Result, Sentence, counted, finite
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A bracket at rest wider than this is written out. Relative to the lower bound. Chosen: an engineer needs no more.
WIDE_BRACKET = 1e-3
#: Joints of an event that are named at most.
MAX_NAMED_JOINTS = 4


class CapacityOutcome(Sentence):
    """How a capacity curve ends; each value is the sentence a user reads."""

    ZERO = "Zero: the multiplier reaches zero; beyond this displacement the weight alone drives the mechanism."
    REACHED = "Reached: the displacement asked for is reached."
    COLLAPSE = "Collapse: no admissible state with a positive multiplier follows at this displacement."
    LOCKED = "Locked: the blocks lock each other; at this displacement any multiple of the load is carried."
    LOST = "Lost: the mechanism could not be followed any further; what lies beyond is not known."
    INTERRUPTED = "Interrupted: the curve is known up to here."


@dataclass(frozen=True, eq=False)
class CapacityPoint:
    """One state on a capacity curve."""

    displacement: float  #: of the control [m]
    lower: float  #: multiplier that admissible forces carry
    upper: float  #: multiplier at which the mechanism moves
    pose: Pose  #: positions of the blocks
    mechanism: Floats  #: rate of the pose for a unit rate of the displacement, shape (n_blocks, 6)
    opened: Ints  #: joints that are open somewhere, numbers of interfaces


@dataclass(frozen=True, eq=False)
class CapacityCurve(Result):
    """Load multiplier against the displacement of a control, with a bracket at each point."""

    outcome: CapacityOutcome
    points: tuple[CapacityPoint, ...]
    events: tuple[PathEvent, ...]  #: changes of the mechanism, in order; the curve has two points at each
    control: str  #: which displacement is followed, in words
    limit: LimitLoad  #: the limit load that the curve starts from
    warnings: tuple[str, ...]
    timings: dict[str, float]
    fallen: tuple[FallenBlocks, ...] = ()  #: blocks that fall out of the structure on the way
    #: multiplier that is carried at rest without dilatancy and self-stress, where the curve begins above it
    without_self_stress: tuple[float, float] | None = None

    @property
    def displacement(self) -> Floats:
        """Displacement of the control, shape (k,) [m].

        Two points at a jump have the same displacement. On a linkage it increases. On a path of finite steps it may
        decrease (snap-back).
        """
        return np.array([point.displacement for point in self.points])

    @property
    def lower(self) -> Floats:
        """Multipliers that admissible forces carry, shape (k,)."""
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
        """Return the bracket at a displacement, by linear interpolation between points.

        Parameters
        ----------
        displacement : float
            Of the control [m], from 0 to the largest of the curve. At a jump, the bracket after it is returned; after a
            snap-back, that of the last passage.

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
        check_number("displacement", displacement)
        if not 0 <= displacement <= there.max():
            raise InputError(f"displacement is {displacement!r}; the curve is known from 0 to {there.max():.6g} m")
        last = int(np.flatnonzero(there <= displacement)[-1])
        if last + 1 == len(there) and there[last] < displacement:  # the control has come back from there by a snap-back
            last = int(np.flatnonzero((there[:-1] - displacement) * (there[1:] - displacement) <= 0)[-1])
        rows = np.arange(last, min(last + 2, len(there)))
        rows = rows[np.argsort(there[rows], kind="stable")]  # a snap-back goes down
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
        wide = first.upper > (1.0 + WIDE_BRACKET) * first.lower
        most = f" to {first.upper:.6g}" if wide else ""
        lines = [
            self.outcome.value,
            f"Displacement: {self.control}.",
            f"Multiplier {first.lower:.6g}{most} at rest, {last.lower:.6g} at {last.displacement:.6g} m, "
            f"{counted(len(self.points), 'point')}.",
        ]
        for event in self.events:
            after = "no admissible state follows" if event.after is None else f"to {event.after:.6g}"
            if event.after == np.inf:
                after = "any multiple of the load is carried"
            opened, shut = (", ".join(self._called(joints)) for joints in (event.opened, event.shut))
            what = "; ".join(text for text in (opened and f"opens {opened}", shut and f"closes {shut}") if text)
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
                    "after": None if event.after is None else finite(event.after),
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
        return ["-".join(self._pair(k)) for k in joints[:MAX_NAMED_JOINTS]] + (
            ["..."] if len(joints) > MAX_NAMED_JOINTS else []
        )
