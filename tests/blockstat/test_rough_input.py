"""Input that real files and slips of the pen bring."""

import json
import warnings
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import (
    Assembly,
    Block,
    InputError,
    InputWarning,
    LoadOutcome,
    Outcome,
    assess,
    limit_load,
    load_scene,
    read,
    read_plan,
    search,
    write,
)
from blockstat.spec import scene_from
from evidence.scenes.small import HUT, arch, assembly, box, hexahedron, prism, stack


def leaning_plank(under=0.5):
    """A plank with a foot cut flat, resting on the top corner of a wall: a contact of an edge with a face.

    under : how far the wall reaches under the plank, which is a metre wide.
    """
    slope, thick, length = np.deg2rad(60), 0.1, 3.0
    along, across = np.array([np.cos(slope), np.sin(slope)]), np.array([-np.sin(slope), np.cos(slope)])
    heel = np.array([thick / np.sin(slope), 0.0])
    plan = [(0, 0), tuple(heel), tuple(heel + length * along), tuple(heel + length * along + thick * across)]
    x, z = heel + along / along[0]
    return assembly(
        [
            box((-5, -5, -1), (9, 9, 0), name="ground"),
            box((x, 1 - under, 0), (x + 0.5, 2.5, z), name="wall"),
            hexahedron([(u, 1, w) for u, w in plan], [(u, 0, w) for u, w in plan], name="plank"),
        ],
        supports=[0, 1],
        friction=0.8,
    )


def test_a_plank_leans_on_the_corner_of_a_wall():
    assert assess(leaning_plank()).outcome is Outcome.STABLE
    assert assess(leaning_plank(), friction=0.01).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("under", [0.5, 0.04, 0.01, 1e-5])
def test_a_wall_holds_a_plank_however_little_of_it(under):
    verdict = assess(leaning_plank(under))
    assert verdict.outcome is Outcome.STABLE
    assert verdict.interfaces.contacts["edge"] == 1
    # An edge shorter than a thousandth of the block is less than stone is cut to.
    assert ["narrower than 0.001" in text for text in verdict.warnings] == [True] * (under < 1e-3)


def test_a_wall_that_just_touches_the_side_of_a_plank_leaves_it_undecided():
    # Corner on edge: no direction of the force is known, so falling is not proven.
    verdict = assess(leaning_plank(0.0))
    assert verdict.outcome is Outcome.UNDECIDED
    assert any('"wall" and "plank" touch only' in text for text in verdict.warnings)


@pytest.mark.parametrize("digits", [3, 6, 9])
def test_overlaps_are_found_in_rounded_coordinates(digits):
    turn = Rotation.from_rotvec([0.3, 0.2, 0.9]).as_matrix()
    blocks = [box((0, 0, 0), (0.3, 0.3, 0.3), name="a"), box((0.15, 0, 0), (0.45, 0.3, 0.3), name="b")]
    rough = [Block(np.round(b.vertices @ turn.T + 7, digits), b.faces, b.name) for b in blocks]
    with pytest.raises(InputError, match=r'blocks "a" and "b" overlap by 0.15'):
        assess(assembly(rough))


def test_a_name_wins_over_a_number():
    blocks = [box((0, 0, 1), (1, 1, 2), name="1"), box((-1, -1, 0), (2, 2, 1), name="0")]
    assert Assembly.from_blocks(blocks, supports=["0"]).support.tolist() == [False, True]
    assert Assembly.from_blocks(blocks, supports=[0]).support.tolist() == [True, False]
    named = [Block(b.vertices, b.faces, name) for b, name in zip(blocks, "xy", strict=True)]
    assert Assembly.from_blocks(named, supports=["1"]).support.tolist() == [False, True]
    assert Assembly.from_blocks(named, supports="y").support.tolist() == [False, True]


