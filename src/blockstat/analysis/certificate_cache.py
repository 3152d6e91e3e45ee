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
from dataclasses import dataclass, field

import numpy as np

from blockstat.analysis.decision import Proof, prove
from blockstat.analysis.problem import Problem
from blockstat.analysis.verdict import Outcome
from blockstat.certificate import check as certificate
from blockstat.certificate.interior_motions import opened
from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats

#: Force fields and mechanisms kept for one set of joints, and sets of joints kept.
FIELDS, MECHANISMS, KINDS = 2, 3, 16


@dataclass
class _Evidence:
    """What is known about assemblies with one set of joints; scaled values of their programs."""

    forces: list[Floats] = field(default_factory=list)
    twists: list[Floats] = field(default_factory=list)


class Memory:
    """Hand one to several calls of `assess` on designs of one kind.

    statistics : how many verdicts rested on an earlier force field ("forces"), on an earlier mechanism ("mechanism"),
    and how many had to be solved for ("solved").
    """

    def __init__(self) -> None:
        self.statistics = {"forces": 0, "mechanism": 0, "solved": 0}
        self._known: OrderedDict[bytes, _Evidence] = OrderedDict()

    def recall(self, problem: Problem) -> tuple[Proof, str] | None:
        """A proof from earlier evidence and its kind, None if there is none."""
        program = problem.program
        known = self._known.get(_kind(program)) if program is not None else None
        if program is None or known is None:
            return None
        nothing = np.zeros_like(program.load)
        for twist in known.twists:
            proof = prove(program, np.zeros((len(program.friction), 3)), opened(program, twist))
            if proof.outcome is Outcome.UNSTABLE:
                return self._counted(proof, "mechanism")
        for force in known.forces:
            proof = prove(program, certificate.settle(program, force), nothing)
            if proof.outcome is Outcome.STABLE:
                return self._counted(proof, "forces")
        return None

    def keep(self, problem: Problem, proof: Proof) -> None:
        """Remember a proof that was solved for."""
        self.statistics["solved"] += 1
        program = problem.program
        if program is None or proof.outcome is Outcome.UNDECIDED:
            return
        kind = _kind(program)
        known = self._known.setdefault(kind, _Evidence())
        self._known.move_to_end(kind)
        while len(self._known) > KINDS:
            self._known.popitem(last=False)
        if proof.outcome is Outcome.STABLE:
            known.forces = [proof.force, *known.forces][:FIELDS]
            return
        known.twists = [proof.twist, *known.twists][:MECHANISMS]

    def _counted(self, proof: Proof, kind: str) -> tuple[Proof, str]:
        self.statistics[kind] += 1
        return proof, kind


def _kind(program: PenaltyProgram) -> bytes:
    """The blocks that each contact point and bond joins: what evidence of another design must share."""
    digest = hashlib.sha256(np.ascontiguousarray(program.point_blocks).tobytes())
    digest.update(f"{len(program.load)} {program.n_points}".encode())
    return digest.digest()
