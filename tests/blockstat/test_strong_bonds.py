"""Strong glue and strong bonds hold what weak ones hold, and what they take up counts in full."""

import numpy as np
import pytest

from blockstat import Assembly, LoadOutcome, Outcome, assess, box, glued, limit_load
from blockstat.analysis.decision import decide, outcome_of
from blockstat.analysis.problem import pose
from blockstat.certificate.check import FORCE_LIMIT, check
from blockstat.contact.interfaces import GAP
from blockstat.proof.exact_check import power
from blockstat.proof.rational import exact
from blockstat.proof.structure import structure
from blockstat.solve.penalty import solve_penalty

GROUND = box((0, 0, -0.02), (0.2, 0.1, 0), name="ground")
DOWN = np.array([0, 0, -1.0, 0, 0, 0])


def posed(asm):
    return pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)


def cube(strength):
    blocks = [GROUND, box((0, 0, 0), (0.1, 0.1, 0.1), name="cube")]
    return glued(Assembly.from_blocks(blocks, supports=["ground"]), strength)


def tower(strength, moment=None):
    steps = [box((0.05 * i, 0.003 * i, 0.06 * i), (0.2 + 0.05 * i, 0.1 + 0.003 * i, 0.06 * (i + 1))) for i in range(6)]
    return glued(Assembly.from_blocks([GROUND, *steps], supports=["ground"]), strength, moment=moment)


@pytest.mark.parametrize("strength", [0.0, 1e5, 1e8])
def test_a_cube_on_the_ground_is_not_driven_into_it_by_the_strength_of_its_glue(strength):
    # At 1 m/s into the ground the weight W works W, and contact forces of W in all take that up.
    found = check(posed(cube(strength)).program, np.zeros((4, 3)), DOWN)
    assert found.required_force == pytest.approx(1.0, rel=1e-6)
    assert not found.proves_unstable


@pytest.mark.parametrize("strength", [0.0, 1e5])
def test_a_proof_of_a_motion_counts_what_glue_takes_up_where_a_joint_closes(strength):
    asm = cube(strength)
    found = power(structure(posed(asm), None, None), exact(np.vstack([0 * DOWN, DOWN])))
    assert float(found.dead) == pytest.approx(asm.free_weight)
    assert found.closing == 1
    assert found.drives(0)
    assert not found.drives(2)


@pytest.mark.parametrize("solver", ["auto", "clarabel", "interior-point"])
@pytest.mark.parametrize("strength", [1e8, 1e10])
def test_a_leaning_tower_with_strong_glue_is_not_proven_to_fall(strength, solver):
    # Of the program: forces less the strength of the glue, in newtons, have fewer digits.
    program = posed(tower(strength)).program
    found = decide(program, solve_penalty(program, solver=solver), solver=solver)
    assert outcome_of(found.certificate) is Outcome.STABLE


@pytest.mark.parametrize("strength", [1e6, 1e8, 1e10])
def test_what_weak_bonds_hold_strong_ones_hold(strength):
    verdict = assess(tower(strength, strength / 10))
    assert verdict.outcome is Outcome.STABLE
    assert verdict.certificate.total_force <= FORCE_LIMIT


def test_a_tower_with_strong_bonds_stands_before_it_is_loaded():
    # A tenth of the strength carries 58.3 times its weight per 1e4 N.
    found = limit_load(tower(1e8, 1e7), (1, 0, 0))
    assert found.outcome is not LoadOutcome.UNDECIDED
    assert found.lower > 0.99 * limit_load(tower(1e6, 1e5), (1, 0, 0)).lower
