"""The structured interior-point method against Clarabel and the literal program: verdicts, scores, limit loads."""

import numpy as np
import pytest
from test_cvxpy import LAWS

from blockstat import Outcome, assess, limit_load
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.analysis.problem import pose
from blockstat.certificate.interior_motions import least_slack
from blockstat.contact.interfaces import GAP
from blockstat.loads import acceleration
from blockstat.program.conic import conic_program
from blockstat.solve.kkt import KktSolver
from blockstat.solve.phase_one import MOST_OPENING, find_motion
from evidence.scenes.small import FERRIS, SCENES, arch, assembly, box, ferris_wall, running_bond, stack


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: s[0])
def test_same_verdict_and_score(scene):
    _, make, options = scene
    ours, theirs = (assess(make(), solver=solver, **options) for solver in ("interior-point", "clarabel"))
    assert ours.outcome is theirs.outcome
    assert ours.score == pytest.approx(theirs.score, abs=1e-7)
    assert ours.solver == "interior-point"


@pytest.mark.parametrize("scene", LAWS, ids=lambda s: s[0])
def test_same_verdict_and_score_with_joint_laws(scene):
    _, make, law, options = scene
    asm = make().with_(joints=[law])
    ours, theirs = (assess(asm, solver=solver, **options) for solver in ("interior-point", "clarabel"))
    assert ours.outcome is theirs.outcome
    assert ours.score == pytest.approx(theirs.score, abs=1e-7)
    assert ours.solver == "interior-point"


@pytest.mark.parametrize("name", FERRIS)
def test_limit_loads(name):
    asm = ferris_wall(FERRIS[name][0])
    ours, theirs = (
        limit_load(asm, (1, 0, 0), solver=solver, optimum=True) for solver in ("interior-point", "clarabel")
    )
    assert ours.lower == pytest.approx(theirs.lower, rel=1e-8)
    assert ours.gap < 1e-6


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (1, 0.3, 0.2), (-1, 1, 0)])
def test_limit_loads_in_space(direction):
    for asm in (running_bond(5, 4), arch(12, 0.2), stack(4)):
        ours, theirs = (
            limit_load(asm, direction, solver=solver, optimum=True) for solver in ("interior-point", "clarabel")
        )
        assert ours.lower == pytest.approx(theirs.lower, rel=1e-7)
        assert ours.gap < 1e-6


def test_programs_without_an_answer_end_with_one():
    asm = running_bond(5, 4)
    assert limit_load(asm, (0, 0, -1), solver="interior-point").outcome is LoadOutcome.UNBOUNDED
    falling = limit_load(asm, (1, 0, 0), gravity=(1.2, 0, -1), solver="interior-point")
    assert falling.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE
    upside_down = assess(stack(2), gravity=(0, 0, 1), solver="interior-point")
    assert upside_down.outcome is Outcome.UNSTABLE


def test_without_friction_and_with_little():
    for mu in (0.0, 1e-3, 1e3, np.inf):
        asm = stack(2).with_(friction=mu)
        ours, theirs = (assess(asm, gravity=(0.1, 0, -1), solver=solver) for solver in ("interior-point", "clarabel"))
        assert ours.outcome is theirs.outcome
        assert ours.score == pytest.approx(theirs.score, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("tilt", [0.0, 0.2, 0.5])
def test_coulomb_states(tilt):
    # Programs by either solver: the same end. A checked state ends them early, so the forces may be others.
    for make in (lambda: running_bond(4, 3), lambda: arch(10, 0.25), lambda: stack(2, 1.0, 0.5)):
        ours, theirs = (
            assess(make(), gravity=(tilt, 0.05, -1), flow="coulomb", solver=solver)
            for solver in ("interior-point", "clarabel")
        )
        assert ours.outcome is theirs.outcome
        if ours.coulomb is not None and theirs.coulomb is not None:
            assert ours.coulomb.settles is theirs.coulomb.settles
            assert ours.coulomb.certificate.proves_settled is theirs.coulomb.certificate.proves_settled


def test_the_bracket_of_a_wall_of_four_hundred_is_narrow():
    # The method's own digits: proximal terms blind to the size of the forces leave a bracket of 2e-5.
    assert limit_load(running_bond(20, 20), (1, 0, 0), solver="interior-point", optimum=True).gap < 2e-6


@pytest.mark.parametrize(("courses", "bricks"), [(10, 3), (40, 70)])
def test_a_motion_that_opens_every_joint_is_found_however_large_a_wall_is(courses, bricks):
    """Blocks that move apart by their distance from the foot open every joint, so that there is such a motion."""
    problem = pose(running_bond(courses, bricks), friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)
    program = problem.program
    conic = conic_program(program, -program.load, pinned=problem.scaled(acceleration(problem.assembly, (0, 1, 0))))
    motion, _ = find_motion(conic, KktSolver(conic))
    assert motion is not None
    assert least_slack(program, conic.twist(motion)) > 0


def test_the_search_for_an_opening_motion_ends_where_there_is_none():
    """A tenon in its mortise leaves four faces along which it only slides."""
    walls = [box((-2, -2, 0), (-1, 2, 1)), box((1, -2, 0), (2, 2, 1)), box((-1, -2, 0), (1, -1, 1)),
             box((-1, 1, 0), (1, 2, 1))]  # fmt: skip
    asm = assembly([box((-3, -3, -1), (3, 3, 0)), *walls, box((-1, -1, 0), (1, 1, 2))], supports=range(5))
    problem = pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)
    program = problem.program
    conic = conic_program(program, -program.load, pinned=problem.scaled(acceleration(asm, (0, 0, 1))))
    motion, factorisations = find_motion(conic, KktSolver(conic))
    assert motion is None
    assert factorisations <= MOST_OPENING
