"""Repair of rough geometry."""

import json

import numpy as np
import pytest
from test_cli import run

from blockstat import (
    Assembly,
    Block,
    InputError,
    RepairOutcome,
    assess,
    build,
    find_interfaces,
    load_scene,
    read,
    repair,
    write,
)
from blockstat.geometry_repair.trimming import trim_overlaps
from blockstat.result import counted
from evidence.scenes.small import arch, assembly, box, prism, running_bond, stack

SIZE = 1e-3  #: of the largest gap [m]


def grid_wall():
    """Bricks without bond: four meet at every corner."""
    bricks = [box((0.4 * i, 0, 0.2 * k), (0.4 * i + 0.4, 0.2, 0.2 * k + 0.2)) for i in range(5) for k in range(4)]
    return assembly([box((-1, -1, -1), (3, 2, 0)), *bricks])


def shrunk(asm, rng):
    """Boxes with every face moved inwards by up to half of SIZE: joints gape by up to SIZE."""
    vertices = asm.vertices.copy()
    for b in range(asm.n_blocks):
        own = slice(asm.vertex_start[b], asm.vertex_start[b + 1])
        middle = (vertices[own].min(axis=0) + vertices[own].max(axis=0)) / 2
        low, high = rng.uniform(0, SIZE / 2, (2, 3))
        vertices[own] += np.where(vertices[own] < middle, low, -high)
    return asm.with_(vertices=vertices)


def shaken(asm, rng):
    """Every vertex moved at random: joints gape or overlap by up to SIZE, faces are warped."""
    return asm.with_(vertices=asm.vertices + rng.uniform(-SIZE / 4, SIZE / 4, asm.vertices.shape))


@pytest.mark.parametrize("spoil", [shrunk, shaken])
@pytest.mark.parametrize("make", [lambda: running_bond(6, 5), grid_wall], ids=["bond", "grid"])
def test_a_wall_with_random_gaps_gets_its_joints_back(make, spoil):
    perfect = make()
    rough = spoil(perfect, np.random.default_rng(0))
    assert find_interfaces(rough, gap=1e-6).n_interfaces == 0
    repaired, report = repair(rough)
    ours, theirs = find_interfaces(repaired, gap=1e-6), find_interfaces(perfect, gap=1e-6)
    assert ours.pair.tolist() == theirs.pair.tolist()
    assert np.diff(ours.start).tolist() == np.diff(theirs.start).tolist()
    # As far as the vertices were moved, relative to the shorter side of a joint.
    np.testing.assert_allclose(ours.area, theirs.area, rtol=2 * SIZE / 0.175)
    assert np.abs(ours.frame[:, 0] - theirs.frame[:, 0]).max() < 2 * SIZE / 0.175
    assert repaired.planes.warp.max() < 1e-12
    assert np.linalg.norm(repaired.vertices - rough.vertices, axis=1).max() < 1.5 * SIZE
    assert assess(repaired, gap=1e-6).outcome is assess(perfect).outcome
    for i, change in enumerate(report.changes):
        own = slice(repaired.vertex_start[i], repaired.vertex_start[i + 1])
        distance = np.linalg.norm(repaired.vertices[own] - rough.vertices[own], axis=1).max()
        assert change.moved == pytest.approx(distance, rel=1e-9, abs=1e-15)


def test_an_arch_gets_its_joints_back():
    repaired, _ = repair(shaken(arch(20, 0.12), np.random.default_rng(1)))
    assert find_interfaces(repaired, gap=1e-6).n_interfaces == 21


def test_a_gap_above_the_tolerance_stays():
    blocks = [box((0, 0, 0), (1, 1, 1)), box((0, 0, 1.02), (1, 1, 2))]
    repaired, report = repair(assembly(blocks))
    assert report.changed == ()
    np.testing.assert_array_equal(repaired.vertices, assembly(blocks).vertices)
    closed, _ = repair(assembly(blocks), gap=0.03)
    assert find_interfaces(closed, gap=1e-6).n_interfaces == 1
    _, report = repair(shrunk(stack(3), np.random.default_rng(0)), gap=0)
    assert report.changed == ()


def test_overlaps_below_the_tolerance_are_closed_too():
    repaired, report = repair(assembly([box((-1, -1, -1), (2, 2, 0)), box((0, 0, -0.004), (1, 1, 1))]))
    joint = find_interfaces(repaired, gap=1e-6)
    assert joint.n_interfaces == 1
    assert [change.joined for change in report.changes] == [1, 1]
    # The plane lies between, closer to where the larger face was.
    assert joint.point[:, 2] == pytest.approx([-0.0004] * 4)


