"""Forged proof files: geometry, numbers and claims that are not what they seem, with hashes that fit."""

import copy
import hashlib
import importlib.util
import json

import pytest

from blockstat import Assembly, Block, box, prove
from blockstat.proof.solids import solids


@pytest.fixture(scope="module")
def checker(request):
    spec = importlib.util.spec_from_file_location("check_proof", request.config.rootpath / "extras" / "check_proof.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
BOTTOM, TOP = 4, 5


def cuboid(low, high):
    return [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])], FACES


def solid(shape, fixed=False, **more):
    vertices = [[str(x) for x in row] for row in shape[0]]
    return {"name": "b", "fixed": fixed, "density": "1", "vertices": vertices, "faces": shape[1]} | more


def contact(point, on, blocks=(0, 1), normal=(0, 0, 1), **law):
    own = {"blocks": list(blocks), "on": on, "point": [str(x) for x in point], "normal": [str(x) for x in normal]}
    return own | (law or {"friction": "0.5"})


def joined(one, two):
    """Two closed surfaces as one block."""
    return one[0] + two[0], one[1] + [[i + len(one[0]) for i in face] for face in two[1]]


def turned(shape):
    """The same surface, inside out."""
    return shape[0], [face[::-1] for face in shape[1]]


def file(blocks, contacts, proof, **more):
    data = {"gravity": ["0", "0", "-10"], "distance": "0.000000001", "sine": "0.000000001"}
    return {"data": data | {"blocks": blocks, "contacts": contacts} | more, "proof": proof}


def said(checker, content):
    """What the checker says of a file, with the hashes of what it says."""
    sums = {k: json.dumps(content[k], sort_keys=True, separators=(",", ":")).encode() for k in ("data", "proof")}
    content = content | {"sha256": {k: hashlib.sha256(own).hexdigest() for k, own in sums.items()}}
    return checker.check(json.loads(json.dumps(content), object_pairs_hook=checker.once))


GROUND = solid(cuboid((-5, -5, -1), (5, 5, 0)), True)
CUBE = cuboid((0, 0, 0), (1, 1, 1))
RAISED = cuboid((0, 0, 1), (1, 1, 2))
FEET = [contact((x, y, 0), [[TOP], [BOTTOM]]) for x in (0, 1) for y in (0, 1)]
QUARTERS = {"forces": [["0", "0", "2.5"]] * 4}
WHOLE = {"forces": [["0", "0", "10"]]}


def standing(**more):
    return file([GROUND, solid(CUBE)], copy.deepcopy(FEET), copy.deepcopy(QUARTERS), **more)


def with_a_fin(fin):
    """A cube a metre above the ground, and a sheet without thickness from there down to it."""
    shape = RAISED[0] + [[0.2, 0.5, 0], [0.8, 0.5, 0], [0.2, 0.5, 1.5], [0.8, 0.5, 1.5]], RAISED[1] + fin
    return file([GROUND, solid(shape)], [contact((0.5, 0.5, 0), [[TOP], [8, 9]])], WHOLE)


def foot_inside_out():
    """A raised cube that rests on the ground by the face of a hole in nothing, which looks down on it."""
    shape = joined(RAISED, turned(cuboid((0.25, 0.25, -0.5), (0.75, 0.75, 0))))
    return file([GROUND, solid(shape)], [contact((0.5, 0.5, 0), [[TOP], [6 + TOP]])], {"forces": [["0", "0", "8.75"]]})


def counterweight():
    """A block that stands on one of its corners, with less than nothing on the other side."""
    shape = joined(cuboid((0, 0, 0), (2, 1, 1)), turned(cuboid((1.5, 0.5, 3), (2.5, 1.5, 4))))
    return file([GROUND, solid(shape)], FEET[:1], WHOLE)


def heavier():
    """A cube that counts twice within."""
    shape = joined(CUBE, cuboid((0.25, 0.25, 0.25), (0.75, 0.75, 0.75)))
    return file([GROUND, solid(shape)], FEET, {"forces": [["0", "0", "2.8125"]] * 4})


def warped():
    """A block on two pillars under high corners of a face that is not flat, 0.4 m below it."""
    vertices = [[0, 0, 1], [1, 0, 0], [1, 1, 1], [0, 1, 0], [0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2]]
    faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    pillars = [cuboid((x, x, -1), (x + 0.1, x + 0.1, 0.5)) for x in (0.05, 0.85)]
    contacts = [contact((x, x, 0.5), [[TOP], [0]], (k, 2)) for k, x in enumerate((0.1, 0.9))]
    blocks = [*(solid(pillar, True) for pillar in pillars), solid((vertices, faces))]
    return file(blocks, contacts, {"forces": [["0", "0", "7.5"]] * 2})


