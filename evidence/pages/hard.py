"""Put hard scenes to the statics and write docs/hard.md."""

from __future__ import annotations

import argparse
import math
import re
from collections import Counter
from collections.abc import Iterable
from time import process_time

from blockstat import assess
from evidence.checks import derived, independent
from evidence.hard import edges, jumps, layers, places, rubble, steps, ties
from evidence.hard.cases import CASES, UNDECIDED, Case
from evidence.hard.figures import FigureRow, Section, StagesRow, figure_row, stages_row
from evidence.hard.outcome import Row, outcome
from evidence.hard.piles import pile
from evidence.opinion import brackets, building, curves
from evidence.paths import DOCS
from evidence.tables import table

SECTIONS = tuple(module.SECTION for module in (edges, places, layers, rubble, ties, jumps, steps))
PILES = 10_000
#: What tells the two sides of a limit apart, and what stands for both in their common line.
SIDES = (
    (re.compile(r"0\.999|1\.001"), "1 ± 1e-03"),
    (re.compile(r"0\.99\b|1\.01\b"), "1 ± 1e-02"),
    (re.compile(r"(?<=\b1 )[-+](?= \d)|(?<= )[-+](?=\de-)"), "±"),
)
SAID = 2  #: warnings of a figure that are shown
HEAD = """# Hard cases

Written by `make evidence ONLY=hard`. These are scenes on which solvers fail, with the truth about each, where it comes
from, and the answer of blockstat. A verdict may be undecided where the scene is very close to its limit, or has a
joint of almost no width; no verdict may be wrong. Where a case is closer to its limit than 1e-9 of the load of a
block, which is the tolerance of the certificates, both answers count as right.
The residual is the largest unbalanced force on a
block, relative to its load. A figure is "wide" where its bracket holds the truth but not as sharply as is stated,
"off" where it has no bracket and differs by more or has another outcome than the true one, "WRONG" where a bracket
excludes the truth, "rejected" where an independent check refuses what is given as its proof, and a "hang" where there
is no answer in 20 s. "Off by" is relative to the truth, but to the weight for forces of props. The independent checks
in `evidence/checks` and `evidence/opinion`, which take only blocks, joints and joint laws from blockstat, confirm
every answer that is not "rejected". Each row is a test (`tests/hard`). A row with ± is two, one on either side of a
limit, and where its cells differ the first is the side that stands. The tests of the next table are expected to fail.

"""
VERDICTS = ["family", "case", "true", "from", "answer", "", "by", "residual", "s", "what the user is told"]
FIGURES = ["figure", "true", "from", "outcome", "answer", "off by", "", "s", "what the user is told"]
STAGES = ["plan", "true", "from", "answer", "", "s"]
SHORT = ["figure", "true", "answer", "", "why"]


def judged(found: Row) -> str:
    """What a verdict is worth."""
    if found.word == UNDECIDED != found.case.right and found.case.near and not found.case.within:
        return UNDECIDED
    return "right" if found.right else "**WRONG**"


def marked(word: str) -> str:
    """What a figure or a plan is worth; bold where it falls short."""
    return word if word in ("right", UNDECIDED) else f"**{word}**"


def said(texts: Iterable[str]) -> str:
    """What the user is told, in a cell of a table."""
    return " ".join(texts).replace("|", "\\|")


def verdict_cells(found: Row) -> list[str]:
    """One verdict as it came out."""
    case = found.case
    told = said(found.told)
    if found.word == UNDECIDED and not told:
        told = "too close to the limit for the numbers; both figures"
    residual = "" if math.isnan(found.residual) else f"{found.residual:.0e}"
    words = [case.family, case.name, case.right, case.why, found.word, judged(found), found.solver]
    return [*words, residual, f"{found.seconds:.2f}", told]


def answer(row: FigureRow) -> str:
    """A bracket or a value."""
    lower, upper = (f"{value:.10g}" for value in (row.found.lower, row.found.upper))
    return "" if math.isnan(row.found.lower) else lower if row.found.lower == row.found.upper else f"{lower} to {upper}"


