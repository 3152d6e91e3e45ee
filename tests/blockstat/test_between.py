"""Blocks in the gap of a joint: the force goes through them, so their friction counts."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Block, JointLaw, Outcome, assess, find_interfaces
from blockstat.contact.between import held_apart
from blockstat.contact.coplanar import Patch, Patches
from evidence.scenes.small import assembly, box, prism, running_bond

BASE = box((-3, -3, -1), (3, 3, 0), name="base", group="base")
SLIPPERY = JointLaw(("sheet", "*"), friction=0.1)


def sheet(lower, upper, name="sheet"):
    return box(lower, upper, name=name, group="sheet")


def cube(bottom):
    return box((0, 0, bottom), (1, 1, 1 + bottom), name="cube", group="cube")


def tilted(blocks, degrees, **options):
    """Blocks on a slope with friction 0.7, and 0.1 on both sides of the sheets."""
    down = -np.array([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))])
    return assembly(blocks, friction=0.7, gravity=down, joints=[SLIPPERY], **options)


def joined(asm):
    found = find_interfaces(asm)
    pairs = {(asm.names[a], asm.names[b]) for a, b in found.pair}
    return pairs, [(asm.names[d.a], asm.names[d.b], d.reason) for d in found.dropped]


@pytest.mark.parametrize("width", [0.4, 1.0, 2.0])
@pytest.mark.parametrize("thickness", [1e-5, 5e-4, 2e-3, 5e-3])
def test_a_cube_on_a_slip_sheet_slides_at_the_friction_of_the_sheet(thickness, width):
    # tan 15 deg = .268 lies between the friction of the sheet and that of the stones; .1 = tan 5.71 deg.
    a, b = 0.5 - width / 2, 0.5 + width / 2
    blocks = [BASE, sheet((a, a, 0), (b, b, thickness)), cube(thickness)]
    pairs, dropped = joined(tilted(blocks, 15))
    assert pairs == {("base", "sheet"), ("sheet", "cube")}
    assert dropped == [("base", "cube", "between")]
    for degrees, outcome in ((15, Outcome.UNSTABLE), (5.8, Outcome.UNSTABLE), (5.6, Outcome.STABLE)):
        assert assess(tilted(blocks, degrees)).outcome is outcome


def test_pads_hold_two_blocks_apart():
    # The pads fill a part of the gap, and each lies only partly under the cube.
    pads = [sheet((x, y, 0), (x + 0.2, y + 0.2, 2e-3), f"pad{x}{y}") for x in (-0.1, 0.85) for y in (-0.1, 0.9)]
    asm = tilted([BASE, *pads, cube(2e-3)], 15)
    pairs, dropped = joined(asm)
    assert ("base", "cube") not in pairs
    assert len(pairs) == 8
    assert dropped == [("base", "cube", "between")]
    assert assess(asm).outcome is Outcome.UNSTABLE


def test_two_membranes_hold_two_blocks_apart():
    # Neither membrane touches both blocks.
    membranes = [sheet((-1, -1, k * 5e-4), (2, 2, (k + 1) * 5e-4), f"membrane{k}") for k in range(2)]
    pairs, dropped = joined(tilted([BASE, *membranes, cube(1e-3)], 15))
    assert pairs == {("base", "membrane0"), ("membrane0", "membrane1"), ("membrane1", "cube")}
    assert dropped == [("base", "cube", "between")]


def test_a_sheet_that_cannot_move_holds_blocks_apart_too():
    asm = tilted([BASE, sheet((-1, -1, 0), (2, 2, 5e-4)), cube(5e-4)], 15, supports=[0, 1])
    assert joined(asm) == ({("sheet", "cube")}, [("base", "cube", "between")])
    assert assess(asm).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1], [1, 2, 0], [2, 1, 0]])
def test_the_order_of_the_blocks_does_not_matter(order):
    blocks = [BASE, sheet((-1, -1, 0), (2, 2, 5e-4)), cube(5e-4)]
    pairs, _ = joined(tilted([blocks[i] for i in order], 15, supports=["base"]))
    assert {frozenset(pair) for pair in pairs} == {frozenset(("base", "sheet")), frozenset(("sheet", "cube"))}


def test_a_sheet_in_a_recess_leaves_the_joint_beside_it():
    # The cube stands on the base with one half, and with the other on a sheet that fills a recess.
    outline = [(-3, -1), (3, -1), (3, 0), (0.5, 0), (0.5, -5e-4), (-3, -5e-4)]
    base = prism(outline, 2.0, name="base", group="base")
    blocks = [base, sheet((-1, 0, -5e-4), (0.5, 1, 0)), cube(0)]
    asm = assembly(blocks)
    pairs, dropped = joined(asm)
    assert ("base", "cube") in pairs
    assert ("base", "cube", "between") in dropped
    found = find_interfaces(asm)
    own = (found.pair == [0, 2]).all(axis=1)
    assert found.area[own].tolist() == pytest.approx([0.5])


def test_an_open_head_joint_stays_beside_thin_blocks():
    # The slates touch both bricks, but do not stand in the gap between them.
    bricks = [box((0, 0, 0), (0.5, 0.2, 0.2), name="left"), box((0.502, 0, 0), (1, 0.2, 0.2), name="right")]
    slates = [
        box((0, 0, 0.2), (1, 0.2, 0.202), name="above"),
        box((0, 0.2, 0), (1, 0.202, 0.2), name="behind"),
    ]
    pairs, dropped = joined(assembly([BASE, *bricks, *slates]))
    assert ("left", "right") in pairs
    assert ("left", "right", "between") not in dropped


def test_rough_joints_of_real_walls_stay():
    # Every corner moves at random by up to a millimetre, so all joints are open or overlap a little.
    exact = running_bond(6, 6)
    noise = np.random.default_rng(3).uniform(-1e-3, 1e-3, exact.vertices.shape)
    rough = find_interfaces(exact.with_(vertices=exact.vertices + noise))
    assert rough.gap.max() > 1e-4
    assert [d for d in rough.dropped if d.reason == "between"] == []
    assert set(map(tuple, find_interfaces(exact).pair.tolist())) <= set(map(tuple, rough.pair.tolist()))


# The rule itself, on patches written down: 0 over 1, and others between them.

TURN = Rotation.from_rotvec([0.5, -0.8, 0.3]).as_matrix()
PLACE = np.array([3.0, -1.0, 2.0])
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]


def patch(pair, *, height=0.0, corners=SQUARE, gap=0.0, tilt=0.0, aside=0.0):
    """A patch at a height over the plane z = 0 whose normal, from the first block down to the second, may be tilted."""
    down = -1.0 if pair[0] < pair[1] or pair == (2, 1) or pair == (3, 1) else 1.0
    tilt = np.radians(tilt)
    normal = down * np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    frame = np.array([normal, [0, 1, 0], np.cross(normal, [0, 1, 0])])
    space = np.column_stack([np.array(corners, float) + [aside, 0.0], np.full(len(corners), height)])
    origin = np.array([0.3, 0.2, height])
    return Patch(np.array(pair), frame @ TURN.T, TURN @ origin + PLACE, 1.0, gap, (space - origin) @ frame[1:].T)


def blocks(support=(), thin=1.0):
    """Unit cubes, of which the third lies between z = 0 and a height; only sizes and heights of these count."""
    vertices, faces = np.asarray(box((0, 0, 0), (1, 1, 1)).vertices, float), box((0, 0, 0), (1, 1, 1)).faces
    found = []
    for k in range(4):
        own = vertices * ([1, 1, thin] if k == 2 else [1, 1, 1])
        found.append(Block(own @ TURN.T + PLACE, faces))
    return assembly(found, supports=list(support))


def leads(asked, joints, *, support=(1,), thin=1.0):
    empty = Patches(
        np.empty((0, 2), int), np.empty((0, 3, 3)), np.empty((0, 3)), np.empty(0), np.empty(0), np.empty((0, 2)),
        np.empty(0, int), np.empty(0),
    )  # fmt: skip
    listed = empty.with_more(joints) if joints else empty
    # Others are asked about too, before and after: each has its own answer.
    far = patch((0, 3), aside=50.0, gap=2e-3)
    rows = empty.with_more([far, asked, far])
    found = held_apart(blocks(support, thin), listed, rows, np.radians(15.0))
    assert not found[[0, 2]].any()
    return bool(found[1])


OPEN = patch((0, 1), gap=2e-3)


def test_two_joints_through_one_block_hold_a_gap_open():
    assert leads(OPEN, [patch((0, 2)), patch((2, 1))])
    assert leads(OPEN, [patch((2, 1)), OPEN, patch((0, 2))])
    assert leads(OPEN, [patch((0, 2)), patch((2, 3)), patch((3, 1))])
    assert leads(OPEN, [patch((0, 2)), patch((2, 1))], support=(0,))
    assert leads(OPEN, [patch((0, 2)), patch((2, 1))], support=())


def test_no_chain_that_ends_before_the_other_block_holds_a_gap_open():
    for joints in ([], [OPEN], [OPEN, patch((0, 2))], [OPEN, patch((2, 1))], [patch((0, 2)), patch((3, 1))]):
        assert not leads(OPEN, joints)
    assert not leads(OPEN, [patch((0, 2)), patch((2, 3))], support=())


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize(("height", "held"), [(2.9e-3, True), (3.1e-3, False), (-2.9e-3, True), (-3.1e-3, False)])
def test_joints_of_a_chain_lie_at_the_height_of_the_gap(which, height, held):
    # Two millimetres of the gap and one of the joint's own.
    joints = [patch((0, 2)), patch((2, 1))]
    joints[which] = patch([(0, 2), (2, 1)][which], height=height, gap=1e-3)
    assert leads(OPEN, joints) is held


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize(("aside", "held"), [(1 - 3e-3, True), (1 - 0.3e-3, False), (-1 + 3e-3, True), (1.5, False)])
def test_joints_beside_a_gap_do_not_hold_it_open(which, aside, held):
    joints = [patch((0, 2)), patch((2, 1))]
    joints[which] = patch([(0, 2), (2, 1)][which], aside=aside)
    assert leads(OPEN, joints) is held


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize(("tilt", "held"), [(14.5, True), (15.5, False), (-14.5, True), (-15.5, False), (180.0, False)])
def test_joints_of_a_chain_have_the_normal_of_the_gap(which, tilt, held):
    joints = [patch((0, 2)), patch((2, 1))]
    joints[which] = patch([(0, 2), (2, 1)][which], tilt=tilt, gap=1.0)
    assert leads(OPEN, joints) is held


@pytest.mark.parametrize("corners", [[(0.3, 0.2)], [(0.3, 0.2), (0.3, 0.9)]])
def test_edges_and_corners_hold_a_gap_open_where_they_lie_over_it(corners):
    end = 1 - max(x for x, _ in corners)
    for aside, held in ((0.0, True), (end + 0.5e-6, True), (end + 3e-6, False)):
        joints = [patch((0, 2), corners=corners, aside=aside), patch((2, 1), corners=corners, aside=aside)]
        assert leads(OPEN, joints) is held
        # And patches hold open an edge or a corner that lies over them.
        asked = patch((0, 1), corners=corners, aside=aside, gap=2e-3)
        assert leads(asked, [patch((0, 2)), patch((2, 1))]) is held


def test_a_gap_of_rounding_has_no_room_for_a_block():
    joints = [patch((0, 2)), patch((2, 1))]
    assert not leads(patch((0, 1), gap=0.9e-9), joints)
    assert leads(patch((0, 1), gap=1.1e-9), joints)


@pytest.mark.parametrize("thin", [1.9e-3, 2.1e-3])
@pytest.mark.parametrize("support", [(1, 2), (1,), (2,), (0, 2)])
def test_a_support_in_a_gap_over_another_needs_no_joint_with_it_if_it_is_thin(thin, support):
    own = patch((0, 2)) if 0 not in support else patch((2, 1))
    expected = thin < 2e-3 and support in ((1, 2), (0, 2))
    assert leads(OPEN, [own], support=support, thin=thin) is expected


def test_the_other_order_of_two_blocks_is_the_same_gap():
    asked = patch((1, 0), gap=2e-3)
    assert leads(asked, [patch((0, 2)), patch((2, 1))])
    assert not leads(asked, [patch((0, 2)), patch((2, 1), height=0.01)])


def test_a_post_through_a_support_leaves_the_joint_around_it():
    # A post and a floor, both fixed, that run into each other: the cube rests on the post and, nearly, on the floor.
    for bottom, reason in ((-1.0, []), (0.0, [("base", "cube", "between")])):
        asm = assembly([BASE, sheet((0.2, 0.3, bottom), (0.4, 0.6, 5e-4), "post"), cube(5e-4)], supports=[0, 1])
        pairs, dropped = joined(asm)
        assert ("post", "cube") in pairs
        assert (("base", "cube") in pairs) == (not reason)
        assert dropped == reason
