"""A plan carried out in Bullet: the steps that fall are those that statics exclude."""

import json
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from blockstat import Assembly, Outcome, Plan, Prop, Step, Tie, assess, assess_plan, box, find_order, write, write_plan
from blockstat.errors import InputError
from blockstat.view.painter import visible
from building_sites import arch, tee
from dynsim import DynamicOutcome, Settings, World, read_run, sequence, verify, write_run
from dynsim.bonds.props import PropForces
from dynsim.cli.commands import app
from dynsim.comparison.steps import StepComparison, compare_steps
from dynsim.view import film


@pytest.fixture(scope="module")
def one_sided():
    """An arch built from one side without a hand: all states but the first and the last fall."""
    plan = Plan(tuple(Step((f"s{k}",)) for k in range(7)))
    return plan, sequence(arch(), plan)


def test_an_order_that_statics_prove_stands_at_every_step():
    assembly = arch()
    found = sequence(assembly, find_order(assembly, held_at_most=2).plan)
    assert found.outcome.word == "stands"
    assert found.first_fall is None
    assert max(step.max_displacement for step in found.steps) < 0.1 * found.threshold


@pytest.mark.parametrize("plan", [None, {"steps": []}, "plan.json"])
def test_what_is_no_plan_is_refused(plan):
    for ask in (sequence, assess_plan):
        with pytest.raises(InputError, match="it must be a Plan, as read_plan returns it"):
            ask(arch(), plan)


def test_the_steps_that_fall_are_those_that_statics_exclude(one_sided):
    plan, found = one_sided
    static = [verdict.outcome.word for verdict in assess_plan(arch(), plan).verdicts]
    assert static == ["stable"] + 5 * ["unstable"] + ["stable"]
    assert [step.outcome.word for step in found.steps] == ["stands"] + 5 * ["falls"] + ["stands"]
    assert found.steps[1].first_block == "s1"


def test_a_block_that_is_let_go_in_the_air_falls_no_faster_than_gravity_lets_it():
    assembly = tee()
    plan = Plan((Step(("top",), ("top",)), Step()), never_installed=("base", "left", "right"))
    found = sequence(assembly, plan)
    assert [step.outcome.word for step in found.steps] == ["stands", "falls"]
    top = assembly.names.index("top")
    fallen = -(found.run.displacement[-1, top] - found.run.displacement[-2, top])[2]
    assert found.threshold < fallen < 0.5 * 9.81 * (found.run.times[-1] - found.run.times[-2]) ** 2


def test_a_run_of_a_plan_is_written_and_read_with_the_times_of_its_blocks(one_sided, tmp_path):
    _, found = one_sided
    again = read_run(write_run(found.run, tmp_path / "plan.npz"))
    assert np.array_equal(again.placed, found.run.placed)
    assert (np.diff(found.run.placed[:7]) > 0).all()
    for suffix in (".glb", ".png"):
        assert write_run(found.run, tmp_path / f"plan{suffix}").stat().st_size > 1000


def test_a_picture_of_a_step_has_the_blocks_that_are_in_by_its_end(monkeypatch):
    """Also where nothing is free at the end of a step; supports and the boundary are there from the beginning."""
    shown = []

    def seen(assembly, vertices, view, colour):
        shown.append({name for name, paint in zip(assembly.names, colour, strict=True) if paint[3]})
        return visible(assembly, vertices, view, colour)

    monkeypatch.setattr(film, "visible", seen)
    plan = Plan((Step(("left",), ("left",)), Step(("right",)), Step(("top",))), boundary=("base",))
    run = sequence(tee(), plan).run
    assert (np.diff(run.times) > 0).all()
    painter, axes = film._Painter(run, np.arange(4)), Figure().add_subplot()
    for frame in range(4):
        painter.paint(axes, frame)
    there = {"ground", "base"}
    assert shown == [there, there | {"left"}, there | {"left", "right"}, there | {"left", "right", "top"}]


PROPS = {
    "west": Prop("left", (-0.7, 0.5, 0.25), (0.0, 0.0, 1.0)),
    "east": Prop("right", (0.7, 0.5, 0.25), (0.0, 0.0, 1.0)),
}
ARMS = (Step(("base",)), Step(("left",), props_in=("west",)), Step(("right",), props_in=("east",)), Step(("top",)))


def test_arms_stand_on_props_until_the_top_holds_them():
    """The same plan falls without its props, and where they go before the top is there."""
    found = sequence(tee(), Plan((*ARMS, Step(props_out=("west", "east"))), props=PROPS))
    assert [step.outcome.word for step in found.steps] == 5 * ["stands"]
    assert max(step.max_displacement for step in found.steps) < 0.1 * found.threshold
    early = sequence(tee(), Plan((*ARMS[:2], Step(props_out=("west",)), *ARMS[2:]), props=PROPS))
    assert [step.outcome.word for step in early.steps[:3]] == ["stands", "stands", "falls"]
    compared = compare_steps(tee(), early)
    assert (compared.differ, compared.static[2].word) == ([], "unstable")


