"""From a solver's answer to an outcome: nothing counts but the certificate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.equilibrium import Equilibrium
from blockstat.polyhedron import Floats
from blockstat.program import PenaltyProgram
from blockstat.result import Outcome
from blockstat.solve import certificate, dual
from blockstat.solve.certificate import Certificate
from blockstat.solve.raw import RawSolution


@dataclass(frozen=True, eq=False)
class Proof:
    """An outcome and the scaled numbers it rests on."""

    outcome: Outcome
    force: Floats  #: shape (m, 3), on equilibrium as far as it goes
    twist: Floats  #: shape (6 n,)
    certificate: Certificate


def decide(eq: Equilibrium, program: PenaltyProgram, raw: RawSolution) -> Proof:
    """What our own checks make of an answer to the penalty program; a second program is asked near the limit."""
    proof = _prove(eq, program, raw)
    if proof.outcome is not Outcome.UNDECIDED:
        return proof
    closer = _prove(eq, program, dual.solve_margin(program), mend=True)
    better = closer.certificate.required_force > proof.certificate.required_force
    return closer if closer.outcome is not Outcome.UNDECIDED or better else proof


def _prove(eq: Equilibrium, program: PenaltyProgram, raw: RawSolution, *, mend: bool = False) -> Proof:
    force = certificate.balance(program, raw.force)
    twist = raw.twist
    proof = certificate.check(eq, program, force, twist)
    if mend and proof.required_force > 0 and not (proof.proves_stable or proof.proves_unstable):
        twist = dual.open_joints(program, twist)
        proof = certificate.check(eq, program, force, twist)
    outcome = Outcome.STABLE if proof.proves_stable else Outcome.UNSTABLE
    if proof.proves_stable == proof.proves_unstable:
        outcome = Outcome.UNDECIDED
    return Proof(outcome, force, np.asarray(twist), proof)
