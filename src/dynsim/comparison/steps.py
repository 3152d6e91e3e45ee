"""Statics and Bullet side by side on the steps of a plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP
from blockstat.result import Result
from blockstat.sequence.plan import assess_plan
from blockstat.sequence.states import Whole
from dynsim.comparison.causes import outcomes_agree
from dynsim.judge.replay import DynamicSequence
from dynsim.judge.verdict import DynamicOutcome

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Random tightnesses of the joints at which a Coulomb state is looked for.
TIGHTNESSES = 12


@dataclass(frozen=True, eq=False)
class StepComparison(Result):
    """What statics and Bullet say of each step of a plan."""

    static: tuple[Outcome, ...]  #: whether admissible forces exist
    coulomb: tuple[Outcome | None, ...]  #: without dilatancy and self-stress; None where the two agree, and on props
    dynamic: tuple[DynamicOutcome, ...]
    #: share of random tightnesses of the joints at which a Coulomb state exists; None where it was not asked for
    tightness: tuple[float | None, ...]

    @property
    def differ(self) -> list[int]:
        """Steps that statics call stable and Bullet sees fall, or the other way round."""
        return self._where(False)

    @property
    def undecided(self) -> list[int]:
        """Steps of which statics or Bullet say neither: statics do not decide, or the blocks creep."""
        return self._where(None)

    def _where(self, answer: bool | None) -> list[int]:
        pairs = zip(self.static, self.dynamic, strict=True)
        return [k for k, pair in enumerate(pairs) if outcomes_agree(*pair) is answer]

    @property
    def unexplained(self) -> list[int]:
        """Of those, steps on which Coulomb's verdict neither sides with Bullet nor hangs on how tight the joints are.

        Coulomb friction does not determine the forces. Where not all tightnesses of the joints have a state without
        dilatancy and self-stress, statics do not exclude a fall, and Bullet's joints decide.
        """
        return [k for k in self.differ if not (self._sides(k) or self._hangs(k))]

    def _sides(self, step: int) -> bool:
        verdict = self.coulomb[step]
        decided = verdict not in (None, Outcome.UNDECIDED)
        return decided and (verdict is Outcome.STABLE) == _stands(self.dynamic[step])

    def _hangs(self, step: int) -> bool:
        share = self.tightness[step]
        return share is not None and share < 1.0 and not _stands(self.dynamic[step])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            The verdict on each step, and the numbers of those that differ and of those undecided.
        """
        return {
            "verdicts": [outcome.word for outcome in self.static],
            "differ": self.differ,
            "undecided": self.undecided,
            "coulomb": {str(k): outcome.word for k, outcome in enumerate(self.coulomb) if outcome is not None},
            "tightness": {str(k): share for k, share in enumerate(self.tightness) if share is not None},
            "unexplained": self.unexplained,
        }

    def explain(self) -> str:
        """Return the comparison in words.

        Returns
        -------
        str
            One fact a line.
        """
        steps, undecided = len(self.static), self.undecided
        lines = [f"Statics and Bullet agree on {len(self._where(True))} of {steps} steps."]
        if undecided:
            lines.append(f"On {len(undecided)} of {steps} steps one of them says neither.")
        for k in sorted((*self.differ, *undecided)):
            coulomb = self.coulomb[k]
            word = "" if coulomb is None else f', with flow="coulomb" {coulomb.word}'
            share = self.tightness[k]
            word += "" if share is None else f"; states at {100 * share:.0f} % of random tightnesses of the joints"
            lines.append(f"step {k}: Bullet {self.dynamic[k].word}, statics {self.static[k].word}{word}")
        return "\n".join(lines)


def compare_steps(assembly: Assembly, found: DynamicSequence, *, gap: float | str = GAP) -> StepComparison:
    """Judge the steps of a plan by statics, and by Coulomb's verdict where Bullet differs.

    Parameters
    ----------
    assembly : Assembly
        The blocks, with the friction of the run.
    found : DynamicSequence
        What Bullet made of them.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`.

    Returns
    -------
    StepComparison
        The verdicts side by side.
    """
    whole = Whole(assembly, gap=gap)
    states = [whole.state_of(*state, f"step {k}") for k, state in enumerate(found.plan.states())]
    static = assess_plan(assembly, found.plan, gap=gap).outcomes
    dynamic = [step.outcome for step in found.steps]
    coulomb: list[Outcome | None] = [None] * len(states)
    tightness: list[float | None] = [None] * len(states)
    for k, state in enumerate(states):
        if outcomes_agree(static[k], dynamic[k]):
            continue
        if any(found.plan.standing_props()[k]):
            continue  # Coulomb states of blocks on props are not known
        verdict = whole.assess(*state, flow="coulomb", score=False)
        coulomb[k] = verdict.outcome
        if verdict.outcome in (Outcome.STABLE, Outcome.UNDECIDED):
            again = whole.assess(*state, flow="coulomb", score=False, tightnesses=TIGHTNESSES)
            tightness[k] = None if again.coulomb is None else again.coulomb.tightness
    return StepComparison(static, tuple(coulomb), tuple(dynamic), tuple(tightness))


def _stands(outcome: DynamicOutcome) -> bool:
    return outcome is DynamicOutcome.STANDS
