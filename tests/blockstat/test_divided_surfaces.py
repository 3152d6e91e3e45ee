"""Blocks as meshes divide them: faces without width, vertices on straight edges, corners listed twice, steps of
millimetres, solids inside out. What touches and what is carried is that of the stone, in any position."""

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, InputError, Outcome, assess, box, find_interfaces, limit_load, overlaps, repair
from blockstat.geometry.topology import edge_topology

GROUND = box((-1, -1, -1), (2, 2, 0))


def turn(a, b, c):
    def about(angle, axis):
        sine, cosine, (i, j) = np.sin(angle), np.cos(angle), [k for k in range(3) if k != axis]
        matrix = np.eye(3)
        matrix[[i, i, j, j], [i, j, i, j]] = cosine, -sine, sine, cosine
        return matrix

    return about(a, 2) @ about(b, 0) @ about(c, 2)


POSITIONS = [pytest.param(np.eye(3), id="as drawn"), pytest.param(turn(0.3, 0.7, 1.1), id="turned")]


def placed(blocks, position, **options):
    turned = [Block(np.asarray(block.vertices, dtype=float) @ position.T, block.faces) for block in blocks]
    return Assembly.from_blocks(turned, gravity=position @ [0, 0, -9.81], **options)


def prism(outline, start, end, first=0):
    """An outline in x and z, counter-clockwise seen against y, from one y to another; its faces begin with any."""
    n = len(outline)
    vertices = [(x, y, z) for y in (start, end) for x, z in outline]
    faces = [[*range(n)], [*range(2 * n - 1, n - 1, -1)], *([i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n))]
    faces = faces[first:] + faces[:first]
    return Block(np.array(vertices, dtype=float), faces)


