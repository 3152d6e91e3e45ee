"""Which contacts are found where blocks are no convex solids: notches, hooks, holes, edges beside patches, sheets."""

import numpy as np
import pytest

from blockstat import Block, JointLaw, assess, find_interfaces
from blockstat.analysis.verdict import Outcome
from blockstat.contact.features import ContactKind
from evidence.scenes.small import assembly, box
from tests.point_bodies import EVERYWHERE, FLOOR, agrees, hull, limit, placed, prism

#: Two arms of one height on a bar, and the same with a ridge in place of the second arm.
ARMS = [(0, 0), (4, 0), (4, 2), (3, 2), (3, 1), (1, 1), (1, 2), (0, 2)]
ARM_AND_RIDGE = [(0, 0), (4, 0), (4, 1), (3.5, 2), (3, 1), (1, 1), (1, 2), (0, 2)]


TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def found(blocks, supports=(0,), **place):
    """The interfaces of a scene, and its blocks."""
    scene, _ = placed(blocks, list(supports), **place)
    return find_interfaces(scene), scene


@EVERYWHERE
def test_a_block_on_the_arms_of_a_fork_rests_on_both(place, flip):
    blocks = [prism(ARMS, 0, 1, name="fork"), box((0.5, 0, 2), (3.5, 1, 4), name="body")]
    contacts, scene = found(blocks, [1 if flip else 0], place=place, flip=flip)
    assert contacts.kinds.tolist() == [ContactKind.FACE]
    assert contacts.area[0] == pytest.approx(2 * 0.5 * (scene.volume[0 if flip else 1] / 6) ** (2 / 3))
    # It tips about the outer ends of the joint: half of 3 over half of 2.
    agrees(limit(blocks, [0], (1, 0, 0), place=place, flip=flip, friction=9.0), 1.5)


@EVERYWHERE
def test_an_edge_in_the_plane_of_a_patch_is_part_of_it(place, flip):
    blocks = [prism(ARM_AND_RIDGE, 0, 1, name="fork"), box((0, 0, 2), (4, 1, 4), name="body")]
    contacts, _ = found(blocks, [1 if flip else 0], place=place, flip=flip)
    assert contacts.kinds.tolist() == [ContactKind.FACE]
    # The centroid is 1.5 from the ridge, 2 from the far end of the arm, and 1 above both.
    agrees(limit(blocks, [0], (1, 0, 0), place=place, flip=flip, friction=9.0), 1.5)
    agrees(limit(blocks, [0], (-1, 0, 0), place=place, flip=flip, friction=9.0), 2.0)


@EVERYWHERE
def test_an_edge_beside_a_patch_is_a_contact_of_its_own(place, flip):
    step = prism([(0, -1), (4, -1), (4, 0.5), (2, 0.5), (2, 0), (0, 0)], 0, 1, name="step")
    body = prism([(0, 0), (1, 0), (1, 1), (2.5, 1), (3, 0.5), (3.5, 1), (3.5, 3), (0, 3)], 0, 1, name="body")
    contacts, _ = found([step, body], [1 if flip else 0], place=place, flip=flip)
    assert sorted(contacts.kinds.tolist()) == [ContactKind.FACE, ContactKind.EDGE]
    # It tips about the edge; the foot lifts by 2 where it moves aside by .5, so friction up to 4 does not hold it.
    x, z = assembly([body]).centroid[0, [0, 2]]
    agrees(limit([step, body], [0], (1, 0, 0), place=place, flip=flip, friction=2.0), (3 - x) / (z - 0.5))


def hook(shift):
    """A hook on a fixed knife edge at x = 0, its hanging part moved sideways."""
    knife = prism([(-0.2, -0.5), (0.2, -0.5), (0, 0)], 0, 1, name="knife")
    x = shift
    body = [(-0.3, 0), (0.6, 0), (0.6, -2), (x - 0.4, -2), (x - 0.4, -3), (0.9, -3), (0.9, 0.3), (-0.3, 0.3)]
    return [knife, prism(body, 0, 1, name="hook")]


