"""Ask Bullet for every closed form and limit again and write docs/dynamics_validation.md: `make validation`.

The families and their sources are in evidence/references/dynamics.py; tests/dynsim/test_dynamic_references.py asks the
same.
"""

from __future__ import annotations

from time import process_time

from dynsim import verify
from evidence.paths import DOCS
from evidence.references.dynamics import BLOCKS, DIRECTIONS, LIMITS, RESTS, rocking, slips_rightly
from evidence.tables import head, row

HEADER = """# Validation of the dynamics

Written by `make validation` with the default preset. Limits are given as multiples of the exact limit: the largest
multiple that stood and the smallest that did not. Seconds are the process time of all runs of a row. The families and
their sources are in [evidence/references/dynamics.py](../evidence/references/dynamics.py). The tests are in
[tests/dynsim/test_dynamic_references.py](../tests/dynsim/test_dynamic_references.py).
"""


def section(title: str, test: str, source: str) -> list[str]:
    """Heading, which test asks for the rows, and where the truth is from."""
    return [f"## {title}", "", f"Test: `{test}`. Source: {source}.", ""]


def limits() -> list[str]:
    lines = [
        *section("Limits", "test_a_family_stops_standing_at_its_limit[<row>]", "the second column"),
        head(["", "limit from", "stood", "did not", "error", "accepted", "s"]),
    ]
    for limit in LIMITS:
        begin = process_time()
        low, high = limit.bracket()
        error, seconds = (low + high) / 2 - 1, process_time() - begin
        shares = (f"{100 * error:+.2f} %", f"{100 * limit.within:g} %")
        lines.append(row([limit.name, limit.source, f"{low:.4f}", f"{high:.4f}", *shares, f"{seconds:.1f}"]))
        print(lines[-1], flush=True)
    return lines


def slips() -> list[str]:
    lines = [
        *section("Slip", "test_slip_within_half_a_percent_of_friction", "Coulomb, tan(angle) = mu"),
        f"Number of directions, of {DIRECTIONS}, in which a slab rests at .995 mu and slides at 1.005 mu.",
        "",
    ]
    for name, hull in (("boxes", False), ("hulls", True)):
        right = sum(slips_rightly(hull, direction) for direction in range(DIRECTIONS))
        lines.append(f"- {name}: {right} of {DIRECTIONS}")
    return lines


def rocks() -> list[str]:
    lines = [
        *section("Rocking", "test_rocking_follows_housner", "[Housner 1963](bibliography.md#housner-1963)"),
        head(["block [m]", "quarter period / exact", "restitution / (1 - 1.5 sin^2 alpha)"]),
    ]
    for width, height in BLOCKS:
        found = rocking(width, height)
        lines.append(row([f"{width} x {height}", f"{found.quarter:.4f}", f"{found.restitution:.4f}"]))
    return lines


def rests() -> list[str]:
    lines = [
        *section("Rest", "test_tall_walls_and_long_arches_rest[<row>]", "statics, by which both stand"),
        head(["", "verdict", "moved [mm]", "threshold [mm]", "s"]),
    ]
    for name, scene in RESTS.items():
        verdict = verify(scene())
        moved, threshold = 1e3 * verdict.max_displacement, 1e3 * verdict.brick_threshold
        seconds = verdict.run.process_seconds
        lines.append(row([name, verdict.outcome.word, f"{moved:.2g}", f"{threshold:.3g}", f"{seconds:.1f}"]))
    return lines


def main() -> None:
    sections = [HEADER.splitlines(), slips(), rocks(), limits(), rests()]
    text = "\n\n".join("\n".join(lines) for lines in sections)
    print(text)
    (DOCS / "dynamics_validation.md").write_text(text.rstrip() + "\n")


if __name__ == "__main__":
    main()
