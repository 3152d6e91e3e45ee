"""Blocks on edges and corners: exact limits from first principles.

Each limit follows from the equilibrium of one rigid body on a few contact points with Coulomb friction. The formulas
stand at the tests; the body has unit weight, and a push is a multiple of it.
"""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from blockstat import Block, assess, find_interfaces, limit_load
from blockstat.analysis.verdict import Outcome
from blockstat.contact.features import ContactKind
from evidence.scenes.small import assembly, box

EXACT = 1e-6
FLOOR = box((-9, -9, -1), (9, 9, 0), name="floor")
#: The same scene as it is, turned, far from the origin, and in other units.
PLACES = {
    "here": lambda points: points,
    "turned": lambda points: points @ TURN.T,
    "utm": lambda points: points + [5e5, 5e6, 100],
    "turned, utm": lambda points: points @ TURN.T + [5e5, 5e6, 100],
    "millimetres": lambda points: 1e-3 * points,
    "kilometres": lambda points: 1e3 * points,
}
TURN = Rotation.from_rotvec([0.3, -0.5, 1.1]).as_matrix()


def prism(outline, low, high, **options):
    """A prism along y with an outline in x and z, counter-clockwise seen from -y."""
    n = len(outline)
    vertices = [(x, low, z) for x, z in outline] + [(x, high, z) for x, z in outline]
    sides = [[i, n + i, n + (i + 1) % n, (i + 1) % n] for i in range(n)]
    return Block(vertices, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides], **options)


def moved(block, rotation=None, shift=(0.0, 0.0, 0.0)):
    turn = np.eye(3) if rotation is None else rotation
    return Block(np.asarray(block.vertices, float) @ np.asarray(turn).T + shift, block.faces, block.name)


def hull(points, **options):
    """The convex hull of points, in triangles."""
    points = np.asarray(points, dtype=float)
    found = ConvexHull(points)
    faces = []
    for simplex, plane in zip(found.simplices, found.equations, strict=True):
        a, b, c = points[simplex]
        outward = np.cross(b - a, c - a) @ plane[:3] > 0
        faces.append([int(i) for i in (simplex if outward else simplex[::-1])])
    return Block(points, faces, **options)


def limit(blocks, supports, push, *, place="here", flip=False, friction=0.5, **options):
    """Bounds of the limit load of the last block, its scene moved to a place or its blocks in reverse order."""
    turn = TURN if "turned" in place else np.eye(3)
    blocks = [Block(PLACES[place](np.asarray(b.vertices, float)), b.faces, b.name) for b in blocks]
    if flip:
        blocks, supports = blocks[::-1], [len(blocks) - 1 - k for k in supports]
    scene = assembly(blocks, supports=supports, friction=friction, gravity=turn @ [0, 0, -1.0])
    return limit_load(scene, turn @ np.asarray(push, float), **options)


def agrees(found, exact):
    assert found.lower == pytest.approx(exact, rel=EXACT)
    assert found.upper == pytest.approx(exact, rel=EXACT)


def tetrahedron(dent):
    """Regular, of edge 1, its base pushed in to a point; it stands on three vertices."""
    base = [(np.cos(t) / np.sqrt(3), np.sin(t) / np.sqrt(3), 0) for t in np.deg2rad([0, 120, 240])]
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 4, 2], [2, 4, 3], [3, 4, 1]]
    return Block([(0, 0, np.sqrt(2 / 3)), *base, (0, 0, dent)], faces, name="body")


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("flip", [False, True])
def test_three_vertices_on_a_floor(place, flip):
    # rho / (2 h_c cos delta) with rho = 1 / sqrt 3, h_c = (sqrt(2/3) + c) / 4, delta from the nearest side's normal.
    height = (np.sqrt(2 / 3) + 0.1) / 4
    for angle, delta in ((180, 0.0), (0, 60.0), (165, 15.0)):
        exact = 1 / np.sqrt(3) / (2 * height * np.cos(np.deg2rad(delta)))
        push = (np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle)), 0)
        agrees(limit([FLOOR, tetrahedron(0.1)], [0], push, place=place, flip=flip, friction=10.0), exact)
        agrees(limit([FLOOR, tetrahedron(0.1)], [0], push, place=place, flip=flip, friction=0.5), 0.5)


def ridge(x, **options):
    return prism([(x - 0.2, 0), (x + 0.2, 0), (x, 0.2)], -1, 1, **options)


@pytest.mark.parametrize("place", PLACES)
def test_a_box_on_two_ridges(place):
    # +x: min(mu, 2 (c - e) / h), -x: min(mu, 2 (c + e) / h), y: min(mu, d / h) for 1.0 x .8 x 1.2, c = .3.
    c, depth, height = 0.3, 0.8, 1.2
    for e in (0.0, 0.1):
        body = box((e - 0.5, -0.4, 0.2), (e + 0.5, 0.4, 1.4), name="body")
        blocks = [FLOOR, ridge(-c), ridge(c), body]
        cases = {(1, 0, 0): 2 * (c - e) / height, (-1, 0, 0): 2 * (c + e) / height, (0, 1, 0): depth / height}
        for push, turns in cases.items():
            for mu in (0.8, 0.4):
                agrees(limit(blocks, [0, 1, 2], push, place=place, friction=mu), min(mu, turns))