def slab(low, high, *, sliver):
    """A slab of which one edge has a vertex in its middle, and a face without width beside it."""
    corners = np.array([(x, y, z) for z in (low, high) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))] + [(0.5, 0, high)])
    front = [[0, 1, 5, 8, 4], [5, 4, 8]] if sliver else [[0, 1, 5, 4]]
    return Block(corners, [[0, 3, 2, 1], [4, 5, 6, 7], *front, [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


def ridge_along_y(x):
    return prism([(x - 0.2, -0.5), (x + 0.2, -0.5), (x, 0)], -0.5, 1.5)


@pytest.mark.parametrize("position", POSITIONS)
@pytest.mark.parametrize("sliver", [False, True])
def test_a_face_without_width_hides_no_overlap_and_no_contact(position, sliver):
    sunk = placed([GROUND, slab(-0.5, 0.5, sliver=sliver)], position, supports=[0])
    with pytest.raises(InputError, match=r"overlap by 0\.5 m"):
        assess(sunk)
    # A ball of .5 m fits into what two blocks share of 1 by 1 by .5 m.
    assert overlaps(sunk, gap=0.01)[1] == pytest.approx([0.5], rel=1e-6)
    carried = placed([ridge_along_y(0.2), ridge_along_y(0.8), slab(0, 0.3, sliver=sliver)], position, supports=[0, 1])
    assert find_interfaces(carried).contacts["edge"] == 2
    assert assess(carried).outcome is Outcome.STABLE


def test_two_faces_without_width_side_by_side_lie_in_the_planes_beside_them():
    corners = np.array(
        [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))] + [(0.3, 0, 1), (0.6, 0, 1)]
    )
    faces = [
        [0, 3, 2, 1],
        [4, 5, 6, 7],
        [0, 1, 5, 9, 8, 4],
        [5, 4, 8],
        [5, 8, 9],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ]
    cube = Assembly.from_blocks([Block(corners, faces)])
    normal = cube.planes.normal[[3, 4]]
    for own in normal:
        assert own.tolist() in ([0, 0, 1], [0, -1, 0])


@pytest.mark.parametrize("width", [1e-7, 1e-8])
def test_the_narrow_top_of_a_ridge_lies_in_no_plane_beside_it(width):
    ridge = Assembly.from_blocks([prism([(-1, -1), (1, -1), (width / 2, 0), (-width / 2, 0)], 0, 1)])
    top = np.argmax(ridge.planes.centre[:, 2])
    assert ridge.planes.normal[top].tolist() == pytest.approx([0, 0, 1], abs=1e-6)


SLOPE = np.tan(np.deg2rad(50))
#: A ledge whose edge has 50 degrees, and a stone that reaches round it.
LEDGE = prism([(-3, -SLOPE), (-1, -SLOPE), (0, 0), (-3, 0)], 0, 1)
ROUND_IT = prism([(-0.25, -0.25 * SLOPE), (0.3, -0.25 * SLOPE), (0.3, 0.5), (-2, 0.5), (-2, 0), (0, 0)], 0, 1)


def with_a_vertex_on_its_edge(ledge, share):
    """The ledge with a vertex on its edge from 2 to 6, in one of the faces there, and a face without width."""
    corners = 0.82 * np.asarray(ledge.vertices, dtype=float)
    faces = [list(face) for face in ledge.faces]
    face = next(face for face in faces if (2, 6) in zip(face, face[1:] + face[:1], strict=True))
    face.insert(face.index(2) + 1, len(corners))
    return Block(np.vstack([corners, (1 - share) * corners[2] + share * corners[6]]), [*faces, [2, 6, 8]])


@pytest.mark.parametrize("divided", [False, True])
def test_a_face_without_width_at_an_acute_edge_holds_no_stone(divided):
    """The stone lifts off the slope of the ledge as it slides on the top, so that friction alone carries."""
    position = Rotation.from_euler("xyz", [230, 337, 158], degrees=True).as_matrix()
    stone = Block(0.82 * np.asarray(ROUND_IT.vertices, dtype=float), ROUND_IT.faces)
    plain = Block(0.82 * np.asarray(LEDGE.vertices, dtype=float), LEDGE.faces)
    ledge = with_a_vertex_on_its_edge(LEDGE, 0.888) if divided else plain
    asm = placed([ledge, stone], position, supports=[0], friction=0.3)
    assert find_interfaces(asm).contacts == {"face": 2, "edge": 0, "corner": 0, "crossing": 0}
    found = limit_load(asm, position @ [1, 0, 0])
    assert (found.lower, found.upper) == pytest.approx((0.3, 0.3), rel=1e-6)
    assert assess(asm, gravity=position @ [9.81 * np.sin(0.61), 0, -9.81 * np.cos(0.61)]).outcome is Outcome.UNSTABLE


def test_a_face_without_width_at_an_acute_edge_looks_between_the_faces_beside_it():
    """Those beside it make 130 degrees, so that nothing between them is further than 65 degrees from their bisector."""
    block = with_a_vertex_on_its_edge(LEDGE, 0.888)
    bisector = np.array([np.sin(np.deg2rad(65)), 0, np.cos(np.deg2rad(65))])
    for turned in Rotation.random(200, random_state=0).as_matrix():
        normal = placed([block], turned).planes.normal[-1]
        assert normal @ turned @ bisector >= np.cos(np.deg2rad(65)) - 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_a_face_of_single_precision_that_has_no_width_hides_no_overlap(seed):
    """In single precision its normal is any; the cube is sunk by half of its side and turned."""
    position = turn(*np.random.default_rng(seed).uniform(0, 3, 3))
    sunk = slab(-0.5, 0.5, sliver=True)
    turned = [(np.asarray(own.vertices, dtype=float) @ position.T).astype(np.float32) for own in (GROUND, sunk)]
    blocks = [Block(place.astype(float), own.faces) for place, own in zip(turned, (GROUND, sunk), strict=True)]
    _, depth = overlaps(Assembly.from_blocks(blocks, supports=[0]), gap=0.01)
    assert depth == pytest.approx([0.5], rel=1e-4)


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_what_has_a_face_without_width_is_repaired():
    mended, report = repair(Assembly.from_blocks([GROUND, slab(0, 1, sliver=True)], supports=[0]))
    assert mended.volume[1] == pytest.approx(1.0, rel=1e-12)
    assert not report.overlaps


def ridge_along_x(*cuts):
    """A ridge from x = -1 to 1 of which the edge has vertices in between."""
    places = (-1, *cuts, 1)
    top = [*range(4, 4 + len(places))]
    corners = [(-1, -0.3, -0.5), (-1, 0.3, -0.5), (1, -0.3, -0.5), (1, 0.3, -0.5), *((x, 0, 0) for x in places)]
    return Block(np.array(corners), [[0, 1, 3, 2], [0, 2, *top[::-1]], [3, 1, *top], [0, 4, 1], [2, 3, top[-1]]])


@pytest.mark.parametrize("position", POSITIONS)
@pytest.mark.parametrize("gap", [0.0, 0.003])
@pytest.mark.parametrize(
    "cuts", [(), (0,), (0.3,), (0.002,), (-0.5, -0.2, 0, 0.1, 0.7), tuple(np.arange(-0.99, 1, 0.004))]
)
def test_a_vertex_on_a_straight_edge_does_not_divide_it(cuts, gap, position):
    keel = prism([(0, gap), (0.3, 0.5 + gap), (-0.3, 0.5 + gap)], -1, 1)
    crossed = placed([ridge_along_x(*cuts), keel], position, supports=[0])
    assert find_interfaces(crossed).contacts["crossing"] == 1
    assert assess(crossed).outcome is Outcome.STABLE


def test_corners_that_are_listed_twice_are_one():
    """Two pyramids base to base on their apex, which a collapsed face lists twice."""
    corners = [(0.5, 0, 0.5), (0, 0.5, 0.5), (-0.5, 0, 0.5), (0, -0.5, 0.5), (0, 0, 1), (0, 0, 0), (0, 0, 0)]
    faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5, 6], [3, 2, 6], [0, 3, 6, 5]]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        top = Assembly.from_blocks([box((-2, -2, -1), (2, 2, 0)), Block(np.array(corners), faces)], supports=[0])
        assert find_interfaces(top).contacts["corner"] == 1
    assert assess(top).outcome is Outcome.STABLE


