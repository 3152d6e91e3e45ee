"""The independent check of states, orders, courses and props notices every number and every block that is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import (
    Assembly,
    assess_states,
    box,
    build_by_courses,
    centring,
    decentring,
    falsework,
    find_order,
    hoists,
    remove_each,
    safest_order,
)
from blockstat.sequence.plan import Step
from building_sites import arch
from damage import assert_noticed, believed
from evidence.opinion import building

OPEN = (["s0", "s1", "s2", "s4", "s5", "s6"], [])  # the keystone is missing
#: Errors of a program, which are rounding.
ROUNDING = ("residual", "cone_violation")


def test_the_least_forces_under_an_open_arch():
    asm = arch()
    props = centring(asm, OPEN[0])
    found = falsework(asm, OPEN, props)
    assert_noticed(found, lambda one: building.check_falsework(one, asm, OPEN, props), 0.05, but=ROUNDING)


def test_the_least_peak_under_an_open_arch():
    asm = arch()
    props = centring(asm, OPEN[0])
    found = falsework(asm, OPEN, props, least="peak")
    building.check_falsework(found, asm, OPEN, props)
    for factor in (0.95, 1.05):
        for wrong in ({"force": factor * found.force}, {"bound": factor * found.bound}):
            assert not believed(lambda one: building.check_falsework(one, asm, OPEN, props), replace(found, **wrong))


def test_props_that_hold_are_not_said_to_hold_nothing():
    asm = arch()
    found = falsework(asm, OPEN, [])
    assert found.outcome.word == "not_held"
    building.check_falsework(found, asm, OPEN, [])
    props = hoists(asm, OPEN[0])
    wrong = replace(found, props=tuple(props), force=np.full(len(props), np.nan))
    assert not believed(lambda one: building.check_falsework(one, asm, OPEN, props), wrong)


def test_an_arch_that_follows_its_centring():
    asm = arch()
    props = centring(asm, OPEN[0])
    found = decentring(asm, OPEN, props, lowering=0.002)
    assert len(found.hinges)
    assert_noticed(found, lambda one: building.check_decentring(one, asm, OPEN, props), 0.05, but=ROUNDING)


def overhanging():
    """A beam that tips over the edge unless it is held or a weight is on its tail, and a block beside both."""
    blocks = [
        box((-1, 0, -1), (1, 1, 0), name="ground"),
        box((0.4, 0, 0), (2, 1, 1), name="beam"),
        box((0.4, 0, 1), (1, 1, 3), name="weight"),
        box((-1, 0, 0), (0, 1, 1), name="beside"),
    ]
    return Assembly.from_blocks(blocks, supports=["ground"], density=1.0, gravity=(0, 0, -1))


def test_states_and_single_blocks_taken_out():
    asm = overhanging()
    states = [(["beam"], []), (["beam"], ["beam"]), (["beam", "weight"], [])]
    for found in (assess_states(asm, states), list(remove_each(asm).values())):
        building.check_states(found)
        for k, verdict in enumerate(found):
            for name in ("forces", "mechanism"):
                proof = {"forces": "stable", "mechanism": "unstable"}[name]
                if verdict.outcome.word == proof and getattr(verdict, name).any():
                    wrong = replace(verdict, **{name: -getattr(verdict, name)})
                    assert not believed(building.check_states, [*found[:k], wrong, *found[k + 1 :]])


def wrong_plans(plan):
    """The plan with the beam let go that nothing holds down, with more blocks held, or with a block less."""
    there = []
    for k, step in enumerate(plan.steps):
        there += step.install
        changes = [Step(step.install[1:], step.hold), Step(step.install, (*step.hold, "beside", "weight", "beam"))]
        if "beam" in there and "weight" not in there:
            changes.append(Step(step.install, tuple(name for name in step.hold if name != "beam")))
        for changed in changes:
            if changed != step:
                yield replace(plan, steps=(*plan.steps[:k], changed, *plan.steps[k + 1 :]))


def test_an_order_with_two_hands():
    asm = overhanging()
    found = find_order(asm, held_at_most=2)
    building.check_order(found, asm, held_at_most=2)
    assert found.plan.most_held
    assert not believed(lambda one: building.check_order(one, asm, held_at_most=0), found)
    for wrong in wrong_plans(found.plan):
        assert not believed(lambda one: building.check_order(one, asm, held_at_most=2), replace(found, plan=wrong))


def test_the_least_friction_of_an_order():
    # On a slope of 1 in 4 every block needs a friction of 1/4.
    asm = overhanging().with_(gravity=(0, 0.25, -1), friction=0.6)
    found = safest_order(asm, held_at_most=2)
    assert found.least_friction[1] == pytest.approx(0.25, rel=1e-2)

    def check(one):
        building.check_safest(one, asm, held_at_most=2)

    check(found)
    falls, stands = found.least_friction
    for least in ((falls * 0.9, stands * 0.9), (stands * 1.1, stands)):
        assert not believed(check, replace(found, least_friction=least))
    assert not believed(check, replace(found, friction=0.7))


def test_what_is_held_after_each_course():
    asm = overhanging()
    found = build_by_courses(asm)
    assert any(course.held for course in found.courses)
    building.check_courses(found, asm)
    for k, course in enumerate(found.courses):
        for wrong in (replace(course, held=course.held[1:]), replace(course, at_least=len(course.held) + 1)):
            if wrong != course:
                courses = (*found.courses[:k], wrong, *found.courses[k + 1 :])
                assert not believed(lambda one: building.check_courses(one, asm), replace(found, courses=courses))
