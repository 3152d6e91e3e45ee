"""Random scenes: no verdict of the statics is wrong, and none undecided without need.

`python -m evidence.fuzz --only SEED` repeats a failure with the contacts that the judge found; `make fuzz` judges
20,000 scenes.
"""

from dataclasses import replace

import pytest

from evidence.checks import independent
from evidence.fuzz.compare import compared
from evidence.fuzz.generate import FAMILIES
from evidence.fuzz.limits import limit
from evidence.fuzz.report import bracket_line, line

SCENES = 300
PLACES = 10  #: every so many rounds of the families, scenes are also moved and reordered


@pytest.mark.parametrize("family", FAMILIES)
def test_verdicts_on_random_scenes_are_the_truth(family):
    first, step = list(FAMILIES).index(family), len(FAMILIES)
    results = [compared(seed, places=seed // step % PLACES == 0) for seed in range(first, SCENES, step)]
    assert not [line(result) for result in results if result.fails]


def test_limit_loads_of_random_scenes_lie_between_polygons_inside_and_outside_the_cones():
    found = [bracket for seed in range(60) if (bracket := limit(seed)) is not None]
    assert len(found) > 10
    assert not [bracket_line(bracket) for bracket in found if bracket.fails]


@pytest.mark.parametrize("seed", [496, 572, 629, 1085, 521, 1233])
def test_limit_loads_that_the_optimum_leaves_open_are_narrowed_by_verdicts(seed, monkeypatch):
    # A bracket that verdicts have narrowed ends at a multiplier that was tried, above what the mechanism there proves.
    monkeypatch.setattr(independent, "TIGHT", 1e-3)
    # Masses from 1e-6 to 1e2, where the optimum is not good to the lightest block's weight; infinite friction far from
    # the origin, where planes that were parallel differ by rounding; a cone that is reached only by growing forces.
    found = limit(seed)
    # Seed 1233 is narrowed to 1e-4, and so called a limit, or to 3e-4, as the rounding of the machine goes.
    assert found.word in ("limit", "undecided"), bracket_line(found)
    assert not replace(found, word="limit").fails, bracket_line(found)
    assert found.upper - found.lower <= 1e-3 * found.upper


def test_a_load_that_is_carried_by_forces_that_grow_with_its_square_is_unbounded():
    found = limit(142)
    assert not found.fails, bracket_line(found)
    assert found.word == "unbounded"
