"""A face that a mesh leaves in pieces has the rim of the whole face: round a hole, and where corners are listed twice.

The stones over the hole are as wide as it is. They touch its rim edge along edge, corner on corner or corner on edge
only, where forces have no definite direction, and the least bit narrower they fall through. So nothing is proven of
them, however the mesh divides the plate.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, LoadOutcome, Outcome, assess, box, find_interfaces, limit_load
from blockstat.contact.unresolved import unresolved_contacts

RIM, HOLE, DEPTH = 1.0, 0.3, 0.3
SQUARE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]


def welded(polygons):
    """A block of polygons, corners at one place once."""
    numbers = {}
    faces = [[numbers.setdefault(tuple(float(x) for x in point), len(numbers)) for point in ring] for ring in polygons]
    return Block(np.array(list(numbers)), faces)


def unwelded(block):
    """The same block with the corners of each face listed for themselves."""
    vertices = np.asarray(block.vertices, dtype=float)
    count = np.cumsum([0, *map(len, block.faces)])
    rings = [list(range(a, b)) for a, b in zip(count[:-1], count[1:], strict=True)]
    return Block(np.concatenate([vertices[list(face)] for face in block.faces]), rings)


def plate(pieces, outer, inner):
    """A plate of which the top and the bottom are these pieces, counter-clockwise from above, with its two outlines."""
    polygons = [[(x, y, 0) for x, y in piece] for piece in pieces]
    polygons += [[(x, y, -DEPTH) for x, y in piece[::-1]] for piece in pieces]
    for ring in (outer, inner[::-1]):
        for (x, y), (u, v) in zip(ring, ring[1:] + ring[:1], strict=True):
            polygons.append([(x, y, -DEPTH), (u, v, -DEPTH), (u, v, 0), (x, y, 0)])
    return welded(polygons)


def corners(size):
    return [(size * x, size * y) for x, y in SQUARE]


def trapezia():
    outer, inner = corners(RIM), corners(HOLE)
    return [[outer[k], outer[k - 3], inner[k - 3], inner[k]] for k in range(4)]


def in_trapezia():
    return plate(trapezia(), corners(RIM), corners(HOLE))


def in_triangles(diagonals):
    """Each trapezium cut along one of its diagonals."""
    pieces = []
    for (a, b, c, d), other in zip(trapezia(), diagonals, strict=True):
        pieces += [[a, b, d], [b, c, d]] if other else [[a, b, c], [a, c, d]]
    return plate(pieces, corners(RIM), corners(HOLE))


def in_squares():
    """The grid of three by three without its middle."""
    ticks = [-RIM, -HOLE, HOLE, RIM]
    cells = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    pieces = [[(ticks[i + a], ticks[j + b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))] for i, j in cells]
    outer = [*((t, -RIM) for t in ticks[:3]), *((RIM, t) for t in ticks[:3])]
    outer += [*((t, RIM) for t in ticks[:0:-1]), *((-RIM, t) for t in ticks[:0:-1])]
    return plate(pieces, outer, corners(HOLE))


def middles():
    """The outline of the hole with a vertex in the middle of each side."""
    ring = corners(HOLE)
    both = [
        [one, ((one[0] + two[0]) / 2, (one[1] + two[1]) / 2)]
        for one, two in zip(ring, ring[1:] + ring[:1], strict=True)
    ]
    return [point for pair in both for point in pair]


def in_fans():
    """Triangles of which three meet in the middle of each side of the hole: the one between has only joins there."""
    ring, pieces = middles(), []
    for k, (a, b, c, d) in enumerate(trapezia()):
        middle = ring[2 * k + 1]
        pieces += [[a, middle, d], [a, b, middle], [b, c, middle]]
    return plate(pieces, corners(RIM), ring)


def with_slivers():
    """Trapezia that know nothing of the vertices in the middle of the sides, and faces without width that do."""
    ring = middles()
    slivers = [[d, c, m] for (_, _, c, d), m in zip(trapezia(), ring[1::2], strict=True)]
    return plate([*trapezia(), *slivers], corners(RIM), ring)


DIVISIONS = {
    "trapezia": in_trapezia(),
    "triangles": in_triangles([0, 0, 0, 0]),
    "other triangles": in_triangles([1, 1, 1, 1]),
    "mixed triangles": in_triangles([0, 1, 0, 1]),
    "squares": in_squares(),
    "fans": in_fans(),
    "slivers": with_slivers(),
}
PLATES = [pytest.param(block, id=name) for name, block in DIVISIONS.items()]
PLATES += [pytest.param(unwelded(block), id=f"{name}, unwelded") for name, block in DIVISIONS.items()]


def upright(ring, height):
    """A right prism on an outline at z = 0."""
    n = len(ring)
    sides = [[i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)]
    vertices = [(x, y, z) for z in (0, height) for x, y in ring]
    return Block(np.array(vertices, dtype=float), [list(range(n))[::-1], list(range(n, 2 * n)), *sides])


#: As wide as the hole: both ways, one way, and from corner to corner.
STONES = {
    "cube": box((-HOLE, -HOLE, 0), (HOLE, HOLE, 2 * HOLE)),
    "bar": box((-HOLE, -0.2, 0), (HOLE, 0.2, 0.5)),
    "diamond": upright([(HOLE, 0), (0, HOLE), (-HOLE, 0), (0, -HOLE)], 0.5),
}
TURNED = Rotation.from_euler("xyz", [230, 337, 158], degrees=True).as_matrix()
PLACES = {
    "as drawn": (np.eye(3), (0, 0, 0)),
    "mirrored": (np.diag([-1.0, 1, 1]), (0, 0, 0)),
    "turned": (TURNED, (0, 0, 0)),
    "UTM": (np.eye(3), (5e5, 5.4e6, 300)),
    "small": (1e-2 * np.eye(3), (0, 0, 0)),
    "large": (30 * TURNED, (0, 0, 0)),
}


def placed(blocks, place="as drawn", *, swapped=False, friction=0.7):
    """The blocks, the first of them a support, at one of the places, and the direction that was x."""
    matrix, offset = PLACES[place]
    turn = matrix / np.cbrt(abs(np.linalg.det(matrix)))
    flip = 1 if np.linalg.det(matrix) > 0 else -1
    moved = [Block(np.asarray(b.vertices) @ matrix.T + offset, [list(f)[::flip] for f in b.faces]) for b in blocks]
    last = len(moved) - 1
    asm = Assembly.from_blocks(
        moved[::-1] if swapped else moved,
        supports=[last if swapped else 0],
        friction=friction,
        gravity=turn @ [0, 0, -9.81],
    )
    return asm, turn @ [1, 0, 0]


def expect_nothing_proven(asm, push):
    found = find_interfaces(asm)
    assert found.contacts == {"face": 0, "edge": 0, "corner": 0, "crossing": 0}
    assert len(unresolved_contacts(asm, found).pair) >= 4
    assert assess(asm).outcome is Outcome.UNDECIDED
    limit = limit_load(asm, push)
    assert (limit.outcome, limit.lower, limit.upper) == (LoadOutcome.UNDECIDED, -np.inf, np.inf)


@pytest.mark.parametrize("stone", STONES)
@pytest.mark.parametrize("ground", PLATES)
def test_a_stone_as_wide_as_a_hole_is_not_carried_by_its_rim(ground, stone):
    expect_nothing_proven(*placed([ground, STONES[stone]]))


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("division", ["triangles", "squares"])
def test_nor_in_any_place_size_or_order(division, place, swapped):
    expect_nothing_proven(*placed([DIVISIONS[division], STONES["cube"]], place, swapped=swapped))


@pytest.mark.parametrize("stone", STONES)
@pytest.mark.parametrize("ground", PLATES)
def test_nor_where_it_is_wider_by_less_than_it_is_lifted(ground, stone):
    """The overlap of .1 mm is narrower than the gap of 1 mm: the blocks are beside each other, and not a joint."""
    wider = np.array([1 + 1e-4 / HOLE, 1 + 1e-4 / HOLE if stone != "bar" else 1, 1])
    lifted = Block(np.asarray(STONES[stone].vertices) * wider + [0, 0, 1e-3], STONES[stone].faces)
    asm, push = placed([ground, lifted])
    assert find_interfaces(asm).n_interfaces == 0
    assert not limit_load(asm, push).lower > 0


def ledge(*, in_squares):
    """A prism along x over all quadrants of the plane y, z but the first."""
    if not in_squares:
        faces = [[(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)]]
        outline = faces[0]
    else:
        faces = [[(y, z), (y + 1, z), (y + 1, z + 1), (y, z + 1)] for y, z in ((-1, -1), (0, -1), (-1, 0))]
        outline = [(-1, -1), (0, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1), (-1, 0)]
    polygons = [[(x, y, z) for y, z in face[::step]] for face in faces for x, step in ((0, -1), (1, 1))]
    for (y, z), (v, w) in zip(outline, outline[1:] + outline[:1], strict=True):
        polygons.append([(0, y, z), (0, v, w), (1, v, w), (1, y, z)])
    return welded(polygons)


def triangulated(block):
    vertices = np.asarray(block.vertices, dtype=float)
    return Block(vertices, [[f[0], f[i], f[i + 1]] for f in block.faces for i in range(1, len(f) - 1)])


WHOLE, SQUARES = ledge(in_squares=False), ledge(in_squares=True)
LEDGES = {"whole": WHOLE, "squares": SQUARES, "triangles": triangulated(WHOLE), "squares cut": triangulated(SQUARES)}
LEDGES |= {f"{name}, unwelded": unwelded(block) for name, block in LEDGES.items()}


@pytest.mark.parametrize("place", ["as drawn", "turned", "UTM"])
@pytest.mark.parametrize("division", LEDGES)
def test_a_stone_beside_the_re_entrant_corner_of_a_face_slides_past_it(division, place):
    """The cube fills the first quadrant up to the ledge and meets it in two edges, along which it slides past it.

    Only the ground carries it: up to the coefficient of friction, as .49 m of base under a centre .5 m high carry .98.
    """
    ground, cube = box((-1.2, -0.2, -0.5), (-0.01, 1.2, 0)), box((-1, 0, 0), (0, 1, 1))
    matrix, offset = PLACES[place]
    moved = [Block(np.asarray(b.vertices) @ matrix.T + offset, b.faces) for b in (ground, LEDGES[division], cube)]
    asm = Assembly.from_blocks(moved, supports=[0, 1], friction=0.7, gravity=matrix @ [0, 0, -9.81])
    assert find_interfaces(asm).contacts == {"face": 1, "edge": 0, "corner": 0, "crossing": 0}
    assert limit_load(asm, matrix @ [1, 0, 0]).lower == pytest.approx(0.7, rel=1e-6)
    steep = assess(asm, gravity=matrix @ [7.6, 0, -10])
    assert steep.outcome is Outcome.UNDECIDED


def table(reach=0.65, rise=0.2, height=0.5):
    """A slab on four points, which are the corners of its folded underside."""
    feet, low = corners(reach), rise
    middle = [(0, -reach), (reach, 0), (0, reach), (-reach, 0)]
    vertices = [(x, y, 0) for x, y in feet] + [(x, y, low) for x, y in middle] + [(0, 0, low)]
    vertices += [(x, y, height) for x, y in feet]
    faces = [[9, 10, 11, 12]]
    for k in range(4):
        following = (k + 1) % 4
        faces += [[8, 4 + k, k], [8, following, 4 + k], [k, 4 + k, following, 9 + following, 9 + k]]
    return Block(np.array(vertices, dtype=float), faces)


@pytest.mark.parametrize("ground", PLATES)
def test_feet_on_the_joins_of_a_divided_plate_are_carried(ground):
    """The feet stand where pieces meet, with the plate all round. Four feet slide when the push is mu times the weight.

    The feet are .65 m from the middle and no part is higher than .5 m, so the table does not tip at 30 percent.
    """
    asm, push = placed([ground, table()], friction=0.3)
    assert find_interfaces(asm).contacts == {"face": 0, "edge": 0, "corner": 4, "crossing": 0}
    assert assess(asm).outcome is Outcome.STABLE
    limit = limit_load(asm, push)
    assert (limit.lower, limit.upper) == pytest.approx((0.3, 0.3), rel=1e-6)


def trestle(half=HOLE, length=1.8):
    """A prism along x on two ridges that are as far apart as the hole is wide."""
    section = [(-half, 0), (0, 0.2), (half, 0), (half, 0.5), (-half, 0.5)]
    vertices = [(x, y, z) for x in (-length / 2, length / 2) for y, z in section]
    sides = [[i, (i + 1) % 5, (i + 1) % 5 + 5, i + 5] for i in range(5)]
    return Block(np.array(vertices, dtype=float), [[4, 3, 2, 1, 0], [5, 6, 7, 8, 9], *sides])


@pytest.mark.parametrize("ground", PLATES)
def test_ridges_along_the_rim_of_a_hole_are_carried_beyond_it(ground):
    """Each ridge runs along a side of the hole, and on the plate before and after: there it is an edge on a face.

    The ridges are 1.8 m long and no part is higher than .5 m, so the trestle slides along them when the push is mu
    times the weight.
    """
    asm, push = placed([ground, trestle()], friction=0.3)
    assert find_interfaces(asm).contacts == {"face": 0, "edge": 2, "corner": 0, "crossing": 0}
    assert assess(asm).outcome is Outcome.STABLE
    limit = limit_load(asm, push)
    assert (limit.lower, limit.upper) == pytest.approx((0.3, 0.3), rel=1e-6)
