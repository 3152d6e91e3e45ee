"""Construction stages of a scene file."""

import json
import re
from dataclasses import replace
from pathlib import Path

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
    read,
    scene_from,
    scene_text,
    with_values,
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
    assert "stable on a centring that needs " in CliRunner().invoke(app, ["sequence", str(gate), "--stages"]).stdout


def test_stages_are_kept_when_a_scene_is_written(gate):
    assert "decentring" in scene_text(load_scene(gate))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('place = ["ring"]', 'place = ["rnig"]', r'stages.0 \("ring"\): no group "rnig"'),
        (
            'place = ["ring"]',
            'put = ["ring"]',
            "stages.0.put: unknown key; keys here are: name, place, c",
        ),
        ('place = ["ring"]\n', "", r'stages.0 \("ring"\): block ".*" is on a centring, but not put in yet'),
        (
            'name = "decentring"',
            'name = "ring"',
            'stages.1.name: stages.0 is named "ring", too; each stage needs a name of',
        ),
        ('name = "decentring"', 'name = "again"\nplace = ["ring"]', 'stands since stage "ring"'),
    ],
)
def test_a_bad_stage_gets_one_sentence(gate, old, new, sentence):
    gate.write_text(SCENE.replace(old, new))
    with pytest.raises(InputError, match=sentence):
        stages_of(build(load_scene(gate)))


RANDOM = '\n[uncertain.{}]\nkind = "normal"\nmean = 0.6\ndeviation = 0.1\n'


@pytest.mark.parametrize("scene", [SCENE, 'name = "hut"\nlength = 3.0\nspan = 2.0\n'], ids=["composition", "building"])
@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (
            '\n[[stages]]\nname = "more"\nplase = ["ring"]\n',
            r"stages.\d.plase: unknown key; keys here are: name, ",
        ),
        ('\n[[stages]]\nname = "more"\nplace = ["rnig"]\n', r'stages.\d \("more"\): no group "rnig"; groups are: '),
        (
            '\n[[stages]]\nname = "more"\n' * 2,
            r'stages.\d.name: stages.\d is named "more", too; each stage needs a name of its own',
        ),
        ('\n[[stages]]\nname = ""\n', r'stages.\d.name: it is ""; a stage needs a name'),
        ('\n[[stages]]\nname = " "\n', r'stages.\d.name: it is " "; a stage needs a name'),
        (RANDOM.format("frction"), r"line \d+: uncertain.frction: unknown key; keys here are: friction, edge"),
        (RANDOM.format("density"), "uncertain.density: unknown key; keys here are: friction, edge"),
        (RANDOM.format("density.rnig"), 'uncertain.density.rnig: no group "rnig"; groups are: '),
    ],
)
def test_a_slip_in_stages_and_random_variables_is_refused_when_the_scene_is_read(gate, scene, more, sentence):
    gate.write_text(scene + more)
    with pytest.raises(InputError, match=rf"^{re.escape(str(gate))}[:,].*{sentence}"):
        read(gate)


@pytest.mark.parametrize("present", ['"search"', "false"])
def test_stages_may_name_what_is_not_present(gate, present):
    keys = 'kind = "pier"\nsize = [1, 1]\nheight = 1\ncourses = 1\nat = [5, 0, 0]\n'
    post = f"present = {present}\n\n[elements.post]\n{keys}"
    gate.write_text(SCENE.replace("\n[[stages]]", post + "\n[[stages]]", 1))
    scene = load_scene(gate)
    absent = with_values(scene, {"elements.ring.present": 0}) if present != "false" else scene
    assert build(absent).n_blocks == 2


CHAPEL = Path(__file__).parents[2] / "examples" / "chapel.toml"
#: The walls and the vault of the chapel.
WALLS = """
[[stages]]
name = "walls"
place = ["wall", "buttress"]

[[stages]]
name = "vault"
place = ["vault"]
centring = ["vault"]
"""


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ('centring = ["vault"]', 'centring = ["vault.typo"]', 'stages.1 ("vault"): no group "vault.typo"'),
        ('place = ["vault"]', 'place = ["vault", "vault.typo"]', 'stages.1 ("vault"): no group "vault.typo"'),
        ('"buttress"', '"buttress.est"', 'stages.0 ("walls"): no group "buttress.est"'),
    ],
)
def test_a_misspelt_subgroup_is_refused_by_who_judges_the_stages_of_a_scene_with_ranges(tmp_path, old, new, where):
    """It may be there with other values, so the scene is built."""
    path = tmp_path / "chapel.toml"
    path.write_text(CHAPEL.read_text() + WALLS.replace(old, new, 1))
    assembly = build(load_scene(path))
    assert "absent" not in assembly.metadata
    groups = ", ".join(sorted({group for group in assembly.groups if group}))
    for judge in (stages_of, assess_stages):
        with pytest.raises(InputError) as refused:
            judge(assembly)
        assert str(refused.value) == f"{where}; groups are: {groups}"


def test_a_design_of_a_search_that_leaves_out_an_element_has_its_stages_judged(tmp_path):
    """The stages name the vault and a part of it that only it can tell; both ranges of the chapel move."""
    path = tmp_path / "chapel.toml"
    data = CHAPEL.read_text().replace("[vault]\n", '[vault]\npresent = "search"\n')
    path.write_text(data + WALLS.replace('place = ["vault"]', 'place = ["vault", "vault.part"]'))
    design = build(with_values(load_scene(path), {"vault.present": 0}))
    assert design.metadata["absent"] == ["vault", "vault.part"]
    walls, vault = assess_stages(design).stages
    assert walls.blocks == vault.blocks == len(design.free)
    assert vault.falsework is None
    with pytest.raises(InputError, match=r'^stages.1 \("vault"\): no group "vault.part"; groups are: '):
        assess_stages(build(load_scene(path)))


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
    assert f"unstable; first to move: {falls.moving[0]} and {len(falls.moving) - 1} more" in said[0]
    assert said[1] == "decentring: 9 blocks, stable"
    every = StagesVerdict(falls.outcome, (falls,)).explain(limit=len(falls.moving))
    assert every.endswith(f"first to move: {', '.join(falls.moving)}")


