"""What physics says must not change a verdict, and which way a change can go."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from blockstat import Block, Outcome, assess, limit_load
from problems import SCENES, arch, assembly, running_bond, stack

SCENE = st.sampled_from(SCENES)
FEW = settings(max_examples=25, deadline=None)


def rebuilt(asm, vertices, order=None):
    blocks = [
        Block(
            vertices[asm.vertex_start[i] : asm.vertex_start[i + 1]],
            asm.faces_of(i),
            asm.names[i],
            density=asm.density[i],
        )
        for i in (range(asm.n_blocks) if order is None else order)
    ]
    names = [asm.names[i] for i in np.flatnonzero(asm.support)]
    return assembly(blocks, supports=names, friction=asm.friction, gravity=asm.gravity)


def same(a, b, rel=1e-5):
    assert a.outcome is b.outcome
    assert a.score == pytest.approx(b.score, rel=rel, abs=1e-9)


@FEW
@given(SCENE, st.sampled_from([1e-3, 1e3]))
def test_units_of_length(scene, scale):
    _, make, options = scene
    asm = make()
    same(assess(asm, **options), assess(rebuilt(asm, scale * asm.vertices), **options))


@FEW
@given(SCENE, st.sampled_from([1e-3, 1e4]))
def test_density(scene, factor):
    _, make, options = scene
    asm = make()
    same(assess(asm, **options), assess(asm.with_(density=factor * asm.density), **options))


@FEW
@given(SCENE, st.integers(0, 2**32 - 1))
def test_order_of_the_blocks(scene, seed):
    _, make, options = scene
    asm = make()
    order = np.random.default_rng(seed).permutation(asm.n_blocks)
    same(assess(asm, **options), assess(rebuilt(asm, asm.vertices, order), **options))


@FEW
@given(SCENE, st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-100, 100)] * 3))
def test_rotation_and_translation(scene, turn, shift):
    _, make, options = scene
    asm = make().with_(**options)
    matrix = Rotation.from_rotvec(turn).as_matrix()
    moved = rebuilt(asm, asm.vertices @ matrix.T + shift).with_(gravity=matrix @ asm.gravity)
    same(assess(asm), assess(moved))


@FEW
@given(SCENE)
def test_mirror(scene):
    _, make, options = scene
    asm = make().with_(**options)
    flip = np.array([-1.0, 1, 1])
    blocks = [
        Block(
            asm.block_vertices(i) * flip,
            [f[::-1] for f in asm.faces_of(i)],
            asm.names[i],
            density=asm.density[i],
        )
        for i in range(asm.n_blocks)
    ]
    names = [asm.names[i] for i in np.flatnonzero(asm.support)]
    same(
        assess(asm),
        assess(assembly(blocks, supports=names, friction=asm.friction, gravity=asm.gravity * flip)),
    )


@FEW
@given(SCENE, st.integers(0, 100))
def test_one_more_support_never_destabilises(scene, pick):
    _, make, options = scene
    asm = make()
    support = asm.support.copy()
    support[pick % asm.n_blocks] = True
    if assess(asm, **options).outcome is Outcome.STABLE:
        assert assess(asm.with_(support=support), **options).outcome is Outcome.STABLE


@FEW
@given(st.floats(0.0, 1.5), st.floats(0.0, 1.5), st.floats(0, 0.6))
def test_less_friction_never_stabilises(one, two, push):
    low, high = sorted((one, two))
    asm = running_bond(3, 3)
    outcomes = [assess(asm, friction=mu, gravity=(push, 0, -1)).outcome for mu in (low, high)]
    assert outcomes != [Outcome.STABLE, Outcome.UNSTABLE]


@pytest.mark.parametrize("mu", [0.0, 1e-3, 1e3, np.inf])
def test_extreme_friction_is_decided(mu):
    assert assess(stack(4), friction=mu).outcome is Outcome.STABLE
    assert assess(arch(12, 0.05), friction=mu).outcome is Outcome.UNSTABLE


def test_frictionless_block_on_a_slope_has_no_finite_score():
    verdict = assess(stack(1), friction=0.0, gravity=(0.1, 0, -1))
    assert verdict.outcome is Outcome.UNSTABLE
    assert verdict.score == np.inf
    assert verdict.summary()["score"] is None


def test_far_from_the_origin():
    asm = arch(12, 0.12)
    for shift in (1e3, 1e6):
        assert assess(rebuilt(asm, asm.vertices + shift)).outcome is Outcome.STABLE
        assert assess(rebuilt(arch(12, 0.1), arch(12, 0.1).vertices + shift)).outcome is Outcome.UNSTABLE


LIMITS = [
    (lambda: arch(20, 0.2), (1, 0, 0)),
    (lambda: running_bond(5, 4), (1, 0, 0)),
    (lambda: running_bond(4, 3), (0.3, 1, 0)),
]


@pytest.mark.parametrize(("make", "direction"), LIMITS, ids=["arch", "wall", "wall across"])
def test_limit_loads_do_not_depend_on_the_point_of_view(make, direction):
    asm = make()
    exact = limit_load(asm, direction)
    turn = Rotation.from_rotvec([0.7, -0.2, 1.1]).as_matrix()
    order = np.random.default_rng(3).permutation(asm.n_blocks)
    rotated = rebuilt(asm, asm.vertices @ turn.T + [5, -3, 2]).with_(gravity=turn @ asm.gravity)
    others = [
        limit_load(rebuilt(asm, 1e-3 * asm.vertices), direction),
        limit_load(rebuilt(asm, 1e3 * asm.vertices), direction),
        limit_load(asm.with_(density=1e4 * asm.density), direction),
        limit_load(asm.with_(gravity=9.81 * asm.gravity), direction),
        limit_load(rebuilt(asm, asm.vertices, order), direction),
        limit_load(rotated, (turn @ np.array(direction)).tolist()),
    ]
    for other in others:
        assert other.outcome is exact.outcome
        assert other.lower == pytest.approx(exact.lower, rel=1e-6)
        assert other.upper == pytest.approx(exact.upper, rel=1e-6)
