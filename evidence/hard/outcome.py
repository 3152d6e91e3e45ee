"""What becomes of a hard case: the same for the tests and for the page."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

from blockstat import InputError, assess
from evidence.hard.cases import REFUSED, UNDECIDED, Case


@dataclass(frozen=True)
class Row:
    """One case as it came out."""

    case: Case
    word: str
    solver: str
    residual: float  #: what is left unbalanced on a block, relative to its load
    imbalance: float  #: the same without rounding of the forces on the block
    told: tuple[str, ...]  #: warnings, or the message of a refusal
    seconds: float
    finite: bool  #: no number of the answer is not a number

    @property
    def right(self) -> bool:
        return self.case.within or self.word == self.case.right or (self.case.near and self.word == UNDECIDED)


def outcome(case: Case) -> Row:
    """Assess a case."""
    begin = process_time()
    try:
        verdict = assess(case.make(), **case.options)
    except InputError as error:
        return Row(case, REFUSED, "", np.nan, np.nan, (str(error),), process_time() - begin, True)
    numbers = (verdict.forces, verdict.adhesion, verdict.mechanism, [verdict.certificate.residual])
    return Row(
        case,
        verdict.outcome.word,
        verdict.solver,
        verdict.certificate.residual,
        verdict.certificate.imbalance,
        tuple(verdict.warnings),
        process_time() - begin,
        all(np.isfinite(array).all() for array in numbers) and not np.isnan(verdict.score),
    )
