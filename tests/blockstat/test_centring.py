"""What a boarded centring carries: soffits all over, and nothing of what is put in later."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_bearings import C_BED, L_BED, upright
from typer.testing import CliRunner

from blockstat import Assembly, Block, InputError, assess_stages, box, build, centring, falsework, scene_from
from blockstat.cli.commands import app
from building_sites import arch

#: Vaults of which some course fell while each stone had one prop, in the middle of one soffit.
VAULTS = {
    "groin": {"kind": "groin", "spans": [3.0, 3.0], "thickness": 0.25, "voussoirs": 9, "brick": 0.6},
    "pointed groin": {"kind": "groin", "spans": [3.0, 3.0], "thickness": 0.25, "voussoirs": 8, "brick": 0.8,
                      "shape": "pointed", "rise": 2.2},
    "groin over a rectangle": {"kind": "groin", "spans": [3.0, 2.0], "thickness": 0.25, "voussoirs": 7, "brick": 1.2},
    "fan": {"kind": "fan", "spans": [4, 4], "rise": 1.6, "thickness": 0.25, "foot": 0.5, "rings": 3, "voussoirs": 2},
    "sail": {"kind": "sail", "spans": [3, 3], "rise": 1.2, "thickness": 0.25, "courses": 5, "voussoirs": 4,
             "supports": ["south", "north"]},
    "freeform": {"kind": "freeform", "height": "1.2*(1-y**2)*(1-0.3*x**2)", "x": [-1, 1], "y": [-1, 1], "courses": 6,
                 "voussoirs": 4, "thickness": 0.2},
}  # fmt: skip


@pytest.mark.parametrize("vault", VAULTS)
def test_a_vault_that_rests_wholly_on_its_centring_stands_after_each_course(vault):
    stage = {"name": "vault", "place": ["v"], "centring": ["v"], "courses": True}
    element = {**VAULTS[vault], "springers": 0.3}
    scene = {"name": vault, "supports": ["v.springer"], "elements": {"v": element}, "stages": [stage]}
    found = assess_stages(build(scene_from(scene)))
    assert {stage.outcome.word for stage in found.stages} == {"stable"}
    assert max(stage.falsework.total for stage in found.stages) > 1e3


def prism(profile):
    """A stone of 1 m depth over a profile in x and z, that touches nothing."""
    n = len(profile)
    corners = [(x, y, z) for y in (0.0, 1.0) for x, z in profile]
    sides = [[k, k + n, (k + 1) % n + n, (k + 1) % n] for k in range(n)]
    stone = Block(corners, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides], "stone")
    ground = box((5.0, 0.0, -1.0), (6.0, 1.0, 0.0), name="ground")
    return Assembly.from_blocks([ground, stone], supports=["ground"], density=1000.0, gravity=(0, 0, -10))


@pytest.mark.parametrize(("left", "right"), [(1.0, 1.0), (1.0, 0.5)], ids=["alike", "steeper"])
def test_two_soffits_of_a_stone_carry_it_as_the_triangle_of_forces_says(left, right):
    """Slopes a and b of the soffits from the level: N_a sin a = N_b sin b, N_a cos a + N_b cos b = w.

    Each soffit has its part of the weight wherever the lines of action meet, which they do within both soffits.
    """
    assembly = prism([(-left, 0.0), (0.0, 1.0), (right, 0.0), (right, 2.0), (-left, 2.0)])
    props = centring(assembly, ["stone"])
    assert len(props) == 8
    found = falsework(assembly, (["stone"], []), props)
    weight, a, b = assembly.mass[1] * 10, np.arctan(1 / left), np.arctan(1 / right)
    one, other = weight * np.sin([b, a]) / np.sin(a + b)
    upward = np.array([prop.direction[2] for prop in props])
    assert found.total == pytest.approx(one + other, rel=1e-6)
    assert found.force @ upward == pytest.approx(weight, rel=1e-6)
    assert found.by_block == {"stone": pytest.approx(one + other, rel=1e-6)}
    assert found.summary()["props"] == [{"block": "stone", "force": pytest.approx(one + other, rel=1e-6)}]


def test_a_stone_bears_anywhere_on_its_soffit_and_its_centring_has_its_weight():
    """The weight of an L is beside the middle of its foot."""
    assembly = prism([(0.0, 0.0), (1.0, 0.0), (1.0, 3.0), (0.7, 3.0), (0.7, 0.5), (0.0, 0.5)])
    found = falsework(assembly, (["stone"], []), centring(assembly, ["stone"]))
    assert found.outcome.word == "held"
    assert found.total == pytest.approx(assembly.mass[1] * 10, rel=1e-6)


def test_no_board_lies_under_a_bed_whose_neighbour_is_not_there_yet():
    """Past the crown the far bed of a stone looks down. The stones slide down the centring: no board stops them there.

    The neighbour may rest on the same centring later, or belong to another stage.
    """
    assembly = arch()
    there = [f"s{k}" for k in range(5)]
    every = [f"s{k}" for k in range(7)]
    props = {name: centring(assembly, blocks, present=there) for name, blocks in (("one", there), ("all", every))}
    for found in props.values():
        assert [prop.block for prop in found] == [stone for stone in there for _ in range(4)]
        radial = np.array([prop.direction for prop in found])
        middle = np.array([assembly.centroid[assembly.names.index(prop.block)] for prop in found]) * [1, 0, 1]
        np.testing.assert_allclose(radial, middle / np.linalg.norm(middle, axis=1)[:, None], atol=1e-9)
        assert falsework(assembly, (there, []), found).outcome.word == "not_held"


def test_blocks_that_are_all_there_have_the_same_props_one_by_one_and_together():
    vault = {"kind": "arch", "span": 2.0, "thickness": 0.3, "depth": 0.5, "voussoirs": 9, "at": [0, 0, 1]}
    piers = {"kind": "pier", "size": [0.3, 0.5], "height": 1.0, "courses": 2, "at": [-1.15, 0, 0]}
    piers |= {"repeat": {"number": 2, "by": [2.3, 0, 0]}}
    assembly = build(scene_from({"name": "gate", "elements": {"vault": vault, "pier": piers}}))
    names = [assembly.names[k] for k in assembly.free][::-1]
    together = centring(assembly, names)
    assert [prop.block for prop in together[::4]] == [name for name in names if "pier" not in name]
    assert together == [prop for name in names for prop in centring(assembly, [name])]


def beam(**more):
    """Three stones of 1 m on a centring between two piers, .5 m of the outer ones on them."""
    across = {"repeat": {"number": 2, "by": [2.5, 0, 0]}}
    elements = {
        "pier": {"kind": "box", "size": [0.5, 0.5, 2], "at": [-1.25, 0, 0], **across},
        "stone": {"kind": "box", "size": [1, 0.5, 0.4], "at": [-1, 0, 2], "repeat": {"number": 3, "by": [1, 0, 0]}},
    }
    stages = [{"name": "piers", "place": ["pier"]}, {"name": "beam", "place": ["stone"], "centring": ["stone"]}]
    stages += [{"name": "infill", "place": [name]} for name in more]
    return assess_stages(build(scene_from({"name": "beam", "elements": {**elements, **more}, "stages": stages})))


def test_an_infill_that_is_built_later_takes_no_room_of_the_centring():
    alone, filled = beam(), beam(infill={"kind": "box", "size": [1, 0.5, 2]})
    assert [stage.outcome.word for stage in alone.stages] == ["stable", "stable"]
    assert [stage.outcome.word for stage in filled.stages] == ["stable", "stable", "stable"]
    assert filled.stages[1].unpropped == ()
    assert filled.stages[1].falsework.props == alone.stages[1].falsework.props
    assert filled.stages[1].falsework.total == pytest.approx(alone.stages[1].falsework.total, rel=1e-6)


def test_a_ring_on_its_centring_is_judged_as_if_no_ring_came_below_it_later():
    def ring(span):
        return {"kind": "arch", "span": span, "thickness": 0.3, "depth": 0.5, "voussoirs": 9}

    first = {"name": "outer", "place": ["outer"], "centring": ["outer"], "courses": True}
    then = {"name": "inner", "place": ["inner"], "centring": ["inner"]}
    one = {"name": "one", "elements": {"outer": ring(2.6)}, "stages": [first]}
    two = {"name": "two", "elements": {"outer": ring(2.6), "inner": ring(2.0)}, "stages": [first, then]}
    alone, both = (assess_stages(build(scene_from(scene))) for scene in (one, two))
    assert {stage.outcome.word for stage in both.stages} == {"stable"}
    totals = [[stage.falsework.total for stage in found.stages[:5]] for found in (alone, both)]
    assert totals[1] == pytest.approx(totals[0], rel=1e-6, abs=1e-3)
    assert totals[0][3] > 1e3


ABSENT = """
[elements.p]
kind = "pier"
size = [0.6, 0.6]
height = 1
courses = 2
[elements.q]
kind = "pier"
size = [0.6, 0.6]
height = 1
courses = 2
at = [2, 0, 0]
present = false
[[stages]]
name = "a"
place = ["p"]
[[stages]]
name = "b"
place = ["q", "q.pier"]
centring = ["q"]
courses = true
"""


def test_a_stage_puts_in_nothing_of_what_is_not_present(tmp_path):
    path = tmp_path / "piers.toml"
    path.write_text(ABSENT)
    rows = json.loads(CliRunner().invoke(app, ["sequence", str(path), "--stages", "--json"]).stdout)["stages"]
    assert [(row["name"], row["blocks"], row["verdict"]) for row in rows] == [("a", 2, "stable"), ("b", 2, "stable")]
    path.write_text(ABSENT.replace("present = false", ""))
    rows = json.loads(CliRunner().invoke(app, ["sequence", str(path), "--stages", "--json"]).stdout)["stages"]
    assert [row["blocks"] for row in rows] == [2, 3, 4]
    path.write_text(ABSENT.replace('["q", "q.pier"]', '["r"]'))
    said = CliRunner().invoke(app, ["sequence", str(path), "--stages"])
    assert isinstance(said.exception, InputError)
    assert 'stages.1 ("b"): no group "r"; groups are: ground, p.pier' in str(said.exception)


def test_stages_of_an_assembly_say_which_groups_may_be_absent(tmp_path):
    path = tmp_path / "piers.json"
    scene = tmp_path / "piers.toml"
    scene.write_text(ABSENT)
    assert CliRunner().invoke(app, ["build", str(scene), "-o", str(path)]).exit_code == 0
    assert json.loads(path.read_text())["absent"] == ["q", "q.pier"]
    assert CliRunner().invoke(app, ["sequence", str(path), "--stages"]).exit_code == 0
    asm = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), name="b", group="b")], supports=["b"])
    for absent, words in ((["q"], 'no group "p"; groups are: b'), ("p", "metadata: \"absent\" is 'p'; it is a list")):
        with pytest.raises(InputError, match=words):
            assess_stages(asm.with_(metadata={"stages": [{"name": "a", "place": ["p"]}], "absent": absent}))


TURNS = [np.eye(3), *Rotation.random(11, random_state=3).as_matrix()]
UTM = np.array([500000.0, 4600000.0, 300.0])


def turned(assembly, rotation, origin=0.0):
    return assembly.with_(vertices=assembly.vertices @ rotation.T + origin, gravity=rotation @ assembly.gravity)


def shelf(end):
    """A slab with .8 m of its 1.2 m on a shelf that reaches 1 m beyond its pier, and -end m back on it."""
    blocks = [box((-2, 0, -2), (0, 1, -1), name="pier"), box((end, 0, -1), (1, 1, -0.8), name="shelf")]
    blocks += [box((0.2, 0, -0.8), (1.4, 1, 0), name="slab")]
    return Assembly.from_blocks(blocks, supports=["pier"], density=1000.0, gravity=(0, 0, -10), friction=0.7)


@pytest.mark.parametrize("end", [-1.1, -1.3])
def test_boards_carry_a_slab_beside_its_shelf_and_not_under_it(end):
    """The shelf tips about the edge of the pier under a moment M, of its own weight about x = 0.

    The slab of weight W, with its centroid at x = .8, is on it at x >= .2 and on boards at x >= 1. So the shelf has a
    moment of W / 20 at least, from W / 4 at x = .2. It carries M / .2 at most, and the boards what is left of W.
    """
    scene = shelf(end)
    weight, moment = scene.mass[2] * 10, -scene.mass[1] * 10 * scene.centroid[1, 0]
    for rotation in TURNS:
        found = falsework(asm := turned(scene, rotation), (["shelf", "slab"], []), centring(asm, ["slab"]))
        assert found.outcome.word == ("held" if moment > weight / 20 else "not_held")
        if moment > weight / 20:
            assert found.total == pytest.approx(weight - moment / 0.2, rel=1e-4)


BESIDE = {
    "a slab beside a notch": (L_BED, (1, 0.2), (3, 1.4), [(1, 1), (3, 1), (3, 1.4), (1, 1.4)]),
    "a slab over a notch between two sides": (L_BED, (0, 0), (3, 3), [(1, 1), (3, 1), (3, 3), (1, 3)]),
    "a slab over a notch between three sides": (C_BED, (0, 0), (5, 4), [(1, 1), (4, 1), (4, 4), (1, 4)]),
    "a slab that is all on its bed": (L_BED, (0, 0), (1, 3), []),
}


@pytest.mark.parametrize("case", BESIDE)
def test_boards_reach_as_far_as_a_bed_leaves_room(case):
    """Wherever the slab lies, its sides are upright, and no strip is left along the edges that it shares with its bed.

    What is cut off leaves a stub of a twentieth of its width, which is a thousandth of the slab, towards either side.
    """
    bed, low, high, wanted = BESIDE[case]
    blocks = [upright(bed, -0.5, 0, "bed"), box((*low, 0), (*high, 0.3), name="slab")]
    scene = Assembly.from_blocks(blocks, supports=["bed"])
    for rotation in TURNS:
        for origin in (0 * UTM, UTM):
            props = centring(turned(scene, rotation, origin), ["slab"])
            points = np.array([np.array(prop.point) - origin for prop in props]).reshape(-1, 3) @ rotation
            assert len(points) == len(wanted)
            for corner in wanted:
                away = np.linalg.norm(points - (*corner, 0), axis=1)
                assert away.min() < np.sqrt(2) * 1e-3 / 20 * scene.size[1]
