"""Evidence of earlier verdicts, tried on the next design before anything is solved.

Neighbouring designs of a search have the same blocks and joints in slightly other places. The forces of the last one
that stood, corrected onto the new equilibrium, often prove that the new one stands; the mechanism of the last one that
fell, with a little of a motion that opens every joint (see `blockstat.certificate.interior_motions`), often proves
that it falls.
Nothing is assumed: the certificate is computed on the new geometry like any other. What remains undecided is solved.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from blockstat.analysis.decision import outcome_of
from blockstat.analysis.problem import Problem
from blockstat.analysis.verdict import Outcome
from blockstat.certificate import check as certificate
from blockstat.certificate.interior_motions import with_interior_motion
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer, Status
from blockstat.typing import Floats

#: Force fields and mechanisms kept for one set of joints, and sets of joints kept.
FIELDS, MECHANISMS, KINDS = 2, 3, 16


@dataclass
class _Evidence:
    """What is known about assemblies with one set of joints; scaled values of their programs."""

    forces: list[Floats] = field(default_factory=list)
    twists: list[Floats] = field(default_factory=list)


class Memory:
    """Evidence of earlier verdicts; hand one to several calls of `assess` on designs of one kind.

    Attributes
    ----------
    statistics : dict of str to int
        How many verdicts rested on an earlier force field ("forces"), on an earlier mechanism ("mechanism"), and how
        many had to be solved for ("solved").

    Examples
    --------
    >>> from blockstat import Assembly, Memory, assess
    >>> from blockstat.model.solids import box
    >>> memory = Memory()
    >>> ground = box((-1, -1, -1), (2, 2, 0), name="ground", group="ground")
    >>> for width in (1.0, 1.01, 1.02):
    ...     blocks = [ground, box((0, 0, 0), (width, 1, 1), name="block", group="block")]
    ...     verdict = assess(Assembly.from_blocks(blocks, supports=[0]), memory=memory)
    >>> memory.statistics
    {'forces': 2, 'mechanism': 0, 'solved': 1}
    """

    def __init__(self) -> None:
        self.statistics = {"forces": 0, "mechanism": 0, "solved": 0}
        self._known: OrderedDict[bytes, _Evidence] = OrderedDict()

    def state(self) -> Any:
        """Return what is known now, to `go_back` to.

        Returns
        -------
        object
            What is kept from now on leaves it as it is.
        """
        known = OrderedDict((kind, replace(own)) for kind, own in self._known.items())
        return dict(self.statistics), known

    def go_back(self, state: Any) -> None:
        """Forget all verdicts since a state.

        Parameters
        ----------
        state : object
            As `state` gave it.
        """
        statistics, self._known = state
        self.statistics.update(statistics)

    def recall(self, problem: Problem) -> Answer | None:
        """Return earlier evidence that proves the outcome of a new problem.

        Parameters
        ----------
        problem
            The posed problem.

        Returns
        -------
        Answer or None
            Forces or a mechanism with their certificate on the new problem; None if nothing known proves anything.
        """
        program = problem.program
        known = self._known.get(joined_blocks(program)) if program is not None else None
        if program is None or known is None:
            return None
        tried = [(Outcome.UNSTABLE, twist) for twist in known.twists]
        tried += [(Outcome.STABLE, force) for force in known.forces]
        return next(filter(None, (self.tried(problem, program, *one) for one in tried)), None)

    def tried(self, problem: Problem, program: PenaltyProgram, outcome: Outcome, vector: Floats) -> Answer | None:
        """Return what forces or a mechanism of an earlier problem prove of a new one, and count it.

        Parameters
        ----------
        problem
            The posed problem.
        program
            Its penalty program.
        outcome
            What they proved of the earlier one: stable for forces, unstable for a mechanism.
        vector
            Forces, shape (m, 3), or twist, shape (6 n,), in the units of the program.

        Returns
        -------
        Answer or None
            With the certificate on the new problem; None where they do not prove the same.
        """
        if outcome is Outcome.STABLE:
            kind, force, twist = "forces", certificate.settle(program, vector), np.zeros_like(program.load)
        else:
            kind, force = "mechanism", np.zeros((len(program.friction), 3))
            twist = with_interior_motion(program, vector, problem.motions())
        found = evidence(program, force, twist, kind)
        if outcome_of(found.certificate) is not outcome:
            return None
        self.statistics[kind] += 1
        return found

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
        program, outcome = problem.program, outcome_of(answer.certificate)
        if program is None or outcome is Outcome.UNDECIDED:
            return
        kind = joined_blocks(program)
        known = self._known.setdefault(kind, _Evidence())
        self._known.move_to_end(kind)
        while len(self._known) > KINDS:
            self._known.popitem(last=False)
        if outcome is Outcome.STABLE:
            known.forces = [answer.force, *known.forces][:FIELDS]
            return
        known.twists = [answer.twist, *known.twists][:MECHANISMS]


def evidence(program: PenaltyProgram, force: Floats, twist: Floats, kind: str) -> Answer:
    """Return forces and a mechanism of an earlier design with the certificate that they have on this one.

    Parameters
    ----------
    program
        The penalty program of this design.
    force
        Shape (m, 3), in its units.
    twist
        Shape (6 n,).
    kind
        What they are, in a word.

    Returns
    -------
    Answer
        Its solver says that it is earlier evidence.
    """
    checked = certificate.check(program, force, twist)
    unknown = np.full(program.n_points, np.nan)
    return Answer(force, twist, Status.RECALLED, 0, f"earlier {kind}", adhesion=unknown, certificate=checked)


def joined_blocks(program: PenaltyProgram) -> bytes:
    """Return a digest of the blocks that each contact point and bond joins: what evidence of another design must share.

    Parameters
    ----------
    program
        The penalty program.

    Returns
    -------
    bytes
        The same for programs whose forces and mechanisms have the same places.
    """
    digest = hashlib.sha256(np.ascontiguousarray(program.point_blocks).tobytes())
    digest.update(f"{len(program.load)} {program.n_points}".encode())
    return digest.digest()
