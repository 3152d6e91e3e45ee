"""The independent check of tilts, least frictions and limits all round notices every number that is wrong."""

import pytest

from blockstat import Bracket, JointLaw, friction_limit, limit_load_by_direction, tilt_limit
from damage import assert_noticed, believed
from evidence.opinion import brackets
from evidence.scenes.small import arch, running_bond, stack


def lawful(law):
    return arch(5, 0.3).with_(joints=[JointLaw(("*", "*"), **law)] if law else [])


@pytest.mark.parametrize("law", [{}, {"tension": 0.02}])
@pytest.mark.parametrize("axis", ["y", (0.2, -1, 0)])
def test_the_tilt_of_an_arch(law, axis):
    asm = lawful(law)
    assert_noticed(tilt_limit(asm, axis), lambda found: brackets.check_tilt(found, asm, axis))


def test_a_tilt_about_the_vertical_ends_nowhere_but_where_the_range_does():
    assert_noticed(tilt_limit(stack(2), "z"), lambda found: brackets.check_tilt(found, stack(2), "z"))


@pytest.mark.parametrize("law", [{}, {"cohesion": 0.02}])
def test_the_least_friction_of_an_arch(law):
    asm = lawful(law)
    assert_noticed(friction_limit(asm), lambda found: brackets.check_friction(found, asm))


def test_the_ends_of_the_range_of_friction():
    enough, none = friction_limit(stack(2)), friction_limit(arch(12, 0.04), top=0.7)
    assert (enough.outcome.word, none.outcome.word) == ("always_stands", "never_stands")
    for found, asm, top in ((enough, stack(2), 10.0), (none, arch(12, 0.04), 0.7)):
        brackets.check_friction(found, asm, top=top)
        for wrong in (Bracket(0.1, float("nan"), "friction"), Bracket(float("nan"), 0.6, "friction")):
            assert not believed(lambda one, a=asm, t=top: brackets.check_friction(one, a, top=t), wrong)


def test_the_limit_loads_all_round():
    found = limit_load_by_direction(running_bond(2, 2), directions=4, refine=False)
    assert_noticed(found, brackets.check_directions, but=("timings",), places=4)
