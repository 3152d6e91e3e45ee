"""Mechanisms of one multiplier: what the solver mixes of them is no mechanism of its own, and e* is 1."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Block,
    acceleration,
    box,
    capacity,
    limit_load,
    linear_check,
    nonlinear_check,
)
from blockstat.code_check.linear import moving_bodies
from blockstat.code_check.macro_blocks import is_mixture

ALONG = np.array([1.0, 0.0, 0.0])
#: Of one body of alpha0 = .1: .1 x 9.81 / 1.35.
ONE_BODY = 0.726667


def turned(block, angle=0.0, mirror=1.0, shift=(0.0, 0.0, 0.0)):
    """A block mirrored in x, turned about z and moved."""
    c, s = np.cos(angle), np.sin(angle)
    corners = np.asarray(block.vertices, dtype=float) * (mirror, 1.0, 1.0)
    corners = corners @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    faces = block.faces if mirror > 0 else [face[::-1] for face in block.faces]
    return replace(block, vertices=corners + shift, faces=faces)


def on_ground(blocks, density=2000.0, **motion):
    ground = box((-3, -3, -1), (4, 9, 0), name="ground")
    moved = [turned(block, **motion) for block in (ground, *blocks)]
    return Assembly.from_blocks(moved, supports=["ground"], density=density)


def storeys(higher=0.0, courses=1):
    """A wall .6 m thick and one of .3 m on it, flush at the hinge face, each 3 m high.

    By hand, with weights 2 and 1: the upper one turns at .15 / 1.5, both about the toe at (.6 + .15) / (3 + 4.5).
    """
    found = []
    for name, x, low, high in (("lower", 0.0, 0.0, 3.0), ("upper", 0.3, 3.0, 6.0 + higher)):
        beds = np.linspace(low, high, courses + 1)
        ends = zip(beds[:-1], beds[1:], strict=True)
        found += [box((x, 0, a), (0.6, 4, b), name=f"{name}{k}") for k, (a, b) in enumerate(ends)]
    return found


FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def cut(kind, parts, height=6.0):
    """A spire 1 m wide, a triangular wall or one half of it, 6 m high, in parts of equal height.

    What is above each bed has the same shape. Its centroid is at a quarter of its height, or a third.
    """
    beds, found = np.linspace(0, height, parts + 1), []
    for k, (low, high) in enumerate(zip(beds[:-1], beds[1:], strict=True)):
        corners = []
        for z in (low, high):
            width = 1 - z / height
            left, right = (0.0, width) if kind == "half" else (-width / 2, width / 2)
            y = (-width / 2, width / 2) if kind == "spire" else (0.0, 3.0)
            corners += [(left, y[0], z), (right, y[0], z), (right, y[1], z), (left, y[1], z)]
        faces = FACES
        if k + 1 == parts and kind == "spire":
            corners, faces = corners[:5], [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
        elif k + 1 == parts:
            corners = [*corners[:4], corners[4], corners[6]]
            faces = [[0, 3, 2, 1], [0, 1, 4], [1, 2, 5, 4], [2, 3, 5], [3, 0, 4, 5]]
        found.append(Block(corners, faces, name=f"part{k}"))
    return found


def verified(blocks, along=ALONG, **motion):
    scene = on_ground(blocks, **motion)
    return linear_check(limit_load(scene, along), along)


def is_one_body(found, acceleration=ONE_BODY):
    assert found.participation == pytest.approx(1.0)
    assert found.acceleration == pytest.approx(acceleration, rel=1e-4)
    told = any("with a joint between them closed" in text for text in found.warnings)
    assert told == (len(found.bodies) > 1)


@pytest.mark.parametrize(
    "motion",
    [{}, {"mirror": -1.0}, {"angle": 0.5}, {"angle": 2.0, "mirror": -1.0}, {"shift": (5e5, 5.4e6, 100.0)}],
    ids=["as it is", "mirrored", "turned", "turned and mirrored", "in UTM"],
)
@pytest.mark.parametrize("courses", [1, 2])
def test_two_storeys_that_tip_at_one_multiplier_are_one_body(motion, courses):
    angle, mirror = motion.get("angle", 0.0), motion.get("mirror", 1.0)
    along = mirror * np.array([np.cos(angle), np.sin(angle), 0.0])
    found = verified(storeys(courses=courses), along, **motion)
    assert found.alpha0 == pytest.approx(0.1, rel=1e-6)
    is_one_body(found)
    assert found.warnings  # the mechanism is no single one


@pytest.mark.parametrize("order", [*permutations(range(4))], ids=str)
def test_the_order_of_blocks_does_not_matter(order):
    blocks = storeys(courses=2)
    is_one_body(verified([blocks[k] for k in order]))


@pytest.mark.parametrize("higher", [sign * size for size in (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4) for sign in (1, -1)])
def test_next_to_a_tie_a_body_that_hardly_moves_has_no_weight(higher):
    """It moves at 1e-3 of the speed of the other because the digits of the optimum end there: e* was 1/3."""
    is_one_body(verified(storeys(higher)))


@pytest.mark.parametrize("parts", [2, 3])
@pytest.mark.parametrize(
    ("kind", "along", "alpha0"),
    [("spire", 1, 1 / 3), ("spire", -1, 1 / 3), ("triangle", 1, 1 / 4), ("half", 1, 1 / 3), ("half", -1, 1 / 6)],
)
def test_shapes_that_are_like_their_upper_parts_are_one_body(kind, along, alpha0, parts):
    """Half widths .5 over heights 6/4 and 6/3; of half a triangle the centroid is 2/3 or 1/3 from its toe."""
    found = verified(cut(kind, parts), along * ALONG)
    assert found.alpha0 == pytest.approx(alpha0, rel=1e-6)
    is_one_body(found, alpha0 * 9.81 / 1.35)


def test_a_stack_that_leans_is_one_body():
    """Three blocks .5 m thick and .6 m high, each .1 m further than the one below, over whose edge it cannot lean.

    About the toe at x = .5 all turn at (.25 + .15 + .05) / (.3 + .9 + 1.5), and those above the first bed about the end
    of that bed, at x = .5 too, at (.15 + .05) / (.3 + .9).
    """
    found = verified([box((0.1 * k, 0, 0.6 * k), (0.5 + 0.1 * k, 1, 0.6 * (k + 1)), name=f"b{k}") for k in range(3)])
    is_one_body(found, 9.81 / 6 / 1.35)
    assert len(found.bodies) == 2


def test_what_an_optimum_mixes_with_another_mechanism_is_found():
    """The upper wall is 10 % more slender, and a thousandth of the motion of both about the toe is added to its own."""
    scene = on_ground(storeys(0.3))
    limit = limit_load(scene, ALONG)
    assert limit.lower == pytest.approx(0.3 / 3.3, rel=1e-6)
    both, alone = np.zeros((2, 3, 6))
    for motion, pole in ((both, (0.6, 2, 0)), (alone, (0.6, 2, 3))):
        motion[1:, :3] = np.cross((0, 1, 0), scene.centroid[1:] - pole)
        motion[1:, 4] = 1.0
    alone[1] = 0.0
    mixed = replace(limit, mechanism=alone + 1e-3 * both)
    found = linear_check(mixed, ALONG)
    assert len(found.bodies) == 2
    assert found.apart < 0.4
    is_one_body(found, 0.3 / 3.3 * 9.81 / 1.35)


def test_a_mixture_is_told_from_a_mechanism_that_is_the_only_one():
    """A lintel on two posts: a post that rests, or turns with the lintel, lets nothing move."""
    blocks = [box((0, 0, 0), (0.5, 1, 3)), box((3, 0, 0), (3.5, 1, 3)), box((0, 0, 3), (3.5, 1, 3.5))]
    for scene, mixture in ((on_ground(storeys()), True), (on_ground(blocks).with_(friction=5.0), False)):
        limit = limit_load(scene, ALONG)
        push = acceleration(scene, ALONG)
        assert is_mixture(limit, moving_bodies(limit), push, 1e-5) == mixture


@pytest.mark.parametrize(("more", "e_star"), [(5e-4, 1.0), (-5e-4, 1.0), (5e-3, 9.75**2 / (4.75 * 22.5))])
def test_what_stone_is_not_cut_well_enough_to_tell_from_the_mechanism_counts(more, e_star):
    """A portal that tips at 1 / 6 with three bodies, on a tower that turns with it as one at (1 + more) / 6.

    Posts of weight 1.5 and a lintel of 1.75, whose centroid is 2.1447 m above the tower. A tower of height H and weight
    3.5 H has its toe 1.75 m from all centroids: (4.75 + 3.5 H) 1.75 = (1 + more) / 6 (4.75 (H + 2.1447) + 1.75 H^2).
    """
    each = (1 + more) / 6
    height = max(np.roots([1.75 * each, 4.75 * each - 6.125, each * (1.5 * 3 + 1.75 * 3.25) - 4.75 * 1.75]).real)
    spans = [((0, 0, 0), (0.5, 1, 3)), ((3, 0, 0), (3.5, 1, 3)), ((0, 0, 3), (3.5, 1, 3.5))]
    portal = [box(*(np.add(end, (0, 0, height)) for end in span)) for span in spans]
    scene = on_ground([box((0, 0, 0), (3.5, 1, height)), *portal]).with_(friction=5.0)
    found = linear_check(limit_load(scene, ALONG), ALONG)
    assert found.alpha0 == pytest.approx((1 + min(more, 0)) / 6, rel=1e-6)
    assert found.participation == pytest.approx(e_star, rel=1e-6)
    assert len(found.bodies) == (1 if more < 0 else 3)


def test_a_curve_of_mechanisms_that_tip_follows_the_one_that_falls_fastest():
    """The upper storey falls when its centroid has moved by .15 m, the whole one by .75 m / 3."""
    found = nonlinear_check(capacity(on_ground(storeys()), ALONG, control="mean"), ALONG, demand={"SLV": 0.02})
    alone = on_ground(storeys()).with_(support=np.array([True, True, False]))
    single = nonlinear_check(capacity(alone, ALONG, control="mean"), ALONG)
    assert found.ultimate == pytest.approx(0.15, rel=1e-6)
    assert found.state("SLV").ag == pytest.approx(single.state("SLV").ag, rel=1e-6)
    assert found.outcome.word == "satisfied"


def test_a_curve_that_mixes_mechanisms_has_no_displacement_that_is_verified():
    """At friction .1 the storeys slide, too. SLD at .1 / 1.35 g; at SLV less than the upper storey alone bears."""
    curve = capacity(on_ground(storeys()).with_(friction=0.1), ALONG, control="mean")
    found = nonlinear_check(curve, ALONG, demand={"SLD": 0.07, "SLV": 0.02})
    alone = on_ground(storeys()).with_(support=np.array([True, True, False]))
    single = nonlinear_check(capacity(alone, ALONG, control="mean"), ALONG)
    assert found.participation == pytest.approx(1.0)
    assert found.apart < 0.6
    assert found.acceleration == pytest.approx(ONE_BODY, rel=1e-4)
    assert found.state("SLD").ag == pytest.approx(0.1 / 1.35, rel=1e-4)
    assert found.state("SLV").ag < single.state("SLV").ag
    assert [state.satisfied for state in found.states] == [True, None, None]
    assert found.outcome.word == "not_verified"
    assert any("the curve follows a mixture of mechanisms" in text for text in found.warnings)
    refused = nonlinear_check(curve, ALONG, demand={"SLV": 0.5})
    assert refused.outcome.word == "not_satisfied"
