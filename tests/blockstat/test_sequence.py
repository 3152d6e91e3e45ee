"""States of an assembly, plans, orders and falsework on small cases whose answers are known exactly.

Numbers of stable states and orders, least numbers of hands and least forces of hoists and centring come from an
independent enumeration with its own force programs (exact cones, corner contacts).
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from blockstat import (
    Assembly,
    Block,
    FalseworkOutcome,
    InputError,
    JointLaw,
    Outcome,
    Plan,
    Prop,
    Step,
    Tie,
    assess,
    assess_plan,
    assess_states,
    box,
    build_by_courses,
    centring,
    count_orders,
    decentring,
    falsework,
    fewest_props,
    find_interfaces,
    find_order,
    hoists,
    plot_plan,
    read_plan,
    remove_each,
    safest_order,
    write,
    write_plan,
)
from blockstat.cli.commands import app
from blockstat.sequence.props import falls_on_props, held_by_props
from blockstat.sequence.states import Whole
from blockstat.view.building.slider import StepSlider
from building_sites import arch, least_force, prism, slab, tee
from evidence.scenes.small import stack


def corbel():
    """Four courses; course k ends at .3 (k + 1), and a second brick stands behind each first one."""
    blocks = [slab(-3, 0, -0.5, 0, "ground")]
    for k in range(4):
        end, low = 0.3 * (k + 1), 0.25 * k
        blocks += [slab(end - 1, end, low, low + 0.25, f"lead{k}"), slab(end - 2, end - 1, low, low + 0.25, f"back{k}")]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)


def beds_only(assembly):
    faces = find_interfaces(assembly)
    return faces.subset(np.abs(faces.frame[:, 0, 0]) < 0.5)


def numbers(count):
    return count.stable, count.orders, count.rest, count.placing


def test_an_arch_of_seven_needs_one_hand_at_rest_and_two_to_move_on():
    assembly = arch()
    assert numbers(count_orders(assembly)) == (5, 0, 1, 1)
    assert find_order(assembly, held_at_most=1).outcome.word == "none"
    found = find_order(assembly, held_at_most=2)
    assert found.outcome.word == "found"
    assert found.plan.most_held == 2
    assert assess_plan(assembly, found.plan).outcome.word == "stable"


def test_a_tee_needs_a_hand_for_its_first_arm():
    assembly = tee()
    assert numbers(count_orders(assembly)) == (3, 0, 1, 1)
    assert [find_order(assembly, held_at_most=k).outcome.word for k in (1, 2)] == ["none", "found"]


def test_a_corbel_is_built_course_by_course_without_a_hand_at_rest():
    assembly = corbel()
    assert numbers(count_orders(assembly, interfaces=beds_only(assembly))) == (23, 46, 0, 1)
    assert find_order(assembly, held_at_most=1).outcome.word == "found"
    with_heads = count_orders(assembly)  # self-stress between the bricks lets two more states stand
    assert (with_heads.stable, with_heads.orders, with_heads.rest) == (25, 46, 0)


def test_states_side_by_side_have_the_verdicts_that_they_have_one_after_the_other():
    assembly = arch()
    names = [f"s{k}" for k in range(7)]
    states = [(names[:count], names[:held]) for count in range(1, 8) for held in (0, 1)]
    one, two = (assess_states(assembly, states, jobs=jobs) for jobs in (1, 2))
    assert [v.outcome for v in one] == [v.outcome for v in two]
    assert [v.score for v in one] == pytest.approx([v.score for v in two], abs=1e-6)
    with pytest.raises(InputError, match="jobs is 0"):
        assess_states(assembly, states, jobs=0)


def test_each_state_has_the_verdict_of_its_own_assembly():
    assembly = arch()
    names = [f"s{k}" for k in range(7)]
    states = [(names, []), (names[:5], ["s4"]), (names[:5], []), (["s0", "s6"], []), (names[:3], ["s0"])]
    for (present, held), verdict in zip(states, assess_states(assembly, states), strict=True):
        there = [k for k, name in enumerate(assembly.names) if name in present or assembly.support[k]]
        blocks = []
        for k in there:
            first, last = assembly.vertex_start[k : k + 2]
            faces = [
                (assembly.face_vertices[assembly.face_start[f] : assembly.face_start[f + 1]] - first).tolist()
                for f in np.flatnonzero(assembly.face_block == k)
            ]
            blocks.append(Block(assembly.vertices[first:last], faces, assembly.names[k]))
        alone = Assembly.from_blocks(blocks, supports=["west", "east", *held], friction=0.6)
        own = assess(alone)
        assert verdict.outcome is own.outcome
        if np.isfinite(own.score):
            assert verdict.score == pytest.approx(own.score, rel=1e-5, abs=1e-9)
        assert verdict.certificate.proves_stable != verdict.certificate.proves_unstable


@pytest.mark.parametrize(("placed", "hoist"), [("06", 0), ("0156", 2), ("012456", 4), ("0123456", 0)])
def test_falsework_of_an_arch_built_from_both_sides(placed, hoist):
    """The weight of the stones that lean out, where they hang; on a centring by a plane program."""
    assembly = arch()
    stones = [f"s{k}" for k in placed]
    weight = assembly.mass[0] * 9.81
    there = tuple(map(int, placed))
    assert least_force(True, there) == pytest.approx(hoist, abs=1e-9)
    for props, expected in ((hoists(assembly, stones), hoist), (centring(assembly, stones), least_force(False, there))):
        found = falsework(assembly, (stones, []), props)
        assert found.total / weight == pytest.approx(expected, abs=1e-6)
        assert found.bound / weight == pytest.approx(expected, abs=1e-6)
        peak = falsework(assembly, (stones, []), props, least="peak")
        assert found.total / len(props) / weight - 1e-6 <= peak.peak / weight <= found.peak / weight + 1e-6


def test_props_that_cannot_hold_say_so():
    assembly = arch()
    stones = [f"s{k}" for k in range(5)]
    assert falsework(assembly, (stones, []), hoists(assembly, ["s0"])).outcome.word == "not_held"
    with pytest.raises(InputError, match='block "s6" is held or not present'):
        falsework(assembly, (stones, []), hoists(assembly, ["s6"]))


def test_no_stone_of_an_arch_may_be_taken_out():
    found = remove_each(arch())
    assert {verdict.outcome.word for verdict in found.values()} == {"unstable"}
    assert set(found) == {f"s{k}" for k in range(7)}


GOOD = [{"install": ["base"], "hold": ["base"]}, {"install": ["left"], "hold": ["left"]}]
REST = [{"install": ["right"], "hold": ["left", "right"]}, {"install": ["top"]}]


@pytest.mark.parametrize(
    ("steps", "sentence"),
    [
        ([*GOOD, *REST, {"install": ["left"]}], 'step 4: block "left" is put in, but stands since step 1'),
        ([{"hold": ["top"]}, *GOOD, *REST], 'step 0: block "top" is held, but is put in only at step 4'),
        ([*GOOD, REST[0]], 'block "top" is never put in; list it under "never_installed"'),
        ([*GOOD, {"install": ["tpo"]}, *REST], 'step 2: no block "tpo"'),
        ([{"instal": ["base"]}], 'step 0: no key "instal"; keys are: install, hold, in, out, robots'),
    ],
)
def test_a_bad_plan_gets_one_sentence_with_the_step(tmp_path, steps, sentence):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({"steps": steps}))
    with pytest.raises(InputError) as error:
        read_plan(path, tee())
    assert sentence in str(error.value)


def test_a_plan_is_read_as_it_was_written(tmp_path):
    plan = Plan((Step(("base",), ("base",)), Step(("left", "right"), ("left",)), Step(("top",))), name="tee")
    write_plan(plan, tmp_path / "plan.json")
    assert read_plan(tmp_path / "plan.json", tee()).steps == plan.steps


def test_the_tilt_of_a_step_is_that_of_friction_or_of_the_edge():
    """A cube slides at the arctangent of its friction, .6; a pillar twice as high as wide tips at that of .5."""
    blocks = [slab(-3, 3, -1, 0, "ground"), slab(-2, -1, 0, 1, "cube"), slab(1, 2, 0, 2, "pillar")]
    assembly = Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)
    plan = Plan((Step(("cube",), ("cube",)), Step(), Step(("pillar",))))
    tilt = assess_plan(assembly, plan, tilt=True).tilt
    assert tilt == pytest.approx([90.0, np.degrees(np.arctan(0.6)), np.degrees(np.arctan(0.5))], abs=1e-4)
    falls = assess_plan(
        arch(),
        Plan((Step(("s0",)), Step(tuple(f"s{k}" for k in range(1, 4)))), never_installed=("s4", "s5", "s6")),
        tilt=True,
    )
    assert falls.rows()[1]["tilt"] == 0.0
    assert "least at step 1" in falls.explain()


def test_the_first_step_that_falls_is_named_with_the_stones_that_move():
    plan = Plan((Step(("base",)), Step(("left",)), Step(("right",)), Step(("top",))))
    verdict = assess_plan(tee(), plan)
    assert verdict.first_fall == 1
    row = verdict.rows()[1]
    assert (row["verdict"], row["moving"]) == ("unstable", ["left"])
    assert "the first is step 1" in verdict.explain()
    with pytest.raises(InputError, match='state 0: block "top" is held but not present'):
        assess_states(tee(), [(["base"], ["top"])])


def test_all_orders_are_counted_for_at_most_fourteen_blocks():
    with pytest.raises(InputError, match=r"15 blocks have 2\^15 states; all orders are counted for at most 14"):
        count_orders(stack(15))


def test_supports_alone_are_built_in_one_way_without_a_hand():
    found = count_orders(stack(0))
    assert (found.states, *numbers(found)) == (1, 1, 1, 0, 0)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        ({"steps": [{"install": "base"}]}, "step 0: install is 'base'; it must be a list of names"),
        ({"steps": [], "boundary": "ground"}, "boundary is 'ground'; it must be a list of names"),
        ({"steps": [{"install": ["base"], "hold": ["base", "base"]}]}, "step 0: a block is held twice"),
        (
            {"steps": [{"install": ["base"]}, {"install": ["left"]}], "never_installed": ["left"]},
            'step 1: block "left" is put in, but listed as never installed',
        ),
    ],
)
def test_a_plan_with_bad_lists_gets_one_sentence(tmp_path, data, sentence):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(data))
    with pytest.raises(InputError) as error:
        read_plan(path, tee())
    assert sentence in str(error.value)


def cube_on_slope(tangent, **options):
    """A block on a slope down to the left."""
    ground = prism([(0, -1), (3, -1), (3, 3 * tangent), (0, 0)], "ground")
    block = prism([(1, tangent), (2, 2 * tangent), (2, 1.5), (1, 1.5)], "block")
    return Assembly.from_blocks([ground, block], supports=["ground"], **options)


def test_the_least_friction_of_a_plan_is_said_and_nothing_is_said_unless_it_is_asked_for():
    """On a slope of .25 a block needs a friction of .25: a reserve of .5 / .25 at a friction of .5."""
    assembly, plan = cube_on_slope(0.25, friction=0.5), Plan((Step(("block",)),))
    found = assess_plan(assembly, plan, reserve=True)
    low, high = found.least_friction
    assert low < 0.25 <= high + 1e-9
    assert high == pytest.approx(0.25, abs=2e-5)
    assert "Every step stands from a friction of 0.25" in found.explain()
    assert "reserve 2.000" in found.explain()
    assert "friction of" not in assess_plan(assembly, plan).explain()


@pytest.mark.parametrize("search", ["reserve", "tilt"])
def test_a_search_about_a_plan_that_would_be_answered_with_another_flow_is_refused(search, tmp_path):
    assembly, plan = cube_on_slope(0.25, friction=0.5), Plan((Step(("block",)),))
    with pytest.raises(InputError, match=f'{search}=True has flow "associated" alone, not "coulomb"'):
        assess_plan(assembly, plan, flow="coulomb", **{search: True})
    write(assembly, tmp_path / "slope.json")
    write_plan(plan, tmp_path / "plan.json")
    command = ["sequence", str(tmp_path / "slope.json"), "--plan", str(tmp_path / "plan.json"), "--flow", "coulomb"]
    refused = CliRunner().invoke(app, [*command, f"--{search}"]).exception
    assert str(refused) == f"--plan with --{search} does not take --flow coulomb"
    assert CliRunner().invoke(app, command).exit_code == 0


def test_no_friction_holds_a_block_that_tips():
    plan = Plan((Step(("base",)), Step(("left",))), never_installed=("right", "top"))
    found = assess_plan(tee(), plan, reserve=True)
    assert found.least_friction[1] == np.inf
    assert found.summary()["least_friction"][1] is None
    assert found.explain().endswith("No friction up to 10000 is proven to make every step stand.")
    assert "inf" not in found.explain()


def test_joints_with_laws_of_their_own_have_no_one_least_friction():
    law = JointLaw(("*", "*"), friction=0.5)
    assembly = cube_on_slope(0.25, friction=0.1, joints=[law])
    with pytest.raises(InputError, match="the least friction is that of joints without laws of their own"):
        assess_plan(assembly, Plan((Step(("block",)),)), reserve=True)
    with pytest.raises(InputError, match="falsework is for dry joints; this assembly has joint laws"):
        falsework(assembly, (["block"], []), hoists(assembly, ["block"]))


def test_the_states_of_an_assembly_with_joint_laws_follow_the_laws():
    """A slope of .25 and a law of .2 or .3, against the coefficient of the assembly."""
    for law, friction, word in ((0.3, 0.1, "stable"), (0.2, 0.6, "unstable")):
        laws = [JointLaw(("*", "*"), friction=law)]
        assembly = cube_on_slope(0.25, friction=friction, joints=laws)
        assert assess_states(assembly, [(["block"], [])])[0].outcome.word == word
        assert assess_states(assembly, [(["block"], ["block"])])[0].outcome.word == "stable"


@pytest.mark.parametrize("law", [{"compression": 1e7}, {"cells": 8}])
def test_laws_that_divide_joints_into_cells_are_followed_in_every_state(law):
    """At 10 MPa stones of some 20 kN fall as without a law: a base below, and one on it that lies beyond its edge."""
    blocks = [slab(-1, 0, -1, 0, "ground"), slab(-0.6, 0.4, 0, 1, "low"), slab(0, 1, 1, 2, "high")]
    scene = Assembly.from_blocks(blocks, supports=["ground"], joints=(JointLaw(("*", "*"), **law),))
    states = [(["low"], []), (["low", "high"], ["high"]), (["low", "high"], []), (["low"], [])]
    words = ["stable", "stable", "unstable", "stable"]
    assert [verdict.outcome.word for verdict in assess_states(scene, states)] == words
    assert assess_plan(scene, Plan((Step(("low",)), Step(("high",))))).first_fall == 1
    assert {name: verdict.outcome.word for name, verdict in remove_each(scene).items()} == {
        "low": "unstable",
        "high": "stable",
    }
    stands = Assembly.from_blocks(
        [*blocks[:2], slab(-0.7, 0.3, 1, 2, "high")], supports=["ground"], joints=scene.joints
    )
    assert find_order(stands, held_at_most=1).outcome.word == "found"
    assert build_by_courses(stands).most_held == 0


def test_props_hold_a_block_on_a_slope_without_friction():
    """On a slope of .25 the joint pushes square to it: a level prop through the centroid carries a quarter of weight.

    The block has the area of a trapezium, 1 x (1.25 + 1) / 2, and lies in x from 1 to 2.
    """
    assembly = cube_on_slope(0.25, density=1000.0, gravity=(0, 0, -10))
    middle = assembly.centroid[1]
    prop = Prop("block", tuple(middle.tolist()), (1.0, 0.0, 0.0))
    for friction in (0.0, 0.1):
        found = falsework(assembly, (["block"], []), [prop], friction=friction)
        # With friction mu the resultant leans by atan mu towards the prop: tan(atan .25 - atan mu).
        tangent = np.tan(np.arctan(0.25) - np.arctan(friction))
        assert found.outcome.word == "held"
        assert found.total == pytest.approx(tangent * 1000.0 * 10 * 1.125, rel=1e-5)


def two_on_slope(tangent, **options):
    """Two blocks beside each other on a slope down to the left, which do not touch."""
    blocks = [prism([(0, -1), (6, -1), (6, 6 * tangent), (0, 0)], "ground")]
    for x, name in ((1, "low"), (3, "high")):
        foot, top = x * tangent, 1.5 + x * tangent
        blocks.append(prism([(x, foot), (x + 1, foot + tangent), (x + 1, top), (x, top)], name))
    return Assembly.from_blocks(blocks, supports=["ground"], **options)


@pytest.mark.parametrize(("own", "friction"), [(0.2, 0.3), (0.3, 0.2)])
def test_a_friction_given_counts_before_that_of_the_assembly(own, friction):
    """On a slope of .25 a block stands at a friction of .3 and slides at .2."""
    assembly, slides = two_on_slope(0.25, friction=own), friction < 0.25
    alone = remove_each(assembly, friction=friction)
    assert {name: verdict.outcome.word for name, verdict in alone.items()} == dict.fromkeys(
        ("low", "high"), "unstable" if slides else "stable"
    )
    built = build_by_courses(assembly, friction=friction)
    held = [("low",), ("low", "high")] if slides else [(), ()]
    assert [course.held for course in built.courses] == held
    assert [course.at_least for course in built.courses] == [len(names) for names in held]
    assert numbers(count_orders(assembly, friction=friction)) == ((1, 0, 2, 2) if slides else (4, 2, 0, 1))
    sunk = decentring(assembly, (["low"], []), hoists(assembly, ["low"]), lowering=0.01, friction=friction)
    assert sunk.displacement[1, 2] == pytest.approx(-0.01 if slides else 0.0, abs=1e-7)


def test_states_without_supports_with_ties_or_of_unknown_blocks_are_refused():
    with pytest.raises(InputError, match='has no supports; list the blocks that cannot move under "supports"'):
        find_order(tee().with_(support=np.zeros(5, dtype=bool)), held_at_most=1)
    tie = Tie(("ground", "stone0"), ((-1.0, 0.5, 0.0), (0.0, 0.5, 1.0)))
    with pytest.raises(InputError, match="has ties; sequences are judged without ties"):
        assess_states(stack(1).with_(ties=[tie]), [(["stone0"], [])])
    with pytest.raises(InputError, match='state 1: no block "tpo"'):
        assess_states(tee(), [(["base"], []), (["tpo"], [])])
    with pytest.raises(InputError, match='state 0: no block "bsae"'):
        assess_states(tee(), [(["base"], ["bsae"])])


def test_a_block_that_touches_nothing_bears_no_tilt_of_the_ground():
    plan = Plan((Step(("s3",), ("s3",)), Step()), never_installed=tuple(f"s{k}" for k in (0, 1, 2, 4, 5, 6)))
    found = assess_plan(arch(), plan, tilt=True)
    assert found.tilt == (90.0, 0.0)
    assert "The ground may tilt by 0.00 deg towards +x, -x, +y and -y in any step, least at step 1;" in found.explain()


def test_falsework_says_its_forces_where_it_holds_and_none_where_it_does_not():
    """A rope at the centroid of a block in the air carries its weight."""
    blocks = [slab(-3, 3, -1, 0, "ground"), slab(0, 1, 2, 3, "block"), slab(1, 2, 5, 6, "other")]
    assembly = Assembly.from_blocks(blocks, supports=["ground"], density=1000.0, gravity=(0, 0, -10))
    found = falsework(assembly, (["block"], []), hoists(assembly, ["block"]))
    assert found.explain().splitlines()[1] == "Props: 10000 N in total, 10000 N at most; least total."
    bad = falsework(assembly, (["block", "other"], []), hoists(assembly, ["block"]))
    assert bad.explain() == "Not held: no forces in these props balance the blocks."


def test_blocks_in_hands_need_no_falsework():
    found = falsework(tee(), (["base", "left"], ["base", "left"]), [])
    assert (found.outcome.word, found.total, found.bound) == ("held", 0.0, 0.0)


def test_no_centring_stands_in_a_joint():
    """A stack looks down into joints alone; an arm of a tee juts out."""
    assert centring(stack(2), ["stone0", "stone1"]) == []
    assert {prop.block for prop in centring(tee(), ["base", "left"])} == {"left"}
    stones = [f"s{k}" for k in range(7)]
    assert [prop.block for prop in centring(arch(), stones)] == [stone for stone in stones for _ in range(4)]


def test_a_motion_of_no_size_is_no_proof_that_props_fail():
    assembly = tee()
    problem, _, twist = held_by_props(assembly, (["base", "left"], []), [], least="total")
    assert falls_on_props(problem, [], twist)
    assert not falls_on_props(problem, [], 0 * twist)


def ledge(*beyond):
    """A wall of sixteen bricks in four courses, with bricks on it that jut out so far over its end."""
    blocks = [slab(-1, 5, -0.5, 0, "ground")]
    for course in range(4):
        low, high = 0.25 * course, 0.25 * (course + 1)
        blocks += [slab(k, k + 1, low, high, f"{course}.{k}") for k in range(4)]
    blocks += [slab(3 + x, 4 + x, 1 + 0.25 * k, 1.25 + 0.25 * k, f"out{k}") for k, x in enumerate(beyond)]
    blocks.append(slab(0, 1, 1, 1.25, "calm"))
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)


def test_a_state_that_falls_has_the_same_score_whatever_was_judged_before():
    """One brick falls beside many at rest: its score is found around it, or by the motion of an earlier state."""
    assembly = ledge(0.7, 0.9)
    wall = [name for name in assembly.names if "." in name]
    added = [(), ("out0",), ("out0",), ("out0", "out1"), ("calm", "out0", "out1")]
    states = [([*wall, *more], []) for more in added]
    whole = Whole(assembly)
    verdicts = whole.assess_all([whole.state_of(*state, "state") for state in states], "associated", True)
    assert [verdict.outcome.word for verdict in verdicts] == ["stable", *4 * ["unstable"]]
    assert whole.evidence.statistics["nearby"] > 0
    mixed = assess_states(assembly, [states[0], states[-1]])[1]  # what falls and what stays come at once
    for state, verdict in zip([*states[1:], states[-1]], [*verdicts[1:], mixed], strict=True):
        alone = assess_states(assembly, [state])[0]
        assert alone.score > 1e-3
        assert verdict.score == pytest.approx(alone.score, rel=1e-5)
        assert verdict.certificate.proves_unstable
        assert {assembly.names[k] for k in verdict.moving} == {name for name in state[0] if name.startswith("out")}


def test_states_with_bonds_are_judged_each_by_itself():
    """A beam of weight .5 glued to a wall at one end: its moment .5 x 1 against the bond's .25 F + M."""
    for moment, word in ((0.1, "unstable"), (0.4, "stable")):
        wall, beam = box((-1, 0, -1), (0, 0.5, 1), name="wall"), box((0, 0, -0.25), (2.0, 0.5, 0.25), name="beam")
        options = {"friction": 5.0, "gravity": (0, 0, -1), "density": 1.0}
        glue = JointLaw(("*", "*"), bond=0.8, bond_moment=moment)
        assembly = Assembly.from_blocks([wall, beam], supports=["wall"], joints=[glue], **options)
        states = [(["beam"], []), (["beam"], ["beam"]), (["beam"], [])]
        assert [verdict.outcome.word for verdict in assess_states(assembly, states)] == [word, "stable", word]