@pytest.mark.parametrize("position", POSITIONS)
def test_an_edge_that_touches_is_not_held_open_by_a_pad_beside_it(position):
    """A beam on a pad and on a ridge of the height of the pad, with its weight between them."""
    base = prism([(-1, -1), (1.75, -1), (1.7, 0.004), (1.696, 0), (-1, 0)], -1, 1)
    pad, beam = box((0.1, -0.15, 0), (0.5, 0.15, 0.004)), box((0, -0.15, 0.004), (2, 0.15, 0.304))
    assembly = placed([base, pad, beam], position, supports=[0])
    assert find_interfaces(assembly).contacts["edge"] == 1
    assert assess(assembly).outcome is Outcome.STABLE


@pytest.mark.parametrize("first", [0, 3])
def test_a_step_of_some_millimetres_is_no_single_plane(first):
    """A block with a foot on each side of a step tips about the outer end of either foot."""
    step = 0.008
    lower = prism([(-1, -1), (2, -1), (2, -step), (0.5, -step), (0.5, 0), (-1, 0)], -1, 2, first)
    feet = [(0, 0), (0.3, 0), (0.3, 0.2), (0.7, 0.2), (0.7, -step), (1, -step), (1, 1), (0, 1)]
    block = Assembly.from_blocks([lower, prism(feet, 0, 1, first)], supports=[0], friction=10.0)
    x, _, z = block.centroid[1]
    assert limit_load(block, (1, 0, 0)).lower == pytest.approx((1 - x) / (z + step), rel=1e-4)
    assert limit_load(block, (-1, 0, 0)).lower == pytest.approx(x / z, rel=1e-4)


