"""Put hard scenes to the statics and write docs/hard.md: `make hard`."""

from __future__ import annotations

import math
import sys
from collections import Counter
from pathlib import Path
from time import process_time

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

import recheck

recheck.install()

from blockstat import assess
from hard.cases import CASES
from hard.outcome import Row, outcome
from hard.piles import pile

PILES = 10_000
HEAD = """# Hard cases

Written by `make hard`. Scenes that break solvers, the truth about each and what came out. A case within a hair of its
limit, or with a joint hardly wider than nothing, may be undecided; none may be wrong. Where a case is closer to its
limit than 1e-9 of the weight, the stated tolerance of the certificates, either word is honest. The residual is what is
left unbalanced on a block beside its own load. Behind every answer stands the second opinion of `tests/recheck.py`,
which shares no code with the product; each row is a test (`tests/hard`).

| family | case | true | answer | | by | residual | s | what the user is told |
|---|---|---|---|---|---|---|---|---|
"""


def line(row: Row) -> str:
    case = row.case
    residual = "" if math.isnan(row.residual) else f"{row.residual:.0e}"
    told = " ".join(row.told).replace("|", "\\|")
    if row.word == "undecided" and not told:
        told = "too close to the limit for the numbers; both figures"
    return (
        f"| {case.family} | {case.name} | {case.right} | {row.word} | {'right' if row.right else '**WRONG**'} | "
        f"{row.solver} | {residual} | {row.seconds:.2f} | {told} |"
    )


def piles() -> str:
    """Verdicts on random piles, counted; a wrong proof raises AssertionError."""
    begin, words = process_time(), Counter()
    for seed in range(PILES):
        words[assess(pile(seed)).outcome.word] += 1
    counts = ", ".join(f"{number:,} {word}" for word, number in words.most_common())
    return (
        f"\n## Random piles\n\n{PILES:,} random piles of 1 to 15 blocks (`tests/hard/piles.py`: any friction from none "
        "to endless, mass ratios to 1e5 from density alone, sheared, turned, in millimetres to kilometres, tilted): "
        f"{counts}. No proof was rejected by the second opinion, no answer was not a number, none took long: "
        f"{process_time() - begin:.0f} s of process time in all.\n"
    )


def main() -> None:
    lines = []
    for case in CASES:
        lines.append(line(outcome(case)))
        print(lines[-1], flush=True)
    (HERE / "hard.md").write_text(HEAD + "\n".join(lines) + "\n" + piles())


if __name__ == "__main__":
    main()
