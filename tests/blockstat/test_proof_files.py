"""Proof files: what a checker of the standard library accepts, and what it does not."""

import ast
import copy
import importlib.util
import json
import random
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from math import atan, degrees

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Block,
    InputError,
    JointLaw,
    LoadOutcome,
    Outcome,
    Tie,
    assess,
    box,
    glued,
    limit_load,
    prove,
    prove_limit,
    prove_verdict,
    write,
)
from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import GAP
from blockstat.proof.parallel import parallel_forces
from blockstat.proof.structure import structure, with_normals_of_faces
from evidence.scenes.small import arch, pulled_slab, stack, trilith
from point_bodies import FLOOR, crossed_keels, ladder, moved, octahedron_in_a_corner, prism_in_a_groove, tetrahedron

CORRUPTED = 1000
#: What is corrupted: a digit of a force or a velocity, of a place, of a corner, of a friction or a strength; a contact,
#: a bond or a tie.
KINDS = ("value", "point", "vertex", "law", "remove", "add")
#: More friction or strength is another problem with a valid proof. These are not valid whatever the hash says.
WRONG = ("value", "point", "vertex", "remove", "add")


@pytest.fixture(scope="module")
def script(request):
    return request.config.rootpath / "extras" / "check_proof.py"


@pytest.fixture(scope="module")
def checker(script):
    spec = importlib.util.spec_from_file_location("check_proof", script)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def bounds(said):
    """Multipliers of a limit load, as the checker prints them."""
    assert [line.split(" ")[:2] for line in said[:2]] == [["PROVED", "stable"], ["PROVED", "unstable"]]
    return tuple(float(line.split(" ")[3]) for line in said[:2])


def hashed(checker, content):
    """The same file with the hashes of what it says, as somebody would make them who wants it to pass."""
    sums = {}
    for part in ("data", "proof"):
        text = json.dumps(content[part], sort_keys=True, separators=(",", ":"))
        sums[part] = checker.hashlib.sha256(text.encode()).hexdigest()
    return content | {"sha256": sums}


def cube_by_hand(force="2.4525", **contact):
    """A cube of 1 kg on the ground, written down by hand: a quarter of 9.81 N at each corner."""
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]

    def solid(low, high, fixed):
        vertices = [[str(x), str(y), str(z)] for z in (low, high) for x, y in square]
        return {"name": str(high), "fixed": fixed, "density": "1", "vertices": vertices, "faces": faces}

    contacts = [
        {
            "blocks": [0, 1],
            "on": [[1], [0]],
            "point": [str(x), str(y), "0"],
            "normal": ["0", "0", "1"],
            "friction": "0.5",
        }
        | contact
        for x, y in square
    ]
    data = {"gravity": ["0", "0", "-9.81"], "distance": "0", "sine": "0", "contacts": contacts}
    data["blocks"] = [solid(-1, 0, True), solid(0, 1, False)]
    return {"data": data, "proof": {"forces": [["0", "0", force]] * 4}}


def test_the_checker_is_short_and_reads_nothing_of_ours(script):
    source = script.read_text()
    assert len(source.splitlines()) < 400
    names = {
        alias.name if isinstance(node, ast.Import) else node.module
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    assert names <= sys.stdlib_module_names


def test_a_proof_written_by_hand_is_accepted(checker):
    assert checker.check(hashed(checker, cube_by_hand()))[0] == "PROVED stable"


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        (cube_by_hand("2.4526"), "not balanced"),
        (cube_by_hand(blocks=[1, 0], on=[[0], [1]]), "not that of its face"),
        (cube_by_hand(normal=["0", "0", "-1"]), "not that of its face"),
        (cube_by_hand(normal=["0", "0", "2"]), "no normal"),
        (cube_by_hand(normal=["0.6", "0", "0.8"]), "not that of its face"),
        (cube_by_hand(point=["0", "0", "0.001"]), "off its face"),
        (cube_by_hand(point=["-0.001", "0", "0"]), "beside its face"),
        (cube_by_hand(on=[[1], [2]]), "not that of its face"),
        (cube_by_hand(most="2"), "outside its cone"),
        (cube_by_hand(least="3"), "outside its cone"),
        (cube_by_hand(friction="-1"), "law"),
    ],
)
def test_what_is_wrong_is_named(checker, wrong, reason):
    with pytest.raises(ValueError, match=reason):
        checker.check(hashed(checker, wrong))


