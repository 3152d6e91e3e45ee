"""Props of a plan: set up and taken away step by step, with the least forces in them."""

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from blockstat import Assembly, InputError, Plan, Prop, Step, assess_plan, read_plan, write, write_plan
from blockstat.cli.commands import app
from blockstat.sequence import props
from building_sites import slab, tee


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


@pytest.mark.parametrize("friction", [0.6, 0.0])
def test_an_arm_on_a_prop_below_its_centroid_needs_what_the_lever_says(friction):
    """The arm turns about the edge of the base at .5, its centroid and its prop are .1 beyond: the prop carries it all.

    Moments about the edge: r x .1 = w x .1. All joints are level and all loads upright, so no friction is needed.
    """
    found = assess_plan(tee(), plan(), friction=friction)
    assert [outcome.word for outcome in found.outcomes] == 5 * ["stable"]
    assert found.outcome.word == "stable"
    assert found.falsework[1].force == pytest.approx([weight("left")], rel=1e-6)
    assert found.falsework[2].total == pytest.approx(2 * weight("left"), rel=1e-6)
    assert [one is None for one in found.falsework] == [True, False, False, True, True]
    rows = found.rows()
    assert [row["props"] for row in rows] == [[], ["west"], ["west", "east"], ["west", "east"], []]
    assert rows[4]["prop_force"] is None


def test_a_prop_off_its_block_is_refused_when_the_plan_is_read(tmp_path):
    """Though no step needs it: the base stands by itself."""
    off = Plan(
        (Step(("base",)), Step(props_in=("under",)), Step(props_out=("under",))),
        props={"under": Prop("base", (8.0, 0.5, 0.25), (0.0, 0.0, 1.0))},
        never_installed=("left", "right", "top"),
    )
    low, high = (bound[tee().names.index("base")].tolist() for bound in tee().bounds)
    words = f'step 1: prop "under" at [8.0, 0.5, 0.25] is not on block "base", which is from {low} to {high}'
    with pytest.raises(InputError) as refused:
        assess_plan(tee(), off)
    assert str(refused.value) == words
    write_plan(off, tmp_path / "off.json")
    with pytest.raises(InputError) as refused:
        read_plan(tmp_path / "off.json", tee())
    assert str(refused.value) == f"{tmp_path / 'off.json'}: {words}"
    never = Plan(off.steps[:1], props=off.props, never_installed=off.never_installed)
    with pytest.raises(InputError, match=r'^prop "under" at'):
        assess_plan(tee(), never)


def test_props_that_are_never_taken_away_are_told():
    left = "never taken away"
    assert left not in assess_plan(tee(), plan()).explain()
    told = assess_plan(tee(), Plan(plan().steps[:-1], props=plan().props))
    assert told.explain().endswith("\n2 props never taken away: west, east. The last step is judged with them.")
    assert told.explain(limit=1).endswith(
        "2 props never taken away: west and 1 more. The last step is judged with them."
    )


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
    said = CliRunner().invoke(app, command).stdout
    # Each arm has its weight in its prop, and two of them stand on props in step 2.
    most, one = f"{2 * weight('left'):.6g}", f"{weight('left'):.6g}"
    assert "2 steps stand on props; step 2 needs most: at least " in said
    assert f"at least {most} N in total, then with up to {one} N in one of them." in said


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


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"direction": [0, 0, 0]}, r"direction is \(0.0, 0.0, 0.0\); it must be three numbers, not all zero"),
        ({"point": [0, float("nan"), 0]}, r"point is \(0.0, nan, 0.0\); it must be three finite numbers"),
    ],
)
def test_a_prop_of_a_plan_that_reads_well_and_is_none_gets_the_sentence_of_a_prop(tmp_path, wrong, words):
    prop = {"block": "left", "point": [-0.6, 0.5, 0.25], "direction": [0, 0, 1]} | wrong
    (tmp_path / "plan.json").write_text(json.dumps({"steps": [], "props": {"west": prop}}))
    with pytest.raises(InputError, match=f'plan.json: prop "west" under "left": {words}$'):
        read_plan(tmp_path / "plan.json", tee())


