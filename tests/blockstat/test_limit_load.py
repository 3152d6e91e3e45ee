"""What a solver says about a limit load is believed only as far as it can be checked."""

from dataclasses import replace

import pytest

from blockstat import LoadOutcome, limit_load
from blockstat.analysis import limit_load as module
from blockstat.solve.answer import Status
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
