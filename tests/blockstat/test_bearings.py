"""What bears on a bed that is not convex, wherever it lies: an arm without width bears nothing, one of 1 mm does."""

import numpy as np
import pytest

from blockstat import Block, JointLaw, LoadOutcome, Outcome, assess, find_interfaces, limit_load
from evidence.scenes.small import assembly, box

L_BED = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
C_BED = [(0, 0), (5, 0), (5, 4), (4, 4), (4, 1), (1, 1), (1, 4), (0, 4)]
U_FRAME = [(0, 0), (4, 0), (4, 2), (3, 2), (3, 0.5), (1, 0.5), (1, 2), (0, 2)]
UTM = np.array([500000.0, 4600000.0, 300.0])
DOWN = np.array([0.0, 0.0, -9.81])
#: Thickness of the slabs [m]: their centroid lies half of it above the bed.
THICK = 0.3


def upright(outline, low, high, name):
    """A prism over an outline in plan."""
    n = len(outline)
    corners = np.array([(x, y, z) for z in (low, high) for x, y in outline], dtype=float)
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    return Block(corners, [list(range(n))[::-1], list(range(n, 2 * n)), *sides], name)


def on_bed(outline, low, high, *, mu=0.7, **options):
    """A slab from one corner to the other on a bed of some outline."""
    slab = box((*low, 0), (*high, THICK), name="slab")
    return assembly([upright(outline, -0.5, 0, "bed"), slab], supports=["bed"], friction=mu, **options)


def on_frame(bearing):
    """A lintel that rests on 0.2 m of one leg of a frame, and on so much of the other."""
    lying = upright(U_FRAME, -1, 0, "bed")
    standing = Block(lying.vertices @ [[1, 0, 0], [0, 0, 1], [0, -1, 0]], lying.faces, "bed")
    return assembly([standing, box((0.8, 0, 2), (3 + bearing, 1, 2.4), name="slab")], supports=["bed"], friction=0.7)


def on_piers(bearing):
    """The same lintel on two piers."""
    piers = [box((0, 0, 0), (1, 1, 2), name="left"), box((3, 0, 0), (4, 1, 2), name="bed")]
    lintel = box((0.8, 0, 2), (3 + bearing, 1, 2.4), name="slab")
    return assembly([*piers, lintel], supports=["left", "bed"], friction=0.7)


