"""A friction that is asked for does not count where joint laws or the interfaces have their own, and that is told."""

import json
import warnings
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from blockstat import (
    InputError,
    InputWarning,
    JointLaw,
    Plan,
    Step,
    assess,
    assess_plan,
    assess_states,
    capacity,
    find_interfaces,
    find_order,
    friction_limit,
    limit_load,
    limit_load_by_direction,
    load_domain,
    reliability,
    settle,
    settle_to_collapse,
    thrust_range,
    tilt_limit,
    write,
)
from blockstat.chance.variables import Random
from blockstat.cli.commands import app
from blockstat.contact.point_law import keeps_friction, kept_by
from dynsim import sequence
from dynsim.cli.commands import app as dynamics
from evidence.scenes.small import assembly, box

OWN = 'keep a friction of their own, by the joint law between "slab" and "*"'
ASKED = f"a friction of 0.3 is asked for, and 1 of 2 joints {OWN}"
SIDE = (1, 0, 0)


def slabs(*laws, friction=0.5):
    """Two slabs beside each other on the ground, which slide before they tip."""
    blocks = [
        box((-2, -2, -1), (9, 3, 0), name="ground", group="ground"),
        box((0, 0, 0), (1, 1, 0.2), name="slab", group="slab.a"),
        box((5, 0, 0), (6, 1, 0.2), name="other", group="other"),
    ]
    return assembly(blocks, friction=friction, joints=laws)


RUBBING = JointLaw(("slab", "*"), friction=0.7)
SCENE = """\
name = "slab"
[elements.p]
kind = "box"
size = [1, 1, 0.2]
[[joints]]
between = ["*", "*"]
friction = 0.7
"""


def test_a_limit_load_under_another_friction_names_the_laws_that_keep_theirs():
    """Of two slabs the other one slides first, at .3; of one alone the law holds .7."""
    found = limit_load(slabs(RUBBING), SIDE, friction=0.3)
    assert found.lower == pytest.approx(0.3, rel=2e-4)
    assert found.warnings == (ASKED,)
    assert limit_load(slabs(RUBBING), SIDE, friction=0.3, flow="coulomb").warnings.count(ASKED) == 1
    assert limit_load(slabs(RUBBING), SIDE).warnings == ()
    assert limit_load(slabs(), SIDE, friction=0.3).warnings == ()
    assert limit_load(slabs(RUBBING), SIDE, friction=0.7).warnings == ()


def test_a_limit_load_under_another_friction_tells_that_the_interfaces_keep_theirs():
    asm = slabs()
    joints = replace(find_interfaces(asm), friction=np.array([0.7, 0.7]))
    found = limit_load(asm, SIDE, friction=0.3, interfaces=joints)
    assert found.lower == pytest.approx(0.7, rel=2e-4)
    told = "2 of 2 joints keep a friction of their own, which the interfaces give"
    assert found.warnings == (f"a friction of 0.3 is asked for, and {told}",)
    with pytest.raises(InputError, match="all joints keep a friction of their own, which the interfaces give; leave"):
        friction_limit(asm, interfaces=joints)


@pytest.mark.parametrize(
    "ask",
    [
        assess,
        partial(assess, flow="coulomb", tightnesses=2),
        partial(tilt_limit, axis="y"),
        partial(thrust_range, supports=["ground"], direction=(0, 0, -1)),
        partial(load_domain, one=SIDE, two=(0, 1, 0), directions=4),
        partial(limit_load_by_direction, directions=4),
        partial(settle, moves={"ground": (0, 0, -0.01)}),
        partial(capacity, load=SIDE, steps=3, displacement=0.1),
        partial(capacity, load=SIDE, steps=3, displacement=0.1, flow="associated"),
        partial(settle_to_collapse, moves={"ground": (0, 0, -1)}, steps=3, displacement=0.1),
    ],
)
def test_every_analysis_tells_it_once(ask):
    assert ask(slabs(RUBBING), friction=0.3).warnings.count(ASKED) == 1
    assert not [text for text in ask(slabs(RUBBING)).warnings if "of their own" in text]


