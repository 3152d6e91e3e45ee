"""The dynamic verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.polyhedron import Floats, Ints
from dynsim.action import Action
from dynsim.criteria import default_threshold, drops, group_box_centre
from dynsim.run import Run, simulate
from dynsim.settings import Settings
from dynsim.stiffness import caveats


class DynamicOutcome(Enum):
    """The two dynamic answers; each value is the sentence a user reads."""

    STANDS = "Stands: no block moved further than the threshold in the simulated time."
    FALLS = "Falls: blocks moved further than the threshold."

    @property
    def word(self) -> str:
        return self.name.lower()


@dataclass(frozen=True, eq=False)
class DynamicVerdict:
    """What Bullet saw. Drops and displacements are since release, after settling [m]."""

    outcome: DynamicOutcome
    group: str  #: group of Eq. 1, "" for the whole assembly
    group_drop: float  #: Eq. 1, of the bounding-box centre
    max_drop: float  #: Eq. 2, of the block that went furthest down
    max_displacement: float
    settling: float  #: largest displacement while settling
    roof_threshold: float
    brick_threshold: float
    moved: Ints  #: blocks beyond the threshold, furthest first
    first_block: str | None  #: the block that crossed the threshold first
    run: Run
    warnings: tuple[str, ...] = ()

    @property
    def passes_eq1(self) -> bool:
        return self.group_drop < self.roof_threshold

    @property
    def passes_eq2(self) -> bool:
        return self.max_drop < self.brick_threshold

    @property
    def displacement(self) -> Floats:
        """Displacement of each centroid at the end, shape (n_blocks, 3) [m]."""
        return self.run.since_release[-1]

    def explain(self, limit: int = 5) -> str:
        """The verdict in words."""
        lines = [
            self.outcome.value,
            f"Eq. 1: {self.group or 'whole assembly'} dropped {1e3 * self.group_drop:.2g} mm "
            f"(threshold {1e3 * self.roof_threshold:.3g} mm). "
            f"Eq. 2: largest drop of a block {1e3 * self.max_drop:.2g} mm "
            f"(threshold {1e3 * self.brick_threshold:.3g} mm). "
            f"Largest displacement {1e3 * self.max_displacement:.2g} mm.",
        ]
        names = [self.run.assembly.names[i] for i in self.moved]
        if names:
            more = f" and {len(names) - limit} more" if len(names) > limit else ""
            lines.append(f"First to move: {self.first_block}. Moved: {', '.join(names[:limit])}{more}.")
        lines += [f"Warning: {text}" for text in self.warnings]
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "verdict": self.outcome.word,
            "sentence": self.outcome.value,
            "group": self.group,
            "group_drop": self.group_drop,
            "max_drop": self.max_drop,
            "max_displacement": self.max_displacement,
            "settling": self.settling,
            "roof_threshold": self.roof_threshold,
            "brick_threshold": self.brick_threshold,
            "passes_eq1": self.passes_eq1,
            "passes_eq2": self.passes_eq2,
            "first_block": self.first_block,
            "moved": [self.run.assembly.names[i] for i in self.moved],
            "blocks": self.run.assembly.n_blocks,
            "initial_overlap": self.run.initial_overlap,
            "simulated_seconds": float(self.run.times[-1]),
            "process_seconds": self.run.process_seconds,
            "warnings": list(self.warnings),
        }


def verify(assembly: Assembly, *, settings: Settings | None = None, actions: Sequence[Action] = ()) -> DynamicVerdict:
    """Simulate an assembly in Bullet and judge it by displacement.

    actions : what acts on the blocks meanwhile, such as `AngularSprings` or `InertiaScale`; the bonds of the joint laws
    come by themselves. The run ends early on a clear fall (a block beyond its threshold) or a clear rest. Raises
    InputError when nothing is supported or nothing is free, the group of Eq. 1 does not exist, or a joint law cannot be
    simulated (see `dynsim.bonds`).
    """
    settings = settings or Settings()
    if not assembly.support.any():
        raise InputError(f'"{assembly.name}" has no supports; list the blocks that cannot move under "supports"')
    if not len(assembly.free):
        raise InputError(f'"{assembly.name}": all blocks are supports; there is nothing to simulate')
    group, blocks = _roof(assembly, settings.group)
    limit = default_threshold(assembly)
    roof, brick = settings.roof_threshold or limit, settings.brick_threshold or limit

    def decided(elapsed: float, moved: Floats) -> bool:
        furthest = np.linalg.norm(moved, axis=1).max()
        return bool(
            furthest >= max(brick, roof) or (elapsed >= settings.rest_after and furthest < settings.rest * brick)
        )

    run = simulate(assembly, settings=settings, stop=decided, actions=actions)
    since = run.since_release
    length = np.linalg.norm(since, axis=2)
    start = group_box_centre(assembly, blocks, run.displacement[0], run.rotation[0])
    end = group_box_centre(assembly, blocks, run.displacement[-1], run.rotation[-1])
    group_drop = float(drops(assembly, end - start))
    max_drop = float(drops(assembly, since[-1]).max())
    beyond = length >= brick
    ever = np.flatnonzero(beyond.any(axis=0))
    falls = len(ever) > 0 or group_drop >= roof or max_drop >= brick
    warnings = caveats(actions)
    if run.initial_overlap > 0.1 * brick:
        warnings.append(
            f"shapes overlap by up to {1e3 * run.initial_overlap:.2g} mm before the first step; "
            "motion is counted after settling"
        )
    settling = float(np.linalg.norm(run.displacement[0], axis=1).max())
    if settling > brick:
        warnings.append(f"blocks moved {1e3 * settling:.2g} mm while settling, more than the threshold")
    return DynamicVerdict(
        outcome=DynamicOutcome.FALLS if falls else DynamicOutcome.STANDS,
        group=group,
        group_drop=group_drop,
        max_drop=max_drop,
        max_displacement=float(length.max()),
        settling=settling,
        roof_threshold=roof,
        brick_threshold=brick,
        moved=ever[np.argsort(-length[-1, ever], kind="stable")],
        first_block=_first(assembly, beyond, length) if len(ever) else None,
        run=run,
        warnings=tuple(warnings),
    )


def _roof(assembly: Assembly, group: str | None) -> tuple[str, Ints]:
    """Group of Eq. 1 and its blocks."""
    if group is None and not any(g == "vault" or g.startswith("vault.") for g in assembly.groups):
        return "", assembly.free
    group = group or "vault"
    return group, assembly.in_group(group)


def _first(assembly: Assembly, beyond: np.ndarray, length: Floats) -> str:
    """Name of the block that crossed the threshold first; the furthest of those that did so in one look."""
    frame = int(np.argmax(beyond.any(axis=1)))
    return assembly.names[int(np.argmax(np.where(beyond[frame], length[frame], -1.0)))]