def test_overlaps_that_stay_are_told():
    deep = assembly([box((-1, -1, -1), (2, 2, 0)), box((0, 0, -0.05), (1, 1, 1), name="sunk")])
    _, report = repair(deep)
    assert '1 pairs of blocks overlap, the worst "block0" and "sunk" by 0.05 m' in report.explain()
    _, report = repair(stack(3))
    assert report.overlaps == ""


def test_what_is_sound_is_not_touched(root):
    chapel = build(load_scene(root / "examples" / "chapel.toml"))
    repaired, report = repair(chapel)
    np.testing.assert_array_equal(repaired.vertices, chapel.vertices)
    np.testing.assert_array_equal(repaired.face_vertices, chapel.face_vertices)
    assert (repaired.names, repaired.groups, repaired.metadata) == (chapel.names, chapel.groups, chapel.metadata)
    assert report.changed == ()
    assert report.outcome is RepairOutcome.UNCHANGED
    assert report.explain().splitlines() == [RepairOutcome.UNCHANGED.value, "219 of 219 blocks unchanged"]


def curved_arch(n=30, facets=6, thickness=0.15):
    """Voussoirs on a half circle of radius 1 m whose intrados and extrados are in facets, 1 degree apart; its ends."""
    blocks = []
    for k in range(n):
        turns = np.linspace(np.pi * k / n, np.pi * (k + 1) / n, facets + 1)
        inner, outer = ((1 + way * thickness / 2) * np.column_stack([np.cos(turns), np.sin(turns)]) for way in (-1, 1))
        blocks.append(prism([*outer, *inner[::-1]], 0.5, name=f"v{k}"))
    feet = [box((x - 0.1, 0, -1), (x + 0.1, 0.5, 0), name=name) for x, name in ((1, "right"), (-1, "left"))]
    return assembly([*blocks, *feet], supports=["right", "left"])


def test_the_facets_of_curved_stones_whose_joints_close_are_not_flattened():
    asm = curved_arch()
    repaired, report = repair(asm)
    assert report.outcome.word == "unchanged"
    np.testing.assert_array_equal(repaired.vertices, asm.vertices)
    # A joint that is open is closed all the same.
    moved = asm.vertices.copy()
    moved[asm.vertex_block >= 15] += (-1e-3, 0, 0)
    closed, report = repair(asm.with_(vertices=moved))
    assert (report.outcome.word, report.closed) == ("repaired", 1)
    assert len(find_interfaces(closed, gap=1e-9).pair) == len(find_interfaces(asm, gap=1e-9).pair)


def test_a_slab_thinner_than_the_tolerance_is_not_squeezed():
    blocks = [box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 0.0005)), box((0, 0, 0.0005), (1, 1, 1))]
    repaired, _ = repair(assembly(blocks), gap=0.1)
    np.testing.assert_allclose(repaired.volume, [1, 0.0005, 0.9995], rtol=1e-12)
    assert find_interfaces(repaired, gap=1e-6).n_interfaces == 2


def scattered(block, rng, noise=1e-6):
    """A block as a soup: every face with vertices of its own, a little off."""
    faces = np.split(np.arange(24), 6)
    vertices = np.asarray(block.vertices, dtype=float)[np.concatenate(block.faces)]
    return Block(vertices + rng.uniform(-noise, noise, vertices.shape), [f.tolist() for f in faces], block.name)


def test_a_soup_with_faces_turned_at_random_becomes_solids():
    perfect, rng = arch(8, 0.3), np.random.default_rng(2)
    blocks, turned = [], []
    for i, name in enumerate(perfect.names):
        soup = scattered(Block(perfect.block_vertices(i), perfect.faces_of(i), name), rng)
        flip = rng.random(6) < 0.5
        turned.append(int(flip.sum()))
        faces = [face[::-1] if f else face for face, f in zip(soup.faces, flip, strict=True)]
        blocks.append(Block(soup.vertices, [*faces, faces[0], [0, 1, 0]], name))
    with pytest.raises(InputError):
        Assembly.from_blocks(blocks, supports=[0, 1])
    repaired, report = repair(blocks, supports=[0, 1], density=1.0, gravity=(0, 0, -1))
    np.testing.assert_allclose(repaired.volume, perfect.volume, rtol=1e-4)
    assert len(repaired.vertices) == len(perfect.vertices)
    assert [c.merged for c in report.changes] == [16] * perfect.n_blocks
    assert [c.dropped for c in report.changes] == [2] * perfect.n_blocks
    assert [c.turned for c in report.changes] == turned
    assert all(0 < c.spread < 2e-6 for c in report.changes)
    assert assess(repaired, gap=1e-6).outcome is assess(perfect).outcome
    assert report.outcome is RepairOutcome.REPAIRED
    first = report.explain().splitlines()[1]
    assert first.startswith('block "left": 16 duplicate vertices merged (moved by up to ')
    assert f"2 faces dropped; {counted(turned[0], 'face')} turned; " in first