def test_a_pier_that_stands_askew_tilts_less_between_the_axes_and_that_is_said():
    """Its corners are .5 from its axis along x and y, its sides .5 / sqrt(2): at a height of 2 it tips at .5 and .354.

    The four limit loads are corners of loads that are carried, and the sides between them the loads at its own sides.
    """
    foot = [(0.5, 0), (0, 0.5), (-0.5, 0), (0, -0.5)]
    faces = [[3, 2, 1, 0], [4, 5, 6, 7], *([i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4))]
    pier = Block([(x, y, z) for z in (0, 2) for x, y in foot], faces, "pier")
    ground = box((-3, -3, -1), (3, 3, 0), name="ground")
    found = assess_plan(Assembly.from_blocks([ground, pier], supports=["ground"]), Plan((Step(("pier",)),)), tilt=True)
    assert found.tilt == pytest.approx([np.degrees(np.arctan(0.5))], abs=1e-4)
    assert found.tilt_any_way == pytest.approx([np.degrees(np.arctan(0.5 / np.sqrt(2)))], abs=1e-4)
    line = (
        "may tilt by 26.57 deg towards +x, -x, +y and -y in any step, least at step 0; in any other direction by 19.47"
    )
    assert line in found.explain()
    assert found.rows()[0]["tilt_any_way"] == found.tilt_any_way[0]


