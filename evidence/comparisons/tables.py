"""Tables of the comparisons of static and dynamic verdicts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from dynsim import Comparison, Comparisons
from dynsim.comparison.causes import Cause
from evidence.comparisons.limits import LimitRow
from evidence.tables import table

STATIC = ("stable", "stable_only_by_self_stress", "undecided", "unstable")
BULLET = ("stands", "creeps", "falls")


def matrix(rows: Comparisons, statics: str) -> str:
    """The confusion matrix: a line for each static verdict that occurs, a column for each of Bullet's."""
    counts = rows.confusion(statics)
    said = [word for word in STATIC if any(pair[0] == word for pair in counts)]
    title = {"static": "force fields alone", "coulomb": "with Coulomb friction"}[statics]
    return table(
        [title, *(f"Bullet: {word}" for word in BULLET), "all"],
        (
            [s.replace("_", " "), *(counts.get((s, b), 0) for b in BULLET), sum(counts.get((s, b), 0) for b in BULLET)]
            for s in said
        ),
    )


def by_cause(rows: Comparisons) -> dict[Cause, Comparisons]:
    """Rows with a cause, sorted by it."""
    causes = (cause for cause in Cause if any(row.cause == cause.word for row in rows))
    return {cause: Comparisons(tuple(row for row in rows if row.cause == cause.word)) for cause in causes}


def figures(rows: Comparisons) -> str:
    """The verdicts on some assemblies."""

    def number(value: float | None, factor: float = 1.0) -> str:
        return "" if value is None else f"{factor * value:.3g}"

    return table(
        ["", "blocks", "force fields", "Coulomb", "score", "Bullet", "settled [mm]", "then moved [mm]"],
        (
            [
                row.name, row.blocks, row.static, (row.coulomb or "").replace("_", " "), number(row.score), row.dynamic,
                number(row.settling, 1e3), number(row.max_displacement, 1e3),
            ]
            for row in rows
        ),
    )  # fmt: skip


def families(rows: Comparisons, family: Callable[[Comparison], str]) -> str:
    """How often verdicts agree, family by family."""
    lines = []
    names = list(dict.fromkeys(family(row) for row in rows))
    for name in [*names, "all"]:
        own = [row for row in rows if name in (family(row), "all")]
        cosines = [row.cosine for row in own if row.cosine is not None]
        lines.append(
            [
                name, len(own),
                sum(row.agree is True for row in own), sum(row.agree is False for row in own),
                sum(row.agree_coulomb is True for row in own), sum(row.agree_coulomb is False for row in own),
                sum(row.static == "unstable" and row.dynamic == "stands" for row in own),
                f"{np.median(cosines):.3f}" if cosines else "",
                f"{min(cosines):.2f}" if cosines else "",
            ]
        )  # fmt: skip
    head = ["", "scenes", "force fields agree", "differ", "Coulomb agrees", "differs", "excluded but stands"]
    return table([*head, "median cosine", "least"], lines)


def ratios(rows: Sequence[LimitRow]) -> str:
    """Bullet's limit over the static ones, family by family."""
    lines = []
    for name in [*dict.fromkeys(row.family for row in rows), "all"]:
        own = [row for row in rows if name in (row.family, "all")]
        cells: list[object] = [name, len(own)]
        for which in ("associated", "coulomb"):
            share = np.array([row.bullet / getattr(row, which) for row in own])
            apart = max((row.bullet - getattr(row, which) for row in own), key=abs)
            cells += [f"{np.median(share):.3f}", f"{share.min():.3f}", f"{share.max():.3f}", f"{apart:+.3f}"]
        lines.append(cells)
    measures = ("least", "most", "furthest [g]")
    head = ["", "scenes", "Bullet / force fields: median", *measures, "Bullet / Coulomb: median", *measures]
    return table(head, lines)


def finer_limits(rows: Sequence[LimitRow]) -> str:
    """Bullet's limits beside those with finer time steps, where these were asked for."""
    return table(
        ["", "force fields [g]", "Coulomb, largest [g]", "least [g]", "Bullet [g]", "Bullet, finer [g]"],
        (
            [row.name, *(f"{value:.4f}" for value in (row.associated, row.coulomb, row.least, row.bullet, row.finer))]
            for row in rows
            if row.finer is not None
        ),
    )
