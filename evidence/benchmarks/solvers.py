"""Solvers against each other on scenes of growing size, and where the time of blockstat goes.

    python -m evidence.benchmarks.solvers [--sizes 100 1000 ...] [--scenes wall ...] [--solvers blockstat ...]
        [--limit 60] [--json]
    python -m evidence.benchmarks.solvers --profile wall 1000
    python -m evidence.benchmarks.solvers --write FILE            # with parts of the time, and one parameter moved
    python -m evidence.benchmarks.solvers --large --write FILE    # 10,000 blocks, and larger walls; 10 GB

Each cell has its own process, one thread and a limit of wall seconds; a solver that exceeds it is not asked for more
blocks of that scene. compas_cra answers when BLOCKSTAT_COMPAS_PYTHON, or --compas, names the Python of an environment
that has it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator

from evidence import results
from evidence.benchmarks import solver_tables
from evidence.paths import ROOT
from evidence.run.threads import THREADS

SCENES = ("wall", "along", "vault", "chapel", "falling")
SOLVERS = ("cvxpy", "clarabel-primal", "clarabel-dual", "structured", "blockstat", "compas-rbe")
COMPAS = "BLOCKSTAT_COMPAS_PYTHON"
AGREE = 1e-6  #: scores of two solvers may differ by that much
#: Of `--large`: the solvers that can, their blocks, and the walls of blockstat alone, the first for comparison.
FAST, LARGE, ALONE = ("clarabel-dual", "structured", "blockstat"), 10_000, (1000, 30_000, 100_000)


def run(module: str, *arguments: object, limit: float | None = None, **environment: str) -> dict:
    """What a module prints, or the word for why it did not."""
    env = {**os.environ, **dict.fromkeys(THREADS, "1"), **environment}
    command = [sys.executable, "-m", module, *map(str, arguments)]
    process = subprocess.Popen(command, cwd=ROOT, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               start_new_session=True)  # fmt: skip
    try:
        out, error = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)  # its own children with it
        process.communicate()
        return {"word": f"over {limit:g} s"}
    if process.returncode:
        print(error, file=sys.stderr)
        return {"word": "failed"}
    return json.loads(out.splitlines()[-1])


def cells(scenes: list[str], sizes: list[int], solvers: list[str], limit: float) -> Iterator[dict]:
    """All rows, those of one scene and size together."""
    for scene in scenes:
        slow: set[str] = set()
        for size in sizes:
            rows = []
            for solver in solvers:
                row = {"scene": scene, "size": size, "solver": solver}
                if solver == "compas-rbe" and not os.environ.get(COMPAS):
                    row["word"] = "not installed"
                elif solver in slow:
                    row["word"] = "left out"
                else:
                    row |= run("evidence.benchmarks.cell", scene, size, solver, limit=limit)
                    if "word" in row:
                        slow.add(solver)
                rows.append(row)
            yield from compared(rows)


def compared(rows: list[dict]) -> list[dict]:
    """Rows of one scene and size with their ratio to blockstat and what they disagree about."""
    own = next((row for row in rows if row["solver"] == "blockstat" and "seconds" in row), None)
    for row in rows if own else ():
        if "seconds" not in row:
            continue
        row["ratio"] = row["seconds"] / own["seconds"]
        # Forces in an octagon about the cone, without a mechanism, may prove nothing; they must not prove the contrary.
        silent = row["solver"] == "compas-rbe" and row["verdict"] == "undecided"
        same = silent or row["verdict"] == own["verdict"]
        row["agrees"] = same and abs(row["score"] - own["score"]) <= AGREE
    return rows


def alone(limit: float, sizes: Iterable[int]) -> list[dict]:
    """Ours on walls too large for the others."""
    return [
        run("evidence.benchmarks.cell", "wall", size, "blockstat", limit=limit) | {"scene": "wall", "size": size}
        for size in sizes
    ]


def profiles() -> list[dict]:
    """Parts of the time, with both factorisations."""
    return [
        run("evidence.benchmarks.breakdown", scene, size, BLOCKSTAT_FACTOR=backend)
        for scene, size in (("wall", 1000), ("chapel", 1000), ("falling", 1000), ("wall", 3000), ("wall", 10_000))
        for backend in ("pardiso", "superlu")
    ]


def options() -> argparse.Namespace:
    parser = results.parser(__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=[100, 1000, 3000])
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=SCENES)
    parser.add_argument("--solvers", nargs="+", default=list(SOLVERS), choices=SOLVERS)
    parser.add_argument("--limit", type=float, default=60.0, help="wall seconds of a cell")
    parser.add_argument("--compas", help="Python of an environment with compas_cra")
    parser.add_argument("--profile", nargs=2, metavar=("SCENE", "SIZE"))
    parser.add_argument("--alone", type=int, nargs="+", default=ALONE, help="walls of blockstat alone, with --large")
    parser.add_argument("--large", action="store_true", help="the large scenes instead")
    return parser.parse_args()


def main() -> None:
    given = options()
    if given.compas:
        os.environ[COMPAS] = given.compas
    if given.large:
        given.sizes, given.solvers = [LARGE], FAST
    found: dict = {"rows": [], "profiles": [], "alone": []}
    if given.profile:
        found["profiles"].append(run("evidence.benchmarks.breakdown", *given.profile))
    else:
        if not given.json:
            print(solver_tables.HEAD, flush=True)
        for row in cells(given.scenes, given.sizes, given.solvers, given.limit):
            found["rows"].append(row)
            if not given.json:
                print(solver_tables.cell_line(row), flush=True)
    if given.large:
        found["alone"] = alone(20 * given.limit, given.alone)
    elif given.write:
        found["resolve"] = run("evidence.benchmarks.resolve")
        found["profiles"] = profiles()
    parts = solver_tables.parts(found)
    print(json.dumps(found) if given.json else "\n\n".join(text for name, text in parts.items() if name != "table"))
    if given.write:
        results.save(given.write, parts)


if __name__ == "__main__":
    main()