def test_a_scene_has_its_own_support(root):
    with pytest.raises(InputError, match="supports cannot be chosen"):
        read(root / "examples" / "chapel.toml", supports=["ground"])


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"wall": {"thickness": {"value": 0.5, "min": -0.1, "max": 0.5, "step": 0.3}}}, "wall.thickness"),
        ({"vault": {"thickness": 0.3, "voussoirs": {"value": 3, "min": -3, "max": 3, "step": 1}}}, "vault.voussoirs"),
        ({"vault": {"thickness": 0.3, "voussoirs": {"value": 4, "min": 3, "max": 5, "step": 0.5}}}, "vault.voussoirs"),
        ({"span": float("inf")}, "span"),
        ({"wall": {"thickness": {"value": 0.5, "min": 0.1, "max": float("inf"), "step": 0.3}}}, "wall.thickness.max"),
        ({"wall": {"thickness": {"value": 0.5, "min": 0.1, "max": 0.6, "step": 1e-9}}}, "wall.thickness"),
        ({"name": "../../elsewhere"}, "name"),
        ({"name": ""}, "name"),
    ],
)
def test_slips_in_a_scene_name_their_key(change, path):
    with pytest.raises(InputError, match=path.replace(".", r"\.")):
        scene_from(HUT | change)


def test_a_scene_of_millions_of_bricks_is_refused_before_it_is_built():
    from blockstat import build

    with pytest.raises(InputError, match=r"about .* blocks are asked for; at most"):
        build(scene_from(HUT | {"brick": {"length": 1e-3, "height": 1e-3}}))


def test_separate_solids_in_one_object_are_mentioned_and_nameless_ones_are_blocks(tmp_path):
    path = write(stack(2), tmp_path / "stack.obj")
    lines = path.read_text().splitlines()
    nameless = tmp_path / "nameless.obj"
    nameless.write_text("\n".join(line for line in lines if not line.startswith("o ")))
    assert read(nameless, supports=[0]).n_blocks == 3
    joined = tmp_path / "joined.obj"
    joined.write_text("\n".join(line for line in lines if line != "o stone1") + "  # a comment\n")
    with pytest.warns(InputWarning, match=r'1 blocks hold separate solids that move as one \(the first is "stone0"\)'):
        assert read(joined, supports=["ground"]).n_blocks == 2


def touching(*places):
    """Two cubes as one block, which share the corners where they touch."""
    cubes = [box(low, np.add(low, 1)) for low in places]
    corners = sorted({tuple(map(float, corner)) for cube in cubes for corner in cube.vertices})
    faces = []
    for cube in cubes:
        own = [corners.index(tuple(map(float, corner))) for corner in cube.vertices]
        faces += [[own[corner] for corner in face] for face in cube.faces]
    return Block(corners, faces, "pair")


def voxels(*places, turn=None):
    """The surface of unit cubes at places of a grid as one block: a face of a cube where no other cube is."""
    corners, faces = {}, []
    cube = box((0, 0, 0), (1, 1, 1))
    for place in places:
        for face in cube.faces:
            own = [tuple(np.add(place, cube.vertices[c]).tolist()) for c in face]
            beside = np.add(place, 2 * np.mean([cube.vertices[c] for c in face], axis=0) - 1)
            if tuple(np.round(beside).astype(int).tolist()) not in places:
                faces.append([corners.setdefault(corner, len(corners)) for corner in own])
    points = np.array(list(corners), dtype=float)
    return Block(points if turn is None else points @ turn.T, faces, "piece")


