"""Static and dynamic verdicts side by side."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from blockstat.analysis import assess
from blockstat.assembly import Assembly
from blockstat.result import Outcome, Verdict
from dynsim.settings import Settings
from dynsim.verify import DynamicOutcome, DynamicVerdict, verify


@dataclass(frozen=True)
class Comparison:
    """One row: what statics and Bullet say of one assembly. Seconds are process time; None was not reached."""

    name: str
    blocks: int | None = None
    interfaces: int | None = None
    static: str | None = None  #: "stable", "unstable", "undecided"
    score: float | None = None
    dynamic: str | None = None  #: "stands", "falls", "creeps"
    group_drop: float | None = None
    max_drop: float | None = None
    max_displacement: float | None = None
    static_seconds: float | None = None
    dynamic_seconds: float | None = None
    agree: bool | None = None  #: None when statics are undecided, Bullet sees creep, or a verdict is missing
    note: str = ""


def compare(assembly: Assembly, *, settings: Settings | None = None) -> Comparison:
    """Both verdicts on one assembly, and the likely reason when they differ."""
    static = assess(assembly)
    dynamic = verify(assembly, settings=settings)
    score = static.summary()["score"]
    return Comparison(
        name=assembly.name,
        blocks=assembly.n_blocks,
        interfaces=static.interfaces.n_interfaces,
        static=static.outcome.word,
        score=score,
        dynamic=dynamic.outcome.word,
        group_drop=dynamic.group_drop,
        max_drop=dynamic.max_drop,
        max_displacement=dynamic.max_displacement,
        static_seconds=static.timings["total"],
        dynamic_seconds=dynamic.run.process_seconds,
        agree=_agree(static, dynamic),
        note=likely_reason(static, dynamic),
    )


def _agree(static: Verdict, dynamic: DynamicVerdict) -> bool | None:
    if static.outcome is Outcome.UNDECIDED or dynamic.outcome is DynamicOutcome.CREEPS:
        return None
    return (static.outcome is Outcome.STABLE) == (dynamic.outcome is DynamicOutcome.STANDS)


def likely_reason(static: Verdict, dynamic: DynamicVerdict) -> str:
    """Why statics and dynamics differ, in one sentence; empty when they agree."""
    if _agree(static, dynamic) is not False:
        if dynamic.outcome is DynamicOutcome.CREEPS:
            return f"it creeps at {1e3 * dynamic.rate:.2g} mm/s in Bullet: neither a stand nor a fall"
        return "marginal" if static.outcome is Outcome.UNDECIDED else ""
    if static.outcome is Outcome.UNSTABLE:
        return "statics exclude rest: the motion is slower than the threshold in the simulated time"
    if dynamic.run.initial_overlap > 0.1 * dynamic.brick_threshold:
        return "the shapes Bullet sees overlap, so it does not simulate quite this geometry"
    found = assess(static.assembly, interfaces=static.interfaces, flow="coulomb").outcome
    if found is Outcome.STABLE_ONLY_BY_SELF_STRESS:
        return "it stands only by self-stress or dilatancy: Coulomb friction without them finds no equilibrium"
    return "statics allow rest, with Coulomb friction too: marginal, or a motion that rest would have stopped"


def write_csv(rows: Sequence[Comparison], path: Path) -> None:
    """The rows as CSV; what was not reached stays empty."""
    table: list[dict[str, Any]] = [asdict(row) for row in rows]
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(Comparison.__dataclass_fields__))
        writer.writeheader()
        writer.writerows([{k: "" if v is None else v for k, v in row.items()} for row in table])