def of_two(one, two, *, turned):
    faces = [[k + len(one.vertices) for k in (face[::-1] if turned else face)] for face in two.faces]
    return Block(np.vstack([one.vertices, two.vertices]), [*map(list, one.faces), *faces])


def test_a_solid_inside_out_is_refused_and_a_cavity_is_not():
    beside = of_two(box((0, 0, 0), (1, 1, 1)), box((1.5, 0, 0), (2.4, 1, 1)), turned=True)
    with pytest.raises(InputError, match="one of its surfaces looks the wrong way"):
        Assembly.from_blocks([beside])
    hollow = of_two(box((0, 0, 0), (1, 1, 1)), box((0.2, 0.2, 0.2), (0.8, 0.8, 0.8)), turned=True)
    with pytest.warns(match=r'^1 blocks have cavities \(the first is "block0"\)$'):
        assert Assembly.from_blocks([hollow]).volume[0] == pytest.approx(1 - 0.6**3, rel=1e-12)


@pytest.mark.parametrize(("thickness", "low"), [(0.0005, -0.3), (0.002, -0.3), (0.002, -0.001)])
def test_a_plate_inside_the_ground_overlaps_it(thickness, low):
    with pytest.raises(InputError, match=r"lies inside|overlap"):
        assess(Assembly.from_blocks([GROUND, box((0, 0, low), (1, 1, low + thickness))], supports=[0]))


@pytest.mark.parametrize("face", [None, 3, ["a", 1, 2], [0, 1.5, 2], [float("nan"), 1, 2]])
def test_faces_that_are_no_numbers_of_corners_are_refused(face):
    with pytest.raises(InputError, match=r"face 0 is .*; it needs the numbers of its corners"):
        Assembly.from_blocks([Block(GROUND.vertices, [face, *list(GROUND.faces)[1:]])])


def saddle(low, high, below, above, first, face):
    """A cube whose lower and upper faces bend by so much up and down at their corners; one face begins elsewhere."""
    plan, way = ((0, 0), (1, 0), (1, 1), (0, 1)), (-1, 1, -1, 1)
    corners = [
        (*at, z + bend * up) for z, bend in ((low, below), (high, above)) for at, up in zip(plan, way, strict=True)
    ]
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    faces[face] = faces[face][first:] + faces[face][:first]
    return Block(np.array(corners, dtype=float), faces)


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("bend", [0.02, 0.1, 0.3])
def test_blocks_that_share_a_warped_face_do_not_overlap_wherever_it_begins(first, bend):
    pair = Assembly.from_blocks([saddle(0, 1, 0, bend, first, 1), saddle(1, 2, bend, 0, 0, 0)], supports=[0])
    assert not len(overlaps(pair, gap=0.01)[0])
    assert find_interfaces(pair).contacts["face"] == 1


@pytest.mark.parametrize("facets", [400, 1600])
def test_an_edge_that_bends_little_by_little_is_no_chord(facets):
    """A stone with a hollow underside, 28 mm high in its middle, over a pedestal as high as its ends."""
    angle = np.linspace(0.075, -0.075, facets + 1)
    hollow = np.column_stack([10 * np.sin(angle), 10 * np.cos(angle) - 10 * np.cos(0.075)])
    stone = prism([*hollow.tolist()[::-1], (hollow[0, 0], 0.5), (hollow[-1, 0], 0.5)], 0, 0.5)
    scene = Assembly.from_blocks([box((-0.1, -0.5, -0.3), (0.1, 1, 0)), stone], supports=[0])
    assert find_interfaces(scene).n_interfaces == 0
    assert assess(scene).outcome is Outcome.UNSTABLE


def test_a_ring_of_edges_is_no_line():
    """Edges of so many sides turn by less than what counts as a turn."""
    sides = 70_000
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = Assembly.from_blocks([prism(np.column_stack([np.cos(angle), np.sin(angle)]).tolist(), 0, 1)])
    assert len(edge_topology(ring, np.array([0])).edge) == 2 * sides