def test_a_force_at_the_edge_of_its_cone_passes_and_one_beyond_it_does_not(checker):
    law = {"normal": ["0", "0", "1"], "friction": "3/4"}
    up = (Fraction(0), Fraction(0), Fraction(1))
    edge = (Fraction(3, 20) * 3, Fraction(3, 20) * 4, Fraction(1))  # 5 x 3/20 = 3/4
    assert checker.admits(law, up, edge)
    assert not checker.admits(law, up, (edge[0], edge[1] + Fraction(1, 10**40), edge[2]))
    assert not checker.admits(law, up, tuple(-x for x in edge))


@pytest.mark.parametrize(("friction", "word"), [(0.35, "unstable"), (0.37, "stable")])
def test_a_block_on_a_slope_of_twenty_degrees(checker, friction, word):
    slope = [9.81 * np.sin(np.radians(20)), 0, -9.81 * np.cos(np.radians(20))]
    blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 0.5))]
    proof = prove(Assembly.from_blocks(blocks, supports=[0], friction=friction), gravity=slope)
    assert proof.outcome.word == word
    assert checker.check(proof.content)[0] == f"PROVED {word}"
    assert not proof.bounded


def test_a_block_in_the_air_falls(checker):
    blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 5), (1, 1, 6))]
    assert checker.check(prove(Assembly.from_blocks(blocks, supports=[0])).content)[0] == "PROVED unstable"


@pytest.mark.parametrize(
    ("scene", "load", "exact"),
    [
        (stack(1, 1.0, 2.0), (1, 0, 0), 0.5),
        (stack(5, 1.0, 0.5), (1, 0, 0), 0.4),
        (trilith(), (1, 0, 0), 0.25),
        (trilith(1e6), (1, 0, 0), 0.25),
        (*pulled_slab(), 11 / 6),
    ],
)
def test_a_closed_form_lies_in_the_exact_bracket(checker, scene, load, exact):
    lower, upper = bounds(checker.check(prove(scene, load).content))
    assert lower <= exact * (1 + 1e-12)
    assert upper >= exact * (1 - 1e-12)
    assert upper - lower < 1e-7 * exact


def test_infinite_friction_is_proved_for_bounded_forces(checker):
    proof = prove(arch(20, 0.2).with_(friction=np.inf), (1, 0, 0))
    said = checker.check(proof.content)
    lower, upper = bounds(said)
    assert lower == pytest.approx(0.28564581, abs=1e-7)
    assert upper == pytest.approx(0.28564581, abs=1e-7)
    assert proof.bounded
    assert "1000000 dead loads" in said[1]


@pytest.mark.parametrize(
    ("blocks", "friction"),
    [
        ([FLOOR, moved(tetrahedron(0.1))], 0.5),
        (crossed_keels()[0], 1.0),
        (ladder(60.0), 0.3),
        (prism_in_a_groove(), 0.5),
        (octahedron_in_a_corner()[0], 0.3),
    ],
)
def test_edges_corners_and_crossings_are_contacts_of_a_proof(checker, blocks, friction):
    free = len(blocks) - 1
    scene = Assembly.from_blocks(blocks, supports=range(free), friction=friction, gravity=(0, 0, -1), density=1.0)
    proof = prove(scene)
    assert checker.check(proof.content)[0] == f"PROVED {proof.outcome.word}"
    places = {len(on) for contact in proof.content["data"]["contacts"] for on in contact["on"]}
    assert 2 in places  # an edge, or a corner given twice


def test_joint_laws_are_part_of_the_problem(checker):
    """A slab that is pulled with cohesion: mu W + c A."""
    law = JointLaw(("stone", "ground"), cohesion=0.7, tension=0.3)
    ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    stone = box((-1, -0.5, 0), (1, 0.5, 0.5), name="stone", group="stone")
    options = {"density": 2.0, "friction": 0.5, "gravity": (0, 0, -0.5)}
    scene = Assembly.from_blocks([ground, stone], supports=[0], joints=[law], **options)
    pull = np.array([np.zeros(6), [1, 0, 0, 0, -0.25, 0]])
    lower, upper = bounds(checker.check(prove(scene, pull).content))
    assert lower == pytest.approx(0.5 * 1.0 + 0.7 * 2.0, rel=1e-7)
    assert upper == pytest.approx(lower, rel=1e-7)


