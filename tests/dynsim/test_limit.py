"""Bullet's own limit multiplier."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import InputError, limit_load
from blockstat.loads import point_load
from dynsim import Settings, limit, verify
from dynsim.judge.limit import DynamicLimit, LimitOutcome, Trial, _Search, _warnings
from evidence.scenes.small import arch, assembly, box, running_bond, slab, stack


def test_an_interrupt_in_the_runs_beside_a_bracket_leaves_the_bracket():
    def stop(trial):
        if len(trials) == len(whole.trials) - 2:  # the two beside it
            raise KeyboardInterrupt
        trials.append(trial)

    trials: list[Trial] = []
    whole = limit(stack(2), (1, 0, 0), width=0.05)
    found = limit(stack(2), (1, 0, 0), width=0.05, progress=stop)
    assert found.outcome is LimitOutcome.STOPPED
    assert (found.lower, found.upper) == (whole.lower, whole.upper)
    assert len(found.trials) == len(whole.trials) - 1
    fell = replace(found, lower=-np.inf)
    assert f"Multiplier below {found.upper:.5g}; it has not stood at any so far." in fell.explain()
    assert (fell.summary()["lower"], fell.ratio) == (None, None)


def test_a_block_tips_and_slides_at_its_closed_forms():
    tips = limit(stack(1, 0.5, 2.0), (1, 0, 0))
    assert tips.outcome is LimitOutcome.LIMIT
    assert tips.lower <= 0.25 * 1.003
    assert tips.upper >= 0.25 * 0.997
    assert tips.upper - tips.lower <= 0.01 * tips.upper
    assert tips.warnings == ()
    slides = limit(slab(), (3, 4, 0), width=0.005)
    assert slides.lower <= slab().friction * 1.003
    assert slides.upper >= slab().friction * 0.997


def test_wrenches_tip_a_block():
    # A force at the top tips at W b / (2 h), a moment alone at W b / 2.
    asm = stack(1, 0.5, 2.0)
    weight = float(asm.mass[1])
    force = limit(asm, point_load(asm, 1, (0, 0.5, 2.0), (1, 0, 0)), check=False)
    assert force.lower / weight <= 0.125 * 1.005
    assert force.upper / weight >= 0.125 * 0.995
    moment = np.zeros((2, 6))
    moment[1, 4] = 1.0
    turn = limit(asm, moment, check=False)
    assert turn.lower / weight <= 0.25 * 1.005
    assert turn.upper / weight >= 0.25 * 0.995


def test_few_runs_from_the_static_limit():
    asm = running_bond(4, 3)
    found = limit(asm, (0, 1, 0))
    static = limit_load(asm, (0, 1, 0))
    assert found.static == (static.lower, static.upper)
    assert 0.97 < found.ratio < 1.01
    assert len(found.trials) <= 7
    assert found.summary()["runs"] == len(found.trials)
    assert "Bullet / static" in found.explain()
    assert str(found) == found.explain()
    assert "Bullet / static" in found._repr_html_()
    # The bracket is what the runs say.
    stood = [t.multiplier for t in found.trials if t.verdict == "stands"]
    moved = [t.multiplier for t in found.trials if t.verdict != "stands"]
    assert found.lower in stood
    assert found.upper in moved


@pytest.mark.parametrize("friction", [1e-6, 0.0])
def test_a_limit_of_less_than_runs_can_see_is_not_resolved(friction):
    # The block slides at its friction, and a run need not show an imbalance below a thousandth of the weight.
    found = limit(stack(1, friction=friction), (1, 0, 0), check=False, settings=Settings.named("fast"))
    assert found.outcome is LimitOutcome.LIMIT
    assert found.lower <= friction < found.upper <= 1e-3
    assert any("not resolved" in text for text in found.warnings)
    assert found.summary()["ratio"] is None


def test_a_load_is_unbounded_in_units_of_the_weight():
    # A load carried up to 0.3 of the weight, or without end, where statics say a millionth.
    asm = stack(1)
    moves, carried = 0.3, []

    class Prescribed(_Search):
        def stands(self, multiplier):
            carried.append(multiplier)
            return multiplier < moves

    search = Prescribed(asm, asm.gravity[[2, 0, 1]], (), None, None, 0.01, None, unbounded=False)
    outcome, lower, upper = search.bracket(2e-6)
    assert outcome is LimitOutcome.LIMIT
    assert lower < 0.3 <= upper <= 1.02 * lower
    moves = np.inf
    assert search.bracket(2e-6)[0] is LimitOutcome.UNBOUNDED
    assert 32 <= max(carried) <= 64


def test_a_static_limit_of_zero_has_no_ratio():
    found = DynamicLimit(LimitOutcome.LIMIT, 0.1, 0.11, (0.0, 0.0), (), 1.0, 0.01)
    assert found.summary()["ratio"] is None
    assert "Bullet / static" not in found.explain()


def test_a_limit_tells_what_its_verdicts_warn_of():
    # The cube is drawn 8 mm above the ground: a joint to statics, which is closed for Bullet.
    open_joint = assembly([box((-2, -2, -1), (3, 3, 0)), box((0, 0, 0.008), (1, 1, 1.008))])
    (text,) = verify(open_joint).warnings
    assert "1 joints that statics count as closed were open" in text
    assert limit(open_joint, (1, 0, 0), width=0.5, check=False).warnings.count(text) == 1


def test_loads_without_a_limit_and_assemblies_without_a_stand():
    assert limit(stack(2), (0, 0, -1)).outcome is LimitOutcome.UNBOUNDED
    thin = limit(arch(15, 0.09), (1, 0, 0))
    assert thin.outcome is LimitOutcome.DEAD_LOAD_FALLS
    assert len(thin.trials) == 1
    assert thin.summary()["lower"] is None


def test_a_load_that_statics_carry_without_bound_says_so():
    found = limit(stack(2), (0, 0, -1), check=False)
    assert found.outcome is LimitOutcome.UNBOUNDED
    assert found.summary()["upper"] is None
    assert "Statics carry the load without bound." in found.explain()
    assert "without bound" not in limit(stack(1), (1, 0, 0), width=0.5, check=False).explain()


def test_verdicts_that_change_more_than_once_are_told():
    trials = [Trial(m, v, 0.0, 1.0, 1.0) for m, v in ((0.5, "falls"), (0.9, "stands"), (1.0, "falls"), (1.1, "stands"))]
    below, above = _warnings(trials, 0.9, 1.0)
    assert "it moved at 0.5 too, below the bracket" in below
    assert "it stood at 1.1 too, above the bracket" in above
    assert "neither stood nor fell (creeps)" in _warnings([Trial(1.0, "creeps", 0.0, 1.0, 1.0)], 0.9, 1.0)[0]
    assert _warnings(trials[1:3], 0.9, 1.0) == ()


def test_where_statics_carry_without_bound_a_creep_is_told_as_carried():
    trials = [Trial(m, v, 0.0, 1.0, 1.0) for m, v in ((0.0, "stands"), (8.0, "creeps"), (16.0, "falls"))]
    (text,) = _warnings(trials, 8.0, 16.0, unbounded=True)
    assert text == (
        "some runs neither stood nor fell (creeps); they count as carried, as statics carry the load without bound"
    )
    above = _warnings([*trials, Trial(17.0, "creeps", 0.0, 1.0, 1.0)], 8.0, 16.0, unbounded=True)
    assert above[0] == "not one limit: it stood or crept at 17 too, above the bracket"
    below = _warnings([*trials, Trial(7.0, "falls", 0.0, 1.0, 1.0)], 8.0, 16.0, unbounded=True)
    assert below[0] == "not one limit: it moved at 7 too, below the bracket"


def test_bad_questions():
    with pytest.raises(InputError, match="width is 2"):
        limit(stack(1), (1, 0, 0), width=2)
    with pytest.raises(InputError, match="load direction"):
        limit(stack(1), (0, 0, 0))
