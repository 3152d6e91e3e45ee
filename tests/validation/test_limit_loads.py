"""What limit loads, thrusts and friction limits must be besides their values (those are in `evidence.references`).

Ferris & Tin-Loi, Int. J. Mech. Sci. 43 (2001): numbers of blocks and joints of the planar wall set.
Thrusts of a semicircle of 20 voussoirs, and thicknesses at which 27 slide: `evidence.references.arches`.
"""

import math

import numpy as np
import pytest

from blockstat import LoadOutcome, find_interfaces, friction_limit, limit_load, load_domain, settlement
from blockstat.analysis.problem import pose
from evidence.references.arches import SLIDING, THRUST
from evidence.references.walls import turned_wall
from evidence.scenes.small import FERRIS, arch, assembly, box, ferris_wall, running_bond, stack


@pytest.mark.parametrize("name", FERRIS)
def test_ferris_and_tin_loi_walls_have_the_published_joints(name):
    asm = ferris_wall(FERRIS[name][0])
    assert (asm.n_blocks - 1, find_interfaces(asm).n_interfaces) == FERRIS[name][1:3]


def test_a_wall_turned_in_plan_is_solved_in_space():
    # So that the row "exact cones in space" means what it says.
    given = {"friction": None, "gravity": None, "loads": None, "gap": 1e-2, "interfaces": None}
    assert pose(ferris_wall(FERRIS["W1"][0]), **given).program.plane is not None
    assert pose(turned_wall("W1")[0], **given).program.plane is None


@pytest.mark.parametrize("t", THRUST)
def test_moving_supports_of_a_semicircle(t):
    least, greatest = map(float, THRUST[t])
    asm = arch(20, t)
    weight = asm.mass[asm.free].sum()
    # A spreading support meets the least thrust, a closing one the greatest.
    assert settlement(asm, ["right"], (1, 0, 0)).reaction / weight == pytest.approx(least, abs=1e-6)
    assert -settlement(asm, ["right"], (-1, 0, 0)).reaction / weight == pytest.approx(greatest, abs=1e-6)


def test_least_friction():
    for mu in (0.36, 0.38):
        assert friction_limit(arch(27, float(SLIDING[mu]))).stands == pytest.approx(mu, abs=2e-6)
    assert friction_limit(stack(1), gravity=(0.3, 0, -1)).stands == pytest.approx(0.3, abs=2e-6)
    assert math.isnan(friction_limit(stack(1)).falls)
    assert math.isnan(friction_limit(arch(10, 0.05)).stands)


def test_results_that_are_no_number():
    assert limit_load(stack(3), (0, 0, -1)).outcome is LoadOutcome.UNBOUNDED
    assert limit_load(arch(20, 0.1), (1, 0, 0)).outcome is LoadOutcome.DEAD_LOAD_UNSTABLE
    floating = assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 3), (1, 1, 4))])
    assert limit_load(floating, (1, 0, 0)).outcome is LoadOutcome.DEAD_LOAD_UNSTABLE


@pytest.mark.parametrize("strength", [1e9, 1.0, 1e-6])
def test_a_load_however_weak_has_the_limit_of_a_strong_one(strength):
    # A block of 1 x 1 x 2 m pushed at half its height tips at half its weight; pressed down it never does.
    asm = stack(1, 1.0, 2.0)
    push = np.zeros((2, 6))
    push[asm.free, 0] = strength
    found = limit_load(asm, push)
    assert found.outcome is LoadOutcome.LIMIT
    weight = asm.mass[asm.free].sum() * np.linalg.norm(asm.gravity)
    assert found.lower * strength == pytest.approx(weight / 2, rel=1e-4)
    assert limit_load(asm, push[:, [1, 2, 0, 3, 4, 5]] * -1).outcome is LoadOutcome.UNBOUNDED


def test_the_joints_of_a_mechanism_are_named():
    four = limit_load(arch(20, 0.15), (1, 0, 0)).joints()
    assert (len(four["hinges"]), len(four["sliding"]), len(four["opening"])) == (4, 0, 0)
    slide = limit_load(stack(1, 2.0, 0.5), (1, 0, 0)).joints()
    assert slide == {"hinges": [], "sliding": [("ground", "stone0")], "opening": []}
    tip = limit_load(stack(2, 0.5, 1.0), (1, 0, 0)).joints()
    assert tip["hinges"] == [("ground", "stone0")]


def test_domain_of_two_horizontal_loads_on_a_block():
    # A square block under loads x and y tips at |x| or |y| = b/h; friction .7 cuts the corners of the square.
    found = load_domain(stack(1, 1.0, 2.0), (1, 0, 0), (0, 1, 0), directions=16)
    size = np.linalg.norm(found.inner, axis=1)
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    exact = np.minimum(0.7, 0.5 / np.maximum(np.abs(np.cos(angle)), np.abs(np.sin(angle))))
    np.testing.assert_allclose(size, exact, rtol=1e-7)
    for a, b, c in found.outer:
        assert (found.inner @ [a, b] <= c * (1 + 1e-7)).all()


def test_a_wall_in_two_directions_and_mirrored_is_the_same():
    wall = running_bond(6, 5)
    east, west = (limit_load(wall, (sign, 0, 0)) for sign in (1, -1))
    assert east.lower == pytest.approx(west.lower, rel=1e-8)
