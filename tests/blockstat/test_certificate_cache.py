"""Evidence of earlier designs: what is kept, in which order it is forgotten, and what it proves of the next design."""

import numpy as np
import pytest

from blockstat import Memory, Outcome, assess
from blockstat.analysis.certificate_cache import evidence, joined_blocks
from blockstat.analysis.problem import pose
from blockstat.program.penalty import PenaltyProgram
from evidence.scenes.small import assembly, box, stack

GROUND = box((-99, -9, -1), (99, 9, 0), name="ground")


def row(n, lean=0.1):
    """n cubes beside each other with gaps, under a gravity that leans; they stand to .5 and fall beyond."""
    return assembly([GROUND, *(box((2 * k, 0, 0), (2 * k + 1, 1, 1)) for k in range(n))], gravity=(lean, 0, -1))


def posed(asm):
    return pose(asm, friction=None, gravity=None, loads=None, gap=0.01, interfaces=None)


def counted(memory):
    return tuple(memory.statistics[key] for key in ("forces", "mechanism", "solved"))


def test_forces_of_a_stand_and_mechanisms_of_a_fall_prove_the_next():
    memory = Memory()
    assert counted(memory) == (0, 0, 0)
    first = assess(row(1, 0.1), memory=memory)
    assert (first.outcome, counted(memory)) == (Outcome.STABLE, (0, 0, 1))
    second = assess(row(1, 0.12), memory=memory)
    assert (second.outcome, second.solver, counted(memory)) == (Outcome.STABLE, "earlier forces", (1, 0, 1))
    falls = assess(row(1, 0.8), memory=memory)
    assert (falls.outcome, counted(memory)) == (Outcome.UNSTABLE, (1, 0, 2))
    assert falls.score > 0
    again = assess(row(1, 0.82), memory=memory)
    assert (again.outcome, again.solver, counted(memory)) == (Outcome.UNSTABLE, "earlier mechanism", (1, 1, 2))
    assert np.isnan(again.score)
    assert again.certificate.proves_unstable
    still = assess(row(1, 0.11), memory=memory)  # the mechanism proves nothing of it, the forces do
    assert (still.outcome, counted(memory)) == (Outcome.STABLE, (2, 1, 2))
    assert still.certificate.proves_stable
    np.testing.assert_allclose(still.forces[:, 0].sum(), 1.0, rtol=1e-6)


def test_evidence_of_other_joints_is_not_asked():
    memory = Memory()
    for n in (1, 2, 3):
        assess(row(n), memory=memory)
    assert counted(memory) == (0, 0, 3)
    for n in (3, 1, 2):
        assess(row(n), memory=memory)
    assert counted(memory) == (3, 0, 3)
    assert len({joined_blocks(posed(row(n)).program) for n in (1, 2, 3)}) == 3
    assert joined_blocks(posed(row(2, 0.1)).program) == joined_blocks(posed(row(2, 0.3)).program)


def test_sixteen_sets_of_joints_are_kept_and_the_one_kept_longest_ago_is_forgotten():
    memory = Memory()
    problems = {n: posed(row(n)) for n in range(1, 18)}
    answers = {n: evidence(problems[n].program, forces(problems[n]), still(problems[n]), "forces") for n in problems}
    for n in range(1, 17):
        memory.keep(problems[n], answers[n])
    assert all(memory.recall(problems[n]) is not None for n in range(1, 17))
    memory.keep(problems[1], answers[1])
    memory.keep(problems[17], answers[17])
    assert memory.recall(problems[2]) is None
    assert memory.recall(problems[1]) is not None
    assert memory.recall(problems[3]) is not None
    assert counted(memory) == (18, 0, 18)


def forces(problem):
    """Forces in balance: each cube leans by a tenth, so its weight passes .05 beside the middle of its foot."""
    program = problem.program
    joints = problem.interfaces
    found = np.zeros((joints.n_points, 3))
    for k, (a, b) in enumerate(joints.pair):
        own = slice(joints.start[k], joints.start[k + 1])
        right = joints.point[own][:, 0] > problem.assembly.centroid[b][0]
        push = np.where(right[:, None], [-0.05, 0, 0.55], [-0.05, 0, 0.45]) / 2
        found[own] = push @ joints.frame[k].T * (1 if a == 0 else -1)
    return found / program.force_unit


def still(problem):
    return np.zeros_like(problem.program.load)


def test_forces_by_hand_are_earlier_evidence():
    problem = posed(row(2))
    found = evidence(problem.program, forces(problem), still(problem), "forces")
    assert found.solver == "earlier forces"
    assert found.iterations == 0
    assert np.isnan(found.adhesion).all()
    assert len(found.adhesion) == problem.program.n_points
    assert found.certificate.proves_stable
    assert not evidence(problem.program, 1.1 * forces(problem), still(problem), "x").certificate.proves_stable


def test_two_fields_of_forces_and_three_mechanisms_are_kept():
    memory, problem = Memory(), posed(row(1))
    good = evidence(problem.program, forces(problem), still(problem), "forces")
    memory.keep(problem, good)
    kept = next(iter(memory._known.values()))
    for count in (2, 2, 2):
        memory.keep(problem, good)
        assert len(kept.forces) == count
    fallen = posed(row(1, 0.8))
    twist = assess(row(1, 0.8)).mechanism[1] * np.repeat([1.0, fallen.program.length_unit], 3)
    bad = evidence(fallen.program, np.zeros((fallen.program.n_points, 3)), twist, "mechanism")
    assert bad.certificate.proves_unstable
    for count in (1, 2, 3, 3):
        memory.keep(fallen, bad)
        assert len(kept.twists) == count
    assert counted(memory) == (0, 0, 8)


def test_what_is_undecided_is_counted_and_not_kept():
    memory, problem = Memory(), posed(row(1))
    nothing = evidence(problem.program, np.zeros_like(forces(problem)), still(problem), "forces")
    memory.keep(problem, nothing)
    assert counted(memory) == (0, 0, 1)
    assert memory.recall(problem) is None
    assert isinstance(problem.program, PenaltyProgram)


def test_a_scene_that_floats_has_no_evidence():
    memory = Memory()
    apart = assembly([GROUND, box((0, 0, 2), (1, 1, 3))])
    assert assess(apart, memory=memory).outcome is Outcome.UNSTABLE
    assert counted(memory) == (0, 0, 0)
    assert memory.recall(posed(apart)) is None


def test_forces_are_pressed_onto_the_next_design():
    memory = Memory()
    for width in np.linspace(1.0, 1.3, 4):
        assert assess(stack(3, width), memory=memory).outcome is Outcome.STABLE
    assert counted(memory) == (3, 0, 1)
    with pytest.raises(AttributeError):
        memory.statistic  # noqa: B018
