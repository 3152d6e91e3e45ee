"""Ties, tendons and anchor plates: what they gain where a hand calculation is short, and what is refused."""

import re
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from blockstat import (
    InputError,
    LoadOutcome,
    Tie,
    TieOutcome,
    anchor_plate,
    assess,
    limit_load,
    point_load,
    tendon_load,
    tie_gain,
    tie_range,
)
from blockstat.analysis import thrust
from blockstat.solve.answer import Status
from evidence.scenes.small import assembly, box, stack

ENDS = ((-1, 0.5, 0), (0, 0.5, 1))


def overhang(**tie):
    """A block 3 m long of which 2 m lean out over its foot, and a tie that holds it back."""
    blocks = [box((-2, -1, -1), (1, 1, 0), name="ground"), box((0, 0, 0), (3, 1, 1), name="block")]
    return assembly(blocks, ties=[Tie(("ground", "block"), ENDS, **tie)])


@pytest.mark.parametrize("number", [-1, 1])
def test_the_range_of_a_tie_that_does_not_exist_is_refused(number):
    says = f"tie is {number}; the assembly has 1 tie, numbered from 0"
    with pytest.raises(InputError, match=says):
        tie_range(overhang(), number)


def test_a_tie_whose_force_is_given_has_no_range():
    with pytest.raises(InputError, match='tie "bar": its force is given; there is no range to find'):
        tie_range(overhang(least=5.0, greatest=5.0, name="bar"))


@pytest.mark.parametrize(("part", "outcome"), [(0.9, "unstable"), (1.0, "stable"), (1.1, "unstable")])
def test_a_block_that_only_a_given_force_holds_hangs_where_the_force_is_its_weight(part, outcome):
    ceiling, bell = box((0, 0, 3), (1, 1, 4), name="ceiling"), box((0, 0, 0), (1, 1, 1), name="bell")
    force = part * 1000.0
    rod = Tie(("ceiling", "bell"), ((0.5, 0.5, 3), (0.5, 0.5, 1)), least=force, greatest=force)
    asm = replace(assembly([ceiling, bell], supports=["ceiling"], ties=[rod]), density=np.full(2, 1000.0))
    assert assess(asm).outcome.name.lower() == outcome
    assert limit_load(asm, (1, 0, 0)).outcome is (
        LoadOutcome.LIMIT if outcome == "stable" else LoadOutcome.DEAD_LOAD_UNSTABLE
    )


def test_a_tie_between_supports_has_no_range():
    ceiling, ground = box((0, 0, 2), (1, 1, 3), name="ceiling"), box((-1, -1, -1), (2, 2, 0), name="ground")
    tie = Tie(("ceiling", "ground"), ((0, 0, 2), (0, 0, 0)), name="rod")
    asm = assembly([ceiling, ground, box((0, 0, 0), (1, 1, 1))], supports=["ceiling", "ground"], ties=[tie])
    with pytest.raises(InputError, match='tie "rod": both its blocks are supports; it holds nothing, with any force'):
        tie_range(asm)


@pytest.mark.parametrize(
    ("options", "least", "greatest"),
    [
        ({}, 0.5 / 2**0.5, 1.5 * 2**0.5),
        ({"friction": 0.3}, 0.5 / 2**0.5, 0.3 / 0.7 * 2**0.5),
        ({"gravity": (0, 0, -2)}, 1.0 / 2**0.5, 3.0 * 2**0.5),
        ({"loads": 1.0}, 2.5 / 2**0.5, 4.5 * 2**0.5),
    ],
    ids=["plain", "friction", "gravity", "loads"],
)
def test_a_tie_that_leans_by_half_a_right_angle_pulls_between_what_tips_and_what_slides(options, least, greatest):
    """About the toe at x = 1 the tie has an arm of 2^.5 and W one of .5; about the heel 1 / 2^.5 and 1.5.

    It slides where T / 2^.5 is the friction of W + T / 2^.5. A load of W at the far end has arms of 2 and 3.
    """
    asm = overhang()
    weight = asm.free_weight
    if "loads" in options:
        options = {"loads": point_load(asm, "block", (3, 0.5, 1), (0, 0, -options["loads"] * weight))}
    found = tie_range(asm, **options)
    assert (found.least, found.greatest) == pytest.approx((least * weight, greatest * weight), rel=1e-6)


