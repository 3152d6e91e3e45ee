"""Units and the axis that is up, and doubts about them."""

import json

import numpy as np
import pytest

from blockstat import Assembly, Block, InputError, InputWarning, Tie, assess, box, read, write
from blockstat.assembly import STANDARD_GRAVITY
from blockstat.cli.commands import app
from blockstat.cli.options import _status
from blockstat.io.parts import UP, doubts
from evidence.scenes.small import arch, stack


def placed(assembly, matrix):
    """The same blocks in other coordinates."""
    blocks = [
        Block(assembly.block_vertices(i) @ matrix.T, [list(face) for face in assembly.faces_of(i)], assembly.names[i])
        for i in range(assembly.n_blocks)
    ]
    return Assembly.from_blocks(blocks, supports=np.flatnonzero(assembly.support).tolist(), density=2000.0)


def bare(assembly, path):
    """An OBJ without what is noted of gravity and supports, as other programs write it."""
    write(assembly, path)
    path.write_text("\n".join(line for line in path.read_text().splitlines() if not line.startswith("#")))
    return path


@pytest.mark.parametrize("up", UP)
def test_every_axis_can_be_up(up, tmp_path):
    ring = arch(9, 0.2)
    axis = "xyz".index(up[-1])
    sign = -1.0 if up.startswith("-") else 1.0
    # A rotation that takes z to the axis: its third column is the axis.
    third = sign * np.eye(3)[axis]
    first = np.eye(3)[(axis + 1) % 3]
    matrix = np.column_stack([first, np.cross(third, first), third])
    path = bare(placed(ring, matrix), tmp_path / "ring.obj")
    found = read(path, supports=[ring.names[i] for i in np.flatnonzero(ring.support)], up=up)
    assert np.allclose(found.centroid[:, 2], ring.centroid[:, 2])
    assert assess(found).score == pytest.approx(assess(ring).score, abs=1e-6)


def test_gravity_turns_with_the_blocks(tmp_path):
    path = write(stack(2).with_(gravity=(0, -9.81, 0)), tmp_path / "a.json")
    assert np.allclose(read(path, up="y").gravity, (0, 0, -9.81))
    with pytest.raises(InputError, match="must be one of: x, y, z, -x, -y, -z"):
        read(path, up="w")


def scaled(metres):
    return placed(stack(2), metres * np.eye(3))


def test_doubts_name_what_to_type():
    assert doubts(scaled(1.0)) == []
    assert "give --units mm" in doubts(scaled(1000.0))[0]
    assert "1,000 m long" in doubts(scaled(1000.0))[0]
    assert "give --units m" in doubts(scaled(1e-4))[0]
    swapped = placed(stack(4), np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]))
    assert doubts(swapped) == [
        "the blocks are beside their supports, along y, and not above them; if y is up, give --up y"
    ]
    # The other way along the axis; and of a GLB, whose y is up as a rule, the axis that its coordinates have.
    hanging = placed(stack(4), np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    assert doubts(hanging)[0].endswith("if -y is up, give --up -y")
    assert doubts(hanging, up="y")[0].endswith("if z is up, give --up z")
    assert doubts(swapped, up="y")[0].endswith("if -z is up, give --up -z")
    assert "the density is 2.7 kg/m3" in doubts(stack(2).with_(density=np.full(3, 2.7)))[0]


def test_examples_and_arches_are_beyond_doubt(root):
    for path in (root / "examples").glob("*.toml"):
        if path.stem != "basilica":
            assert doubts(read(path)) == []
    assert doubts(placed(arch(15, 0.2), np.eye(3))) == []


def test_what_is_doubted_of_a_scene_can_be_done_about_a_scene():
    long, short = scaled(1000.0), scaled(1e-5)
    for odd in (long, short):
        assert doubts(odd, scene=True) == [text for text in doubts(odd, scene=True) if "--" not in text]
        assert "a scene is in metres" in doubts(odd, scene=True)[0]
        assert "--units" in doubts(odd)[0]


def test_the_command_warns_and_the_options_mend_it(tmp_path, capsys, recwarn):
    path = bare(placed(stack(3), 1000.0 * np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])), tmp_path / "a.obj")

    def run(*words):
        recwarn.clear()
        words = ["check", str(path), "--supports", "ground", *words]
        return _status(lambda: app(words, standalone_mode=False), "blockstat"), " ".join(
            str(w.message) for w in recwarn
        )

    status, warned = run()
    assert "--units mm" in warned
    assert "--up y" in warned
    status, warned = run("--units", "mm", "--up", "y")
    assert (status, warned) == (0, "")
    assert "Stable" in capsys.readouterr().out


