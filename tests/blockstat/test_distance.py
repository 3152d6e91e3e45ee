"""The distance between blocks is exact: corner to face, edge to edge, over notches and through faces."""

import numpy as np
import pytest

from blockstat import Assembly, Block, assess, box
from blockstat.surface.distance import smallest_gap

BOTH = np.array([0, 1])


def gap_of(one, other):
    return smallest_gap(Assembly.from_blocks([one, other], supports=[0]), BOTH, BOTH)[0]


def turned(block, rotation, offset):
    return Block(np.asarray(block.vertices) @ np.asarray(rotation).T + offset, block.faces)


def about(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.insert(np.insert([[c, -s], [s, c]], axis, 0, axis=0), axis, np.eye(3)[axis], axis=1)


CUBE = box((-1, -1, -1), (1, 1, 1))


def test_a_face_over_a_face():
    assert gap_of(CUBE, box((-3, -3, 1.3), (3, 3, 2))) == pytest.approx(0.3)


def test_a_corner_over_a_face():
    # The diagonal of the cube stands upright: its lowest corner is sqrt(3) below its centre.
    axis = np.array([1, 1, 1]) / np.sqrt(3)
    side = np.array([1, -1, 0]) / np.sqrt(2)
    upright = np.array([side, np.cross(axis, side), axis])
    assert gap_of(box((-9, -9, -1), (9, 9, 0)), turned(CUBE, upright, (0.2, 0.1, 2.0))) == pytest.approx(2 - np.sqrt(3))


def test_an_edge_across_an_edge():
    # Both cubes stand on edges that cross at right angles, sqrt(2) from the centres.
    low, high = turned(CUBE, about(0, np.pi / 4), (0, 0, 0)), turned(CUBE, about(1, np.pi / 4), (0, 0, 3.0))
    assert gap_of(low, high) == pytest.approx(3 - 2 * np.sqrt(2))


def test_over_the_notch_of_a_block_the_corner_is_further_away():
    u = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    vertices = [(x, y, z) for y in (0.0, 9.0) for x, z in u]
    sides = [[(i + 1) % 8, i, i + 8, (i + 1) % 8 + 8] for i in range(8)]
    channel = Block(vertices, [list(range(8)), list(range(15, 7, -1)), *sides])
    # Its ends are faces with a notch: a peg that enters there is 0.25 from the arms, and 0.3 from the bottom.
    assert gap_of(channel, box((1.25, -1, 1.3), (1.6, 1, 1.8))) == pytest.approx(0.25)


def test_an_edge_through_a_face_leaves_no_distance():
    assert gap_of(box((-3, -3, -1), (3, 3, 0)), box((-0.1, -0.1, -2), (0.1, 0.1, 2))) == 0


def test_the_smallest_gap_of_many_is_that_of_all_pairs():
    rng = np.random.default_rng(5)
    blocks = []
    for x in range(4):
        for y in range(4):
            q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            rotation = q * np.linalg.det(q)
            blocks.append(turned(CUBE, rotation, (3.9 * x, 3.9 * y, rng.uniform(0, 1))))
    many = Assembly.from_blocks(blocks, supports=[0])
    alone = {(a, b): gap_of(blocks[a], blocks[b]) for a in range(16) for b in range(a)}
    everywhere = np.arange(16)
    found, a, b = smallest_gap(many, everywhere, everywhere)
    assert found == pytest.approx(min(alone.values()), rel=1e-12) == alone[b, a]
    found, a, b = smallest_gap(many, np.array([7]), everywhere)
    assert found == pytest.approx(min(gap for pair, gap in alone.items() if 7 in pair), rel=1e-12)


def test_blocks_that_do_not_touch_are_told_how_far_apart_they_are():
    blocks = [box((-3, -3, -1), (3, 3, 0), name="floor")]
    blocks += [box((x, 0, 0.02), (x + 1, 1, 1), name=f"stone {x:g}") for x in (-2.0, -0.75, 0.75)]
    verdict = assess(Assembly.from_blocks(blocks, supports=["floor"]))
    assert verdict.outcome.word == "unstable"
    assert verdict.warnings[0] == (
        'no two blocks touch: the smallest gap between two of them is 0.25 m ("stone -2" and "stone -0.75"), '
        'and 0.02 m to a support ("stone -2" and "floor")'
    )


def test_there_is_no_distance_to_no_block():
    two = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 2), (1, 1, 3))], supports=[0])
    none = np.empty(0, dtype=np.int64)
    assert smallest_gap(two, np.array([0]), none) == (np.inf, -1, -1)
    assert smallest_gap(two, none, np.array([0, 1])) == (np.inf, -1, -1)


def test_a_corner_listed_twice_is_no_edge_without_length():
    face = CUBE.faces[0]
    k = next(k for k, corner in enumerate(face) if CUBE.vertices[corner][0] == 1)
    faces = [[*face[:k], 8, *face[k:]], *CUBE.faces[1:]]
    one = Block([*CUBE.vertices, CUBE.vertices[face[k]]], faces)
    with np.errstate(all="raise"):
        assert gap_of(one, turned(CUBE, np.eye(3), (2.5, 0, 0))) == pytest.approx(0.5)