def cube_with(kind, low):
    """A cube with a face without area: of three corners at one place, or of two at one end of an edge."""
    cube = box((0, 0, low), (1, 1, low + 1))
    corners, faces = [tuple(map(float, at)) for at in cube.vertices], [list(face) for face in cube.faces]
    a, b = faces[0][:2]
    if kind == "point":
        faces.append([len(corners), len(corners) + 1, len(corners) + 2])
        corners += [corners[a]] * 3
    elif kind == "needle":
        faces = [[len(corners) if k == a else k for k in faces[0]], *faces[1:], [a, b, len(corners)]]
        corners += [corners[a]]
    return Block(np.array(corners), faces)


@pytest.mark.filterwarnings("ignore:1 blocks hold|2 blocks hold")
@pytest.mark.parametrize("kind", ["plain", "point", "needle"])
def test_a_face_whose_corners_coincide_hides_no_overlap_and_no_contact(kind):
    sunk = Assembly.from_blocks([cube_with(kind, 0), cube_with(kind, 0.5)], supports=[0])
    assert overlaps(sunk, gap=0.01)[1] == pytest.approx([0.5], rel=1e-6)
    on_edge = cube_with(kind, 0)
    turned = np.asarray(on_edge.vertices) @ turn(0, np.pi / 4, 0).T
    turned[:, 2] -= turned[:, 2].min()
    rests = Assembly.from_blocks([box((-3, -3, -1), (3, 3, 0)), Block(turned, on_edge.faces)], supports=[0])
    assert find_interfaces(rests).contacts["edge"] == 1


@pytest.mark.filterwarnings("ignore:1 blocks hold")
def test_a_stone_in_a_cavity_of_a_stone_may_have_a_cavity():
    def nested(*turned):
        shells = [box([(8 - side) / 2] * 3, [(8 + side) / 2] * 3) for side in (8, 6, 4, 2)]
        whole = shells[0]
        for shell, inwards in zip(shells[1:], turned, strict=True):
            whole = of_two(whole, shell, turned=inwards)
        return Assembly.from_blocks([whole])

    assert nested(True, False, True).volume[0] == pytest.approx(8**3 - 6**3 + 4**3 - 2**3, rel=1e-12)
    for wrong in ((True, True, False), (False, True, False), (True, True, True)):
        with pytest.raises(InputError, match="one of its surfaces looks the wrong way"):
            nested(*wrong)


def in_triangles(block, first=0):
    """A block whose faces of four corners are two triangles each, cut at one diagonal or the other."""
    faces = []
    for face in block.faces:
        a, b, c, d = np.roll(face, first) if len(face) == 4 else [None] * 4
        faces += [[a, b, c], [a, c, d]] if len(face) == 4 else [list(face)]
    return Block(np.array(block.vertices), faces)


def in_single_precision(block):
    return Block(np.asarray(block.vertices, dtype=np.float32).astype(float), block.faces)


def stone_at_a_wall(off, sunk, made):
    """A stone that leans away from a wall, so far off it and so deep in the floor, and a stone 20 m away."""
    floor = prism([(-0.2, -0.3), (1, -0.3), (1, 0), (0, 0), (0, 0.2), (-0.2, 0.2)], 0.0, 0.4)
    foot = np.array([(0, 0), (0.3, 0), (0.345, 0.4), (0.045, 0.4)]) + (off, -sunk)
    blocks = [made(floor), made(prism(foot, 0.0012, 0.4012)), box((20, 0, -1), (21, 1, 0))]
    return Assembly.from_blocks(blocks, supports=[0, 2], friction=0.4)


MADE = {
    "whole": lambda block: block,
    "triangles": in_triangles,
    "other diagonals": lambda block: in_triangles(block, 1),
    "single precision": in_single_precision,
    "triangles in single precision": lambda block: in_single_precision(in_triangles(block)),
}