def test_a_glb_written_with_z_up_stands_when_that_is_said(tmp_path):
    """Millimetres, z up and gaps of 2 mm, as trimesh writes a model that was drawn so."""
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    for k in range(4):
        stone = trimesh.creation.box(extents=(400.0, 300.0, 500.0))
        stone.apply_translation((0.0, 0.0, 502.0 * k))
        scene.add_geometry(stone, node_name=f"stone{k}", geom_name=f"stone{k}")
    path = tmp_path / "pier.glb"
    scene.export(path)
    pier = read(path, supports=["stone0"], units="mm", up="z")
    assert pier.centroid[:, 2] == pytest.approx([0.0, 0.502, 1.004, 1.506])
    assert assess(pier).outcome.word == "stable"
    assert doubts(pier) == []
    # As its format says, y is up: the pier lies on its side, and nothing carries it.
    lying = read(path, supports=["stone0"], units="mm")
    assert np.ptp(lying.centroid[:, 2]) == pytest.approx(0.0, abs=1e-12)
    assert assess(lying).outcome.word == "unstable"
    assert doubts(lying, up="y")[0].endswith("if z is up, give --up z")
    assert (read(path, supports=["stone0"], units="mm", up="y").vertices == lying.vertices).all()


#: Commands that search for joints, with what a tower of two cubes of 0.1 m says that is read with its gaps of 2 mm.
SEARCHES = {
    "check": ([], '"verdict": "stable"'),
    "limit": (["--load", "1,0,0"], '"status": "limit"'),
    "limit all round": (["--directions", "4"], '"outcome": "limit"'),
    "tilt": (["--axis", "x"], '"angle_deg": 26.'),
    "capacity": (["--load", "1,0,0", "--steps", "3"], '"outcome": "zero"'),
    "settle": (["--move", "ground:0,0,-0.001"], '"outcome"'),
    "sequence": (["--courses"], '"most_held": 0'),
    "cases": (["--loads", "LOADS"], '"status": "limit"'),
    "code-check": (["--load", "1,0,0"], '"alpha0": 0.490'),
    "friction": ([], '"outcome": "always_stands"'),
    "tie": (["--between", "cube0,cube1"], '"outcome": "no_greatest"'),
}


@pytest.mark.parametrize("command", SEARCHES)
def test_every_command_that_searches_for_joints_takes_a_stated_gap(command, tmp_path, capsys):
    blocks = [box((-100, -100, -50), (200, 200, 0), name="ground")]
    blocks += [box((0, 0, 102 * k + 2), (100, 100, 102 * k + 102), name=f"cube{k}") for k in range(2)]
    path = write(Assembly.from_blocks(blocks, supports=[0]), tmp_path / "tower.glb")
    (tmp_path / "loads.toml").write_text(
        '[loads.push]\nkind = "acceleration"\ndirection = [0.1, 0, 0]\n[cases.push]\nlive = { push = 1.0 }\n'
    )
    own, expected = SEARCHES[command]
    own = [str(tmp_path / "loads.toml") if text == "LOADS" else text for text in own]
    arguments = [command.split()[0], str(path), "--units", "mm", *own, "--json"]
    _status(lambda: app(arguments, standalone_mode=False), "blockstat")
    assert expected not in capsys.readouterr().out
    assert _status(lambda: app([*arguments, "--gap", "2 mm"], standalone_mode=False), "blockstat") == 0
    assert expected in capsys.readouterr().out


