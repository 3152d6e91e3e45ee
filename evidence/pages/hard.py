"""Put hard scenes to the statics and write docs/hard.md."""

from __future__ import annotations

import math
from collections import Counter
from time import process_time

from blockstat import assess
from evidence.checks import independent
from evidence.hard.cases import CASES
from evidence.hard.outcome import Row, outcome
from evidence.hard.piles import pile
from evidence.paths import DOCS
from evidence.tables import head, row

PILES = 10_000
HEAD = """# Hard cases

Written by `make evidence ONLY=hard`. These are scenes on which solvers fail, with the truth about each and the answer
of blockstat. A case very close to its limit, or with a joint of almost no width, may be undecided. No answer may be
wrong. Where a case is closer to its limit than 1e-9 of the weight, which is the tolerance of the certificates, both
answers count as right. The residual is the largest unbalanced force on a block, relative to its load. The independent
check in `evidence/checks`, which takes only blocks, joints and joint laws from blockstat, confirms every answer. Each
row is a test (`tests/hard`).

"""
HEADS = ["family", "case", "true", "answer", "", "by", "residual", "s", "what the user is told"]


def line(found: Row) -> str:
    """One case as it came out."""
    case = found.case
    residual = "" if math.isnan(found.residual) else f"{found.residual:.0e}"
    told = " ".join(found.told).replace("|", "\\|")
    if found.word == "undecided" and not told:
        told = "too close to the limit for the numbers; both figures"
    judged = "right" if found.right else "**WRONG**"
    words = (case.family, case.name, case.right, found.word, judged, found.solver)
    return row([*words, residual, f"{found.seconds:.2f}", told])


def piles() -> str:
    """Verdicts on random piles, counted; a wrong proof raises AssertionError."""
    begin, words = process_time(), Counter()
    for seed in range(PILES):
        words[assess(pile(seed)).outcome.word] += 1
    counts = ", ".join(f"{number:,} {word}" for word, number in words.most_common())
    return (
        f"\n## Random piles\n\nThe verdicts on {PILES:,} random piles of 1 to 15 blocks (`evidence/hard/piles.py`) "
        f"are: {counts}. The piles have any friction from zero to infinite and mass ratios up to 1e5 from density "
        "alone. They are sheared, turned and tilted, and their size is from millimetres to kilometres. The "
        "independent check rejected no proof, every answer was a number, and none took long: "
        f"{process_time() - begin:.0f} s of process time in all.\n"
    )


def main() -> None:
    independent.install()
    lines = [head(HEADS)]
    for case in CASES:
        lines.append(line(outcome(case)))
        print(lines[-1], flush=True)
    (DOCS / "hard.md").write_text(HEAD + "\n".join(lines) + "\n" + piles())


if __name__ == "__main__":
    main()
