"""What is wrong in an input is told at once, a line each."""

import json
import pickle
import subprocess
import sys

import pytest

from blockstat import Assembly, Block, InputError, box, build, load_scene, read, scene_from, write
from blockstat.errors import MOST_TOLD, gathered
from evidence.scenes.small import stack

HUT = """
length = 4.0
span = "wide"
wall = { thickness = 0.5, hieght = 2.0 }
[doors.south]
width = 1.0
height = -2.0
[loads.wind]
kind = "gale"
[ties.chain]
between = ["a"]
points = [[0, 0, 0], [1, 0, 0]]
"""
GATE = """
[parameters]
t = 0.5
wide = "= narow * 2"
[elements.pier]
kind = "pier"
size = [0.5, "= t"]
height = "high"
courses = 3
bond = "flemish"
[elements.ring]
kind = "ark"
[elements.drum]
kind = "box"
size = ["= wide", 1.0, 1.0]
hight = 2.0
[material]
friction = -1.0
[[joints]]
between = ["pier", "ring"]
cohesoin = 1.0
[loads.wind]
kind = "gale"
[cases.storm]
live = { rain = 1.0 }
[uncertain.friction]
kind = "gamma"
"""


def lines_of(call) -> list[str]:
    with pytest.raises(InputError) as refused:
        call()
    assert type(refused.value) is InputError
    return str(refused.value).splitlines()


def begins(lines, *starts):
    assert len(lines) == len(starts), lines
    for line, start in zip(lines, starts, strict=True):
        assert line.startswith(start), line


def test_all_errors_of_a_building_are_told(tmp_path):
    path = tmp_path / "hut.toml"
    path.write_text(HUT)
    begins(
        lines_of(lambda: load_scene(path)),
        f"{path}: span: it must be a number or a table, not a text",
        f"{path}: wall.hieght: unknown key; keys here are: thickness, height",
        f"{path}: doors.south.height: it must be a number above 0",
        f"{path}, line 9: loads.wind.kind: no kind 'gale'; kinds are: point",
        f"{path}, line 11: ties.chain.between: ",
    )


def test_all_errors_of_a_composition_are_told(tmp_path):
    path = tmp_path / "gate.toml"
    path.write_text(GATE)
    begins(
        lines_of(lambda: load_scene(path)),
        f'{path}: parameters.wide: "= narow * 2": no parameter "narow"; parameters are: t, wide',
        f"{path}: elements.pier.height: it must be a number",
        f"{path}: elements.pier.bond: Invalid enum value 'flemish'; it must be one of: ",
        f'{path}: elements.ring.kind: no kind "ark"; kinds are: ',
        f"{path}: elements.drum.hight: unknown key; keys here are: ",
        f"{path}: material.friction: it must be a number of at least 0",
        f"{path}: joints.0.cohesoin: unknown key; keys here are: between",
        f"{path}, line 23: loads.wind.kind: no kind 'gale'",
        f'{path}, line 25: cases.storm.live.rain: no load "rain"; loads are: wind',
        f"{path}, line 27: uncertain.friction.kind: Invalid enum value 'gamma'; it must be one of: normal",
    )


def test_a_wrong_key_of_the_scene_does_not_hide_wrong_elements():
    data = {"name": "gate", "elements": {"pier": {"kind": "peir"}}, "lods": {}, "supports": "ground"}
    begins(
        lines_of(lambda: scene_from(data)),
        "lods: unknown key; keys here are: ",
        "supports: it must be a list, not a text",
        'elements.pier.kind: no kind "peir"; kinds are: ',
    )


def test_an_element_that_cannot_be_built_does_not_hide_another():
    piers = {
        name: {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 3, "bond": "flemish"} for name in "ab"
    }
    arch = {"kind": "arch", "span": 2.0, "thickness": 0.3, "depth": 1.0, "voussoirs": 9, "shape": "round"}
    data = {"name": "gate", "elements": {"ring": arch, "other": arch | {"shape": "flat"}}}
    begins(
        lines_of(lambda: build(scene_from(data))),
        "elements.ring: shape is 'round'; it must be one of: ",
        "elements.other: shape is 'flat'; it must be one of: ",
    )
    begins(
        lines_of(lambda: scene_from({"name": "gate", "elements": piers})),
        "elements.a.bond: ",
        "elements.b.bond: ",
    )


def test_all_errors_of_a_json_file_are_told_by_block(tmp_path, capsys):
    path = write(stack(3), tmp_path / "stack.json")
    data = json.loads(path.read_text())
    data["blocks"][0]["density"] = "heavy"
    data["blocks"][1]["vertices"][3] = [0, 0, "up"]
    data["friction"] = None
    path.write_text(json.dumps(data))
    from blockstat.cli.commands import app
    from blockstat.cli.options import _status

    assert _status(lambda: app(["check", str(path)], standalone_mode=False), "blockstat") == 2
    names = [block["name"] for block in data["blocks"]]
    begins(
        capsys.readouterr().err.splitlines(),
        f'blockstat: {path}: block "{names[0]}": density: it must be a number, not a text',
        f'blockstat: {path}: block "{names[1]}": vertices[3][2]: it must be a number, not a text',
        f"blockstat: {path}: friction: it must be a number, not null",
    )