def pressed_down(**tie):
    """A block that a tie presses on the ground."""
    blocks = [box((-2, -1, -1), (3, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="block")]
    return assembly(blocks, ties=[Tie(("ground", "block"), ((0.5, 0.5, -1), (0.5, 0.5, 1)), **tie)])


def test_a_range_without_a_greatest_force_is_told_where_a_ray_of_forces_shows_it(monkeypatch):
    plain = thrust.solve
    found = tie_range(pressed_down())
    assert (found.outcome, found.least, found.greatest) == (TieOutcome.NO_GREATEST, 0.0, inf)
    given = tie_range(pressed_down(least=2.0, greatest=5.0))
    assert given.outcome is TieOutcome.RANGE
    assert (given.least, given.greatest) == pytest.approx((2.0, 5.0), rel=1e-6)
    assert tie_range(overhang()).outcome is TieOutcome.RANGE
    assert tie_range(overhang()).summary()["proven"]

    for status in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE, Status.STALLED):
        monkeypatch.setattr(thrust, "solve", lambda *given, _s=status, **how: replace(plain(*given, **how), status=_s))
        found = tie_range(overhang())
        assert found.outcome is TieOutcome.UNDECIDED
        assert 0 < found.least <= found.greatest < inf  # a force with which it was found to stand
        assert found.explain().startswith("Undecided: the assembly stands with every force between those told")


def test_a_range_is_one_sided_where_blocks_meet_at_edges_alone():
    # A stop along the lower edge of the far end may carry it, and then the tie need not.
    stop = box((3, 0, -1), (4, 1, 0), name="stop")
    blocks = [box((-2, -1, -1), (1, 1, 0), name="ground"), box((0, 0, 0), (3, 1, 1), name="block"), stop]
    asm = assembly(blocks, supports=["ground", "stop"], ties=[Tie(("ground", "block"), ENDS)])
    found, free = tie_range(asm), tie_range(overhang())
    assert found.outcome is TieOutcome.UNDECIDED
    assert found.least == pytest.approx(free.least, rel=1e-6)
    (text,) = found.warnings
    assert text.startswith('"block" and "stop" touch only edge along edge')
    assert found.explain().splitlines()[-1] == f"Warning: {text}"
    assert found.summary()["warnings"] == [text]


def test_a_tie_gains_nothing_where_no_load_has_a_limit():
    block = stack(1)
    limit = limit_load(block, (0, 0, -1))
    with pytest.raises(InputError, match="no limit load to differentiate: Unbounded"):
        tie_gain(limit, (0, 0, -1), [Tie(("ground", "stone0"), ENDS)])