def bonded_beam(moment):
    """A beam .5 x .5 x 2 of density 1 glued to a wall at one end."""
    wall = box((-1, 0, -1), (0, 0.5, 1), name="wall", group="wall")
    beam = box((0, 0, -0.25), (2.0, 0.5, 0.25), name="beam", group="beam")
    glue = JointLaw(("wall", "beam"), bond=3.0, bond_moment=moment)
    options = {"joints": [glue], "friction": 5.0, "gravity": (0, 0, -1e-3), "density": 1.0}
    return Assembly.from_blocks([wall, beam], supports=[0], **options)


@pytest.mark.parametrize(("moment", "exact"), [(0.0, 1.5), (0.4, 2.3)])
def test_a_bond_at_the_centre_of_a_joint_is_part_of_the_problem(checker, moment, exact):
    """A cantilever: (M + F a / 2) / (W L / 2)."""
    said = checker.check(prove(bonded_beam(moment), (0, 0, -1)).content)
    lower, upper = (1e-3 * (1 + bound) for bound in bounds(said))
    assert lower <= exact <= upper
    assert upper - lower < 1e-7 * exact
    assert "6 contacts (2 of bonds and ties)" in said[2]


def test_each_strength_of_a_bond_has_its_limit(checker):
    """A lamp of weight 1 below a roof, without friction: it hangs by the tension, and pushed and turned as it hangs, it
    shears by F, and twists by M."""
    roof = box((-1, -1, 1), (2, 2, 2), name="roof", group="roof")
    lamp = box((0, 0, 0), (1, 1, 1), name="lamp", group="lamp")
    glue = JointLaw(("roof", "lamp"), friction=0.0, bond=3.0, bond_moment=0.5)
    options = {"gravity": (0, 0, -1.0), "density": 1.0, "joints": [glue]}
    scene = Assembly.from_blocks([roof, lamp], supports=[0], **options)
    for wrench, exact in (([0, 0, -1, 0, 0, 0], 2.0), ([0.6, 0.8, 0, -0.4, 0.3, 0], 3.0), ([0, 0, 0, 0, 0, -1], 0.5)):
        lower, upper = bounds(checker.check(prove(scene, np.array([[0] * 6, wrench])).content))
        assert lower <= exact * (1 + 1e-12)
        assert upper >= exact * (1 - 1e-12)
        assert upper - lower < 1e-7


def tied_block(**tie):
    """A block 1 x 1 x 2 of weight 2 that a tie holds on the side away from the toe x = 1, or towards it."""
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    anchored = Tie(("ground", "block"), ((-0.5, 0.5, -0.5), (0, 0.5, 1.5)), **tie)
    options = {"ties": [anchored], "friction": 2.0, "density": 1.0, "gravity": (0, 0, -1.0)}
    return Assembly.from_blocks(blocks, supports=[0], **options)


#: Moment of a unit of tension about the toe: (1.5 x .5 + 2 x 1) / |(.5, 2)|, over W h / 2 = 2; about the heel 1.5 x .5.
ABOUT_TOE, ABOUT_HEEL = 2.75 / np.hypot(0.5, 2.0) / 2.0, 0.75 / np.hypot(0.5, 2.0) / 2.0


@pytest.mark.parametrize(
    ("tie", "side", "exact"),
    [
        ({"greatest": 0.3}, 1, 0.5 + 0.3 * ABOUT_TOE),
        ({"greatest": 0.3}, -1, 0.5),
        ({"least": 0.1, "greatest": 0.3}, 1, 0.5 + 0.3 * ABOUT_TOE),
        ({"least": 0.1, "greatest": 0.3}, -1, 0.5 - 0.1 * ABOUT_HEEL),
        ({"least": 0.2, "greatest": 0.2}, 1, 0.5 + 0.2 * ABOUT_TOE),
        ({"greatest": 0.3, "strut": True}, 1, 0.5),
        ({"greatest": 0.3, "strut": True}, -1, 0.5 + 0.3 * ABOUT_HEEL),
    ],
)
def test_a_tie_is_part_of_the_problem(checker, tie, side, exact):
    """Moments about the toe, or about the heel when pushed the other way."""
    lower, upper = bounds(checker.check(prove(tied_block(**tie), (side, 0, 0)).content))
    assert lower <= exact * (1 + 1e-12)
    assert upper >= exact * (1 - 1e-12)
    assert upper - lower < 1e-7


