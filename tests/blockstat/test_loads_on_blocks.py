"""Loads on blocks against integrals by quadrature, on shapes and under gravities without symmetry."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, InputError, acceleration, body_load, point_load
from blockstat.loads import as_load, on_block, three
from evidence.scenes.small import box, prism

GRAVITY = np.array([1.0, -2.0, -8.0])
UP = -GRAVITY / np.linalg.norm(GRAVITY)
WEDGE = np.array([[0.3, 0.1, 0.2], [1.4, 0.0, 0.5], [0.2, 1.7, 0.1], [0.6, 0.5, 2.3]])
TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
#: A U in the plane x, z between y = 0 and 2, with a notch from x = 1 to 2.5 above z = 1.
NOTCHED = [(0, 0), (4, 0), (4, 3), (2.5, 3), (2.5, 1), (1, 1), (1, 3), (0, 3)]


def scene(**options):
    blocks = [
        Block(WEDGE, TETRAHEDRON, "wedge", "wall.north", 700.0),
        box((3, 0, 0), (4, 2, 5), name="post", group="wall", density=300.0),
        box((6, 0, 0), (8, 3, 1), name="slab", group="wall2", density=500.0),
    ]
    return Assembly.from_blocks(blocks, gravity=GRAVITY, **options)


def inside_tetrahedron(corners):
    """Points and volumes of a rule that is exact to degree two."""
    a, b = (5 + 3 * 5**0.5) / 20, (5 - 5**0.5) / 20
    shares = np.full((4, 4), b) + (a - b) * np.eye(4)
    return shares @ corners, abs(np.linalg.det(corners[1:] - corners[0])) / 6 / 4


def test_an_acceleration_is_as_strong_as_gravity_whatever_the_length_of_its_direction():
    asm = scene()
    for length in (1e-200, 0.1, 1.0, 7.0, 1e200):
        load = acceleration(asm, length * np.array([2.0, -1.0, 2.0]))
        unit = np.array([2.0, -1.0, 2.0]) / 3
        np.testing.assert_allclose(load[:, :3], np.outer(asm.mass * 69**0.5, unit), rtol=1e-12)
        assert not load[:, 3:].any()


def test_an_acceleration_of_a_group_is_that_of_its_blocks_alone():
    asm = scene()
    load = acceleration(asm, (0, 1, 0), group="wall")
    np.testing.assert_allclose(load[:, 1], asm.mass * 69**0.5 * [1, 1, 0], rtol=1e-12)
    with pytest.raises(InputError, match='no group "wal"'):
        acceleration(asm, (0, 1, 0), group="wal")


@pytest.mark.parametrize("direction", [(0, 0, 0), (1, 0), (1, 0, 0, 0), (np.nan, 0, 1), (0, np.inf, 1), ("a", 0, 1)])
def test_a_load_needs_a_direction(direction):
    with pytest.raises(InputError, match=r"load direction is \[.*\]; it must be three numbers, not all zero"):
        acceleration(scene(), direction)


def test_an_acceleration_that_changes_with_the_height_is_the_integral_over_the_block():
    """The factor is linear over the whole block, so a rule of degree two over the tetrahedron is exact."""
    asm = scene()
    load = acceleration(asm, (3, 1, -2), profile=[(-100.0, -3.0), (100.0, 7.0)])[0]
    points, volume = inside_tetrahedron(WEDGE)
    factors = 2.0 + 0.05 * (points @ UP)
    force = 700.0 * volume * 69**0.5 * factors[:, None] * np.array([3, 1, -2]) / 14**0.5
    np.testing.assert_allclose(load[:3], force.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(load[3:], np.cross(points - asm.centroid[0], force).sum(axis=0), rtol=1e-9)


@pytest.mark.parametrize("away", [0.0, 1e6])
def test_a_profile_may_bend_within_a_block(away):
    """A pillar of 1 m x 1 m x 6 m: force and moment are the integrals of the profile times 1 and times the height."""
    pillar = Assembly.from_blocks([box((away, away, away), (away + 1, away + 1, away + 6))], density=1000.0)
    profile = [(away, 0.0), (away + 0.5, 1.0), (away + 4.0, -0.5), (away + 9.0, -0.5)]
    load = acceleration(pillar, (1, 0, 0), profile=profile)[0] / 9810.0
    # .5 (0 + 1) / 2, 3.5 (1 - .5) / 2 and -.5 times 2; the first moment of each about the foot.
    force = 0.25 + 0.875 - 1.0
    slope, first = -1.5 / 3.5, 0.5**2 / 3
    second = (1 - 0.5 * slope) * (4**2 - 0.5**2) / 2 + slope * (4**3 - 0.5**3) / 3
    moment = first + second - 0.5 * (6**2 - 4**2) / 2 - 3.0 * force
    np.testing.assert_allclose(load, [force, 0, 0, 0, moment, 0], atol=1e-8 if away else 1e-12)


def test_two_parts_of_a_block_however_it_lies_carry_what_the_block_does():
    turn = Rotation.from_rotvec([0.7, -0.4, 0.3]).as_matrix().T
    parts = [box((0, 0, 0), (1, 2, 1)), box((0, 0, 1), (1, 2, 3)), box((0, 0, 0), (1, 2, 3))]
    asm = Assembly.from_blocks([Block(part.vertices @ turn, part.faces) for part in parts])
    profile = [(0.3, 0.0), (0.8, 1.0), (1.7, -2.0), (1.9, 0.5)]
    load = acceleration(asm, (1, -2, 0), profile=profile)
    arm = asm.centroid[:2] - asm.centroid[2]
    moment = load[:2, 3:] + np.cross(arm, load[:2, :3])
    np.testing.assert_allclose(load[2], np.hstack([load[:2, :3], moment]).sum(axis=0), rtol=1e-9, atol=1e-6)


def test_beyond_its_ends_a_profile_is_constant_and_a_group_keeps_its_own():
    asm = scene()
    whole = acceleration(asm, (1, 2, 3))
    np.testing.assert_allclose(acceleration(asm, (1, 2, 3), profile=[(-50, 1.5), (-40, 3)]), 3 * whole, atol=1e-9)
    np.testing.assert_allclose(acceleration(asm, (1, 2, 3), profile=[(40, 1.5), (50, 3)]), 1.5 * whole, atol=1e-9)
    grown = acceleration(asm, (1, 2, 3), profile=[(0, 1), (5, 2)])
    alone = acceleration(asm, (1, 2, 3), profile=[(0, 1), (5, 2)], group="wall2")
    np.testing.assert_array_equal(alone[2], grown[2])
    assert not alone[:2].any()


@pytest.mark.parametrize("profile", [[(0, 1), (0, 2)], [(1, 1), (0, 2)], [(0, 1), (np.nan, 2)], [(0, np.inf), (1, 2)]])
def test_heights_of_a_profile_ascend(profile):
    with pytest.raises(InputError, match=r"profile has heights .*; they must ascend"):
        acceleration(scene(), (1, 0, 0), profile=profile)


@pytest.mark.parametrize("profile", [[(0, 1, 2), (1, 1, 2)], [1, 2, 3], "high", [(0, 1), (2,)]])
def test_a_profile_is_pairs(profile):
    with pytest.raises(InputError, match="it must be pairs of a height and a factor"):
        acceleration(scene(), (1, 0, 0), profile=profile)


def test_a_point_load_turns_about_the_centroid():
    asm = scene()
    point, force = (3.2, 0.3, 4.0), (7.0, -5.0, 2.0)
    load = point_load(asm, "post", point, force)
    arm = np.array(point) - (3.5, 1.0, 2.5)
    moment = [
        arm[1] * force[2] - arm[2] * force[1], arm[2] * force[0] - arm[0] * force[2],
        arm[0] * force[1] - arm[1] * force[0],
    ]  # fmt: skip
    np.testing.assert_allclose(load[1], [*force, *moment], rtol=1e-12)
    assert not load[[0, 2]].any()
    np.testing.assert_array_equal(point_load(asm, 1, point, force), load)


def test_a_point_is_on_its_block_to_a_millionth_of_its_size():
    asm = scene()
    for axis, face in ((0, 4.0), (1, 2.0), (2, 5.0)):
        point = np.array([3.6, 0.7, 2.0])
        point[axis] = face + 0.9e-6 * asm.size[1]
        assert on_block(asm, 1, point)
        point[axis] = face + 1.1e-6 * asm.size[1]
        assert not on_block(asm, 1, point)
    with pytest.raises(InputError, match=r'not on block "post", which lies between \[3\.0, 0\.0, 0\.0\] and \[4\.0, '):
        point_load(asm, "post", (5, 0, 0), (1, 0, 0))


def test_the_notch_of_a_concave_block_is_outside_and_its_faces_are_on_it():
    asm = Assembly.from_blocks([box((9, 9, 9), (10, 10, 10)), prism(NOTCHED, 2.0)])
    near = 1e-6 * asm.size[1]
    for x, z in ((0.5, 2), (3.2, 2.5), (1.7, 0.5), (1.7, 1.0), (1.0, 2.0), (2.5, 1.7), (0.5, 3.0), (4.0, 2.0)):
        assert on_block(asm, 1, np.array([x, 0.7, z])), (x, z)
    for x, z in ((1.7, 2.0), (1.7, 3.0), (2.4, 1.1), (1.1, 2.9), (4.1, 2.0), (1.7, -0.1)):
        assert not on_block(asm, 1, np.array([x, 0.7, z])), (x, z)
    assert on_block(asm, 1, np.array([1.7, 0.7, 1 + 0.8 * near]))
    assert not on_block(asm, 1, np.array([1.7, 0.7, 1 + 2.5 * near]))
    assert on_block(asm, 1, np.array([1 + 0.8 * near, 0.7, 2.0]))
    assert not on_block(asm, 1, np.array([1 + 2.5 * near, 0.7, 2.0]))


@pytest.mark.parametrize("scale", [0.01, 0.1, 1.0, 30.0])
def test_the_surface_of_a_concave_block_of_any_size_is_on_it_and_the_air_above_a_groove_is_not(scale):
    grooved = scale * np.array([(0, 0), (4, 0), (4, 3), (2.5, 3), (2.5, 2.7), (1, 2.7), (1, 3), (0, 3)])
    asm = Assembly.from_blocks([prism([tuple(corner) for corner in grooved], 2.0 * scale)])
    for x, z in ((0.5, 3.0), (4.0, 2.0), (3.0, 0.0), (0.0, 1.0), (1.7, 2.7), (1.0, 2.8), (2.5, 2.9)):
        assert on_block(asm, 0, scale * np.array([x, 0.7, z])), (x, z)
    for x, z in ((1.7, 3.0), (1.7, 2.75), (2.0, 2.9), (1.0, 3.1), (5.0, 3.0), (-0.5, 0.0)):
        assert not on_block(asm, 0, scale * np.array([x, 0.7, z])), (x, z)


@pytest.mark.parametrize("values", [(1, 2), (1, 2, 3, 4), [[1, 2, 3]], (1, np.nan, 2), (np.inf, 0, 0), "abc", None])
def test_three_numbers_are_three_and_finite(values):
    with pytest.raises(InputError, match=r"^push is .*; it must be three finite numbers"):
        three(values, "push")
    np.testing.assert_array_equal(three((1, 2, 3), "push"), [1.0, 2.0, 3.0])


def test_a_load_is_a_direction_or_a_wrench_on_each_block():
    asm = scene(supports=["slab"])
    np.testing.assert_array_equal(as_load(asm, (0, 3, 0)), acceleration(asm, (0, 1, 0)))
    wrenches = np.arange(18.0).reshape(3, 6)
    np.testing.assert_array_equal(as_load(asm, wrenches), wrenches)
    alone = np.zeros((3, 6))
    alone[1, 5] = 1e-9
    np.testing.assert_array_equal(as_load(asm, alone), alone)
    for shape in ((3, 3), (2, 6), (18,), (3, 6, 1)):
        with pytest.raises(InputError, match=r"finite values of shape \(3, 6\) are needed"):
            as_load(asm, np.ones(shape))
    wrenches[2, 3] = np.nan
    with pytest.raises(InputError, match=r"load has shape \(3, 6\)"):
        as_load(asm, wrenches)
    support = np.zeros((3, 6))
    support[2] = 1.0
    for nothing in (np.zeros((3, 6)), support):
        with pytest.raises(InputError, match="load is zero on every free block"):
            as_load(asm, nothing)


def test_blocks_share_a_body_force_by_their_masses():
    asm = scene(supports=["slab"])
    force = np.array([6.0, -4.0, 2.0])
    free = asm.mass * [1, 1, 0] / asm.mass[:2].sum()
    wall = asm.mass * [1, 1, 0] / asm.mass[:2].sum()
    for options, share in (
        ({}, free), ({"group": "wall"}, wall), ({"group": "wall2"}, [0, 0, 1]), ({"blocks": ["post", 2]}, None),
    ):  # fmt: skip
        if share is None:
            share = asm.mass * [0, 1, 1] / asm.mass[1:].sum()
        load = body_load(asm, force, **options)
        np.testing.assert_allclose(load[:, :3], np.outer(share, force), rtol=1e-12)
        assert not load[:, 3:].any()
    with pytest.raises(InputError, match="a load is for blocks or for a group; give one of the two"):
        body_load(asm, force, blocks=["post"], group="wall")
    with pytest.raises(InputError, match='load: no block "pst"'):
        body_load(asm, force, blocks="pst")
    with pytest.raises(InputError, match=r"force is \(1, 2\)"):
        body_load(asm, (1, 2))


def test_a_block_that_is_named_twice_has_its_share_once():
    pair = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), name="one"), box((0, 0, 1), (1, 1, 4), name="two")])
    load = body_load(pair, (8, 0, 0), blocks=["one", 0, "two", "one"])
    np.testing.assert_allclose(load[:, 0], [2.0, 6.0], rtol=1e-12)


def test_a_point_load_is_on_one_block():
    pair = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), name="one"), box((0, 0, 1), (1, 1, 4), name="two")])
    with pytest.raises(InputError, match="load: \\['one', 'two'\\] are 2 blocks; give one"):
        point_load(pair, ["one", "two"], (0.5, 0.5, 1), (1, 0, 0))