BUILT = Plan((Step(("slab",)), Step(("other",))))


@pytest.mark.parametrize(
    "ask",
    [
        partial(assess_states, states=[(("ground", "slab", "other"), ())]),
        partial(assess_plan, plan=BUILT),
        partial(find_order, held_at_most=1),
    ],
)
def test_every_analysis_of_a_sequence_tells_it(ask):
    with pytest.warns(InputWarning) as told:
        ask(slabs(RUBBING), friction=0.3)
    assert {str(one.message) for one in told} == {ASKED}  # the independent check of an order asks again
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ask(slabs(RUBBING))
        ask(slabs(RUBBING), friction=0.7)
        ask(slabs(), friction=0.3)


def test_a_plan_that_is_carried_out_tells_that_the_interfaces_keep_their_friction():
    joints = replace(find_interfaces(slabs()), friction=np.array([0.7, 0.7]))
    told = "a friction of 0.3 is asked for, and 2 of 2 joints keep a friction of their own, which the interfaces give"
    assert sequence(slabs(), BUILT, friction=0.3, interfaces=joints).warnings == (told,)
    assert sequence(slabs(), BUILT, interfaces=joints).warnings == ()
    assert sequence(slabs(), BUILT, friction=0.3).warnings == ()


def test_a_least_friction_tells_it_in_the_same_words_and_does_not_tell_of_a_friction_that_is_tried():
    found = friction_limit(slabs(RUBBING).with_(gravity=(3.0, 0, -9.81)))
    assert found.value == pytest.approx(3.0 / 9.81, abs=2e-6)
    assert found.warnings == (f"1 of 2 joints {OWN}",)


def test_random_friction_is_refused_in_the_same_words():
    with pytest.raises(InputError, match=f'uncertain "friction": joints {OWN.replace("*", "[*]")}; leave it out'):
        reliability(slabs(RUBBING), {"friction": Random("uniform", 0.5, 0.6)}, draws=2)


def test_the_last_law_alone_keeps_its_friction():
    rough, glued = JointLaw(("*", "*"), friction=0.9), JointLaw(("other", "*"), tension=1.0)
    asm = slabs(rough, RUBBING, glued)
    assert keeps_friction(asm, find_interfaces(asm)).tolist() == [True, False]
    assert limit_load(asm, SIDE, friction=0.3).warnings == (ASKED,)
    assert kept_by([rough, RUBBING, rough]).endswith('by the joint laws between "*" and "*", between "slab" and "*"')


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "slab.toml"
    path.write_text(SCENE)
    return path


TOLD = f'"slab": --friction 0.3 is asked for, and joints {kept_by([JointLaw(("*", "*"), friction=0.7)])}'


@pytest.mark.parametrize(
    ("program", "command"),
    [
        ("blockstat", ("check", "--tilt", "y,30")),
        ("blockstat", ("limit", "--load", "1,0,0")),
        ("blockstat", ("tilt", "--axis", "y")),
        ("dynsim", ("verify",)),
    ],
)
def test_a_command_tells_of_laws_that_keep_their_friction_once(run_command, scene, program, command):
    run = partial(run_command, app if program == "blockstat" else dynamics, program, command[0], scene)
    with pytest.warns(InputWarning) as told:
        status, out, _ = run(*command[1:], "--friction", 0.3, "--json")
    assert [str(one.message) for one in told] == [TOLD]
    assert (status, json.loads(out)["warnings"].count(TOLD)) == (0, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run(*command[1:], "--friction", 0.7)[0] == 0
        assert run(*command[1:])[0] == 0


def test_a_friction_that_no_joint_has_is_told_on_a_file_of_blocks(run_command, tmp_path):
    path = write(slabs(RUBBING), tmp_path / "slabs.json")
    with pytest.warns(InputWarning, match=f"--friction 0.3 is asked for, and joints {OWN.replace('*', '[*]')}"):
        run_command(app, "blockstat", "prove", path, "-o", tmp_path / "proof.json", "--friction", 0.3)
