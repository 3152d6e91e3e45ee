"""A certificate is computed from the forces and twists themselves, so damage to them must show."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import JointLaw, Outcome, assess, find_interfaces
from blockstat.analysis.problem import pose
from blockstat.certificate.check import balance, check, cone_slack, opening_slack
from blockstat.certificate.interior_motions import expansions, with_interior_motion
from blockstat.contact.interfaces import GAP
from blockstat.program.conic import conic_program
from blockstat.program.equilibrium import equilibrium, weight
from blockstat.program.penalty import penalty_program
from blockstat.solve import interior_point
from blockstat.solve.answer import EarlyEnd, Status
from blockstat.solve.penalty import open_joints, solve_penalty
from blockstat.solve.phase_one import load_path_guess
from evidence.scenes.small import arch, running_bond, stack

WALL_PULLS = [(0, 0, -1), (0.1, 0, -1), (0, 0.02, -1)]


def without_optimum(program, *, brief=False):
    def proves(force):
        return check(program, force, np.zeros_like(program.load)).proves_stable

    normal = load_path_guess(program)
    guess = np.column_stack([normal, 0 * normal, 0 * normal])
    conic = conic_program(program, -program.load, penalty=True)
    return interior_point.solve(conic, EarlyEnd(proves, guess=guess, brief=brief, optimise=False))


def solved(asm):
    faces = find_interfaces(asm)
    eq = equilibrium(asm, faces, weight(asm), asm.free, np.arange(faces.n_points))
    program = penalty_program(eq, np.full(faces.n_points, asm.friction))
    raw = solve_penalty(program)
    return eq, program, raw, balance(program, raw.force)


def program_of(asm):
    return replace(pose(asm, friction=None, gravity=None, loads=None, gap=GAP, interfaces=None).program, plane=None)


@pytest.mark.parametrize("asm", [*(running_bond(6, 5).with_(gravity=g) for g in WALL_PULLS), arch(20, 0.15)])
def test_forces_are_found_without_an_optimum(asm):
    answer = without_optimum(program_of(asm))
    assert answer.status is Status.ACCEPTED
    assert answer.iterations <= 4


@pytest.mark.parametrize("asm", [arch(20, 0.05), running_bond(6, 5).with_(gravity=(0, 1, -1)), stack(3, friction=0.0)])
def test_no_forces_are_found_for_what_falls(asm):
    program = program_of(asm.with_(gravity=(0.2, 0.2, -1)) if asm.n_blocks == 4 else asm)
    assert without_optimum(program).status is Status.NO_FORCES


@pytest.mark.parametrize("thickness", [0.111, 0.115])
def test_next_to_its_limit_an_arch_needs_the_second_attempt(thickness):
    # Least thickness .1074: the forces that blocks hand down lead nowhere, the least ones lifted into their cones do.
    # (In fewer voussoirs the first may, and nearer to the limit neither: the last digits of a machine decide.)
    program = program_of(arch(60, thickness))
    assert without_optimum(program, brief=True).status is Status.NO_FORCES
    answer = without_optimum(program)
    assert answer.status is Status.ACCEPTED
    assert check(program, answer.force, np.zeros_like(program.load)).residual <= 1e-11


def test_blocks_hand_down_what_they_carry():
    # Three blocks on each other carry one, two and three weights; on the ground of a wall rests all of it.
    tower = program_of(stack(3))
    force, pair = load_path_guess(tower), tower.point_blocks
    np.testing.assert_allclose([force[pair[:, 1] == k].sum() for k in range(3)], [3, 2, 1])
    wall = program_of(running_bond(6, 5))
    ground = (wall.point_blocks < 0).any(axis=1)
    assert load_path_guess(wall)[ground].sum() == pytest.approx(wall.total_load, rel=1e-2)


def test_voussoirs_hand_down_what_they_carry_along_the_arch():
    # A joint carries the weight above it over the cosine of its normal with it; the springings carry all.
    program = program_of(arch(20, 0.15))
    force = load_path_guess(program)
    springing = (program.point_blocks < 0).any(axis=1)
    head = program.local[::3]
    vertical = np.abs(np.where(program.point_blocks[:, 1:] >= 0, head[:, 6:9], head[:, :3])[:, 2])
    assert (force * vertical)[springing].sum() == pytest.approx(program.total_load, rel=1e-2)


def test_no_load_rests_nowhere():
    program = program_of(stack(2))
    assert (load_path_guess(replace(program, load=0 * program.load)) == 0).all()


def test_iterates_that_open_every_joint_prove_a_mechanism_next_to_the_limit():
    # A thousandth of a percent thinner than the least. What the solver ends with closes a little; opened by an iterate
    # it closes nowhere, and needs no bound on the forces.
    program = program_of(arch(30, 0.10740 * (1 - 1e-5)))
    raw = solve_penalty(program, solver="interior-point")
    assert raw.interior is not None
    assert opening_slack((program.matrix.T @ raw.interior).reshape(-1, 3), program.friction).min() > 0
    assert check(program, raw.force, raw.twist).mechanism_violation > 0
    mended = check(program, raw.force, with_interior_motion(program, raw.twist, [raw.interior]))
    assert mended.proves_unstable
    assert mended.required_force == np.inf


def test_sound_forces_prove_stability_and_damaged_ones_do_not():
    eq, program, _, force = solved(running_bond(5, 4))
    nothing = np.zeros(6 * eq.n_blocks)
    assert check(program, force, nothing).proves_stable
    unbalanced = force.copy()
    unbalanced[7, 0] += 1e-6
    assert not check(program, unbalanced, nothing).proves_stable
    pulling = force.copy()
    pulling[7] = [-1e-6, 0, 0]
    assert not check(program, pulling, nothing).proves_stable
    assert not check(program, np.zeros_like(force), nothing).proves_stable


def test_forces_of_one_geometry_prove_nothing_of_another():
    eq, program, _, _ = solved(arch(20, 0.12))
    _, _, _, other = solved(arch(20, 0.121))
    assert not check(program, other, np.zeros(6 * eq.n_blocks)).proves_stable


def test_a_mechanism_proves_instability_and_a_damaged_one_does_not():
    _eq, program, raw, force = solved(stack(3).with_(gravity=(0.4, 0, -1)))
    assert check(program, force, raw.twist).proves_unstable
    assert not check(program, force, -raw.twist).proves_unstable
    assert not check(program, force, 0 * raw.twist).proves_unstable
    crooked = raw.twist.copy()
    crooked[2] -= 0.1 * np.abs(crooked).max()
    assert not check(program, force, crooked).proves_unstable


def test_no_twist_proves_a_stable_assembly_unstable():
    eq, program, _, force = solved(running_bond(4, 3))
    rng = np.random.default_rng(0)
    for _ in range(200):
        proof = check(program, force, rng.normal(size=6 * eq.n_blocks))
        assert not proof.proves_unstable
        assert proof.required_force <= force[:, 0].sum() / np.abs(program.load).sum() * (1 + 1e-9)


def test_mending_a_mechanism_leaves_no_joint_closing():
    _, program, raw, _ = solved(arch(20, 0.1072).with_(friction=2.0))
    rough = raw.twist + 1e-6 * np.random.default_rng(0).normal(size=len(raw.twist)) * np.abs(raw.twist).max()
    mended = open_joints(program, rough)

    def worst(twist):
        return opening_slack((program.matrix.T @ twist).reshape(-1, 3), program.friction).min()

    assert worst(rough) < 0
    assert worst(mended) >= 0
    assert np.abs(mended - rough).max() < 1e-3 * np.abs(rough).max()


def test_slack_in_the_cones():
    mu = np.array([0.5, 0.5, 0.0, 0.0, np.inf, np.inf, np.inf])
    force = np.array([[2, 0.6, 0.8], [1, 0.6, 0.8], [1, 0, 0], [1, 0.1, 0], [1, 9, 9], [0, 1, 0.0], [-1, 1e-16, 0]])
    np.testing.assert_allclose(cone_slack(force, mu), [0, -1, 1, -np.inf, 1, -1, -1])
    np.testing.assert_allclose(opening_slack(force, mu), [1.5, 0.5, 1, 1, -np.hypot(9, 9), -1, -1])


@pytest.mark.parametrize("solver", ["clarabel", "interior-point", "cvxpy"])
def test_equilibrium_of_the_returned_forces_by_hand(solver):
    # Add up forces and moments block by block, without the matrix.
    asm = arch(12, 0.2)
    verdict = assess(asm, solver=solver)
    assert verdict.outcome is Outcome.STABLE
    faces = verdict.interfaces
    for block in asm.free:
        force, moment = asm.mass[block] * asm.gravity, np.zeros(3)
        for point, k in enumerate(faces.point_interface):
            if block in faces.pair[k]:
                sign = 1 if faces.pair[k, 1] == block else -1
                push = sign * faces.frame[k].T @ verdict.forces[point]
                force = force + push
                moment = moment + np.cross(faces.point[point] - asm.centroid[block], push)
        np.testing.assert_allclose(force, 0, atol=1e-10)
        np.testing.assert_allclose(moment, 0, atol=1e-10)


def test_forces_that_balance_outside_their_cones_prove_nothing():
    # A cube of weight 1 on its four corners. Forces that grow at two opposite corners as they shrink at the others
    # balance; beyond a quarter of the weight two corners pull. So does friction that pinches the cube beyond mu f.
    program = program_of(stack(1))
    at = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    corner = [int(np.argmin(np.abs(program_points(program) - place).sum(axis=1))) for place in at]
    nothing = np.zeros(6)
    for share, stands in ((0.24, True), (0.26, False)):
        force = np.zeros((4, 3))
        force[corner, 0] = 0.25 + share * np.array([1, -1, 1, -1])
        found = check(program, force, nothing)
        assert found.imbalance < 1e-12
        assert found.proves_stable == stands
        assert found.cone_violation == pytest.approx(max(share - 0.25, 0.0), abs=1e-12)
    mu = program.friction[0]
    for part, stands in ((0.99, True), (1.01, False)):
        force = np.zeros((4, 3))
        force[:, 0] = 0.25
        force[corner[:2], 1:] = part * mu * 0.25 * tangent_along(program, corner[:2], [[1, 0, 0], [-1, 0, 0]])
        found = check(program, force, nothing)
        assert found.imbalance < 1e-12
        assert found.proves_stable == stands
        assert found.cone_violation == pytest.approx(max(part - 1, 0.0) * 0.25, abs=1e-12)


def program_points(program):
    """Places of the points of a program with one free unit cube that stands on z = 0, in plan: moment over force."""
    moment = program.local[::3, 9:] * program.length_unit  # of unit normal forces about the centroid
    return np.column_stack([-moment[:, 1], moment[:, 0]]) + 0.5


def tangent_along(program, points, directions):
    """Shares of t1 and t2 in horizontal directions at points of a program whose joints are level."""
    rows = program.local.reshape(-1, 3, 12)[points, 1:, 6:9]
    return np.einsum("nij,nj->ni", rows, np.array(directions, dtype=float))


@pytest.mark.parametrize("compression", [None, 100.0])
def test_a_joint_that_cannot_slide_is_not_dragged_for_nothing(compression):
    # A mechanism that slides a slab of infinite friction does work against forces without bound, and proves nothing.
    # Where the joint may crush, only its closing has a price.
    law = JointLaw(("*", "*"), compression=compression)
    slab = stack(1, friction=np.inf, gravity=(1, 0, -1)).with_(joints=[law] if compression else [])
    program = program_of(slab)
    slide = np.array([1.0, 0, 0, 0, 0, 0])
    found = check(program, np.zeros((len(program.friction), 3)), slide)
    assert found.work > 0
    assert found.mechanism_violation == pytest.approx(1.0)
    assert not found.proves_unstable


def test_a_program_in_other_units_is_the_same_program():
    law = JointLaw(("*", "*"), tension=2.0, cohesion=3.0, compression=50.0)
    program = program_of(arch(6, 0.3).with_(joints=[law]))
    random = np.random.default_rng(3)
    block, point = 10.0 ** random.uniform(-3, 3, 6), 10.0 ** random.uniform(-3, 3, len(program.friction))
    other = program.in_units(block, point)
    force = random.normal(size=(len(point), 3))
    np.testing.assert_allclose(
        (other.matrix @ (force / point[:, None]).reshape(-1) + other.load) * np.repeat(block, 6),
        program.matrix @ force.reshape(-1) + program.load,
        rtol=1e-9, atol=1e-9,
    )  # fmt: skip
    for name in ("shift", "lower", "upper"):
        assert getattr(program, name).any()
        np.testing.assert_allclose(getattr(other, name) * point, getattr(program, name), rtol=1e-12)


@pytest.mark.parametrize("asm", [stack(3), running_bond(4, 3), arch(20, 0.2)], ids=["stack", "wall", "arch"])
def test_an_assembly_that_expands_upwards_opens_every_joint(asm):
    # What proves instability without a bound on the forces begins with a motion that closes nowhere.
    faces = find_interfaces(asm)
    program = program_of(asm)
    slack = [
        opening_slack((program.matrix.T @ motion).reshape(-1, 3), program.friction).min()
        for motion in expansions(asm, faces, asm.free)
    ]
    assert max(slack) > 0
    assert expansions(asm, faces, asm.free[:0]) == ()