def test_a_tie_without_limit_is_never_the_one_that_yields(checker):
    proof = prove(tied_block(), (1, 0, 0))
    assert checker.check(proof.content)[0].startswith("PROVED stable at")
    assert "motion" not in proof.content["proof"]
    fallen = prove(tied_block(), (-1, 0, 0))  # about the heel it slackens
    lower, upper = bounds(checker.check(fallen.content))
    assert lower <= 0.5 <= upper
    assert not fallen.bounded


def test_a_tie_without_limit_is_in_the_bracket(checker):
    """Two cubes that are tied turn about their toe, 1 / 2; and an arch carries more with its haunches tied."""
    tower = stack(2, 1.0, 1.0)
    tower = tower.with_(ties=[Tie((1, 2), ((0, 0.5, 0.5), (0, 0.5, 1.5)))])
    proof = prove(tower, (1, 0, 0))
    lower, upper = bounds(checker.check(proof.content))
    assert lower <= 0.5 * (1 + 1e-12)
    assert 0.5 * (1 - 1e-12) <= upper < 0.5 + 1e-7
    assert not proof.bounded
    scene = arch(12, 0.12)
    ends = [scene.centroid[k] for k in (1, 11)]
    tied = scene.with_(ties=[Tie((1, 11), tuple(tuple(map(float, end)) for end in ends))])
    found = limit_load(tied, (1, 0, 0))
    lower, upper = bounds(checker.check(prove(tied, (1, 0, 0)).content))
    assert found.lower > limit_load(scene, (1, 0, 0)).lower
    assert (lower, upper) == pytest.approx((found.lower, found.upper), rel=1e-6)


def changed(content, **what):
    """A copy with other values in the last contact."""
    wrong = copy.deepcopy(content)
    wrong["data"]["contacts"][-1] |= what
    return wrong


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ({"shear": "-3"}, "a law is none"),
        ({"least": "4", "most": "3"}, "a law is none"),
        ({"friction": "0.5"}, "a law is none"),
        ({"shear": "0.01"}, "outside its cone"),
        ({"least": "0", "most": "0.4", "shear": "0"}, "outside its cone"),
        ({"point": ["0.001", "0.25", "0"]}, "off its face"),
        ({"point": ["0", "0.6", "0"]}, "beside its face"),
        ({"normal": ["0.6", "0", "0.8"]}, "not that of its face"),
        ({"couple": True, "ends": [["0", "0.25", "0"]] * 2}, "a law is none"),
    ],
)
def test_what_is_wrong_with_a_bond_is_named(checker, what, reason):
    content = prove(bonded_beam(0.4).with_(gravity=(0.1, 0.2, -1.9))).content
    assert checker.check(content)[0] == "PROVED stable"
    with pytest.raises(ValueError, match=reason):
        checker.check(hashed(checker, changed(content, **what)))


@pytest.mark.parametrize(
    ("what", "reason"),
    [
        ({"friction": "0"}, "a law is none"),
        ({"couple": True}, "not of the format"),
        ({"least": "-0.1"}, "a law is none"),
        ({"ends": [["-0.5", "0.5", "-0.5"], ["0", "0.5", "1.6"]]}, "not along its ends"),
        ({"ends": [["0", "0.5", "1.5"]] * 2}, "not along its ends"),
        ({"ends": [["-1.5", "0.5", "-4.5"], ["-0.5", "0.5", "-0.5"]]}, "ends nowhere"),
        ({"most": "0.01"}, "outside its cone"),
    ],
)
def test_what_is_wrong_with_a_tie_is_named(checker, what, reason):
    content = prove(tied_block(greatest=1.0), gravity=(0.7, 0, -1.0)).content
    assert checker.check(content)[0] == "PROVED stable"
    with pytest.raises(ValueError, match=reason):
        checker.check(hashed(checker, changed(content, **what)))


def test_a_motion_that_a_bond_or_a_tie_resists_proves_nothing(checker):
    """More strength than the motion was made for."""
    for scene in (bonded_beam(0.4).with_(gravity=(0, 0, -2.5)), tied_block(greatest=0.1).with_(gravity=(0.7, 0, -1.0))):
        content = prove(scene).content
        assert checker.check(content)[0] == "PROVED unstable"
        for contact in content["data"]["contacts"]:
            contact |= {key: str(3 * Fraction(contact[key])) for key in ("least", "most", "shear") if key in contact}
        with pytest.raises(ValueError, match="do not drive the motion"):
            checker.check(hashed(checker, content))


