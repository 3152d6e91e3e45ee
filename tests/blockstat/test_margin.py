import pytest

from blockstat import Assembly, assess, box
from blockstat.design_search.margin import Margin, measure


def leaning(values):
    """A pillar as wide as the parameter, a slab that falls off it, and a lid that a width of 0.5 just meets."""
    width = values["width"]
    blocks = [
        box((-3, -3, -1), (4, 4, 0), name="ground"),
        box((0, 0, 0), (width, 1, 1), name="pillar"),
        box((0.5, 1, 0), (1, 3, 1), name="neighbour"),
        box((0.5, 0.2, 1), (1, 2.8, 1.2), name="lid"),
        box((-1, 0, 1), (0.5, 1, 1.2), name="slab"),
    ]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)


def test_a_design_that_falls_where_joints_change_has_its_own_score():
    # A hair wider, the pillar carries the lid too, so there is no derivative; the score is known all the same.
    found = measure(leaning, {"width": 0.5}, ("width",), Margin())
    score = assess(leaning({"width": 0.5})).score
    assert 0 < score < 1
    assert found.static == "unstable"
    assert found.reserve == pytest.approx(-score, rel=1e-6)
