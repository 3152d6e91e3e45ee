"""Blocks that fall freely from joints that nothing has pressed: which they are, and what forbids the proof."""

import numpy as np
import pytest

from blockstat import Assembly, BracketOutcome, Tie, acceleration, assess, box, friction_limit, glued, limit_load
from blockstat.analysis.verdict import Outcome
from evidence.pages.elements import ELEMENTS
from evidence.scenes.small import pinched, prism


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


def under_an_arm(**options) -> Assembly:
    """A block with nothing beneath it between fixed stones, and a stone on a fixed bed whose arm lies on its top.

    The arm's stone has its centre at (1/2 + 1/2 + 3/2) / 3 = 5/6 of its bed of width 1, and so stands by itself. Free
    of forces the block falls away from the arm, and slides along all other stones.
    """
    arm = prism([(0, 1), (1, 1), (1, 2), (2, 2), (2, 3), (0, 3)], 1.0, name="arm")
    blocks = [
        box((0, 0, 0), (1, 1, 1), name="bed"), box((2, 0, 0), (3, 1, 2), name="right"),
        box((1, 0, 0), (2, 1, 2), name="hung"), arm,
    ]  # fmt: skip
    return Assembly.from_blocks(blocks, supports=["bed", "right"], density=2000.0, **{"friction": 1.2, **options})


def test_what_falls_freely_below_an_arm_is_not_stable_at_any_friction():
    # A state in joints of one kind alone holds it by a wedge between the bed, the arm's stone and the right one.
    asm = under_an_arm()
    for mu in (0.7, 1.2, 2.0, 5.0, 7.5, 10.0):
        assert falling(asm, friction=mu) == ["hung"]
    verdict = assess(asm, flow="coulomb")
    assert "but blocks fall freely from joints that nothing has pressed" in verdict.headline
    assert "so none resists: hung." in verdict.explain()
    alone = asm.with_(support=[True, True, True, False])
    assert assess(alone, flow="coulomb").outcome is Outcome.STABLE


def test_a_limit_of_what_falls_freely_is_none():
    asm = under_an_arm()
    assert assess(asm).outcome is Outcome.STABLE
    none = friction_limit(asm, flow="coulomb")
    assert none.outcome is BracketOutcome.NOT_FOUND
    assert np.isnan([none.stands, none.falls, *np.ravel(none.kinds)]).all()
    found = limit_load(asm, acceleration(asm, (1, 0, 0)), flow="coulomb")
    assert found.coulomb == found.coulomb_least == (0.0, 0.0)


def test_a_load_or_a_tie_elsewhere_does_not_hide_a_fall():
    asm = under_an_arm()
    load = np.zeros((4, 6))
    load[3, 2] = -100.0
    assert falling(asm, loads=load) == ["hung"]
    load[2, 2] = -100.0
    assert falling(asm, loads=load) == []
    beside = [box((9, 0, 0), (10, 1, 1), name="fixed floor"), box((9, 0, 1), (10, 1, 2), name="post")]
    more = clamped(*beside)
    tied = more.with_(ties=[Tie(("fixed floor", "post"), ((9.5, 0.5, 0), (9.5, 0.5, 2)), 0.0, 9.0)])
    assert falling(tied) == ["row.0"]


def test_a_part_falls_where_another_is_what_the_others_lean_on():
    # Two heavy blocks on slopes of 45 degrees lean on a light one, as in the tests of the reserve; another light block
    # is clamped between upright stones beside them. Only the second falls while the others rest.
    beside = [box((x, 0, 5), (x + 1, 1, 6), name=name) for x, name in ((3, "west"), (4, "clamped"), (5, "east"))]
    blocks = [*pinched(), *beside]
    supports = ["left", "right", "west", "east"]
    assert falling(Assembly.from_blocks(blocks, supports=supports, density=2000.0, friction=0.5)) == ["clamped"]