def test_the_least_friction_refuses_props():
    with pytest.raises(InputError, match="without props"):
        assess_plan(tee(), plan(), reserve=True)


def jammed(*others):
    """A stone between two walls, with nothing below it: only how tight it is holds it."""
    blocks = [slab(-1, 5, -1, 0, "ground"), slab(-1, 0, 1, 4, "west"), slab(1, 2, 1, 4, "east")]
    blocks += [slab(0, 1, 2, 3, "stone"), *others]
    return Assembly.from_blocks(blocks, supports=["ground", "west", "east"], friction=0.5)


def test_a_prop_that_carries_nothing_does_not_hold_what_stands_only_by_self_stress():
    """The prop is under a block that lies on the ground and needs none."""
    scene = jammed(slab(3, 4, 0, 1, "other"))
    props = {"p": Prop("other", (3.5, 0.5, 0.5), (0.0, 0.0, 1.0))}
    found = assess_plan(scene, Plan((Step(("stone", "other"), props_in=("p",)),), props=props), flow="coulomb")
    assert found.outcome.word == "stable_only_by_self_stress"
    assert found.rows()[0]["prop_force"] is None
    assert "stand on props" not in found.explain()


def test_props_that_carry_no_more_than_what_is_left_unbalanced_prove_nothing(monkeypatch):
    """A beam whose centroid is 1e-7 beyond its edge: a prop .25 beyond it carries 4e-7 of the weight."""
    blocks = [slab(-0.5, 0.5, -1, 0, "ground"), slab(1e-7, 1 + 1e-7, 0, 1, "beam")]
    scene = Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)

    def on(x):
        under = {"p": Prop("beam", (x, 0.5, 0.0), (0.0, 0.0, 1.0))}
        return assess_plan(scene, Plan((Step(("beam",), props_in=("p",)),), props=under))

    assert assess_plan(scene, Plan((Step(("beam",)),))).outcome.word == "unstable"
    assert (on(0.75).outcome.word, on(0.2).outcome.word) == ("stable", "unstable")
    assert on(0.75).falsework[0].total == pytest.approx(4e-7 * scene.mass[1] * 9.81, rel=1e-3)
    held_by_props = props.held_by_props

    def roughly(*given, **options):
        problem, found, twist = held_by_props(*given, **options)
        return problem, replace(found, residual=5e-7), twist

    monkeypatch.setattr(props, "held_by_props", roughly)
    assert on(0.75).outcome.word == "undecided"


def test_a_prop_proves_no_fall_into_what_has_no_joint():
    """A cube over a slot of its own width touches its supports only edge along edge; no verdict says that it falls."""
    blocks = [slab(-1, 0, -1, 0, "west"), slab(1, 2, -1, 0, "east"), slab(0, 1, 0, 1, "cube")]
    scene = Assembly.from_blocks(blocks, supports=["west", "east"])
    props = {"p": Prop("cube", (0.0, 0.5, 0.5), (1.0, 0.0, 0.0))}
    assert assess_plan(scene, Plan((Step(("cube",)),))).outcome.word == "undecided"
    assert assess_plan(scene, Plan((Step(("cube",), props_in=("p",)),), props=props)).outcome.word == "undecided"
    under = {"p": Prop("cube", (0.5, 0.5, 0.0), (0.0, 0.0, 1.0))}  # and one below its middle carries it
    assert assess_plan(scene, Plan((Step(("cube",), props_in=("p",)),), props=under)).outcome.word == "stable"


def test_each_prop_that_stands_has_its_force_and_that_of_a_held_block_has_none():
    steps = list(plan().steps)
    steps[2] = Step(("right",), hold=("left",), props_in=("east",))
    row = assess_plan(tee(), Plan(tuple(steps), props=plan().props)).rows()[2]
    assert row["props"] == ["west", "east"]
    assert row["prop_force"] == pytest.approx([0.0, weight("right")], rel=1e-6)
