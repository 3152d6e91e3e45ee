"""A U-shaped wall of cubes and stretchers pushed out of plane, bonded at its corners.

Unit cubes and stretchers of 2 x 1 x 1, facade x in [0, 6], y in [0, 1], side walls to y = 5. In even courses the facade
has the corners (stretchers from x = 0), in odd ones the side walls (stretchers from y = 0). Load lambda W towards -y,
mu = 0.7. Limits derived by an independent program over four corner points a face; the facade alone has 1 / n.
"""

import pytest

from blockstat import limit_load
from blockstat.model import Run, walls
from walls import grounded


def u_wall(courses, **options):
    runs = [
        Run(name="facade", path=[(0.5, 0.5), (5.5, 0.5)], thickness=1, height=courses),
        Run(name="west", path=[(0.5, 0.5), (0.5, 5)], thickness=1, height=courses),
        Run(name="east", path=[(5.5, 0.5), (5.5, 5)], thickness=1, height=courses),
    ]
    return walls(runs, brick=(2, 1), **options)


def test_layout():
    plan = {
        b.name: tuple(
            (round(float(b.vertices[:, k].min()), 9), round(float(b.vertices[:, k].max()), 9)) for k in (0, 1)
        )
        for b in u_wall(4)
    }
    courses = {
        0: [((0, 2), (0, 1)), ((2, 4), (0, 1)), ((4, 6), (0, 1)), ((0, 1), (1, 3)), ((0, 1), (3, 5)), ((5, 6), (1, 3)),
            ((5, 6), (3, 5))],
        1: [((1, 3), (0, 1)), ((3, 5), (0, 1)), ((0, 1), (0, 2)), ((0, 1), (2, 4)), ((0, 1), (4, 5)), ((5, 6), (0, 2)),
            ((5, 6), (2, 4)), ((5, 6), (4, 5))],
    }  # fmt: skip
    for course in range(4):
        found = sorted(place for name, place in plan.items() if name.split(".")[2] == str(course))
        assert found == sorted(courses[course % 2])


@pytest.mark.parametrize(("courses", "limit"), [(4, 0.552372), (8, 0.389499)])
def test_limit_of_the_bonded_wall(courses, limit):
    answer = limit_load(grounded(u_wall(courses)), (0, -1, 0), friction=0.7)
    assert answer.lower == pytest.approx(limit, abs=2e-6)
    assert answer.upper == pytest.approx(limit, abs=2e-6)


def test_straight_joints_at_the_corners_cost_strength():
    loose = limit_load(grounded(u_wall(4, bonded=False)), (0, -1, 0), friction=0.7)
    # Not less than the facade alone, and well below the bonded wall.
    assert 0.25 < loose.lower <= loose.upper < 0.8 * 0.552372
