"""Two values of a parameter with verdicts on both sides of a limit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from blockstat.analysis.limit_load import DILATES
from blockstat.result import Result, Sentence, both_ends, finite


class BracketOutcome(Sentence):
    """The answers of `tilt_limit` and `friction_limit`; each value is the sentence a user reads."""

    LIMIT = "Limit: the assembly stands on one side of the limit and not on the other."
    ALWAYS_STANDS = "Always stands: the assembly is stable in the whole range."
    NEVER_STANDS = "Never stands: the assembly is stable nowhere in the range."
    CHANGE = (
        "Change: a Coulomb state was found at one of two neighbouring values and none at the other. Without dilatancy "
        "that says nothing of values that were not tried."
    )
    NOT_FOUND = (
        "Not found: there is no proof that the assembly never stands, but where it should stand first no Coulomb state "
        "was found."
    )
    OPEN = "Open: the assembly stands at the value given; what it does just beyond could not be proven."
    UNDECIDED = "Undecided: too close to the limit to prove either way, even where the assembly would stand first."


@dataclass(frozen=True)
class Bracket(Result):
    """Two values of a parameter with proven verdicts on both sides of a limit: neighbours, unless `open`."""

    stands: float  #: the assembly is statically stable here; nan if nowhere
    falls: float  #: and unstable here; nan if nowhere in the range, or where no fall could be proven
    parameter: str = "parameter"  #: what is varied, "tilt" or "friction"
    unit: str = ""  #: of both values, "deg" or none
    #: with flow="coulomb", both values for each kind of joints (`blockstat.analysis.coulomb.FAMILY`): stiff ones,
    #: elastic ones, and both; the outer values are those of the joints that bear most
    kinds: tuple[tuple[float, float], ...] = ()
    worst: str = ""  #: the case of the imperfections that this bracket is of, the worst one, in words
    warnings: tuple[str, ...] = ()
    flow: str = "associated"  #: or "coulomb", as it was asked
    #: whether verdicts just beyond `stands` are undecided, so that no fall is proven, or one further off than was asked
    open: bool = False

    @property
    def value(self) -> float:
        """The end that is certain: the one at which the assembly stands."""
        return self.stands

    @property
    def outcome(self) -> BracketOutcome:
        """Whether there is a limit in the range; open where one side is known, undecided where neither is.

        Without dilatancy an assembly may stand with less friction and fall with more, and values tried are all that is
        known: there is a change in place of a limit.
        """
        sampled = self.flow == "coulomb"
        if math.isnan(self.stands) and math.isnan(self.falls):
            return BracketOutcome.NOT_FOUND if sampled else BracketOutcome.UNDECIDED
        if math.isnan(self.stands):
            return BracketOutcome.NEVER_STANDS
        if self.open:
            return BracketOutcome.OPEN
        if math.isnan(self.falls):
            return BracketOutcome.ALWAYS_STANDS
        return BracketOutcome.CHANGE if sampled else BracketOutcome.LIMIT

    def explain(self) -> str:
        """Return the answer in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value, *([f"Worst case of the imperfections: {self.worst}."] if self.worst else [])]
        unit = f" {self.unit}" if self.unit else ""
        stands, falls = both_ends(self.stands, self.falls, 9)
        if not math.isnan(self.stands):
            lines.append(f"Stable at a {self.parameter} of {stands}{unit}.")
        if not math.isnan(self.falls):
            lines.append(f"Not stable at a {self.parameter} of {falls}{unit}.")
        if self.kinds:
            ends = ", ".join("none" if math.isnan(stands) else f"{stands:.6g}" for stands, _ in self.kinds)
            to = "up to" if self.parameter == "tilt" else "down to"
            lines.append(f"In stiff joints, elastic ones and both in one a Coulomb state is found {to} {ends}{unit}.")
        elif self.flow == "associated" and not math.isnan(self.stands):
            lines.append(DILATES)
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

    @property
    def least(self) -> tuple[float, float]:
        """Both values for the joints that bear least; the limit is not unique without dilatancy."""
        return self.kinds[_order(self.kinds, self.parameter)[-1]] if self.kinds else (self.stands, self.falls)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; a side that does not exist is None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "parameter": self.parameter,
            "unit": self.unit,
            "stands": finite(self.stands),
            "falls": finite(self.falls),
            "imperfections": self.worst or None,
            "kinds": [[finite(stands), finite(falls)] for stands, falls in self.kinds],
            "warnings": list(self.warnings),
        }


def _order(kinds: Sequence[tuple[float, float]], parameter: str) -> list[int]:
    """Numbers of the kinds of joints, those that bear most first: the most tilt, the least friction."""
    sign = -1.0 if parameter == "tilt" else 1.0
    return sorted(range(len(kinds)), key=lambda k: math.inf if math.isnan(kinds[k][0]) else sign * kinds[k][0])


def of_kinds(found: Sequence[tuple[float, float]], parameter: str, unit: str = "") -> Bracket:
    """Return the bracket of the joints that bear most, with those of all kinds.

    Parameters
    ----------
    found
        Both values for each kind of joints.
    parameter, unit
        As of `Bracket`.

    Returns
    -------
    Bracket
        With its kinds.
    """
    return Bracket(*found[_order(found, parameter)[0]], parameter, unit, tuple(found))
