"""The table of static and dynamic verdicts: in a notebook, as CSV, as JSON."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from html import escape
from pathlib import Path
from typing import Any

from blockstat.errors import InputError
from blockstat.result import Result, Sentence
from blockstat.system.writing import written_whole

STATICS = ("static", "coulomb")


class Agreement(Sentence):
    """Whether statics and Bullet say the same; the value of each is the sentence that a user reads."""

    AGREE = "Statics and Bullet agree, with and without dilatancy and self-stress."
    DIFFER = "Statics and Bullet differ."
    OPEN = "Statics or Bullet do not decide."
    NO_VERDICT = "There is no verdict."


@dataclass(frozen=True)
class Comparison(Result):
    """What statics and Bullet say of one assembly: a row of a table.

    Lengths are in metres, times are process seconds. What was not reached is None.
    """

    name: str
    blocks: int | None = None
    interfaces: int | None = None
    static: str | None = None  #: force fields alone: "stable", "unstable", "undecided"
    coulomb: str | None = None  #: without dilatancy and self-stress: also "stable_only_by_self_stress"
    score: float | None = None
    dynamic: str | None = None  #: "stands", "falls", "creeps"
    group_drop: float | None = None
    max_drop: float | None = None
    max_displacement: float | None = None
    settling: float | None = None
    static_seconds: float | None = None
    coulomb_seconds: float | None = None
    dynamic_seconds: float | None = None
    agree: bool | None = None  #: static with dynamic; None when one of them says neither, or is missing
    agree_coulomb: bool | None = None  #: coulomb with dynamic
    cosine: float | None = None  #: of the static mechanism with Bullet's first motion, where both say it falls
    cause: str = (
        ""  #: word of `dynsim.comparison.causes.Cause` where a static verdict differs from Bullet or one says neither
    )
    note: str = ""
    lmgc90: str | None = None  #: "stands", "falls", "creeps"; None where LMGC90 was not asked or gave no verdict
    lmgc90_displacement: float | None = None
    lmgc90_seconds: float | None = None

    @property
    def engines_agree(self) -> bool | None:
        """Whether Bullet and LMGC90 say the same; None where one of them says nothing."""
        return None if self.lmgc90 is None or self.dynamic is None else self.lmgc90 == self.dynamic

    @property
    def outcome(self) -> Agreement:
        """Whether Bullet agrees with both static verdicts."""
        if self.static is None and self.agree is None and self.agree_coulomb is None:
            return Agreement.NO_VERDICT
        if self.agree is False or self.agree_coulomb is False:
            return Agreement.DIFFER
        return Agreement.AGREE if self.agree and self.agree_coulomb else Agreement.OPEN

    def explain(self) -> str:
        """Return the verdicts and why they differ, in words.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [f"{self.name}: {self.outcome.value}"]
        if self.static is not None:
            coulomb = (self.coulomb or "no verdict").replace("_", " ")
            second = f" LMGC90: {self.lmgc90}." if self.lmgc90 is not None else ""
            lines.append(f"Force field: {self.static}. Coulomb friction: {coulomb}. Bullet: {self.dynamic}.{second}")
        if self.cosine is not None:
            lines.append(f"Cosine of the static mechanism with Bullet's first motion: {self.cosine:.2f}.")
        if self.note:
            lines.append(f"Note: {self.note}.")
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """Return the row as plain values; what was not reached is None.

        Returns
        -------
        dict
            Values by name.
        """
        return asdict(self)


