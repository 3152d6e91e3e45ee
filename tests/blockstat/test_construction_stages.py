"""Construction stages of a scene file."""

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from blockstat import (
    Assembly,
    InputError,
    assess_stages,
    assess_states,
    box,
    build,
    centring,
    falsework,
    load_scene,
    scene_text,
)
from blockstat.cli.commands import app
from blockstat.sequence import props
from blockstat.sequence.stages import StagesVerdict, stages_of

SCENE = """
name = "gate"

[elements.ring]
kind = "arch"
span = 2.0
thickness = 0.3
depth = 0.5
voussoirs = 9

[[stages]]
name = "ring"
place = ["ring"]
centring = ["ring"]
courses = true

[[stages]]
name = "decentring"
"""

#: A base with an arm whose centroid is .1 beyond its edge.
ARMS = {
    "ground": ((0, 0, -0.25), (1, 1, 0)),
    "base": ((0, 0, 0), (1, 1, 0.25)),
    "arm": ((0.6, 0, 0.25), (1.6, 1, 0.5)),
}


@pytest.fixture
def gate(tmp_path):
    path = tmp_path / "gate.toml"
    path.write_text(SCENE)
    return path


def test_a_ring_rests_on_its_centring_until_the_keystone_is_in(gate):
    assembly = build(load_scene(gate))
    found = assess_stages(assembly)
    assert found.outcome.word == "stable"
    *courses, closed, free = found.stages
    assert [stage.blocks for stage in found.stages] == [2, 4, 6, 8, 9, 9]
    totals = [stage.falsework.total for stage in courses]
    assert totals == sorted(totals)
    weight = assembly.mass[assembly.free].sum() * 9.81
    assert totals[-1] > 0.1 * weight
    assert closed.falsework.total < 1e-6 * weight
    assert (free.name, free.falsework, free.outcome.word) == ("decentring", None, "stable")
    order = sorted(assembly.free.tolist(), key=lambda k: assembly.centroid[k, 2])
    there = [assembly.names[k] for k in order[:6]]
    assert falsework(assembly, (there, []), centring(assembly, there)).total == pytest.approx(totals[2], rel=1e-6)
    assert assess_states(assembly, [(there, [])])[0].outcome.word == "unstable"


def test_the_command_prints_one_row_a_stage(gate):
    rows = json.loads(CliRunner().invoke(app, ["sequence", str(gate), "--stages", "--json"]).stdout)["stages"]
    assert [row["name"] for row in rows][-2:] == ["ring, course 5 of 5", "decentring"]
    assert rows[3]["centring_total"] > 0
    assert "on a centring that carries at least" in CliRunner().invoke(app, ["sequence", str(gate), "--stages"]).stdout


def test_stages_are_kept_when_a_scene_is_written(gate):
    assert "decentring" in scene_text(load_scene(gate))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('place = ["ring"]', 'place = ["rnig"]', r'stages.0 \("ring"\): no group "rnig"'),
        ('place = ["ring"]', 'put = ["ring"]', "stages.0: .*put"),
        ('place = ["ring"]\n', "", r'stages.0 \("ring"\): block ".*" is on a centring, but not put in yet'),
        ('name = "decentring"', 'name = "again"\nplace = ["ring"]', 'stands since stage "ring"'),
    ],
)
def test_a_bad_stage_gets_one_sentence(gate, old, new, sentence):
    gate.write_text(SCENE.replace(old, new))
    with pytest.raises(InputError, match=sentence):
        stages_of(build(load_scene(gate)))


def test_a_scene_without_stages_says_where_they_go(gate):
    gate.write_text(SCENE[: SCENE.index("[[stages]]")])
    with pytest.raises(InputError, match=r"write them as \[\[stages\]\]"):
        assess_stages(build(load_scene(gate)))


def test_a_stage_names_what_moves_only_where_it_falls(gate):
    gate.write_text(SCENE.replace('centring = ["ring"]\n', ""))
    falls, stands = assess_stages(build(load_scene(gate))).stages[2], assess_stages(build(load_scene(gate))).stages[-1]
    assert falls.outcome.word == "unstable"
    assert falls.moving
    said = StagesVerdict(falls.outcome, (falls, stands)).explain(limit=1).splitlines()
    assert f"unstable; first to move: {falls.moving[0]} ..." in said[0]
    assert said[1] == "decentring: 9 blocks, stable"
    every = StagesVerdict(falls.outcome, (falls,)).explain(limit=len(falls.moving))
    assert every.endswith(f"first to move: {', '.join(falls.moving)}")


def test_blocks_that_no_stage_puts_in_are_named(gate):
    post = '[elements.post]\nkind = "pier"\nsize = [0.5, 0.5]\nheight = 1.0\ncourses = 2\nat = [5.0, 0.0, 0.0]\n\n'
    gate.write_text(SCENE.replace("[[stages]]", post + "[[stages]]", 1))
    with pytest.raises(InputError, match=r'stages: block "post.*" is never put in \(nor are 1 more\)'):
        stages_of(build(load_scene(gate)))


def test_a_centring_that_is_not_held_falls_only_where_a_mechanism_proves_it(monkeypatch):
    """An arm juts out over its base; its centring has no face to stand under but that of the joint."""
    arms = [replace(box(*span), name=name, group=name) for name, span in ARMS.items()]
    stages = [{"name": "base", "place": ["base"]}, {"name": "arm", "place": ["arm"], "centring": ["arm"]}]
    assembly = Assembly.from_blocks(arms, supports=["ground"]).with_(metadata={"stages": stages})
    assert [stage.outcome.word for stage in assess_stages(assembly).stages] == ["stable", "unstable"]
    monkeypatch.setattr(props, "falls_on_props", lambda *what: False)
    found = assess_stages(assembly)
    assert [stage.outcome.word for stage in found.stages] == ["stable", "undecided"]
    assert found.outcome.word == "undecided"
