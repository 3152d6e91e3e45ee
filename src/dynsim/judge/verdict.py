"""The dynamic verdict and the displacements behind it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from blockstat.result import Result, Sentence, listed, millimetres
from blockstat.typing import Floats, Ints
from dynsim.judge.cracks import Cracks
from dynsim.judge.run import Run
from dynsim.settings import Settings


class DynamicOutcome(Sentence):
    """The three dynamic answers; the value of each is the sentence that a user reads."""

    STANDS = "Stands: the blocks came to rest within the threshold."
    FALLS = "Falls: blocks moved or turned further than the threshold."
    CREEPS = "Creeps: blocks stayed within the threshold and were still moving, slowly, at the end of the run."


#: What a fall under loads that change leaves open where it falls without them as well.
ALONE = (
    "It falls without the loads that change, too: no movement of supports or of the ground and no removal or push is "
    "needed, and this run does not say what they would do."
)


@dataclass(frozen=True, eq=False)
class DynamicVerdict(Result):
    """The dynamic verdict. Drops and displacements are since release, after settling [m]."""

    outcome: DynamicOutcome
    group: str  #: group of Eq. 1, "" for the whole assembly
    group_drop: float  #: Eq. 1, of the bounding-box centre
    max_drop: float  #: Eq. 2, of the block that went furthest down
    max_displacement: float
    max_rotation: float  #: [deg], of the block that turned most
    rate: float  #: of the fastest block at the end of the run [m/s]
    settling: float  #: largest displacement while settling
    roof_threshold: float
    brick_threshold: float
    moved: Ints  #: blocks beyond the threshold, furthest first
    first_block: str | None  #: the block that crossed the threshold first
    first_time: float | None  #: when it did, since release [s]
    cracks: Cracks  #: joints that opened or slid
    run: Run
    resolution: float  #: imbalance that would have shown in the run, as a share of the weight
    warnings: tuple[str, ...] = ()
    corners_moved: float = 0.0  #: the furthest that a corner was moved to close the joints before the run [m]
    misfit: float = 0.0  #: largest gap or overlap of the joints that statics count as closed and that were left [m]
    settings: Settings | None = None  #: of the run
    max_turn: float = (
        0.0  #: the furthest that turning moved a point at half the size of its block from the centroid [m]
    )
    turn_threshold: float = 0.0  #: of it [m]
    #: friction of the joint furthest beyond Coulomb's, over the coefficient, where the stand needs it; 0 elsewhere
    friction_excess: float = 0.0
    #: pressure of a joint over all weight and loads, where the stand rests on self-stress; 0 elsewhere
    wedged: float = 0.0
    falls_alone: bool = False  #: whether it falls without the loads that change, too, as far as that was asked

    @property
    def passes_eq1(self) -> bool:
        """Whether the group of Eq. 1 dropped by less than its threshold."""
        return self.group_drop < self.roof_threshold

    @property
    def passes_eq2(self) -> bool:
        """Whether every block dropped by less than its threshold."""
        return self.max_drop < self.brick_threshold

    @property
    def process_seconds(self) -> float:
        """Process time of all runs behind the verdict [s], wherever they took place."""
        return self.run.process_seconds

    @property
    def displacement(self) -> Floats:
        """Displacement of each centroid at the end, shape (n_blocks, 3) [m]."""
        return self.run.since_release[-1]

    def explain(self, limit: int = 5) -> str:
        """Return the outcome and the displacements behind it in words, one fact a line.

        Parameters
        ----------
        limit : int
            How many moved blocks are named at most.

        Returns
        -------
        str
            Lines of plain text.
        """
        lines = [
            self.outcome.value + (" (LMGC90)" if self.run.engine == "lmgc90" else ""),
            f"Fita et al. 2017, Eq. 1: {self.group or 'whole assembly'} dropped {millimetres(self.group_drop, 2)} mm "
            f"(threshold {millimetres(self.roof_threshold)} mm). "
            f"Eq. 2: largest drop of a block {millimetres(self.max_drop, 2)} mm "
            f"(threshold {millimetres(self.brick_threshold)} mm). "
            f"Largest displacement {millimetres(self.max_displacement, 2)} mm, "
            f"rate at the end {millimetres(self.rate, 2)} mm/s. Largest rotation {self.max_rotation:.2g} degrees; "
            f"rotation moved points at half a block's size by up to {millimetres(self.max_turn, 2)} mm "
            f"(threshold {millimetres(self.turn_threshold)} mm).",
        ]
        if self.falls_alone:
            lines.insert(1, ALONE)
        if self.outcome is DynamicOutcome.STANDS:
            lines.append(f"An imbalance of {self.resolution:.1g} of the weight would have shown.")
        names = [self.run.assembly.names[i] for i in self.moved]
        if names:
            first = f"First to move: {self.first_block}, at {self.first_time:.2g} s."
            lines.append(f"{first} Moved: {listed(names, limit)}.")
        if self.cracks.n_cracks:
            lines.append(self.cracks.explain())
        lines += [f"Warning: {text}" for text in self.warnings]
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "verdict": self.outcome.word,
            "sentence": self.outcome.value,
            "engine": self.run.engine,
            "group": self.group,
            "group_drop": self.group_drop,
            "max_drop": self.max_drop,
            "max_displacement": self.max_displacement,
            "max_rotation_deg": self.max_rotation,
            "max_turn": self.max_turn,
            "rate": self.rate,
            "resolution": self.resolution,
            "settling": self.settling,
            "roof_threshold": self.roof_threshold,
            "brick_threshold": self.brick_threshold,
            "turn_threshold": self.turn_threshold,
            "falls_alone": self.falls_alone,
            "friction_excess": self.friction_excess,
            "wedged": self.wedged,
            "passes_eq1": self.passes_eq1,
            "passes_eq2": self.passes_eq2,
            "first_block": self.first_block,
            "first_time": self.first_time,
            "moved": [self.run.assembly.names[i] for i in self.moved],
            "cracks": self.cracks.per_group(),
            "blocks": self.run.assembly.n_blocks,
            "initial_overlap": self.run.initial_overlap,
            "corners_moved": self.corners_moved,
            "misfit": self.misfit,
            "time_step": self.run.time_step,
            "simulated_seconds": float(self.run.times[-1]),
            "process_seconds": self.run.process_seconds,
            "warnings": list(self.warnings),
        }