def test_a_motion_into_the_ground_does_not_drive_against_the_cohesion_of_glue(checker):
    """The weight is W and so is its work; contact forces of W in all resist, which are fewer than two dead loads."""
    blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (0.1, 0.1, 0.1))]
    content = prove(glued(Assembly.from_blocks(blocks, supports=[0]), 1e5)).content
    down = {"motion": [["0"] * 6, ["0", "0", "-1", "0", "0", "0"]], "bound": "2"}
    with pytest.raises(ValueError, match="do not drive the motion"):
        checker.check(hashed(checker, content | {"proof": down}))


def test_far_from_the_origin_nothing_changes(checker):
    near = arch(12, 0.15)
    far = near.with_(vertices=near.vertices + [5e5, 5e6, 100.0])
    one, two = (bounds(checker.check(prove(scene, (1, 0, 0)).content)) for scene in (near, far))
    np.testing.assert_allclose(one, two, rtol=1e-7)


def test_a_stack_balanced_exactly_on_an_edge_has_an_exact_proof(checker):
    blocks = [box((-1, -1, -1), (1, 1, 0)), box((0.5, -1, 0), (1.5, 1, 1))]
    scene = Assembly.from_blocks(blocks, supports=[0], density=1000.0)
    assert checker.check(prove(scene).content)[0] == "PROVED stable"


def prism(profile, **named):
    """A block between y = 0 and 1 with this outline, counter-clockwise seen against y."""
    n = len(profile)
    sides = [[(i + 1) % n, i, i + n, (i + 1) % n + n] for i in range(n)]
    corners = [(x, y, z) for y in (0, 1) for x, z in profile]
    return Block(corners, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides], **named)


def wedge_and_slab(friction):
    """A slab that rests on a wedge of slope 3 : 4, which stands on the ground."""
    wedge, slab = [(0, 0), (4, 0), (4, 3)], [(0.8, 0.6), (3.2, 2.4), (2.9, 2.8), (0.5, 1.0)]
    blocks = [box((-2, -1, -1), (6, 2, 0)), prism(wedge), prism(slab)]
    return Assembly.from_blocks(blocks, supports=[0], friction=friction)


def test_at_the_limit_of_friction_exactly_forces_along_the_weight_prove_that_it_stands(checker):
    """tan = 3 / 4, and a friction of .75 to the last digit."""
    assert checker.check(prove(wedge_and_slab(0.75)).content)[0] == "PROVED stable"
    with pytest.raises(InputError, match=r"no exact proof|undecided"):
        prove(wedge_and_slab(np.nextafter(0.75, 0)))


def test_without_friction_what_stands_on_a_level_face_is_proved_to_stand(checker):
    """Forces along the weight need none."""
    for low, high in (((0, 0, 0), (1, 1, 1)), ((0.1, 0.2, 0), (1.3, 0.7, 0.9))):
        ground = box((-5, -5, -1), (5, 5, 0))
        scene = Assembly.from_blocks([ground, box(low, high)], supports=[0], friction=0.0)
        assert checker.check(prove(scene).content)[0] == "PROVED stable"


def test_what_cannot_be_proved_is_said():
    """On a slope of .6 gravity and friction are decimals; here the friction is too small in the last of them."""
    blocks = [box((-1, -1, -1), (2, 2, 0), name="a"), box((0, 0, 0), (1, 1, 1), name="b")]
    slope = Assembly.from_blocks(blocks, supports=[0], gravity=(0.6, 0, -1.0), friction=np.nextafter(0.6, 0))
    with pytest.raises(InputError, match=r"no exact proof|undecided"):
        prove(slope)
    table = prism([(0, 0), (1, 0), (1, 1), (4, 1), (4, 0), (5, 0), (5, 2), (0, 2)], name="table", group="table")
    ground = box((-1, -1, -1), (6, 2, 0), name="ground", group="ground")
    glue = JointLaw(("ground", "table"), bond=1.0, bond_moment=1.0)
    with pytest.raises(InputError, match='bond of "ground" and "table" is at the centre of several patches'):
        prove(Assembly.from_blocks([ground, table], supports=[0], joints=[glue]))


def test_the_file_holds_the_bracket_of_the_limit_load(checker):
    scene = arch(15, 0.2)
    found = limit_load(scene, (1, 0, 0))
    lower, upper = bounds(checker.check(prove(scene, (1, 0, 0)).content))
    assert lower == pytest.approx(found.lower, rel=1e-7)
    assert upper == pytest.approx(found.upper, rel=1e-7)


