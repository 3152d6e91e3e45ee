"""From a moved slider to the new verdict on the live page: process time of every step, at two sizes.

A page without a browser, its judge in a process of its own as always. For each move of `wall.thickness` the clock of
the judge (rebuild, contacts, solve, certificate) and that of the page (words, colours, meshes) are added up; the second
starts at the change and stops when the words of the verdict are on the page and the blocks have their new colours.
"""

from __future__ import annotations

import pickle
import statistics
from time import process_time, sleep

from blockstat.app.design import Model
from blockstat.app.server import running
from blockstat.spec import parameters
from evidence import results
from evidence.scenes.sized import chapel_scene
from evidence.tables import table

MOVED = "wall.thickness"
#: Moves of the slider at each size: to and fro between stable designs, and through the limit.
MOVES = (0.78, 0.74, 0.7, 0.66, 0.62, 0.58, 0.55, 0.5, 0.45, 0.4, 0.35, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
#: Seconds that a move may take, median: what the page is held against.
TARGETS = {300: 0.15, 3000: 1.5}
STEPS = ("build", "interfaces", "equilibrium", "memory", "solve", "certificate")


def measured(blocks: int, moves: tuple[float, ...] = MOVES) -> dict:
    """Median, least and most of the seconds of a move, and the medians of its steps."""
    scene = chapel_scene(blocks)
    model = Model(scene.name, scene, None, parameters(scene))
    rows = []
    with running(model) as (page, _):
        _wait(page, MOVED, None)
        for value in moves:
            rows.append(_moved(page, value))
        count = page.known.verdict.assembly.n_blocks
    total = [row["total"] for row in rows]
    return {
        "blocks": count,
        "moves": len(rows),
        "median": statistics.median(total),
        "least": min(total),
        "most": max(total),
        "target": TARGETS.get(blocks),
        "unstable": sum(row["outcome"] == "unstable" for row in rows),
        "steps": {step: statistics.median(row[step] for row in rows) for step in (*STEPS, "send", "page")},
        "rows": rows,
    }


def _moved(page, value: float) -> dict:
    """Seconds of one move by step; the page's share is what this process spent between change and picture."""
    shown = page.known
    begin = process_time()
    page.post(lambda: page.change(MOVED, value))
    _wait(page, MOVED, shown)
    here = process_time() - begin
    known = page.known
    row = {step: known.seconds.get(step, 0.0) for step in STEPS}
    begin = process_time()
    pickle.dumps(known.verdict)  # what the judge spends on sending its verdict; its own clock stops before
    row["send"] = process_time() - begin
    judge = known.seconds["total"] + row["send"]
    return {**row, "value": value, "outcome": known.verdict.outcome.word, "page": here, "total": judge + here}


def _wait(page, path: str, before) -> None:
    """Until the page shows the design of its present values, picture and words."""
    while page.known is before or "draw" not in page.known.seconds or page.follower.pending:
        sleep(0.005)


def moves_table(found: list[dict]) -> str:
    """Seconds of a move at each size, and the medians of its steps."""
    rows = {
        "blocks": [f"{one['blocks']:,}" for one in found],
        "moves": [f"{one['moves']}" for one in found],
        "of these to a design that falls": [f"{one['unstable']}" for one in found],
        "median [s]": [f"{one['median']:.3f}" for one in found],
        "target [s]": ["-" if one["target"] is None else f"{one['target']:g}" for one in found],
        "least [s]": [f"{one['least']:.3f}" for one in found],
        "most [s]": [f"{one['most']:.3f}" for one in found],
        **{f"{step} [ms]": [f"{1e3 * one['steps'][step]:.0f}" for one in found] for step in (*STEPS, "send", "page")},
    }
    first, *others = ([name, *cells] for name, cells in rows.items())
    return table(first, others)


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=sorted(TARGETS))
    options = parser.parse_args()
    found = [measured(size) for size in options.sizes]
    results.report(options, {"moved": MOVED, "sizes": found}, {"moves": moves_table(found)})


if __name__ == "__main__":
    main()
