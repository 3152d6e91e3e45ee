"""A Coulomb state is checked from its arrays alone: damage to any of its conditions must show, a thousand times."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import Assembly, Outcome, assess, box, glued, read
from blockstat.analysis.coulomb import coulomb_state
from blockstat.certificate.coulomb_state import RATE_ACCURACY, check_coulomb_state, loaded_points
from evidence.checks.coulomb import check_displacements
from evidence.scenes.bonded import bonded_scene, program_of
from evidence.scenes.small import arch, running_bond, stack

TRIALS = 200  #: of each of five corruptions


def slope(degrees, mu=0.7):
    turn = np.radians(degrees)
    return stack(2).with_(gravity=9.81 * np.array([np.sin(turn), 0.0, -np.cos(turn)]), friction=mu)


@pytest.fixture(scope="module", params=["wall", "arch", "slope"])
def settled(request):
    asm = {"wall": lambda: running_bond(4, 3), "arch": lambda: arch(10, 0.3), "slope": lambda: slope(20)}[
        request.param
    ]()
    program = program_of(asm)
    state = coulomb_state(program)
    assert check_coulomb_state(program, state.force, state.displacement).proves_settled
    return program, state.force, state.displacement


def corrupted(settled, change):
    """Of TRIALS states with a random change, how many the check rejects."""
    program, force, displacement = settled
    random = np.random.default_rng(7)
    rejected = 0
    for _ in range(TRIALS):
        damaged = change(random, program, force.copy(), displacement.copy())
        rejected += not check_coulomb_state(program, *damaged).proves_settled
    return rejected


def pick(random, program, force):
    return random.choice(np.flatnonzero(loaded_points(program, force)))


def test_forces_that_do_not_balance(settled):
    def change(random, program, force, displacement):
        force[pick(random, program, force)] *= 1 + 10.0 ** random.uniform(-6, 0)
        return force, displacement

    assert corrupted(settled, change) == TRIALS


def test_forces_outside_their_cones(settled):
    def change(random, program, force, displacement):
        # Friction that balances still, but not under the cone's own coefficient.
        k = pick(random, program, force)
        force[k, 1:] = force[k, 0] * program.friction[k] * (1 + 10.0 ** random.uniform(-6, 0)) * np.array([0.6, 0.8])
        return force, displacement

    assert corrupted(settled, change) == TRIALS


def test_a_loaded_point_that_opens(settled):
    def change(random, program, force, displacement):
        # The least motion of the blocks that opens one loaded point.
        k = pick(random, program, force)
        row = program.matrix[:, [3 * k]].toarray().reshape(-1)
        opening = row @ displacement
        return force, displacement + row * (10.0 ** random.uniform(-6, 0) - opening) / (row @ row)

    assert corrupted(settled, change) == TRIALS


def test_a_point_without_force_that_closes_most(settled):
    def change(random, program, force, displacement):
        # Forces and motion fit, but one point that closes more than all others is said to carry nothing.
        k = pick(random, program, force)
        row = program.matrix[:, [3 * k]].toarray().reshape(-1)
        force[k] = 0.0
        return force, displacement - row * np.abs(program.matrix.T @ displacement).max() * random.uniform(2, 9) / (
            row @ row
        )

    program, force, displacement = settled
    assert corrupted(settled, change) == TRIALS
    damaged = change(np.random.default_rng(0), program, force.copy(), displacement)
    found = check_coulomb_state(program, *damaged)
    assert found.clearance_violation > RATE_ACCURACY
    known = np.full(len(force), 1e3)  # unless that joint is known to have been open so far
    assert check_coulomb_state(program, *damaged, known).clearance_violation == 0


def test_friction_that_does_not_oppose_slip():
    # The balance would show it first; the friction alone must show it, too.
    program = program_of(slope(20))
    state = coulomb_state(program)
    random, loaded = np.random.default_rng(7), np.flatnonzero(loaded_points(program, state.force))
    for _ in range(TRIALS):
        force, k = state.force.copy(), random.choice(loaded)
        angle = random.choice([-1, 1]) * random.uniform(0.1, np.pi)
        force[k, 1:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]] @ force[k, 1:]
        assert check_coulomb_state(program, force, state.displacement).friction_violation > RATE_ACCURACY


def test_forces_of_more_than_a_million_weights():
    # A slab between walls that are drawn into it with ten million times its weight: they balance by rounding alone.
    ground = [box((-2, 0, -1), (3, 1, 0), name="ground"), box((-1, 0, 0), (0, 1, 1), name="left")]
    blocks = [*ground, box((0, 0, 0), (1, 1, 1), name="slab"), box((1, 0, 0), (2, 1, 1), name="right")]
    program = program_of(Assembly.from_blocks(blocks, supports=["ground", "left", "right"], friction=0.7))
    state = coulomb_state(program)
    assert state.settles
    force, across = state.force.copy(), np.abs(program.matrix.toarray()[0, ::3]) > 0.5
    force[across, 0] += 1e7
    found = check_coulomb_state(program, force, state.displacement)
    assert found.residual <= 1e-9
    assert found.cone_violation <= 1e-9
    assert found.total_force > 1e6
    assert not found.proves_settled


def test_numbers_that_are_none_prove_nothing(settled):
    program, force, displacement = settled
    for k in range(2):
        damaged = [force.copy(), displacement.copy()]
        damaged[k].flat[0] = np.nan
        assert not check_coulomb_state(program, *damaged).proves_settled


def test_scale_of_the_displacements_does_not_matter(settled):
    program, force, displacement = settled
    for size in (1e-9, 1e9):
        assert check_coulomb_state(program, force, size * displacement).proves_settled
    assert not check_coulomb_state(program, force, -displacement).proves_settled
    assert not check_coulomb_state(program, force, 0 * displacement).proves_settled


def test_a_bond_opposes_what_stretches_it():
    hung = glued(stack(2).with_(gravity=(0.0, 0.0, 9.81)), 1e6)
    program = program_of(hung)
    found = coulomb_state(program)
    assert found.settles
    assert not check_coulomb_state(program, found.force, -found.displacement).proves_settled


def test_jammed_blocks_have_no_state_whatever_the_displacements(cases):
    # H hangs between two fixed blocks: what closes one joint opens the other.
    asm = read(cases / "cra_H.json").with_(friction=0.84)
    program = program_of(asm)
    found = coulomb_state(program)
    random = np.random.default_rng(1)
    for _ in range(1000):
        motion = found.displacement + random.normal(size=len(program.load)) * 10.0 ** random.uniform(-6, 3)
        assert not check_coulomb_state(program, found.force, motion).proves_settled


@pytest.mark.parametrize("make", [lambda: slope(20), lambda: running_bond(4, 3), lambda: arch(10, 0.3)])
def test_the_second_opinion_agrees_and_can_say_no(make):
    verdict = assess(make(), flow="coulomb")
    assert verdict.outcome is Outcome.STABLE
    check_displacements(verdict)
    with pytest.raises(AssertionError, match="does not close"):
        check_displacements(replace(verdict, displacement=-verdict.displacement))
    turned = verdict.forces * np.array([1.0, -1.0, -1.0])
    if np.abs(verdict.forces[:, 1:]).max() > 1e-3 * verdict.forces.max():
        with pytest.raises(AssertionError, match="does not oppose"):
            check_displacements(replace(verdict, forces=turned))
    with pytest.raises(AssertionError, match="closes more than any"):
        check_displacements(replace(verdict, forces=np.zeros_like(verdict.forces)))


def test_a_slip_that_friction_does_not_oppose_counts_beyond_the_accuracy_of_the_rates():
    # Slip across a slope, relative to the largest rate: solvers return rates to 1e-8 at worst, and 3e-5 is no rounding.
    program = program_of(slope(20))
    state = coulomb_state(program)
    rate = np.abs(program.matrix.T @ state.displacement).max()
    for size, settles in ((1e-7, True), (3e-5, False)):
        aside = state.displacement.copy()
        aside[1::6] += size * rate
        found = check_coulomb_state(program, state.force, aside)
        assert found.friction_violation > 0
        assert found.proves_settled == settles


@pytest.mark.parametrize("seed", [0, 6, 15, 41])
def test_what_glue_holds_with_a_reserve_has_a_coulomb_state(seed):
    # A bond under bending shears as much as it pulls, and both of its forces carry.
    name, asm, strength = bonded_scene(seed)
    assert asm.joints[0].bond_moment is not None
    assert strength > 1.3
    verdict = assess(asm, flow="coulomb")
    assert verdict.outcome.word == "stable", name
    assert verdict.coulomb.certificate.proves_settled
