"""What one and two workers of dask gain: a sweep, a reliability, a fragility and a plan of building.

    python -m evidence.choosing.workers [--size 0.6] [--repeat 3] [--json] [--write FILE]

Clock time beside that of the same call in one process without dask just before. Ways take turns, so that other programs
on the machine slow all of them down, and the median of `--repeat` turns counts. Every answer is compared with that of
one process. Process time is that of the workers and of the caller, which is also the scheduler here.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import distributed
import joblib

from blockstat import (
    Assembly,
    Random,
    Scene,
    assess_plan,
    build,
    find_order,
    fragility,
    latin_hypercube,
    load_scene,
    reliability,
    scene_from,
    sweep,
)  # fmt: skip
from blockstat.model import arch, assemble
from evidence import results
from evidence.benchmarks.sweep import HUT
from evidence.paths import EXAMPLES
from evidence.tables import table

SIDE = (1, 0, 0)
UNCERTAIN = {"friction": Random("lognormal", 0.6, 0.1), "edge": Random("uniform", 0.0, 0.005)}
PUSH = {"push": Random("normal", 0.3, 0.1)}
#: Ways to do the work: without dask in one process and in two, and with so many workers.
ALONE, PROCESSES, ONE, TWO = "alone", "2 processes", "1 worker", "2 workers"
COUNT = {ALONE: 1, PROCESSES: 2, ONE: 1, TWO: 2}


@dataclass(frozen=True)
class Work:
    """A call, and of how many independent parts it is."""

    name: str
    scene: str
    blocks: int
    parts: str
    run: Callable[[int | None], Any]  #: with `jobs`; returns what every way must answer


@dataclass(frozen=True)
class Spent:
    """Seconds of one call."""

    clock: float
    process: float
    answer: Any


def rows_of(scene: Scene, designs: int, jobs: int | None) -> list[tuple[int, str]]:
    """The verdicts of a sweep."""
    with tempfile.TemporaryDirectory() as folder:
        found = sweep(scene, latin_hypercube(scene, designs), Path(folder, "rows.jsonl"), jobs=jobs)
        return sorted((row["design"], row["static"]) for row in found.rows())


def works(size: float) -> list[Work]:
    """The calls, with numbers of parts in proportion to a size."""
    scene = scene_from(HUT)
    chapel = build(load_scene(EXAMPLES / "chapel.toml"))
    designs, draws, multipliers = (max(round(size * n), 2) for n in (240, 240, 40))
    ring = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=max(round(41 * size), 5), springers=0.3))
    plan = find_order(ring, held_at_most=2).plan
    assert plan is not None

    def judged(jobs: int | None) -> list[tuple[str, float]]:
        found = assess_plan(ring, plan, tilt=True, jobs=jobs)
        assert found.tilt is not None
        return list(zip([outcome.word for outcome in found.outcomes], found.tilt, strict=True))

    def fallen(jobs: int | None) -> int:
        return reliability(chapel, UNCERTAIN | PUSH, load=SIDE, draws=draws, jobs=jobs).failures

    def carried(jobs: int | None) -> list[float]:
        return fragility(chapel, UNCERTAIN, SIDE, draws=multipliers, jobs=jobs).tolist()

    def of(assembly: Assembly) -> tuple[str, int]:
        return assembly.name, assembly.n_blocks

    return [
        Work("sweep", *of(build(scene)), f"{designs} designs", lambda jobs: rows_of(scene, designs, jobs)),
        Work("reliability", *of(chapel), f"{draws} draws", fallen),
        Work("fragility", *of(chapel), f"{multipliers} draws", carried),
        Work("plan with tilts", "arch", ring.n_blocks, f"{len(plan.steps)} steps", judged),
    ]


@contextmanager
def workers(count: int) -> Iterator[tuple[distributed.Client, float]]:
    """So many workers of one thread on this machine, and the seconds until they have imported the package."""
    began = perf_counter()
    options = {"n_workers": count, "threads_per_worker": 1, "dashboard_address": ":0"}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster, set_as_default=False) as client:
        client.wait_for_workers(count)
        client.run(ready)
        yield client, perf_counter() - began


def ready() -> None:
    """Import in a worker what the calls need, by a small one."""
    for work in works(0.02):
        work.run(1)


def timed(work: Work, way: str, clients: dict[str, distributed.Client]) -> Spent:
    """Do the work in one way."""
    with ExitStack() as stack:
        client = clients.get(way)
        if client is not None:
            stack.enter_context(joblib.parallel_config(backend="dask", client=client))
        before = process_of(client)
        clock, process = perf_counter(), process_time()
        answer = work.run(None if client is not None else COUNT[way])
        clock, process = perf_counter() - clock, process_time() - process
        return Spent(clock, process + process_of(client) - before, answer)


def process_of(client: distributed.Client | None) -> float:
    """Process time of all workers."""
    if client is None:
        return 0.0
    spent: Any = client.run(process_time)
    return sum(spent.values())


def measured(work: Work, repeat: int, clients: dict[str, distributed.Client]) -> dict:
    """The medians over some turns: seconds in one process, and of each way its efficiency and added process time."""
    runs: dict[str, list[Spent]] = {way: [] for way in COUNT}
    for _ in range(repeat):
        for way, found in runs.items():
            found.append(timed(work, way, clients))
    answers = [spent.answer for found in runs.values() for spent in found]
    turns = {way: list(zip(runs[ALONE], found, strict=True)) for way, found in runs.items()}
    return {
        "name": work.name, "scene": work.scene, "blocks": work.blocks, "parts": work.parts,
        "same": all(answer == answers[0] for answer in answers),
        "seconds": median(spent.clock for spent in runs[ALONE]),
        "efficiency": {way: median(a.clock / b.clock / COUNT[way] for a, b in turns[way]) for way in COUNT},
        "added": {way: median(b.process / a.process - 1 for a, b in turns[way]) for way in (ONE, TWO)},
    }  # fmt: skip


def efficiency(rows: list[dict]) -> str:
    """A line a call: how much of each process is used, and what process time is added."""

    def line(row: dict) -> list[str]:
        used = [f"{100 * row['efficiency'][way]:.0f} %" for way in (PROCESSES, ONE, TWO)]
        more = [f"{100 * row['added'][way]:+.0f} %" for way in (ONE, TWO)]
        same = "yes" if row["same"] else "NO"
        return [row["name"], row["scene"], row["blocks"], row["parts"], f"{row['seconds']:.1f}", *used, *more, same]

    heads = ["call", "scene", "blocks", "parts", "one process [s]", PROCESSES, ONE, TWO]
    heads += [f"process time, {ONE}", f"process time, {TWO}", "same answers"]
    return table(heads, map(line, rows))


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--size", type=float, default=0.6, help="of the calls")
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    load = os.getloadavg()[0]
    chosen = works(options.size)
    with ExitStack() as stack:
        one, two = (stack.enter_context(workers(count)) for count in (1, 2))
        clients = {ONE: one[0], TWO: two[0]}
        for work in works(0.02):
            work.run(2)  # starts the processes without dask
        rows = [measured(work, options.repeat, clients) for work in chosen]
    figures = {"rows": rows, "start": two[1], "load": load, "cores": len(os.sched_getaffinity(0))}
    start = table(
        ["cores", "load before", "two workers are ready after [s]"],
        [[figures["cores"], f"{load:.1f}", f"{two[1]:.1f}"]],
    )
    results.report(options, figures, {"efficiency": efficiency(rows), "start": start})


if __name__ == "__main__":
    main()
