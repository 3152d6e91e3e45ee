"""Props of a plan: set up and taken away step by step, with the least forces in them."""

import json

import pytest
from typer.testing import CliRunner

from blockstat import InputError, Plan, Prop, Step, assess_plan, read_plan, write, write_plan
from blockstat.cli.commands import app
from building_sites import tee


def plan(**changes):
    """A tee whose arms stand on a prop each, below their centroids, until the top is on them."""
    props = {
        "west": Prop("left", (-0.6, 0.5, 0.25), (0.0, 0.0, 1.0)),
        "east": Prop("right", (0.6, 0.5, 0.25), (0.0, 0.0, 1.0)),
    }
    steps = (
        Step(("base",)),
        Step(("left",), props_in=("west",)),
        Step(("right",), props_in=("east",)),
        Step(("top",)),
        Step(props_out=("west", "east")),
    )
    return Plan(steps, props=props, **changes)


def weight(name):
    assembly = tee()
    return float(assembly.mass[assembly.names.index(name)] * 9.81)


def test_an_arm_on_a_prop_below_its_centroid_needs_what_the_lever_says():
    """The arm turns about the edge of the base at .5, its centroid and its prop are .1 beyond: the prop carries it all.

    Moments about the edge: r x .1 = w x .1.
    """
    found = assess_plan(tee(), plan())
    assert [outcome.word for outcome in found.outcomes] == 5 * ["stable"]
    assert found.outcome.word == "stable"
    assert found.falsework[1].force == pytest.approx([weight("left")], rel=1e-6)
    assert found.falsework[2].total == pytest.approx(2 * weight("left"), rel=1e-6)
    assert [one is None for one in found.falsework] == [True, False, False, True, True]
    rows = found.rows()
    assert [row["props"] for row in rows] == [[], ["west"], ["west", "east"], ["west", "east"], []]
    assert rows[4]["prop_force"] is None


def test_a_prop_further_out_carries_less():
    far = plan()
    far.props["west"] = Prop("left", (-1.0, 0.5, 0.25), (0.0, 0.0, 1.0))
    assert assess_plan(tee(), far).falsework[1].total == pytest.approx(weight("left") * 0.1 / 0.5, rel=1e-6)


def test_a_prop_that_goes_too_early_leaves_a_step_that_falls():
    early = Plan(
        (Step(("base",)), Step(("left",), props_in=("west",)), Step(props_out=("west",)), Step(("right", "top"))),
        props=plan().props,
    )
    found = assess_plan(tee(), early)
    assert (found.first_fall, found.outcome.word) == (2, "unstable")
    assert found.rows()[2]["moving"] == ["left"]


def test_a_prop_in_the_wrong_place_is_proven_not_to_hold():
    """Within the base a prop pushes the arm over the edge; it need not push, and nothing else holds the arm."""
    inside = plan()
    inside.props["west"] = Prop("left", (-0.3, 0.5, 0.25), (0.0, 0.0, 1.0))
    found = assess_plan(tee(), inside)
    assert found.outcomes[1].word == "unstable"
    assert found.falsework[1].outcome.word == "not_held"


def test_props_are_written_and_read(tmp_path):
    path = tmp_path / "plan.json"
    write_plan(plan(), path)
    again = read_plan(path, tee())
    assert (again.steps, dict(again.props)) == (plan().steps, dict(plan().props))
    steps = json.loads(path.read_text())["steps"]
    assert (steps[1]["in"], steps[4]["out"]) == (["west"], ["west", "east"])
    assert "in" not in steps[0]


def test_the_command_prints_the_forces_of_the_props(tmp_path):
    write(tee(), tmp_path / "tee.json")
    write_plan(plan(), tmp_path / "plan.json")
    command = ["sequence", str(tmp_path / "tee.json"), "--plan", str(tmp_path / "plan.json")]
    rows = json.loads(CliRunner().invoke(app, [*command, "--json"]).stdout)["steps"]
    assert rows[1]["prop_force"] == pytest.approx([weight("left")], rel=1e-6)
    assert "props carry at most" in CliRunner().invoke(app, command).stdout


@pytest.mark.parametrize(
    ("steps", "sentence"),
    [
        ([{"install": ["base"], "in": ["north"]}], 'step 0: no prop "north"'),
        ([{"install": ["base"], "in": ["west"]}], 'step 0: prop "west" is under block "left", which is not put in yet'),
        (
            [{"install": ["base", "left"], "in": ["west"]}, {"in": ["west"]}],
            'step 1: prop "west" is set up, but stands',
        ),
        ([{"install": ["base", "left"], "out": ["west"]}], 'step 0: prop "west" is taken away, but does not stand'),
    ],
)
def test_bad_props_get_one_sentence_with_the_step(tmp_path, steps, sentence):
    path = tmp_path / "plan.json"
    write_plan(plan(), path)
    data = json.loads(path.read_text())
    data |= {"steps": steps, "never_installed": [name for name in ("left", "right", "top") if name not in str(steps)]}
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=sentence):
        read_plan(path, tee())
    data["props"] = {"west": {"block": "left", "point": [0, 0]}}
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=r'prop "west" is .* it must read'):
        read_plan(path, tee())


def test_the_least_friction_refuses_props():
    with pytest.raises(InputError, match="without props"):
        assess_plan(tee(), plan(), reserve=True)