TURNS = [None, np.linalg.qr(np.array([[3.0, 1, 2], [1, 4, 1], [-2, 1, 5]]))[0]]
#: Five cubes, each on a face of the one before it; the first and the last share an edge alone.
BENT = [(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (1, 1, 0)]


@pytest.mark.parametrize("turn", TURNS, ids=["as it is", "turned"])
def test_a_solid_that_touches_itself_along_an_edge_is_one(turn):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for places in (BENT, BENT[::-1], [(0, 0, 0), (0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 1, 0)]):
            # The edge from (1, 1, 0) to (1, 1, 1) is one of four faces.
            assert Assembly.from_blocks([voxels(*places, turn=turn)], supports=[0]).volume[0] == pytest.approx(5.0)


@pytest.mark.parametrize("turn", TURNS, ids=["as it is", "turned"])
@pytest.mark.parametrize(
    "places",
    [
        [(0, 0, 0), (1, 1, 0)],
        [(0, 0, 0), (0, 0, 1), (1, 1, 1), (1, 1, 0)],
        [(0, 0, 0), (1, 1, 1)],
        [(0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)],
    ],
    ids=["an edge", "two edges", "a corner", "six edges of four cubes"],
)
def test_solids_that_share_edges_or_corners_alone_are_several(places, turn):
    with pytest.warns(InputWarning, match="1 blocks hold separate solids that move as one"):
        assert Assembly.from_blocks([voxels(*places, turn=turn)], supports=[0]).volume[0] == pytest.approx(len(places))


@pytest.mark.parametrize("second", [(1, 0, 0), (1, 1, 0)], ids=["a face", "an edge"])
def test_solids_of_one_block_that_touch_are_mentioned(second, tmp_path):
    import trimesh

    pair = touching((0, 0, 0), second)
    text = r'1 blocks hold separate solids that move as one \(the first is "pair"\)'
    with pytest.warns(InputWarning, match=text):
        assert Assembly.from_blocks([pair], supports=[0]).volume[0] == pytest.approx(2.0)
    triangles = [(face[0], face[k], face[k + 1]) for k in (1, 2) for face in pair.faces]
    whole = trimesh.Trimesh(pair.vertices, triangles, process=False)  # neither cube closes before the other begins
    trimesh.Scene({"pair": whole}).export(tmp_path / "pair.glb")
    whole.export(tmp_path / "pair.stl")
    for suffix in (".glb", ".stl"):
        with pytest.warns(InputWarning, match=text):
            assert read(tmp_path / f"pair{suffix}", supports=[0]).n_blocks == 1


def test_one_solid_with_a_notch_is_not_mentioned_as_several():
    notched = prism([(0, 0), (2, 0), (2, 2), (1, 2), (1, 1), (0, 1)], 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Assembly.from_blocks([notched], supports=[0])


def test_the_only_object_of_a_file_is_all_its_solids(tmp_path):
    import trimesh

    boxes = [trimesh.creation.box((1, 1, 1), trimesh.transformations.translation_matrix((0, 0, k))) for k in range(10)]
    boxes[-1].metadata["name"] = "last"  # what joins meshes may name all of them after one
    path = tmp_path / "joined.obj"
    trimesh.util.concatenate(boxes).export(path)
    with pytest.raises(InputError, match=r"which blocks are supports.*block0, block1, .*, block7 and 2 more"):
        read(path)
    tower = read(path, supports=[0])
    assert tower.n_blocks == 10
    assert assess(tower).outcome.word == "stable"
    boxes[0].export(path)
    assert read(path, supports=[0]).n_blocks == 1


def test_bricks_of_the_only_object_may_share_vertices(tmp_path):
    # two halves of a beam that would bridge the gap if they were one block
    boxes = [
        box((0, 0, 0), (0.5, 1, 1)),
        box((2.5, 0, 0), (3, 1, 1)),
        box((0, 0, 1), (1.5, 1, 2)),
        box((1.5, 0, 1), (3, 1, 2)),
    ]
    corners = sorted({tuple(corner) for block in boxes for corner in block.vertices.tolist()})
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    for block in boxes:
        own = [corners.index(tuple(corner)) + 1 for corner in block.vertices.tolist()]
        lines += ["f " + " ".join(str(own[corner]) for corner in face) for face in block.faces]
    path = tmp_path / "welded.obj"
    path.write_text("\n".join(lines))
    bridge = read(path, supports=[0, 1])
    assert bridge.n_blocks == 4
    assert assess(bridge, friction=0.0).outcome.word == "unstable"


def test_names_that_collide_with_the_numbering(tmp_path):
    blocks = [box((0, 0, k), (1, 1, k + 1), name=name) for k, name in enumerate(("a", "b", "c"))]
    path = write(assembly(blocks), tmp_path / "x.obj")
    path.write_text(path.read_text().replace("o a", "o m").replace("o b", "o m").replace("o c", "o m.0"))
    with pytest.warns(InputWarning, match="share a name"):
        names = read(path, supports=[0]).names
    assert len(set(names)) == 3
    assert "m.0" in names


def test_loads_that_balance_a_floating_block_are_no_proof_of_falling():
    asm = assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 3), (1, 1, 4)), box((5, 0, 3), (6, 1, 4))])
    loads = np.zeros((3, 6))
    loads[1:, 2] = 1.0
    assert assess(asm, loads=loads).outcome is Outcome.UNDECIDED
    loads[1:, 2] = 0.0, 2.0
    apart = assess(asm, loads=loads)
    assert apart.outcome is Outcome.UNSTABLE
    assert np.sign(apart.mechanism[:, 2]).tolist() == [0, -1, 1]
    loads[1:, 2] = 1.0
    loads[2, 4] = 0.5
    spun = assess(asm, loads=loads)
    assert spun.outcome is Outcome.UNSTABLE
    assert spun.mechanism[2, 4] > 0