def test_the_command_writes_what_the_checker_accepts(tmp_path, script):
    stones, proof = write(stack(3), tmp_path / "stones.json"), tmp_path / "proof.json"
    code = "from blockstat.cli.commands import main; main()"

    def run(*arguments):
        return subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True)

    told = run("-c", code, "prove", stones, "-o", proof, "--tilt", "x,18", "--json")
    assert told.returncode == 0, told.stderr
    assert json.loads(told.stdout)["outcome"] == "stable"
    answer = run(script, proof)
    assert (answer.returncode, answer.stdout.splitlines()[0]) == (0, "PROVED stable")
    assert run("-c", code, "prove", stones, "-o", proof, "--tilt", f"x,{degrees(atan(1 / 3)) + 0.01}").returncode == 0
    answer = run(script, proof)
    assert (answer.returncode, answer.stdout.splitlines()[0]) == (0, "PROVED unstable")
    proof.write_text(proof.read_text().replace("density", "destiny", 1))
    answer = run(script, proof)
    assert answer.returncode == 1
    assert answer.stdout.startswith("REJECTED: ")
    assert run("-c", code, "prove", tmp_path / "none.json", "-o", proof).returncode == 2


def texts(part):
    """The lists and dictionaries, with the places in them that hold a number as text."""
    items = part.items() if isinstance(part, dict) else enumerate(part)
    for key, value in list(items):
        if isinstance(value, dict | list):
            yield from texts(value)
        elif isinstance(value, str) and key != "name" and value[-1:].isdigit():
            yield part, key


def change_digit(rng, holder, key):
    """Another digit in place of one of a number."""
    value = holder[key]
    place = rng.choice([i for i, sign in enumerate(value) if sign.isdigit()])
    digit = rng.choice([d for d in "0123456789" if d != value[place]])
    holder[key] = value[:place] + digit + value[place + 1 :]


def corrupted(content, rng, kind):
    """A copy with one digit of a number changed, or a contact removed or added."""
    wrong = copy.deepcopy(content)
    contacts, proof = wrong["data"]["contacts"], wrong["proof"]
    values = proof.get("forces") or proof["motion"]
    if kind in ("remove", "add"):
        i = rng.randrange(len(contacts))
        for items in (contacts, proof["forces"]) if "forces" in proof else (contacts,):
            if kind == "remove":
                del items[i]
            else:
                items.append(copy.deepcopy(items[i]))
        return wrong
    blocks = [block["vertices"] for block in wrong["data"]["blocks"] if not block["fixed"]]
    points = [c["ends"] if "ends" in c else c["point"] for c in contacts]
    laws = [(c, key) for c in contacts for key in ("friction", "shear", "most") if key in c]
    part = {"value": values, "point": points, "vertex": blocks, "law": []}[kind]
    places = list(texts(part)) or laws
    change_digit(rng, *rng.choice(places))
    return wrong


@pytest.fixture(scope="module")
def proofs():
    """Stable, two with a bond and a tie, and unstable: in every digit of forces or motions something can be wrong."""
    tilted = stack(3).with_(gravity=np.array([3.0, 0.5, -9.81]))
    glued = bonded_beam(0.4).with_(gravity=np.array([0.1, 0.2, -1.9]))
    tied = tied_block(greatest=1.0).with_(gravity=np.array([0.7, 0.1, -1.0]))
    fallen = stack(3).with_(gravity=np.array([4.0, 0.5, -9.81]))
    return [prove(scene).content for scene in (tilted, arch(5, 0.25), glued, tied, fallen)]


def test_every_corrupted_file_is_rejected(checker, proofs):
    rng = random.Random(26)
    for trial in range(CORRUPTED):
        with pytest.raises(ValueError, match="hash"):
            checker.check(corrupted(proofs[trial % len(proofs)], rng, KINDS[trial % len(KINDS)]))


@pytest.mark.parametrize("trials", [100, pytest.param(CORRUPTED, marks=pytest.mark.slow)])
def test_new_hashes_do_not_make_a_wrong_proof_right(checker, proofs, trials):
    """Forces balance exactly or not at all: every digit of a force, a contact point and a free block counts."""
    rng = random.Random(trials)
    for trial in range(trials):
        content = proofs[trial % 4]
        wrong = corrupted(content, rng, WRONG[trial % len(WRONG)])
        if same_numbers(wrong, content):  # 0 and -0
            continue
        with pytest.raises((ValueError, ZeroDivisionError)):
            checker.check(hashed(checker, wrong))


