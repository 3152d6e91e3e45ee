"""Limit loads of walls in their plane by another formulation and another solver.

A linear program written from the blocks' corners alone: courses of boxes, two contact points a joint, Coulomb friction
as two inequalities, solved by HiGHS.
"""

import numpy as np
import pytest
from scipy.optimize import linprog

from blockstat import limit_load
from evidence.scenes.small import FERRIS, ferris_wall

BLOCK, HEIGHT, BED = 0.4, 0.175, 0.65


def joints(rows):
    """Boxes (x0, x1, course) and contacts (lower or left box, other box, two points, normal, is a head joint)."""
    boxes, contacts = [(-9.0, 9.0, -1)], []
    for course, row in enumerate(rows):
        x = 0.0
        for item in row:
            if item > 0:
                boxes.append((x, x + item * BLOCK, course))
            x += abs(item) * BLOCK
    for i, (a0, a1, course) in enumerate(boxes):
        for j, (b0, b1, other) in enumerate(boxes):
            z = HEIGHT * (course + 1)
            low, high = max(a0, b0), min(a1, b1)
            if other == course + 1 and high - low > 1e-9:
                contacts.append((i, j, ((low, z), (high, z)), (0.0, 1.0), False))
            elif other == course and abs(a1 - b0) < 1e-9:
                contacts.append((i, j, ((a1, z - HEIGHT), (a1, z)), (1.0, 0.0), True))
    return boxes, contacts


def largest_push(rows, head):
    """Greatest horizontal acceleration over g; `head` is the friction of head joints, None leaves them out."""
    boxes, contacts = joints(rows)
    points = [(i, j, p, n, head if is_head else BED) for i, j, ends, n, is_head in contacts for p in ends]
    points = [point for point in points if point[-1] is not None]
    balance, cone = np.zeros((len(boxes), 3, 2 * len(points) + 1)), []
    for k, (i, j, (x, z), (nx, nz), mu) in enumerate(points):
        for body, sign in ((i, -1), (j, 1)):
            x0, x1, course = boxes[body]
            ax, az = x - (x0 + x1) / 2, z - (course + 0.5) * HEIGHT
            for column, (fx, fz) in ((2 * k, (nx, nz)), (2 * k + 1, (-nz, nx))):
                balance[body, :, column] = sign * fx, sign * fz, sign * (ax * fz - az * fx)
        for sign in (-1, 1):
            row = np.zeros(2 * len(points) + 1)
            row[[2 * k, 2 * k + 1]] = -mu, sign
            cone.append(row)
    weight = np.array([x1 - x0 for x0, x1, _ in boxes])
    balance[:, 0, -1] = weight
    down = np.stack([0 * weight, weight, 0 * weight], axis=1)
    cost = np.append(np.zeros(2 * len(points)), -1.0)
    bounds = [(0, None), (None, None)] * len(points) + [(0, None)]
    free = balance[1:].reshape(-1, len(cost))
    found = linprog(cost, np.array(cone), np.zeros(len(cone)), free, down[1:].reshape(-1), bounds, method="highs")
    assert found.status == 0
    return -found.fun


@pytest.mark.parametrize("head", [BED, 0.2, 0.0])
@pytest.mark.parametrize("name", FERRIS)
def test_walls_by_linear_programming(name, head):
    rows = FERRIS[name][0]
    ours = limit_load(ferris_wall(rows, head_friction=head), (1, 0, 0))
    assert ours.lower == pytest.approx(largest_push(rows, head), rel=1e-7)


@pytest.mark.parametrize(("name", "derived"), [("W1", 0.639969), ("W3", 0.359007), ("W4", 0.285403)])
def test_walls_with_open_head_joints(name, derived):
    assert largest_push(FERRIS[name][0], None) == pytest.approx(derived, abs=1e-6)
