"""Does anything stand in Bullet that statics exclude? Random arches, walls, vaulted huts, dry and glued, and rubble.

    python -m evidence.comparisons.soundness [--designs 1100] [--seed 11] [--json] [--rows FILE] [--write FILE]

Statics judge every design; what they exclude is simulated with careful settings (glued designs: the default ones), and
once more for ten times as long if it did not fall. A design that then stands is a counter-example, and is printed.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np

from blockstat import Assembly, InputError, assess, glued
from dynsim import Settings, verify
from evidence import results
from evidence.scenes.families import Random, arch, heap, hut, portal, rubble, wall
from evidence.tables import table

LONGER = 10.0
#: Imbalance that it has to see, as a share of the weight.
CLOSER = 1e-5

FAMILIES: dict[str, tuple[Callable[[Random], Assembly], float, bool]] = {
    "arches": (arch, 0.26, False), "portals": (portal, 0.20, False), "walls": (wall, 0.10, False),
    "huts": (hut, 0.12, False), "glued arches": (arch, 0.06, True), "glued portals": (portal, 0.06, True),
    "irregular walls": (rubble, 0.12, False), "heaps": (heap, 0.08, False),
}  # fmt: skip


def judged(name: str, rng: Random) -> dict:
    """One random design of a family: the verdicts on it."""
    make, _, with_glue = FAMILIES[name]
    try:
        assembly = make(rng)
    except InputError as error:
        return {"family": name, "static": "not built", "note": str(error)}
    if with_glue:
        weight = float(assembly.mass[assembly.free].mean()) * 9.81
        assembly = glued(assembly, float(rng.uniform(0.02, 0.6)) * weight)
    static = assess(assembly)
    row = {"family": name, "blocks": assembly.n_blocks, "static": static.outcome.word, "score": static.score}
    if row["static"] != "unstable":
        return row
    settings = Settings.named("default" if with_glue else "careful")
    begin = process_time()
    try:
        verdict = verify(assembly, settings=settings)
    except InputError as error:  # blocks of a heap that statics take for closed and that cannot be closed
        return row | {"dynamic": "refused", "first": "refused", "note": str(error)}
    row["first"] = verdict.outcome.word
    if row["first"] != "falls":
        verdict = verify(assembly, settings=replace(settings, resolution=CLOSER, end=LONGER * settings.end))
    row |= {"dynamic": verdict.outcome.word, "seconds": process_time() - begin}
    row |= {"displacement": verdict.max_displacement, "rate": verdict.rate}
    return row


def counts(rows: list[dict]) -> str:
    """Counts by family, and each counter-example."""
    lines = []
    for name in [*FAMILIES, "all"]:
        own = [row for row in rows if name in (row["family"], "all")]
        count = Counter(row.get("dynamic") for row in own)
        later = sum(row.get("dynamic") == "falls" and row["first"] != "falls" for row in own)
        excluded = sum(row["static"] == "unstable" for row in own)
        fell = count["falls"] - later
        lines.append([name, len(own), excluded, fell, later, count["creeps"], count["refused"], count["stands"]])
    stood = [row for row in rows if row.get("dynamic") == "stands"]
    examples = [
        f"- Counter-example: design {row['number']}, of the {row['family']}, {row['blocks']} blocks. Its residual "
        f"tension is {row['score']:.5f} of the weight, and in Bullet it moved by {1e3 * row['displacement']:.2f} mm."
        for row in stood
    ] or ["No counter-example was found."]
    heads = ["family", "designs", "excluded", "fell", "fell later", "creep", "refused", "stood"]
    return "\n".join([table(heads, lines), "", *examples])


def summary(rows: list[dict]) -> str:
    """One line."""
    excluded = sum(row["static"] == "unstable" for row in rows)
    stood = sum(row.get("dynamic") == "stands" for row in rows)
    return f"- Of {len(rows)} random designs, statics exclude {excluded}. Of these, {stood or 'none'} stood in Bullet."


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--designs", type=int, default=1100)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--rows", type=Path, help="file of rows: those in it are taken from it, others appended")
    options = parser.parse_args()
    known = []
    if options.rows and options.rows.is_file():
        known = [json.loads(line) for line in options.rows.read_text().splitlines()]
    names, shares = list(FAMILIES), np.array([share for _, share, _ in FAMILIES.values()])
    draw = np.random.default_rng(options.seed)
    rows = []
    for number in range(options.designs):
        family = str(draw.choice(names, p=shares / shares.sum()))
        if number < len(known):
            rows.append(known[number])
            continue
        rows.append({"number": number, **judged(family, np.random.default_rng([options.seed, number]))})
        if options.rows:
            with options.rows.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
    results.report(options, rows, {"table": counts(rows), "summary": summary(rows)})


if __name__ == "__main__":
    main()