@pytest.mark.parametrize("far", [-3, 4])
def test_a_tie_gains_what_the_moment_about_the_toe_says_and_loses_nothing_while_it_may_be_slack(far):
    """A pillar of width b and height h that tips under W lambda carries b / h, and 2 z / (W h) more for each newton."""
    blocks = [box((-4, -1, -1), (5, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="pillar")]
    pillar = assembly(blocks, density=1000.0, gravity=(0, 0, -10))
    limit = limit_load(pillar, (1, 0, 0), optimum=True)
    ends, weight, force = ((far, 0.5, 1.5), (0.25, 0.5, 1.5)), 10e3, 500.0
    slack, tight = (Tie(("ground", "pillar"), ends, least=least) for least in (0.0, force))
    slope = -np.sign(far) * 2 * 1.5 / (weight * 2)
    assert tie_gain(limit, (1, 0, 0), [slack, tight]) == pytest.approx([max(slope, 0.0), slope], abs=1e-9)
    assert tie_gain(limit, (1, 0, 0), [slack], force=force) == pytest.approx([max(slope, 0.0)], abs=1e-9)
    given = pillar.with_(ties=[Tie(("ground", "pillar"), ends, least=force, greatest=force)])
    assert limit_load(given, (1, 0, 0)).lower - limit.lower == pytest.approx(force * slope, rel=1e-6)


def pillar():
    """It tips at b / (2 z) = .25 times its weight of 10 kN."""
    return assembly(
        [box((-4, -1, -1), (5, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="pillar")],
        density=1000.0,
        gravity=(0, 0, -10),
    )


@pytest.mark.parametrize("force", [None, 100.0])
def test_a_tie_gains_at_the_load_of_the_limit_alone(force):
    """A dead load N on top of W raises the limit to (1 + N / W) b / h; a tie at z adds 2 z / (W h) for each newton."""
    block, tie, dead = pillar(), Tie(("ground", "pillar"), ((-3, 0.5, 1.5), (0.0, 0.5, 1.5))), np.zeros((2, 6))
    dead[1, 2] = -5e3
    limit = limit_load(block, (1, 0, 0), loads=dead, optimum=True)
    assert limit.lower == pytest.approx(1.5 * 0.25, rel=1e-6)
    gain = tie_gain(limit, (1, 0, 0), [tie], force=force, loads=dead)
    assert gain == pytest.approx([2 * 1.5 / (10e3 * 2)], rel=1e-5)
    for load, loads in (((1, 0, 0), None), ((0, 1, 0), dead), ((0, 0, -1), dead)):
        with pytest.raises(InputError, match="the limit is not that of this load"):
            tie_gain(limit, load, [tie], force=force, loads=loads)


@pytest.mark.parametrize("force", [None, 100.0])
def test_a_tie_that_gains_is_on_its_block(force):
    beside = Tie(("ground", "pillar"), ((-3, 0.5, 20), (0, 0.5, 20)), name="high")
    with pytest.raises(InputError, match=r'tie "high": the point \[0.0, 0.5, 20.0\] is not on block "pillar"'):
        tie_gain(limit_load(pillar(), (1, 0, 0)), (1, 0, 0), [beside], force=force)


@pytest.mark.parametrize("force", ["1", None, np.nan, np.inf, 0.0, -1.0])
def test_a_force_is_a_number_above_0(force):
    block, tie = pillar(), Tie(("ground", "pillar"), ((-3, 0.5, 1.5), (0.0, 0.5, 1.5)))
    if force is not None:
        with pytest.raises(InputError, match=r"^force is .*; it must be above 0"):
            tie_gain(limit_load(block, (1, 0, 0)), (1, 0, 0), [tie], force=force)
    with pytest.raises(InputError, match=r"^tendon: force is .*; it must be above 0"):
        tendon_load(block, ["ground", "pillar"], [(0, 0, 0), (0, 0, 2)], force)


def row():
    return assembly([box((-2, 0, 0), (-1, 1, 1), name="rock"), *(box((k, 0, 0), (k + 1, 1, 1)) for k in range(3))])


@pytest.mark.parametrize(
    ("blocks", "points", "force", "says"),
    [
        ([1], [(0, 0.5, 0.5)], 1.0, "a list of points of three finite numbers is needed, 2 at least"),
        ([1, 2], [(0, 0.5, 0.5)], 1.0, "a list of points"),
        ([1, 2], [(0, 0.5), (2, 0.5)], 1.0, "a list of points"),
        ([1, 2], [(0, 0.5, 0.5), (2, 0.5)], 1.0, "a list of points"),
        ([1, 2], (0.0, 1.0, 2.0), 1.0, "a list of points"),
        ([1, 2], [(0, 0.5, nan), (2, 0.5, 0.5)], 1.0, "a list of points"),
        ([1, 2, 3], [(0, 0.5, 0.5), (2, 0.5, 0.5)], 1.0, "it has 2 points on 3 blocks; one point a block is needed"),
        ([1, 2], [(0, 0.5, 0.5), (2, 0.5, 0.5)], 0.0, "force is 0.0; it must be above 0"),
        ([1, 2], [(0, 0.5, 0.5), (2, 0.5, 0.5)], -3.0, "force is -3.0; it must be above 0"),
        ([1, 2], [(0, 0.5, 0.5), (2, 0.5, 0.5)], inf, "force is inf; it must be above 0"),
        ([1, 2, 3], [(0, 0.5, 0.5), (1, 0.5, 1), (1, 0.5, 1)], 1.0, "two of its points that follow each other are the"),
        ([1, 2], [(0, 0.5, 0.5), (2.1, 0.5, 0.5)], 1.0, 'the point [2.1, 0.5, 0.5] is not on block "1"'),
    ],
)
def test_a_tendon_runs_from_block_to_block_with_a_force(blocks, points, force, says):
    named = says.replace('"1"', f'"{row().names[2]}"')
    with pytest.raises(InputError, match=re.escape(f"tendon: {named}")):
        tendon_load(row(), blocks, points, force)


def test_a_tendon_may_be_anchored_in_the_ground_beside_a_support():
    """Supports stand for rock that is not drawn; the pull is 5 in the direction (4, 3) over 5."""
    load = tendon_load(row(), ["rock", 1], [(-3.5, 0.5, -2.5), (0.5, 0.5, 0.5)], 5.0)
    np.testing.assert_allclose(load[0, :3], [4, 0, 3])
    np.testing.assert_allclose(load[1], [-4, 0, -3, 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    "bad",
    [
        {"sides": (0.4,)},
        {"sides": (0.4, 0.0)},
        {"sides": (-0.4, 0.6)},
        {"sides": (0.4, 0.6, 0.1)},
        {"sides": (0.4, "a")},
        {"sides": 0.4},
        {"sides": (0.4, inf)},
        {"thickness": 0.0},
        {"thickness": nan},
        {"thickness": "a"},
        {"outward": (0, 0, 0)},
    ],
)
def test_a_plate_has_an_extent_and_a_direction(bad):
    with pytest.raises(InputError, match=r"^plate: (sides are .*two numbers|thickness is .*it must be) above 0"):
        anchor_plate((0, 0, 2), **{"outward": (-1, 0, 0), "sides": (0.4, 0.6)} | bad)


@pytest.mark.parametrize("slab", [(20, 1), (200, 1), (500, 20)])
def test_the_least_force_of_a_tie_does_not_depend_on_what_the_ground_weighs(slab):
    """A pot of .05 x .05 x .1 m on a cube of 2 m, pushed at its top by .75 W, tips over its edge x = 0 but for a tie.

    About the edge the push turns by .75 W .1 and the weight back by W .025; a tie from its top to (1, .025, 2), in the
    direction d, holds with d_x .1 + d_z .025 a newton: 2.404 N, whether the slab below weighs 31 MN or 392 GN.
    """
    side, depth = slab
    ground = box((-side, -side, -depth), (side, side, 0), name="ground")
    blocks = [ground, box((0, 0, 0), (2, 2, 2), name="cube"), box((0, 0, 2), (0.05, 0.05, 2.1), name="pot")]
    tie = Tie(("cube", "pot"), ((1, 0.025, 2), (0.025, 0.025, 2.1)))
    tied = assembly(blocks, density=2000.0, friction=0.7, ties=[tie], gravity=(0, 0, -9.81))
    weight = 0.05 * 0.05 * 0.1 * 2000 * 9.81
    found = tie_range(tied, loads=point_load(tied, "pot", (0, 0.025, 2.1), (-0.75 * weight, 0, 0)))
    away, down = np.array([0.975, 0.1]) / np.hypot(0.975, 0.1)
    needed = weight * (0.75 * 0.1 - 0.025) / (away * 0.1 + down * 0.025)
    assert needed == pytest.approx(2.404, abs=1e-3)
    assert found.least == pytest.approx(needed, rel=1e-5)
