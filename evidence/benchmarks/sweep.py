"""What a row of a sweep costs, and what a million would.

    python -m evidence.benchmarks.sweep [--designs 40] [--json] [--write FILE]

Seconds are process time of a worker: building, statics and certificate of each design of a Latin hypercube, in batches
that share evidence.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from blockstat import build
from blockstat.design_search.sweep import latin_hypercube, sweep
from blockstat.spec import Scene, scene_from
from evidence import results
from evidence.scenes.sized import chapel_scene
from evidence.tables import table

MILLION = 1_000_000
CORES = (2, 64, 1000)
ARCH = {
    "name": "arch",
    "parameters": {"t": {"value": 0.2, "min": 0.08, "max": 0.2, "step": 0.01}},
    "elements": {"arch": {"kind": "arch", "span": 2.0, "thickness": "= t", "depth": 0.5, "voussoirs": 15}},
}
HUT = {
    "name": "hut", "length": 2.0, "span": 2.4, "brick": {"length": 0.8, "height": 0.5},
    "wall": {"thickness": {"value": 0.8, "min": 0.2, "max": 0.8, "step": 0.1}, "height": 1.5},
    "vault": {"thickness": {"value": 0.3, "min": 0.2, "max": 0.3, "step": 0.05}, "voussoirs": 7},
}  # fmt: skip


def cost(scene: Scene, designs: int) -> dict:
    """Seconds and bytes a row."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "rows.jsonl")
        sweep(scene, latin_hypercube(scene, 2), Path(folder, "warm.jsonl"), jobs=1)
        rows = sweep(scene, latin_hypercube(scene, designs), path, jobs=1).rows()
        size = path.stat().st_size / designs
    seconds = sum(row["seconds"] for row in rows) / designs
    return {
        "scene": scene.name, "blocks": build(scene).n_blocks, "designs": designs, "seconds": seconds, "bytes": size,
        "stable": sum(row["static"] == "stable" for row in rows),
    }  # fmt: skip


def costs(rows: list[dict]) -> str:
    """A line a scene, with the hours that a million rows take."""

    def hours(row: dict) -> list[str]:
        return [f"{row['seconds'] * MILLION / n / 3600:.2g}" for n in CORES]

    return table(
        ["scene", "blocks", "ms a row", "bytes a row", *(f"a million on {n:,} cores [h]" for n in CORES)],
        ([r["scene"], r["blocks"], f"{1e3 * r['seconds']:.1f}", f"{r['bytes']:.0f}", *hours(r)] for r in rows),
    )


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--designs", type=int, default=40)
    options = parser.parse_args()
    rows = [cost(scene_from(data), options.designs) for data in (ARCH, HUT)]
    rows.append(cost(chapel_scene(300), options.designs))
    results.report(options, rows, {"table": costs(rows)})


if __name__ == "__main__":
    main()