@pytest.mark.filterwarnings("ignore:1 blocks hold separate solids")
def test_a_block_inside_out_is_turned_and_a_cavity_is_not():
    outer, inner = box((0, 0, 0), (3, 3, 3)), box((1, 1, 1), (2, 2, 2))
    hollow = Block(
        np.vstack([outer.vertices, inner.vertices]),
        [*outer.faces, *([c + 8 for c in face[::-1]] for face in inner.faces)],
        "hollow",
    )
    same, report = repair([hollow], supports=[0])
    assert same.volume[0] == pytest.approx(26)
    assert report.changed == ()
    inverted, report = repair([Block(hollow.vertices, [face[::-1] for face in hollow.faces], "hollow")], supports=[0])
    assert inverted.volume[0] == pytest.approx(26)
    assert report.changes[0].turned == 12


@pytest.mark.filterwarnings("ignore:1 blocks hold separate solids")
@pytest.mark.parametrize(
    "spoilt", [[7], [7, 8, 11], [2], [2, 9], [*range(6)], [*range(6, 12)], [*range(6), 8], [8, 13]]
)
def test_a_cavity_whose_faces_are_turned_stays_a_cavity_and_a_stone_in_it_is_solid(spoilt):
    """A cube of 5 m with a cavity of 3 m, in which a cube of 1 m lies loose."""
    cubes = [box((0, 0, 0), (5, 5, 5)), box((1, 1, 1), (4, 4, 4)), box((2, 2, 2), (3, 3, 3))]
    faces = [[8 * k + c for c in (face[::-1] if k == 1 else face)] for k in range(3) for face in cubes[k].faces]
    faces = [face[::-1] if number in spoilt else face for number, face in enumerate(faces)]
    block = Block(np.vstack([cube.vertices for cube in cubes]), faces, "hollow")
    sound, report = repair([block], supports=[0])
    assert sound.volume[0] == pytest.approx(5**3 - 3**3 + 1)
    assert report.changes[0].turned == len(spoilt)


@pytest.mark.filterwarnings("ignore:1 blocks hold separate solids")
def test_a_surface_in_the_notch_of_another_is_no_cavity():
    """A cube inside the box around an L, and outside the L."""
    around, cube = prism([(0, 0), (5, 0), (5, 5), (4, 5), (4, 1), (0, 1)], 3.0), box((1, 2, 1), (2, 3, 2))
    around.vertices[:] = around.vertices - around.vertices.min(axis=0)
    faces = [*around.faces, *([len(around.vertices) + c for c in face] for face in cube.faces)]
    faces[-1] = faces[-1][::-1]
    sound, _ = repair([Block(np.vstack([around.vertices, cube.vertices]), faces, "pair")], supports=[0])
    assert sound.volume[0] == pytest.approx(9 * 3 + 1)


TURN = np.linalg.qr(np.array([[3.0, 1, 2], [1, 4, 1], [-2, 1, 5]]))[0]


def tees(*shares_of_faces, edge=(5, 6), off=0.0):
    """A box of 1 by 2 by 3 m with corners at shares of an edge, each known to one of the two faces of that edge alone.

    The corners are off the edge to the outside by a length.
    """
    solid = box((0, 0, 0), (1, 2, 3), name="tee")
    points, faces = [list(point) for point in solid.vertices], [list(face) for face in solid.faces]
    beside = [k for k, face in enumerate(faces) if set(edge) <= set(face)]
    a, b = (np.array(points[corner]) for corner in edge)
    out = (a + b) / 2 - (0.5, 1.0, 1.5)
    for k, shares in zip(beside, shares_of_faces, strict=False):
        at = faces[k].index(edge[0])
        ahead = faces[k][(at + 1) % 4] == edge[1]
        added = []
        for share in shares:
            points.append((a + share * (b - a) + off * out / np.linalg.norm(out)).tolist())
            added.append(len(points) - 1)
        place = at + 1 if ahead else at
        faces[k][place:place] = added if ahead else added[::-1]
    return Block(np.array(points), faces, "tee")


