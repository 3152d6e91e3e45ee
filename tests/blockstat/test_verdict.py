"""What a verdict says, of verdicts made by hand: figures, names, kinds of motion and how hard joints are used."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from blockstat import Assembly, Block, JointLaw, Outcome, Verdict, assess, find_interfaces
from blockstat.analysis.coulomb import CoulombState
from blockstat.analysis.verdict import (
    ASSOCIATED,
    HANGS,
    UNTRIED,
    corner_speed,
    fastest_first,
    first_words,
    motion_words,
    moving_joints,
    relative_motion,
    unit_motion,
)
from blockstat.certificate.check import Certificate
from blockstat.certificate.coulomb_state import CoulombCertificate
from evidence.scenes.small import assembly, box

PROOF = Certificate(2e-10, 3e-11, 0.25, 4e-12, 5e7, imbalance=1e-10, total_force=3.25, slack=0.5)


def row(n=3, **options):
    """Cubes beside each other along x on a ground, no two of one height."""
    blocks = [box((k, 0, 0), (k + 1, 1, 1 + 0.1 * k), name=f"b{k}") for k in range(n)]
    return assembly([box((-5, -5, -1), (9, 9, 0), name="ground"), *blocks], **options)


def verdict(asm=None, **changes):
    asm = row() if asm is None else asm
    joints = find_interfaces(asm)
    made = Verdict(
        Outcome.STABLE, 0.0, np.zeros((joints.n_points, 3)), np.zeros(joints.n_points), np.zeros((asm.n_blocks, 6)),
        PROOF, joints, asm, "by hand",
    )  # fmt: skip
    return replace(made, **changes)


def state(settles, tightness=np.nan, opposed=False, unequal=False, solves=4, changes=((3.0, 0.5), (2.0, 0.25))):
    checked = CoulombCertificate(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    return CoulombState(
        settles, np.zeros((1, 3)), np.zeros(6), checked, solves, changes, np.empty(0, np.int64), 0.25, opposed, unequal,
        tightness,
    )  # fmt: skip


def test_a_stable_verdict_tells_its_figures_and_which_question_it_answers():
    lines = verdict().explain().splitlines()
    assert lines == [
        Outcome.STABLE.value, "Largest residual 2.0e-10 of a block's load, cones violated by 3.0e-11.",
        "Normal forces of 3.25 times the weight in total.", ASSOCIATED,
    ]  # fmt: skip
    rough = replace(PROOF, residual=1.1e-9)
    assert "Without rounding of the forces on a block, residuals are 1.0e-10." in verdict(certificate=rough).explain()
    assert "Without rounding" not in verdict(certificate=replace(PROOF, residual=1e-9)).explain()
    assert ASSOCIATED not in verdict(flow="coulomb").explain()
    told = verdict(outcome=Outcome.STABLE_ONLY_BY_SELF_STRESS, flow="coulomb").explain()
    assert "Normal forces of 3.25" in told
    told = verdict(worst="the case", warnings=("one", "two")).explain().splitlines()
    assert told[1] == "Worst case of the imperfections: the case."
    assert told[-2:] == ["Warning: one", "Warning: two"]


def test_a_fall_tells_what_is_missing_and_what_moves_first():
    mechanism = np.zeros((4, 6))
    mechanism[1:, 2] = 0.5, 1.0, 0.005
    made = verdict(outcome=Outcome.UNSTABLE, score=0.125, mechanism=mechanism)
    lines = made.explain().splitlines()
    assert lines[1:4] == [
        "Residual tension (score): 0.125 of the weight.",
        "No normal forces balance the blocks, even of 1,000,000 times the weight.", "First to move: b1, b0.",
    ]  # fmt: skip
    few = replace(made, certificate=replace(PROOF, required_force=5e4), outcome=Outcome.UNDECIDED)
    assert "Any equilibrium would need 5e+04 times the weight in normal forces." in few.explain()
    assert made.moving.tolist() == [2, 1]
    assert made.motion == pytest.approx([0, 0.5, 1.0, 0.005])
    assert "Best force field" not in made.explain()
    none = replace(made, certificate=replace(PROOF, required_force=np.inf), score=np.nan)
    assert "No normal forces at all, however large, balance the blocks." in none.explain()
    assert "Residual tension" not in none.explain()
    assert "Residual tension" not in replace(made, score=0.0).explain()
    open_ = replace(made, outcome=Outcome.UNDECIDED, mechanism=0 * mechanism)
    assert open_.explain().splitlines()[3] == "Best force field: residual 2.0e-10, cones violated by 3.0e-11."
    assert "First to move" not in open_.explain()
    assert "First to move: b1 and 1 more." in made.explain(limit=1)


def test_held_falling_and_floating_blocks_are_named_up_to_a_limit():
    asm = row(7)
    made = verdict(asm, floating=np.arange(1, 8), falling=np.arange(1, 8))
    told = made.explain(limit=3).splitlines()
    assert told[-1] == "Nothing holds: b0, b1, b2 and 4 more."
    assert told[-2].endswith("so none resists: b0, b1, b2 and 4 more.")
    few = verdict(asm, floating=np.arange(1, 4), falling=np.arange(1, 4)).explain(limit=3).splitlines()
    assert few[-1] == "Nothing holds: b0, b1, b2."
    assert few[-2].endswith("so none resists: b0, b1, b2.")
    joints = find_interfaces(asm)
    held = [k for k, pair in enumerate(joints.pair.tolist()) if pair in ([1, 2], [2, 3], [0, 1])]
    text = verdict(asm, held=np.array(held)).explain(limit=2)
    pairs = [f"{asm.names[a]}-{asm.names[b]}" for a, b in joints.pair[held]]
    assert f"Held so: 3 of 7 blocks, at the joints {pairs[0]}, {pairs[1]} and 1 more." in text
    assert f"{pairs[2]}." in verdict(asm, held=np.array(held)).explain(limit=3)


def test_the_summary_is_what_the_verdict_holds():
    mechanism = np.zeros((4, 6))
    mechanism[2:, 1] = 1.0, 0.5
    made = verdict(
        outcome=Outcome.UNSTABLE, score=np.inf, mechanism=mechanism, floating=np.array([3]), neutral=np.array([1]),
        held=np.array([0]), falling=np.array([2]), coulomb=state(False), flow="coulomb", worst="w", warnings=("a",),
        certificate=replace(PROOF, required_force=np.inf),
    )  # fmt: skip
    found = made.summary()
    a, b = (made.assembly.names[k] for k in made.interfaces.pair[0])
    assert found["certificate"] == {
        "residual": 2e-10, "cone_violation": 3e-11, "work": 0.25, "mechanism_violation": 4e-12, "required_force": None,
        "imbalance": 1e-10, "total_force": 3.25,
    }  # fmt: skip
    expected = {
        "outcome": "unstable", "sentence": Outcome.UNSTABLE.value, "score": None, "moving": ["b1", "b2"],
        "floating": ["b2"], "neutral": ["b0"], "blocks": 4, "interfaces": 5, "contact_points": 20, "dropped": 0,
        "solver": "by hand", "flow": "coulomb", "held": [[a, b]], "falling": ["b1"], "held_share": 0.25,
        "tightness": None, "imperfections": "w", "warnings": ["a"], "timings": {},
    }  # fmt: skip
    assert {key: found[key] for key in expected} == expected
    bare = verdict().summary()
    assert (bare["held_share"], bare["tightness"], bare["imperfections"], bare["score"]) == (None, None, None, 0.0)
    assert verdict(coulomb=state(True, tightness=0.5)).summary()["tightness"] == 0.5


def test_a_headline_says_what_a_state_leaves_open():
    stable = Outcome.STABLE.value
    assert verdict().headline == stable
    assert verdict(coulomb=state(True)).headline == f"{stable} {UNTRIED}"
    assert verdict(coulomb=state(True, tightness=1.0)).headline == stable
    assert verdict(coulomb=state(True, tightness=0.9)).headline == HANGS
    assert verdict(coulomb=state(True, opposed=True)).headline == HANGS
    assert verdict(outcome=Outcome.UNDECIDED, coulomb=state(None)).headline == Outcome.UNDECIDED.value


@pytest.mark.parametrize(("given", "hangs"), [
    (state(True), False), (state(True, tightness=1.0), False), (state(True, tightness=0.99), True),
    (state(True, opposed=True), True), (state(True, unequal=True), True), (state(False), False),
    (state(False, tightness=0.0), False), (state(False, tightness=0.01), True), (state(False, opposed=True), False),
    (state(None, unequal=True), True), (state(None, tightness=0.5), True), (state(None), False),
])  # fmt: skip
def test_a_stand_hangs_on_the_tightness_where_kinds_of_joints_disagree(given, hangs):
    assert given.hangs is hangs
    assert ("hangs on how tight the joints are" in given.explain()) is hangs
    tried = not np.isnan(given.tightness)
    assert ("% of random tightnesses" in given.explain()) is tried
    if hangs:
        assert given.explain().endswith("the joints are." if tried else "(tightnesses=12 tells the share).")


def test_a_state_tells_how_its_slips_changed():
    words = state(True).explain()
    assert "every loaded joint closes" in words
    assert "(checked; conic programs: 4)." in words
    words = state(False).explain()
    assert words.startswith("Points that do not close carry 25 % of the normal force.")
    assert "Slips change by 0.5 (first 3), 0.25 (first 2) with each program: they grow in joints" in words
    assert "Slips change by 0.25 (first 3) with each" in state(False, changes=((3.0, 2.0, 1.0, 0.25), ())).explain()
    assert "Slips change by 3 (first 3) with each program" in state(False, changes=((3.0,),)).explain()
    assert "neither settle nor clearly grow in joints" in state(None).explain()
    assert "they grow in joints" in state(None, unequal=True).explain()
    assert "there is a state (checked)" in state(None, unequal=True).explain()
    assert "(programs: 3)" in state(False, solves=7).explain()
    assert "unequal amounts" not in state(False).explain()
    assert "no state either" not in state(None, solves=7).explain()
    assert "Slips" not in state(False, changes=((), ())).explain()
    assert "At 25 % of random tightnesses" in state(False, tightness=0.25).explain()


def test_corners_move_with_their_block_and_turn_about_its_centroid():
    asm = row()
    twist = np.zeros((4, 6))
    twist[1] = 1.0, 0.0, 0.0, 0.0, 0.0, 2.0
    twist[2] = 0.0, 3.0, 0.0, 0.0, 0.0, 0.0
    # The corner at (+-.5, +-.5) turns by 2 about z: v = (1 - 2 y, 2 x), the fastest at y = -.5.
    assert corner_speed(asm, twist) == pytest.approx([0.0, np.hypot(2.0, 1.0), 3.0, 0.0])
    scaled = unit_motion(asm, twist)
    np.testing.assert_allclose(scaled, twist / 3.0)
    assert corner_speed(asm, unit_motion(asm, 1e-8 * twist)).max() == pytest.approx(1.0)
    assert not unit_motion(asm, np.zeros((4, 6))).any()


def test_blocks_that_move_are_named_fastest_first_from_a_hundredth_on():
    asm = row(5)
    twist = np.zeros((6, 6))
    twist[1:, 1] = 0.02, 1.0, 0.01, 0.0101, 0.02
    assert fastest_first(asm, twist).tolist() == [2, 1, 5, 4]
    assert first_words(asm, np.array([2, 1])) == "First to move: b1, b0."
    assert first_words(asm, np.arange(1, 6), limit=5) == "First to move: b0, b1, b2, b3, b4."
    assert first_words(asm, np.arange(1, 6), limit=4) == "First to move: b0, b1, b2, b3 and 1 more."


def motion(**twists):
    asm = row(friction=0.5)
    found = np.zeros((4, 6))
    for name, twist in twists.items():
        found[asm.names.index(name)] = twist
    return asm, find_interfaces(asm), found


def test_relative_motion_is_that_of_the_second_block_in_the_frame_of_the_joint():
    asm, joints, twist = motion(b0=(1, 2, 3, 0.4, -0.3, 0.2), b1=(-2, 1, 0.5, 0.1, 0.2, -0.6))
    rate = relative_motion(asm, joints, twist)
    for k, (a, b) in enumerate(joints.pair):
        for p in range(joints.start[k], joints.start[k + 1]):
            place = joints.point[p]
            one, two = (twist[i, :3] + np.cross(twist[i, 3:], place - asm.centroid[i]) for i in (a, b))
            np.testing.assert_allclose(rate[p], joints.frame[k] @ (two - one), atol=1e-12)


def apart(**twists):
    """The same cubes a metre from each other: each joint is that of one cube and the ground, with friction .5."""
    blocks = [box((2 * k, 0, 0), (2 * k + 1, 1, 1.2), name=f"b{k}") for k in range(3)]
    asm = assembly([box((-5, -5, -1), (9, 9, 0), name="ground"), *blocks], friction=0.5)
    found = np.zeros((4, 6))
    for name, twist in twists.items():
        found[asm.names.index(name)] = twist
    return asm, find_interfaces(asm), found


def words_of(limit=5, **twists):
    return motion_words(*apart(**twists), limit=limit)


def test_joints_slide_open_or_part_in_words():
    assert words_of() == []
    assert words_of(b2=(0, 1, 0.5, 0, 0, 0)) == ["Slides at ground | b2."]
    assert words_of(b2=(0, 0, 1, 0, 0, 0)) == ["Parts at ground | b2."]
    # It tips about its lower edge, .5 beside and .6 below its centroid.
    tips = (0.6, 0, 0.5, 0, 1, 0)
    assert words_of(b2=tips) == ["Opens as a hinge at ground | b2."]
    told = words_of(b0=(0, 0, 1, 0, 0, 0), b1=(0, 1, 0.5, 0, 0, 0), b2=tips)
    assert told == ["Slides at ground | b1.", "Opens as a hinge at ground | b2.", "Parts at ground | b0."]


def test_a_joint_slides_only_where_its_point_slips_by_friction_alone():
    # It slips by .2 and opens; friction .5 asks for .1, and .02 of the motion are rounding.
    for opening, kind in ((0.0, "Slides"), (0.1, "Slides"), (0.104, "Slides"), (0.106, "Parts"), (0.3, "Parts")):
        assert words_of(b0=(-0.2, 0, opening, 0, 0, 0)) == [f"{kind} at ground | b0."], opening


def test_joints_that_hardly_move_beside_the_fastest_are_not_told():
    assert words_of(b0=(0, 0, 1, 0, 0, 0), b2=(0, 0, 0.021, 0, 0, 0)) == ["Parts at ground | b0, ground | b2."]
    assert words_of(b0=(0, 0, 1, 0, 0, 0), b2=(0, 0, 0.019, 0, 0, 0)) == ["Parts at ground | b0."]
    twists = {"b0": (-1, 0, 1, 0, 0, 0), "b1": (0, 2, 2, 0, 0, 0), "b2": (1, -2, 3, 0, 0, 0)}
    assert words_of(limit=2, **twists) == ["Parts at ground | b2, ground | b1 and 1 joint more."]
    assert words_of(limit=3, **twists) == ["Parts at ground | b2, ground | b1, ground | b0."]


def test_moving_joints_are_hinges_slides_or_openings():
    hinge = apart(b2=(0.6, 0, 0.5, 0, 1.0, 0), b0=(0.6, 0, 0.6, 0, 1.0, 0))
    assert moving_joints(*hinge, 1e-4) == {"hinges": [("ground", "b2")], "sliding": [], "opening": [("ground", "b0")]}
    slide = motion(b2=(0.0, 1.0, 0.5, 0, 0, 0))
    found = moving_joints(*slide, 1e-4)
    assert found["sliding"] == [("ground", "b2"), ("b1", "b2")]
    lift = motion(b0=(0, 0, 1, 0, 0, 0), b1=(0, 0, 1, 0, 0, 0), b2=(0, 0, 1, 0, 0, 0))
    assert moving_joints(*lift, 1e-4) == {
        "hinges": [], "sliding": [], "opening": [("ground", "b0"), ("ground", "b1"), ("ground", "b2")],
    }  # fmt: skip
    small = apart(b0=(0, 0, 0.9e-4, 0, 0, 0), b2=(0, 0, 1.1e-4, 0, 0, 0))
    assert moving_joints(*small, 1e-4) == {"hinges": [], "sliding": [], "opening": [("ground", "b2")]}
    # The largest friction that is told from an infinite one is a thousand.
    for friction in (1e3, 2e3, np.inf):
        asm, joints, twist = apart(b0=(1e-3, 0, 1.0, 0, 0, 0), b1=(1e-3, 0, 1.001, 0, 0, 0))
        found = moving_joints(asm.with_(friction=friction), joints, twist, 1e-4)
        assert (found["sliding"], found["opening"]) == ([("ground", "b0")], [("ground", "b1")]), friction
    for opening, kind in ((0.1, "sliding"), (0.1 + 0.9e-4, "sliding"), (0.1 + 1.1e-4, "opening")):
        assert moving_joints(*apart(b1=(0.2, 0, opening, 0, 0, 0)), 1e-4)[kind] == [("ground", "b1")]


def test_an_edge_about_which_a_block_turns_is_a_hinge_although_its_points_stay():
    ridge = [(-0.5, 0, 0), (0.5, 0, 0), (0.5, 2, 0), (-0.5, 2, 0), (0, 0, -1), (0, 2, -1)]
    faces = [[0, 1, 2, 3], [0, 4, 1], [2, 5, 3], [0, 3, 5, 4], [1, 4, 5, 2]]
    asm = assembly([box((-3, -3, -2), (3, 3, -1), name="ground"), Block(ridge, faces, "ridge")])
    joints = find_interfaces(asm)
    assert joints.area.tolist() == [0.0]
    arm = asm.centroid[1] - [0, 0, -1]
    twist = np.zeros((2, 6))
    twist[1] = [*np.cross((0, 1, 0), arm), 0, 1, 0]
    size = asm.size.min()
    for factor, hinges in ((1.0, [("ground", "ridge")]), (1.01e-4 / size, [("ground", "ridge")]), (0.99e-4 / size, [])):
        assert moving_joints(asm, joints, factor * twist, 1e-4)["hinges"] == hinges


def test_demand_is_the_largest_share_of_friction_or_strength_at_points_that_carry():
    asm = row(1, friction=0.5)
    joints = find_interfaces(asm)
    forces = np.array([[4.0, 0.6, 0.8], [2.0, 0.0, 0.0], [0.03, 0.015, 0.0], [0.0, 0.0, 0.0]])
    made = verdict(asm, forces=forces)
    assert made.demand() == pytest.approx([0.5, 0.5])  # the third point is at its limit, and carries less than 1 %
    forces[2] *= 2.0
    assert verdict(asm, forces=forces).demand() == pytest.approx([1.0, 1.0])
    assert verdict(asm, forces=0 * forces).demand() == pytest.approx([0.0, 0.0])
    forces[2] = 0.0, 0.1, 0.0
    assert verdict(asm, forces=forces).demand() == pytest.approx([1.0, 1.0])  # friction without a normal force
    strong = asm.with_(joints=[JointLaw(("*", "*"), compression=20.0)])  # 5 N at each of four points
    forces[2] = 0.0
    assert verdict(strong, forces=forces).demand() == pytest.approx([0.8, 0.8])
    bonded = asm.with_(joints=[JointLaw(("*", "*"), tension=8.0)])  # the cone begins 2 N below zero at each point
    assert verdict(bonded, forces=forces).demand() == pytest.approx([1.0 / (0.5 * 6.0)] * 2)
    smooth = asm.with_(friction=np.inf)
    assert verdict(smooth, forces=forces).demand() == pytest.approx([0.0, 0.0])
    forces[:, 1:] = 0.0
    for bare in (asm.with_(friction=0.0), asm.with_(joints=[JointLaw(("*", "*"), friction=0.0)])):
        assert verdict(bare, forces=forces).demand() == pytest.approx([0.0, 0.0])  # none to use, and none used
    pair = row(2, friction=0.5)
    joints = find_interfaces(pair)
    forces = np.zeros((joints.n_points, 3))
    for k, pair_ in enumerate(joints.pair.tolist()):
        forces[joints.start[k]] = {(0, 1): (1, 0.1, 0), (0, 2): (1, 0.2, 0), (1, 2): (1, 0.3, 0)}[tuple(pair_)]
    assert verdict(pair, forces=forces).demand() == pytest.approx([0.4, 0.6, 0.6])


def test_a_tower_presses_its_ground_with_its_weight():
    ground, tower = box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="tower")
    asm = Assembly.from_blocks([ground, tower], supports=["ground"], density=1000.0)
    found = assess(asm)
    assert found.certificate.total_force == pytest.approx(1.0, rel=1e-6)
    assert found.demand()[1] == pytest.approx(0.0, abs=1e-6)


def test_results_are_told_apart_by_identity_and_keep_what_they_hold():
    for result, name in ((state(True), "settles"), (verdict(), "score")):
        assert result == result
        assert result != replace(result)
        assert len({result, replace(result)}) == 2
        with pytest.raises(FrozenInstanceError):
            setattr(result, name, 0.5)


@pytest.mark.parametrize(("lift", "outcome"), [
    (1.0, Outcome.UNDECIDED), (0.9, Outcome.UNSTABLE), (1.1, Outcome.UNSTABLE), (0.0, Outcome.UNSTABLE),
])  # fmt: skip
def test_a_block_in_the_air_falls_or_rises_unless_its_loads_happen_to_balance(lift, outcome):
    asm = assembly([box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1)), box((5, 0, 3), (6, 1, 4))], supports=[0])
    loads = np.zeros((3, 6))
    loads[2, 2] = lift * asm.free_weight / 2
    found = assess(asm, loads=loads)
    assert found.outcome is outcome
    assert found.floating.tolist() == [2]
    if outcome is Outcome.UNSTABLE:
        assert np.sign(found.mechanism[2, 2]) == np.sign(lift - 1)
        assert not found.mechanism[:2].any()
