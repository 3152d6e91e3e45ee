"""Worst cases of imperfections, contacts that are in no program, and verdicts that combine several causes."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import (
    Imperfections,
    JointLaw,
    LoadOutcome,
    Memory,
    Outcome,
    acceleration,
    assess,
    find_interfaces,
    limit_load,
    point_load,
    tilt_limit,
)
from blockstat.analysis.assess import judged
from blockstat.analysis.coulomb import FAMILY
from blockstat.analysis.problem import cases_of, pose
from blockstat.analysis.reserve import doubtful_joints
from blockstat.certificate.check import Certificate
from evidence.scenes.small import assembly, box, flat_arch, stack

GROUND = box((-9, -9, -1), (9, 9, 0), name="ground")


def posed(asm, **options):
    given = {"friction": None, "gravity": None, "loads": None, "gap": 0.01, "interfaces": None}
    return pose(asm, **(given | options))


def block(**options):
    return assembly([GROUND, box((0, 0, 0), (1, 0.5, 2), name="block")], friction=0.7, **options)


def test_the_worst_case_is_the_first_that_falls_or_the_one_with_least_slack():
    light = Imperfections(loads={"*": (0.5, 2.0)})
    asm = block(gravity=(0.45, 0, -1))
    push = point_load(asm, "block", (1, 0.25, 2), (0, 0, -0.1))  # it holds the block down beyond its middle
    found = assess(asm, loads=push, imperfections=light)
    assert found.outcome is Outcome.STABLE
    assert found.worst
    assert found.explain().splitlines()[1] == f"Worst case of the imperfections: {found.worst}."
    tipping = point_load(asm, "block", (0.0, 0.25, 2), (0.04, 0, 0))  # moment .08, of .05 that are left x .5
    falls = assess(asm, loads=tipping, imperfections=light)
    assert falls.outcome is Outcome.UNSTABLE
    assert "2" in falls.worst
    assert (
        assess(asm, loads=tipping / 2, imperfections=Imperfections(loads={"*": (0.5, 1.0)})).outcome is Outcome.STABLE
    )
    steady = Imperfections(edge=0.01)
    verdict = assess(block(), imperfections=steady)
    assert verdict.outcome is Outcome.STABLE
    assert np.ptp(verdict.interfaces.point[:, 0]) == pytest.approx(0.98)


def test_warnings_of_the_scene_as_drawn_come_with_the_worst_case():
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="a"), box((5, 0, 2), (6, 1, 3), name="up")])
    found = assess(asm, imperfections=Imperfections(friction=1.2))
    assert found.outcome is Outcome.UNSTABLE
    assert found.warnings.count('block "up" touches nothing') == 1
    limit = limit_load(block(), (1, 0, 0), imperfections=Imperfections(friction=2.0))
    assert limit.upper == pytest.approx(0.35, rel=1e-3)
    assert "friction" in limit.worst


def test_cases_are_made_of_whole_joints_where_a_law_divides_them_into_cells():
    asm = block().with_(joints=[JointLaw(("*", "*"), compression=1e6, cells=4)])
    problem = posed(asm)
    assert problem.interfaces.share is not None
    (case,) = cases_of(problem, None, Imperfections(edge=0.1))
    assert case.interfaces.share is None
    assert case.interfaces.n_points == 4
    plain = posed(block())
    (case,) = cases_of(plain, None, Imperfections(edge=0.1))
    assert np.ptp(case.interfaces.point[:, 1]) == pytest.approx(0.3)
    found = limit_load(asm, (1, 0, 0), imperfections=Imperfections(edge=0.1), tolerance=1e-3)
    assert found.upper <= 0.4 * (1 + 1e-3)


def test_a_tilt_under_imperfections_is_that_of_the_worst_case():
    asm = block().with_(friction=2.0)
    found = tilt_limit(asm, "y", imperfections=Imperfections(edge=0.1))
    assert found.stands == pytest.approx(np.degrees(np.arctan(0.4)), abs=1e-3)
    assert found.worst
    never = tilt_limit(asm, "y", gravity=(0.45, 0, -1), imperfections=Imperfections(edge=0.1))
    assert np.isnan(never.stands)
    slides = tilt_limit(asm, "y", friction=0.4, imperfections=Imperfections(friction=2.0))
    assert slides.stands == pytest.approx(np.degrees(np.arctan(0.2)), abs=1e-3)


def under_a_shelf(alone=True):
    """A block that tips towards +x against the lower edge of a shelf along its own upper one, and one that is free."""
    blocks = [GROUND, box((0, 0, 0), (1, 0.5, 2), name="held"), box((1, -1, 2), (3, 2, 3), name="shelf")]
    if not alone:
        blocks += [box((-4, 0, 0), (-3, 0.5, 2.2), name="free")]
    return assembly(blocks, supports=["ground", "shelf"], friction=2.0)


def test_an_upper_bound_holds_at_edges_along_each_other():
    alone = limit_load(under_a_shelf(), (1, 0, 0))
    assert alone.lower == pytest.approx(0.5, rel=1e-3)
    assert alone.outcome is not LoadOutcome.LIMIT
    assert alone.upper > 0.6
    assert any("edge along edge" in text for text in alone.warnings)
    back = limit_load(under_a_shelf(), (-1, 0, 0))
    assert (back.outcome, back.warnings) == (LoadOutcome.LIMIT, ())
    assert back.upper == pytest.approx(0.5, rel=1e-3)
    beside = limit_load(under_a_shelf(alone=False), (1, 0, 0))  # the free one tips at 1 / 2.2 before the other does
    assert beside.outcome is LoadOutcome.LIMIT
    assert beside.upper == pytest.approx(1 / 2.2, rel=1e-3)


def test_a_verdict_of_what_leans_on_an_edge_is_open_unless_something_else_falls():
    leaning = assess(under_a_shelf(), gravity=(0.55, 0, -1))
    assert leaning.outcome is Outcome.UNDECIDED
    assert any("edge along edge" in text for text in leaning.warnings)
    both = assess(under_a_shelf(alone=False), gravity=(0.55, 0, -1))
    assert both.outcome is Outcome.UNSTABLE
    assert not both.mechanism[both.assembly.names.index("held")].any() or both.moving.tolist() == [3]
    assert both.certificate.proves_unstable
    away = assess(under_a_shelf(), gravity=(-0.55, 0, -1))
    assert away.outcome is Outcome.UNSTABLE


def test_a_verdict_may_be_asked_for_without_its_reserve_or_its_score():
    # Balanced on the edge of its foot exactly.
    asm = block(gravity=(0.5, 0, -1.0))
    problem = posed(asm)
    whole = judged(problem)
    assert whole.outcome in (Outcome.STABLE, Outcome.UNDECIDED)
    bare = judged(problem, reserve=False)
    assert bare.neutral.tolist() == []
    falling = posed(block(gravity=(0.6, 0, -1)))
    assert judged(falling).score > 0
    assert judged(falling, score=False).outcome is Outcome.UNSTABLE
    assert judged(posed(block()), flow="coulomb", kinds=FAMILY[:1]).coulomb.changes.__len__() == 1
    memory = Memory()
    assert judged(posed(block()), memory=memory).solver != "earlier forces"
    assert judged(posed(block()), memory=memory).solver == "earlier forces"


def test_all_supports_are_a_stand_with_nothing_to_check():
    found = assess(assembly([GROUND]))
    assert (found.outcome, found.solver, found.score) == (Outcome.STABLE, "none", 0.0)
    assert found.certificate == Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
    assert found.forces.shape == (0, 3)
    assert not len(found.neutral)
    assert len(doubtful_joints(posed(assembly([GROUND])), np.empty((0, 3))).slivers) == 0


def test_the_score_is_the_missing_adhesion_in_weights_whatever_the_units():
    asm = block(gravity=(0.6, 0, -1))
    score = assess(asm).score
    for other in (
        asm.with_(density=1e3 * asm.density),
        asm.with_(vertices=20 * asm.vertices),
        asm.with_(gravity=(6, 0, -10)),
    ):
        assert assess(other).score == pytest.approx(score, rel=1e-5)
    found = assess(asm)
    # Forces and adhesion balance the moment about the edge that it tips over: .6 - .5 of its weight at half its height.
    pulled = found.adhesion
    assert score == pytest.approx(np.linalg.norm(pulled) / asm.free_weight, rel=1e-9)
    assert (pulled >= -1e-9).all()
    # Two corners at x = 0 pull with a arm of 1 each: .6 x 1 - 1 x .5 = .1 of |g| = 1.166.
    weight = asm.free_weight
    moment = (0.6 * 1.0 - 1.0 * 0.5) / np.hypot(0.6, 1.0)
    assert np.linalg.norm(pulled) / weight == pytest.approx(moment / 2 * 2**0.5, rel=1e-2)


def test_a_verdict_without_self_stress_shows_the_forces_of_its_state():
    asm = stack(2).with_(gravity=(0.05, 0, -1))
    plain, coulomb = assess(asm), assess(asm, flow="coulomb")
    assert plain.displacement is None
    assert plain.coulomb is None
    assert coulomb.coulomb.settles is True
    assert coulomb.displacement.shape == (3, 6)
    joints = coulomb.interfaces
    np.testing.assert_allclose(
        coulomb.forces, posed(asm).to_points(coulomb.coulomb.force), rtol=1e-9, atol=1e-12
    )  # fmt: skip
    assert coulomb.certificate.proves_stable
    assert joints.n_points == len(coulomb.forces)
    smooth = assess(asm.with_(gravity=(0, 0, -1)), friction=0.0, flow="coulomb")
    assert smooth.coulomb is None
    assert smooth.flow == "coulomb"
    jammed = assess(flat_arch(6, friction=0.1), flow="coulomb")
    assert jammed.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS
    assert len(jammed.held)
    assert jammed.displacement is None
    tried = assess(asm, flow="coulomb", tightnesses=2)
    assert tried.coulomb.tightness == 1.0


def test_loads_beside_the_weight_keep_blocks_from_falling_freely():
    walls = [box((-1, 0, 0), (0, 1, 4), name="left"), box((1, 0, 0), (2, 1, 4), name="right")]
    asm = assembly([*walls, box((0, 0, 2), (1, 1, 3), name="block")], supports=["left", "right"], friction=0.5)
    assert assess(asm, flow="coulomb").falling.tolist() == [2]
    load = np.zeros((3, 6))
    assert assess(asm, flow="coulomb", loads=load).falling.tolist() == [2]  # no load is none
    load[2, 0] = 1.0
    pressed = assess(asm, flow="coulomb", loads=load)
    assert pressed.falling.tolist() == []
    assert pressed.outcome is not Outcome.STABLE


def test_times_and_a_motion_are_kept_of_a_limit():
    found = limit_load(block(), (1, 0, 0))
    assert {"interfaces", "equilibrium", "solve", "total"} <= set(found.timings)
    assert np.abs(found.mechanism).max() > 0
    assert found.iterations > 0
    load = acceleration(block(), (1, 0, 0))
    balance = found.lower * load[1, 0]
    joints = find_interfaces(block())
    pushed = np.einsum("pi,pij->j", found.forces, joints.frame[joints.point_interface])
    assert pushed == pytest.approx([-balance, 0, 1.0], abs=1e-6)
    twice = limit_load(block(), 2 * load)
    assert twice.upper == pytest.approx(found.upper / 2, rel=1e-4)
    assert replace(found, lower=0.0).gap == pytest.approx(1.0)