def test_all_errors_of_blocks_given_in_python_are_told():
    blocks = [box((0, 0, k), (1, 1, k + 1), name=f"b{k}") for k in range(4)]
    blocks[1] = Block(blocks[1].vertices[:3], blocks[1].faces, "b1")
    blocks[2] = Block(blocks[2].vertices, blocks[2].faces, "b2", density=-1.0)
    begins(
        lines_of(lambda: Assembly.from_blocks(blocks, supports=["b0", "b9"], friction=-1, gravity=(0, 0))),
        'block "b1": vertices have shape (3, 3)',
        'block "b2": density is -1.0',
        'supports: no block "b9"',
        "friction is -1",
        "gravity is (0, 0)",
    )


def test_open_and_inverted_and_flat_blocks_are_told_together():
    blocks = [box((0, 0, k), (1, 1, k + 1), name=f"b{k}") for k in range(4)]
    blocks[1] = Block(blocks[1].vertices, blocks[1].faces[:-1], "b1")
    blocks[3] = Block(blocks[3].vertices, [list(blocks[3].faces[0])[::-1], *blocks[3].faces[1:]], "b3")
    begins(
        lines_of(lambda: Assembly.from_blocks(blocks)),
        'block "b1": its surface is open',
        'block "b3": face 0 is inverted',
    )


def test_all_bad_lines_of_an_obj_file_are_told(tmp_path):
    path = write(stack(2), tmp_path / "stack.obj")
    lines = path.read_text().splitlines()
    vertex = next(k for k, line in enumerate(lines) if line.startswith("v "))
    face = max(k for k, line in enumerate(lines) if line.startswith("f "))
    note = next(k for k, line in enumerate(lines) if line.startswith("# blockstat") and "density" in line)
    lines[vertex], lines[face], lines[note] = "v 0 0 up", "f 1 2 999", "# blockstat {density: 1}"
    path.write_text("\n".join(lines))
    why = {
        vertex: 'cannot be read as "v" of an OBJ file',
        face: '"f" has the corner 999, and 24 vertices come before it',  # three cubes
        note: 'cannot be read as "# blockstat" of an OBJ file',
    }
    assert lines_of(lambda: read(path)) == [f"{path}: line {number + 1}: {why[number]}" for number in sorted(why)]
    scene = {"name": "shell", "elements": {"shell": {"kind": "mesh_vault", "file": str(path), "thickness": 0.1}}}
    told = lines_of(lambda: build(scene_from(scene)))
    assert [line.partition(f"{path}: line ")[2].split(":")[0] for line in told] == [
        str(k + 1) for k in sorted([vertex, face, note])
    ]


def glb_of(path, spoil):
    """Write a GLB of four triangulated cubes, of which `spoil` changes the vertices and faces by number."""
    import trimesh

    scene = trimesh.Scene()
    for k in range(4):
        cube = trimesh.creation.box(extents=(1, 1, 1))
        vertices, faces = spoil(k, cube.vertices + [2 * k, 0, 0], cube.faces.copy())
        name = f"cube{k}"
        scene.add_geometry(trimesh.Trimesh(vertices, faces, process=False), node_name=name, geom_name=name)
    scene.export(path)
    return path


def far_away(k, vertices, faces):
    if k in (1, 3):
        vertices[[2, 5], 0] = 2e30
    return vertices, faces


def lost(k, vertices, faces):
    if k in (0, 2):
        faces[[1, 4], 0] = 99
    return vertices, faces


def test_all_bad_objects_of_a_glb_are_told(tmp_path):
    path = glb_of(tmp_path / "cubes.glb", far_away)
    assert lines_of(lambda: read(path, supports=["cube0"])) == [
        f'{path}: object "cube{k}": coordinates must be finite and below 1e+30 (vertex 2, 5)' for k in (1, 3)
    ]
    path = glb_of(tmp_path / "lost.glb", lost)
    assert lines_of(lambda: read(path, supports=["cube1"])) == [
        f'{path}: object "cube{k}": a face has a corner that does not exist (face 1, 4)' for k in (0, 2)
    ]


