"""Keels that cross ridges: their limit load, its derivatives, and normals that follow moved corners."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import Block, InputError, find_interfaces, limit_load, limit_load_by_point, reserve_map
from blockstat.contact.features import ContactKind
from blockstat.sensitivity.moved_corners import MovedCorners
from blockstat.sensitivity.vertices import point_carriers, shared_points
from evidence.scenes.small import assembly, box, prism, stack

SIDE = (1, 0, 0)
FRICTION = 0.5


def as_soup(block):
    """The block with corners of their own for each face."""
    corners = [np.asarray(block.vertices)[face] for face in block.faces]
    ends = np.cumsum([len(face) for face in corners])
    faces = [list(range(end - len(face), end)) for face, end in zip(corners, ends, strict=True)]
    return Block(np.concatenate(corners), faces, name=block.name)


def crossed(top=lambda block: block):
    """A block with two keels along x on two ridges along y: four crossings, at x = -+.5 and y = .5 and 1.5."""
    ridges = [prism([(x - 0.3, -1), (x + 0.3, -1), (x, 0)], 2.0, name=f"ridge{k}") for k, x in enumerate((-0.5, 0.5))]
    along_y = prism([(-1, 1), (-0.5, 0), (0, 0.5), (0.5, 0), (1, 1)], 2.0)
    x, y, z = np.asarray(along_y.vertices).T
    keels = Block(np.column_stack([1 - y, 1 + x, z]), along_y.faces, name="keels")
    return assembly([*ridges, top(keels)], supports=[0, 1], friction=FRICTION)


@pytest.mark.parametrize("top", [lambda block: block, as_soup], ids=["shared corners", "corners of each face"])
def test_crossings_are_found_whether_or_not_faces_share_their_corners(top):
    joints = find_interfaces(crossed(top))
    assert joints.kinds.tolist() == [ContactKind.CROSSING] * 4
    places = sorted(map(tuple, joints.point.round(9).tolist()))
    assert places == [(-0.5, 0.5, 0.0), (-0.5, 1.5, 0.0), (0.5, 0.5, 0.0), (0.5, 1.5, 0.0)]
    np.testing.assert_allclose(np.abs(joints.frame[:, 0]), np.tile([0.0, 0.0, 1.0], (4, 1)), atol=1e-12)


def raised(scene, height):
    """Displacement of each shared corner that raises the keels' ends at x = 1."""
    points = shared_points(scene)[0]
    shift = np.zeros_like(points)
    ends = (points[:, 0] == 1) & (points[:, 2] == 0)
    assert ends.sum() == 2
    shift[ends, 2] = height
    return shift


def test_a_limit_load_follows_the_slope_of_keels_that_slide_on_ridges():
    """Up a slope s the block slides at tan(atan mu + atan s): at s = 0 the derivative is 1 + mu^2, and s = h / 2."""
    scene = crossed()
    found = limit_load_by_point(limit_load(scene, SIDE), SIDE)
    assert found.value == pytest.approx(FRICTION, rel=1e-6)
    slope = float((found.gradient * raised(scene, 1.0)).sum())
    assert slope == pytest.approx((1 + FRICTION**2) / 2, rel=1e-5)


def test_normals_of_crossings_turn_with_their_edges():
    scene, height = crossed(), 0.2
    joints = find_interfaces(scene)
    corners = MovedCorners(scene, joints)
    shift = raised(scene, height)
    free = scene.vertex_block == 2  # the corners of the ridges, which are supports, stay
    moving = np.unique(shared_points(scene)[1][free])
    assert corners.count == len(moving)
    moved, changed = corners.moved(shift[moving], joints)
    expected = np.array([-height, 0.0, 2.0]) / np.hypot(height, 2.0)
    upwards = joints.frame[:, 0, 2][:, None]
    np.testing.assert_allclose(changed.frame[:, 0] * upwards, np.tile(expected, (4, 1)), atol=1e-12)
    # It slides up the slope at tan(atan mu + atan s).
    limit = limit_load(moved, SIDE, interfaces=changed)
    assert limit.lower == pytest.approx(np.tan(np.arctan(FRICTION) + np.arctan(height / 2)), rel=1e-6)


def test_corners_of_blocks_without_joints_move_too():
    scene = assembly([box((0, 0, 0), (1, 1, 1)), box((5, 0, 0), (6, 1, 1))])
    joints = find_interfaces(scene)
    assert joints.n_interfaces == 0
    corners = MovedCorners(scene, joints)
    assert corners.count == 8
    lifted, changed = corners.moved(np.full((8, 3), [0.0, 0.0, 2.0]), joints)
    assert changed.n_interfaces == 0
    np.testing.assert_allclose(lifted.centroid, [[0.5, 0.5, 0.5], [5.5, 0.5, 2.5]])


@pytest.mark.parametrize(
    ("scene", "names"), [(crossed(), '"ridge0" and "keels"'), (stack(1, 1.0, 2.0), '"ground" and "stone0"')]
)
def test_a_contact_point_that_lies_on_nothing_has_no_derivative(scene, names):
    joints = find_interfaces(scene)
    elsewhere = replace(joints, point=0.5 * joints.point + [0.3, 0.3, 0.0])
    with pytest.raises(InputError, match=f"{names}: a contact point lies on no corner and on no edge"):
        point_carriers(scene, elsewhere, 0, 0, [])


def test_a_map_without_corners_names_none():
    found = reserve_map(limit_load(stack(1, 1.0, 2.0), SIDE), SIDE, corners=False)
    with pytest.raises(InputError, match="the map was made without corners; ask for them by corners=True"):
        found.most("corner")
    assert [name for name, _ in found.most("edge")] == ['"ground" and "stone0"']
