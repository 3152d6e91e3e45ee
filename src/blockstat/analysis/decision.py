"""From a solver's answer to an outcome: nothing counts but the certificate."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.certificate import check as certificate
from blockstat.certificate.check import Certificate
from blockstat.certificate.interior_motions import opened
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve import dispatch as dual
from blockstat.solve.answer import ACCEPTED, MECHANISM, RawSolution
from blockstat.typing import Floats

#: A block that weighs less than this beside the heaviest is given this as its unit.
LIGHTEST = 1e-9


@dataclass(frozen=True, eq=False)
class Proof:
    """An outcome and the scaled numbers it rests on."""

    outcome: Outcome
    force: Floats  #: shape (m, 3), on equilibrium as far as it goes
    twist: Floats  #: shape (6 n,)
    certificate: Certificate


def decide(program: PenaltyProgram, raw: RawSolution) -> Proof:
    """What our own checks make of an answer to the penalty program; a second program is asked near the limit."""
    proof = _prove(program, raw)
    if proof.outcome is not Outcome.UNDECIDED:
        return proof
    for solve in (dual.solve_margin, _locally):
        closer = _prove(program, solve(program), mend=True)
        better = closer.certificate.required_force > proof.certificate.required_force
        proof = closer if closer.outcome is not Outcome.UNDECIDED or better else proof
        if proof.outcome is not Outcome.UNDECIDED:
            break
    return proof


def _locally(program: PenaltyProgram) -> RawSolution:
    """The least adhesion in units of the lighter block of each joint, where light blocks are lost beside heavy ones."""
    own = np.linalg.norm(program.load.reshape(-1, 6), axis=1)
    own = np.maximum(own, LIGHTEST * own.max(initial=1.0))
    sides = np.where(program.point_blocks >= 0, np.append(own, np.inf)[program.point_blocks], np.inf)
    unit = sides.min(axis=1)
    raw = dual.solve_margin(program.in_units(own, unit))
    twist = (raw.twist.reshape(-1, 6) / own[:, None]).reshape(-1)
    return replace(raw, force=raw.force * unit[:, None], adhesion=raw.adhesion * unit[: program.n_points], twist=twist)


def _prove(program: PenaltyProgram, raw: RawSolution, *, mend: bool = False) -> Proof:
    proven = raw.status in (ACCEPTED, MECHANISM)
    force = raw.force if proven else certificate.balance(program, raw.force)
    twist = raw.twist
    proof = certificate.check(program, force, twist)
    if proof.required_force > 0 and not (proof.proves_stable or proof.proves_unstable):
        wider = opened(program, twist, raw.inside)
        second = certificate.check(program, force, wider)
        if second.required_force > proof.required_force:
            twist, proof = wider, second
    if mend and not (proof.proves_stable or proof.proves_unstable):
        pressed = certificate.settle(program, force)
        second = certificate.check(program, pressed, twist)
        if second.proves_stable:
            force, proof = pressed, second
    if mend and proof.required_force > 0 and not (proof.proves_stable or proof.proves_unstable):
        twist = dual.open_joints(program, twist)
        proof = certificate.check(program, force, twist)
    return _proof(force, twist, proof)


def prove(program: PenaltyProgram, force: Floats, twist: Floats) -> Proof:
    """What forces (m, 3) and a twist (6 n,) prove as they are."""
    return _proof(force, twist, certificate.check(program, force, twist))


def _proof(force: Floats, twist: Floats, checked: Certificate) -> Proof:
    outcome = Outcome.STABLE if checked.proves_stable else Outcome.UNSTABLE
    if checked.proves_stable == checked.proves_unstable:
        outcome = Outcome.UNDECIDED
    return Proof(outcome, force, np.asarray(twist), checked)
