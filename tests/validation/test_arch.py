"""Semicircular arch of straight-sided voussoirs under its own weight: least thickness over centreline radius.

Continuum .1075: Milankovitch (1907); Makris & Alexakis, Archive of Applied Mechanics 83 (2013).
By number of voussoirs, infinite friction: derived from first principles by two independent methods.
Sliding: Gilbert, Casapulla & Ahmed, Computers & Structures 84 (2006), 27 voussoirs.
"""

import math

import pytest

from blockstat import Outcome, assess
from problems import arch
from vaults import pointed_arch


def least_thickness(n, friction, low, high, accuracy):
    """Bisection on the verdict; an undecided one ends it."""
    while high - low > accuracy:
        middle = (low + high) / 2
        outcome = assess(arch(n, middle), friction=friction).outcome
        if outcome is Outcome.UNDECIDED:
            return middle
        low, high = (low, middle) if outcome is Outcome.STABLE else (middle, high)
    return (low + high) / 2


@pytest.mark.parametrize(("n", "exact"), [(4, 0.097361), (10, 0.107011), (20, 0.107348), (27, 0.106721)])
def test_least_thickness_by_number_of_voussoirs(n, exact):
    assert least_thickness(n, math.inf, 0.08, 0.13, 1e-6) == pytest.approx(exact, abs=2e-6)


@pytest.mark.parametrize(("mu", "exact"), [(0.39, 0.111630), (0.36, 0.140891), (0.32, 0.183845)])
def test_least_thickness_with_sliding(mu, exact):
    assert least_thickness(27, mu, 0.09, 0.25, 1e-6) == pytest.approx(exact, abs=2e-6)


def test_no_thickness_works_below_a_friction():
    assert all(assess(arch(27, t), friction=0.308).outcome is Outcome.UNSTABLE for t in (0.15, 0.2, 0.3, 0.5))


@pytest.mark.parametrize("n", [10, 20, 27])
@pytest.mark.parametrize("margin", [1e-3, 1e-5, 1e-7])
def test_verdicts_next_to_the_limit_are_right(n, margin):
    # The limit itself is found by our bisection to 1e-10; what is tested is that both sides are told apart.
    exact = {10: 0.107011, 20: 0.107348, 27: 0.106721}[n]
    limit = least_thickness(n, 2.0, exact - 1e-6, exact + 1e-6, 1e-11)
    assert limit == pytest.approx(exact, abs=1e-6)
    thick = assess(arch(n, limit * (1 + margin)), friction=2.0).outcome
    thin = assess(arch(n, limit * (1 - margin)), friction=2.0).outcome
    if margin >= 1e-5:
        assert (thick, thin) == (Outcome.STABLE, Outcome.UNSTABLE)
    assert thick is not Outcome.UNSTABLE
    assert thin is not Outcome.STABLE


@pytest.mark.parametrize(("t", "degrees"), [(0.20, 15.9418)])
def test_tilting_arch(t, degrees):
    # N = 20 straight-sided voussoirs, t/R = .20; Ochsendorf (2002) gives 15.84 for the continuum.
    def tilted(angle):
        a = math.radians(angle)
        return assess(arch(20, t), friction=math.inf, gravity=(math.sin(a), 0, -math.cos(a))).outcome

    assert tilted(degrees - 1e-3) is Outcome.STABLE
    assert tilted(degrees + 1e-3) is Outcome.UNSTABLE


@pytest.mark.parametrize(
    ("n", "e", "exact"),
    [(10, 0.1, 0.085991), (50, 0.1, 0.086797), (10, 0.2, 0.069925), (50, 0.2, 0.070727), (10, 0.5, 0.039687),
     (50, 0.5, 0.039970)],
)  # fmt: skip
def test_least_thickness_of_a_pointed_arch(n, e, exact):
    # Two arcs with centres at +-e on the springing, n voussoirs each half; derived from first principles.
    def outcome(t):
        return assess(pointed_arch(n, e, t), friction=2.0).outcome

    assert outcome(exact + 1e-6) is Outcome.STABLE
    assert outcome(exact - 1e-6) is Outcome.UNSTABLE
