"""The structured solver on hard cases: mass ratios, tiny joints, redundant contacts, units, either factorisation."""

import numpy as np
import pytest

from blockstat import JointLaw, LoadOutcome, Outcome, assess, limit_load
from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import find_interfaces
from blockstat.linear_algebra import factor
from blockstat.linear_algebra import normal_equations as normal
from blockstat.solve.penalty import solve_penalty
from evidence.scenes.small import arch, assembly, box, running_bond, stack

IP = {"solver": "interior-point"}


def residual(verdict):
    """Largest unbalanced force or moment over the total weight, added up block by block."""
    asm, faces = verdict.assembly, verdict.interfaces
    k = faces.point_interface
    push = np.einsum("nij,ni->nj", faces.frame[k], verdict.forces)
    left = np.zeros((asm.n_blocks, 6))
    left[:, :3] = asm.mass[:, None] * asm.gravity
    for side, sign in ((0, -1.0), (1, 1.0)):
        block = faces.pair[k, side]
        np.add.at(left[:, :3], block, sign * push)
        np.add.at(left[:, 3:], block, sign * np.cross(faces.point - asm.centroid[block], push))
    left[:, 3:] /= asm.size[:, None]
    return np.abs(left[asm.free]).max() / asm.free_weight


def overhang(ratio, excess):
    """A light block that a heavy one on its tail holds back: it tips where its own moment beats the heavy one's."""
    base = box((-2, 0, -1), (0, 1, 0), name="base")
    plank = box((-1, 0, 0), (1 + excess, 1, 0.1), name="plank", density=1.0)
    heavy = box((-0.8, 0, 0.1), (-0.6, 1, 0.3), name="heavy", density=ratio)
    return assembly([base, plank, heavy])


@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_mass_ratios(ratio):
    # Moments about the edge of the base: plank .1 ((1 + e)^2 - 1) / 2 against ratio x .04 x .7.
    balance = np.sqrt(1 + 2 * ratio * 0.04 * 0.7 / 0.1) - 1
    # Balance is proven to 1e-9 of a block's load, and a fall by motions good to 1e-6 of it: what decides must be more.
    margin = min(max(1e-4, 1e-6 / balance), 0.9 / min(balance, 1.0))
    for excess, outcome in ((balance * (1 - margin), Outcome.STABLE), (balance * (1 + margin), Outcome.UNSTABLE)):
        verdict = assess(overhang(ratio, excess), **IP)
        assert verdict.outcome is outcome
        if verdict.outcome is Outcome.STABLE:
            assert residual(verdict) < 1e-10


@pytest.mark.parametrize("mass", [1e-6, 1e-3, 1e3, 1e6])
def test_a_stone_of_another_weight_on_a_wall(mass):
    wall = running_bond(5, 4)
    asm = assembly([*blocks_of(wall), box((0.7, 0, 0.875), (0.9, 0.2, 1.0), name="stone", density=mass)])
    verdict = assess(asm, **IP)
    assert verdict.outcome is Outcome.STABLE
    assert verdict.solver == "interior-point"
    assert residual(verdict) < 1e-10
    assert assess(asm, gravity=(1.2, 0, -1), **IP).outcome is Outcome.UNSTABLE


def blocks_of(asm):
    from blockstat import Block

    return [Block(asm.block_vertices(i), asm.faces_of(i), name=asm.names[i]) for i in range(asm.n_blocks)]


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-5])
def test_a_narrow_joint(width):
    # A block on a ledge so narrow, its centre of mass inside or outside of it.
    for inside, outcome in ((0.25, Outcome.STABLE), (-0.25, Outcome.UNSTABLE)):
        ground = box((-1, -1, -1), (0, 1, 0), name="ledge")
        left = -width * inside - 0.5  # centre of mass at -width * inside
        asm = assembly([ground, box((left, -0.5, 0), (left + 1, 0.5, 1), name="stone")])
        small = assembly([box((-width, -1, -1), (0, 1, 0), name="ledge"), *blocks_of(asm)[1:]])
        for case in (asm, small):
            verdict = assess(case, **IP)
            assert verdict.outcome is outcome
            if outcome is Outcome.STABLE:
                assert residual(verdict) < 1e-10


