"""Beds whose triangles miss one plane by what files round or surveys are off by: on a path they are one plane."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, box, capacity, find_interfaces, limit_load, settle_to_collapse
from blockstat.large_displacement.displaced.common_beds import in_common_planes

TURN = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()
#: Corners of the two halves of an outline of six.
HALVES = [(0, 1, 4, 5), (1, 2, 3, 4)]
UTM = np.array([5e5, 4.6e6, 0.0])
#: Standard deviation of the corners [m], and seeds with which the two triangles of the bed were followed to .7 mm only.
SEEDS = [(5e-5, 6), (1e-4, 10), (1e-4, 26), (1e-4, 34)]


def triangulated(block, size, random):
    """A block with corners off by random numbers and faces divided from random corners on."""
    corners = block.vertices + random.normal(0, size, block.vertices.shape)
    faces = []
    for face in block.faces:
        k = int(random.integers(len(face)))
        around = [*face[k:], *face[:k]]
        faces += [(around[0], *pair) for pair in zip(around[1:], around[2:], strict=False)]
    return Block(corners, faces, block.name)


def prism(outline, name, parts, depth=1.0):
    """A block with an outline in x and z, whose ends are parts with these corners, counter-clockwise seen along y."""
    n = len(outline)
    corners = np.array([(x, y, z) for y in (0.0, depth) for x, z in outline])
    sides = [(k, k + n, (k + 1) % n + n, (k + 1) % n) for k in range(n)]
    return Block(corners, [*map(tuple, parts), *(tuple(n + k for k in part[::-1]) for part in parts), *sides], name)


def scene_of(blocks, friction=0.3):
    return Assembly.from_blocks(blocks, supports=[blocks[0].name], friction=friction)


def block_on_pedestal(size, seed):
    """A block of .8 x .8 x .6 m in the middle of a pedestal of 1 m x 1 m; friction .3."""
    random = np.random.default_rng(seed)
    blocks = [box((0, 0, 0), (1, 1, 1), name="pedestal"), box((0.1, 0.1, 1), (0.9, 0.9, 1.6), name="block")]
    return scene_of([triangulated(block, size, random) for block in blocks])


def beds_of(scene):
    """The numbers of joints as drawn and as followed, without slivers where ridges miss each other."""
    drawn = find_interfaces(scene)
    return tuple(int((joints.area > 1e-3).sum()) for joints in (drawn, in_common_planes(scene, drawn)))


def carried(displacement):
    """The block slides at .3 until the thrust is at the rim of the pedestal, at .41 m, and then turns over the rim.

    The centre is .09 m behind the rim then, and .3 m above it, and stays as far away: the multiplier is the tangent of
    the angle of that line with the vertical.
    """
    behind = np.maximum(0.5 - displacement, 0.0)
    return np.minimum(0.3, behind / np.sqrt(0.09**2 + 0.3**2 - np.minimum(behind, 0.09) ** 2))


def check_slide(curve, size):
    """Against the closed form. Four deviations of the corners at the rim and of the bed, over the height of .3 m."""
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.5, abs=4 * size)
    assert curve.lower == pytest.approx(carried(curve.displacement), abs=4 * size / 0.3)
    assert np.diff(curve.displacement).max() < 0.1


@pytest.mark.parametrize(("size", "seed"), SEEDS)
def test_a_block_on_two_triangles_slides_as_on_one_plane(size, seed):
    scene = block_on_pedestal(size, seed)
    assert beds_of(scene)[0] > 1
    check_slide(capacity(scene, (1, 0, 0), control="block"), size)


@pytest.mark.parametrize(("size", "seed"), SEEDS)
def test_so_it_does_turned_and_in_map_coordinates(size, seed):
    scene = block_on_pedestal(size, seed)
    there = scene.with_(vertices=scene.vertices @ TURN.T + UTM, gravity=TURN @ scene.gravity)
    check_slide(capacity(there, tuple(TURN @ (1.0, 0, 0)), control="block"), size)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_with_associated_flow_it_turns_where_the_clean_block_does(seed):
    """It opens by .3 of its slip: .4831 m of the quads is where its curve is zero."""
    clean = scene_of([box((0, 0, 0), (1, 1, 1), name="p"), box((0.1, 0.1, 1), (0.9, 0.9, 1.6), name="block")])
    curves = [
        capacity(scene, (1, 0, 0), control="block", flow="associated")
        for scene in (clean, block_on_pedestal(5e-5, seed))
    ]
    assert curves[1].displacement[-1] == pytest.approx(curves[0].displacement[-1], abs=10 * 5e-5)


@pytest.mark.parametrize(("size", "seed"), SEEDS)
def test_the_limit_load_at_rest_stays_within_what_the_corners_are_off_by(size, seed):
    """A tilt of a triangle adds to friction or takes from it: 4 deviations of two corners, over half its width."""
    scene = block_on_pedestal(size, seed)
    found = find_interfaces(scene)
    drawn, joined = (
        limit_load(scene, (1, 0, 0), interfaces=joints) for joints in (found, in_common_planes(scene, found))
    )
    assert joined.lower == pytest.approx(drawn.lower, abs=2 * 4 * size / 0.28)


def test_a_lintel_on_triangles_falls_when_its_shorter_bearing_is_used_up():
    random, size = np.random.default_rng(3), 1e-4
    ends = {
        "left": ((-0.5, 0, 0), (0.3, 1, 2)),
        "right": ((1.8, 0, 0), (2.7, 1, 2)),
        "lintel": ((0, 0, 2), (2.2, 1, 2.4)),
    }
    blocks = [triangulated(box(*corners, name=name), size, random) for name, corners in ends.items()]
    scene = Assembly.from_blocks(blocks, supports=["left", "right"], friction=0.6)
    assert beds_of(scene)[1] == 2
    path = settle_to_collapse(scene, {"right": (1, 0, 0)}, displacement=0.4, steps=8)
    assert path.collapse == pytest.approx(0.3, abs=2 * 4 * size)


def test_a_bed_of_several_triangles_stands_for_their_area_alone():
    """An L of three quarters of a square: the shares of the corners of its hull have the centroid of the L."""
    random, size = np.random.default_rng(4), 1e-4
    outline = [(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)]
    block = prism(outline, "block", [(0, 1, 2, 3), (0, 3, 4, 5)], depth=0.6)
    upright = np.column_stack([block.vertices[:, 0], block.vertices[:, 2], 0.6 - block.vertices[:, 1]])
    block = triangulated(Block(upright, block.faces, "block"), size, random)
    scene = scene_of([box((-1, -1, -1), (2, 2, 0), name="ground"), block])
    joints = in_common_planes(scene, find_interfaces(scene))
    assert beds_of(scene)[0] > 1
    assert joints.n_interfaces == 1
    assert joints.area[0] == pytest.approx(0.75, abs=20 * size)
    assert joints.point_share.sum() == pytest.approx(1.0)
    assert (joints.point_share @ joints.point)[:2] == pytest.approx(5 / 12, abs=4 * size)


def v_bed(angle, *, mates=True, size=0.0, seed=0):
    """A bed whose halves of .4 m rise outwards by an angle [degrees]; where it does not mate, the ground is level."""
    rise, random = 0.4 * np.tan(np.radians(angle)), np.random.default_rng(seed)
    bed, level = [(0.0, rise), (0.4, 0.0), (0.8, rise)], [(0.8, 0.0), (0.4, 0.0), (0.0, 0.0)]
    ground = [(0.0, -1.0), (0.4, -1.0), (0.8, -1.0), *(bed[::-1] if mates else level)]
    upper = [*bed, (0.8, 0.6), (0.4, 0.6), (0.0, 0.6)]
    blocks = [prism(outline, name, HALVES) for outline, name in ((ground, "ground"), (upper, "block"))]
    return scene_of([triangulated(block, size, random) if size else block for block in blocks])


@pytest.mark.parametrize("angle", [0.25, 1.0, 2.0, 10.0])
def test_a_bed_at_an_angle_stays_two_planes(angle):
    assert beds_of(v_bed(angle)) == (2, 2)


def test_a_ridge_on_a_level_ground_stays_two_planes():
    assert beds_of(v_bed(0.9, mates=False)) == (2, 2)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_triangles_of_a_bed_at_an_angle_become_its_two_planes(seed):
    assert beds_of(v_bed(2.0, size=1e-4, seed=seed))[1] == 2


def step(height, size=0.0, seed=0):
    """Two level beds of .4 m, one higher than the other."""
    random, bed = np.random.default_rng(seed), [(0.0, 0.0), (0.4, 0.0), (0.4, height), (0.8, height)]
    parts = [(0, 1, 5, 6), (1, 2, 3, 4, 5)]
    ground = prism([(0.0, -1.0), (0.4, -1.0), (0.8, -1.0), *bed[::-1]], "ground", parts)
    blocks = [ground, prism([*bed, (0.8, 0.6), (0.4, 0.6), (0.0, 0.6)], "block", parts)]
    return scene_of([triangulated(block, size, random) if size else block for block in blocks])


@pytest.mark.parametrize("height", [1e-5, 1e-4, 5e-4, 5e-3])
def test_a_step_stays_two_planes(height):
    scene = step(height)
    found = find_interfaces(scene)
    assert in_common_planes(scene, found) is found


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_the_triangles_of_a_step_become_its_two_planes(seed):
    scene = step(5e-4, 5e-5, seed)
    joints = in_common_planes(scene, find_interfaces(scene))
    assert joints.area[joints.area > 1e-3] == pytest.approx([0.4, 0.4], abs=1e-3)