def test_the_friction_that_is_asked_for_governs_that_of_the_interfaces():
    """A slope of .25 and joints of .1 or .5 against a friction of .5 or .1."""
    assembly = cube_on_slope(0.25, friction=0.3)
    faces = find_interfaces(assembly)
    for own, asked, word in ((0.1, 0.5, "stable"), (0.5, 0.1, "unstable")):
        given = replace(faces, friction=np.full(faces.n_interfaces, own))
        as_given, as_asked = (
            assess_states(assembly, [(["block"], [])], interfaces=given, friction=friction)[0]
            for friction in (None, asked)
        )
        assert as_given.outcome.word != word
        assert as_asked.outcome.word == word
        state = np.ones(2, dtype=bool), assembly.support
        assert Whole(assembly, interfaces=given).at_friction(asked).assess(*state).outcome.word == word
        assert Whole(assembly, interfaces=given, friction=asked).assess(*state).outcome.word == word


def test_interfaces_with_a_friction_of_their_own_have_no_one_least_friction():
    assembly = cube_on_slope(0.25, friction=0.6)
    faces = find_interfaces(assembly)
    given = replace(faces, friction=np.full(faces.n_interfaces, 0.5))
    with pytest.raises(InputError, match="these interfaces have their own"):
        safest_order(assembly, held_at_most=1, interfaces=given)