def test_redundant_contacts():
    # Sixteen posts carry one slab: 64 points where three would do.
    posts = [box((i, j, 0), (i + 0.3, j + 0.3, 1), name=f"post{i}{j}") for i in range(4) for j in range(4)]
    slab = box((0, 0, 1), (3.3, 3.3, 1.2), name="slab")
    asm = assembly([box((-1, -1, -1), (5, 5, 0), name="ground"), *posts, slab])
    verdict = assess(asm, **IP)
    assert verdict.outcome is Outcome.STABLE
    assert residual(verdict) < 1e-10
    found = limit_load(asm, (1, 0, 0), optimum=True, **IP)
    assert found.lower == pytest.approx(0.3, rel=1e-6)  # the posts tip, whatever the slab weighs


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_units(scale):
    asm = arch(20, 0.12)
    scaled = asm.with_(vertices=asm.vertices * scale, density=asm.density * 10.0 ** np.log10(scale))
    one, other = (limit_load(a, (1, 0, 0), optimum=True, **IP) for a in (asm, scaled))
    assert other.lower == pytest.approx(one.lower, rel=1e-7)


def test_friction_next_to_nothing_and_next_to_endless():
    for mu in (1e-4, 1e4):
        found = limit_load(stack(1, 1.0, 1.0), (1, 0, 0), friction=mu, **IP)
        assert found.outcome is LoadOutcome.LIMIT
        assert found.lower == pytest.approx(min(mu, 1.0), rel=1e-5)


def test_either_factorisation_gives_the_same(monkeypatch):
    asm = running_bond(8, 8)
    plain = limit_load(asm, (0.2, 1, 0), optimum=True, **IP)
    monkeypatch.setenv("BLOCKSTAT_FACTOR", "superlu")
    normal.known.normals.clear()
    assert factor.backend() == "superlu"
    other = limit_load(asm, (0.2, 1, 0), optimum=True, **IP)
    normal.known.normals.clear()
    assert other.lower == pytest.approx(plain.lower, rel=1e-8)


def test_clarabel_takes_over_what_does_not_fit():
    # A strength in compression on a joint without friction.
    law = JointLaw(("*", "*"), friction=0.0, compression=50.0, cells=2)
    verdict = assess(stack(2).with_(joints=[law]), **IP)
    assert verdict.outcome is Outcome.STABLE
    assert verdict.solver == "clarabel"


def test_a_pattern_is_analysed_once():
    asm = running_bond(6, 6)
    faces = find_interfaces(asm)
    programs = [
        pose(asm, friction=mu, gravity=(0.1, 0.2, -1), loads=None, gap=0.01, interfaces=faces).program
        for mu in (0.5, 0.7)
    ]
    normal.known.normals.clear()
    for program in programs:
        assert program is not None
        solve_penalty(program, **IP)
    # One for the forces that are looked for first; if it came to that, one for the penalty program and one for the
    # correction of forces onto equilibrium.
    assert 1 <= len(normal.known.normals) <= 3


def test_joints_may_name_their_two_blocks_in_either_order():
    # Two blocks may share joints found from either side: (0, 1) and (1, 0); supports are -1.
    random = np.random.default_rng(3)
    pair = np.array([(0, 1), (1, 0), (0, -1), (-1, 0), (2, 1), (1, 2), (0, 1), (-1, 2)]).repeat(3, axis=0)
    rows = random.normal(size=(len(pair), 6)) * (pair >= 0).repeat(3, axis=1)
    dense = np.zeros((len(pair), 9))
    for row, blocks, values in zip(dense, pair, rows.reshape(-1, 2, 3), strict=True):
        for block, part in zip(blocks, values, strict=True):
            if block >= 0:
                row[3 * block : 3 * block + 3] = part
    equations = normal.normal_equations(pair, 3, 3)
    equations.update(rows)
    right = random.normal(size=9)
    assert equations.solve(right) == pytest.approx(np.linalg.solve(dense.T @ dense, right), rel=1e-9)