def same_numbers(one, other):
    """Whether two files say the same."""
    values = [[holder[key] for part in ("data", "proof") for holder, key in texts(file[part])] for file in (one, other)]
    return all(a == b or ("/0" not in a and Fraction(a) == Fraction(b)) for a, b in zip(*values, strict=False)) and (
        len(values[0]) == len(values[1])
    )


@pytest.mark.parametrize("friction", ["0.2", "0.05", "0"])
def test_less_friction_than_the_forces_need_is_rejected(checker, friction):
    tilted = stack(3).with_(gravity=np.array([3.0, 0.5, -9.81]))
    content = prove(tilted).content
    for contact in content["data"]["contacts"]:
        contact["friction"] = friction
    with pytest.raises(ValueError, match="outside its cone"):
        checker.check(hashed(checker, content))


def test_a_motion_that_closes_a_contact_is_rejected(checker, proofs):
    content = copy.deepcopy(proofs[-1])
    down = ["0", "0", "-1", "0", "0", "0"]
    content["proof"]["motion"] = [["0"] * 6, *[down] * 3]
    with pytest.raises(ValueError, match="do not drive the motion"):
        checker.check(hashed(checker, content))
    content["proof"]["bound"] = "1000000"
    with pytest.raises(ValueError, match="do not drive the motion"):
        checker.check(hashed(checker, content))
    up = ["0", "0", "1", "0", "0", "0"]
    content["proof"]["motion"] = [["0"] * 6, *[up] * 3]
    with pytest.raises(ValueError, match="do not drive the motion"):
        checker.check(hashed(checker, content))
    content["proof"]["motion"] = [up, *[up] * 3]
    with pytest.raises(ValueError, match="a fixed block moves"):
        checker.check(hashed(checker, content))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::blockstat.errors.InputWarning")
def test_every_shared_case_that_is_decided_has_a_proof(cases, checker):
    from blockstat import read

    missing = set()
    for path in sorted([*cases.glob("*.json"), *cases.glob("rubble/*.json")]):
        if path.stem in ("expected", "contacts"):
            continue
        verdict = assess(read(path))
        if verdict.outcome is Outcome.UNDECIDED:
            continue
        try:
            said = checker.check(prove_verdict(verdict).content)
        except InputError:
            missing.add(path.stem)
            continue
        assert said[0] == f"PROVED {verdict.outcome.word}"
    assert not missing


SLOPE = (0.5, 0.0, -1.0)


def test_a_proof_says_that_it_is_bounded_only_if_it_is():
    sticky = prove(arch(20, 0.2).with_(friction=np.inf), (1, 0, 0))
    assert "The motion is not exact: it holds for contact forces of up to 1e+06 dead loads." in sticky.explain()
    assert sticky.summary()["bounded"]
    plain = prove(stack(1), (1, 0, 0))
    assert "not exact" not in plain.explain()
    assert not plain.summary()["bounded"]


def test_what_is_not_decided_is_not_proved():
    scene = stack(1).with_(name="post")
    undecided = replace(assess(scene), outcome=Outcome.UNDECIDED)
    with pytest.raises(InputError, match='"post" is undecided: there is nothing to prove'):
        prove_verdict(undecided)
    fixed = scene.with_(support=np.ones(scene.n_blocks, dtype=bool))
    with pytest.raises(InputError, match='"post": all blocks are supports; there is nothing to prove'):
        prove_verdict(assess(fixed))
    limit = replace(limit_load(scene, (1, 0, 0)), outcome=LoadOutcome.UNDECIDED)
    with pytest.raises(InputError, match='"post" is undecided under this load: there is nothing to prove'):
        prove_limit(limit, (1, 0, 0))
    # A contact without area that would crush is in the way of the only mechanism.
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, -1, 0), (1, 2, 2), name="post")]
    blocks.append(prism([(1, 1), (2, 0.8), (2, 1.2)], name="wedge"))
    law = JointLaw(("*", "*"), compression=5e6)
    leaning = Assembly.from_blocks(blocks, supports=["ground", "wedge"], joints=[law], name="leaning")
    assert limit_load(leaning, (1, 0, 0)).outcome is LoadOutcome.UNDECIDED
    with pytest.raises(InputError, match='"leaning" is undecided under this load: there is nothing to prove'):
        prove(leaning, (1, 0, 0))


