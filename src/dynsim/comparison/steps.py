"""Statics and Bullet side by side on the steps of a plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.result import Result
from blockstat.sequence.states import Whole
from dynsim.judge.replay import DynamicSequence
from dynsim.judge.verdict import DynamicOutcome

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True, eq=False)
class StepComparison(Result):
    """What statics and Bullet say of each step of a plan."""

    static: tuple[Outcome, ...]  #: whether admissible forces exist
    coulomb: tuple[Outcome | None, ...]  #: without dilatancy and self-stress; None where the two agree anyway
    dynamic: tuple[DynamicOutcome, ...]

    @property
    def differ(self) -> list[int]:
        """Steps that statics call stable and Bullet sees fall or creep, or the other way round."""
        pairs = zip(self.static, self.dynamic, strict=True)
        return [k for k, (s, d) in enumerate(pairs) if (s is Outcome.STABLE) != (d is DynamicOutcome.STANDS)]

    @property
    def unexplained(self) -> list[int]:
        """Of those, steps on which Coulomb's verdict does not side with Bullet."""
        return [k for k in self.differ if (self.coulomb[k] is Outcome.STABLE) != _stands(self.dynamic[k])]

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            The verdict on each step, and the numbers of those that differ.
        """
        return {
            "verdicts": [outcome.word for outcome in self.static],
            "differ": self.differ,
            "coulomb": {str(k): outcome.word for k, outcome in enumerate(self.coulomb) if outcome is not None},
            "unexplained": self.unexplained,
        }

    def explain(self) -> str:
        """Return the comparison in words.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [f"Statics and Bullet agree on {len(self.static) - len(self.differ)} of {len(self.static)} steps."]
        for k in self.differ:
            coulomb = self.coulomb[k]
            word = "" if coulomb is None else f', with flow="coulomb" {coulomb.word}'
            lines.append(f"step {k}: Bullet {self.dynamic[k].word}, statics {self.static[k].word}{word}")
        return "\n".join(lines)


def compare_steps(assembly: Assembly, found: DynamicSequence) -> StepComparison:
    """Judge the steps of a plan by statics, and by Coulomb's verdict where Bullet differs.

    Parameters
    ----------
    assembly : Assembly
        The blocks, with the friction of the run.
    found : DynamicSequence
        What Bullet made of them.

    Returns
    -------
    StepComparison
        The verdicts side by side.
    """
    whole = Whole(assembly)
    states = [whole.state_of(*state, f"step {k}") for k, state in enumerate(found.plan.states())]

    def judged(k: int, flow: str) -> Verdict:
        return whole.assess(*states[k], flow=flow, score=False)

    static = [judged(k, "associated").outcome for k in range(len(states))]
    dynamic = [step.outcome for step in found.steps]
    coulomb: list[Outcome | None] = [None] * len(states)
    for k in range(len(states)):
        if (static[k] is Outcome.STABLE) != _stands(dynamic[k]):
            coulomb[k] = judged(k, "coulomb").outcome
    return StepComparison(tuple(static), tuple(coulomb), tuple(dynamic))


def _stands(outcome: DynamicOutcome) -> bool:
    return outcome is DynamicOutcome.STANDS
