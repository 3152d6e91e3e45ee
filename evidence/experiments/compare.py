"""Compare the predictions of `evidence.experiments.predict`, as they were written, with what was measured."""

from __future__ import annotations

from typing import Any

import numpy as np

from evidence import results
from evidence.experiments.predict import FRICTIONS, KINDS, predictions
from evidence.experiments.walls import FILE, UNIT_WEIGHT, tests
from evidence.tables import table

Predicted = dict[tuple[str, float], float]


def measured(test: dict[str, Any]) -> list[float]:
    """Greatest forces [kN] in the directions that were tested, plus before minus."""
    return [test["peak"][f"{side}_kN"] for side in ("plus", "minus") if test["peak"][f"{side}_kN"] is not None]


def rigid(test: dict[str, Any]) -> float:
    """Force [kN] at which the wall as one block turns about its toe, the cap free to turn."""
    shape, axial = test["geometry"], test["axial"]["load_kN"]
    weight = UNIT_WEIGHT / 1e3 * shape["length_m"] * shape["height_m"] * shape["thickness_m"]
    return (axial + weight) * shape["length_m"] / 2 / shape["H0_m"]


def level(test: dict[str, Any]) -> tuple[float, float]:
    """Least and greatest force [kN] over the frictions if the cap could not turn at all.

    A rigid wall between level plates carries (N + W / 2) L / H, and no more than mu N below the cap (references: a
    monolith turns about two opposite corners).
    """
    shape, axial = test["geometry"], test["axial"]["load_kN"]
    weight = UNIT_WEIGHT / 1e3 * shape["length_m"] * shape["height_m"] * shape["thickness_m"]
    turning = (axial + weight / 2) * shape["length_m"] / shape["height_m"]
    return min(FRICTIONS[0] * axial, turning), min(FRICTIONS[-1] * axial, turning)


def ends(values: Any, form: str = ".1f") -> str:
    """The least and the greatest of some values, or the one there is."""
    low, high = format(min(values), form), format(max(values), form)
    return low if low == high else f"{low} to {high}"


def of_kind(found: Predicted, kind: str) -> list[float]:
    """The predictions of one kind, by friction."""
    return [found[kind, mu] for mu in FRICTIONS]


def wall_row(test: dict[str, Any], found: Predicted) -> list[str]:
    """One test beside what was computed for it."""
    peaks = measured(test)
    ratios = [
        ends([peak / value for value in of_kind(found, "associated")], ".2f") if peak is not None else "-"
        for peak in (test["peak"]["plus_kN"], test["peak"]["minus_kN"])
    ]
    return [
        test["id"], test["loading"], test["failure_reported"], f"{test['axial']['load_kN']:g}",
        " / ".join(f"{peak:g}" for peak in peaks), *(ends(of_kind(found, kind)) for kind in KINDS), *ratios,
    ]  # fmt: skip


def groups(rows: list[tuple[dict[str, Any], Predicted]]) -> dict[tuple[str, float], list[list[float]]]:
    """Measured over associated by friction, a row for each direction of each test, by series and axial load."""
    found: dict[tuple[str, float], list[list[float]]] = {}
    for test, forces in rows:
        key = test["series"], test["axial"]["load_kN"]
        # Two directions of one wall count as one wall.
        mean = float(np.mean(measured(test)))
        found.setdefault(key, []).append([mean / value for value in of_kind(forces, "associated")])
    return found


def means(rows: list[tuple[dict[str, Any], Predicted]]) -> str:
    """Means of measured over computed by axial load."""
    lines = []
    for (series, axial), ratios in groups(rows).items():
        of_series = [r for r in rows if (r[0]["series"], r[0]["axial"]["load_kN"]) == (series, axial)]
        crushed = [
            np.mean([np.mean(measured(test)) / forces["crushing", mu] for test, forces in of_series])
            for mu in FRICTIONS
        ]
        lines.append(
            [series, f"{axial:g}", len(ratios), *(f"{value:.3f}" for value in np.mean(ratios, axis=0)),
             ends(crushed, ".3f"), f"{np.mean([np.mean(measured(t)) / rigid(t) for t, _ in of_series]):.3f}"]
        )  # fmt: skip
    heads = [
        "series",
        "axial [kN]",
        "walls",
        *(f"associated, friction {mu:g}" for mu in FRICTIONS),
        "crushing",
        "one block",
    ]
    return table(heads, lines)


def sides(rows: list[tuple[dict[str, Any], Predicted]]) -> str:
    """Means of the two directions of the cyclic tests apart."""
    both = [(test, forces["associated", 0.7]) for test, forces in rows if test["peak"]["minus_kN"] is not None]
    if not both:
        return "None of the walls was pushed to and fro."
    plus, minus = ([test["peak"][f"{side}_kN"] / force for test, force in both] for side in ("plus", "minus"))
    more = [b / a for a, b in zip(plus, minus, strict=True)]
    return (
        f"In the {len(both)} cyclic tests the direction minus carried {100 * min(more) - 100:.0f} to "
        f"{100 * max(more) - 100:.0f} % more than plus. Measured over computed (associated, friction .7) is "
        f"{np.mean(plus):.3f} on the mean for plus ({ends(plus, '.2f')}) and {np.mean(minus):.3f} for minus "
        f"({ends(minus, '.2f')})."
    )


def misses(rows: list[tuple[dict[str, Any], Predicted]]) -> str:
    """The tests further than a tenth from every prediction, each with what a level cap would carry."""
    lines = []
    for test, forces in rows:
        ratios = [np.mean(measured(test)) / value for kind in KINDS for value in of_kind(forces, kind)]
        if min(ratios) > 1.1 or max(ratios) < 0.9:
            low, high = level(test)
            lines.append(
                [test["id"], test["failure_reported"], f"{np.mean(measured(test)):.1f}", ends(ratios, ".2f"),
                 ends((low, high))]
            )  # fmt: skip
    heads = ["wall", "failure", "measured [kN]", "over computed", "a cap that cannot turn would carry [kN]"]
    return table(heads, lines)


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--walls", type=int, metavar="N", help="so many alone, the first of the folder")
    options = parser.parse_args()
    if not FILE.is_file():
        raise SystemExit(f"no file {FILE}; set BLOCKSTAT_EXPERIMENTS to the directory of the experiments")
    predicted = predictions()
    rows = [(test, predicted[test["id"]]) for test in tests()[: options.walls]]
    heads = ["wall", "test", "failure", "axial [kN]", "measured [kN]", *KINDS, "plus / associated", "minus"]
    parts = {
        "walls": table(heads, (wall_row(*row) for row in rows)),
        "means": means(rows),
        "sides": sides(rows),
        "misses": misses(rows),
    }
    results.report(options, [wall_row(*row) for row in rows], parts)


if __name__ == "__main__":
    main()