def edge_on_edge():
    """A roof upside down on another: their ridges are one line, and any normal is square to it."""
    ridge = [[0, 0, 0], [0, 1, 0]]
    up = [[-1, 0, 1], [1, 0, 1], [-1, 1, 1], [1, 1, 1]]
    faces = [[0, 2, 3], [1, 5, 4], [0, 1, 4, 2], [0, 3, 5, 1], [2, 4, 5, 3]]
    upper = ridge + [up[0], up[1], up[2], up[3]], [face[::-1] for face in faces]
    lower = ridge + [[x, y, -z] for x, y, z in up], faces
    force = [["0", "0", "5"]] * 2
    contacts = [contact((0, y, 0), [[0, 1], [0, 1]]) for y in (0, 1)]
    return file([solid(lower, True), solid(upper)], contacts, {"forces": force})


def prism(outline, long=1):
    """A solid between y = 0 and a length, whose outline in x and z is counter-clockwise seen along y."""
    n = len(outline)
    sides = [[(i + 1) % n, i, i + n, (i + 1) % n + n] for i in range(n)]
    corners = [[x, y, z] for y in (0, long) for x, z in outline]
    return corners, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides]


def beside(wall, place):
    """A block flush with a wall with a notch, said to hang on the rim of the notch, and to be turned by nothing.

    It is in front of the wall and touches it nowhere else: without friction it falls.
    """
    block = solid(cuboid((-0.5, -1, 0), (0.5, 0, 1)), dead=["0", "0", "0", "-5", "0", "0"])
    hung = contact((0, 0, 0), [place, [BOTTOM]], friction="0")
    return file([solid(prism(wall), True), block], [hung], WHOLE)


NOTCH = [(-3, -2), (-1, -2), (-1, 0), (1, 0), (1, -2), (3, -2), (3, 3), (-3, 3)]
ANGLE = [(-3, -2), (-2, -2), (0, 0), (2, -2), (3, -2), (3, 3), (-3, 3)]


def at_the_rim(shape, place, **more):
    """A block of which the bottom ends where something ends, too, or has its tip: beside it, it falls."""
    block = solid(CUBE, dead=["0", "0", "0", "0", "-5", "0"])
    return file([solid(shape, True), block], [contact((0, 0.5, 0), [place, [BOTTOM]])], WHOLE, **more)