@dataclass(frozen=True)
class Comparisons(Result):
    """A table of comparisons, in the order in which the assemblies were handed in."""

    rows: tuple[Comparison, ...]

    def __iter__(self) -> Iterator[Comparison]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, index: int) -> Comparison:
        return self.rows[index]

    @property
    def outcome(self) -> Agreement:
        """Whether Bullet agrees with both static verdicts in all rows that have verdicts."""
        found = {row.outcome for row in self}
        ranked = (Agreement.DIFFER, Agreement.OPEN, Agreement.AGREE)
        return next((outcome for outcome in ranked if outcome in found), Agreement.NO_VERDICT)

    def explain(self) -> str:
        """Return the counts, and the rows that differ, in words.

        Returns
        -------
        str
            One fact a line.
        """
        return "\n".join([self._counts(), *(row.explain() for row in self.disagreements)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON: a list of rows.

        Returns
        -------
        dict
            One entry, the list of rows.
        """
        return {"rows": [row.summary() for row in self]}

    def _counts(self) -> str:
        judged = sum(row.static is not None for row in self)
        return (
            f"{len(self)} assemblies, {judged} with verdicts. Bullet agrees with force fields alone on "
            f"{sum(row.agree is True for row in self)}, with Coulomb friction on "
            f"{sum(row.agree_coulomb is True for row in self)}."
        )

    @property
    def has_lmgc90(self) -> bool:
        """Whether LMGC90 gave a verdict on some row."""
        return any(row.lmgc90 is not None for row in self)

    @property
    def disagreements(self) -> Comparisons:
        """Rows in which a static verdict says stable and Bullet falls, or the other way round."""
        return Comparisons(tuple(row for row in self if row.outcome is Agreement.DIFFER))

    def confusion(self, statics: str = "static") -> dict[tuple[str, str], int]:
        """Return how many rows have each pair of a static and a dynamic verdict.

        Parameters
        ----------
        statics : str
            Which static verdict: "static" or "coulomb".

        Returns
        -------
        dict of (str, str) to int
            Rows without verdicts do not count.

        Raises
        ------
        InputError
            For another word.
        """
        if statics not in STATICS:
            raise InputError(f"no static verdict {statics!r}; there are: {', '.join(STATICS)}")
        return dict(Counter((getattr(row, statics), row.dynamic or "") for row in self if row.static is not None))

    def write_csv(self, path: str | Path) -> Path:
        """Write one line a row; what was not reached stays empty.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Path
            The file.
        """
        path = Path(path)
        with (
            written_whole(path) as place,
            place.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file,
        ):
            writer = csv.DictWriter(file, list(Comparison.__dataclass_fields__))
            writer.writeheader()
            writer.writerows([{k: "" if v is None else v for k, v in row.summary().items()} for row in self])
        return path

    def write_json(self, path: str | Path) -> Path:
        """Write an object with a list of rows; what was not reached is null.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Path
            The file.
        """
        path = Path(path)
        with written_whole(path) as place:
            place.write_text(json.dumps(self.summary(), indent=1) + "\n")
        return path

    def _repr_html_(self) -> str:
        lines = [
            f"<p>{self._counts()}</p>",
            "<table><thead><tr>",
            *(f"<th>{title}</th>" for title in TITLES if title != "LMGC90" or self.has_lmgc90),
            "</tr></thead><tbody>",
            *(_line(row, self.has_lmgc90) for row in self),
            "</tbody></table>",
        ]
        return "\n".join(lines)


TITLES = (
    "name",
    "blocks",
    "force field",
    "Coulomb",
    "score",
    "Bullet",
    "LMGC90",
    "moved [mm]",
    "cosine",
    "agree",
    "why not",
)
#: Background of the cell that says whether they agree; the word in it says the same.
COLOUR = {True: "#d9ead3", False: "#f4cccc", None: "#eeeeee"}


def _line(row: Comparison, has_lmgc90: bool) -> str:
    """Return a row of the HTML table."""

    def number(value: float | None, form: str) -> str:
        return "" if value is None else format(value, form)

    agree = {Agreement.AGREE: True, Agreement.DIFFER: False}.get(row.outcome)
    moved = None if row.max_displacement is None else 1e3 * row.max_displacement
    score = "inf" if row.static is not None and row.score is None else number(row.score, ".2e")
    said = [row.static, (row.coulomb or "").replace("_", " "), row.dynamic]
    cells = [row.name, number(row.blocks, "d"), said[0], said[1], score, said[2], *[row.lmgc90] * has_lmgc90]
    text = "".join(
        f"<td>{escape(str(cell or ''))}</td>" for cell in [*cells, number(moved, ".3g"), number(row.cosine, ".2f")]
    )
    word = {True: "yes", False: "no", None: ""}[agree]
    return (
        f'<tr>{text}<td style="background:{COLOUR[agree]};color:#222">{word}</td>'
        f'<td style="text-align:left">{escape(row.note)}</td></tr>'
    )
