"""The independent check of capacity curves and settlements to collapse notices every number that is wrong."""

import pytest

from blockstat import Assembly, box, capacity, settle_to_collapse
from damage import assert_noticed
from evidence.opinion import curves
from evidence.scenes.small import arch

#: What is left alone: the limit load at rest, which has a check of its own, and seconds.
APART = ("limit", "first", "timings")


def rocking():
    blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="block")]
    return Assembly.from_blocks(blocks, supports=["ground"], density=100.0)


@pytest.mark.parametrize("control", ["block", "mean", ("block", (0.5, 0, 2)), None])
def test_a_block_that_rocks(control):
    found = capacity(rocking(), (1, 0, 0), control=control, steps=2)
    assert_noticed(
        found, lambda one: curves.check_capacity(one, (1, 0, 0), control=control, every=4), 0.05, but=APART, places=2
    )


def test_a_block_that_rocks_under_forces_at_points():
    push, weight = [("block", (0.0, 0.3, 1.5), (1.0, 0.2, 0.1))], [("block", (0.3, 0.4, 2.0), (0, 0, -300.0))]
    found = capacity(rocking(), push, loads=weight, steps=2)
    assert_noticed(
        found, lambda one: curves.check_capacity(one, push, loads=weight, every=4), 0.05, but=APART, places=2
    )
    with pytest.raises(AssertionError):
        curves.check_capacity(found, push)


@pytest.mark.parametrize("flow", ["coulomb", "associated"])
def test_an_arch_that_hinges(flow):
    asm = arch(5, 0.2, friction=2.0)
    found = capacity(asm, (1, 0, 0), control="mean", steps=2, flow=flow, tolerance=1e-2)
    # With associated flow blocks may slide too, and joints are open that only slide: they are not named.
    but = APART if flow == "coulomb" else (*APART, "opened")
    options = {"control": "mean", "flow": flow, "every": 4}
    assert_noticed(found, lambda one: curves.check_capacity(one, (1, 0, 0), **options), 0.05, but=but, places=2)


@pytest.mark.parametrize("direction", [(1, 0, 0), (0.5, 0, -1)])
def test_an_arch_on_a_support_that_moves(direction):
    found = settle_to_collapse(arch(6, 0.3), {"right": direction}, steps=4, displacement=0.1)
    assert len(found.poses) > 3
    assert_noticed(found, curves.check_path, 0.05, but=APART, places=3)


def test_the_energy_of_a_load_counts():
    found = settle_to_collapse(arch(6, 0.3), {"right": (1, 0, 0)}, loads=[("voussoir3", (0.0, 0.1, 1.1), (0, 0, -0.1))])
    curves.check_path(found, loads=[("voussoir3", (0.0, 0.1, 1.1), (0, 0, -0.1))])
    with pytest.raises(AssertionError):
        curves.check_path(found)
