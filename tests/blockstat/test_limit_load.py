"""What a solver says about a limit load is believed only as far as it can be checked."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from blockstat import Assembly, Imperfections, LoadOutcome, box, limit_load
from blockstat.analysis import coulomb
from blockstat.analysis import limit_load as module
from blockstat.solve.answer import Status
from evidence.hard import ties
from evidence.scenes.small import stack


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
