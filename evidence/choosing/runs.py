"""Runs of Bullet by resolution and preset: the imbalance that is missed, and the seconds of a verdict that stands.

A scene is pushed by multiples of its limit load. Beyond the limit the load and the weight do work on the mechanism: the
imbalance is that work as a share of the sum of weight times speed, which is what `dynsim.Settings.resolution` counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from blockstat import Assembly, limit_load
from dynsim import Settings, verify
from dynsim.settings import PRESETS
from evidence.bisection import bisect
from evidence.references.dynamics import G
from evidence.scenes.small import arch, running_bond, stack
from evidence.tables import table

RESOLUTIONS = (1e-2, 3e-3, 1e-3, 3e-4)
#: Multiples of the limit load between which Bullet's limit is looked for, and how closely. The first is the one of the
#: verdict whose seconds are given.
LOW, HIGH, WITHIN = 0.8, 1.08, 1e-4
Push = tuple[float, float, float]


@dataclass(frozen=True)
class Known:
    """A scene with a known limit load."""

    name: str
    scene: Assembly
    load: Push
    limit: float

    def pushed(self, factor: float) -> Assembly:
        """The scene under a multiple of its limit load."""
        push = factor * self.limit * np.array(self.load)
        return self.scene.with_(gravity=G * (push + (0, 0, -1)))

    def imbalance(self) -> float:
        """Imbalance as a share of the weight, by the excess of the load over its limit as a share of the limit."""
        found = limit_load(self.scene, self.load, optimum=True)
        motion = found.mechanism[:, :3]
        work = self.limit * float(self.scene.mass @ (motion @ np.array(self.load)))
        return work / float(self.scene.mass @ np.linalg.norm(motion, axis=1))


def known() -> list[Known]:
    """A pillar tips at b / h, a wall at thickness / height; the limit of the arch is a bracket of statics."""
    ring = arch(15, 0.15, friction=0.7)
    found = limit_load(ring, (1, 0, 0), tolerance=1e-9)
    return [
        Known("pillar", stack(1, 0.5, 2.0), (1, 0, 0), 0.25),
        Known("wall", running_bond(6, 4), (0, 1, 0), 0.2 / (6 * 0.175)),
        Known("arch", ring, (1, 0, 0), (found.lower + found.upper) / 2),
    ]


def choices() -> dict[str, Settings]:
    """Settings by name: resolutions with the steps of the default, then the other presets."""
    usual = Settings()
    found = {}
    for resolution in RESOLUTIONS:
        name = "default" if resolution == usual.resolution else f"resolution {resolution:.0e}"
        found[name] = Settings(resolution=resolution)
    return found | {name: Settings.named(name) for name in PRESETS if name != "default"}


@dataclass(frozen=True)
class Judged:
    """The limit of a scene in Bullet."""

    scene: str
    setting: str
    resolution: float
    preset: bool
    low: float  #: imbalance at which it stands, as a share of the weight; negative below the limit
    high: float  #: at which it does not
    excess: float  #: middle of the bracket of its limit over the exact limit, less 1
    seconds: float  #: process time of a verdict that stands

    @property
    def missed(self) -> float:
        """Largest imbalance seen to stand; negative: the least reserve seen to fall; zero: neither."""
        return self.low if self.low > 0 else min(self.high, 0.0)


def judged(one: Known, setting: str, settings: Settings, within: float = WITHIN) -> Judged:
    """The limit of a scene by bisection, and the seconds of a verdict well below it."""
    timed = verify(one.pushed(LOW), settings=settings)
    if timed.outcome.word != "stands":
        raise ValueError(f"{one.name}, {setting}: {timed.outcome.word} at {LOW} of the limit")

    def stands(factor: float) -> bool:
        return verify(one.pushed(factor), settings=settings).outcome.word == "stands"

    low, high = bisect(stands, LOW, HIGH, within)
    share = one.imbalance()
    return Judged(
        one.name, setting, settings.resolution, setting in PRESETS, share * (low - 1), share * (high - 1),
        (low + high) / 2 - 1, timed.process_seconds,
    )  # fmt: skip


def measured(within: float = WITHIN) -> list[Judged]:
    """All scenes with all settings; the limits are bracketed within this share."""
    rows = []
    for one in known():
        verify(one.pushed(LOW))  # imports and first calls are no part of any row
        for setting, settings in choices().items():
            rows.append(judged(one, setting, settings, within))
    return rows


def rows_table(rows: Sequence[Judged]) -> str:
    """A line a setting, columns by scene."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    lines = []
    for setting in dict.fromkeys(row.setting for row in rows):
        own = [row for row in rows if row.setting == setting]
        cells = (text for r in own for text in (_imbalance(r), f"{100 * r.excess:+.2f}", f"{r.seconds:.3f}"))
        lines.append([setting, f"{own[0].resolution:.0e}", *cells])
    heads = (text for name in scenes for text in (f"{name}: imbalance", "limit [%]", "s"))
    return table(["setting", "its resolution", *heads], lines)


def _imbalance(row: Judged) -> str:
    return f"{row.missed:+.1e}" if row.missed else f"below {max(row.high, -row.low):.0e}"


def advice(rows: Sequence[Judged]) -> str:
    """What a finer resolution buys, from the rows."""
    plain = {(row.scene, row.resolution): row for row in rows if not row.preset}
    coarse, fine = (pick(resolution for _, resolution in plain) for pick in (max, min))
    scenes = list(dict.fromkeys(row.scene for row in rows))
    share = max(row.missed / row.resolution for row in rows)
    dear = max(plain[scene, fine].seconds / plain[scene, coarse].seconds for scene in scenes)
    moved = (
        f"of the {scene} {100 * plain[scene, coarse].excess:+.1f} and {100 * plain[scene, fine].excess:+.1f} %"
        for scene in scenes
    )
    by_preset = {name: [row for row in rows if row.setting == name] for name in PRESETS}
    worst = (f"{name} {100 * max((r.excess for r in own), key=abs):+.1f} %" for name, own in by_preset.items() if own)
    return (
        f"- No setting missed an imbalance of more than {share:.2f} times its resolution. The errors of the limits at "
        f"{coarse:.0e} and {fine:.0e} are {', '.join(moved)}; the finer verdict takes up to {dear:.1f} times the "
        "seconds.\n"
        "- What a fine resolution leaves is the error of the contact solver, which only other time steps and more "
        f"iterations change. Largest errors of a limit by preset: {', '.join(worst)}. Choose the resolution by the "
        "imbalance that matters to you, and a preset by the error of a limit that you can bear."
    )
