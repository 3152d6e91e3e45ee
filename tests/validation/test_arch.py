"""A semicircular arch of straight-sided voussoirs next to its limits.

Least thickness over centreline radius, D: .107011, .107348, .106721 for 10, 20, 27 voussoirs (references/arches.py).
Sliding: below mu = .309 no thickness stands (Gilbert, Casapulla & Ahmed, Computers & Structures 84, 2006).
"""

import pytest

from blockstat import Outcome, assess
from evidence.references.row import between, stands
from evidence.scenes.small import arch


def test_no_thickness_works_below_a_friction():
    assert all(assess(arch(27, t), friction=0.308).outcome is Outcome.UNSTABLE for t in (0.15, 0.2, 0.3, 0.5))


@pytest.mark.parametrize("n", [10, 20, 27])
@pytest.mark.parametrize("margin", [1e-3, 1e-5, 1e-7])
def test_verdicts_next_to_the_limit_are_right(n, margin):
    # The limit is the gap between certified verdicts; it is narrow enough for all margins, and where it should be.
    exact = {10: 0.107011, 20: 0.107348, 27: 0.106721}[n]
    limit = between(exact + 1e-5, exact - 1e-5, lambda t: stands(arch(n, t), friction=2.0), 1e-10)
    assert limit.ours == pytest.approx(exact, abs=1e-6)
    assert limit.bracket < 2e-8 * exact
    thick = stands(arch(n, limit.ours * (1 + margin)), friction=2.0)
    thin = stands(arch(n, limit.ours * (1 - margin)), friction=2.0)
    if margin >= 1e-5:
        assert (thick, thin) == (Outcome.STABLE, Outcome.UNSTABLE)
    assert thick is not Outcome.UNSTABLE
    assert thin is not Outcome.STABLE
