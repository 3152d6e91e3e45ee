"""One conic program, three solvers: interior point, Clarabel and cvxpy read the same arrays and agree."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import JointLaw, acceleration, limit_load
from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import GAP
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve import clarabel, cvxpy, interior_point
from blockstat.solve.answer import Status
from evidence.scenes.small import arch, assembly, box, running_bond, stack

EVERY = ("*", "*")
SOLVERS = (interior_point, clarabel, cvxpy)
#: In space, in the plane, with bounds on the forces of points and bonds, without friction, with infinite friction.
SCENES = {
    "wall in space": lambda: running_bond(4, 3).with_(gravity=(0.3, 0.6, -1)),
    "thin arch in its plane": lambda: arch(12, 0.08),
    "crushed arch": lambda: arch(8, 0.2).with_(joints=[JointLaw(EVERY, compression=3.0, cells=2)]),
    "bonded arch": lambda: arch(12, 0.08).with_(joints=[JointLaw(EVERY, bond=1e-4, bond_moment=1e-5)]),
    "overhang without friction": lambda: assembly(
        [box((0, 0, 0), (1, 1, 1)), box((0.6, 0.1, 1), (1.6, 1.1, 2))], friction=0.0
    ),
    "stack with infinite friction": lambda: stack(3, friction=np.inf).with_(gravity=(0.6, 0.1, -1)),
}


def posed(make):
    return pose(make(), friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)


@pytest.mark.parametrize("scene", SCENES)
def test_the_penalty_program(scene):
    program = posed(SCENES[scene]).program
    conic = conic_program(program, -program.load, penalty=True)
    answers = [solver.solve(conic) for solver in SOLVERS if conic.has_structure or solver is not interior_point]
    best = answers[0]
    gaps = program.normal_columns.T @ best.twist + best.yielding[: program.n_points]
    assert np.linalg.norm(gaps) > 1e-3
    for answer in answers:
        assert answer.status in (Status.SOLVED, Status.ALMOST_SOLVED)
        own = program.normal_columns.T @ answer.twist + answer.yielding[: program.n_points]
        assert np.linalg.norm(own) == pytest.approx(np.linalg.norm(gaps), rel=1e-6)
        # The multipliers with the adhesion taken off balance the load.
        rest = program.matrix @ answer.force.reshape(-1) - program.normal_columns @ np.maximum(own, 0) + program.load
        assert np.abs(rest).max() < 1e-5 * program.total_load


@pytest.mark.parametrize("across", [0.0, 0.2])
@pytest.mark.parametrize("strength", [None, 40.0])
def test_a_pinned_load(across, strength):
    laws = [] if strength is None else [JointLaw(EVERY, compression=strength, cells=2)]
    asm = running_bond(3, 3).with_(joints=laws)
    problem = posed(lambda: asm)
    load = problem.scaled(acceleration(asm, (1, across, 0)))
    conic = conic_program(problem.program, -problem.program.load, pinned=load)
    assert (conic.plane is not None) == (across == 0.0 and strength is None)
    answers = [solver.solve(conic) for solver in SOLVERS]
    for answer in answers:
        assert answer.multiplier == pytest.approx(answers[0].multiplier, rel=1e-6)
        assert float(load @ answer.twist) == pytest.approx(1.0, rel=1e-6)


def test_the_least_mending_of_a_twist():
    program = replace(posed(lambda: running_bond(4, 3)).program, plane=None)
    offset = np.random.default_rng(0).normal(size=3 * len(program.friction))
    conic = conic_program(program, np.zeros(len(program.load)), least_norm=True, offset=offset)
    answers = [solver.solve(conic) for solver in SOLVERS]
    for answer in answers:
        np.testing.assert_allclose(answer.twist, answers[0].twist, atol=1e-6 * np.abs(answers[0].twist).max())


def test_forces_with_a_compliance():
    # The interior-point method counts shear otherwise, so it is compared at friction one, where both measures agree.
    program: PenaltyProgram = replace(posed(lambda: running_bond(3, 3).with_(friction=1.0)).program, plane=None)
    offset = np.zeros((len(program.friction), 3))
    offset[:, 0] = np.random.default_rng(0).uniform(0.5, 1.0, len(offset))
    conic = conic_program(program, -program.load, offset=offset.reshape(-1), compliance=0.1)
    answers = [solver.solve(conic) for solver in SOLVERS]
    for answer in answers:
        np.testing.assert_allclose(answer.force, answers[0].force, atol=1e-5 * np.abs(answers[0].force).max())
        np.testing.assert_allclose(answer.rates, answers[0].rates, atol=1e-5)
        # De Saxce: the rates are in the dual cone, and do no work on the forces.
        assert (answer.rates[:, 0] - np.hypot(*answer.rates[:, 1:].T)).min() > -1e-6
        assert abs((answer.rates * answer.force).sum(axis=1)).max() < 1e-6


def test_programs_without_an_answer_say_so():
    problem = posed(lambda: running_bond(3, 3))
    down = problem.scaled(acceleration(problem.assembly, (0, 0, -1)))
    unbounded = conic_program(problem.program, -problem.program.load, pinned=down)
    no_balance = conic_program(replace(problem.program, load=-problem.program.load), problem.program.load)
    for solver in SOLVERS:
        assert solver.solve(unbounded).status is Status.PRIMAL_INFEASIBLE
        assert solver.solve(no_balance).status is Status.DUAL_INFEASIBLE


def test_a_limit_load_through_cvxpy():
    asm = arch(12, 0.2)
    assert limit_load(asm, (1, 0, 0), solver="cvxpy").lower == pytest.approx(limit_load(asm, (1, 0, 0)).lower, rel=1e-7)
