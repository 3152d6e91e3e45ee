"""Blocks that fall freely from joints that nothing has pressed: which they are, and what forbids the proof."""

import numpy as np
import pytest

from blockstat import Assembly, assess, box, glued
from blockstat.analysis.verdict import Outcome
from evidence.pages.elements import ELEMENTS


def clamped(*more, n: int = 1, **options) -> Assembly:
    """A row of n blocks between two fixed ones, and what else there is."""
    ends = [box((-1, 0, 0), (0, 1, 1), name="left"), box((n, 0, 0), (n + 1, 1, 1), name="right")]
    row = [box((k, 0, 0), (k + 1, 1, 1), name=f"row.{k}") for k in range(n)]
    fixed = [block.name for block in more if block.name.startswith("fixed")]
    return Assembly.from_blocks(
        [*ends, *row, *more], supports=["left", "right", *fixed], **{"friction": 0.9, **options}
    )


def falling(asm: Assembly, **options) -> list[str]:
    verdict = assess(asm, flow="coulomb", **options)
    assert (verdict.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS) or not len(verdict.falling)
    return [asm.names[k] for k in verdict.falling]


def test_a_row_between_two_walls_falls_and_takes_along_what_it_carries():
    rider = box((0.2, 0, 1), (0.8, 1, 1.5), name="rider")
    assert falling(clamped()) == ["row.0"]
    assert falling(clamped(n=3)) == ["row.0", "row.1", "row.2"]
    assert falling(clamped(rider)) == ["row.0", "rider"]


def test_gravity_says_what_is_down():
    asm = clamped()
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    assert falling(asm.with_(vertices=asm.vertices @ turn.T, gravity=turn @ asm.gravity)) == ["row.0"]
    assert falling(asm.with_(gravity=(9.81, 0.0, 0.0))) == []  # pressed against a wall
    assert falling(asm.with_(gravity=(0.05, 0.0, -9.81), friction=900.0)) == []  # hardly, but it closes the joint


def test_what_rests_on_a_support_does_not_fall():
    assert falling(clamped(box((0, 0, -1), (1, 1, 0), name="fixed floor"))) == []
    on_prop = [box((0.4, 0.4, -1), (0.6, 0.6, 0), name="prop"), box((0, 0, -2), (1, 1, -1), name="fixed floor")]
    assert falling(clamped(*on_prop)) == []
    hung_prop = box((0.4, 0.4, -1), (0.6, 0.6, 0), name="prop")  # held by nothing itself
    assert assess(clamped(hung_prop), flow="coulomb").outcome is Outcome.UNSTABLE


def test_glue_and_loads_are_no_free_fall():
    assert falling(glued(clamped(), 1e6)) == []
    press = np.zeros((3, 6))
    press[2, 0] = 1.0
    assert falling(clamped(), loads=press) == []


def test_an_overlap_below_stands_in_the_way_of_a_proof():
    # The ledge reaches 1 cm into the block: no joint is found there, and it may well carry.
    ledge = box((0.3, 0.3, -1), (0.7, 0.7, 0.01), name="fixed ledge")
    assert falling(clamped(ledge)) == []


@pytest.mark.parametrize(("name", "count"), [("arch-vertical", 11), ("buttress-flying", 8)])
def test_stones_between_vertical_joints_fall_freely(name, count):
    """The middle of an arch of vertical joints, and a flyer that only leans: `docs/gallery.md` shows them."""
    asm = next(build() for element, _, build, _ in ELEMENTS if element == name)
    found = falling(asm)
    assert len(found) == count
    assert assess(asm).outcome is Outcome.STABLE
