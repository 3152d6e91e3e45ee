"""Forces and mechanisms of earlier draws, tried on the next one in the order of their distance from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from blockstat.analysis.certificate_cache import Memory, joined_blocks
from blockstat.analysis.decision import outcome_of
from blockstat.analysis.problem import Problem
from blockstat.analysis.verdict import Outcome
from blockstat.solve.answer import Answer
from blockstat.typing import Floats

#: Pieces of evidence kept, and of each kind how many are tried: those of the kind of the nearest one, and the others.
KEPT, LIKELY, UNLIKELY = 200, 2, 1


@dataclass(frozen=True, eq=False)
class Known:
    """Forces or a mechanism of one draw."""

    place: Floats  #: its standard normal variables
    kind: bytes  #: which blocks its contact points join
    outcome: Outcome
    vector: Floats  #: forces, shape (m, 3), or twist, shape (6 n,), in the units of the program


class NearbyEvidence(Memory):
    """Evidence of earlier draws, found by the distance of their standard normal variables."""

    def __init__(self, known: Sequence[Known] = ()) -> None:
        super().__init__()
        self.place: Floats = np.empty(0)  #: of the draw that is judged next
        self.known = list(known)
        self.gained: list[Known] = []  #: what was solved for since

    def recall(self, problem: Problem) -> Answer | None:
        """Return earlier evidence that proves the outcome of the draw.

        Parameters
        ----------
        problem
            The posed problem of the draw at `place`.

        Returns
        -------
        Answer or None
            Forces or a mechanism with their certificate on this draw; None if nothing known proves anything.
        """
        program = problem.program
        if program is None:
            return None
        kind = joined_blocks(program)
        own = [known for known in self.known if known.kind == kind]
        if not own:
            return None
        away = np.linalg.norm(np.array([known.place for known in own]) - self.place, axis=1)
        order = [own[i] for i in np.argsort(away, kind="stable")]
        likely = order[0].outcome
        nearest = [known for known in order if known.outcome is likely][:LIKELY]
        nearest += [known for known in order if known.outcome is not likely][:UNLIKELY]
        for known in nearest:
            if (found := self.tried(problem, program, known.outcome, known.vector)) is not None:
                self._add(kind, found, known.outcome)
                return found
        return None

    def keep(self, problem: Problem, answer: Answer) -> None:
        """Remember the evidence of an answer that was solved for.

        Parameters
        ----------
        problem
            The posed problem.
        answer
            Its checked answer.
        """
        self.statistics["solved"] += 1
        outcome = outcome_of(answer.certificate)
        if problem.program is not None and outcome is not Outcome.UNDECIDED:
            self.gained.append(self._add(joined_blocks(problem.program), answer, outcome))

    def _add(self, kind: bytes, answer: Answer, outcome: Outcome) -> Known:
        vector = answer.force if outcome is Outcome.STABLE else answer.twist
        known = Known(self.place, kind, outcome, vector)
        self.known = [*self.known, known][-KEPT:]
        return known