@pytest.mark.parametrize("edge", [(0, 1), (5, 6), (2, 6)])
@pytest.mark.parametrize("shares", [[[0.5]], [[0.25, 0.5, 0.9]], [[0.2, 0.7], [0.4]], [[0.1], [0.3, 0.8, 0.9]]])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["as it is", "turned"])
def test_corners_on_edges_are_put_into_the_faces_that_lack_them(edge, shares, scale, turn):
    block = tees(*shares, edge=edge)
    block = Block(scale * (block.vertices @ turn.T + (1, -2, 3)), block.faces, "tee")
    with pytest.raises(
        InputError, match=r'block "tee": corners of some faces lie on edges .*let `blockstat repair` put'
    ):
        Assembly.from_blocks([block], supports=[0])
    closed, report = repair([block], supports=[0])
    assert closed.volume[0] == pytest.approx(6 * scale**3)
    change, count = report.changes[0], sum(map(len, shares))
    assert (change.inserted, change.merged, change.dropped, change.turned) == (count, 0, 0, 0)
    assert f"{counted(count, 'corner')} put into the edges that they lie on" in report.explain()
    assert repair(closed)[1].outcome is RepairOutcome.UNCHANGED


def test_corners_are_on_an_edge_within_the_distance_of_merging():
    diagonal = 14**0.5
    for off, merge, closes in ((0.9e-4, 1e-4, True), (1.1e-4, 1e-4, False), (1.1e-4, 2e-4, True)):
        block = tees([0.5], off=off * diagonal)
        if closes:
            closed, report = repair([block], supports=[0], merge=merge)
            assert closed.volume[0] == pytest.approx(6, rel=1e-3)
            assert report.changes[0].inserted == 1
        else:
            with pytest.raises(InputError, match="its surface is open"):
                repair([block], supports=[0], merge=merge)


def test_a_turned_face_with_a_corner_on_its_edge_is_turned_and_closed():
    block = tees([0.3], [0.6])
    faces = [face[::-1] if k == 4 else face for k, face in enumerate(block.faces)]
    closed, report = repair([Block(block.vertices, faces, "tee")], supports=[0])
    assert closed.volume[0] == pytest.approx(6)
    assert (report.changes[0].turned, report.changes[0].inserted) == (1, 2)


@pytest.mark.parametrize("hole", range(6))
def test_a_hole_stays_open_whatever_corners_lie_on_edges(hole):
    block = tees([0.3], [0.6])
    faces = [face for k, face in enumerate(block.faces) if k != hole]
    for call in (repair, Assembly.from_blocks):
        with pytest.raises(InputError, match='block "tee": its surface is open') as error:
            call([Block(block.vertices, faces, "tee")], supports=[0])
        assert "repair" not in str(error.value)


def test_faces_far_from_flat_are_left_and_said():
    bent = box((0.0, 0, 0), (1, 1, 1), name="bent")
    bent.vertices[6] += [0, 0, 0.2]
    repaired, report = repair([bent], supports=[0])
    np.testing.assert_array_equal(repaired.vertices, bent.vertices)
    assert 'block "bent": 1 faces are too far from flat and were left' in report.explain()


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        (Block(box((0, 0, 0), (1, 1, 1)).vertices, box((0, 0, 0), (1, 1, 1)).faces[:-1], "a"), "its surface is open"),
        (Block([[0, 0, float("nan")]] * 8, box((0, 0, 0), (1, 1, 1)).faces, "a"), "vertices must be finite numbers"),
        (Block([], [], "a"), "vertices must be finite numbers"),
        (Block([[0, 0, 0]] * 4, [[0, 1, 9]], "a"), "a face has a corner that is not between 0 and 3"),
        (Block("stone", [], "a"), "vertices must be a list of"),
        (Block([[0, 0, 0]] * 8, box((0, 0, 0), (1, 1, 1)).faces, "a"), "vertices have shape"),
    ],
)
def test_what_cannot_be_repaired_is_named(block, expected):
    with pytest.raises(InputError, match=f'block "a": {expected}'):
        repair([block], supports=[0])