@pytest.mark.parametrize("name", ["a.obj", "a.glb", "a.stl", "a.ply", "a.json", "folder"])
@pytest.mark.parametrize(("units", "up"), [("mm", "z"), ("in", "-x"), ("cm", "y"), (None, None)])
def test_what_is_written_in_a_frame_is_read_in_it(name, units, up, tmp_path):
    ring = arch(9, 0.3).with_(gravity=STANDARD_GRAVITY)  # STL and PLY hold none
    supports = [ring.names[i] for i in np.flatnonzero(ring.support)]
    if name in ("a.stl", "a.ply"):  # they hold no names
        supports = np.flatnonzero(ring.support).tolist()
    path = write(ring, tmp_path / name, units=units, up=up)
    found = read(path, supports=supports, units=units, up=up)
    order = [found.names.index(own) for own in ring.names] if name not in ("a.stl", "a.ply") else slice(None)
    assert found.centroid[order] == pytest.approx(ring.centroid, abs=1e-5)
    assert found.gravity == pytest.approx(ring.gravity)


def test_ties_and_the_unit_of_a_frame_are_in_the_file(tmp_path):
    tie = Tie(("ground", "stone0"), ((0.1, 0.2, 0.0), (0.1, 0.2, 0.3)))
    path = write(stack(1).with_(ties=[tie]), tmp_path / "a.json", units="mm", up="y")
    data = json.loads(path.read_text())
    assert data["units"] == "mm"
    assert np.ptp(data["ties"][0]["points"], axis=0) == pytest.approx([0, 300, 0])
    assert np.allclose(read(path, units="mm", up="y").ties[0].points, tie.points)
    with pytest.raises(InputError, match="known are: m, dm"):
        write(stack(1), tmp_path / "b.json", units="ells")


@pytest.mark.parametrize("name", ["clean.glb", "clean.obj", "clean.json"])
def test_a_repaired_file_is_in_the_frame_of_the_file(name, tmp_path, capsys):
    """Millimetres, z up: `repair` and `check` with the same options see the same blocks; no supports are needed."""
    rough = write(stack(3), tmp_path / "rough.glb", units="mm", up="z")
    frame = ("--units", "mm", "--up", "z")
    run = lambda *words: _status(lambda: app([*map(str, words)], standalone_mode=False), "blockstat")  # noqa: E731
    assert run("repair", rough, *frame, "-o", tmp_path / name) == 0
    assert "in mm, z up; read it with --units mm --up z" in capsys.readouterr().out
    clean = read(tmp_path / name, units="mm", up="z", supports=["ground"])
    assert clean.centroid == pytest.approx(read(rough, units="mm", up="z").centroid, abs=1e-6)
    assert run("convert", rough, *frame, "-o", tmp_path / "plain.glb") == 0
    assert "in m, y up" in capsys.readouterr().out
    assert read(tmp_path / "plain.glb").centroid == pytest.approx(clean.centroid, abs=1e-6)


def test_repair_doubts_units_as_check_does(tmp_path):
    path = write(stack(2), tmp_path / "a.glb", units="mm", up="z")
    with pytest.warns(InputWarning, match="give --units mm"):
        app(["repair", str(path), "--up", "z", "-o", str(tmp_path / "b.glb")], standalone_mode=False)


def test_a_file_that_does_not_speak_of_gravity_leaves_it_along_z_whatever_is_up(tmp_path):
    cube = box((0, 0, 0), (1, 1, 1))
    blocks = [{"vertices": np.array(cube.vertices).tolist(), "faces": [list(face) for face in cube.faces]}]
    path = tmp_path / "cube.json"
    path.write_text(json.dumps({"blocks": blocks, "supports": [0]}))
    for up in (None, *UP):
        assert read(path, up=up).gravity.tolist() == list(STANDARD_GRAVITY)
    path.write_text(json.dumps({"blocks": blocks, "supports": [0], "gravity": [0, -9.81, 0]}))
    np.testing.assert_allclose(read(path, up="y").gravity, STANDARD_GRAVITY, atol=1e-12)