def figure_cells(row: FigureRow) -> list[str]:
    """One figure as it came out."""
    figure, told = row.figure, said(row.found.told[:SAID])
    off = "" if math.isnan(row.off) else f"{row.off:.0e}"
    words = [figure.name, f"{figure.value:.10g}", figure.why, row.found.word, answer(row), off, marked(row.judged)]
    return [*words, f"{row.seconds:.2f}", told]


def stages_cells(row: StagesRow) -> list[str]:
    """One plan as it came out."""
    stages = row.stages
    true, found = (", ".join(words) for words in (stages.right, row.words))
    return [stages.name, true, stages.why, found, marked(row.judged), f"{row.seconds:.2f}"]


def verdicts(cases: Iterable[Case]) -> str:
    """The table of some verdicts."""
    return told_table(VERDICTS, (verdict_cells(outcome(case)) for case in cases))


def both_sides(name: str) -> str:
    """A name that is the same on either side of a limit."""
    for sign, either in SIDES:
        name = sign.sub(either, name)
    return name


def told_table(names: list[str], rows: Iterable[list[str]]) -> str:
    """A table, each line of which is printed as soon as it is known; the two sides of a limit become one line."""
    kept: dict[tuple[str, ...], list[list[str]]] = {}
    first = names.index("true")
    for number, cells in enumerate(rows):
        print(*cells, sep=" | ", flush=True)
        # Figures of two sides differ in more than their word.
        sides = tuple(map(both_sides, cells[:first])) if names is not FIGURES else (str(number),)
        kept.setdefault(sides, []).append(cells)
    lines = []
    for sides, group in kept.items():
        rest = ["; ".join(filter(None, dict.fromkeys(texts))) for texts in zip(*group, strict=True)]
        lines.append(rest if len(group) == 1 else [*sides, *rest[first:]])
    return table(names, lines) + "\n"


def section(family: Section, short: list[FigureRow], fast: bool) -> str:
    """A family of cases, without its slow figures if it is to be fast; those that fall short are added to a list."""
    parts = [f"## {family.title}\n\n{family.text}\n"]
    if family.cases:
        parts.append(verdicts(family.cases))
    if family.figures:
        rows = [figure_row(figure) for figure in family.figures if not (fast and figure.slow)]
        short += [row for row in rows if row.judged != "right"]
        parts.append(told_table(FIGURES, map(figure_cells, rows)))
    if family.stages:
        parts.append(told_table(STAGES, (stages_cells(stages_row(stages)) for stages in family.stages)))
    return "\n".join(parts)


def shortfalls(short: list[FigureRow]) -> str:
    """The table of figures that fall short."""
    rows = [
        [row.figure.name, f"{row.figure.value:.10g}", f"{row.found.word} {answer(row)}", marked(row.judged),
         row.figure.flaw]
        for row in short
    ]  # fmt: skip
    return f"## What falls short\n\n{table(SHORT, rows)}\n"


def piles(number: int) -> str:
    """Verdicts on so many random piles, counted; a wrong proof raises AssertionError."""
    begin, words = process_time(), Counter()
    for seed in range(number):
        words[assess(pile(seed)).outcome.word] += 1
    counts = ", ".join(f"{count:,} {word}" for word, count in words.most_common())
    return (
        f"## Random piles\n\nThe verdicts on {number:,} random piles of 1 to 15 blocks (`evidence/hard/piles.py`) "
        f"are: {counts}. The piles have any friction from zero to infinite and mass ratios up to 1e5 from density "
        "alone. They are sheared, turned and tilted, and their size is from millimetres to kilometres. The "
        "independent check rejected no proof, every answer was a number, and none took long: "
        f"{process_time() - begin:.0f} s of process time in all.\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="without the slow figures")
    parser.add_argument("--piles", type=int, default=PILES, help="how many random piles")
    options = parser.parse_args()
    for checks in (independent, derived, brackets, building, curves):
        checks.install()
    short: list[FigureRow] = []
    first = f"## Single scenes\n\n{verdicts(CASES)}"
    families = [section(family, short, options.fast) for family in SECTIONS]
    (DOCS / "hard.md").write_text(HEAD + "\n".join([shortfalls(short), first, *families, piles(options.piles)]))


if __name__ == "__main__":
    main()