def spoilt():
    """A cube without its last face, one with a face turned, and one with a wing on an edge."""
    open_, turned, winged = (box((2 * k, 0, 0), (2 * k + 1, 1, 1), name=n) for k, n in enumerate(("o", "t", "w")))
    first = winged.faces[0]
    corners = np.vstack([winged.vertices, winged.vertices[list(first[:2])] + [0, 0, 3.0]])
    return [
        Block(open_.vertices, open_.faces[:-1], "o"),
        Block(turned.vertices, [turned.faces[0][::-1], *turned.faces[1:]], "t"),
        Block(corners, [*winged.faces, [first[0], first[1], 9, 8]], "w"),
    ]


SENT = "counter-clockwise seen from outside, or let `blockstat repair` turn it"


def test_a_repair_does_not_send_to_itself():
    # At one edge of the wing three faces meet, and its other three edges have no neighbour: no turn closes it.
    blocks = spoilt()
    with pytest.raises(InputError) as refused:
        Assembly.from_blocks(blocks, supports=[0])
    assert [text.endswith(SENT) for text in refused.value.args] == [False, True, True]
    with pytest.raises(InputError) as left:
        repair(blocks, supports=[0])
    assert [text[:9] for text in left.value.args] == ['block "o"', 'block "w"']
    assert left.value.args[0] == refused.value.args[0]
    assert left.value.args[1].endswith("counter-clockwise seen from outside")


def test_the_mesh_of_a_scene_is_not_sent_to_the_command_that_refuses_it(tmp_path):
    lines, before = [], 1
    for block in spoilt()[:2]:
        lines += [f"o {block.name}", *(f"v {x} {y} {z}" for x, y, z in block.vertices)]
        lines += ["f " + " ".join(str(before + corner) for corner in face) for face in block.faces]
        before += len(block.vertices)
    (tmp_path / "stones.obj").write_text("\n".join(lines))
    scene = tmp_path / "stones.toml"
    scene.write_text('[elements.m]\nkind = "mesh"\nfile = "stones.obj"\n')
    told = run("repair", scene, "-o", tmp_path / "new.json").stderr.splitlines()
    assert ['block "m.o": its surface is open' in told[0], 'block "m.t": face 0 is inverted' in told[1]] == [True] * 2
    assert "blockstat repair" not in told[1]
    assert SENT in run("check", scene).stderr


@pytest.mark.parametrize("supports", ["ground", 0, ["ground"], [0]])
def test_a_support_may_be_said_without_a_list(supports):
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube")]
    for source in (blocks, Assembly.from_blocks(blocks, supports=["cube"])):
        assert repair(source, supports=supports)[0].support.tolist() == [True, False]


def test_bad_tolerances():
    for bad in ({"gap": 0.5}, {"merge": -1}, {"warp": "x"}, {"gap": float("nan")}):
        with pytest.raises(InputError, match=f"{next(iter(bad))} is .*; it must be at least 0 and below"):
            repair(stack(2), **bad)
    with pytest.raises(InputError, match="units and up are those of a file"):
        repair(stack(2), units="mm")


@pytest.mark.parametrize("command", ["repair", "heal"])
def test_the_command_repairs_a_file_that_is_refused(tmp_path, command):
    path = write(stack(2), tmp_path / "rough.json")
    data = json.loads(path.read_text())
    data["blocks"][1]["faces"][2].reverse()
    path.write_text(json.dumps(data))
    refused = run("check", path)
    assert (refused.returncode, "is inverted" in refused.stderr) == (2, True)
    target = tmp_path / "clean.json"
    answer = run(command, path, "-o", target, "--gap", "0.005")
    assert answer.returncode == 0, answer.stderr
    told = [RepairOutcome.REPAIRED.value, 'block "stone0": 1 face turned', "2 of 3 blocks unchanged"]
    assert ("blockstat heal is now blockstat repair" in answer.stderr) == (command == "heal")
    assert answer.stdout.splitlines() == [*told, f"{target}: 3 blocks, in m, z up"]
    assert assess(read(target)).outcome.word == "stable"
    wrong = run(command, path, "-o", target, "--gap", "7")
    assert (wrong.returncode, "gap is 7.0; it must be" in wrong.stderr) == (2, True)


def test_a_vault_from_elsewhere_closes(cases):
    rough = read(cases / "asm_crossvault.json")
    repaired, _ = repair(rough)
    # 488 joints are recorded with it; at this tolerance the file itself lacks some of them.
    assert (find_interfaces(rough, gap=1e-6).kinds == 0).sum() < 488
    assert find_interfaces(repaired, gap=1e-6).n_interfaces == 488
    assert assess(rough, gap=1e-6).outcome.word != "stable"
    assert assess(repaired, gap=1e-6).outcome.word == "stable"


