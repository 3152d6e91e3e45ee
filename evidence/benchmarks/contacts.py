"""Process time of contacts and overlaps: sound buildings, heaps that overlap, and blocks of many triangles.

    python -m evidence.benchmarks.contacts [--json] [--write FILE]

Assemblies from elsewhere are timed where the directory of the cases is known. Each time is the shortest of three; the
assemblies are made anew each time, so that nothing is remembered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import process_time

import numpy as np

from blockstat import Assembly, InputError, assess, box, build, find_interfaces, overlaps, read, scene_from
from evidence import results
from evidence.benchmarks.building import BLOCKS_A_BAY, hall
from evidence.paths import CASES
from evidence.scenes.small import assembly
from evidence.tables import table

TIMES = 3
BUILDING = 10_000


def heap(blocks: int, spread: float) -> Assembly:
    """Unit cubes at random places so near each other that all overlap."""
    place = np.random.default_rng(5).uniform(0, spread, (blocks, 3))
    return assembly([box(p, p + 1) for p in place])


def copies(blocks: int) -> Assembly:
    """A cube many times at one place."""
    return assembly([box((-9, -9, -1), (9, 9, 0), name="base"), *[box((0, 0, 0), (1, 1, 1)) for _ in range(blocks)]])


def refused(scene: Assembly) -> None:
    """Assess what cannot be assessed."""
    try:
        assess(scene)
    except InputError:
        return
    raise RuntimeError("overlaps were not refused")


def works() -> Iterator[tuple[str, Callable[[], Assembly], str, Callable[[Assembly], object]]]:
    """What is timed: the scene, how to have it anew, what is asked, and how."""
    yield "hall", lambda: build(scene_from(hall(round(BUILDING / BLOCKS_A_BAY)))), "contacts", find_interfaces
    yield "400 cubes that all overlap", lambda: heap(400, 0.4), "all overlaps", lambda a: overlaps(a, gap=0.01)
    yield "400 cubes that all overlap", lambda: heap(400, 0.4), "refused", refused
    yield "3,000 cubes that all overlap", lambda: heap(3000, 0.01), "refused", refused
    yield "3,000 copies of a cube", lambda: copies(3000), "refused", refused
    for name in ("asm_dome", "asm_crossvault", "cra_curve_3_blocks", "rubble/oneleaf39"):
        if (CASES / f"{name}.json").is_file():
            for asked, ask in (("contacts", find_interfaces), ("verdict", assess)):
                yield name, lambda name=name: read(CASES / f"{name}.json"), asked, ask


def timed(make: Callable[[], Assembly], ask: Callable[[Assembly], object]) -> tuple[int, float]:
    """Blocks and seconds."""
    seconds = []
    for _ in range(TIMES):
        scene = make()
        start = process_time()
        ask(scene)
        seconds.append(process_time() - start)
    return scene.n_blocks, min(seconds)


def main() -> None:
    """Run as the command line says."""
    options = results.parser(__doc__).parse_args()
    rows = [(name, asked, *timed(make, ask)) for name, make, asked, ask in works()]
    lines = [[name, f"{blocks:,}", asked, f"{seconds:.2f}"] for name, asked, blocks, seconds in rows]
    results.report(options, rows, {"table": table(["scene", "blocks", "asked", "seconds"], lines)})


if __name__ == "__main__":
    main()