def test_blocks_and_props_may_come_from_a_generator():
    """A stone in the air falls, however it is named, and its hoist holds it."""
    asm = Assembly.from_blocks(
        [box((-2, 0, -1), (-1, 1, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="stone")], supports=["ground"]
    )
    assert [v.outcome for v in assess_states(asm, [((n for n in ["stone"]), iter([]))])] == [Outcome.UNSTABLE]
    state, props = (["stone"], []), hoists(asm, ["stone"])
    assert held_by_props(asm, state, iter(props), least="total")[1].outcome is FalseworkOutcome.HELD
    assert fewest_props(asm, state, iter(props)).props == tuple(props)


def test_a_plan_of_lists_is_a_plan(tmp_path):
    asm = stack(1)
    stone = asm.names[1]
    plan = Plan([Step([stone], [stone])], boundary=[asm.names[0]])
    found = assess_plan(asm, plan)
    assert found.outcome is Outcome.STABLE
    nothing = replace(found, plan=Plan((), never_installed=(stone,)), verdicts=(), outcomes=())
    with pytest.raises(InputError, match="no steps to draw"):
        plot_plan(asm, nothing, tmp_path / "plan.png")
    with pytest.raises(InputError, match="no steps to draw"):
        StepSlider(None, asm, nothing)  # refused before anything is drawn on a server