def test_repair_needs_no_supports_and_counts_the_joints_that_it_closed(tmp_path):
    """A gap of 2 mm between two bricks: each of the two faces moves by half of it."""
    bricks = [box((0, 0, 0), (1, 1, 1), name="low"), box((0, 0, 1.002), (1, 1, 2.002), name="high")]
    path = tmp_path / "pair.ply"
    write(Assembly.from_blocks(bricks), path)
    repaired, report = repair(path)
    assert not repaired.support.any()
    assert report.closed == 1
    assert report.explain().endswith("0 of 2 blocks unchanged, 1 joint closed, vertices moved by up to 1 mm")
    _, again = repair(repaired)
    assert again.closed == 0


def test_a_scene_is_repaired_as_it_is_built(tmp_path):
    path = tmp_path / "post.toml"
    path.write_text('[elements.post]\nkind = "box"\nsize = [1, 1, 2]\n')
    repaired, report = repair(path)
    assert repaired.names == read(path).names
    assert report.explain().endswith("2 of 2 blocks unchanged")
    with pytest.raises(InputError, match=r"post\.toml: a scene is in metres; units cannot be chosen for it"):
        repair(path, units="mm")


def test_a_block_with_a_notch_is_not_cut_as_if_it_were_its_hull():
    ell = prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 1.0, name="ell")
    scene = assembly([box((0, 0, -1), (2, 1, 0)), ell, box((0, 0, 1.9), (1, 1, 3), name="cap")])
    says = 'blocks "ell" and "cap" overlap, and "ell" has a notch: draw them apart, or let `blockstat repair` close'
    with pytest.raises(InputError, match=says):
        trim_overlaps(scene, np.array([[1, 2]]), gap=0.01)


def test_a_face_with_a_slit_to_its_hole_is_left_as_it_is():
    # A frame of 3 x 3 x 1 with a hole of 1 x 1: the slit from corner to corner lists both ends twice.
    rim, hole = [(0, 0), (3, 0), (3, 3), (0, 3)], [(1, 1), (1, 2), (2, 2), (2, 1)]
    vertices = [(x, y, z) for z in (0, 1) for x, y in rim + hole] + [(0, 0, 1), (1, 1, 1), (0, 0, 0), (1, 1, 0)]
    faces = [[8, 9, 10, 11, 16, 17, 13, 14, 15, 12], [0, 4, 7, 6, 5, 19, 18, 3, 2, 1]]
    faces += [[k + i, k + (i + 1) % 4, k + (i + 1) % 4 + 8, k + i + 8] for k in (0, 4) for i in range(4)]
    frame = Block(vertices, faces, "frame")
    repaired, report = repair([box((-1, -1, -1), (4, 4, 0)), frame], supports=[0])
    assert report.outcome is RepairOutcome.UNCHANGED
    assert repaired.volume[1] == pytest.approx(8.0)
    # Its top moves along when a gap is closed, slit and all.
    above = Block(np.array(vertices) + [0, 0, 2e-3], faces, "frame")
    repaired, report = repair([box((-1, -1, -1), (4, 4, 0)), above], supports=[0])
    assert report.closed == 1
    assert find_interfaces(repaired, gap=1e-6).area == pytest.approx([8.0])


def test_a_wall_inside_a_block_is_dropped_from_both_sides():
    number = {corner: k for k, corner in enumerate(np.ndindex(3, 2, 2))}
    cube = box((0, 0, 0), (1, 1, 1))
    faces = [
        [number[x + int(cube.vertices[c][0]), int(cube.vertices[c][1]), int(cube.vertices[c][2])] for c in face]
        for x in (0, 1)
        for face in cube.faces
    ]
    block = Block([tuple(map(float, corner)) for corner in number], faces, "double")
    assert assembly([block]).volume == pytest.approx([2.0])
    repaired, report = repair([block])
    assert repaired.volume == pytest.approx([2.0])
    assert report.changes[0].dropped == 2
    # A face listed from both sides that is no wall stays, once; so does every face of a shell listed from both.
    for listed in ([*cube.faces, cube.faces[2][::-1]], [*cube.faces, *(face[::-1] for face in cube.faces)]):
        repaired, report = repair([Block(cube.vertices, listed)])
        assert repaired.volume == pytest.approx([1.0])
        assert report.changes[0].dropped == len(listed) - 6
