"""Bullet against closed forms and known limits (`evidence.references.dynamics`), with the tolerances of the docs."""

import re

import pytest

from dynsim import verify
from evidence.references.dynamics import BLOCKS, DIRECTIONS, LIMITS, RESTS, rocking, slips_rightly


@pytest.mark.parametrize("hull", [False, True], ids=["boxes", "hulls"])
@pytest.mark.parametrize("direction", range(DIRECTIONS))
def test_slip_within_half_a_percent_of_friction(hull, direction):
    assert slips_rightly(hull, direction)


@pytest.mark.parametrize(("width", "height"), BLOCKS)
def test_rocking_follows_housner(width, height):
    found = rocking(width, height)
    assert found.quarter == pytest.approx(1, abs=0.01)
    assert found.restitution == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize(
    "limit", [pytest.param(limit, id=limit.name, marks=[pytest.mark.slow] * limit.slow) for limit in LIMITS]
)
def test_a_family_stops_standing_at_its_limit(limit):
    assert limit.stands(1 - limit.within)
    assert not limit.stands(1 + limit.within)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(RESTS))
def test_tall_walls_and_long_arches_rest(name):
    assert verify(RESTS[name]()).outcome.word == "stands"


def test_every_row_of_the_page_names_its_test(root):
    page = (root / "docs" / "dynamics_validation.md").read_text()
    sections = {part.splitlines()[0]: part for part in page.split("\n## ")[1:]}
    tests = {title: re.search(r"^Test: `(\w+)", part, re.MULTILINE)[1] for title, part in sections.items()}
    assert all(callable(globals()[name]) for name in tests.values())
    assert len(set(tests.values())) == len(tests)
    for title, names in (("Limits", [limit.name for limit in LIMITS]), ("Rest", list(RESTS))):
        rows = [line.split(" | ")[0].removeprefix("| ") for line in sections[title].splitlines() if line[:2] == "| "]
        assert rows[1:] == names