PLY = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 4
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
0 0 TOP
3 0 2 1
3 0 1 3
3 1 2 3
3 2 0 LAST
"""


def test_all_bad_files_of_a_folder_are_told_by_their_place(tmp_path):
    stones = tmp_path / "stones"
    for place, top, last in [("1", "1", "3"), ("2", "nan", "3"), ("wall/3", "1", "7"), ("wall/4", "1", "3")]:
        file = stones / f"{place}.ply"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(PLY.replace("TOP", top).replace("LAST", last))
    (stones / "wall" / "5.stl").write_text("solid nothing\nendsolid nothing\n")
    begins(
        lines_of(lambda: read(stones, supports=[0])),
        f"{stones}: 2.ply: coordinates must be finite and below 1e+30 (vertex 3)",
        f"{stones}: wall/3.ply: a face has a corner that does not exist (face 3)",
        f"{stones}: wall/5.stl: ",
    )


def test_all_errors_of_a_compas_assembly_are_told(tmp_path):
    path = write(stack(4), tmp_path / "stack.json", format="compas-assembly")
    data = json.loads(path.read_text())
    nodes = data["data"]["graph"]["data"]["node"]
    nodes["0"]["block"] |= {"dtype": "compas.geometry/Brep", "inheritance": []}
    nodes["1"]["block"]["data"]["vertex"]["3"]["x"] = "far"
    nodes["1"]["block"]["data"]["vertex"]["5"]["x"] = "far"
    nodes["1"]["block"]["data"]["vertex"]["6"]["z"] = 10**400
    del nodes["2"]["block"]["data"]["vertex"]["7"]
    nodes["3"]["block"]["data"]["face"] = []
    path.write_text(json.dumps(data))
    names = [node["block"]["name"] for node in nodes.values()]
    faces = [key for key, face in nodes["2"]["block"]["data"]["face"].items() if 7 in face]
    bad = "the mesh has a bad vertex or corner"
    assert lines_of(lambda: read(path)) == [
        f'{path}: node 0: geometry is a "compas.geometry/Brep"; only meshes ("compas.datastructures/Mesh") are read',
        f"{path}: block \"{names[1]}\": {bad}: could not convert string to float: 'far' (vertex 3, 5)",
        f'{path}: block "{names[1]}": {bad}: int too large to convert to float (vertex 6)',
        f"{path}: block \"{names[2]}\": {bad}: '7' (face {', '.join(faces)})",
        f"{path}: node 3: face: it must be a table, not a list",
    ]


def test_all_errors_of_a_compas_model_are_told(tmp_path):
    path = write(stack(4), tmp_path / "stack.json", format="compas-model")
    data = json.loads(path.read_text())
    guids = list(data["data"]["elements"])
    elements = [data["data"]["elements"][guid]["data"] for guid in guids]
    turned = {"dtype": "compas.geometry/Rotation", "data": {"matrix": [[1, 0], [0, 10**400]]}}
    data["data"]["transformation"] = turned
    elements[0]["transformation"] = turned
    elements[1]["transformation"] = {"data": {}}
    elements[2]["name"] = ""
    data["data"]["elements"][guids[2]]["name"] = None
    elements[2]["geometry"]["data"]["vertex"]["3"]["x"] = None
    elements[3]["material"] = ["stone"]
    elements[3]["geometry"] = "a mesh"
    data["data"]["tree"]["root"]["children"].append({"element": "nobody", "children": [{"element": "no one"}]})
    path.write_text(json.dumps(data))
    begins(
        lines_of(lambda: read(path)),
        f'{path}: model: a "compas.geometry/Rotation" is neither a 4 by 4 matrix nor a frame',
        f'{path}: element "{elements[0]["name"]}": a "compas.geometry/Rotation" is neither',
        f'{path}: element "{elements[1]["name"]}": transformation: dtype is missing; keys here are: dtype,',
        f'{path}: block "{guids[2]}": the mesh has a bad vertex or corner: float() argument must be a string or a',
        f'{path}: element "{elements[3]["name"]}": a "compas_dem.elements',
        f'{path}: tree: no element "nobody"',
        f'{path}: tree: no element "no one"',
    )


def test_the_command_tells_a_line_each_and_ends_with_2(tmp_path):
    path = tmp_path / "hut.toml"
    path.write_text(HUT)
    run = subprocess.run([sys.executable, "-m", "blockstat", "check", path], capture_output=True, text=True)
    assert run.returncode == 2
    assert run.stdout == ""
    lines = run.stderr.splitlines()
    assert len(lines) == 5
    assert all(line.startswith(f"blockstat: {path}") for line in lines)


def test_one_fault_that_many_name_is_told_once():
    def refuse():
        raise InputError("friction is -1")

    assert lines_of(lambda: gathered([refuse, refuse, lambda: 3])) == ["friction is -1"]
    assert gathered([lambda: 3]) == [3]


def test_a_thousand_errors_are_counted():
    error = InputError(*(f"block {k} is open" for k in range(1000)))
    lines = str(error).splitlines()
    assert len(lines) == MOST_TOLD + 1
    assert lines[-1] == f"and {1000 - MOST_TOLD} more errors"
    assert pickle.loads(pickle.dumps(error)).args == error.args
    assert error.under("a.json").args[999] == "a.json: block 999 is open"