def turn(axis, degrees):
    """The rotation about an axis."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross, angle = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.deg2rad(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


IN_PLAN = [turn((0, 0, 1), degrees) for degrees in (0, 9, 18, 30, 42, 48, 60, 63, 78, 87)]
IN_SPACE = [turn((1, 2, -1), 17), turn((3, -1, 2), 71), turn((-1, 1, 4), 133), turn((2, 5, 1), 201)]


def copies(asm, *, far=True):
    """A scene turned in plan and in space with its gravity, as drawn and, where wanted, in UTM and in millimetres."""
    for rotation in (*IN_PLAN, *IN_SPACE):
        for scale, origin in ((1.0, 0 * UTM), *(((1.0, UTM), (1000.0, 0 * UTM), (1000.0, 1000 * UTM)) if far else ())):
            place = scale * asm.vertices @ rotation.T + origin
            yield rotation, asm.with_(vertices=place, gravity=scale * rotation @ DOWN, density=asm.density / scale**3)


NOTHING_BEARS = {
    "the edge of a slab along that of a leg": on_bed(L_BED, (1, 0.5), (3, 2)),
    "two edges of a slab along two legs": on_bed(C_BED, (1, 0.8), (4, 3)),
    "the end of a lintel at the edge of a leg": on_frame(0.0),
    "a slab that just fits between three sides": on_bed(C_BED, (1, 1), (4, 3)),
    "a slab that overlaps two legs by rounding": on_bed(C_BED, (1 - 1e-8, 0.8), (4 + 1e-8, 3)),
    "a slab that overlaps three sides by rounding": on_bed(C_BED, (1 - 1e-8, 1 - 1e-8), (4 + 1e-8, 3)),
}


@pytest.mark.parametrize("case", NOTHING_BEARS)
def test_edge_along_edge_beside_a_bearing_carries_nothing_for_sure(case):
    """The centroid is beyond what bears, so that only edges without a normal could hold the slab."""
    for _, asm in copies(NOTHING_BEARS[case]):
        verdict = assess(asm)
        assert verdict.outcome is Outcome.UNDECIDED
        assert any('"bed" and "slab" touch only' in text for text in verdict.warnings)


@pytest.mark.parametrize("case", list(NOTHING_BEARS)[:3])
def test_what_edges_alone_may_hold_has_no_proven_limit_and_no_state_without_dilatancy(case):
    for rotation, asm in copies(NOTHING_BEARS[case], far=False):
        found = limit_load(asm, rotation @ [1.0, 0.0, 0.0])
        assert (found.outcome, found.lower) == (LoadOutcome.UNDECIDED, -np.inf)
        assert assess(asm, flow="coulomb").outcome is Outcome.UNDECIDED


def test_an_arm_of_a_hundredth_of_a_metre_bears():
    """The slab tips about the line from (3, 1) to (1, 2), which is d from its centroid in plan, at d / h."""
    asm = on_bed(L_BED, (0.99, 0.5), (3, 2), mu=2.0)
    out = np.array([1.0, 2.0]) / np.sqrt(5)
    arm = out @ [3 - (0.99 + 3) / 2, 1 - 1.25]
    for rotation, turned in copies(asm):
        verdict = assess(turned)
        assert (verdict.outcome, verdict.warnings) == (Outcome.STABLE, ())
        found = limit_load(turned, rotation @ [*out, 0.0])
        assert found.lower == pytest.approx(arm / (THICK / 2), rel=1e-4)
        assert found.warnings == ()


def test_an_arm_of_a_millimetre_bears_without_a_word():
    """It is just wider than a thousandth of the slab, whose size is 0.965 m."""
    for _, asm in copies(on_bed(L_BED, (1 - 1e-3, 0.5), (3, 2))):
        verdict = assess(asm)
        assert (verdict.outcome, verdict.warnings) == (Outcome.STABLE, ())


def test_the_outline_of_a_bearing_keeps_its_corners_when_an_arm_of_it_is_none():
    """Of the L, the slab bears on the rectangle from (1, 0.5) to (3, 1)."""
    for rotation, asm in copies(NOTHING_BEARS["the edge of a slab along that of a leg"], far=False):
        joints = find_interfaces(asm)
        assert joints.area == pytest.approx([1.0], rel=1e-6)
        corners = joints.point @ rotation
        wanted = np.array([(1, 0.5, 0), (3, 0.5, 0), (3, 1, 0), (1, 1, 0)])
        away = np.linalg.norm(corners[:, None] - wanted, axis=2)
        assert away.min(axis=1).max() < 1e-6
        assert away.min(axis=0).max() < 1e-6


@pytest.mark.parametrize("width", [2e-6, 1e-4])
def test_a_bearing_narrower_than_a_thousandth_is_told_whether_or_not_its_blocks_meet_elsewhere(width):
    told = (
        'stable only with joints narrower than 0.001 of their smaller block: "bed" to "slab"; without them it is not '
        "proven stable",
    )
    assert assess(on_piers(width)).warnings == told
    for asm in (on_frame(width), on_bed(L_BED, (1 - width, 0.5), (3, 2))):
        for _, turned in copies(asm, far=False):
            verdict = assess(turned)
            assert (verdict.outcome, verdict.warnings) == (Outcome.STABLE, told)
        assert assess(asm, flow="coulomb").warnings == told


@pytest.mark.parametrize("width", [1e-9, 1e-7, 1e-5, 1e-3, 0.1])
def test_a_bed_of_one_block_bears_as_one_of_two(width):
    """Cut along y = 1 into two supports, the L-shaped bed bears as before; the arm has a block of its own."""
    slab = box((1 - width, 0.5, 0), (3, 2, THICK), name="slab")
    halves = [[(0, 0), (3, 0), (3, 1), (0, 1)], [(0, 1), (1, 1), (1, 3), (0, 3)]]
    beds = [upright(outline, -0.5, 0, name) for outline, name in zip(halves, ("bed", "other"), strict=True)]
    two = assembly([*beds, slab], supports=["bed", "other"], friction=0.7)
    one = on_bed(L_BED, (1 - width, 0.5), (3, 2))
    for (rotation, whole), (_, cut) in zip(copies(one, far=False), copies(two, far=False), strict=True):
        push = rotation @ [0.3, 1.0, 0.0]
        own, other = limit_load(whole, push), limit_load(cut, push)
        assert own.outcome is other.outcome
        assert own.lower == pytest.approx(other.lower, rel=1e-4)
        assert len(own.warnings) == len(other.warnings)


def test_a_limit_that_rests_on_a_narrow_arm_says_what_is_carried_without_it():
    """Without the arm the slab tips about y = 1, 0.2 m from its centroid; with it about the line to (1, 1.4)."""
    asm = on_bed(L_BED, (1 - 1e-4, 0.2), (3, 1.4), mu=4.0)
    for rotation, turned in copies(asm, far=False):
        found = limit_load(turned, rotation @ [0.0, 1.0, 0.0])
        assert found.lower == pytest.approx(0.4 / (THICK / 2), rel=1e-3)
        (text,) = found.warnings
        head, carried = text.rsplit(" ", 1)
        assert head.endswith('narrower than 0.001 of their smaller block: "bed" to "slab"; without them it is')
        assert float(carried) == pytest.approx(0.2 / (THICK / 2), rel=1e-3)
    standing = limit_load(on_bed(L_BED, (1 - 1e-4, 0.5), (3, 2)), (0, 1, 0))
    assert standing.warnings[-1].endswith("without them the dead load is not proven to be carried")


def test_a_narrow_arm_that_nothing_needs_is_not_told():
    """Pushed away from the arm, the slab tips about y = 0.2, 0.6 m from its centroid."""
    asm = on_bed(L_BED, (1 - 1e-4, 0.2), (3, 1.4), mu=9.0)
    assert assess(asm).warnings == ()
    found = limit_load(asm, (0, -1, 0))
    assert found.lower == pytest.approx(0.6 / (THICK / 2), rel=1e-4)
    assert found.warnings == ()


@pytest.mark.parametrize(
    "law", [{"compression": 1e7}, {"tension": 0.01}, {"cohesion": 0.01}, {"compression": 1e7, "cells": 3}]
)
def test_a_narrow_arm_is_told_under_a_joint_law(law):
    """The tension, 0.01 Pa on 1 m2, has a moment of at most 0.005 N m; the slab has one of 0.25 m times its 0.9 N."""
    asm = on_bed(L_BED, (1 - 1e-4, 0.5), (3, 2), joints=[JointLaw(("*", "*"), **law)])
    verdict = assess(asm)
    assert verdict.outcome is Outcome.STABLE
    assert any("stable only with joints narrower than 0.001" in text for text in verdict.warnings)


def test_a_wide_bearing_in_small_pieces_is_no_sliver():
    """The bed has a round notch of 60 sides, each shorter than a thousandth of the slab, whose size is 0.84 m."""
    angle = np.linspace(np.pi, 0, 61)
    notch = 0.01 * np.column_stack([np.cos(angle), np.sin(angle)])
    bed = [(-1.0, 0.0), *notch.tolist(), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0)]
    asm = on_bed(bed, (-1, 0), (1, 1))
    joints = find_interfaces(asm)
    assert min(patch.area for patch in joints.patches) < 1e-3 * asm.size[1] * 0.9  # in triangles across the bed
    verdict = assess(asm)
    assert (verdict.outcome, verdict.warnings) == (Outcome.STABLE, ())
