"""Overlaps of blocks that are not convex, of very many blocks, and of blocks inside others."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.spatial.transform import Rotation

from blockstat import Block, InputError, Outcome, assess, overlaps
from blockstat.geometry.convex_pieces import convex_pieces
from blockstat.geometry.convexity import protrusions, surface_stays_out
from blockstat.geometry.inscribed_ball import inscribed_balls
from blockstat.geometry.triangulation import triangulate
from evidence.scenes.small import assembly, box, prism

STEPS = [(0, 0), (3, 0), (3, 1), (2, 1), (2, 2), (1, 2), (1, 3), (0, 3)]
NOTCH = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
TEE = [(1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (0, 3), (0, 2), (1, 2)]
ELL = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
OTHER_ELL = [(1, 1), (2, 1), (2, 0), (3, 0), (3, 2), (1, 2)]
HOOK = [(0, 0), (4, 0), (4, 3), (2, 3), (2, 2), (3, 2), (3, 1), (0, 1)]
OTHER_HOOK = [(0, 1), (3, 1), (3, 2), (2, 2), (2, 3), (4, 3), (4, 4), (0, 4)]
#: A stone with twenty corners, two of them in the middle of a side but for the eleventh decimal.
NEARLY_IN_LINE = [
    [0.53238249981, 0.38227940234, -0.7725224744],
    [0.62000054905, -0.16880674798, -0.59867382842],
    [0.83474664213, -0.22727539672, -0.80603311773],
    [0.74321494244, 0.32487632786, -0.976102725],
    [0.67005841635, 0.34479456367, -0.90546262994],
    [0.69098802546, 0.41096210111, -0.96090162748],
    [0.52043941308, 0.45739715768, -0.79621952788],
    [0.52300732296, 0.44124589897, -0.7911243704],
    [0.55074353574, 0.37728027353, -0.79025193748],
    [0.0916123755, 0.1856867324, -1.17356145742],
    [0.17923042562, -0.36539942887, -0.99971281044],
    [0.39397652084, -0.42386807179, -1.20707209748],
    [0.30244482741, 0.12828365111, -1.37714171465],
    [0.22928829621, 0.14820188535, -1.30650161509],
    [0.25021790037, 0.21436942895, -1.36194061806],
    [0.07966929258, 0.26080448042, -1.19725851425],
    [0.08223720185, 0.24465322913, -1.19216334943],
    [0.10997341398, 0.18068760193, -1.19129091569],
    [0.73418762078, 0.32733419123, -0.96738592363],
    [0.23438876535, 0.16432667447, -1.32001189677],
]
NEARLY_IN_LINE_FACES = [
    [0, 1, 2, 3, 18, 4, 5, 6, 7, 8],
    [17, 16, 15, 14, 19, 13, 12, 11, 10, 9],
    [0, 9, 10, 1],
    [1, 10, 11, 2],
    [2, 11, 12, 3],
    [3, 12, 13, 4, 18],
    [4, 13, 19, 14, 5],
    [5, 14, 15, 6],
    [6, 15, 16, 7],
    [7, 16, 17, 8],
    [8, 17, 9, 0],
]


def shifted(outline, x, z):
    return [(a + x, b + z) for a, b in outline]


def moved(blocks, seed):
    """The same blocks turned at random, and far from the origin."""
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    return [
        Block(np.asarray(block.vertices, dtype=float) @ turn.T + [4.5e5, 5.3e6, 300], block.faces, name=block.name)
        for block in blocks
    ]


@pytest.mark.parametrize("sunk", [0.3, 1.5])
def test_a_box_sunk_into_a_stepped_floor_is_refused(sunk):
    # The largest ball in a box and the second step is as wide as the box is sunk, or as the box.
    stone = box((1.5, 0, 2 - sunk), (2, 1, 2 - sunk + 1), name="stone")
    asm = assembly([prism(STEPS, 1.0, name="floor"), stone])
    pairs, depth = overlaps(asm, gap=0.01)
    assert pairs.tolist() == [[0, 1]]
    assert depth[0] == pytest.approx(min(sunk, 0.5))
    with pytest.raises(InputError, match='"stone"'):
        assess(asm)


def test_a_shallow_overlap_with_a_stepped_floor_is_told_and_proves_nothing():
    # The stone has a joint with the riser of a step, and should have one with the tread, into which it is sunk.
    asm = assembly([prism(STEPS, 1.0, name="floor"), box((1, 0, 1.95), (2, 1, 2.95), name="stone")])
    verdict = assess(asm)
    assert any('1 pairs of blocks overlap, the worst "floor" and "stone" by 0.05 m' in w for w in verdict.warnings)
    assert verdict.outcome is not Outcome.UNSTABLE


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("one", "two"), [(NOTCH, TEE), (ELL, OTHER_ELL), (HOOK, OTHER_HOOK), (STEPS, shifted(ELL, 2, 1))]
)
def test_concave_blocks_that_interlock_do_not_overlap(one, two, seed):
    blocks = moved([prism(one, 1.0), prism(two, 1.0)], seed)
    assert len(overlaps(assembly(blocks), gap=1e-6)[0]) == 0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("one", "two", "move"),
    [(NOTCH, TEE, (0, -1)), (ELL, OTHER_ELL, (-1, 0)), (HOOK, OTHER_HOOK, (0, -1)), (STEPS, ELL, (2, 1))],
)
@pytest.mark.parametrize("depth", [0.02, 0.15])
def test_concave_blocks_overlap_by_what_they_are_pushed_into_each_other(one, two, move, depth, seed):
    x, z = (depth * m if abs(m) == 1 and m < 0 else m - depth * (m == 1) for m in move)
    blocks = moved([prism(one, 1.0), prism(shifted(two, x, z), 1.0)], seed)
    pairs, found = overlaps(assembly(blocks), gap=1e-3)
    assert pairs.tolist() == [[0, 1]]
    assert found[0] == pytest.approx(depth, rel=1e-4)


def _split_edges(outline, rng):
    """The same outline with corners more in the middle of its sides."""
    ends = zip(outline, outline[1:] + outline[:1], strict=True)
    return [
        tuple(np.add(np.multiply(a, 1 - share), np.multiply(b, share)))
        for a, b in ends
        for share in [0.0, *np.sort(rng.uniform(0.1, 0.9, rng.integers(0, 3)))]
    ]


@pytest.mark.parametrize("noise", [6e-8, 1e-8, 5e-5])
@pytest.mark.parametrize("depth", [0.0, 0.3])
@pytest.mark.parametrize(
    ("one", "two", "move"), [(NOTCH, TEE, (0, -1)), (ELL, OTHER_ELL, (-1, 0)), (HOOK, OTHER_HOOK, (0, -1))]
)
def test_rounding_neither_makes_an_overlap_of_interlocking_blocks_nor_alters_one(one, two, move, depth, noise):
    # Each corner moves by less than twice the noise, and so does each face of a block.
    for seed in range(10):
        rng = np.random.default_rng(seed)
        turn = Rotation.random(rng=rng).as_matrix()
        blocks = []
        for outline in (one, shifted(two, depth * move[0], depth * move[1])):
            block = prism(_split_edges(outline, rng), 1.0)
            corners = np.asarray(block.vertices, dtype=float) @ turn.T
            blocks.append(Block(corners + rng.uniform(-noise, noise, corners.shape), block.faces))
        found = overlaps(assembly(blocks), gap=1e-3)[1]
        np.testing.assert_allclose(found, [depth] if depth else [], atol=1e-3)


def test_blocks_given_to_four_decimals_interlock():
    turn = Rotation.from_euler("z", 3, degrees=True).as_matrix()
    blocks = []
    for outline in (ELL, OTHER_ELL):
        n = len(outline)
        corners = np.array([(x, y, z) for y in (0, 1) for x, z in outline], dtype=float) @ turn.T
        sides = [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
        blocks.append(Block(corners.round(4), [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides]))
    assert len(overlaps(assembly(blocks), gap=0.01)[0]) == 0


def test_a_stone_with_corners_nearly_in_line_is_cut_to_the_end():
    # Seen along its extrusion: a profile whose corner on one side is out of line by the last digit given.
    corners = np.array(NEARLY_IN_LINE)
    stone = Block(corners, NEARLY_IN_LINE_FACES, name="stone")
    other = box((-0.09436569837, 0.13234652212, -1.53689709878), (0.7282926688, 0.96014592843, -0.67056018393))
    pairs, depth = overlaps(assembly([stone, other]), gap=0.01)
    assert pairs.tolist() == [[0, 1]]
    lower, upper = np.min(other.vertices, axis=0), np.max(other.vertices, axis=0)
    room = np.minimum(upper, corners.max(axis=0)) - np.maximum(lower, corners.min(axis=0))
    assert 0.01 < depth[0] < room.min()


def test_pieces_fill_the_solid_in_the_box():
    # Volumes by hulls: an independent way from half-spaces to a volume. The box cuts off what lies above z = 2.5.
    for outline, cut_off in ((STEPS, 0.5), (NOTCH, 0.0), (TEE, 1.5), (HOOK, 0.5 * 2)):
        block = prism(outline, 1.0)
        corners = np.asarray(block.vertices, dtype=float)
        triangles = corners[triangulate(corners, [np.array(face) for face in block.faces])]
        lower, upper = corners.min(axis=0), np.minimum(corners.max(axis=0), [9, 9, 2.5])
        pieces = convex_pieces([triangles], lower[None], upper[None], np.array([1e-9]))[0]
        start = np.concatenate([[0], np.cumsum([len(p) for p in pieces])])
        planes = np.concatenate(pieces)
        _, centre = inscribed_balls(planes[:, :3], planes[:, 3], start)
        volume = sum(
            ConvexHull(HalfspaceIntersection(p * [1, 1, 1, -1], c).intersections).volume
            for p, c in zip(pieces, centre, strict=True)
        )
        assert volume == pytest.approx(assembly([block]).volume[0] - cut_off)


def test_balls_are_those_of_linear_programs():
    rng = np.random.default_rng(1)
    sets = []
    for k in range(60):
        normal = rng.normal(size=(rng.integers(1, 30), 3))
        if k % 3 == 0:  # boxes of one orientation: many ties
            normal = np.round(normal / np.abs(normal).max(axis=1)[:, None])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        planes = np.column_stack([normal, rng.uniform(-0.2, 1.0, len(normal)).round(1 + k % 5)])
        sets.append(np.vstack([planes, np.column_stack([np.vstack([np.eye(3), -np.eye(3)]), np.ones(6)])]))
    start = np.concatenate([[0], np.cumsum([len(s) for s in sets])])
    radius, centre = inscribed_balls(np.concatenate(sets)[:, :3], np.concatenate(sets)[:, 3], start)
    for planes, r, c in zip(sets, radius, centre, strict=True):
        bounds = [(None, None)] * 4
        exact = linprog(
            [0, 0, 0, -1], np.column_stack([planes[:, :3], np.ones(len(planes))]), planes[:, 3], bounds=bounds
        )
        assert r == pytest.approx(exact.x[3], abs=1e-8)
        assert (planes[:, 3] - planes[:, :3] @ c).min() == pytest.approx(r, abs=1e-9)


def test_four_hundred_cubes_that_all_overlap_are_reported_at_once():
    place = np.random.default_rng(5).uniform(0, 0.4, (400, 3))
    asm = assembly([box(p, p + 1) for p in place])
    pairs, depth = overlaps(asm, gap=0.01)
    with pytest.raises(InputError, match="overlap by"):
        assess(asm)
    exact = {(a, b): 1 - np.abs(place[a] - place[b]).max() for a, b in combinations(range(400), 2)}
    assert list(map(tuple, pairs.tolist())) == list(exact)
    np.testing.assert_allclose(depth, list(exact.values()), atol=1e-7)


def test_thousands_of_copies_at_one_place_are_reported_at_once():
    blocks = [box((-9, -9, -1), (9, 9, 0), name="base"), *[box((0, 0, 0), (1, 1, 1)) for _ in range(3000)]]
    asm = assembly(blocks)
    with pytest.raises(InputError, match=r'blocks "block1" and "block2" are copies at one place \(2999 blocks'):
        assess(asm)
    pairs, depth = overlaps(asm, gap=0.01)
    assert pairs.tolist() == [[1, k] for k in range(2, 3001)]
    assert depth == pytest.approx(1.0)


def test_two_supports_may_be_copies():
    base = ((-1, -1, -1), (2, 2, 0))
    asm = assembly([box(*base), box(*base), box((0, 0, 0), (1, 1, 1))], supports=[0, 1])
    assert assess(asm).outcome is Outcome.STABLE


@pytest.mark.parametrize(
    ("outer", "place"), [(box((0, 0, 0), (2, 2, 2), name="outer"), 0.5), (prism(STEPS, 3.0, name="outer"), 0.2)]
)
def test_a_block_inside_another_is_named(outer, place):
    inner = box([place] * 3, [place + 0.6] * 3, name="inner")
    with pytest.raises(InputError, match='block "inner" lies inside block "outer"'):
        assess(assembly([outer, inner]))


def test_a_block_across_a_notch_does_not_lie_inside():
    # Every corner of the beam lies in an arm of the block, but its middle is over the notch.
    with pytest.raises(InputError, match='blocks "outer" and "beam" overlap by'):
        assess(assembly([prism(NOTCH, 1.0, name="outer"), box((0.2, 0.2, 1.2), (2.8, 0.8, 1.8), name="beam")]))


def star(rng, size):
    """A star-shaped solid with notches: an icosahedron whose corners are moved along their rays."""
    golden = (1 + 5**0.5) / 2
    corners = np.array([(0, s, t * golden) for s in (1, -1) for t in (1, -1)])
    corners = np.concatenate([np.roll(corners, k, axis=1) for k in range(3)])
    faces = ConvexHull(corners).simplices
    a, b, c = np.moveaxis(corners[faces], 1, 0)
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    faces[turned] = faces[turned][:, ::-1]
    return Block(corners * rng.uniform(0.4, 1.0, (12, 1)) * size, faces.tolist())


def test_no_dismissal_loses_an_overlap():
    # The brute force is the largest ball in any two tetrahedra of two stars, which have a common corner each.
    rng = np.random.default_rng(7)
    found = {True: 0, False: 0}
    for _ in range(150):
        one, two = star(rng, 1.0), star(rng, rng.choice([0.3, 1.0]))
        way = rng.normal(size=3)
        place = rng.uniform(0.2, 2.4) * way / np.linalg.norm(way)
        two = Block(np.asarray(two.vertices) + place, two.faces)
        asm = assembly([one, two])
        depth = _deepest(_fan(one, np.zeros(3)), _fan(two, place))
        shape = asm.size.min()
        out = protrusions(asm)
        for gap in (1e-4, 1e-2, 1e-1):
            dismissed = [
                surface_stays_out(asm, np.array([pair]), out, np.array([gap * shape / 2]))[0]
                for pair in ((0, 1), (1, 0))
            ]
            if depth > gap * shape:
                assert not any(dismissed)
                # The ball lies in one piece of each, and the pieces are not the tetrahedra.
                assert len(overlaps(asm, gap=0.1 * gap)[0]) == 1
            found[any(dismissed)] += 1
    assert min(found.values()) > 50


def _fan(block, centre):
    """Half-spaces of the tetrahedra from the centre to each triangle, shape (n, 4, 4)."""
    a, b, c = np.moveaxis(np.asarray(block.vertices)[np.asarray(block.faces)], 1, 0)
    normals = [
        np.cross(q - p, r - p)
        for p, q, r in ((a, b, c), (a, centre + 0 * a, b), (b, centre + 0 * a, c), (c, centre + 0 * a, a))
    ]
    normals = [n / np.linalg.norm(n, axis=1)[:, None] for n in normals]
    return np.stack(
        [np.column_stack([n, (n * p).sum(axis=1)]) for n, p in zip(normals, (a, a, b, c), strict=True)], axis=1
    )


def _deepest(one, two):
    """Diameter of the largest ball in any two of two lists of tetrahedra."""
    sets = np.concatenate(np.broadcast_arrays(one[:, None], two[None]), axis=2).reshape(-1, 4)
    return 2 * inscribed_balls(sets[:, :3], sets[:, 3], np.arange(0, len(sets) + 1, 8))[0].max()


def test_a_copy_with_its_corners_in_another_order_is_a_copy():
    stone = box((0, 0, 0), (1, 2, 3))
    order = np.random.default_rng(3).permutation(8)
    turned = Block(np.asarray(stone.vertices)[order], [np.argsort(order)[face].tolist() for face in stone.faces])
    base = box((-1, -1, -1), (2, 3, 0))
    with pytest.raises(InputError, match="are copies at one place"):
        assess(assembly([base, stone, turned]))


def test_three_thousand_cubes_that_all_overlap_are_refused():
    place = np.random.default_rng(6).uniform(0, 0.01, (3000, 3))
    asm = assembly([box(p, p + 1) for p in place])
    with pytest.raises(InputError, match="overlap by"):
        assess(asm)
