"""Corners with notches and edges along each other: what a motion drives together is the same if a support is cut."""

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation
from test_reserve import posed

from blockstat import Block, Outcome, assess
from blockstat.analysis.rims import rim_warnings
from blockstat.surface.corner_cones import corner_cones
from evidence.scenes.small import assembly, box, prism
from tests.point_bodies import hull

TURNS = [Rotation.identity(), Rotation.from_rotvec([0.7, -1.1, 0.4])]
QUADRANTS = [((0, 0), (1, 1)), ((0, -1), (1, 0)), ((-1, -1), (0, 0))]  # of an angle without x < 0 < y
WHOLE = [(-1, -1), (1, -1), (1, 1), (0, 1), (0, 0), (-1, 0)]


def upright(outline, low, high, **options):
    """A prism over an outline in plan."""
    block = prism(outline, high - low, **options)
    x, y, z = np.asarray(block.vertices, dtype=float).T
    return Block(np.column_stack([x, z, high - y]), block.faces, **options)


def turned(blocks, turn):
    return [Block(turn.apply(np.asarray(b.vertices, dtype=float)), b.faces, name=b.name) for b in blocks]


def told(blocks, supports, turn, *, velocity, rotation=(0, 0, 0)):
    """Whether a motion of the last block, its velocity at the origin, is said to drive it into others."""
    asm = assembly(turned(blocks, turn), supports=list(range(supports)))
    motion = np.zeros((asm.n_blocks, 6))
    motion[-1, 3:] = turn.apply(rotation)
    motion[-1, :3] = turn.apply(velocity) + np.cross(motion[-1, 3:], asm.centroid[-1])
    return bool(rim_warnings(posed(asm), motion))


@pytest.mark.parametrize("turn", TURNS)
def test_the_cones_of_a_corner_are_the_solid_about_it(turn):
    floor = turned([upright(WHOLE, -1, 0)], turn)[0]
    asm = assembly([floor])
    at = np.flatnonzero(np.abs(asm.vertices).max(axis=1) < 1e-12)
    (cones,) = corner_cones(asm, at)
    rng = np.random.default_rng(0)
    for way in rng.normal(size=(60, 3)):
        x, y, z = way
        within = any(nnls(cone.T, turn.apply(way))[1] < 1e-9 for cone in cones)
        assert within is bool(z < 0 and not x < 0 < y)


SPIKE = hull([(0, 0, 0), *[(x, y, 1.0) for x in (-0.3, 0.3) for y in (-0.3, 0.3)]], name="spike")


@pytest.mark.parametrize("turn", TURNS)
def test_a_tip_on_the_inner_corner_of_an_angle_passes_where_it_passes_the_parts_of_the_angle(turn):
    whole = [upright(WHOLE, -1, 0, name="floor"), SPIKE]
    parts = [*(box((*a, -1), (*b, 0), name=f"floor{k}") for k, (a, b) in enumerate(QUADRANTS)), SPIKE]
    # Down towards the solid it is stopped, past the notch and up it is not.
    for velocity, stopped in (
        ((0.97, 0, -0.25), True), ((-0.5, -0.6, -0.2), True), ((-1, 1, -0.1), False), ((0.3, 0.2, 1), False),
    ):  # fmt: skip
        assert told(whole, 1, turn, velocity=velocity) is stopped
    for velocity in np.random.default_rng(1).normal(size=(12, 3)):
        assert told(whole, 1, turn, velocity=velocity) is told(parts, 3, turn, velocity=velocity)


NOSE = hull([(0, 0, 0), *[(x, y, z) for x in (1, 4) for y in (0, 1) for z in (-0.5, 0.5)]], name="nose")
FLOOR = box((1, 0, -1), (4, 1, -0.5), name="floor")


def at_a_crease(cut):
    """A nose at the lower end of the crease of an angle, beside a face of it with which it has a joint."""
    outline = [(-1, -1), (4, -1), (4, 0), (0, 0), (0, 1), (-1, 1)]
    halves = [box((-1, -1, 0), (0, 1, 1), name="stop"), box((0, -1, 0), (4, 0, 1), name="side")]
    return [*(halves if cut else [upright(outline, 0, 1, name="angle")]), FLOOR, NOSE]


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("cut", [False, True])
def test_the_end_of_a_crease_stops_a_nose_that_has_a_joint_with_one_of_its_sides(cut, turn):
    blocks = at_a_crease(cut)
    for velocity, stopped in (
        ((-0.95, 0, -0.32), True), ((-0.95, 0.1, 0), True), ((1, 0.1, 0), False), ((-0.1, 0, -1), False),
    ):  # fmt: skip
        assert told(blocks, len(blocks) - 1, turn, velocity=velocity) is stopped
    # Forces at the nose along either extreme normal hold the block: it must not be said to fall.
    options = {"supports": list(range(len(blocks) - 1)), "friction": 0.2}
    pushed = turn.apply([-5.0, 0, -9.81])
    assert assess(assembly(turned(blocks, turn), gravity=tuple(pushed), **options)).outcome is Outcome.UNDECIDED
    stands = turn.apply([-1.0, 0, -9.81])
    assert assess(assembly(turned(blocks, turn), gravity=tuple(stands), **options)).outcome is Outcome.STABLE


def ridge(low, high, name):
    return hull([(x, y, z) for x in (low, high) for y, z in ((0, 0), (-0.4, -0.4), (0.4, -0.4))], name=name)


KNIFE = hull([(x, y, z) for x in (-1, 1) for y, z in ((0, 0), (-0.4, 0.4), (0.4, 0.4))], name="knife")


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("cuts", [(), (0.3,)])
def test_edges_along_each_other_pass_where_they_do_so_all_along(cuts, turn):
    # Faces at 45 degrees: the knife sinks by d past an edge from which it parts by more than d sideways.
    places = [-1.5, *cuts, 1.5]
    blocks = [*(ridge(a, b, f"ridge{k}") for k, (a, b) in enumerate(zip(places[:-1], places[1:], strict=True))), KNIFE]

    def stops(**motion):
        return told(blocks, len(blocks) - 1, turn, **motion)

    assert not stops(velocity=(0, 1, -0.5))
    assert stops(velocity=(0, 0.4, -0.5))
    # It turns about its middle: at both ends it parts, in the middle it is driven in.
    assert stops(velocity=(0, 0, -0.1), rotation=(0, 0, 0.4))
    assert not stops(velocity=(0, 0, 0.1), rotation=(0, 0, 0.4))
    # It turns about x = 2, beyond the end: at x = 1 it parts by 0.4.
    assert not stops(velocity=(0, -0.8, -0.3), rotation=(0, 0, 0.4))
    assert stops(velocity=(0, -0.8, -0.5), rotation=(0, 0, 0.4))