@EVERYWHERE
def test_a_hook_hangs_on_a_knife_edge(place, flip):
    # A line of contact holds it only where its centroid is below: at the width of the foot that puts it at x = 0.
    low, high = -3.0, 0.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if assembly([hook(middle)[1]]).centroid[0, 0] < 0 else (low, middle)
    contacts, _ = found(hook(high), [1 if flip else 0], place=place, flip=flip)
    assert contacts.kinds.tolist() == [ContactKind.EDGE]
    for shift, outcome in ((high, Outcome.STABLE), (high + 0.01, Outcome.UNSTABLE), (high - 0.01, Outcome.UNSTABLE)):
        scene, _ = placed(hook(shift), [0], place=place, flip=flip)
        assert assess(scene).outcome is outcome


def slab_with_a_hole():
    """A slab 4 x 4 x 1 with a square hole 2 x 2, its top and bottom in four faces each."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    rings = [(2, 0), (1, 0), (2, -1), (1, -1)]  # outer and inner ring above, outer and inner ring below
    vertices = [(*(r * corner), z) for r, z in rings for corner in square]
    faces = []
    for i in range(4):
        j = (i + 1) % 4
        faces += [[i, j, 4 + j, 4 + i], [8 + j, 8 + i, 12 + i, 12 + j], [8 + i, 8 + j, j, i]]
        faces += [[4 + i, 4 + j, 12 + j, 12 + i]]
    return Block(vertices, faces, name="slab")


@EVERYWHERE
def test_a_face_with_a_hole_in_several_faces(place, flip):
    supports = [1 if flip else 0]
    lid = box((-1.5, -1.5, 0), (1.5, 1.5, 1), name="lid")
    contacts, scene = found([slab_with_a_hole(), lid], supports, place=place, flip=flip)
    assert contacts.kinds.tolist() == [ContactKind.FACE]
    assert contacts.area[0] == pytest.approx((9 - 4) * (scene.volume[0 if flip else 1] / 9) ** (2 / 3))
    agrees(limit([slab_with_a_hole(), lid], [0], (1, 0, 0), place=place, flip=flip, friction=9.0), 3.0)

    def spike(x, y):
        return hull([(x, y, 0), (x - 1, y - 1, 2), (x + 1, y - 1, 2), (x + 1, y + 1, 2), (x - 1, y + 1, 2)])

    # Inside the hole is nothing; on the line between two faces, and on one of them, is one corner.
    for at, kinds in (((0.5, 0.2), []), ((1.5, 1.5), [ContactKind.CORNER]), ((1.5, 0.0), [ContactKind.CORNER])):
        contacts, _ = found([slab_with_a_hole(), spike(*at)], supports, place=place, flip=flip)
        assert contacts.kinds.tolist() == kinds


@pytest.mark.parametrize("thick", [0.0005, 0.002, 0.005])
@pytest.mark.parametrize("half", [0.2, 0.5])
def test_edges_on_narrow_sheets_do_not_reach_through_them(thick, half):
    # Two keels on two slippery strips: the friction of the strips counts, not that of the floor.
    feet = [(-0.4, 0.3), (-0.3, 0), (-0.2, 0.3), (0.2, 0.3), (0.3, 0), (0.4, 0.3), (0.4, 0.9), (-0.4, 0.9)]
    body = prism([(x, z + thick) for x, z in feet], -0.5, 0.5, name="body")
    strips = [box((x - 0.05, -half, 0), (x + 0.05, half, thick), name=f"sheet{x}") for x in (-0.3, 0.3)]
    strips = [Block(s.vertices, s.faces, s.name, group="sheet") for s in strips]
    scene = assembly([FLOOR, *strips, body], joints=[JointLaw(("sheet", "*"), friction=0.1)], friction=0.8)
    assert [0, 3] not in find_interfaces(scene).pair.tolist()
    assert assess(scene, gravity=(0, 0.099, -1)).outcome is Outcome.STABLE
    assert assess(scene, gravity=(0, 0.101, -1)).outcome is Outcome.UNSTABLE


def fan(plan, heights):
    """A block on z = -1 whose top is at two heights: `heights` has the corners of each, and walls are between them."""
    corners, number = [], {}

    def at(name, z):
        if (name, z) not in number:
            number[name, z] = len(corners)
            corners.append((*plan[name], z))
        return number[name, z]

    low, high, tops = heights
    faces = [[at(k, -1) for k in low[::-1]], [at(k, 1) for k in high], *([at(k, 0) for k in top] for top in tops)]
    for ring, bottom, top in ((low, -1, 0), (high, 0, 1)):
        faces += [
            [at(a, bottom), at(b, bottom), at(b, top), at(a, top)]
            for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
        ]
    return Block(corners, faces, name="stepped")


PLAN = {"o": (0, 0), "e": (2, 0), "ne": (2, 2), "n": (0, 2), "nw": (-2, 2), "sw": (-2, -2), "s": (0, -2), "se": (2, -2)}


@EVERYWHERE
def test_a_corner_at_the_end_of_a_notch_slides_past_it(place, flip):
    """A prism beside a step. The side of the step goes on below it round the corner, where nothing is in the way.

    Pushed along that corner it slides at the coefficient of friction, as it does a little further on.
    """
    rings = ["o n nw sw s se e".split(), "o s se e ne".split(), ["o n nw sw s".split(), "ne e o".split()]]
    step = fan(PLAN, rings)
    for moved in (0.0, 0.1):
        body = [(x - moved, y - moved, z) for z in (0, 1) for x, y in ((0, 0), (-1, 1), (-1, 0))]
        blocks = [step, Block(body, [[2, 1, 0], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]], name="body")]
        contacts, _ = found(blocks, [1 if flip else 0], place=place, flip=flip)
        assert ContactKind.CORNER not in contacts.kinds
        agrees(limit(blocks, [0], (-0.01, -1, 0), place=place, flip=flip, friction=0.3), 0.3)


@EVERYWHERE
def test_a_tip_in_the_end_of_a_notch_may_leave_it_round_the_corner(place, flip):
    """It moves back through the plane of the side of the notch where this has ended, so no one normal holds it."""
    rings = ["o n nw sw s se e".split(), "o s se e ne".split(), ["o n nw sw s".split(), "ne e o".split()]]
    tip = Block([(0, 0, 0), (1, 0.6, -0.3), (1, 0.3, -0.3), (1, 0.4, -0.6)], TETRAHEDRON, name="tip")
    contacts, _ = found([fan(PLAN, rings), tip], [1 if flip else 0], place=place, flip=flip)
    assert not len(contacts.kinds)


def corner_of_a_room():
    """A cube from -1 to 4 without its part from the origin on, where three notches meet."""
    rings = [
        [(-1, -1, -1), (-1, -1, 4), (-1, 4, 4), (-1, 4, -1)],
        [(4, -1, -1), (4, 4, -1), (4, 4, 0), (4, 0, 0), (4, 0, 4), (4, -1, 4)],
        [(0, 0, 0), (0, 4, 0), (0, 4, 4), (0, 0, 4)],
    ]
    turns = [np.roll(np.array(ring), k, axis=1) for ring in rings for k in range(3)]  # x, y and z change places
    corners, where = np.unique(np.concatenate(turns), axis=0, return_inverse=True)
    faces = np.split(where.ravel(), np.cumsum([len(turn) for turn in turns])[:-1])
    return Block(corners.astype(float), [face.tolist() for face in faces], name="room")


@EVERYWHERE
@pytest.mark.parametrize("lean", [0.2, 0.0])
def test_a_tip_in_the_corner_of_a_room_touches_its_floor_and_both_walls(place, flip, lean):
    room = corner_of_a_room()
    tip = Block([(0, 0, 0), (2, lean, lean), (lean, 2, lean), (lean, lean, 2)], TETRAHEDRON, name="tip")
    contacts, _ = found([room, tip], [1 if flip else 0], place=place, flip=flip)
    assert (contacts.kinds == (ContactKind.CORNER if lean else ContactKind.FACE)).all()
    assert len(contacts.kinds) == 3


@EVERYWHERE
@pytest.mark.parametrize("turn", [0.0, 0.5, 1.0])
def test_a_tip_touches_a_corner_of_the_mesh_of_a_floor(place, flip, turn):
    """The tip is above one triangle of the floor, or two."""
    around = [(2.0, 0.0), (0.0, 2.0), (-2.0, 0.0), (0.0, -2.0)]
    floor = [*((x, y, -1) for x, y in around), *((x, y, 0) for x, y in around), (0.0, 0.0, 0.0)]
    sides = [[i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4] for i in range(4)]
    block = Block(floor, [[3, 2, 1, 0], *sides, *([i + 4, (i + 1) % 4 + 4, 8] for i in range(4))], name="floor")
    c, s = np.cos(turn), np.sin(turn)
    top = [(c * x - s * y, s * x + c * y, z) for x, y, z in ((1, 0.1, 0.5), (1, 0.3, 0.5), (1, 0.2, 0.8))]
    tip = Block([(0, 0, 0), *top], TETRAHEDRON, name="tip")
    contacts, _ = found([block, tip], [1 if flip else 0], place=place, flip=flip)
    assert contacts.kinds.tolist() == [ContactKind.CORNER]


#: A prism whose base is one triangle of the top of a support: where GEOS cuts one by the other it finds nothing in
#: common, in one order of the two.
SHARED = [
    (-0.00973482742349948, 1.1836866684326686, 0.5942901714809082),
    (0.6121962260498349, 0.658963540658574, 0.572553927581014),
    (1.30035727782971, 1.1949616754577643, 0.39687642948571206),
]
ABOVE = [
    (-0.08773611204931439, 1.3099485209333548, 1.3625801246174456),
    (0.53419494142402, 0.7852253931592602, 1.3408438807175511),
    (1.222355993203895, 1.3212235279584505, 1.1651663826222494),
]
BEYOND = [
    (1.2341272795231695, 0.13424041288447938, 0.5508176836811196),
    (1.9222883313030443, 0.6702385476836697, 0.37514018558581774),
    (2.5442193847763788, 0.14551541990957512, 0.35340394168592343),
    (2.610449383082919, 1.20623668248286, 0.19946268749051596),
]
BELOW = [
    (0.06622999830654043, 1.060721262573285, -0.15394125419540752),
    (0.6881610517798749, 0.5359981347991903, -0.17567749809530186),
    (1.3100921052532093, 0.011275007025095728, -0.19741374199519618),
    (1.9982531570330841, 0.5472731418242861, -0.37309124009049804),
    (2.6201842105064186, 0.022550014050191455, -0.39482748399039236),
    (2.686414208812959, 1.0832712766234764, -0.5487687381857999),
]


@pytest.mark.parametrize("turned_round", [False, True])
def test_a_joint_on_a_part_of_a_concave_face_is_found_in_both_orders(turned_round):
    stone = Block(
        [*SHARED, *ABOVE],
        [[2, 0, 3, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [1, 0, 2], [5, 3, 4]],
        name="stone",
    )
    support_faces = [
        [7, 0, 2, 6, 12],
        [7, 8, 1, 0],
        [8, 9, 3, 1],
        [12, 10, 11, 9, 8, 7],
        [2, 0, 1],
        [3, 2, 1],
        [2, 3, 4],
        [6, 2, 4],
        [3, 5, 4],
        [10, 12, 6],
        [10, 6, 4],
        [9, 11, 5],
        [9, 5, 3],
        [11, 10, 4, 5],
    ]
    points = np.array([*SHARED, *BEYOND, *BELOW])
    support = Block(points, support_faces, name="support")
    blocks = [stone, support]
    contacts = find_interfaces(assembly(blocks[::-1] if turned_round else blocks, supports=["support"]))
    a, b, c = np.array(SHARED)
    assert contacts.area.sum() == pytest.approx(np.linalg.norm(np.cross(b - a, c - a)) / 2, rel=1e-9)
