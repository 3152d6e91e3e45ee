"""Building by courses: what must be held after each, and why no fewer blocks will do."""

import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    Outcome,
    assess_plan,
    assess_states,
    build,
    build_by_courses,
    load_scene,
    write,
)
from blockstat.cli.commands import app
from blockstat.sequence.courses import _disjoint, _Site, courses_of
from blockstat.sequence.nearby import nearby_evidence, unbalanced
from blockstat.sequence.states import Whole
from building_sites import arch, slab, tee
from evidence.scenes.small import stack

ROOT = Path(__file__).parents[2]


def example(name):
    return build(load_scene(ROOT / "examples" / f"{name}.toml"))


def test_a_symmetric_arch_holds_what_the_reference_holds():
    """Stones placed 2, 4, 6, 7 from both sides: 0, 2, 2, 0 held (independent enumeration, exact cones)."""
    found = build_by_courses(arch())
    assert [len(course.blocks) for course in found.courses] == [2, 2, 2, 1]
    assert [len(course.held) for course in found.courses] == [0, 2, 2, 0]
    assert [course.at_least for course in found.courses] == [0, 2, 2, 0]
    assert (found.most_held, found.at_least) == (2, 2)


def test_a_lower_bound_is_what_all_sets_of_held_blocks_say():
    """An arch from one side holds one stone at rest (independent enumeration); so do all subsets tried here."""
    assembly = arch()
    found = build_by_courses(assembly, along=(1, 0, 0))
    assert [len(course.held) for course in found.courses] == [0, 1, 1, 1, 1, 1, 0]
    for assembly, along in ((arch(), (1, 0, 0)), (tee(), None), (tee(), (1, 0, 0))):
        present = []
        for course in build_by_courses(assembly, along=along).courses:
            present += course.blocks

            def holds(number, assembly=assembly, present=tuple(present)):
                states = [(present, held) for held in combinations(present, number)]
                return any(v.outcome.word == "stable" for v in assess_states(assembly, states, score=False))

            exact = next(number for number in range(len(present) + 1) if holds(number))
            assert course.at_least <= exact <= len(course.held)


@pytest.mark.parametrize("name", ["chapel", pytest.param("bridge", marks=pytest.mark.slow)])
def test_the_plan_of_an_example_is_proven_step_by_step(name):
    assembly = example(name)
    found = build_by_courses(assembly)
    assert found.outcome.word == "built"
    assert found.most_held == found.at_least > 0
    assert found.plan.steps[-1].hold == ()
    assert assess_plan(assembly, found.plan).outcome.word == "stable"


def test_all_blocks_of_a_course_are_held_until_it_is_complete():
    """The states within a course: nothing but earlier blocks, in balance, and blocks that are held."""
    assembly = arch()
    courses = build_by_courses(assembly).courses
    before, states = [], []
    for course, previous in zip(courses, ((), *(c.held for c in courses)), strict=False):
        for count in range(1, len(course.blocks) + 1):
            new = list(course.blocks[:count])
            states.append(([*before, *new], [*previous, *new]))
        before += course.blocks
        states.append((before[:], [*previous, *course.blocks, *course.held]))
    assert {verdict.outcome.word for verdict in assess_states(assembly, states)} == {"stable"}


def test_groups_follow_each_other_each_along_its_direction():
    chapel = example("chapel")
    courses = courses_of(chapel, {"wall": (0, 0, 1), "vault": (1, 0, 0)})
    kinds = ["".join(sorted({chapel.groups[k].split(".")[0] for k in course})) for course in courses]
    assert [kind for k, kind in enumerate(kinds) if k == 0 or kinds[k - 1] != kind] == ["wall", "vault", "buttress"]
    vault = [chapel.centroid[course, 0] for course, kind in zip(courses, kinds, strict=True) if kind == "vault"]
    assert all(one.max() < two.min() for one, two in zip(vault, vault[1:], strict=False))


def test_bad_directions_and_groups_are_named():
    for along in ((0, 0, 0), (0, 0, float("nan")), ((0,), 1, 2), "up", (0, 1)):
        with pytest.raises(InputError, match=f"along is {re.escape(repr(along))}; it must be three numbers"):
            build_by_courses(arch(), along=along)
    with pytest.raises(InputError, match='no group "roof"'):
        build_by_courses(example("chapel"), along={"roof": (0, 0, 1)})


