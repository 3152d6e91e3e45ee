"""What a solver says about a limit load is believed only as far as it can be checked."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Imperfections,
    LoadOutcome,
    box,
    limit_load,
    limit_load_by_direction,
    linear_check,
)
from blockstat.analysis import coulomb
from blockstat.analysis import limit_load as module
from blockstat.certificate.bracket import without_rounding
from blockstat.solve.answer import Status
from evidence.hard import ties
from evidence.scenes.small import stack

GROUND = box((-2, -2, -1), (3, 5, 0), name="ground")
#: A block whose centroid is above the edge of the one below, and one that nothing keeps from sliding.
LEANING = [GROUND, box((0, 0, 0), (0.5, 3, 1), name="low"), box((0.25, 0, 1), (0.75, 3, 2), name="high")]
SMOOTH = [GROUND, box((0, 0, 0), (0.5, 3, 1), name="low")]


@pytest.mark.parametrize("flow", ["associated", "coulomb"])
@pytest.mark.parametrize(("blocks", "friction"), [(LEANING, 0.7), (SMOOTH, 0.0)], ids=["leaning", "smooth"])
def test_a_limit_of_nothing_is_zero_wherever_it_is_told(blocks, friction, flow):
    assembly = Assembly.from_blocks(blocks, supports=["ground"], friction=friction)
    found = limit_load(assembly, (1, 0, 0), flow=flow)
    assert (found.outcome, found.lower, found.upper, found.gap) == (LoadOutcome.LIMIT, 0.0, 0.0, 0.0)
    assert "\n0 <= multiplier <= 0\n" in found.explain()
    told = found.summary()
    assert (told["lower"], told["upper"]) == (0.0, 0.0)
    if flow == "coulomb":
        assert (told["coulomb_lower"], told["coulomb_upper"], told["coulomb_least"]) == (0.0, 0.0, 0.0)
    check = linear_check(found, (1, 0, 0))
    assert (check.alpha0, check.acceleration, check.ag_life) == (0.0, 0.0, 0.0)
    assert "alpha0 = 0, " in check.explain()


def test_the_least_limit_of_all_directions_is_zero_where_one_is():
    found = limit_load_by_direction(Assembly.from_blocks(LEANING, supports=["ground"]), 4)
    assert "Least: 0 towards +x." in found.explain()
    assert found.horizon == (0.0, 0.0)
    # Both blocks together turn about x = 0: their centroid is at x = 0.375, z = 1.
    assert found.upper[found.names.index("-x")] == pytest.approx(0.375, rel=1e-6)
    smooth = limit_load_by_direction(Assembly.from_blocks(SMOOTH, supports=["ground"], friction=0.0), 4)
    assert (smooth.horizon, smooth.upper.tolist()) == ((0.0, 0.0), [0.0] * 4)


def test_what_is_little_for_a_building_is_not_nothing_for_a_stone():
    dead = np.array([*[0, 0, -1e12, 0, 0, 0], *[0, 0, -1, 0, 0, 0]], dtype=float)
    load = np.array([*[0] * 6, *[0.5, 0, 0, 0, 0, 0]])
    assert without_rounding(load, dead, 0.5, 1e-8, 1e-9, -1e-9, -np.inf) == [0.5, 1e-8, 0.0, 0.0, -np.inf]


@pytest.mark.parametrize("cheap", [True, False], ids=["narrowed by verdicts", "undecided"])
def test_a_limit_that_a_solver_misses_is_not_taken_for_none(monkeypatch, cheap):
    # Two cubes tip at half their weight; a solver that calls that unbounded has no ray to show for it.
    honest = module.solve

    def mistaken(conic, **options):
        return replace(honest(conic, **options), status=Status.PRIMAL_INFEASIBLE)

    monkeypatch.setattr(module, "solve", mistaken)
    if not cheap:
        monkeypatch.setattr(module, "CHEAP", 0)
    found = limit_load(stack(2), (1, 0, 0), optimum=True)
    assert found.outcome is not LoadOutcome.UNBOUNDED
    assert found.lower <= 0.5 <= found.upper
    if cheap:
        assert (found.lower, found.upper) == pytest.approx((0.5, 0.5), rel=2e-3)


def test_a_multiplier_says_that_its_friction_dilates_and_which_blocks_move():
    found = limit_load(stack(2), (1, 0, 0))
    assert [found.assembly.names[i] for i in found.moving] == found.summary()["moving"] == ["stone1", "stone0"]
    assert "First to move: stone1, stone0." in found.explain()
    assert 'flow="coulomb"' in found.explain()
    assert 'flow="coulomb"' not in limit_load(stack(2), (1, 0, 0), flow="coulomb").explain()


def test_the_bracket_without_dilatancy_is_told_and_kept_when_it_is_stopped():
    """A cube slides at the coefficient of friction."""
    told = []
    whole = limit_load(stack(1), (1, 0, 0), flow="coulomb", friction=0.3, progress=lambda *step: told.append(step))
    assert [trial for trial, _, _ in told].count(0) == len(whole.coulomb_kinds) == 3
    assert told[-1][1:] == whole.coulomb_kinds[-1]

    def stop(trial, low, high):
        if trial == 1:
            raise KeyboardInterrupt

    found = limit_load(stack(1), (1, 0, 0), flow="coulomb", friction=0.3, progress=stop)
    assert found.outcome is LoadOutcome.STOPPED
    assert (found.lower, found.upper) == (whole.lower, whole.upper)
    assert found.coulomb_kinds == (told[1][1:],)
    assert "stopped before every kind of joints" in found.explain()


def interrupted(*_, **__):
    raise KeyboardInterrupt


def test_an_interrupt_is_kept_only_for_who_watches(monkeypatch):
    """Ctrl-C before the first iterate: nothing is proven but the dead load. Of further worst cases nothing is known."""
    solver, push = {"solver": "interior-point"}, (1, 0, 0)
    monkeypatch.setattr(module, "interior_point", SimpleNamespace(solve=interrupted))
    found = limit_load(stack(2), push, progress=lambda *_: None, **solver)
    assert (found.outcome, found.lower, found.upper) == (LoadOutcome.STOPPED, 0.0, float("inf"))
    with pytest.raises(KeyboardInterrupt):
        limit_load(stack(2), push, **solver)
    with pytest.raises(KeyboardInterrupt):
        limit_load(stack(2), push, progress=lambda *_: None, imperfections=Imperfections(edge=0.01), **solver)
    monkeypatch.undo()
    monkeypatch.setattr(coulomb, "coulomb_state", interrupted)
    with pytest.raises(KeyboardInterrupt):
        limit_load(stack(1), push, flow="coulomb", friction=0.3)


def test_a_bracket_that_only_rounding_narrows_ends():
    """Beside a block 1e8 times as heavy the bounds of mechanisms waver by their last digit; it went on without end."""
    pushed = limit_load(ties.pair(1e8, 1.0), (1, 0, 0), loads=1.25 * (1 - 1e-5) * ties.LIGHT)
    assert pushed.outcome is LoadOutcome.UNDECIDED
    assert 0.0 <= pushed.lower <= pushed.upper < float("inf")


@pytest.mark.parametrize(("open_by", "words"), [(0.004, "1 of 1 joints do not quite close"), (0.02, "not taken")])
def test_a_limit_that_hangs_on_the_joint_tolerance_says_so(open_by, words):
    # A cube of 1 m above the ground: up to .01 m a joint, beyond it none.
    blocks = [box((-2, -2, -1), (3, 3, 0)), box((0, 0, open_by), (1, 1, 1 + open_by))]
    found = limit_load(Assembly.from_blocks(blocks, supports=[0]), (1, 0, 0))
    assert [words in text for text in found.warnings].count(True) == 1
