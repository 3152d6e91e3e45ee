"""Edges and corners of solids against their definition, each feature of one with each of the other in plain loops."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from blockstat import Block, find_interfaces
from blockstat.contact.coplanar import Patches
from blockstat.contact.edges import _merged
from blockstat.contact.faces import frames
from blockstat.contact.features import ContactKind, Features
from blockstat.contact.known_contacts import Contacts, Tolerances, covered, features_of, search_of
from blockstat.contact.tolerance import allowed_gap
from blockstat.contact.unresolved import Unresolved, unresolved_contacts
from evidence.scenes.small import assembly, box, prism
from tests.point_bodies import hull

LEAN = 1e-4
STEEP = 0.3


class Solid:
    """A convex block by its faces: what its features are and in which directions it goes on from them."""

    def __init__(self, asm, block):
        faces = [
            asm.face_vertices[asm.face_start[f] : asm.face_start[f + 1]]
            for f in np.flatnonzero(asm.face_block == block)
        ]
        self.faces = [asm.vertices[face] for face in faces]
        self.normals = [np.cross(f[1] - f[0], f[2] - f[0]) for f in self.faces]
        self.normals = [n / np.linalg.norm(n) for n in self.normals]
        self.edges, self.spokes = {}, {}
        for face, points in zip(faces, self.faces, strict=True):
            ring = [*face.tolist(), int(face[0])]
            for tail, head in pairwise(ring):
                p, q = asm.vertices[tail], asm.vertices[head]
                along = (q - p) / np.linalg.norm(q - p)
                inward = points.mean(axis=0) - p
                inward = inward - (inward @ along) * along
                self.edges.setdefault((min(tail, head), max(tail, head)), []).append(inward / np.linalg.norm(inward))
                self.spokes.setdefault(tail, []).append(along)
        self.points = {vertex: asm.vertices[vertex] for vertex in self.spokes}
        self.lines = {ends: (asm.vertices[ends[0]], asm.vertices[ends[1]]) for ends in self.edges}


def plane(normal):
    one = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    one = one / np.linalg.norm(one)
    return np.array([one, np.cross(normal, one)])


def corners_on(faces_of, other, reach, sign):
    for face, normal in zip(faces_of.faces, faces_of.normals, strict=True):
        across = plane(normal)
        polygon = shapely.Polygon((face - face[0]) @ across.T)
        for vertex, point in other.points.items():
            height = float((point - face[0]) @ normal)
            foot = shapely.Point(across @ (point - face[0]))
            if abs(height) > reach or not polygon.contains(foot):
                continue
            if min(spoke @ normal for spoke in other.spokes[vertex]) < -LEAN:
                continue
            if abs(height) <= polygon.exterior.distance(foot):
                place = point - height / 2 * normal
                yield np.array([*(sign * normal), *place, *place, abs(height)])


def edges_on(faces_of, other, reach, sign):
    for face, normal in zip(faces_of.faces, faces_of.normals, strict=True):
        across = plane(normal)
        polygon = shapely.Polygon((face - face[0]) @ across.T)
        for ends, (p, q) in other.lines.items():
            heights = float((p - face[0]) @ normal), float((q - face[0]) @ normal)
            if abs(heights[1] - heights[0]) > STEEP * np.linalg.norm(q - p):
                continue
            if min(inward @ normal for inward in other.edges[ends]) < -LEAN:
                continue
            flat = [across @ (x - face[0]) for x in (p, q)]
            common = polygon.intersection(shapely.LineString(flat))
            if common.is_empty or common.length < 1e-9:
                continue
            line = flat[1] - flat[0]
            shares = sorted((np.array(c) - flat[0]) @ line / (line @ line) for c in common.coords)
            found = [(1 - s) * heights[0] + s * heights[1] for s in shares]
            gap = max(map(abs, found))
            middle = shapely.Point(flat[0] + sum(shares) / 2 * line)
            if gap <= reach and gap <= polygon.exterior.distance(middle):
                points = [p + s * (q - p) - h / 2 * normal for s, h in zip(shares, found, strict=True)]
                yield np.array([*(sign * normal), *points[0], *points[1], gap])


def crossed(one, two, reach):
    for first, second in product(one.lines, two.lines):
        (p, p2), (q, q2) = one.lines[first], two.lines[second]
        a, b = p2 - p, q2 - q
        normal = np.cross(a, b)
        if np.linalg.norm(normal) <= 2e-9 * max(np.linalg.norm(a), np.linalg.norm(b)):
            continue
        normal = normal / np.linalg.norm(normal)
        s, t, height = np.linalg.solve(np.column_stack([a, -b, normal]), q - p)
        if abs(height) > reach:
            continue
        if any(not abs(height) < x * np.linalg.norm(e) < np.linalg.norm(e) - abs(height) for x, e in ((s, a), (t, b))):
            continue
        ours, theirs = ([d @ normal for d in solid.edges[ends]] for solid, ends in ((one, first), (two, second)))
        up = max(ours) <= LEAN and min(theirs) >= -LEAN
        down = min(ours) >= -LEAN and max(theirs) <= LEAN
        if up or down:
            place = p + s * a + height / 2 * normal
            yield np.array([*(normal if up else -normal), *place, *place, abs(height)])


def third_block(rng, seed):
    """A wedge, a prism over a hexagon or the hull of some points: faces of three to six corners."""
    if seed % 6 == 2:
        return hull(rng.normal(size=(7, 3)))
    outline = [(0.0, 0.0), (0.9, 0.1), (1.3, 0.7), (0.8, 1.2), (-0.1, 1.0), (-0.4, 0.4)] if seed % 6 else None
    solid = prism(outline or [(0, 0), (1.1, 0.2), (0.3, 0.9)], 0.8)
    vertices = Rotation.from_rotvec(rng.normal(size=3)).apply(np.asarray(solid.vertices, float))
    return Block(vertices, _outward(vertices, solid.faces))


def scene(seed):
    """Three solids that nearly touch: two hulls of random points, or a roof over a pentagon, and a box."""
    rng = np.random.default_rng(seed)
    if seed % 2:
        blocks = [hull(rng.normal(size=(rng.integers(5, 9), 3))) for _ in range(3)]
    else:
        pentagon = [(0, 0), (2, -0.3), (2.6, 1.0), (1.2, 1.9), (-0.2, 1.3)]
        base = prism(pentagon, 1.0)
        stood = np.asarray(base.vertices, float)[:, [0, 2, 1]] * [1, 1, -1]
        lean = [rng.uniform(-0.15, 0.15), rng.uniform(-0.3, 0.3)] if seed % 4 else [0.0, 0.0]
        turn = Rotation.from_euler("zyx", [rng.uniform(0, 6), lean[0], np.pi / 4 + lean[1]])
        roof = np.asarray(box((-1, -0.5, -0.5), (1, 0.5, 0.5)).vertices) * rng.uniform(0.4, 1.6, 3)
        faces = box((0, 0, 0), (1, 1, 1)).faces
        third = third_block(rng, seed)
        blocks = [Block(stood, _outward(stood, base.faces)), Block(turn.apply(roof), faces), third]
    placed, heads = [], [(0.0, 0, 1), tuple(rng.normal(size=3))]
    placed.append(blocks[0])
    for block, direction in zip(blocks[1:], heads, strict=True):
        d = np.array(direction) / np.linalg.norm(direction)
        if seed % 2:
            d = rng.normal(size=3) / 2 + d
            d /= np.linalg.norm(d)
        below, own = np.asarray(placed[-1].vertices, float), np.asarray(block.vertices, float)
        own = own - own.mean(axis=0) + below.mean(axis=0) + rng.normal(size=3) * 0.2
        own = own + d * ((below @ d).max() - (own @ d).min() + rng.uniform(-0.08, 0.08))
        placed.append(Block(own, block.faces))
    return assembly(placed)


def _outward(vertices, faces):
    middle, found = vertices.mean(axis=0), []
    for face in faces:
        p = vertices[list(face)]
        normal = np.cross(p[1] - p[0], p[2] - p[0])
        found.append(list(face) if normal @ (p[0] - middle) > 0 else list(face)[::-1])
    return found


PAIRS = np.array([[0, 1], [1, 2], [0, 2]])


def rows(features, k):
    own = features.take(features.row == k)
    return np.column_stack([own.normal, own.ends.reshape(-1, 6), own.gap])


def same(found, expected):
    assert len(found) == len(expected)
    for row in expected:
        swapped = row[[0, 1, 2, 6, 7, 8, 3, 4, 5, 9]]
        assert min(np.abs(found - r).max(axis=1).min() for r in (row, swapped)) < 1e-9


def agrees(asm, pairs, allowed):
    """How many edges, corners and crossings there are, if they are those of the definition."""
    search = search_of(asm, pairs, Tolerances(np.asarray(allowed), 1e-9, STEEP), rims=False)
    solids = [Solid(asm, k) for k in range(asm.n_blocks)]
    found, counts = features_of(search, STEEP), np.zeros(3, dtype=int)
    for k, (a, b) in enumerate(pairs):
        one, two, reach = solids[a], solids[b], min(allowed[a], allowed[b])
        assert search.reach[k] == reach
        expected = (
            [*edges_on(one, two, reach, 1.0), *edges_on(two, one, reach, -1.0)],
            [*corners_on(one, two, reach, 1.0), *corners_on(two, one, reach, -1.0)],
            [*crossed(one, two, reach)],
        )
        for features, own in zip(found, expected, strict=True):
            same(rows(features, k), own)
            assert not features.rim.any()
        counts += [len(own) for own in expected]
    return counts.tolist()


@pytest.mark.parametrize("seed", range(24))
def test_features_are_those_that_touch_by_definition(seed):
    agrees(scene(seed), PAIRS, [0.3, 0.25, 0.2])


def test_the_scenes_above_have_contacts_of_every_kind():
    """Otherwise the test of single scenes says nothing."""
    counts = np.sum([agrees(scene(seed), PAIRS, [0.3, 0.25, 0.2]) for seed in range(24)], axis=0)
    assert (counts > 0).all()


# Without a unique normal.


def bare(blocks, **options):
    asm = assembly(blocks, **options)
    return unresolved_contacts(asm, find_interfaces(asm))


def normals_of(found, k):
    return sorted(set(map(tuple, (found.normal[found.contact == k].round(6) + 0.0).tolist())))


CUBE = ((0, 0, 0), (1, 1, 1))


@pytest.mark.parametrize("flip", [False, True])
def test_an_edge_along_an_edge_touches_at_the_ends_of_what_they_share(flip):
    blocks = [box(*CUBE), box((1, 1, 0.3), (2, 3, 1.7))]
    found = bare(blocks[::-1] if flip else blocks)
    sign = -1.0 if flip else 1.0
    assert found.reason == ("edge along edge",) * 2
    assert found.pair.tolist() == [[0, 1]] * 2
    assert sorted(map(tuple, found.point.round(9).tolist())) == [(1, 1, 0.3), (1, 1, 1)]
    for k in range(2):
        assert normals_of(found, k) == sorted([(sign, 0, 0), (0, sign, 0)])
    assert (np.diff(found.contact) >= 0).all()


@pytest.mark.parametrize("flip", [False, True])
def test_a_corner_on_a_corner_has_a_cone_of_normals(flip):
    blocks = [box(*CUBE), box((1, 1, 1), (1.5, 1.7, 3))]
    found = bare(blocks[::-1] if flip else blocks)
    sign = -1.0 if flip else 1.0
    assert found.reason == ("corner on corner",)
    assert found.point.tolist() == [[1, 1, 1]]
    assert normals_of(found, 0) == sorted([(sign, 0, 0), (0, sign, 0), (0, 0, sign)])


@pytest.mark.parametrize("flip", [False, True])
def test_a_corner_on_an_edge_has_the_normals_that_both_allow(flip):
    # A spike whose tip is on the upper edge y = 1: four edges lead away from it, up and outwards.
    spread = [(0.2, 0.3, 1), (-0.3, 0.3, 1), (-0.3, 0.9, 1), (0.2, 0.9, 1)]
    tip = np.array([0.4, 1.0, 1.0])
    points = [tip, *(tip + s for s in spread)]
    blocks = [box(*CUBE), hull(points)]
    found = bare(blocks[::-1] if flip else blocks)
    sign = -1.0 if flip else 1.0
    assert found.reason == ("corner on edge",)
    assert found.point == pytest.approx(tip[None])
    # From the cube: +y, +z, along its edge not at all. All directions of the spike lie on their far side.
    expected = [(0.0, sign, 0.0), (0.0, 0.0, sign)]
    assert normals_of(found, 0) == sorted(expected)


@pytest.mark.parametrize("seed", range(6))
def test_extreme_normals_keep_both_blocks_on_their_sides_and_touch_two_directions(seed):
    rng = np.random.default_rng(seed)
    # Two pyramids tip to tip, the upper one leaning.
    rings = []
    for sign in (-1.0, 1.0):
        n = int(rng.integers(3, 6))
        angle = np.sort(rng.uniform(0, 2 * np.pi, n)) if n > 3 else np.array([0.3, 2.2, 4.4]) + rng.uniform(0, 0.4, 3)
        rings.append(
            np.column_stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), np.full(n, sign)])
            + rng.uniform(-0.1, 0.1, 3) * [1, 1, 0]
        )
    blocks = [hull([(0.0, 0, 0), *ring]) for ring in rings]
    asm = assembly(blocks)
    found = bare(blocks)
    at_tip = np.flatnonzero(np.abs(found.point).max(axis=1) < 1e-9)
    assert len(at_tip) == 1
    normals = found.normal[found.contact == at_tip[0]]
    below, above = (s for s in (Solid(asm, 0), Solid(asm, 1)))

    def away(solid):
        (tip,) = [v for v, p in solid.points.items() if np.abs(p).max() < 1e-12]
        return np.array(solid.spokes[tip])

    sides = np.concatenate([away(below), -away(above)])
    expected = set()
    for i, j in product(range(len(sides)), repeat=2):
        normal = np.cross(sides[i], sides[j])
        if np.linalg.norm(normal) > LEAN:
            normal = normal / np.linalg.norm(normal)
            if (sides @ normal).max() <= LEAN:
                expected.add(tuple(normal.round(6) + 0.0))
    assert {tuple(n.round(6) + 0.0) for n in normals} == expected
    assert len(expected) >= 3


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("low", "reasons"), [((1, 1, 0.3), ("edge along edge",) * 2), ((1, 1, 1), ("corner on corner",))]
)
def test_directions_along_one_line_have_no_normal_between_them_and_divide_nothing(low, reasons):
    found = bare([box((0, 0, 0), (1, 1, 1)), box(low, (2, 3, 1.9))])
    assert found.reason == reasons
    assert np.linalg.norm(found.normal, axis=1) == pytest.approx(np.ones(len(found.normal)))
    assert found.normal.min() >= -1e-12  # away from the first block


@pytest.mark.filterwarnings("error")
def test_corners_on_faces_of_three_and_of_four_sides_divide_nothing_by_nothing():
    triangle = hull([(x, y, z) for x, y in ((0, 0), (3, 0), (0, 3)) for z in (-1.0, 0.0)])
    tops = [(-0.5, -0.5, 1.0), (0.5, -0.5, 1.0), (0.5, 0.5, 1.0), (-0.5, 0.5, 1.0)]
    tips = [(0.9, 0.8, 0.0), (6.2, 1.1, 0.0)]
    spikes = [hull(np.array([(0.0, 0, 0), *tops]) + tip) for tip in tips]
    found = find_interfaces(assembly([triangle, box((5, 0, -2), (8, 3, 0)), *spikes]))
    assert found.pair.tolist() == [[0, 2], [1, 3]]
    assert found.kinds.tolist() == [ContactKind.CORNER] * 2
    assert found.point == pytest.approx(np.array(tips))


def test_contacts_of_some_pairs_keep_their_normals():
    blocks = [box(*CUBE), box((1, 1, 0.3), (2, 3, 1.7)), box((-1, -1, -1), (0, 0, 0)), box((0, 0, 1), (0.5, 0.5, 1.4))]
    asm = assembly(blocks)
    whole = unresolved_contacts(asm, find_interfaces(asm))
    assert sorted({tuple(p) for p in whole.pair.tolist()}) == [(0, 1), (0, 2)]
    for pairs in ([[0, 1]], [[0, 2]], [[0, 1], [0, 2]], [[1, 2]], []):
        own = whole.among(np.array(pairs, dtype=int).reshape(-1, 2), 4)
        kept = [k for k, pair in enumerate(whole.pair.tolist()) if pair in pairs]
        assert own.pair.tolist() == whole.pair[kept].tolist()
        assert own.point.tolist() == whole.point[kept].tolist()
        assert own.reason == tuple(whole.reason[k] for k in kept)
        for k, old in enumerate(kept):
            assert normals_of(own, k) == normals_of(whole, old)
        assert len(own.normal) == len(own.contact) == sum((whole.contact == k).sum() for k in kept)
    alone = unresolved_contacts(asm, find_interfaces(asm), pairs=np.array([[0, 2]]))
    assert alone.pair.tolist() == [[0, 2]]
    none = unresolved_contacts(asm, find_interfaces(asm), pairs=np.empty((0, 2), dtype=int))
    shapes = [value.shape for value in (none.pair, none.point, none.normal, none.contact)]
    assert (shapes, none.reason) == ([(0, 2), (0, 3), (0, 3), (0,)], ())


def test_contacts_without_a_normal_follow_interfaces_as_corners():
    blocks = [box(*CUBE), box((1, 1, 0.3), (2, 3, 1.7)), box((0.2, 0.1, 1), (0.5, 0.5, 1.4))]
    asm = assembly(blocks)
    faces = find_interfaces(asm)
    more = unresolved_contacts(asm, faces)
    corners = more.as_corners()
    n = len(more.normal)
    assert corners.pair.tolist() == [[0, 1]] * n
    assert corners.frame[:, 0].tolist() == more.normal.tolist()
    assert corners.point.tolist() == [more.point[k].tolist() for k in more.contact]
    assert corners.start.tolist() == list(range(n + 1))
    assert corners.kinds.tolist() == [ContactKind.CORNER] * n
    assert not corners.area.any()
    assert not corners.gap.any()
    both = more.beside(faces)
    assert both.pair.tolist() == [*faces.pair.tolist(), *corners.pair.tolist()]
    assert both.n_points == faces.n_points + n
    assert both.start.tolist() == [*faces.start.tolist(), *(faces.n_points + np.arange(1, n + 1)).tolist()]
    assert (both.point[-n:] == corners.point).all()
    assert (both.frame[-n:] == corners.frame).all()
    assert both.kinds.tolist() == [0] * faces.n_interfaces + [ContactKind.CORNER] * n
    assert (both.outlines, both.share, both.friction, both.rims) == (None, None, None, None)
    assert both.dropped == faces.dropped
    outlines = tuple(faces.outline(k) for k in range(faces.n_interfaces))
    dressed = replace(
        faces, outlines=outlines, share=np.full(faces.n_points, 0.25),
        friction=np.linspace(0.3, 0.7, faces.n_interfaces),
    )  # fmt: skip
    both = more.beside(dressed)
    assert [o.tolist() for o in both.outlines[-n:]] == [[p] for p in corners.point.tolist()]
    assert both.outlines[:-n] == outlines
    assert both.share.tolist() == [0.25] * faces.n_points + [1.0] * n
    most = 0.7 if faces.n_interfaces > 1 else 0.3
    assert both.friction.tolist() == pytest.approx([*np.linspace(0.3, 0.7, faces.n_interfaces), *[most] * n])


def test_a_gap_in_millimetres_blurs_the_rims():
    # Edges 1 mm apart across both axes: nothing at the gap of a share, an edge along an edge at 3 mm.
    blocks = [box(*CUBE), box((1.001, 1.001, 0.3), (2, 3, 1.7))]
    asm = assembly(blocks)
    for gap, touch in (("3 mm", True), ("0.5 mm", False)):
        found = unresolved_contacts(asm, find_interfaces(asm, gap=gap), gap=gap)
        assert isinstance(found, Unresolved)
        assert ("edge along edge" in found.reason) == touch
        assert (len(found.pair) > 0) == touch
    assert allowed_gap(asm, "3 mm").min() > 0.001


# What contacts cover, and what they absorb.


@pytest.mark.parametrize("least", [-np.inf, 0.9, 0.999])
@pytest.mark.parametrize("seed", range(6))
def test_a_feature_is_covered_by_a_contact_in_its_plane_that_it_lies_in(seed, least):
    rng = np.random.default_rng(seed)
    asm = assembly([box((k, 0, 0), (k + 1, 1, 1)) for k in range(3)])
    pairs, reach = np.array([[0, 1], [1, 2], [0, 2]]), np.array([0.05, 0.02, 0.03])
    search = replace(search_of(asm, pairs, Tolerances(np.ones(3), 1e-3, 0.2), rims=False), reach=reach)
    shapes = [
        [(0, 0), (1, 0.1), (0.9, 0.7), (0.2, 0.5)],
        [(0.1, 0.2), (0.9, 0.4)],
        [(0.5, 0.1)],
        [(0, 0), (0.6, -0.2), (0.4, 0.8)],
    ]
    row, origin = np.array([0, 0, 2, 2]), rng.normal(size=(4, 3))
    normal = rng.normal(size=(4, 3))
    frame = frames(normal / np.linalg.norm(normal, axis=1)[:, None])
    patches = Patches(
        pairs[row],
        frame,
        origin,
        np.zeros(4),
        np.zeros(4),
        np.concatenate(shapes).astype(float),
        np.array([len(s) for s in shapes]),
        np.zeros(4),
    )
    order = rng.permutation(4)
    known = Contacts(row[order], np.zeros(4, int), patches.take(order))
    # Points in and beside the contacts, up to their reach and a little more over their planes.
    of, n = rng.integers(0, 4, 200), 200
    lean = rng.normal(size=(n, 3)) * rng.choice([0.0, 0.02, 0.3], n)[:, None]
    direction = frame[of, 0] + lean
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    ends = np.empty((n, 2, 3))
    for i, k in enumerate(of):
        corners = np.array(shapes[k], float)
        for end in range(2):
            share = rng.dirichlet(np.full(len(corners), 0.3)) * rng.choice([1.0, 1.0, 1.02])
            flat_ = share @ corners + rng.choice([0, 0, 1e-3, 4e-3]) * rng.normal(size=2)
            ends[i, end] = origin[k] + flat_ @ frame[k, 1:] + rng.uniform(-1.2, 1.2) * reach[row[k]] * frame[k, 0]
    none = np.zeros(n, int)
    features = Features(np.where(rng.random(n) < 0.1, 1, row[of]), direction, ends, np.zeros(n), none > 0, none, none)

    def is_covered(i):
        for k in range(4):
            alike = float(frame[k, 0] @ direction[i])
            if row[k] != features.row[i] or alike < least:
                continue
            local = (ends[i] - origin[k]) @ frame[k].T
            if np.abs(local[:, 0]).max() > reach[row[k]]:
                continue
            shape = shapely.MultiPoint(shapes[k]).convex_hull
            aside = 2e-3 + reach[row[k]] * np.sqrt(max(1 - alike**2, 0.0))
            if all(shape.distance(shapely.Point(p[1:])) <= aside for p in local):
                return True
        return False

    found = covered(search, features, known, least)
    assert found.tolist() == [is_covered(i) for i in range(n)]
    assert 5 < found.sum() < n - 5
    nothing = Contacts(row[:0], row[:0], patches.take(np.empty(0, dtype=int)))
    assert not covered(search, features, nothing, least).any()


RIDGE_FACES = [(-0.2, -0.3), (0.2, -0.3), (0.0, 0.0)]


def notched(step=0.0, low=0.0, high=1.0):
    """A block whose underside has a notch from y = .3 to .6 over a ridge along y, its further foot higher by a step."""
    ridge = prism(RIDGE_FACES, 1.0)
    ridge = Block(np.asarray(ridge.vertices, float) * [1, high - low, 1] + [0, low, 0], ridge.faces)
    outline = [(0, 0), (0.3, 0), (0.3, 0.1), (0.6, 0.1), (0.6, step), (1, step), (1, 1), (0, 1)]
    body = prism(outline, 1.0)
    turned = np.asarray(body.vertices, float)[:, [1, 0, 2]] * [1, 1, 1] - [0.4, 0, 0]
    return assembly([ridge, Block(turned, _oriented(turned, body.faces))])


def _oriented(vertices, faces):
    """Faces of a mirrored block, walked the other way round."""
    volume = 0.0
    for face in faces:
        p = vertices[list(face)]
        volume += sum(np.linalg.det([p[0], p[i], p[i + 1]]) for i in range(1, len(p) - 1))
    return [list(f) if volume > 0 else list(f)[::-1] for f in faces]


@pytest.mark.parametrize(("step", "low", "high"), [(0.0, -0.2, 0.8), (1e-3, 0.1, 1.4), (0.0, 0.05, 0.95)])
def test_edges_in_one_line_are_one_contact_from_end_to_end(step, low, high):
    found = find_interfaces(notched(step, low, high))
    assert found.kinds.tolist() == [ContactKind.EDGE]
    ends = sorted(found.point.tolist(), key=lambda p: p[1])
    assert [p[1] for p in ends] == pytest.approx([max(low, 0.0), min(high, 1.0)])
    assert [p[0] for p in ends] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert found.gap == pytest.approx([step], abs=1e-12)
    assert found.frame[0, 0] == pytest.approx([0, 0, 1], abs=1e-12)


def test_edges_in_parallel_lines_are_contacts_of_their_own():
    # Two ridges of one base, 0.5 apart and of different height by less than the gap, under a flat block.
    base = prism([(-0.2, -0.5), (0.8, -0.5), (0.8, -0.1), (0.5, -0.002), (0.25, -0.3), (0.0, 0.0), (-0.2, -0.1)], 1.0)
    found = find_interfaces(assembly([base, box((-1, 0.25, 0), (2, 2, 1))]))
    assert found.kinds.tolist() == [ContactKind.EDGE] * 2
    order = np.argsort(found.point[found.start[:-1], 0])
    assert found.gap[order] == pytest.approx([0.0, 0.002], abs=1e-12)
    for k, x, z in ((order[0], 0.0, 0.0), (order[1], 0.5, -0.001)):
        own = found.point[found.start[k] : found.start[k + 1]]
        assert sorted(map(tuple, own.round(9).tolist())) == [(x, 0.25, z), (x, 1.0, z)]


def merged_on_a_line(kinds, gaps, *places):
    """What two contacts on the plane z = 1 become, given by points along and across a line in roundings."""
    search = search_of(
        assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))]), np.array([[0, 1]]),
        Tolerances(np.full(2, 0.1), 1e-3, STEEP), rims=False,
    )  # fmt: skip
    rounding, frame = 1e-3, frames(np.array([[0, 0, 1.0]]))[0]
    line = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0]])
    points = [[0.4, 0.3, 1] + rounding * np.array(own, float) @ line for own in places]
    origins = np.array([own.mean(axis=0) for own in points])
    patches = Patches(
        np.array([[0, 1]] * 2), np.tile(frame, (2, 1, 1)), origins, np.zeros(2), np.array(gaps),
        np.concatenate([(p - o) @ frame[1:].T for p, o in zip(points, origins, strict=True)]),
        np.array([len(own) for own in points]), np.zeros(2),
    )  # fmt: skip
    found, _ = _merged(search, Contacts(np.zeros(2, np.int64), np.array(kinds), patches))
    ends = [(own.origin + own.polygon @ own.frame[1:] - [0.4, 0.3, 1]) @ line.T / rounding for _, own in found]
    return [(kind, own.gap) for kind, own in found], [sorted(map(tuple, own.round(6).tolist())) for own in ends]


@pytest.mark.parametrize(("apart", "one"), [(0.5, True), (1.95, True), (2.05, False), (2.95, False), (9.0, False)])
def test_contacts_of_corners_are_one_within_two_roundings(apart, one):
    found, ends = merged_on_a_line([ContactKind.CORNER] * 2, (0.01, 0.02), [(0, 0)], [(apart, 0)])
    if one:
        assert (found, ends) == ([(ContactKind.CORNER, 0.02)], [[(0, 0)]])
    else:
        assert (found, ends) == ([(ContactKind.CORNER, 0.01), (ContactKind.CORNER, 0.02)], [[(0, 0)], [(apart, 0)]])
    # An edge so short is a point, a longer one goes on to the corner beyond its end.
    found, ends = merged_on_a_line(
        [ContactKind.EDGE, ContactKind.CORNER], (0.03, 0.02), [(-apart / 4, 0), (apart / 4, 0)], [(0.75 * apart, 0)]
    )
    assert found == [(ContactKind.EDGE, 0.03)]
    wanted = [-apart / 4] if one else [-apart / 4, 0.75 * apart]
    assert np.array(ends[0]) == pytest.approx(np.array([(x, 0) for x in wanted]), abs=1e-5)


@pytest.mark.parametrize(("aside", "one"), [(-1.95, True), (1.95, True), (2.05, False), (-2.95, False)])
def test_a_corner_lies_in_the_line_of_an_edge_within_two_roundings(aside, one):
    edge = [(-100, 0), (100, 0)]
    found, ends = merged_on_a_line([ContactKind.EDGE, ContactKind.CORNER], (0.01, 0.02), edge, [(30, aside)])
    assert found == ([(ContactKind.EDGE, 0.02)] if one else [(ContactKind.EDGE, 0.01), (ContactKind.CORNER, 0.02)])
    assert ends == ([edge] if one else [edge, [(30, aside)]])


@pytest.mark.parametrize(("sine", "kinds"), [(0.25, [ContactKind.EDGE]), (0.27, [])])
def test_an_edge_lies_on_a_face_up_to_fifteen_degrees(sine, kinds):
    # sin 15 deg = .2588. A blade that leans along itself about the middle of its edge, on a narrow wall across it.
    blade = prism([(-0.5, 0.8), (0.5, 0.8), (0.0, 0.0)], 1.0)
    vertices = Rotation.from_rotvec([np.arcsin(sine), 0, 0]).apply(np.asarray(blade.vertices, float) - [0, 0.5, 0])
    asm = assembly([box((-1, -0.01, -1), (1, 0.01, 0)), Block(vertices, _oriented(vertices, blade.faces))])
    found = find_interfaces(asm, gap=0.1)
    assert [k for k in found.kinds.tolist() if k == ContactKind.EDGE] == kinds
    if kinds:
        assert found.gap[found.kinds == ContactKind.EDGE] == pytest.approx([0.01 * sine / np.sqrt(1 - sine**2)])


def test_a_search_among_no_pairs_has_no_parts_and_one_among_many_has_them_in_order(monkeypatch):
    asm = scene(1)
    tolerances = Tolerances(np.full(3, 0.2), 1e-9, STEEP)
    assert search_of(asm, PAIRS[:0], tolerances, rims=False).chunks() == []
    search = search_of(asm, PAIRS, tolerances, rims=False)
    (whole,) = search.chunks()
    assert whole.pairs.tolist() == PAIRS.tolist()
    expected = features_of(search, STEEP)
    monkeypatch.setattr("blockstat.contact.features.CHUNK", 1)
    parts = search.chunks()
    assert [part.pairs.tolist() for part in parts] == [[pair] for pair in PAIRS.tolist()]
    for k, part in enumerate(parts):
        assert (part.reach, part.rounding, part.beyond) == tuple(
            pytest.approx(x[k : k + 1]) for x in (search.reach, search.rounding, search.beyond)
        )
    for one, two in zip(features_of(search, STEEP), expected, strict=True):
        assert sorted(one.row.tolist()) == sorted(two.row.tolist())
        for k in range(3):
            same(rows(one, k), rows(two, k))


def ordered(blocks, axis, flip):
    """Blocks with their axes permuted so that z becomes another axis, upside down and in reverse order or not."""
    found = []
    for block in blocks:
        vertices = np.roll(np.asarray(block.vertices, float) * ([1, 1, -1] if flip else [1, 1, 1]), axis + 1, axis=1)
        found.append(Block(vertices, _oriented(vertices, block.faces)))
    return assembly(found[::-1] if flip else found)


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("axis", range(3))
def test_what_is_exactly_within_reach_touches_and_what_is_a_little_further_does_not(axis, flip):
    # Numbers without rounding: a quarter.
    floor, pair = box((-4, -4, -1), (4, 4, 0)), np.array([[0, 1]])
    for more, counts in ((0.0, [1, 2, 0]), (2.0**-40, [0, 0, 0])):
        blade = prism([(-0.5, 1.25 + more), (0.5, 1.25 + more), (0.0, 0.25 + more)], 1.0)
        blade = Block(blade.vertices, _oriented(np.asarray(blade.vertices, float), blade.faces))
        assert agrees(ordered([floor, blade], axis, flip), pair, [0.25, 0.5]) == counts
        under = np.asarray(blade.vertices, float)[:, [1, 0, 2]] * [1, 1, -1] - [0.5, 0, -0.25 - more]
        crossing = [
            Block(under, _oriented(under, blade.faces)),
            Block(np.asarray(blade.vertices) - [0, 0.5, 0], blade.faces),
        ]
        assert agrees(ordered(crossing, axis, flip), pair, [0.5, 0.25]) == [0, 0, counts[0]]


@pytest.mark.parametrize(("slope", "count"), [(0.0, 1), (0.5e-4, 1), (-0.5e-4, 1), (-0.5, 1), (2e-4, 0)])
@pytest.mark.parametrize("flip", [False, True])
def test_what_leans_into_the_other_block_does_not_touch_it_there(slope, count, flip):
    # The underside dips below the plane of the floor by a slope, from an edge that is just over the floor.
    floor, pair = box((-2, -1, -1), (0, 2, 0)), np.array([[0, 1]])
    outline = [(-0.25, 0), (1, -1.25 * slope), (1, 3), (-1.0, 3)]
    ledge = prism(outline, 1.0)
    _, corners, _ = agrees(ordered([floor, ledge], 2, flip), pair, [0.25, 0.25])
    assert corners == 2 * count
    # An edge across a ridge whose further side rises by the slope from the edge.
    ridge = prism([(0.0, 0.0), (-1.0, slope), (-1.0, -1.0), (0.0, -1.0)], 1.0)
    ridge = Block(ridge.vertices, _oriented(np.asarray(ridge.vertices, float), ridge.faces))
    blade = np.asarray(prism([(-0.5, 1.0), (0.5, 1.0), (0.0, 0.0)], 1.0).vertices, float)[:, [1, 0, 2]] + [
        -0.25,
        0.5,
        0,
    ]
    across = Block(blade, _oriented(blade, prism([(-0.5, 1.0), (0.5, 1.0), (0.0, 0.0)], 1.0).faces))
    assert agrees(ordered([ridge, across], 2, flip), pair, [0.25, 0.25])[2] == count


# On rims, where there is no unique normal.


def state_of(point, polygon, rounding, beyond):
    """0 outside, 1 on the rim, 2 inside of a convex face all of whose sides are edges."""
    distance = polygon.exterior.distance(shapely.Point(point))
    if distance <= rounding or (not polygon.contains(shapely.Point(point)) and distance <= beyond):
        return 1
    return 2 if polygon.contains(shapely.Point(point)) else 0


def corners_with_rims(faces_of, other, limits, sign):
    reach, rounding, beyond = limits
    for face, normal in zip(faces_of.faces, faces_of.normals, strict=True):
        across = plane(normal)
        polygon = shapely.Polygon((face - face[0]) @ across.T)
        for vertex, point in other.points.items():
            height, foot = float((point - face[0]) @ normal), across @ (point - face[0])
            state = state_of(foot, polygon, rounding, beyond)
            lean = min(spoke @ normal for spoke in other.spokes[vertex])
            inset = polygon.exterior.distance(shapely.Point(foot))
            closes = abs(height) <= (beyond if state == 1 else min(reach, inset))
            if abs(height) <= reach and closes and (state == 1 or (state == 2 and lean >= -LEAN)):
                place = point - height / 2 * normal
                yield np.array([*(sign * normal), *place, *place, abs(height), state == 1])


def pieces_of(start, line, corners, rounding, beyond):
    """Parts of a segment with one state each, as shares of its length; what is shorter than rounding joins another."""
    polygon, cuts, pieces = shapely.Polygon(corners), {0.0, 1.0}, []
    for tail, head in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        cuts.add(float(np.clip((tail - start) @ line / (line @ line), 0, 1)))
        turn = np.linalg.det([line, head - tail])
        if turn:
            cuts.add(float(np.clip(np.linalg.det([tail - start, head - tail]) / turn, 0, 1)))
    for a, b in pairwise(sorted(cuts)):
        short = (b - a) * np.linalg.norm(line) <= rounding
        state = None if short else state_of(start + (a + b) / 2 * line, polygon, rounding, beyond)
        if pieces and (short or pieces[-1][2] == state):
            pieces[-1][1] = b
        elif not short:
            pieces.append([a if pieces else 0.0, b, state])
    return pieces


def edges_with_rims(faces_of, other, limits, sign):
    reach, rounding, beyond = limits
    for face, normal in zip(faces_of.faces, faces_of.normals, strict=True):
        across = plane(normal)
        corners = (face - face[0]) @ across.T
        polygon = shapely.Polygon(corners)
        for ends, (p, q) in other.lines.items():
            heights = float((p - face[0]) @ normal), float((q - face[0]) @ normal)
            if min(heights) > reach or max(heights) < -reach:
                continue
            if abs(heights[1] - heights[0]) > STEEP * np.linalg.norm(q - p):
                continue
            start = across @ (p - face[0])
            line = across @ (q - p)
            pieces = pieces_of(start, line, corners, rounding, beyond)
            lean = min(inward @ normal for inward in other.edges[ends])
            for a, b, state in pieces:
                found = [(1 - s) * heights[0] + s * heights[1] for s in (a, b)]
                gap = max(map(abs, found))
                inset = polygon.exterior.distance(shapely.Point(start + (a + b) / 2 * line))
                closes = gap <= (beyond if state == 1 else min(reach, inset))
                if closes and (state == 1 or (state == 2 and lean >= -LEAN)):
                    points = [p + s * (q - p) - h / 2 * normal for s, h in zip((a, b), found, strict=True)]
                    yield np.array([*(sign * normal), *points[0], *points[1], gap, state == 1])


def same_with_rims(features, k, expected):
    own = features.take(features.row == k)
    found = np.column_stack([own.normal, own.ends.reshape(-1, 6), own.gap, own.rim])
    assert len(found) == len(expected)
    for row in expected:
        swapped = row[[0, 1, 2, 6, 7, 8, 3, 4, 5, 9, 10]]
        assert min(np.abs(found - r).max(axis=1).min() for r in (row, swapped)) < 1e-9


@pytest.mark.parametrize("seed", [2, 5, 6, 7, 9, 11, 12, 13, 14, 20])
def test_where_rims_are_wanted_contacts_on_them_are_found_as_far_as_the_gap_blurs_them(seed):
    asm, allowed = scene(seed), np.array([0.3, 0.25, 0.2])
    solids = [Solid(asm, k) for k in range(3)]
    rims = 0
    for blurred in (True, False):
        search = search_of(asm, PAIRS, Tolerances(allowed, 0.01, STEEP, blurred), rims=True)
        lines, dots = features_of(search, STEEP)
        for k, (a, b) in enumerate(PAIRS):
            reach, rounding = search.limits(k)
            assert rounding == pytest.approx(0.01 * min(asm.size[a], asm.size[b]))
            limits = reach, rounding, reach if blurred else rounding
            one, two = solids[a], solids[b]
            both = [(one, two, limits, 1.0), (two, one, limits, -1.0)]
            same_with_rims(lines, k, [row for side in both for row in edges_with_rims(*side)])
            same_with_rims(dots, k, [row for side in both for row in corners_with_rims(*side)])
        rims += lines.rim.sum() + dots.rim.sum()
    assert rims > 0


# Pairs that may touch where there is no unique normal.

CUBE_AT = {
    "on it": ((0.2, 0.3, 1.0), False),
    "a little above it": ((0.2, 0.3, 1.003), False),
    "a little into it": ((0.2, 0.3, 0.997), False),
    "along an edge": ((1.0, 0.3, 1.0), True),
    "at a corner": ((1.0, 1.0, 1.0), True),
    "across a gap along an edge": ((1.009, 0.3, 1.009), True),
    "too far along one axis": ((1.011, 0.3, 1.0), False),
    "too far along two axes": ((1.02, 0.3, 1.02), False),
    "beside it": ((1.0, 0.2, 0.3), False),
}


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("where", CUBE_AT)
def test_convex_blocks_on_two_sides_of_a_plane_touch_on_no_rim_outside_it(where, flip):
    corner, rim = CUBE_AT[where]
    blocks = [box(*CUBE), box(corner, np.add(corner, 1.0))]
    found = find_interfaces(assembly(blocks[::-1] if flip else blocks))
    assert found.rims.tolist() == ([[0, 1]] if rim else [])


@pytest.mark.parametrize(
    ("outline", "until"),
    [
        # One foot whole on the cube; a second one half a gap higher; an arm that hangs down beside the cube.
        ([(0.2, 1), (0.6, 1), (0.6, 1.5), (1.5, 1.5), (1.5, 2), (0.2, 2)], 0.6),
        ([(0.2, 1), (0.6, 1), (0.6, 1.003), (0.9, 1.003), (0.9, 2), (0.2, 2)], 0.9),
        ([(0.2, 1), (0.6, 1), (0.6, 1.5), (1.2, 1.5), (1.2, 0.5), (1.5, 0.5), (1.5, 2), (0.2, 2)], 0.6),
        # A foot and an edge in its plane: one joint from the foot to the edge.
        ([(0.2, 1), (0.4, 1), (0.4, 1.3), (0.6, 1.3), (0.8, 1.0), (0.9, 1.3), (0.9, 2), (0.2, 2)], 0.8),
    ],
)
@pytest.mark.parametrize("flip", [False, True])
def test_a_block_with_notches_is_one_joint_with_all_that_touches_in_the_plane_of_its_foot(outline, until, flip):
    body = prism(outline, 0.5)
    body = Block(np.asarray(body.vertices, float) + [0, 0.2, 0], body.faces)
    blocks = [box(*CUBE), body]
    found = find_interfaces(assembly(blocks[::-1] if flip else blocks))
    assert found.rims.tolist() == [[0, 1]]
    assert found.kinds.tolist() == [ContactKind.FACE]
    assert (found.point[:, 0].min(), found.point[:, 0].max()) == (pytest.approx(0.2), pytest.approx(until))


@pytest.mark.parametrize("flip", [False, True])
def test_an_edge_on_another_face_than_that_of_the_foot_is_a_contact_of_its_own(flip):
    # A hook: its foot on the cube, and an edge of its arm against the cube's side.
    outline = [
        (0.2, 1),
        (0.7, 1),
        (0.7, 1.2),
        (1.2, 1.2),
        (1.2, 0.8),
        (1.0, 0.5),
        (1.2, 0.2),
        (1.5, 0.2),
        (1.5, 2),
        (0.2, 2),
    ]
    body = prism(outline, 0.5)
    body = Block(np.asarray(body.vertices, float) + [0, 0.2, 0], body.faces)
    blocks = [box(*CUBE), body]
    found = find_interfaces(assembly(blocks[::-1] if flip else blocks))
    assert found.kinds.tolist() == [ContactKind.FACE, ContactKind.EDGE]
    own = found.point[found.start[1] :]
    assert sorted(map(tuple, own.round(9).tolist())) == [(1.0, 0.2, 0.5), (1.0, 0.7, 0.5)]
    assert found.frame[1, 0] == pytest.approx([-1.0 if flip else 1.0, 0, 0], abs=1e-12)


def test_the_plane_of_a_narrow_patch_is_not_taken_for_one_that_divides_its_blocks():
    # A strip of 15 micrometres that leans by ten degrees: its plane, halfway between the faces, runs into the floor.
    rise = 1.5e-5 * np.tan(np.radians(10))
    upper = prism([(0, 0), (1.5e-5, rise), (5, 4), (5, 6), (0, 6)], 5.0)
    found = find_interfaces(assembly([prism([(-5, -5), (5, -5), (5, 0), (-5, 0)], 5.0), upper]))
    assert found.area[found.kinds == ContactKind.FACE] == pytest.approx([1.5e-5 * 5], rel=2e-2)
    assert found.rims.tolist() == [[0, 1]]


@pytest.mark.parametrize("depth", [1.0, 1.5])
def test_an_edge_in_a_face_that_holds_it_down_has_the_normal_of_that_face(depth):
    # A dovetail in its slot: the edges of its foot lie in the flanks, whose normals look the other way.
    slot = prism([(0, 0), (4, 0), (4, 2), (2.5, 2), (3, 1), (1, 1), (1.5, 2), (0, 2)], 1.0)
    asm = assembly([slot, prism([(1, 1), (3, 1), (2.5, 2), (1.5, 2)], depth)])
    joints = find_interfaces(asm)
    assert joints.n_interfaces == 3
    assert len(unresolved_contacts(asm, joints, pairs=np.array([(0, 1)])).pair) == 0
    # Two of them, of which the numbers are nested: sorted by their second numbers, pairs are not sorted.
    key = prism([(1, 1), (3, 1), (2.5, 2), (1.5, 2)], depth)
    away = [Block(np.asarray(block.vertices) + (20, 0, 0), block.faces) for block in (slot, key)]
    two = assembly([slot, *away, key])
    pairs = np.array([(0, 3), (1, 2)])
    assert len(unresolved_contacts(two, find_interfaces(two), pairs=pairs).pair) == 0
