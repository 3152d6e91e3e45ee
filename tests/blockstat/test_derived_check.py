"""The independent check of domains, settlements, thrusts, ties, trains and plans notices every number that is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import (
    Assembly,
    JointLaw,
    Tie,
    assess_plan,
    box,
    find_interfaces,
    load_domain,
    moving_load,
    settle,
    settlement,
    thrust_range,
    tie_range,
)
from blockstat.sequence.plan import Plan, Step
from damage import assert_noticed, believed
from evidence.checks import derived, independent
from evidence.scenes.small import arch, running_bond, stack

LAWS = [{}, {"tension": 0.02}, {"cohesion": 0.02}, {"tension": 0.01, "cohesion": 0.02, "compression": 30.0}]


def with_laws(asm, law):
    return asm.with_(joints=[JointLaw(("*", "*"), **law)]) if law else asm


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("direction", [(1, 0, 0), (0.3, 0.2, -1)])
def test_thrusts_with_joint_laws(law, direction):
    found = thrust_range(with_laws(arch(5, 0.3), law), ["right"], direction)
    assert_noticed(found, lambda answer: independent.check_thrust(answer, ["right"], direction))


@pytest.mark.parametrize("law", LAWS)
def test_settlements_with_joint_laws(law):
    found = settlement(with_laws(arch(5, 0.3), law), ["right"], (1, 0, -0.5))
    assert_noticed(found, derived.check_settlement)


def test_foundations_that_move_in_part():
    found = settle(running_bond(2, 2), {(0, -1, -1, 0.4, 1, 0.1): (0, 0, -0.01)})
    assert not found.mechanism[0].any()
    assert_noticed(found, derived.check_settlement)
    (part,) = found.foundations
    for name in ("reaction", "displacement"):
        wrong = part._replace(**{name: getattr(part, name) * 1.001})
        assert not believed(derived.check_settlement, replace(found, foundations=(wrong,)))


def test_domains_of_two_loads():
    # Rays to corners of the domain and to its sides; a half-plane may be tilted about a corner and be true.
    asm, loads = stack(2, 1.0, 0.8), ((1, 0, 0), (0, 1, 0))
    found = load_domain(asm, *loads, directions=5)
    assert_noticed(found, lambda answer: derived.check_domain(answer, asm, *loads), by=0.05)


def test_the_range_of_a_tie():
    blocks = [box((-2, -1, -1), (1, 1, 0), name="ground"), box((0, 0, 0), (3, 1, 1), name="block")]
    tie = Tie(("ground", "block"), ((-1, 0.5, 0), (0, 0.5, 1)))
    held = Assembly.from_blocks(blocks, supports=[0], density=1000.0, ties=[tie])
    faces = find_interfaces(held)
    assert_noticed(tie_range(held), lambda answer: derived.check_tie_range(answer, faces=faces))


def test_a_train_at_its_worst_place():
    blocks = [box((0, 0, -1), (2, 1, 0), name="pier"), box((0, 0, 0), (3, 1, 0.5), name="slab")]
    bridge = Assembly.from_blocks(blocks, supports=["pier"], density=1000.0)
    found = moving_load(bridge, [(0, 1000.0)], [(0, 0.5, 0.5), (3, 0.5, 0.5)], positions=3)
    derived.check_moving_load(found)
    k = found.worst
    for name, place, by in (
        ("lower", k, 1.001),
        ("upper", k, 1.001),
        ("load", (1, 2), 1.1),
        ("mechanism", (1, 2), 1.1),
    ):
        wrong = getattr(found, name).copy()
        wrong[place] *= by
        assert not believed(derived.check_moving_load, replace(found, **{name: wrong}))
    assert not believed(derived.check_moving_load, replace(found, worst=0))


def test_the_steps_of_a_plan():
    # The second stone overhangs, and is held until the third one weighs its tail down.
    blocks = [
        box((-1, 0, -1), (1, 1, 0), name="ground"),
        box((0.4, 0, 0), (2, 1, 1), name="beam"),
        box((0.4, 0, 1), (1, 1, 3), name="weight"),
    ]
    asm = Assembly.from_blocks(blocks, supports=["ground"], density=1.0, gravity=(0, 0, -1))
    plan = Plan((Step(("beam",), ("beam",)), Step(("weight",), ()), Step((), ())))
    found = assess_plan(asm, plan)
    derived.check_plan(found)
    for k, verdict in enumerate(found.verdicts):
        if np.abs(verdict.forces).max(initial=0.0):
            others = list(found.verdicts)
            others[k] = replace(verdict, forces=1.001 * verdict.forces)
            assert not believed(derived.check_plan, replace(found, verdicts=tuple(others)))
