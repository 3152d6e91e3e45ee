"""Limits of random scenes under a push: of statics, without dilatancy, and of Bullet."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from blockstat import limit_load
from dynsim import Comparisons, DynamicLimit, Settings, limit
from evidence.comparisons.kept import Kept
from evidence.comparisons.scenes import RANDOM, Scene

#: Where Bullet carries so much more than statics without dilatancy, it is asked once more with this time step [s].
DOUBTED, FINER = 1.03, 2.5e-4


@dataclass(frozen=True)
class LimitRow:
    """Limits of one assembly in one direction, in units of gravity: force fields, without dilatancy, Bullet.

    Those without dilatancy depend on the joints: `coulomb` is the largest and `least` the least.
    """

    name: str
    family: str
    blocks: int
    associated: float
    coulomb: float
    least: float
    bullet: float
    finer: float | None = None  #: Bullet's with finer time steps, where it was asked for


def limits(kept: Kept, scenes: list[Scene], rows: Comparisons, number: int, jobs: int | None) -> list[LimitRow]:
    """Limits under a push of random scenes that stand, about the same number of each family."""
    standing = [
        s for s, row in zip(scenes, rows, strict=True)
        if s.push and (row.static, row.coulomb, row.dynamic) == ("stable", "stable", "stands")
    ]  # fmt: skip
    each = -(-number // len(RANDOM))
    chosen = [scene for family in RANDOM for scene in [s for s in standing if s.family == family][:each]]
    bullet = bullet_limits(kept, chosen, Settings(), jobs)
    found = []
    for scene in chosen:
        static = limit_load(scene.assembly, scene.push, flow="coulomb")
        if scene.name in bullet and static.coulomb is not None and np.isfinite(static.upper):
            kinds = [(low + high) / 2 for low, high in static.coulomb_kinds]
            found.append(
                LimitRow(
                    scene.name, scene.family, scene.assembly.n_blocks, static.upper, max(kinds), min(kinds),
                    bullet[scene.name],
                )
            )  # fmt: skip
    doubted = {row.name for row in found if row.bullet > DOUBTED * row.coulomb}
    finer = bullet_limits(kept, [s for s in chosen if s.name in doubted], Settings(time_step=FINER), jobs)
    return [replace(row, finer=finer.get(row.name)) for row in found]


def bullet_limits(kept: Kept, scenes: list[Scene], settings: Settings, jobs: int | None) -> dict[str, float]:
    """Middle of Bullet's bracket for each scene that has a limit under its push [g]."""
    found: dict[str, float] = {}
    for push in dict.fromkeys(scene.push for scene in scenes):
        own = [scene.assembly for scene in scenes if scene.push == push]
        ask = partial(limit, load=push, settings=settings, check=False)
        for answer in kept.ask(ask, f"limit {push} {settings}", own, DynamicLimit.summary, jobs):
            if answer.get("outcome") == "limit":
                found[answer["name"]] = (answer["lower"] + answer["upper"]) / 2
    return found