def test_a_block_that_touches_only_free_blocks_beside_it_has_no_forces_of_its_own():
    """Raised between two others, on head joints alone: nothing is below it, all its joints lead to blocks beside."""
    shapes = [(-3, 3, -1, 0, "ground"), (-2, -0.5, 0, 1, "left"), (0.5, 2, 0, 1, "right"), (-0.5, 0.5, 0.2, 0.8, "key")]
    assembly = Assembly.from_blocks([slab(*shape) for shape in shapes], supports=["ground"], friction=0.6)
    whole = Whole(assembly)
    program = whole.problem(~assembly.support, np.ones(4, dtype=bool))[0].program
    balanced = whole.assess(np.arange(4) != 3, assembly.support)
    assert balanced.outcome.word == "stable"
    force = np.zeros((len(program.friction), 3))
    key = (program.point_blocks == 2).any(axis=1)
    force[~key] = balanced.forces / program.force_unit
    for proposed in nearby_evidence(program, force, small=False, score=False):
        assert not (proposed.force.any() and unbalanced(program, proposed.force).any())


KILLED = """
import os, signal
from blockstat import build_by_courses
from blockstat.sequence.search import Journal
from building_sites import arch
note, calls = Journal.note, []

def killed(self, *what):
    note(self, *what)
    calls.append(what)
    if len(calls) == 4:
        os.kill(os.getpid(), signal.SIGKILL)

Journal.note = killed
build_by_courses(arch(15), journal={path!r})
"""


def test_a_building_that_was_killed_goes_on_with_nothing_lost(tmp_path):
    path = tmp_path / "journal.jsonl"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests"), *sys.path])}
    ended = subprocess.run([sys.executable, "-c", KILLED.format(path=str(path))], env=environment, check=False)
    assert ended.returncode == -signal.SIGKILL
    kept = path.read_text().splitlines()
    assert len(kept) == 5
    fresh = build_by_courses(arch(15))
    found = build_by_courses(arch(15), journal=path)
    assert found.courses == fresh.courses
    assert 0 < found.states < fresh.states
    assert path.read_text().splitlines()[:5] == kept
    assert build_by_courses(arch(15), journal=path).states == 0


def test_a_building_that_ran_out_of_time_keeps_its_courses():
    found = build_by_courses(arch(), seconds=0.0)
    assert (found.outcome.word, found.plan, found.courses) == ("stopped", None, ())
    assert (found.planned, found.time_limit) == (4, 0.0)
    assert found.explain().splitlines()[:2] == [
        "Stopped: the limit of 0 s was over before the last course.", "0 of 4 courses; 0 of them stand by themselves."
    ]  # fmt: skip


def test_the_command_prints_the_courses_and_writes_the_plan(tmp_path):
    write(arch(), tmp_path / "arch.json")
    command = ["sequence", str(tmp_path / "arch.json"), "--courses"]
    answer = CliRunner().invoke(app, [*command, "--json", "-o", str(tmp_path / "plan.json")])
    found = json.loads(answer.stdout)
    assert (found["outcome"], found["most_held"], found["at_least"]) == ("built", 2, 2)
    judged = CliRunner().invoke(app, ["sequence", str(tmp_path / "arch.json"), "--plan", str(tmp_path / "plan.json")])
    assert "Every step is stable." in judged.stdout
    assert "no fewer than 1 will do" in CliRunner().invoke(app, [*command, "--along", "1,0,0"]).stdout
    for options, message in (
        (["--along", "1,0"], '--along is "1,0"'),
        (["--along", "1,0,0", "--along", "0,0,1"], "--along is given twice"),
        (["--along", "wall=1,0,0", "--along", "wall=0,0,1"], "--along gives wall twice"),
        (["--flow", "coulomb"], '--courses has flow "associated" alone'),
    ):
        bad = CliRunner().invoke(app, [*command, *options])
        assert message in str(bad.exception)