TIP = [[0, 0.5, 0], [-1, 0, -1], [1, 0, -1], [1, 1, -1], [-1, 1, -1]]
PYRAMID = TIP, [[4, 3, 2, 1], [0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]

FLAT = [[8, 9, 10], [9, 11, 10], [9, 8, 11], [8, 10, 11]]  # a tetrahedron without volume

FORGED = {
    "a corner of no face": (
        file(
            [GROUND, solid((RAISED[0] + [[0.5, 0.5, 0]], FACES))],
            [contact((0.5, 0.5, 0), [[TOP], [8, 8]])],
            WHOLE,
        ),
        "of no face",
    ),
    "a sheet of two sides": (
        file(
            [GROUND, solid((RAISED[0] + [[0.2, 0.5, 0], [0.8, 0.5, 0]], FACES + [[0, 8, 9], [9, 8, 0]]))],
            [contact((0.5, 0.5, 0), [[TOP], [8, 9]])],
            WHOLE,
        ),
        "on no solid",
    ),
    "a sheet whose sides are divided otherwise": (with_a_fin(FLAT), "on no solid"),
    "a foot that is inside out": (foot_inside_out(), "inside out"),
    "less than nothing as a counterweight": (counterweight(), "inside out"),
    "a weight that counts twice": (heavier(), "in itself"),
    "the rim of a notch": (beside(NOTCH, [2, 3]), "crosses its contact"),
    "the corner of a notch": (beside(ANGLE, [2, 2]), "crosses its contact"),
    "faces that share a line": (at_the_rim(cuboid((-1, 0, -1), (0, 1, 0)), [TOP]), "rims alone"),
    "faces that share a line exactly": (at_the_rim(cuboid((-1, 0, -1), (0, 1, 0)), [TOP], distance="0"), "rims alone"),
    "a tip on a rim": (at_the_rim(PYRAMID, [0, 0]), "rim of its face"),
    "a face that is not flat": (warped(), "not flat"),
    "an edge along an edge": (edge_on_edge(), "no normal"),
    "a tolerance below zero": (standing(distance="-1"), "tolerance"),
    "a normal of any direction": (standing(sine="1"), "tolerance"),
}


def test_the_file_that_is_forged_is_right(checker):
    assert said(checker, standing())[0] == "PROVED stable"


@pytest.mark.parametrize("name", FORGED)
def test_what_is_forged_is_rejected(checker, name):
    content, reason = FORGED[name]
    with pytest.raises(ValueError, match=reason):
        said(checker, content)


def changed(path, value):
    """The file of a standing cube with another value at a place; ... removes it."""
    content = copy.deepcopy(standing())
    *way, last = path
    holder = content
    for key in way:
        holder = holder[key]
    if value is ...:
        del holder[last]
    else:
        holder[last] = value
    return content


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("data", "blocks", 0, "fixed"), 1),
        (("data", "blocks", 1, "fixed"), None),
        (("data", "blocks", 1, "fixed"), "false"),
        (("data", "blocks", 1, "density"), 1.0),
        (("data", "blocks", 1, "density"), "1e0"),
        (("data", "blocks", 1, "density"), " 1"),
        (("data", "blocks", 1, "density"), "\u0661"),
        (("data", "blocks", 1, "density"), "1_0"),
        (("data", "blocks", 1, "density"), "1/0"),
        (("data", "blocks", 1, "name"), 3),
        (("data", "blocks", 1, "name"), ...),
        (("data", "blocks", 1, "vertices", 0), "000"),
        (("data", "blocks", 1, "vertices", 0), ["0", "0", "0", "0"]),
        (("data", "blocks", 1, "faces", 0, 1), True),
        (("data", "blocks", 1, "faces", 0, 1), 1.0),
        (("data", "blocks", 1, "faces", 0, 2), -5),
        (("data", "blocks", 1, "Dead"), ["0"] * 6),
        (("data", "blocks", 1, "dead"), ["0"] * 5),
        (("data", "gravity"), ["0", "0", -10]),
        (("data", "contacts", 0, "blocks"), [False, True]),
        (("data", "contacts", 0, "blocks"), [0, 1, 1]),
        (("data", "contacts", 0, "on"), [[5], [4], [4]]),
        (("data", "contacts", 0, "on"), [[5], []]),
        (("data", "contacts", 0, "on"), [[5], [4, 4, 4]]),
        (("data", "contacts", 0, "Least"), "9"),
        (("data", "contacts", 0, "friction"), "Infinity"),
        (("data", "contacts", 0, "couple"), False),
        (("proof", "forces", 0), "009"),
        (("proof", "multiplier"), 1),
        (("proof", "more"), "1"),
        (("format",), "blockstat proof 2"),
        (("else",), 1),
    ],
)
def test_what_is_not_of_the_format_is_rejected(checker, path, value):
    with pytest.raises(ValueError, match="format"):
        said(checker, changed(path, value))


def test_a_key_is_given_once(checker):
    with pytest.raises(ValueError, match="given twice"):
        json.loads('{"fixed": true, "fixed": false}', object_pairs_hook=checker.once)


def test_what_is_printed_is_no_more_than_is_proved(checker):
    """Twelve digits, to the safe side: a load carried 0.9999999999999 times is not carried once."""
    push = solid(CUBE, live=["0", "0", "-10", "-5", "5", "0"])
    lower = {"forces": [["0", "0", "4.99999999999975"]] * 4, "multiplier": "0.9999999999999"}
    content = file([GROUND, push], FEET, lower)
    assert said(checker, content)[0] == "PROVED stable at 0.999999999999 times the live load"
    lift = solid(CUBE, live=["0", "0", "9.999999999999", "4.9999999999995", "-4.9999999999995", "0"])
    motion = {"motion": [["0"] * 6, ["0", "0", "1", "0", "0", "0"]]}
    assert (
        said(checker, file([GROUND, lift], FEET, motion))[0]
        == "PROVED unstable beyond 1.00000000001 times the live load"
    )


