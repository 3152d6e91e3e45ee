"""Contacts of traced dry walls against an independent measurement on their outlines, at a stated gap.

    python -m evidence.comparisons.rubble [--gap "2 mm"] [--json] [--write FILE]

The measurement (contacts.json beside the walls) lists the distance of every pair of stones nearer than 3 mm, and
the length over which their sides are opposed within 2 mm and 3 degrees. A pair with at least 5 mm of it is a pair of
faces, another one a pair of a corner or an edge.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from blockstat import Assembly, find_interfaces, read
from blockstat.contact.unresolved import unresolved_contacts
from evidence import results
from evidence.paths import CASES
from evidence.tables import table

FOLDER = CASES / "rubble"
NEAR = 0.002  #: distance up to which a pair counts [m]
OPPOSED = 0.005  #: length of opposed sides from which on it is a pair of faces [m]


@dataclass(frozen=True)
class Pair:
    """Two stones that are near each other, and what is found between them."""

    wall: str
    a: str
    b: str
    distance: float  #: [m]
    faces: bool  #: whether sides are opposed
    found: str  #: "contact", the reason why there is no unique normal, or "" for nothing


def measured(folder: Path) -> dict[str, list[tuple[str, str, float, bool]]]:
    """The pairs of each wall that are near: names, distance [m], and whether they have opposed sides."""
    walls = json.loads((folder / "contacts.json").read_text())["walls"]
    return {
        wall: [(a, b, distance, opposed >= OPPOSED) for a, b, distance, _, _, opposed, *_ in rows if distance < NEAR]
        for wall, rows in walls.items()
    }


def found_between(assembly: Assembly, gap: float | str) -> dict[frozenset[str], str]:
    """What is found between two blocks, by their names."""
    interfaces = find_interfaces(assembly, gap=gap)
    bare = unresolved_contacts(assembly, interfaces, gap=gap)

    def names(pair: tuple[int, int]) -> frozenset[str]:
        return frozenset(assembly.names[block] for block in pair)

    found = {names(pair): reason for pair, reason in zip(bare.pair.tolist(), bare.reason, strict=True)}
    return found | {names(pair): "contact" for pair in interfaces.pair.tolist()}


def compared(gap: float | str, folder: Path = FOLDER) -> list[Pair]:
    """All near pairs of all walls with what is found at a gap."""
    rows = []
    for wall, pairs in measured(folder).items():
        found = found_between(read(folder / f"{wall}.json"), gap)
        rows += [Pair(wall, a, b, d, faces, found.get(frozenset((a, b)), "")) for a, b, d, faces in pairs]
    return rows


def parts(rows: list[Pair], gap: float | str) -> dict[str, str]:
    """How many pairs are found in each wall, and those that are not, or have no normal."""
    counted = []
    for wall in dict.fromkeys(row.wall for row in rows):
        own = [row for row in rows if row.wall == wall]
        line: list[object] = [wall]
        for faces in (True, False):
            kind = [row.found for row in own if row.faces == faces]
            line += [len(kind), kind.count("contact")]
        bare = [row.found for row in own if row.found != "contact"]
        counted.append([*line, len(bare) - bare.count(""), bare.count("")])
    names = [
        "wall",
        "pairs of faces",
        "found",
        "pairs of corners or edges",
        "found",
        "without a unique normal",
        "missed",
    ]
    rest = [
        [row.wall, f"{row.a}, {row.b}", f"{row.distance * 1e3:.2f}", row.found or "not found"]
        for row in rows
        if row.found != "contact"
    ]
    missed = sum(not row.found for row in rows)
    summary = (
        f"- Of {len(rows)} pairs of stones within {NEAR * 1e3:g} mm, {sum(r.found == 'contact' for r in rows)} have a "
        f"contact at `gap={gap!r}`. {sum(bool(r.found) for r in rows if r.found != 'contact')} touch where there is no "
        f"unique normal, and {missed or 'none'} {'are' if missed != 1 else 'is'} missed."
    )
    return {
        "summary": summary,
        "pairs": table(names, counted),
        "without": table(["wall", "stones", "distance [mm]", "reason"], rest),
    }


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--gap", default="2 mm")
    options = parser.parse_args()
    if not FOLDER.is_dir():
        raise SystemExit(f"no directory {FOLDER}; set BLOCKSTAT_CASES to the one of the cases")
    rows = compared(options.gap)
    results.report(options, [asdict(row) for row in rows], parts(rows, options.gap))


if __name__ == "__main__":
    main()
