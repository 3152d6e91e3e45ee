"""Compute every reference value again and write docs/validation.md: `make validation`.

The rows and their sources are in `evidence.references`; tests/validation asks the same of them.
"""

from __future__ import annotations

import math
import re
import sys
from time import process_time

from evidence import tables
from evidence.paths import DOCS
from evidence.references import SECTIONS
from evidence.references.row import Row

HEADER = """# Validation

Written by `make validation`. Each row compares a reference value with the value that blockstat computes. The first
column gives the kind of the reference:

- E: exact. The source is its formula, or the reason for it.
- P: published. The source is a work of the [bibliography](bibliography.md).
- D: derived from first principles by two methods. The source is the program that computes it again.
- d: derived by one method.

The bracket is the distance between the value that is proven to stand and the value that is proven to fall. For zero
dilatancy and Coulomb angles it is the width of the bisection. The error is the value of blockstat less the reference,
and s are seconds of process time. Every row is a test to the digits given, and its name is
made of the first two columns:

    pytest "tests/validation/test_references.py::test_reference[P Ferris & Tin-Loi W1, associated]"
"""
COLUMNS = tables.head(["", "reference", "value", "blockstat", "bracket", "error", "s", "source"])
#: A work as the bibliography calls it.
WORK = re.compile(r"[A-Z]\w+( [A-Z][\w]+)? \d{4}")


def linked(source: str) -> str:
    """A source with its works linked to the bibliography."""
    return WORK.sub(lambda m: f"[{m[0]}](bibliography.md#{m[0].lower().replace(' ', '-')})", source)


def line(row: Row) -> str:
    """What we compute beside a reference."""
    begin = process_time()
    ours, bracket = row.compute()
    seconds = process_time() - begin
    width = "" if math.isnan(bracket) else f"{abs(bracket):.0e}"
    error = 0.0 if ours == row.value else ours - row.value
    value = row.reference if isinstance(row.reference, str) else f"{row.value:.7g}"
    figures = (value, f"{ours:.7g}", width, f"{error:+.0e}", f"{seconds:.2f}")
    return tables.row([row.tag, row.name, *figures, linked(row.source)])


def main() -> None:
    written = [HEADER]
    for title, module in SECTIONS.items():
        path = f"{module.__name__.replace('.', '/')}.py"
        written.append(f"## {title}\n\nComputed in [{path}](../{path}).\n\n{COLUMNS}")
        print(written[-1])
        for row in module.ROWS:
            if row.missing:
                print(f"{row.needs} is not here; left out: {row.name}", file=sys.stderr)
                continue
            written.append(line(row))
            print(written[-1], flush=True)
        written.append("")
    (DOCS / "validation.md").write_text("\n".join(written).rstrip() + "\n")


if __name__ == "__main__":
    main()
