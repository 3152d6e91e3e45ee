"""The fast path against the literal program in cvxpy: the same score and the same verdict."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import JointLaw, Outcome, assess
from blockstat.contact.interfaces import find_interfaces
from blockstat.program.conic import conic_program
from blockstat.program.equilibrium import equilibrium, split_floating, weight
from blockstat.program.penalty import penalty_program
from blockstat.solve import clarabel, cvxpy
from blockstat.solve.answer import Status
from blockstat.solve.cvxpy import solve_on_paper
from blockstat.solve.penalty import solve_penalty
from evidence.scenes.small import SCENES, arch, running_bond, stack

EVERY = ("*", "*")
#: Joint laws of every kind on both sides of the limit: (name, maker, law, options of `assess`).
LAWS = [
    (
        "cohesive wall",
        lambda: running_bond(4, 3),
        JointLaw(EVERY, cohesion=0.2, tension=0.05),
        {"gravity": (0.9, 0, -1)},
    ),
    ("weakly cohesive wall", lambda: running_bond(4, 3), JointLaw(EVERY, cohesion=0.01), {"gravity": (1.2, 0, -1)}),
    ("thin bonded arch", lambda: arch(12, 0.08), JointLaw(EVERY, bond=0.003, bond_moment=0.001), {}),
    ("thin weakly bonded arch", lambda: arch(12, 0.08), JointLaw(EVERY, bond=1e-4, bond_moment=1e-5), {}),
    ("soft arch", lambda: arch(8, 0.2), JointLaw(EVERY, compression=40.0, cells=3), {}),
    ("crushed arch", lambda: arch(8, 0.2), JointLaw(EVERY, compression=3.0, cells=3), {}),
    ("glued stack", lambda: stack(3), JointLaw(EVERY, tension=0.2, cohesion=0.1), {"gravity": (0.4, 0.1, -1)}),
]


@pytest.mark.parametrize("scene", LAWS, ids=lambda s: s[0])
def test_same_verdict_and_score_with_joint_laws(scene):
    _, make, law, options = scene
    asm = make().with_(joints=[law])
    direct, literal = assess(asm, **options), assess(asm, solver="cvxpy", **options)
    assert direct.outcome is literal.outcome is not Outcome.UNDECIDED
    assert direct.score == pytest.approx(literal.score, abs=1e-6)
    # A law that only adds strength never makes it worse.
    if law.compression is None and assess(make(), **options).outcome is Outcome.STABLE:
        assert direct.outcome is Outcome.STABLE


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: s[0])
def test_same_verdict_and_score(scene):
    _, make, options = scene
    direct, literal = assess(make(), **options), assess(make(), solver="cvxpy", **options)
    assert direct.outcome is literal.outcome
    assert direct.score == pytest.approx(literal.score, abs=1e-6)


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: s[0])
def test_same_energy_before_any_certificate(scene):
    _, make, options = scene
    asm = make().with_(**options)
    faces = find_interfaces(asm)
    held, _ = split_floating(asm, faces.pair)
    program = penalty_program(
        equilibrium(asm, faces, weight(asm), held, np.arange(faces.n_points)),
        np.full(faces.n_points, asm.friction),
    )
    direct, literal = solve_penalty(program), solve_on_paper(program)
    total = np.abs(program.load).sum()
    assert np.linalg.norm(direct.adhesion) / total == pytest.approx(np.linalg.norm(literal.adhesion) / total, abs=1e-6)


def program_of(asm):
    faces = find_interfaces(asm)
    held, _ = split_floating(asm, faces.pair)
    eq = equilibrium(asm, faces, weight(asm), held, np.arange(faces.n_points))
    return penalty_program(eq, np.full(faces.n_points, asm.friction))


def test_where_points_cannot_carry_the_weight_no_adhesion_is_enough():
    program = program_of(stack(1))
    weight_of_all = float(np.abs(program.load).sum())
    for share, bounded in ((0.3, True), (0.2, False)):  # of four points under one block
        answer = solve_on_paper(replace(program, upper=np.full(program.n_points, share * weight_of_all)))
        assert answer.bounded is bounded
        assert np.isfinite(answer.adhesion).all() == bounded
        assert answer.status.is_infeasible != bounded
    assert not answer.force.any()
    assert not answer.twist.any()


def test_where_a_block_slides_no_forces_are_found_and_the_rates_have_no_bound():
    program = program_of(stack(1, 2.0, 0.5).with_(gravity=(0.9, 0.2, -1), friction=0.5))
    conic = conic_program(program, -program.load, compliance=1.0)
    literal, direct = cvxpy.solve(conic), clarabel.solve(conic)
    assert literal.status is direct.status is Status.DUAL_INFEASIBLE
    assert not literal.force.any()
    assert not literal.twist.any()
    stands = program_of(stack(1))
    conic = conic_program(stands, -stands.load, compliance=1.0)
    np.testing.assert_allclose(cvxpy.solve(conic).force, clarabel.solve(conic).force, atol=1e-6)