@pytest.mark.parametrize("bound", ["0", "0.5", "-1"])
def test_a_bound_is_of_one_dead_load_or_more(checker, bound):
    motion = {"motion": [["0"] * 6, ["0", "0", "-1", "0", "0", "0"]], "bound": bound}
    with pytest.raises(ValueError, match="bound"):
        said(checker, file([GROUND, solid(CUBE)], [], motion))


def test_a_tip_on_a_face_and_faces_that_overlap_are_right(checker):
    """What is forged at a rim is right half a metre further: the block is balanced, and nothing turns it."""
    for shape, place in ((PYRAMID, [0, 0]), (cuboid((-1, 0, -1), (1, 1, 0)), [TOP])):
        block = solid(cuboid((-0.5, 0, 0), (0.5, 1, 1)))
        content = file([solid(shape, True), block], [contact((0, 0.5, 0), [place, [BOTTOM]])], WHOLE)
        assert said(checker, content)[0] == "PROVED stable"


@pytest.mark.parametrize(
    ("depth", "low", "high"),
    [
        (-3, (-0.5, -1), (0.5, 0)),
        (-1.5, (-0.5, -1), (0.5, 0)),
        (-3, (-0.5, -1.5), (0.5, -0.5)),
        (-3, (-2, -1), (2, 0.1)),
    ],
)
def test_a_block_on_a_face_with_a_notch_is_proved(checker, depth, low, high):
    """The mean of the corners of the face is in the notch, or about its rim."""
    outline = [(-3, depth), (3, depth), (3, 2), (1, 2), (1, 0), (-1, 0), (-1, 2), (-3, 2)]
    corners, faces = prism(outline)
    slab = Block([(x, z, y - 1) for x, y, z in corners], [face[::-1] for face in faces])
    scene = Assembly.from_blocks([slab, box((*low, 0), (*high, 1))], supports=[0], friction=0.5)
    assert checker.check(prove(scene).content)[0] == "PROVED stable"


def test_blocks_whose_faces_are_divided_are_proved(checker):
    """Each contact lies on two pieces that overlap next to it, however the faces of the blocks are divided."""

    def divided(block, first):
        turned = [[*face[first:], *face[:first]] for face in map(list, block.faces)]
        return Block(block.vertices, [[face[0], *face[i : i + 2]] for face in turned for i in (1, 2)])

    boxes = [box((-1, -1, -1), (2, 1, 0)), box((0, -1, 0), (1, 0, 1)), box((0.25, -0.5, 1), (1.25, 0, 2))]
    for first in ((0, 1, 0), (1, 0, 1), (0, 0, 0)):
        blocks = [divided(*pair) for pair in zip(boxes, first, strict=True)]
        proof = prove(Assembly.from_blocks(blocks, supports=[0]))
        assert checker.check(proof.content)[0] == "PROVED stable"


def test_blocks_of_solids_that_touch_are_proved(checker):
    """Two cubes that share an edge, or a face, are one block, as they are elsewhere."""
    for low in ((1, 0, 1), (1, 0, 0)):
        one, two = cuboid((0, 0, 0), (1, 1, 1)), cuboid(low, tuple(x + 1 for x in low))
        vertices, faces = joined(one, two)
        with pytest.warns(match="separate solids"):
            scene = Assembly.from_blocks([box((-5, -5, -1), (5, 5, 0)), Block(vertices, faces)], supports=[0])
        proof = prove(scene)
        assert checker.check(proof.content)[0] == f"PROVED {proof.outcome.word}"


def test_the_prover_states_how_uneven_faces_are(checker):
    """A cube with a corner 1 mm above the ground: contacts lie on the mean plane, and corners are off it."""
    vertices, faces = cuboid((0, 0, 0), (1, 1, 1))
    vertices[0] = [0, 0, 0.001]
    scene = Assembly.from_blocks([box((-5, -5, -1), (5, 5, 0)), Block(vertices, faces)], supports=[0])
    proof = prove(scene)
    assert checker.check(proof.content)[0] == f"PROVED {proof.outcome.word}"


def test_the_prover_writes_no_corner_of_no_face():
    vertices, faces = cuboid((0, 0, 0), (1, 1, 1))
    scene = Assembly.from_blocks(
        [box((-5, -5, -1), (5, 5, 0)), Block([[9, 9, 9], *vertices], [[i + 1 for i in f] for f in faces])], supports=[0]
    )
    found = solids(scene)[1]
    assert len(found.corners) == 8
    assert {i for face in found.faces for i in face} == set(range(8))