@pytest.mark.parametrize("made", MADE.values(), ids=MADE)
@pytest.mark.parametrize("sunk", [0.0, 1e-6, 2e-4, 1e-3])
@pytest.mark.parametrize("off", [0.0, 0.0015])
def test_a_stone_keeps_its_contact_at_the_foot_of_a_wall_however_it_is_divided_and_sunk(made, sunk, off):
    # Pushed to the wall it rocks about its foot, which contacts have in the middle of the overlap. Friction of the wall
    # adds its moment about the foot of the bed, half of the gap away: at most mu (a + mu) / (1 - mu2) of the weight.
    found = limit_load(stone_at_a_wall(off, sunk, made), (-1, 0, 0))
    rocks = 0.1725 / (0.2 - sunk / 2)
    rubs = 0.4 * (0.9 + 0.4) / (1 - 0.4**2) * off / 2 / 0.2
    assert rocks * (1 - 1e-4) <= found.lower <= found.upper <= (rocks + rubs) * (1 + 1e-4)


@pytest.mark.parametrize("made", MADE.values(), ids=MADE)
@pytest.mark.parametrize("sunk", [1e-6, 2e-4, 1e-3])
def test_a_stone_beyond_the_reach_of_a_wall_slides_to_it(made, sunk):
    found = limit_load(stone_at_a_wall(0.02, sunk, made), (-1, 0, 0))
    assert (found.lower, found.upper) == pytest.approx((0.4, 0.4), rel=1e-4)


