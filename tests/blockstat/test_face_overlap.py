"""Contact points of joints at displaced poses: overlaps of faces, crossings of their edges, and the closing of gaps."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from blockstat import Block, JointLaw, capacity, find_interfaces, settle_to_collapse
from blockstat.large_displacement.displaced.contact_pairs import edge_crossings, gaps, pair_points, pairs_at_rest
from blockstat.large_displacement.displaced.loads import read_loads
from blockstat.large_displacement.displaced.pose import Pose, displaced_points
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.finite_steps.contact_projection import projected_onto_zero_gap
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.overlap.face_overlap import overlap_points, with_overlap_points
from evidence.scenes.small import assembly, box, prism


def piles():
    """A box, a hexagonal prism and a long box, each alone on the ground."""
    hexagon = [(6 + np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3]
    lying = prism(hexagon, 2.0)
    upright = np.asarray(lying.vertices)[:, [0, 2, 1]] * (1, 1, -1) + (0, 0, 2)
    return assembly(
        [
            box((-5, -5, -1), (15, 5, 0), name="ground"),
            box((0, 0, 0), (2, 1, 1), name="box"),
            type(lying)(upright, lying.faces, name="hexagon"),
            box((10, -4, 0), (11, 4, 1), name="long"),
        ],
        supports=[0],
    )


def structure_of(scene):
    return Structure(
        scene, find_interfaces(scene), read_loads(scene, None), None, "auto", np.zeros((scene.n_blocks, 6))
    )


def turned(scene, seed, *, far=()):
    """A pose in which each free block has turned about its vertical axis and slid; some by far."""
    random = np.random.default_rng(seed)
    vectors, moved = np.zeros((scene.n_blocks, 3)), np.zeros((scene.n_blocks, 3))
    vectors[1:, 2] = random.uniform(-1, 1, scene.n_blocks - 1)
    moved[1:, :2] = random.uniform(-0.5, 0.5, (scene.n_blocks - 1, 2))
    moved[list(far), 1] = 40.0
    return Pose(Rotation.from_rotvec(vectors).as_matrix(), moved)


@pytest.mark.parametrize("seed", range(4))
def test_the_points_of_joints_that_slid_are_the_corners_of_what_their_faces_share(seed):
    scene = piles()
    structure, pose = structure_of(scene), turned(scene, seed)
    contacts = pairs_at_rest(scene, structure.interfaces)
    joints = np.arange(structure.interfaces.n_interfaces)
    assert len(joints) == 3
    found = overlap_points(structure, contacts, joints[::-1], pose, 0.0)
    assert (np.diff(found.joint) <= 0).all()
    points = pair_points(scene, found, pose, 0.0)
    np.testing.assert_allclose(points[:, 0], points[:, 1], atol=1e-12)  # all faces are still in the plane of the ground
    ground = shapely.box(-5, -5, 15, 5)
    for joint in joints:
        block = int(structure.interfaces.pair[joint].max())
        corner = scene.vertices[(scene.vertex_block == block) & (np.abs(scene.vertices[:, 2]) < 1e-9)]
        now = displaced_points(scene, pose, np.full(len(corner), block), corner)
        shared = shapely.MultiPoint(now[:, :2]).convex_hull.intersection(ground)
        own = shapely.MultiPoint(points[found.joint == joint, 0, :2])
        assert len(own.geoms) == len(shared.exterior.coords) - 1
        assert own.convex_hull.symmetric_difference(shared).area < 1e-9


def test_a_face_that_has_left_its_bearing_shares_nothing():
    scene = piles()
    structure, pose = structure_of(scene), turned(scene, 0, far=[2])
    contacts = pairs_at_rest(scene, structure.interfaces)
    gone = int(np.flatnonzero((structure.interfaces.pair == 2).any(axis=1))[0])
    merged = with_overlap_points(structure, contacts, np.arange(3), pose, 0.0)
    assert gone not in merged.joint
    assert set(merged.joint) == {0, 1, 2} - {gone}
    assert (np.diff(merged.joint) >= 0).all()
    assert overlap_points(structure, contacts, np.arange(0), pose, 0.0).number == 0


def test_points_of_crossing_edges_are_the_nearest_ones_of_both():
    """The long box reaches over both edges of the ground: each crossing is where the two edges are nearest."""
    narrow = box((-1, -1, -1), (1, 1, 0), name="narrow")
    scene = assembly([narrow, box((-0.5, -3, 0), (0.5, 3, 1), name="long")], supports=[0])
    structure = structure_of(scene)
    contacts = pairs_at_rest(scene, structure.interfaces)
    assert not contacts.corner.any()
    vectors = np.array([[0, 0, 0], [0.02, 0.03, 0.4]])
    pose = Pose(Rotation.from_rotvec(vectors).as_matrix(), np.array([[0, 0, 0], [0.05, 0.1, 0.2]]))
    points = pair_points(scene, contacts, pose, 0.0)
    nearest, across = edge_crossings(contacts, pose, points)
    for row in range(contacts.number):
        edges = [pose.rotation[contacts.pair[row, k]] @ contacts.edge[row, k] for k in (0, 1)]
        apart = points[row, 1] - points[row, 0]
        step = np.linalg.lstsq(np.column_stack([edges[0], -edges[1]]), apart, rcond=None)[0]
        for side in (0, 1):
            np.testing.assert_allclose(nearest[row, side], points[row, side] + step[side] * edges[side], atol=1e-12)
        between = nearest[row, 1] - nearest[row, 0]
        np.testing.assert_allclose(np.cross(between, across[row]), 0, atol=1e-12)
        assert gaps(scene, contacts, pose, 0.0)[row] == pytest.approx(between @ across[row], abs=1e-12)


@pytest.mark.parametrize("size", [1e-9, 1e-4])
def test_blocks_that_overlap_on_all_sides_are_moved_by_no_more_than_the_overlap(size):
    """Three cubes in a trough that is too narrow by `size`: no motion is inside all inequalities."""
    blocks = [box((0, 0, -1), (5, 1, 0)), box((0, 0, 0), (1, 1, 1)), box((4, 0, 0), (5, 1, 1))]
    blocks += [box((k, 0, 0), (k + 1, 1, 1), name=f"cube{k}") for k in (1, 2, 3)]
    scene = assembly(blocks, supports=[0, 1, 2])
    structure = structure_of(scene)
    contacts = pairs_at_rest(scene, structure.interfaces)
    closed = np.ones(contacts.number, dtype=bool)
    linkage = Linkage(structure, contacts, ~closed, closed, np.arange(0), np.arange(0), None)
    moved = np.zeros((scene.n_blocks, 3))
    moved[2, 0] = -size  # the right side of the trough has moved in
    moved[3, 2] = 10 * size  # and a cube is off the ground
    pose = Pose(np.tile(np.eye(3), (scene.n_blocks, 1, 1)), moved)
    found = projected_onto_zero_gap(linkage, pose, 0.0, 1.0, None, 0.0)
    assert found.residual_gap.max() <= size
    assert np.linalg.norm(found.pose.displacement[3:], axis=1).max() <= 2 * size


ALONG = (1, 0, 0)


def upright(plan, height, **options):
    """A prism on the ground with an outline in x and y, counter-clockwise seen from above."""
    n = len(plan)
    corners = [(x, y, z) for z in (0, height) for x, y in plan]
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return Block(np.array(corners, dtype=float), [list(range(n))[::-1], list(range(n, 2 * n)), *sides], **options)


def on_ground_to(end, block, **options):
    """A block on a ground that ends at x = `end`."""
    return assembly([box((-3, -3, -1), (end, 4, 0), name="ground"), block], **options)


def on_two_feet():
    """1 m long and deep, on feet .2 m long."""
    return prism([(0, 0), (0.2, 0), (0.2, 0.2), (0.8, 0.2), (0.8, 0), (1, 0), (1, 0.3), (0, 0.3)], 1.0, name="block")


def u_of_three():
    """Its face is no convex polygon: two arms .2 m wide, joined at their far ends."""
    return upright([(0, 0), (1, 0), (1, 0.2), (0.2, 0.2), (0.2, 0.8), (1, 0.8), (1, 1), (0, 1)], 0.3, name="block")


@pytest.mark.parametrize(("block", "shift", "area"), [
    (on_two_feet, 0.15, 0.3), (on_two_feet, 0.3, 0.2), (on_two_feet, 1.0, 0.05), (on_two_feet, 2.0, 0.0),
    (u_of_three, 0.15, 0.2 + 2 * 0.7 * 0.2), (u_of_three, 0.95, 0.1), (u_of_three, 2.0, 0.0),
])  # fmt: skip
def test_a_void_between_two_feet_is_no_contact(block, shift, area):
    """Feet and arms are on the ground as far as that reaches, to x = 1.05; a hull would span what is between them."""
    scene = on_ground_to(1.05, block())
    structure = structure_of(scene)
    pose = Pose(np.array([np.eye(3)] * 2), np.array([[0, 0, 0], [shift, 0, 0]]))
    contacts = pairs_at_rest(scene, structure.interfaces)
    assert contacts.area.sum() == pytest.approx(0.4 if block is on_two_feet else 0.2 + 2 * 0.8 * 0.2)
    found = overlap_points(structure, contacts, np.arange(1), pose, 0.0)
    assert found.area.sum() == pytest.approx(area, abs=1e-9)
    face = scene.block_vertices(1)
    flat = [(x, y) for x, y, z in face[np.abs(face[:, 2]) < 1e-9]]
    if block is on_two_feet:
        feet = [shapely.box(x, 0, x + 0.2, 1) for x in (0.0, 0.8)]
        shape = shapely.union_all(feet)
    else:
        shape = shapely.Polygon(flat)
    shared = shapely.affinity.translate(shape, shift).intersection(shapely.box(-3, -3, 1.05, 4))
    if shared.area > 0:
        points = pair_points(scene, found, pose, 0.0)[:, 0, :2]
        hull = shapely.MultiPoint(points).convex_hull
        depth = 0.0 if block is u_of_three else hull.bounds[1]
        moved = shapely.affinity.translate(hull, 0, -depth)
        assert moved.symmetric_difference(shared.convex_hull).area < 1e-9
        # Uniform stress has its resultant at the centroid of what touches.
        centre = found.area @ points / found.area.sum()
        np.testing.assert_allclose(centre - (0, depth), np.ravel(shared.centroid.xy), atol=1e-9)


def test_a_block_on_two_feet_tips_when_the_front_one_is_off_the_ground():
    """Its centroid is at .5, between the feet: it slides until the front foot is off, after .25, and tips into the
    void, as the rear foot ends at .45 then."""
    curve = capacity(on_ground_to(1.05, on_two_feet(), friction=0.3), ALONG, displacement=0.4)
    assert curve.outcome.word == "collapse"
    assert curve.displacement[-1] == pytest.approx(0.25, abs=1e-5)
    np.testing.assert_allclose(curve.lower, 0.3, rtol=1e-6)


def test_a_foot_that_is_almost_off_the_ground_still_counts():
    """Of the front one 2 micrometres are on it, .25 m of the way being known."""
    scene = on_ground_to(1.05, on_two_feet())
    structure = structure_of(scene)
    pose = Pose(np.array([np.eye(3)] * 2), np.array([[0, 0, 0], [0.25 - 2e-6, 0, 0]]))
    found = overlap_points(structure, pairs_at_rest(scene, structure.interfaces), np.arange(1), pose, 0.0)
    assert pair_points(scene, found, pose, 0.0)[:, 0, 0].max() == pytest.approx(1.05, abs=1e-9)


L_BED = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
C_BED = [(0, 0), (5, 0), (5, 4), (4, 4), (4, 1), (1, 1), (1, 4), (0, 4)]
#: Slabs along the sides of notches, .8 m on the bed and .4 m beyond y = 1; half of .3 m below their centroids.
BESIDE = {"one side": (L_BED, 3.0), "two sides": (C_BED, 4.0)}


def beside(case, **options):
    bed, end = BESIDE[case]
    block = Block(upright(bed, 0.5).vertices - (0, 0, 0.5), upright(bed, 0.5).faces, "bed")
    return assembly([block, box((1, 0.2, 0), (end, 1.4, 0.3), name="slab")], **options)


@pytest.mark.parametrize("case", BESIDE)
@pytest.mark.parametrize("off", [0.0, 1e-6, 2e-5, 1e-3])
@pytest.mark.parametrize("turn", [0.0, 0.4, 1.1, 2.3])
def test_an_edge_along_a_notch_bears_nothing_for_as_much_as_places_are_off(case, off, turn):
    """The slab has slid by .3 m along the notch, and is turned in plan so that its sides are over those by `off`.

    Motions are known to a ten thousandth of their way: 30 micrometres.
    """
    scene = beside(case)
    structure = structure_of(scene)
    middle = np.array([scene.centroid[1, 0], 1.0, 0.0])
    about = Rotation.from_rotvec([0, 0, off / 0.7]).as_matrix()  # the end of a side, at y = 1.7, goes by `off`
    place = middle + about @ (scene.centroid[1] + [0, 0.3, 0] - middle) - scene.centroid[1]
    whole = Rotation.from_rotvec([turn, -turn, turn]).as_matrix()
    scene = scene.with_(vertices=scene.vertices @ whole.T)
    structure = structure_of(scene)
    contacts = pairs_at_rest(scene, structure.interfaces)
    pose = Pose(np.array([np.eye(3), whole @ about @ whole.T]), np.array([np.zeros(3), whole @ place]))
    found = overlap_points(structure, contacts, np.arange(1), pose, 0.0)
    reach = (pair_points(scene, found, pose, 0.0)[:, 0] @ whole)[:, 1].max()
    assert reach == pytest.approx(1.7 if off > 3e-5 else 1.0, abs=3 * off + 1e-4)


@pytest.mark.parametrize("bed", ["rectangle", "two sides"])
@pytest.mark.parametrize("seed", [3, 5, 6, 10, 12])
def test_a_slab_that_slides_over_the_end_of_its_bed_tips_there(bed, seed):
    """Pushed at its centroid it slides at .3, until what it bears on is beyond y = 1: at u = .2 - .3 x .15.

    Then it tips, and its centroid is over the edge of the bed at u = .2. The direction of its slip is known to what
    solvers leave; what that adds up to on the way must not turn it.
    """
    whole = Rotation.random(random_state=seed).as_matrix()
    plain = assembly([box((0, 0, -0.5), (3, 1, 0), name="bed"), box((1, 0.2, 0), (2, 1.4, 0.3), name="slab")])
    scene = plain.with_(friction=0.3) if bed == "rectangle" else beside(bed, friction=0.3)
    scene = scene.with_(vertices=scene.vertices @ whole.T, gravity=whole @ scene.gravity)
    curve = capacity(scene, whole @ (0, 1, 0), control="slab", displacement=0.5, steps=8)
    assert curve.lower[0] == pytest.approx(0.3, rel=1e-5)
    assert curve.outcome.word == "zero"
    assert [event.parameter for event in curve.events] == pytest.approx([0.155], abs=1e-3)
    assert curve.displacement[-1] == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize("notch", [1.0, 1.5])
def test_the_shorter_bearing_is_that_of_what_lies_under_a_lintel(notch):
    """It slides off its left wall after .3 m, .4 m being on the right one: a side of the wall reaches on beside it."""
    wall = [(-0.5, 0), (0.3, 0), (0.3, notch), (2, notch), (2, 2), (-0.5, 2)]
    blocks = [upright(wall, 2, name="left"), box((1.8, 0, 0), (2.7, 1, 2), name="right")]
    scene = assembly([*blocks, box((0, 0, 2), (2.2, 1, 2.4), name="lintel")], supports=[0, 1], friction=0.6)
    for turn in (0.0, 0.7):
        whole = Rotation.from_rotvec([turn, -turn, 2 * turn]).as_matrix()
        turned = scene.with_(vertices=scene.vertices @ whole.T, gravity=whole @ scene.gravity)
        path = settle_to_collapse(turned, {"right": tuple(whole @ (1.0, 0, 0))}, displacement=0.5, steps=8)
        assert path.collapse == pytest.approx(0.3, abs=1e-5)


def test_a_joint_that_slides_keeps_the_friction_it_was_given():
    scene = on_ground_to(3.0, box((0, 0, 0), (1, 1, 0.5), name="block"), friction=0.7)
    faces = replace(find_interfaces(scene), friction=np.array([0.3]))
    curve = capacity(scene, ALONG, displacement=0.1, steps=3, interfaces=faces)
    np.testing.assert_allclose(curve.lower, 0.3, rtol=1e-6)


def test_cohesion_acts_on_what_still_touches():
    """Of weight W = 1/2 and with a cohesion of 1/4, on (1 - d) x 1: .3 + (1 - d) / 2."""
    law = JointLaw(("*", "*"), friction=0.3, cohesion=0.25)
    scene = on_ground_to(1.0, box((0, 0, 0), (1, 1, 0.5), name="block"), joints=[law])
    curve = capacity(scene, ALONG, displacement=0.25, steps=5)
    assert curve.outcome.word == "reached"
    np.testing.assert_allclose(curve.lower, 0.3 + 0.5 * (1 - curve.displacement), rtol=1e-5)
    assert curve.lower[-1] == pytest.approx(0.675, rel=1e-5)


def test_cohesion_of_a_block_on_two_feet_is_that_of_the_feet():
    """Of weight .18, on feet of .2 x 1 with a cohesion of .09; from .05 on the front one leaves the ground."""
    law = JointLaw(("*", "*"), friction=0.3, cohesion=0.09)
    curve = capacity(on_ground_to(1.05, on_two_feet(), joints=[law]), ALONG, displacement=0.15, steps=6)
    feet = 0.4 - np.maximum(curve.displacement - 0.05, 0)
    np.testing.assert_allclose(curve.lower, 0.3 + 0.5 * feet, rtol=1e-5)


def test_a_face_that_gains_corners_as_it_slides_is_followed():
    """A triangular plate with a joint law gets a fourth contact point at the edge of the ground."""
    law = JointLaw(("*", "*"), friction=0.3)
    plate = upright([(0, 0), (0.8, 0.5), (0, 1)], 0.1, name="plate")
    curve = capacity(on_ground_to(1.0, plate, joints=[law]), ALONG, displacement=0.4, steps=4)
    assert curve.outcome.word == "reached"
    np.testing.assert_allclose(curve.lower, 0.3, rtol=1e-6)