def test_a_verdict_that_is_wrong_is_not_proved():
    """A block that stands, said to rise, to sink, or to fall without a motion; and one that slides, said to stand."""
    scene = stack(1).with_(name="post")
    for speed in (1.0, -1.0, 0.0):
        motion = np.zeros((2, 6))
        motion[1, 2] = speed
        with pytest.raises(InputError, match='"post" falls by less than rounding: there is no exact proof'):
            prove_verdict(replace(assess(scene), outcome=Outcome.UNSTABLE, mechanism=motion))
    slides = assess(scene, gravity=(0.9, 0, -1))
    assert slides.outcome is Outcome.UNSTABLE
    with pytest.raises(InputError, match="is balanced without any reserve: there is no exact proof"):
        prove_verdict(replace(slides, outcome=Outcome.STABLE))


def test_bounds_that_are_wrong_are_not_proved():
    """A cube tips at its weight times 1, slides at .7; no forces carry 1.4, and no motion is none."""
    scene = stack(1, friction=0.7).with_(name="post")
    limit = limit_load(scene, (1, 0, 0))
    assert limit.lower == pytest.approx(0.7, abs=1e-6)
    wrong = 'the bounds of "post" rest on rounding: there is no exact proof'
    with pytest.raises(InputError, match=wrong):
        prove_limit(replace(limit, lower=1.4), (1, 0, 0))
    with pytest.raises(InputError, match=wrong):
        prove_limit(replace(limit, mechanism=0 * limit.mechanism), (1, 0, 0))


def test_a_load_that_nothing_limits_has_forces_and_no_motion(checker):
    told = prove(stack(1), (0, 0, -1))
    assert (told.outcome.word, prove(stack(1), (1, 0, 0)).outcome.word) == ("carried", "limit")
    assert "nothing carries" not in told.explain()
    proof = told.content
    assert "motion" not in proof["proof"]
    assert checker.check(proof)[0].startswith("PROVED stable at")


def test_what_falls_under_its_weight_is_proved_to_fall_whatever_the_load(checker):
    scene = stack(1, friction=0.3).with_(gravity=np.array(SLOPE))
    proof = prove(scene, (0, 1, 0))
    assert proof.outcome.word == "unstable"
    assert "multiplier" not in proof.content["proof"]
    assert checker.check(proof.content)[0] == "PROVED unstable"


def exactly(scene, loads=None):
    problem = pose(scene, friction=None, gravity=None, loads=loads, gap=GAP, interfaces=None)
    return structure(problem, loads, None)


def test_forces_along_the_loads_are_looked_for_only_where_these_are_parallel_and_joints_are_dry():
    scene = stack(2)
    push = np.zeros((3, 6))
    push[2, 0] = 0.1
    law = JointLaw(("*", "*"), cohesion=1.0)

    def found(scene, loads=None):
        return parallel_forces(exactly(scene, loads))

    sizes = found(scene).sum(axis=0)
    assert abs(sizes).tolist() == [0, 0, 3]  # the lower joint carries 2, the upper one 1
    assert found(scene, push) is None
    assert found(scene.with_(joints=[law])) is None
    lifted = np.array([0, 0, 1.0, 0, 0, 0]) * scene.mass[:, None]
    assert found(scene, lifted) is None  # no weight is left, and no direction


def test_normals_of_faces_replace_those_that_lie_on_faces_alone():
    """Edges that cross have no face; all contacts of a cube on the ground have one, and its normal is upright."""
    blocks = crossed_keels()[0]
    free = len(blocks) - 1
    options = {"friction": 1.0, "gravity": (0, 0, -1), "density": 1.0}
    keels = Assembly.from_blocks(blocks, supports=range(free), **options)
    for scene, has_faces in ((keels, False), (stack(1), True)):
        plain = exactly(scene)
        changed = with_normals_of_faces(plain)
        for before, after in zip(plain.data["contacts"], changed.data["contacts"], strict=True):
            on_a_face = any(len(place) == 1 for place in after["on"])
            assert on_a_face == has_faces
            if not on_a_face:
                assert after == before
            else:
                x, y, z = map(Fraction, after["normal"])
                assert (x, y) == (0, 0)
                assert z > 0
        if not has_faces:
            assert (changed.normal == plain.normal).all()
