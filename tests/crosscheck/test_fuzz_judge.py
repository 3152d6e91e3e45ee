"""The judge of random scenes, where the answer is known by hand."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from evidence.fuzz.generate import FAMILIES, scene
from evidence.fuzz.judge import Truth, judge, near_limit
from evidence.fuzz.limits import SIDES, carried
from evidence.fuzz.programs import Points
from evidence.fuzz.scene import Scene
from evidence.fuzz.shapes import profile
from evidence.fuzz.solids import Solid, box, brick, extruded, hull, split
from evidence.fuzz.stacks import about_z, slab
from evidence.fuzz.touch import touches

DOWN = np.array([0.0, 0.0, -1.0])
QUARTER = Rotation.from_euler("z", np.pi / 2).as_matrix()


def made(solids, fixed=1, *, friction=0.7, gravity=DOWN, **more):
    """A scene of which the first solids are supports."""
    support = tuple(i < fixed for i in range(len(solids)))
    return Scene("test", tuple(solids), support, (1.0,) * len(solids), friction, np.asarray(gravity, float), **more)


def multiplier(found, direction, outer):
    points = Points.of(found, touches(found))
    around = 2 * np.pi * np.arange(SIDES) / SIDES
    points = replace(points, angles=(around,) * len(points.point))
    return carried(points, np.asarray(direction, float), outer=outer)


def assert_limit(found, direction, value):
    inner, outer = (multiplier(found, direction, side) for side in (False, True))
    assert inner - 1e-9 <= value <= outer + 1e-9
    assert outer - inner <= 5e-3 * value


def truth(found):
    return judge(found).truth


def tetrahedron(pushed):
    """Edge 1, its base on the floor pushed in to a point."""
    angle = 2 * np.pi * np.arange(3) / 3
    base = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(3)]) / np.sqrt(3)
    centre, tip = np.array([0, 0, pushed]), np.array([0, 0, np.sqrt(2 / 3)])
    if not pushed:
        return hull(np.array([*base, tip]))
    pieces = tuple(np.array([base[i], base[(i + 1) % 3], centre, tip]) for i in range(3))
    faces = [(i, (i + 1) % 3, 4) for i in range(3)] + [((i + 1) % 3, i, 3) for i in range(3)]
    return Solid(np.array([*base, centre, tip]), tuple(faces), pieces)


@pytest.mark.parametrize("pushed", [0.0, 0.1])
def test_three_points_tip_over_a_side_or_a_point(pushed):
    """The points are 1 / sqrt 3 off the middle and the sides half of that; the centroid (sqrt(2/3) + pushed) / 4 up."""
    found = made([slab(), tetrahedron(pushed)], friction=np.inf)
    corner = 4 / np.sqrt(3) / (np.sqrt(2 / 3) + pushed)
    assert_limit(found, (-1, 0, 0), corner / 2)
    assert_limit(found, (1, 0, 0), corner)
    assert_limit(made(found.solids, friction=0.5), (-1, 0, 0), 0.5)


@pytest.mark.parametrize(
    ("shift", "friction", "direction", "value"),
    [(0.0, 0.8, (1, 0, 0), 0.5), (0.1, 0.8, (1, 0, 0), 1 / 3), (0.1, 0.8, (-1, 0, 0), 2 / 3),
     (0.0, 0.8, (0, 1, 0), 2 / 3), (0.0, 0.4, (1, 0, 0), 0.4)],
)  # fmt: skip
def test_a_box_on_two_ridges(shift, friction, direction, value):
    """(.3 -+ shift) / .6 over a ridge, .4 / .6 along them, or the friction."""
    posts = [extruded([[(x - 0.1, -1), (x + 0.1, -1), (x, 0)]], -1, 1) for x in (-0.3, 0.3)]
    block = box((shift - 0.5, -0.4, 0), (shift + 0.5, 0.4, 1.2))
    found = made([*posts, block], 2, friction=friction)
    assert {touch.kind for touch in touches(found)} == {"12"}
    assert_limit(found, direction, value)


@pytest.mark.parametrize("degrees", [0, 30, 60, 90])
def test_crossed_keels(degrees):
    """Edge across edge: it tips over a keel, .2 off the middle, or a ridge, .35 off."""
    ridges = [extruded([[(y - 0.1, -1), (y + 0.1, -1), (y, 0)]], -1, 1).moved(turn=QUARTER) for y in (-0.35, 0.35)]
    keels = [[(x - 0.05, 0.1), (x, 0.0), (x + 0.05, 0.1)] for x in (-0.2, 0.2)]
    top = (1 + np.sqrt(1 - 0.95 / 3)) / 2  # the centroid is at .5
    plate = [(-0.4, 0.1), (0.4, 0.1), (0.4, top), (-0.4, top)]
    outline = [(-0.4, 0.1), *keels[0], *keels[1], (0.4, 0.1), (0.4, top), (-0.4, top)]
    body = extruded([plate, *keels], -0.8, 0.8, outline=outline)
    assert body.centroid == pytest.approx([0, 0, 0.5], abs=1e-12)
    found = made([*ridges, body], 2, friction=1.0)
    contacts = touches(found)
    assert [touch.kind for touch in contacts] == ["11"] * 4
    psi = np.radians(degrees)
    value = 1 / (0.5 * max(np.cos(psi) / 0.2, np.sin(psi) / 0.35))
    assert_limit(found, (np.cos(psi), np.sin(psi), 0), value)


def ladder(friction, wall_friction=None):
    """4 x .2 at 60 degrees, underside edges on floor and wall."""
    angle = np.radians(60)
    along, up = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    corners = np.array([(0.0, 0.0), 4 * along, 4 * along + 0.2 * up, 0.2 * up])
    wall = box((corners[:, 0].max(), -1, 0), (5, 2, 5))
    solids = [slab(), wall, extruded([corners], 0, 1)]
    more = {} if wall_friction is None else {"sheets": (1,), "sheet_friction": wall_friction}
    return made(solids, 2, friction=friction, **more)


@pytest.mark.parametrize("wall", [None, 0.0])
def test_a_ladder_needs_so_much_friction(wall):
    """(sqrt(l^2 - t^2 sin^2) - l sin) / (l cos + t sin), or (l cos - t sin) / (2 l sin) at a smooth wall."""
    rise, run, out = 4 * np.sin(np.pi / 3), 4 * np.cos(np.pi / 3), 0.2 * np.sin(np.pi / 3)
    least = (run - out) / (2 * rise) if wall == 0 else (np.sqrt(4**2 - out**2) - rise) / (run + out)
    assert truth(ladder(least * (1 + 1e-6), wall)) is Truth.STABLE
    assert truth(ladder(least * (1 - 1e-6), wall)) is Truth.UNSTABLE


def test_a_prism_in_a_groove():
    """Half angle 45 degrees: 1 across, and by forces alone mu sqrt 2 / sqrt(1 - mu^2) along."""
    flanks = [[(-2, 2), (-2, -2), (2, -2)], [(-2, -2), (2, -2), (2, 2)]]
    valley = extruded(flanks, -2, 2, outline=[(0, 0), (-2, 2), (-2, -2), (2, -2), (2, 2)])
    angle = np.pi / 8 + np.pi / 8 + 2 * np.pi * np.arange(8) / 8
    prism = np.stack([np.cos(angle), np.sin(angle)], axis=1) + [0, np.sqrt(2)]
    found = made([valley, extruded([prism], -0.5, 0.5)], friction=0.2)
    assert {touch.kind for touch in touches(found) if touch.certain} == {"21"}
    assert_limit(found, (1, 0, 0), 1.0)
    assert_limit(found, (0, 1, 0), 0.2 * np.sqrt(2 / 0.96))


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_an_octahedron_in_a_corner(friction):
    """1 / sqrt 2 towards a face and twice as much the other way, for any friction."""
    turn = Rotation.align_vectors([[0, 0, 1]], [[1, 1, 1]])[0].as_matrix()
    planes = [box((0, 0, -1), (4, 4, 0)), box((0, -1, 0), (4, 0, 4)), box((-1, 0, 0), (0, 4, 4))]
    body = hull(np.array([*(0.5 * np.eye(3)), *(-0.5 * np.eye(3))])).moved((0.5, 0.5, 0.5))
    found = made([solid.moved(turn=turn) for solid in (*planes, body)], 3, friction=friction)
    level = (turn @ [0.0, 0.0, 1.0]) * [1, 1, 0]
    level /= np.linalg.norm(level)
    values = sorted(multiplier(found, sign * level, outer) for sign in (1, -1) for outer in (False, True))
    assert values[:2] == pytest.approx([np.sqrt(0.5)] * 2, rel=5e-3 if friction else 1e-8)
    assert values[2:] == pytest.approx([np.sqrt(2)] * 2, rel=5e-3 if friction else 1e-8)


@pytest.mark.parametrize("tilt", [0.1, 0.5, 1.0])
def test_a_cube_on_a_slope_slides_and_tips_at_its_limits(tilt):
    solids = [slab(), box((0, 0, 0), (1, 1, 1))]
    for friction, factor, expected in [
        (tilt, 1 - 1e-6, Truth.STABLE), (tilt, 1 + 1e-6, Truth.UNSTABLE), (5.0, 1 - 1e-6, Truth.STABLE),
    ]:  # fmt: skip
        assert truth(made(solids, friction=friction, gravity=(factor * tilt, 0, -1))) is expected
    assert truth(made(solids, friction=np.inf, gravity=(1 + 1e-6, 0, -1))) is Truth.UNSTABLE


def test_a_block_balanced_on_an_edge_is_within_any_distance_of_its_limit():
    post = extruded([[(-0.1, -1), (0.1, -1), (0, 0)]], -1, 1)
    found = made([post, box((-0.5, -0.5, 0), (0.5, 0.5, 1))])
    assert near_limit(judge(found), 1e-8)
    assert not near_limit(judge(made([slab(), found.solids[1]])), 1e-3)
    assert truth(made([post, box((-0.5, -0.5, 0), (0.50001, 0.5, 1))])) is Truth.UNSTABLE


def test_diagonal_neighbours_touch_without_a_normal_of_their_own():
    found = made([box((-1, 0, -1), (0, 1, 0)), box((0, 0, 0), (1, 1, 1))])
    contacts = touches(found)
    assert {tuple(touch.normal.round(9)) for touch in contacts} == {(1, 0, 0), (0, 0, 1)}
    assert not any(touch.unique for touch in contacts)


def test_blocks_pass_each_other_at_an_edge_that_the_motion_opens():
    posts = [box((-1, 0, -1), (0, 1, 0)), box((1, 0, -1), (2, 1, 0))]
    assert truth(made([*posts, box((0, 0, 0), (1, 1, 1))], 2)) is Truth.UNSTABLE


def test_what_hangs_on_edges_that_every_motion_closes_is_neither_stable_nor_unstable():
    """A block that two walls keep upright stands with its lower edges on the edges of two posts."""
    posts = [box((-1, 0, -1), (0, 1, 0)), box((1, 0, -1), (2, 1, 0))]
    walls = [box((-1.5, 0, 0), (-0.5, 1, 2)), box((1.5, 0, 0), (2.5, 1, 2))]
    body = extruded([[(0, 0), (1, 0), (1.5, 1), (1.5, 2), (-0.5, 2), (-0.5, 1)]], 0, 1)
    assert truth(made([*posts, *walls, body], 4, friction=0.0)) is Truth.NORMAL


@pytest.mark.parametrize("kind", ["L", "U"])
def test_a_cube_in_a_concave_corner_touches_both_faces(kind):
    found = made([profile(kind, 1.0, 1.0, 0.2), box((0.2, 0.1, 0.2), (0.4, 0.5, 0.4))])
    contacts = touches(found)
    assert {tuple(touch.normal.round(9)) for touch in contacts} == {(1, 0, 0), (0, 0, 1)}
    assert all(touch.unique and touch.kind == "22" and len(touch.points) == 4 for touch in contacts)


def test_nothing_touches_through_a_sheet():
    sheet, cube = box((-0.6, -0.6, 0), (0.6, 0.6, 5e-4)), box((-0.5, -0.5, 5e-4), (0.5, 0.5, 1))
    slide = np.array([np.tan(np.radians(15)), 0, -1])
    found = made([slab(), sheet, cube], gravity=slide, sheets=(1,), sheet_friction=0.1)
    assert {(touch.a, touch.b) for touch in touches(found)} == {(0, 1), (1, 2)}
    assert truth(found) is Truth.UNSTABLE


def test_common_patches_are_those_of_two_polygons():
    random = np.random.default_rng(5)
    for _ in range(50):
        corners = [random.uniform(0.5, 2, 3) for _ in range(2)]
        lower = brick(*corners[0]).moved((0, 0, -corners[0][2] / 2), about_z(random.uniform(0, 3)))
        upper = brick(*corners[1]).moved(
            (*random.uniform(-0.8, 0.8, 2), corners[1][2] / 2), about_z(random.uniform(0, 3))
        )
        ends = [s.vertices[np.abs(s.vertices[:, 2]) < 1e-12, :2] for s in (lower, upper)]
        both = shapely.intersection(*(shapely.MultiPoint(end).convex_hull for end in ends))
        found = touches(made([lower, upper]))
        if both.area < 1e-6:
            continue
        (touch,) = found
        assert touch.normal == pytest.approx([0, 0, 1])
        patch = shapely.MultiPoint(touch.points[:, :2]).convex_hull
        assert patch.symmetric_difference(both).area < 1e-8


def test_split_faces_change_neither_volume_nor_centroid():
    random = np.random.default_rng(3)
    for triangles in (False, True):
        for solid in (profile("U", 1.0, 0.8, 0.2), brick(1, 2, 3), tetrahedron(0.1)):
            cut = split(solid, random, triangles=triangles)
            assert len(cut.faces) > len(solid.faces) or len(solid.faces[0]) == 3
            assert cut.volume == pytest.approx(solid.volume)
            assert cut.centroid == pytest.approx(solid.centroid)


def inside(point, faces):
    """Winding number of a closed surface of triangles about a point, over 4 pi."""
    a, b, c = (corner - point for corner in faces)
    lengths = [np.linalg.norm(x, axis=1) for x in (a, b, c)]
    below = lengths[0] * lengths[1] * lengths[2]
    below += sum((x * y).sum(axis=1) * r for x, y, r in ((a, b, lengths[2]), (b, c, lengths[0]), (c, a, lengths[1])))
    return 2 * np.arctan2((a * np.cross(b, c)).sum(axis=1), below).sum() / (4 * np.pi)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_pieces_of_a_solid_fill_its_surface(family):
    for seed in range(3):
        random = np.random.default_rng(seed)
        for solid in scene(seed, family).solids:
            triangles = [np.array([solid.vertices[f[0]], solid.vertices[f[i]], solid.vertices[f[i + 1]]])
                         for f in solid.faces for i in range(1, len(f) - 1)]  # fmt: skip
            corners = np.array(triangles).swapaxes(0, 1)
            low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
            hulls = [hull(piece) for piece in solid.pieces]
            for point in random.uniform(low, high, (20, 3)):
                filled = any(
                    inside(point, np.array([[h.vertices[f[0]], h.vertices[f[i]], h.vertices[f[i + 1]]]
                                            for f in h.faces for i in range(1, len(f) - 1)]).swapaxes(0, 1)) > 0.5
                    for h in hulls
                )  # fmt: skip
                assert filled == (inside(point, corners) > 0.5)
