"""Contact points of joints at displaced poses: overlaps of faces, crossings of their edges, and the closing of gaps."""

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from blockstat import find_interfaces
from blockstat.large_displacement.displaced.contact_pairs import edge_crossings, gaps, pair_points, pairs_at_rest
from blockstat.large_displacement.displaced.face_overlap import overlap_points, with_overlap_points
from blockstat.large_displacement.displaced.loads import read_loads
from blockstat.large_displacement.displaced.pose import Pose, displaced_points
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.finite_steps.contact_projection import projected_onto_zero_gap
from blockstat.large_displacement.linkage.linkage import Linkage
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