def test_a_prop_pushes_with_what_the_lever_says_and_never_pulls():
    """The arm turns about the edge of the base at .5; its centroid is .1 beyond, the prop .2: half the weight.

    A second prop, above the other end of the arm, which would have to pull, carries nothing.
    """
    assembly = tee()
    left, points = assembly.names.index("left"), [(-0.7, 0.5, 0.25), (-0.2, 0.5, 0.25)]
    props = PropForces(assembly, [left, left], points, [(0, 0, 1), (0, 0, 1)])
    present = [assembly.names.index(name) for name in ("ground", "base", "left")]
    settings = Settings()
    with World(assembly, settings, [props]) as world:
        for block in set(range(assembly.n_blocks)) - set(present):
            world.remove(block)
        world.hold(assembly.names.index("base"))
        props.stand(world, np.array([True, True]))
        world.damp(1.0)
        for _ in range(20):
            world.advance()
    weight = 9.81 * assembly.mass[left]
    assert props.force[0] == pytest.approx(0.5 * weight, rel=0.02)
    assert props.force[1] < 0.02 * weight


def test_the_command_compares_each_step_with_statics(tmp_path):
    assembly = tee()
    write(assembly, tmp_path / "tee.json")
    plan = Plan((Step(("base",)), Step(("left",)), Step(("right",)), Step(("top",))), assembly="tee.json")
    write_plan(plan, tmp_path / "plan.json")
    answer = CliRunner().invoke(app, ["sequence", str(tmp_path / "plan.json"), "--json"])
    found = json.loads(answer.stdout)
    assert [row["verdict"] for row in found["steps"]] == ["stands", "falls", "falls", "stands"]
    assert found["statics"]["verdicts"] == ["stable", "unstable", "unstable", "stable"]
    assert found["statics"]["differ"] == []


def test_a_plan_that_cannot_be_carried_out_is_refused_with_the_step():
    with pytest.raises(InputError, match='step 1: block "base" is put in, but stands since step 0'):
        sequence(tee(), Plan((Step(("base",)), Step(("base",)), Step(("left", "right", "top")))))


def test_a_plan_with_ties_is_refused_as_by_the_statics():
    """A pillar whose centroid is .15 beyond the edge hangs on a tie, which a plan would leave out."""
    blocks = [box((-2, 0, -1), (0, 1, 0), name="ground"), box((-0.2, 0, 0), (0.5, 1, 1), name="pillar")]
    tie = Tie(("ground", "pillar"), ((-2, 0.5, 0), (-0.2, 0.5, 1)))
    tied = Assembly.from_blocks(blocks, supports=["ground"], friction=0.7, ties=[tie], name="tied")
    assert (assess(tied).outcome.word, verify(tied).outcome.word) == ("stable", "stands")
    for judge in (sequence, assess_plan):
        with pytest.raises(InputError, match='"tied" has ties; sequences are judged without ties'):
            judge(tied, Plan((Step(("pillar",)),)))


def test_a_step_on_which_statics_or_bullet_say_neither_is_no_agreement():
    stable, unstable, undecided = Outcome.STABLE, Outcome.UNSTABLE, Outcome.UNDECIDED
    stands, falls, creeps = DynamicOutcome.STANDS, DynamicOutcome.FALLS, DynamicOutcome.CREEPS
    pairs = [(s, d) for s in (stable, unstable, undecided) for d in (stands, falls, creeps)]
    static, dynamic = zip(*pairs, strict=True)
    compared = StepComparison(static, (None,) * 9, dynamic, (None,) * 9)
    assert [pairs[k] for k in compared.differ] == [(stable, falls), (unstable, stands)]
    neither = [pair for pair in pairs if undecided in pair or creeps in pair]
    assert [pairs[k] for k in compared.undecided] == neither
    assert len(neither) == 5
    assert compared.summary()["undecided"] == compared.undecided
    words = compared.explain().splitlines()
    assert words[:2] == [
        "Statics and Bullet agree on 2 of 9 steps.", "On 5 of 9 steps one of them says neither."
    ]  # fmt: skip
    assert "step 7: Bullet falls, statics undecided" in words
    assert len(words) == 2 + 7


def test_a_fall_that_statics_allow_is_asked_at_other_tightnesses_and_on_props_not_at_all():
    # Bullet sees all of these steps stand: falls are put in their place.
    plan = Plan((*ARMS, Step(props_out=("west", "east"))), props=PROPS)
    found = sequence(tee(), plan)
    fell = tuple(replace(step, outcome=DynamicOutcome.FALLS) for step in found.steps)
    compared = compare_steps(tee(), replace(found, steps=fell))
    assert compared.differ == [0, 1, 2, 3, 4]
    on_props = [1, 2, 3]
    assert [k for k, verdict in enumerate(compared.coulomb) if verdict is None] == on_props
    assert [k for k, share in enumerate(compared.tightness) if share is None] == on_props
    assert compared.tightness[0] == 1.0  # one block on the ground
    assert 0 in compared.unexplained
    assert 'step 0: Bullet falls, statics stable, with flow="coulomb" stable; states at 100 %' in compared.explain()
