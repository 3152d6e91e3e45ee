"""A train on a path: places and brackets that follow from statics, what is told, and what is refused."""

import re
from math import inf, nan

import numpy as np
import pytest

from blockstat import Assembly, InputError, moving_load
from blockstat.traffic.envelope import MOST_POSITIONS
from evidence.scenes.small import assembly, box

WEIGHT = 1000.0 * 9.81 * 1.5  #: of the slab [N]; it tips about x = 2, .5 m beyond its centroid
WHEEL = [(0.0, 1000.0)]


def overhang():
    """A slab 3 m long on a pier of 2 m."""
    blocks = [box((0, 0, -1), (2, 1, 0), name="pier"), box((0, 0, 0), (3, 1, 0.5), name="slab")]
    return Assembly.from_blocks(blocks, supports=["pier"], density=1000.0)


def along(*ends, height=0.5):
    return [(x, 0.5, height) for x in ends]


def test_the_worst_place_is_told_with_its_bracket():
    found = moving_load(overhang(), WHEEL, along(0, 3), positions=7)
    first, bracket, place, count = found.explain().splitlines()
    assert (
        first == "Limit: at its worst place the train is carried up to the lower bound, and not beyond the upper one."
    )
    low, high = (float(part) for part in bracket.split(" <= multiplier <= "))
    exact = 0.5 * WEIGHT / 1000.0
    assert low * (1 - 1e-5) <= exact <= high * (1 + 1e-5)
    assert high - low <= 1.1e-3 * high
    assert place == "Worst place of the first axle: 3 m along the path."
    assert count == f"{len(found.place)} places, {found.solves} solved."


def test_a_train_that_is_carried_everywhere_has_no_worst_place_to_tell():
    found = moving_load(overhang(), WHEEL, along(0.5, 1.5), positions=1, joints=False)
    assert found.explain() == ("Unbounded: any multiple of the train is carried at every place.\n1 places, 1 solved.")
    assert found.summary()["upper"] == [None]


def test_where_the_path_crosses_a_gap_nothing_is_loaded_and_nothing_is_solved():
    scene = assembly([box((-1, -1, -1), (9, 2, 0)), box((0, 0, 0), (1, 1, 0.5)), box((4, 0, 0), (5, 1, 0.5))])
    found = moving_load(scene, WHEEL, along(0, 5), positions=1, joints=False)
    np.testing.assert_array_equal(found.place, [2.5])
    assert not found.load.any()
    assert found.lower[0] == inf
    assert found.upper[0] == inf
    assert found.solves == 0


def test_axles_on_fill_press_on_the_part_of_their_rectangle_that_has_a_face():
    """.5 m of fill spreads to .25 m on each side: of 2.65 to 3.15 m only 2.65 to 3 m is slab."""
    found = moving_load(overhang(), WHEEL, along(2.8, 3.0, height=1.0), positions=1, spread=0.5)
    exact = 0.5 * WEIGHT / (1000.0 * (2.825 - 2.0))
    assert found.lower[0] <= exact * (1 + 1e-6)
    assert found.upper[0] >= exact * (1 - 1e-6)
    assert found.lower[0] == pytest.approx(exact, rel=2e-3)


BAD_TRAIN = "each is a distance behind the first, at least 0, and a force above 0"


@pytest.mark.parametrize(
    ("axles", "path", "options", "says"),
    [
        *((WHEEL, along(0, 3), {"positions": n}, f"positions is {n!r}; it must be a whole number from 1 to 100000")
          for n in (0, 2.5, "7", MOST_POSITIONS + 1)),
        *((WHEEL, along(0, 3), {"tolerance": t}, f"tolerance is {t!r}; it must be from 1e-9 to 0.1")
          for t in (0.0, 0.11, nan)),
        *((bad, along(0, 3), {}, BAD_TRAIN)
          for bad in ([], "wheel", [1.0, 2.0, 3.0], [(0, 0)], [(0, -1)], [(-1, 5)], [(0, inf)], [(nan, 1)])),
        (WHEEL, along(0), {}, "path has shape (1, 3); two or more points of three numbers are needed"),
        (WHEEL, [(0, 0), (3, 0)], {}, "path has shape (2, 2); two or more points"),
        (WHEEL, (0, 0, 3), {}, "path has shape (3,); two or more points"),
        (WHEEL, along(0, nan), {}, "path has shape (2, 3); two or more points"),
        (WHEEL, along(0, 1, 1, 3), {}, "path: two of its points that follow each other are the same"),
        (WHEEL, along(7, 9), {}, "path: no free face of these blocks lies below it"),
    ],
)  # fmt: skip
def test_a_bad_train_or_path_is_refused(axles, path, options, says):
    with pytest.raises(InputError, match=re.escape(says)):
        moving_load(overhang(), axles, path, **options)


@pytest.mark.parametrize(("positions", "tolerance"), [(1, 0.1), (1, 1e-9)])
def test_the_ends_of_what_is_allowed_are_allowed(positions, tolerance):
    found = moving_load(overhang(), WHEEL, along(2.5, 3), positions=positions, tolerance=tolerance, joints=False)
    exact = 0.5 * WEIGHT / (1000.0 * 0.75)
    assert found.lower[0] <= exact * (1 + 1e-8)
    assert found.upper[0] >= exact * (1 - 1e-8)