def test_courses_that_stand_by_themselves_have_no_course_that_is_held():
    found = build_by_courses(stack(3))
    assert [course.held for course in found.courses] == [(), (), ()]
    said = found.explain()
    assert "3 courses; 3 of them stand by themselves." in said
    assert "blocks are held" not in said
    assert "Most blocks are held after course 2 of 4: 2; no fewer than 2 will do." in build_by_courses(arch()).explain()


def test_groups_that_hold_every_block_leave_no_course_for_the_rest():
    blocks = [slab(-3, 3, -1, 0, "ground"), slab(0, 1, 0, 1, "one"), slab(1, 2, 0, 1, "two")]
    blocks = [blocks[0], *[replace(block, group="row") for block in blocks[1:]]]
    assembly = Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)
    assert [course.tolist() for course in courses_of(assembly, {"row": (-1, 0, 0)})] == [[2], [1]]
    assert [course.tolist() for course in courses_of(assembly)] == [[1, 2]]


def test_a_course_that_is_not_decided_is_held_by_what_was_laid_and_gives_no_plan_unless_that_is_proven(monkeypatch):
    proven = True

    def judge(self, present, hold):
        holds = proven and hold[4]
        return Outcome.STABLE if holds else Outcome.UNDECIDED, np.zeros(len(present))

    monkeypatch.setattr(_Site, "_judge", judge)
    monkeypatch.setattr(_Site, "_falls", lambda self, present, blocks: False)
    held = [set(course.held) for course in build_by_courses(tee()).courses]
    assert held[-1] == {"top"}  # nothing else was needed, and only the block just laid was asked
    proven = False
    found = build_by_courses(tee())
    assert (found.outcome.word, found.plan) == ("undecided", None)
    assert "neither to stand nor to fall" in found.explain()
    assert found.courses[0].held == ("base",)


def test_what_need_not_be_held_is_let_go_and_what_falls_is_not():
    """A whole arch stands with nothing held; with its keystone away each half falls unless a stone of it is held."""
    assembly = arch()
    site, none = _Site(Whole(assembly), None), np.zeros(9, dtype=bool)
    for missing, held in (((), 0), (("s3",), 2)):
        present = ~np.isin(assembly.names, missing)
        hold = present & ~assembly.support
        site._let_go(present, hold, none, 0)
        assert hold.sum() == held
        kept = [name for name, on in zip(assembly.names, hold, strict=True) if on]
        there = [name for name in assembly.names if name not in missing]
        assert assess_states(assembly, [(there, kept)])[0].outcome.word == "stable"


def test_demands_that_share_a_block_count_once():
    assert _disjoint([]) == 0
    assert _disjoint([{1, 2}, {2, 3}]) == 1
    assert _disjoint([{1, 2, 3}, {1}, {3}]) == 2  # the smallest first: the large one asks for nothing more


def test_a_building_that_falls_when_it_is_let_go_is_said_to_stand_only_while_it_is_held():
    """Each arm of a tee without its top has its centroid .1 beyond the edge of the base."""
    shapes = [(-0.5, 0.5, -0.25, 0, "ground"), (-0.5, 0.5, 0, 0.25, "base"), (-1.1, -0.1, 0.25, 0.5, "left")]
    shapes.append((0.1, 1.1, 0.25, 0.5, "right"))
    open_tee = Assembly.from_blocks([slab(*shape) for shape in shapes], supports=["ground"], friction=0.6)
    found = build_by_courses(open_tee)
    assert [course.held for course in found.courses] == [(), ("left", "right")]
    said = found.explain().splitlines()
    assert said[1] == "The finished assembly is proven to stand only while left, right are held."
    assert "Most blocks are held after course 2 of 2: 2; no fewer than 2 will do." in said
    assert "finished assembly" not in build_by_courses(arch()).explain()


def test_a_journal_of_courses_with_other_joint_laws_is_refused(tmp_path):
    """Glued to its base an arm of a tee needs no hand; dry it does."""
    glued = tee().with_(joints=(JointLaw(("*", "*"), tension=1e6),))
    path = tmp_path / "journal.jsonl"
    assert not any(course.held for course in build_by_courses(glued, journal=path).courses)
    with pytest.raises(InputError, match="outcomes of another assembly"):
        build_by_courses(tee(), journal=path)
    assert build_by_courses(glued, journal=path).states == 0
