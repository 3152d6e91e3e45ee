"""Blocks of fine meshes: their faces and edges are found by trees, and their overlaps cell by cell."""

import numpy as np
import pytest

from blockstat import Assembly, Block, assess, find_interfaces, overlaps
from blockstat.geometry.broad_phase import MANY, row_pairs

CELLS = 14  #: along each side of a bed: 896 triangles a block
WAVE = 0.05  #: height of the waves of a bed of 1 m x 1 m


def wave(x, y):
    return 0.5 + WAVE * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y)


def between(under, over, n=CELLS):
    """A block of 1 m x 1 m in plan between two surfaces, each of 2 n n triangles."""
    x, y = (c.reshape(-1) for c in np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij"))
    low, high = (np.column_stack([x, y, surface(x, y) + 0 * x]) for surface in (under, over))
    k, top = n + 1, (n + 1) ** 2
    faces = []
    for i in range(n):
        for j in range(n):
            a, b, c, d = i * k + j, (i + 1) * k + j, (i + 1) * k + j + 1, i * k + j + 1
            faces += [[top + a, top + b, top + c], [top + a, top + c, top + d], [a, c, b], [a, d, c]]
        for a, b in ((i * k, (i + 1) * k), ((i + 1) * k + n, i * k + n), (i + 1, i), (n * k + i, n * k + i + 1)):
            faces += [[a, b, top + b], [a, top + b, top + a]]
    return Block(np.vstack([low, high]), faces)


def stack(sunk=0.0):
    """Two blocks on one wavy bed, the upper one lower than it should be by so much."""
    lower, upper = between(lambda x, y: 0.0, wave), between(wave, lambda x, y: 1.0)
    upper = Block(np.asarray(upper.vertices) - [0, 0, sunk], upper.faces)
    return Assembly.from_blocks([lower, upper], supports=[0], friction=0.6)


def brute_force(row_a, box_a, row_b, box_b, reach):
    """Each box beside each other one."""
    low = box_a[0][:, None] <= box_b[1] + reach[row_a][:, None, None]
    high = box_a[1][:, None] >= box_b[0] - reach[row_a][:, None, None]
    return np.nonzero((row_a[:, None] == row_b) & (low & high).all(axis=2))


@pytest.mark.parametrize("seed", range(3))
def test_boxes_of_crowded_rows_are_found_as_those_of_others(seed):
    random = np.random.default_rng(seed)
    row_a, row_b = np.sort(random.integers(0, 4, 500)), np.sort(random.choice(4, 700, p=[0.9, 0.08, 0.02, 0.0]))
    counts = np.bincount(row_a, minlength=4) * np.bincount(row_b, minlength=4)
    assert counts.max() > MANY > counts[counts > 0].min()
    boxes = []
    for row in (row_a, row_b):
        middle, half = random.normal(size=(len(row), 3)), 10 ** random.uniform(-4, 0, (len(row), 3))
        half[::7] = 0.0  # points
        boxes.append((middle - half, middle + half))
    reach = np.array([0.0, 0.01, 0.1, 0.2])
    found, right = (f(row_a, boxes[0], row_b, boxes[1], reach) for f in (row_pairs, brute_force))
    np.testing.assert_array_equal(np.array(found), np.array(right))


@pytest.mark.parametrize("sunk", [0.0, 1e-4])
def test_a_wavy_bed_is_a_joint_all_over(sunk):
    """The areas of its triangles, seen from above, are those of the plan."""
    assembly = stack(sunk)
    joints = find_interfaces(assembly)
    assert joints.area @ np.abs(joints.frame[:, 0, 2]) == pytest.approx(1.0, abs=20 * sunk + 1e-9)
    assert assess(assembly).outcome.word == "stable"


@pytest.mark.parametrize("sunk", [0.0, 0.003, 0.02])
def test_a_block_sinks_into_a_wavy_bed_by_what_it_is_lowered(sunk):
    """No vertical line is longer than that in both blocks, so no ball is wider; on the crests the bed is level."""
    pairs, depth = overlaps(stack(sunk), gap=0.001)
    assert pairs.tolist() == ([[0, 1]] if sunk else [])
    assert all(0.8 * sunk < d <= sunk + 0.001 for d in depth)


def test_a_block_inside_one_of_a_fine_mesh_overlaps_it():
    """Cells without any surface are inside of both. The ball is one in a convex piece, which may be half as thick."""
    outer, small = between(lambda x, y: 0.0, wave), between(lambda x, y: 0.0, wave, 9)
    inner = Block(0.2 * np.asarray(small.vertices) + [0.2, 0.2, 0.1], small.faces)
    pairs, depth = overlaps(Assembly.from_blocks([outer, inner], supports=[0]), gap=0.001)
    assert pairs.tolist() == [[0, 1]]
    assert 0.2 * (0.5 - WAVE) / 2 <= depth[0] <= 0.2 * (0.5 + WAVE)