@pytest.mark.parametrize("first", range(2))
def test_a_bed_that_is_open_beyond_the_tolerance_at_one_end_is_none_in_triangles_either(first):
    # A stone on one edge of its bed, which is open by 9.6 mm at the other end: nothing holds it up there.
    lean = Rotation.from_euler("y", -np.arcsin(0.0096 / 1.0)).as_matrix()
    stone = Block(np.asarray(box((0, 0, 0), (1, 0.6, 0.7)).vertices) @ lean.T, box((0, 0, 0), (1, 1, 1)).faces)
    for blocks in ([GROUND, stone], [in_triangles(GROUND, first), in_triangles(stone, 1 - first)]):
        asm = Assembly.from_blocks(blocks, supports=[0])
        assert not find_interfaces(asm).contacts["face"]
        assert assess(asm).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("load", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
def test_a_face_of_slender_triangles_is_as_wide_as_it_is(load):
    # A cube of .3 m, .5 mm above its bed; its lower face is a fan to 300 points of one edge. Contacts are half way.
    across = np.linspace(0.3, 0, 301)
    lower = [(0, 0), (0.3, 0), *((x, 0.3) for x in across)]
    m = len(lower)
    corners = [(x, y, 0.0005) for x, y in lower] + [(x, y, 0.3005) for x, y in ((0, 0), (0.3, 0), (0.3, 0.3), (0, 0.3))]
    fan = [[0, k + 1, k] for k in range(1, m - 1)]
    sides = [[m, m + 1, m + 2, m + 3], [0, 1, m + 1, m], [1, 2, m + 2, m + 1], [m - 1, 0, m, m + 3]]
    cube = Block(np.array(corners), [*fan, *sides, [*range(2, m), m + 3, m + 2]])
    found = limit_load(Assembly.from_blocks([GROUND, cube], supports=[0], friction=1.2), load)
    assert (found.lower, found.upper) == pytest.approx([0.15 / 0.15025] * 2, rel=1e-5)


@pytest.mark.parametrize("off", [0.0, 0.0009, 0.0011, 0.0024])
def test_a_bed_that_overlaps_brings_no_part_of_a_stone_that_is_not_at_it_to_a_wall(off):
    # A stone on two steps slides below a beam that is 1 mm above its top, however deep it stands in the lower step.
    steps = [(-0.5, -0.5), (0.6, -0.5), (0.6, 0.6), (0, 0.6), (0, 0.3), (0.4, 0.3), (0.4, -0.02), (-0.05, -0.02)]
    foot = [(-0.3, 0), (-0.12, 0), (-0.04, 0.03), (-0.04, -0.02 - off), (0, -0.02 - off), (0, 0.299), (-0.3, 0.299)]
    blocks = [prism([*steps, (-0.1, 0), (-0.5, 0)], -0.1, 0.5), prism(foot, 0, 0.3)]
    found = limit_load(Assembly.from_blocks(blocks, supports=[0], friction=0.4), (1, 0, 0))
    assert (found.lower, found.upper) == pytest.approx((0.4, 0.4), rel=1e-5)


@pytest.mark.parametrize(("gap", "sunk"), [(0.0026, 0.0005), (0.0028, 0.001), (0.0032, 0.002)])
def test_a_bed_that_slopes_brings_no_stone_to_a_wall_beyond_the_tolerance(gap, sunk):
    # Down a slope of 30 degrees to a wall further off than 2.5 mm; the stone is sunk vertically.
    slope = np.tan(np.deg2rad(30))
    wall = [(-0.5, -1), (0.4, -1), (0.4, 0.3 - 0.05 * slope), (0.05, 0.3 - 0.05 * slope), (0.05, -0.05 * slope)]
    end = 0.05 - gap
    foot = np.array([(end - 0.2, 0), (end, 0), (end - 0.06, 0.3), (end - 0.26, 0.3)])
    foot[:, 1] -= slope * np.array([end - 0.2, end, end, end - 0.2]) + sunk
    blocks = [prism([*wall, (-0.5, 0.5 * slope)], -0.1, 0.4), prism(foot, 0, 0.3)]
    found = limit_load(Assembly.from_blocks(blocks, supports=[0], friction=0.7), (1, 0, 0))
    slides = np.tan(np.arctan(0.7) - np.deg2rad(30))
    assert (found.lower, found.upper) == pytest.approx((slides, slides), rel=1e-4)


def grid(block, n, rng):
    """A block of six faces, each of n by n squares in two triangles, with diagonals at random."""
    corners, faces = [], []
    number = {}

    def vertex(point):
        key = tuple(np.round(point, 9))
        if key not in number:
            number[key] = len(corners)
            corners.append(point)
        return number[key]

    for face in block.faces:
        a, b, c, d = np.asarray(block.vertices)[list(face)]
        at = [[vertex((1 - u) * ((1 - v) * a + v * b) + u * ((1 - v) * d + v * c)) for v in np.arange(n + 1) / n]
              for u in np.arange(n + 1) / n]  # fmt: skip
        for i in range(n):
            for j in range(n):
                p, q, r, s = at[i][j], at[i][j + 1], at[i + 1][j + 1], at[i + 1][j]
                faces += [[p, q, r], [p, r, s]] if rng.random() < 0.5 else [[p, q, s], [q, r, s]]
    return np.array(corners), faces


@pytest.mark.parametrize(("seed", "n", "noise"), [(5, 4, 6e-6), (22, 4, 1e-5), (37, 4, 6e-6), (40, 3, 3e-6)])
def test_faces_that_are_plane_nearly_to_single_precision_keep_the_area_of_their_joint(seed, n, noise):
    # The rounding of single precision over 20 m is 4 micrometres.
    rng, blocks = np.random.default_rng(seed), []
    for block in (box((-0.1, -0.15, -0.5), (0.6, 0.6, 0)), box((0, 0, 0), (0.4, 0.4, 0.2))):
        corners, faces = grid(block, n, rng)
        blocks.append(Block(corners + rng.uniform(-noise, noise, corners.shape), faces))
    asm = Assembly.from_blocks([*blocks, box((20, 0, 0), (21, 1, 1))], supports=[0, 2])
    assert find_interfaces(asm).area.sum() == pytest.approx(0.16, rel=1e-3)
