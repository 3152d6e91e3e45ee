"""Odd but legal questions: strengths under tilt, jammed supports, loads of any size."""

import numpy as np
import pytest

from blockstat import (
    InputError,
    JointLaw,
    LoadOutcome,
    Outcome,
    assess,
    friction_limit,
    limit_load,
    load_domain,
    settlement,
    tilt_limit,
)  # fmt: skip
from blockstat.view.utilisation import plot_utilisation
from evidence.scenes.small import arch, flat_arch, stack

EVERY = ("*", "*")


def bonded(asm, **strengths):
    return asm.with_(joints=[JointLaw(EVERY, **strengths)])


def test_tilt_of_a_block_that_its_joint_holds():
    # Area 1, weight 1, tension .5 and so cohesion .7 x .5: it slides at sin = .7 (cos + .5).
    found = tilt_limit(bonded(stack(1), tension=0.5), "x")
    angle = np.radians(found.stands)
    assert np.sin(angle) == pytest.approx(0.7 * (np.cos(angle) + 0.5), abs=1e-6)
    assert found.falls - found.stands < 1e-5
    strong = tilt_limit(bonded(stack(1), tension=100.0), "x")
    assert strong.stands == 180.0
    assert np.isnan(strong.falls)


def test_supports_that_cannot_move():
    # A stone between two fixed ones, squeezed.
    with pytest.raises(InputError, match="jammed between them"):
        settlement(flat_arch(1, span=1.0), [0], [1, 0, 0])
    with pytest.raises(InputError, match="supports: no blocks are given"):
        settlement(arch(10, 0.2), [], [1, 0, 0])
    with pytest.raises(InputError, match="three numbers"):
        settlement(arch(10, 0.2), ["left"], [1, 0])


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1.0, 1e200, 1e308])
def test_the_size_of_a_direction_does_not_matter(size):
    assert limit_load(stack(2), (size, 0, 0)).lower == pytest.approx(0.5, rel=1e-6)
    assert tilt_limit(stack(2), (0, size, 0)).stands == pytest.approx(np.degrees(np.arctan(0.5)), rel=1e-6)


def test_cohesion_with_next_to_no_friction():
    slippery = bonded(stack(1), cohesion=0.2)
    with pytest.raises(InputError, match=r"cohesion needs a friction of at least 0\.001"):
        limit_load(slippery, (1, 0, 0), friction=1e-6)
    assert limit_load(slippery, (1, 0, 0), friction=1e-3).lower == pytest.approx(0.201, rel=1e-6)
    # .3 = mu + .1
    found = friction_limit(bonded(stack(1), cohesion=0.1), gravity=(0.3, 0, -1))
    assert found.stands == pytest.approx(0.2, abs=1e-5)


def test_domains_need_two_loads():
    with pytest.raises(InputError, match="span no domain"):
        load_domain(stack(2), (1, 0, 0), (-2, 0, 0))
    with pytest.raises(InputError, match="at least 3"):
        load_domain(stack(2), (1, 0, 0), (0, 1, 0), directions=0)


def test_a_load_that_is_not_carried_at_all_has_a_limit_of_nothing():
    for solver in ("interior-point", "clarabel"):
        found = limit_load(stack(1), (1, 0, 0), friction=0.0, solver=solver)
        assert found.outcome is LoadOutcome.LIMIT
        assert found.lower == pytest.approx(0.0, abs=1e-9)


def test_pictures_of_cells(tmp_path):
    for cells in (1, 2, 3):
        verdict = assess(bonded(stack(2), cells=cells))
        assert verdict.outcome is Outcome.STABLE
        assert plot_utilisation(verdict, tmp_path / f"{cells}.png").is_file()


@pytest.mark.parametrize("bad", [
    {"friction": "x"}, {"tension": None}, {"tension": "x"}, {"bond": None}, {"cells": True}, {"cohesion": True},
])  # fmt: skip
def test_laws_of_no_number(bad):
    with pytest.raises(InputError, match="joint law between a and b"):
        JointLaw(("a", "b"), **bad)


@pytest.mark.parametrize("between", [None, "ab", ("a",), (1, 2)])
def test_laws_between_nothing(between):
    with pytest.raises(InputError, match="it must be two group names"):
        JointLaw(between)
