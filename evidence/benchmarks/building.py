"""Seconds to generate a building and to find its interfaces, its memory, and how they grow: process time, one run.

A hall of groin-vaulted bays between walls of two leaves in bond, with a round-headed window and a bonded buttress at
every bay; longer halls have more blocks. Each size runs in a process of its own, so that its memory peak is its own.

    python -m evidence.benchmarks.building [--sizes 1000 10000 50000] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import subprocess
import sys
from time import process_time
from typing import Any

from evidence.paths import ROOT

BLOCKS_A_BAY = 560
STEPS = ("generate", "interfaces")
#: What a building of 10,000 blocks may take.
LIMITS = {"generate": 3.0, "interfaces": 3.0, "memory": 1024.0}


def hall(bays: int) -> dict[str, Any]:
    """The scene of a hall."""
    places = [f"= {k} * pitch + pitch / 2" for k in range(bays)]
    side = {"path": [[0, "= -w"], ["= length", "= -w"]], "thickness": "= t", "height": "= h", "leaves": 2}
    side["openings"] = [
        {"at": places, "width": 1.2, "height": 1.5, "sill": 1.5, "head": "semicircular", "depth": 0.3}
    ]  # fmt: skip
    far = side | {"path": [["= length", "= w"], [0, "= w"]]}
    end = {"path": [["= length", "= -w"], ["= length", "= w"]], "thickness": "= t", "height": "= h", "leaves": 2}
    joints = [f"= {k} * pitch" for k in range(1, bays)]
    buttress = {"width": 0.6, "projection": 0.9, "height": 3.9}
    return {
        "name": "hall",
        "parameters": {"pitch": 4.5, "t": 1.0, "h": 4.5, "length": f"= {bays} * pitch", "w": 3.5},
        "elements": {
            "walls": {
                "kind": "walls", "brick": [0.6, 0.3],
                "runs": {"south": side, "north": far, "east": end, "west": end | {"path": [[0, "= w"], [0, "= -w"]]}},
                "buttresses": [buttress | {"wall": wall, "at": joints} for wall in ("south", "north")],
            },
            "vault": {
                "kind": "groin", "spans": ["= pitch - 0.6", "= 2 * w - t"], "thickness": 0.3, "voussoirs": 15,
                "brick": 0.6, "at": ["= pitch / 2", 0, "= h"], "repeat": {"number": bays, "by": ["= pitch", 0, 0]},
            },
        },
    }  # fmt: skip


def measure(blocks: int) -> dict[str, float]:
    """Process seconds and memory of a hall of about so many blocks, in this process."""
    from blockstat import build, find_interfaces, scene_from

    find_interfaces(build(scene_from(hall(2))))  # imports are not part of any row
    start = process_time()
    assembly = build(scene_from(hall(max(round(blocks / BLOCKS_A_BAY), 2))))
    middle = process_time()
    faces = find_interfaces(assembly)
    end = process_time()
    return {
        "blocks": assembly.n_blocks,
        "found": faces.n_interfaces,
        "generate": middle - start,
        "interfaces": end - middle,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[1000, 10000, 50000])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.one)))
        return
    rows = []
    for size in options.sizes:
        command = [sys.executable, "-m", "evidence.benchmarks.building", "--one", str(size)]
        rows.append(json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout))
    for before, row in zip(rows, rows[1:], strict=False):
        for step in STEPS:
            row[f"{step}_growth"] = math.log(row[step] / before[step]) / math.log(row["blocks"] / before["blocks"])
        more = [n["blocks"] * math.log(n["blocks"]) for n in (before, row)]
        row["n_log_n"] = math.log(more[1] / more[0]) / math.log(row["blocks"] / before["blocks"])
    if options.json:
        print(json.dumps(rows))
        return
    print("growth: exponent of the number of blocks since the row above, and that of n log n")
    heads = ("blocks", "interfaces", "generate s", "growth", "find s", "growth", "n log n", "peak MiB")
    print(" ".join(f"{head:>10}" for head in heads))
    for row in rows:
        growth = [
            f"{row[key]:.2f}" if key in row else "" for key in ("generate_growth", "interfaces_growth", "n_log_n")
        ]
        cells = (
            row["blocks"],
            row["found"],
            f"{row['generate']:.2f}",
            growth[0],
            f"{row['interfaces']:.2f}",
            growth[1],
        )
        print(" ".join(f"{cell:>10}" for cell in (*cells, growth[2], f"{row['memory']:.0f}")))
    limits = f"generate {LIMITS['generate']:g} s, find {LIMITS['interfaces']:g} s, peak {LIMITS['memory']:g} MiB"
    print(f"wanted at 10,000 blocks: {limits}")


if __name__ == "__main__":
    main()