def crossed_keels():
    """A body with keels along y at x = +-a on ridges along x at y = +-c."""
    a, c = 0.2, 0.35
    feet = [(-0.4, 0.3), (-0.3, 0.3), (-a, 0), (-0.1, 0.3), (0.1, 0.3), (a, 0), (0.3, 0.3), (0.4, 0.3)]
    body = prism([*feet, (0.4, 0.7), (-0.4, 0.7)], -1, 1, name="body")
    across = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
    rails = [moved(ridge(y), across, (0, 0, -0.2)) for y in (-c, c)]
    return [*rails, body], a, c, float(assembly([body]).centroid[0, 2])


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("flip", [False, True])
def test_crossed_keels(place, flip):
    # min(mu, a / (z |cos psi|), c / (z |sin psi|)).
    blocks, a, c, z = crossed_keels()
    for psi in (0, 30, 60, 90):
        along, across = np.cos(np.deg2rad(psi)), np.sin(np.deg2rad(psi))
        exact = min(1.0, a / (z * max(along, 1e-9)), c / (z * max(across, 1e-9)))
        agrees(limit(blocks, [0, 1], (along, across, 0), place=place, flip=flip, friction=1.0), exact)


def ladder(degrees, length=4.0, thick=0.2):
    """A box that leans from the floor against a wall with two edges of its underside."""
    angle = np.deg2rad(degrees)
    foot, head = np.zeros(2), length * np.array([np.cos(angle), np.sin(angle)])
    up = thick * np.array([-np.sin(angle), np.cos(angle)])
    wall = box((head[0], -3, 0), (head[0] + 1, 3, 6), name="wall")
    plan = [tuple(map(float, p)) for p in (foot, head, head + up, foot + up)]
    return [FLOOR, wall, prism(plan, -0.3, 0.3, name="body")]


@pytest.mark.parametrize("place", PLACES)
def test_a_ladder_between_floor_and_wall(place):
    # Push away from the wall: min((mu L - x_g) / (L - z_g), x_g / z_g), L = l (sin + mu cos) / (1 + mu^2).
    length, thick, angle = 4.0, 0.2, np.deg2rad(60)
    x = (length * np.cos(angle) - thick * np.sin(angle)) / 2
    z = (length * np.sin(angle) + thick * np.cos(angle)) / 2
    for mu in (0.5, 0.7):
        arm = length * (np.sin(angle) + mu * np.cos(angle)) / (1 + mu**2)
        agrees(limit(ladder(60), [0, 1], (-1, 0, 0), place=place, friction=mu), min((mu * arm - x) / (arm - z), x / z))


def test_a_ladder_needs_friction():
    # mu >= (-l sin + sqrt(l^2 - t^2 sin^2)) / (l cos + t sin).
    length, thick, angle = 4.0, 0.2, np.deg2rad(60)
    root = np.sqrt(length**2 - thick**2 * np.sin(angle) ** 2)
    least = (root - length * np.sin(angle)) / (length * np.cos(angle) + thick * np.sin(angle))
    scene = assembly(ladder(60), supports=[0, 1])
    assert assess(scene, friction=least + EXACT).outcome is Outcome.STABLE
    assert assess(scene, friction=least - EXACT).outcome is Outcome.UNSTABLE


def prism_in_a_groove():
    """An octagonal prism of circumradius 1 with two edges on the flanks of a V of half angle 45 degrees."""
    groove = prism([(-3, -1), (3, -1), (3, 3), (0, 0), (-3, 3)], -9, 9, name="groove")
    turns = np.deg2rad(45 * np.arange(8))
    octagon = [(float(np.cos(t)), float(np.sqrt(2) + np.sin(t))) for t in turns]
    return [groove, prism(octagon, -4, 4, name="body")]


@pytest.mark.parametrize("place", ["here", "turned", "utm"])
@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_prism_in_a_groove(place, mu):
    # Across cot beta; along, with any forces, mu / (sin beta sqrt(1 - mu^2 cot^2 beta)), beta = 45 degrees.
    agrees(limit(prism_in_a_groove(), [0], (1, 0, 0), place=place, friction=mu), 1.0)
    along = mu * np.sqrt(2) / np.sqrt(1 - mu**2)
    agrees(limit(prism_in_a_groove(), [0], (0, 1, 0), place=place, friction=mu), along)


def test_a_prism_slides_along_a_groove_at_the_coulomb_limit():
    # mu / sin beta: no wedging without dilatancy.
    found = limit(prism_in_a_groove(), [0], (0, 1, 0), friction=0.2, flow="coulomb").coulomb
    assert found[0] <= 0.2 * np.sqrt(2) * (1 + EXACT)
    assert found[1] >= 0.2 * np.sqrt(2) * (1 - EXACT)
    assert found[1] - found[0] < 0.01