def test_metadata_does_not_override_physics(tmp_path):
    asm = stack(2).with_(metadata={"friction": 0.1, "supports": [2], "author": "me"})
    back = read(write(asm, tmp_path / "x.json"))
    assert back.friction == asm.friction
    assert back.support.tolist() == asm.support.tolist()
    assert back.metadata["author"] == "me"
    with pytest.raises(InputError, match="metadata cannot be written"):
        write(stack(2).with_(metadata={"a": np.zeros(3)}), tmp_path / "y.json")


def test_a_damaged_history_is_refused(tmp_path):
    path = tmp_path / "history.csv"
    building = scene_from(HUT)

    def judge(assembly):
        raise KeyboardInterrupt

    first = search(building, verify=judge, history=path, names="wall.thickness")
    assert not first.finished
    line = path.read_text().splitlines()[0]
    from blockstat.design_search.history import digest

    row = ["x"] * (len(line.split(",")) - 1) + [digest(first.building, "")]
    path.write_text(line + "\n" + ",".join(row) + "\n")
    with pytest.raises(InputError, match="a row is damaged"):
        search(building, verify=judge, history=path, names="wall.thickness")


@pytest.mark.parametrize("text", ["[" * 100_000, '{"blocks": ' + "[" * 100_000])
def test_deep_json(tmp_path, text):
    path = tmp_path / "deep.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"nested too deeply|not valid JSON"):
        read(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 100_000, "the JSON is nested too deeply"),
        ('{"steps": ' + "[" * 200 + "]" * 200 + "}", "tables and lists are nested more than 100 deep"),
        ("{", "line 1, column 2: not valid JSON"),
        ("1" * 5000, "holds a number of thousands of digits"),
    ],
)
def test_a_plan_that_is_no_json_is_told_what_is_wrong_with_it(tmp_path, text, words):
    path = tmp_path / "plan.json"
    path.write_text(text)
    with pytest.raises(InputError, match=f"plan.json: {words}"):
        read_plan(path, Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), name="block")], supports=["block"]))


def test_wild_numbers_and_types(tmp_path):
    cube = box((0, 0, 0), (1, 1, 1))
    for bad in ({"density": "heavy"}, {"density": float("inf")}):
        with pytest.raises(InputError, match="density is"):
            Assembly.from_blocks([Block(cube.vertices, cube.faces, **bad)])
    with pytest.raises(InputError, match="coordinates must be finite and below"):
        Assembly.from_blocks([Block(1e308 * cube.vertices, cube.faces)])
    with pytest.raises(InputError, match="gravity is"):
        stack(1).with_(gravity=(0, 0, -1e-300))
    with pytest.raises(InputError, match="loads must be numbers"):
        assess(stack(1), loads=[["a"] * 6] * 2)
    with pytest.raises(InputError, match='gap is "x"'):
        assess(stack(1), gap="x")
    with pytest.raises(InputError, match=r"the directory holds no \.ply, \.stl or \.obj files"):
        read(tmp_path)
    assert assess(arch(3, 0.2).with_(support=np.ones(5, dtype=bool))).warnings == (
        "all blocks are supports; there was nothing to check",
    )


