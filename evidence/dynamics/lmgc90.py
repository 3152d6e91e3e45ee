"""Bullet against LMGC90 (non-smooth contact dynamics): a second opinion.

    python -m evidence.dynamics.lmgc90 [FILE ...]

It needs the extra `lmgc90`. Files are compared as they are; without files, walls pushed in their plane near the limit
without dilatancy.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from blockstat import read
from dynsim import verify
from evidence.references.dynamics import wall

FACTORS = (0.94, 0.97, 0.99, 1.01, 1.03, 1.06)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, help="assemblies")
    files = parser.parse_args().files
    scenes = {file.stem: read(file) for file in files}
    if not scenes:
        scenes = {f"wall of 8 x 4 in plane, {factor}": wall(8, factor) for factor in FACTORS}
    print(f"{'scene':34} {'blocks':>6} {'Bullet mm':>10} {'s':>7}  {'Bullet':7} {'LMGC90 mm':>10} {'s':>7}  LMGC90")
    for name, asm in scenes.items():
        line = f"{name:34} {asm.n_blocks:6}"
        for engine in ("bullet", "lmgc90"):
            verdict = verify(asm, engine=engine)
            moved = 1e3 * verdict.max_displacement
            line += f" {moved:10.3g} {verdict.process_seconds:7.1f}  {verdict.outcome.word:7}"
        print(line.rstrip(), flush=True)


if __name__ == "__main__":
    main()