def test_blocks_that_no_stage_puts_in_are_named(gate):
    post = '[elements.post]\nkind = "pier"\nsize = [0.5, 0.5]\nheight = 1.0\ncourses = 2\nat = [5.0, 0.0, 0.0]\n\n'
    gate.write_text(SCENE.replace("[[stages]]", post + "[[stages]]", 1))
    with pytest.raises(InputError, match=r'stages: block "post.*" is never put in \(nor are 1 more\)'):
        stages_of(build(load_scene(gate)))


def stages_with(blocks, centring):
    """The blocks in two stages: the base, and all others with some on a centring."""
    blocks = [replace(box(*span), name=name, group=name) for name, span in blocks.items()]
    others = [block.name for block in blocks[2:]]
    stages = [{"name": "base", "place": ["base"]}, {"name": "rest", "place": others, "centring": [centring]}]
    return Assembly.from_blocks(blocks, supports=["ground"]).with_(metadata={"stages": stages})


def test_boards_push_on_all_that_no_joint_covers():
    """The arm's weight is .1 m beyond its base. Boards below what juts out hold it best at its end, .6 m beyond."""
    assembly = stages_with(ARMS, "arm")
    props = centring(assembly, ["arm"])
    points = sorted(tuple(round(along, 9) for along in prop.point) for prop in props)
    assert points == [(x, y, 0.25) for x in (1.0, 1.6) for y in (0.0, 1.0)]
    stage = assess_stages(assembly).stages[1]
    assert (stage.outcome.word, stage.unpropped) == ("stable", ())
    assert stage.falsework.total == pytest.approx(assembly.free_weight / 2 / 6, rel=1e-6)
    assert stage.falsework.by_block == {"arm": pytest.approx(stage.falsework.total)}


def test_boards_on_both_sides_of_a_joint_push_anywhere_between():
    """A lintel of 3 m on a pillar that is off its middle: free on both sides."""
    pillar, lintel = box((1, 0, 0), (1.5, 1, 2), name="pillar"), box((0, 0, 2), (3, 1, 2.5), name="lintel")
    assembly = Assembly.from_blocks([box((-1, -1, -1), (4, 2, 0), name="ground"), pillar, lintel], supports=["ground"])
    props = centring(assembly, ["lintel"])
    assert sorted(prop.point for prop in props) == [(x, y, 2.0) for x in (0.0, 3.0) for y in (0.0, 1.0)]


def test_a_centring_that_is_not_held_falls_only_where_a_mechanism_proves_it(monkeypatch):
    """A bed covers its base; the arm on it falls, and a centring under the bed has no face to stand under."""
    spans = {name: ARMS[name] for name in ("ground", "base")}
    spans |= {"bed": ((0, 0, 0.25), (1, 1, 0.5)), "arm": ((0.6, 0, 0.5), (1.6, 1, 0.75))}
    assembly = stages_with(spans, "bed")
    found = assess_stages(assembly)
    assert [stage.outcome.word for stage in found.stages] == ["stable", "unstable"]
    assert found.explain().endswith("rest: 3 blocks, unstable; no board of the centring has room under bed")
    assert [row["unpropped"] for row in found.summary()["stages"]] == [[], ["bed"]]
    monkeypatch.setattr(props, "falls_on_props", lambda *what: False)
    found = assess_stages(assembly)
    assert [stage.outcome.word for stage in found.stages] == ["stable", "undecided"]
    assert found.outcome.word == "undecided"


def test_stages_that_are_no_list_and_a_centring_under_supports_alone_are_refused(gate):
    scene = build(load_scene(gate))
    with pytest.raises(InputError, match='metadata: "stages" is None; it is a list of tables'):
        stages_of(scene.with_(metadata={"stages": None}))
    support = [box((-1, -1, -1), (1, 1, 0), name="pier", group="pier"), box((0, 0, 0), (1, 1, 1), name="b", group="b")]
    tables = [{"name": "all", "place": ["b"], "centring": ["pier"]}]
    held = Assembly.from_blocks(support, supports=["pier"], metadata={"stages": tables})
    with pytest.raises(InputError, match='all blocks of "pier" are supports; nothing of it rests on a centring'):
        stages_of(held)


@pytest.mark.parametrize("turn", [0, 30, 33])
def test_boards_under_a_sail_vault_are_found_however_it_is_turned(turn):
    """Edges of joints and of warped soffits all but coincide."""
    sail = {"kind": "sail", "spans": [4.0, 3.0], "rise": 1.0, "thickness": 0.3, "courses": 5, "voussoirs": 4,
            "springers": 0.3, "supports": ["south", "north"], "turn": turn}  # fmt: skip
    vault = build(scene_from({"name": "sail", "elements": {"v": sail}, "supports": ["v.springer"]}))
    props = centring(vault, vault.free)
    under = [sum(prop.block == vault.names[block] for prop in props) for block in vault.free]
    assert min(under) >= 3
    # Turned in plan, boards push on the same stones at as many places.
    upright = build(scene_from({"name": "sail", "elements": {"v": sail | {"turn": 0}}, "supports": ["v.springer"]}))
    assert len(props) == len(centring(upright, upright.free))
