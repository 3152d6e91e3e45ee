"""What physics says must not change a verdict, and which way a change can go."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from blockstat import Block, LoadOutcome, Outcome, acceleration, assess, limit_load
from evidence.scenes.small import SCENES, arch, assembly, stack

SCENE = st.sampled_from(SCENES)
FEW = settings(max_examples=25, deadline=None)


PUSH = st.sampled_from([(1, 0, 0), (0, 1, 0), (-0.6, 0.8, 0)])
#: Subnormal numbers have a few digits only, and so has a limit that is proportional to one.
FRICTION = st.floats(0.0, 1.5, allow_subnormal=False)


def rebuilt(asm, vertices, order=None, *, mirrored=False):
    """The same blocks with other vertices, in another order."""
    blocks = [
        Block(
            vertices[asm.vertex_start[i] : asm.vertex_start[i + 1]],
            [face[::-1] for face in asm.faces_of(i)] if mirrored else asm.faces_of(i),
            asm.names[i],
            density=asm.density[i],
        )
        for i in (range(asm.n_blocks) if order is None else order)
    ]
    names = [asm.names[i] for i in np.flatnonzero(asm.support)]
    return assembly(blocks, supports=names, friction=asm.friction, gravity=asm.gravity)


def posed(scene):
    _, make, options = scene
    return make().with_(**options)


def assert_same(asm, push, other, other_push=None):
    """The same verdict and score, and the same bracket on the multiplier of a horizontal push."""
    one, two = assess(asm), assess(other)
    assert one.outcome is two.outcome
    assert one.score == pytest.approx(two.score, rel=1e-5, abs=1e-9)
    limits = limit_load(asm, push), limit_load(other, push if other_push is None else other_push)
    assert limits[0].outcome is limits[1].outcome
    # Joints that cannot slide at all are redundant equations, and their bounds are less sharp; they hold all the same.
    accuracy = 1e-6
    for bound in ("lower", "upper"):
        assert getattr(limits[0], bound) == pytest.approx(getattr(limits[1], bound), rel=accuracy)
    assert max(limit.lower for limit in limits) <= min(limit.upper for limit in limits)


def assert_no_weaker(weak, strong, load):
    """What stands stands with more to hold it, and carries as much of a load."""
    if assess(weak).outcome is not Outcome.STABLE:
        return
    assert assess(strong).outcome is Outcome.STABLE
    if load[strong.free].any():
        # Bounds hold to the rounding of their certificates, which shows where the limit is zero.
        assert limit_load(strong, load).upper >= limit_load(weak, load).lower - 1e-9


@FEW
@given(SCENE, PUSH, st.sampled_from([1e-3, 1e3]))
def test_units_of_length(scene, push, scale):
    asm = posed(scene)
    assert_same(asm, push, rebuilt(asm, scale * asm.vertices))


@FEW
@given(SCENE, PUSH, st.sampled_from([1e-3, 1e4]))
def test_density(scene, push, factor):
    asm = posed(scene)
    assert_same(asm, push, asm.with_(density=factor * asm.density))


@FEW
@given(SCENE, PUSH, st.sampled_from([1e-3, 9.81, 1e3]))
def test_strength_of_gravity(scene, push, factor):
    asm = posed(scene)
    assert_same(asm, push, asm.with_(gravity=factor * asm.gravity))


@FEW
@example(("arch", lambda: arch(20, 0.12), {}), (-0.6, 0.8, 0), 7709)  # one solver alone is 4e-6 off
@given(SCENE, PUSH, st.integers(0, 2**32 - 1))
def test_order_of_the_blocks(scene, push, seed):
    asm = posed(scene)
    order = np.random.default_rng(seed).permutation(asm.n_blocks)
    assert_same(asm, push, rebuilt(asm, asm.vertices, order))


@FEW
@given(SCENE, PUSH, st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-100, 100)] * 3))
def test_rotation_and_translation(scene, push, turn, shift):
    asm = posed(scene)
    matrix = Rotation.from_rotvec(turn).as_matrix()
    moved = rebuilt(asm, asm.vertices @ matrix.T + shift).with_(gravity=matrix @ asm.gravity)
    assert_same(asm, push, moved, matrix @ push)


@FEW
@given(SCENE, PUSH, st.sampled_from(range(3)))
def test_mirror(scene, push, axis):
    asm = posed(scene)
    flip = np.ones(3)
    flip[axis] = -1
    mirrored = rebuilt(asm, asm.vertices * flip, mirrored=True).with_(gravity=asm.gravity * flip)
    assert_same(asm, push, mirrored, flip * push)


@FEW
@given(SCENE, PUSH, st.integers(0, 100))
def test_one_more_support_never_destabilises(scene, push, pick):
    asm = posed(scene)
    support = asm.support.copy()
    support[pick % asm.n_blocks] = True
    firmer = asm.with_(support=support)
    assert_no_weaker(asm, firmer, acceleration(asm, push))


@FEW
@given(SCENE, PUSH, FRICTION, FRICTION)
@example(SCENES[0], (-0.6, 0.8, 0), 0.0, 1.5e-301)
def test_less_friction_never_stabilises(scene, push, one, two):
    asm = posed(scene)
    low, high = sorted((one, two))
    assert_no_weaker(asm.with_(friction=low), asm.with_(friction=high), acceleration(asm, push))


@FEW
@given(SCENE, PUSH, st.sampled_from([1e-3, 0.5, 7.0, 1e3]))
def test_the_multiplier_of_a_scaled_load_is_scaled_back(scene, push, factor):
    asm = posed(scene)
    load = acceleration(asm, push)
    one, other = limit_load(asm, load), limit_load(asm, factor * load)
    assert one.outcome is other.outcome
    for bound in ("lower", "upper"):
        assert factor * getattr(other, bound) == pytest.approx(getattr(one, bound), rel=1e-6)


@FEW
@given(SCENE, PUSH, st.floats(0.0, 0.999), st.floats(1.001, 10.0))
def test_all_of_a_load_below_its_limit_is_carried_and_none_above(scene, push, below, above):
    asm = posed(scene)
    load = acceleration(asm, push)
    limit = limit_load(asm, load)
    assume(limit.outcome is LoadOutcome.LIMIT and limit.upper > 1e-3)
    assert assess(asm, loads=below * limit.lower * load).outcome is Outcome.STABLE
    # Without any sliding a motion so near the limit may close joints by more than the certificate lets pass.
    beyond = {Outcome.UNSTABLE, Outcome.UNDECIDED} if np.isinf(asm.friction) else {Outcome.UNSTABLE}
    assert assess(asm, loads=above * limit.upper * load).outcome in beyond


@FEW
@given(SCENE, PUSH, PUSH, st.floats(0.0, 1.0))
def test_what_carries_two_loads_carries_any_load_between_them(scene, one, two, share):
    asm = posed(scene)
    limits = [limit_load(asm, push) for push in (one, two)]
    assume(all(limit.outcome is LoadOutcome.LIMIT for limit in limits))
    first, second = (0.99 * limit.lower * acceleration(asm, p) for limit, p in zip(limits, (one, two), strict=True))
    assert assess(asm, loads=share * first + (1 - share) * second).outcome is not Outcome.UNSTABLE


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
