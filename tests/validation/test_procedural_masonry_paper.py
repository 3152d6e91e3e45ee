"""Eqs. 3-5 of the procedural-masonry paper, worked by hand.

A wall of 12 m with bricks of 1.6 m and three buttresses:
LongitudeRow = NumberOfPoints x SizeOfBrick + HalfBrick: 12 = 7 x 1.6 + 0.8;
DistanceAmongButtresses = LongitudeRow / (number + 1): 12 / 4 = 3, so they stand at 3, 6 and 9 m, centred between the
wall's ends, each perpendicular to the wall and on its outer side.
"""

import numpy as np
import pytest

from blockstat.model import Buttress, Run, walls


def build(path, *, bonded=True, side="right"):
    return walls(
        Run(name="south", path=path, thickness=0.5, height=2.0),
        brick=(1.6, 0.4),
        buttresses=[Buttress(wall="south", number=3, width=0.6, projection=0.9, height=1.2, bonded=bonded, side=side)],
    )


def along(blocks, group, direction):
    places = np.concatenate([b.vertices[:, :2] @ direction for b in blocks if b.group == group])
    return float(places.min()), float(places.max())


def test_a_row_is_whole_bricks_and_one_half_brick():
    blocks = [b for b in build([(0, 0), (12, 0)], bonded=False) if b.group == "wall.south"]
    for course in range(5):
        row = sorted((b for b in blocks if b.name.split(".")[2] == str(course)), key=lambda b: b.vertices[:, 0].min())
        sizes = [float(np.ptp(b.vertices[:, 0])) for b in row]
        assert sizes == pytest.approx([1.6] * 7 + [0.8] if course % 2 == 0 else [0.8] + [1.6] * 7)


@pytest.mark.parametrize("bonded", [True, False])
def test_three_buttresses_of_a_wall_of_12_m(bonded):
    blocks = build([(0, 0), (12, 0)], bonded=bonded)
    for k, place in ((1, 3.0), (2, 6.0), (3, 9.0)):
        group = f"buttress.south.{k}"
        assert along(blocks, group, (1, 0)) == pytest.approx((place - 0.3, place + 0.3))
        # To the right of a path along x is y < 0; a bonded one reaches to the far face in every second course.
        assert along(blocks, group, (0, 1)) == pytest.approx((-1.15, 0.25 if bonded else -0.25))
        assert sum(b.vertices[:, 2].max() <= 1.2 + 1e-9 for b in blocks if b.group == group) == sum(
            b.group == group for b in blocks
        )


def test_buttresses_are_perpendicular_to_a_wall_in_any_direction():
    u = np.array([0.6, 0.8])
    blocks = build([(1, 2), (1 + 12 * 0.6, 2 + 12 * 0.8)], bonded=False, side="left")
    start, left = np.array([1, 2]) @ u, np.array([-0.8, 0.6])
    for k, place in ((1, 3.0), (2, 6.0), (3, 9.0)):
        group = f"buttress.south.{k}"
        assert along(blocks, group, u) == pytest.approx((start + place - 0.3, start + place + 0.3))
        low, high = along(blocks, group, left)
        assert (low - np.array([1, 2]) @ left, high - low) == pytest.approx((0.25, 0.9))