def test_a_picture_needs_a_suffix(tmp_path):
    from blockstat.view.plot import plot

    with pytest.raises(InputError, match="needs a suffix"):
        plot(stack(1), tmp_path / "picture")


def test_scene_without_json_but_with_a_name_from_its_file(tmp_path):
    path = tmp_path / "barn.toml"
    path.write_text("length = 3.0\nspan = 2.0\n")
    assert load_scene(path).name == "barn"
    assert json.loads(write(read(path), tmp_path / "barn.json").read_text())["name"] == "barn"


def saddles(apart, warp, side=1.0):
    """Two cubes with saddles between them, whose corners are `warp` above and below the mean plane in turn."""
    corners = [(0, 0), (side, 0), (side, side), (0, side)]
    up = [warp, -warp, warp, -warp]
    faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]

    def block(name, bottom, top):
        points = [(x, y, z) for heights in (bottom, top) for (x, y), z in zip(corners, heights, strict=True)]
        return Block(points, faces, name)

    middle = [side + own for own in up]
    blocks = [block("low", [0.0] * 4, middle), block("high", [apart + z for z in middle], [2 * side] * 4)]
    return assembly(blocks, supports=["low"])


@pytest.mark.parametrize("gap", ["0.1 mm", "0.3 mm"])
def test_warped_faces_that_a_stated_gap_leaves_apart_are_told_with_the_gap_that_closes_them(gap):
    """Saddles of 10 mm that are 2 mm apart fit into each other: a gap of a fifth is too small to be a near miss."""
    scene = saddles(0.002, 0.01)
    told = f'faces apart by less than they are warped, and not taken: 1 (gap tolerance {gap}), the closest "low" to '
    assert assess(scene, gap=gap).warnings[1:] == (f'{told}"high"; gap="2 mm" closes it',)
    closed = assess(scene, gap="2 mm")
    assert closed.outcome is Outcome.STABLE
    assert not [text for text in closed.warnings if "warped" in text]


def test_faces_apart_by_more_than_their_warp_or_told_as_near_are_no_warped_ones():
    for scene, gap in (
        (saddles(0.002, 0.001), "0.1 mm"),
        (saddles(0.002, 0.0), "0.1 mm"),
        (saddles(0.002, 0.01), 1e-4),
    ):
        assert not [text for text in assess(scene, gap=gap).warnings if "warped" in text]
    (near,) = assess(saddles(0.002, 0.01), gap="0.5 mm").warnings[1:]
    assert near.startswith("near joints that were not taken: 1 (gap tolerance 0.5 mm)")


def warped_arch(noise, seed=2):
    """An arch of voussoirs that share quads with corners up to 24 mm off; `noise` moves those of each one alone."""
    random, other = (np.random.default_rng(number) for number in (seed, 7))
    corners = [(radius, y) for radius, y in ((1.0, 0.0), (1.2, 0.0), (1.2, 0.4), (1.0, 0.4))]
    beds = []
    for k in range(14):
        angles = np.pi * (1 - k / 13) + random.uniform(-0.02, 0.02, 4) * (0 < k < 13)
        beds.append(np.array([(r * np.cos(a), y, r * np.sin(a)) for (r, y), a in zip(corners, angles, strict=True)]))
    faces = [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
    blocks = []
    for one, two in pairwise(beds):
        moved = np.vstack([one, two]) + noise * other.uniform(-1, 1, (8, 3))
        blocks.append(Block(moved, faces))
    blocks += [box((-1.4, -0.2, -0.3), (-0.8, 0.6, 0)), box((0.8, -0.2, -0.3), (1.4, 0.6, 0))]
    return Assembly.from_blocks(blocks, supports=[13, 14], friction=0.6)


def test_the_edges_of_a_joint_of_warped_faces_are_part_of_it():
    """They leave its plane by more than a joint may be open. A micrometre apart they would be no edges along edges."""
    shared, apart = (limit_load(warped_arch(noise), (1, 0, 0)) for noise in (0.0, 1e-6))
    assert shared.outcome is apart.outcome is LoadOutcome.LIMIT, shared.explain()
    assert shared.lower == pytest.approx(apart.lower, rel=1e-4)
