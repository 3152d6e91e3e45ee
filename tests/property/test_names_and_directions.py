"""Laws by the names of groups, directions by their signs, blocks in any order: against a plain reading of each."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from blockstat import Block, JointLaw, find_interfaces, limit_load, thrust_range, tilt_limit
from blockstat.contact.point_law import joint_friction, laws_of
from blockstat.joint import fits
from evidence.scenes.small import arch, assembly, box

FEW = settings(max_examples=25, deadline=None)
#: Names that begin alike, end alike and hold each other.
PART = st.text("ab1", min_size=1, max_size=3)
GROUP = st.lists(PART, min_size=1, max_size=3).map(".".join)
UNIT = st.floats(0, 2 * np.pi)


def is_part(name, group):
    """Whether a group is one of a name or lies below it, part by part."""
    if name == "*":
        return True
    name, group = name.split("."), group.split(".")
    return group[: len(name)] == name


@settings(max_examples=300, deadline=None)
@given(GROUP | st.just("*"), GROUP)
def test_a_name_means_a_group_and_its_parts(name, group):
    assert fits(name, group) == is_part(name, group)


@FEW
@given(st.lists(GROUP, min_size=3, max_size=6), st.data())
def test_the_last_law_that_fits_a_joint_counts_whichever_way_it_names_the_groups(groups, data):
    # A row of blocks on a slab: joints of each with the slab, and of neighbours.
    blocks = [box((-1, -1, -1), (9, 2, 0), group=groups[0])]
    blocks += [box((k, 0, 0), (k + 1, 1, 1), group=group) for k, group in enumerate(groups[1:])]
    known = sorted({".".join(g.split(".")[: k + 1]) for g in groups for k in range(g.count(".") + 1)})
    one_of = st.sampled_from(["*", *known])
    pairs = data.draw(st.lists(st.tuples(one_of, one_of), min_size=1, max_size=4))
    laws = [JointLaw(pair, friction=0.1 * (k + 1)) for k, pair in enumerate(pairs)]
    asm = assembly(blocks, joints=laws, friction=0.9)
    faces = find_interfaces(asm)
    expected = []
    for a, b in faces.pair:
        first, second = groups[a], groups[b]
        fitting = [
            law.friction
            for law in laws
            if (is_part(law.between[0], first) and is_part(law.between[1], second))
            or (is_part(law.between[1], first) and is_part(law.between[0], second))
        ]
        expected.append(fitting[-1] if fitting else 0.9)
    np.testing.assert_array_equal(joint_friction(asm, faces), expected)
    assert len(laws_of(asm, faces)) == len(laws)


#: How far a base reaches from the axis to either side: it tips over each side at a push of its own.
SIDES = {"x": (0.3, 0.7), "y": (0.2, 0.4)}


@FEW
@given(UNIT)
def test_a_push_in_any_direction_tips_over_the_side_that_it_points_to(angle):
    # A pyramid 4 high, its centroid 1 above the base. Pushed along d it tips about the side at which the resultant
    # leaves the base: lambda = min over the axes of arm / |d| over the height of the centroid.
    (west, east), (south, north) = SIDES["x"], SIDES["y"]
    points = [(sx, sy) for sx in (-west, east) for sy in (-south, north)]
    base = [(x, y, 0.0) for x, y in points]
    corners = [base[0], base[2], base[3], base[1], (0.0, 0.0, 4.0)]
    pyramid = Block(corners, [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    asm = assembly([box((-3, -3, -1), (3, 3, 0)), pyramid], friction=9.0)
    x, y, z = asm.centroid[1]
    assert z == pytest.approx(1.0)
    d = np.array([np.cos(angle), np.sin(angle)])
    assume(np.abs(d).min() > 1e-3)
    arms = [(east - x if d[0] > 0 else west + x) / abs(d[0]), (north - y if d[1] > 0 else south + y) / abs(d[1])]
    found = limit_load(asm, (*d, 0.0))
    assert found.lower == pytest.approx(min(arms) / z, rel=1e-3)
    assert found.upper == pytest.approx(min(arms) / z, rel=1e-3)
    tilted = tilt_limit(asm, (-d[1], d[0], 0.0))  # about -y gravity leans towards +x
    opposite = limit_load(asm, (-d[0], -d[1], 0.0))
    assert np.tan(np.radians(tilted.stands)) == pytest.approx(opposite.lower, rel=2e-3)


@settings(max_examples=6, deadline=None)
@given(st.permutations(range(7)), st.floats(-1, 1), st.floats(-1, 1))
def test_thrusts_do_not_depend_on_the_order_of_the_blocks(order, x, z):
    assume(abs(x) + abs(z) > 0.1)
    asm = arch(5, 0.3)
    blocks = [Block(asm.block_vertices(i), asm.faces_of(i), asm.names[i]) for i in order]
    other = assembly(blocks, supports=["left", "right"])
    for name in ("left", "right"):
        one, two = (thrust_range(scene, [name], (x, 0, z)) for scene in (asm, other))
        assert (one.least, one.greatest) == pytest.approx((two.least, two.greatest), rel=1e-6, abs=1e-8)
        back = thrust_range(other, [name], (-x, 0, -z))
        assert (back.least, back.greatest) == pytest.approx((-one.greatest, -one.least), rel=1e-6, abs=1e-8)