def octahedron_in_a_corner():
    """An octahedron with three vertices on three faces at right angles, its axis vertical."""
    axis = np.array([[1, -1, 0], [1, 1, -2], [1, 1, 1]]) / np.sqrt([[2], [6], [3]])
    axis[1] = np.cross(axis[2], axis[0])
    slabs = [box((-1, -1, -1), (0, 4, 4)), box((0, -1, -1), (4, 0, 4)), box((0, 0, -1), (4, 4, 0))]
    r = 0.5
    tips = [r * np.ones(3) + sign * r * np.eye(3)[k] for k in range(3) for sign in (1, -1)]
    return [*(moved(slab, axis) for slab in slabs), moved(hull(tips, name="body"), axis)], axis


@pytest.mark.parametrize("place", PLACES)
def test_an_octahedron_in_a_corner(place):
    # 1 / sqrt 2 towards a face's normal and sqrt 2 the other way, for every mu < 1 / sqrt 2.
    blocks, axis = octahedron_in_a_corner()
    push = axis @ [1, 0, 0] * [1, 1, 0]
    push /= np.linalg.norm(push)
    # Without friction rounded coordinates leave a moment that nothing carries.
    for mu in (0.0, 0.3, 0.6) if place == "here" else (0.3, 0.6):
        agrees(limit(blocks, [0, 1, 2], push, place=place, friction=mu), np.sqrt(0.5))
        agrees(limit(blocks, [0, 1, 2], -push, place=place, friction=mu), np.sqrt(2))


@pytest.mark.parametrize(
    ("blocks", "kind", "points"),
    [
        ([FLOOR, ridge(0.0), box((-0.5, -0.4, 0.2), (0.5, 0.4, 1))], ContactKind.EDGE, 2),
        (octahedron_in_a_corner()[0], ContactKind.CORNER, 3),
        (crossed_keels()[0], ContactKind.CROSSING, 4),
    ],
    ids=["edge on face", "corner on face", "edge across edge"],
)
@pytest.mark.parametrize("place", PLACES)
def test_each_kind_of_contact_is_found_once(blocks, kind, points, place):
    blocks = [Block(PLACES[place](np.asarray(b.vertices, float)), b.faces) for b in blocks]
    faces = find_interfaces(assembly(blocks))
    rows = np.flatnonzero(faces.pair[:, 1] == len(blocks) - 1)
    assert set(faces.kinds[rows].tolist()) == {kind}
    assert np.isin(faces.point_interface, rows).sum() == points
    assert (faces.area[rows] == 0).all()


def plank_on_a_rim(reach):
    """A plank from a pillar to a wall whose top edge its end just meets, or passes by `reach`."""
    pillar = box((-1, 0, 0), (0, 1, 1), name="pillar")
    wall = box((4, 0, 0), (5, 1, 1), name="wall")
    return assembly([pillar, wall, box((-0.5, 0, 1), (4 + reach, 1, 1.2), name="plank")], supports=[0, 1])


def test_a_verdict_that_hangs_on_an_edge_along_an_edge_is_undecided():
    verdict = assess(plank_on_a_rim(0.0))
    assert verdict.outcome is Outcome.UNDECIDED
    assert any('"wall" and "plank"' in warning and "edge along edge" in warning for warning in verdict.warnings)
    assert assess(plank_on_a_rim(1e-3)).outcome is Outcome.STABLE
    assert assess(plank_on_a_rim(-1e-3)).outcome is Outcome.UNSTABLE


def test_a_column_on_the_tip_of_another_is_undecided_and_one_beside_it_falls():
    tip = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
    up = hull(tip, name="lower")
    down = moved(up, np.diag([1, -1, -1]), (0, 1, 2))
    verdict = assess(assembly([up, Block(down.vertices, down.faces, "upper")]))
    assert verdict.outcome is Outcome.UNDECIDED
    assert any('"lower" and "upper"' in warning and "corner on corner" in warning for warning in verdict.warnings)
    beside = moved(down, shift=(0.01, 0, 0))
    assert assess(assembly([up, Block(beside.vertices, beside.faces, "upper")])).outcome is Outcome.UNSTABLE


def test_what_falls_whatever_a_rim_carries_is_unstable():
    # The upper block hangs beyond the edge that it shares with the lower one: no force at an edge can hold it.
    verdict = assess(assembly([box((0, 0, 0), (1, 1, 1)), box((1, 0, 1), (2, 1, 2))]))
    assert verdict.outcome is Outcome.UNSTABLE


def test_triangles_of_one_face_have_no_edge_between_them():
    ridged = [FLOOR, ridge(0.0), box((-0.5, -0.4, 0.2), (0.5, 0.4, 1), name="body")]
    body = ridged[2]
    ridged[2] = Block(body.vertices, [t for f in body.faces for t in ([f[0], f[1], f[2]], [f[0], f[2], f[3]])])
    faces = find_interfaces(assembly(ridged))
    row = np.flatnonzero((faces.pair == [1, 2]).all(axis=1))
    assert faces.kinds[row].tolist() == [ContactKind.EDGE]
    assert np.ptp(faces.point[faces.point_interface == row[0]][:, 1]) == pytest.approx(0.8)
