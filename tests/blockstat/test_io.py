import json

import numpy as np
import pytest

from blockstat import InputError, InputWarning, assess, build, find_interfaces, load_scene, read, write, write_verdict
from blockstat.io.mesh import _loop
from blockstat.io.parts import UNITS
from evidence.scenes.small import arch, assembly, box


@pytest.fixture(scope="module")
def chapel(root):
    return build(load_scene(root / "examples" / "chapel.toml"))


def test_native_json_is_exact(tmp_path, chapel):
    back = read(write(chapel, tmp_path / "chapel.json"))
    np.testing.assert_array_equal(back.vertices, chapel.vertices)
    np.testing.assert_array_equal(back.face_vertices, chapel.face_vertices)
    np.testing.assert_array_equal(back.support, chapel.support)
    np.testing.assert_array_equal(back.gravity, chapel.gravity)
    np.testing.assert_array_equal(back.density, chapel.density)
    assert (back.names, back.groups, back.friction) == (chapel.names, chapel.groups, chapel.friction)
    assert back.metadata == chapel.metadata


@pytest.mark.parametrize("suffix", [".obj", ".glb", ".stl", ".ply"])
def test_meshes_come_back_as_the_same_blocks(tmp_path, chapel, suffix):
    path = write(chapel, tmp_path / f"chapel{suffix}")
    back = read(path, supports=None if suffix == ".glb" else [0])
    if suffix in (".obj", ".glb"):
        assert back.names == chapel.names
    np.testing.assert_allclose(back.volume, chapel.volume, rtol=1e-5)
    np.testing.assert_allclose(back.centroid, chapel.centroid, atol=1e-5)
    assert len(back.face_block) == len(chapel.face_block)  # triangles are joined to polygons again
    assert find_interfaces(back).pair.tolist() == find_interfaces(chapel).pair.tolist()
    assert assess(back).outcome is assess(chapel).outcome


def test_glb_keeps_groups_supports_density_and_stands_upright(tmp_path):
    asm = assembly(
        [
            box((0, 0, 0), (1, 1, 1), name="base", group="g.a"),
            box((0, 0, 1), (1, 1, 3), density=7.0, name="top"),
        ]
    )
    path = write(asm, tmp_path / "two.glb")
    back = read(path)
    assert back.groups == ("g.a", "")
    assert back.density.tolist() == [1.0, 7.0]
    assert back.support.tolist() == [True, False]
    assert back.gravity.tolist() == [0, 0, -1]
    import trimesh

    lower, upper = trimesh.load_scene(path).bounds
    assert upper[1] - lower[1] == pytest.approx(3.0)  # y is up in GLB
    # As glTF 2.0 says: column by column, (x, y, z) to (x, z, -y), and nothing but a rotation.
    raw = path.read_bytes()
    content = json.loads(raw[20 : 20 + int.from_bytes(raw[12:16], "little")])
    turns = [node["matrix"] for node in content["nodes"] if "mesh" in node]
    assert turns == 2 * [[1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]]


def test_concave_faces_survive_a_mesh(tmp_path):
    from blockstat import Block

    plan = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    n = len(plan)
    faces = [
        list(range(n))[::-1],
        list(range(n, 2 * n)),
        *([i, (i + 1) % n, (i + 1) % n + n, i + n] for i in range(n)),
    ]
    asm = assembly(
        [
            Block([(x, y, z) for z in (0, 1) for x, y in plan], faces, "u"),
            box((0, 0, -1), (3, 3, 0), name="g"),
        ]
    )
    for suffix in (".obj", ".glb"):
        back = read(write(asm, tmp_path / f"u{suffix}"), supports=[1])
        assert back.volume[0] == pytest.approx(5.0, rel=1e-6)
        assert sorted(np.diff(back.face_start)) == sorted(np.diff(asm.face_start))


def test_other_keys_are_kept_and_a_repeated_name_is_numbered(tmp_path):
    path = tmp_path / "named.json"
    write(arch(4, 0.2), path)
    data = json.loads(path.read_text())
    for block in data["blocks"]:
        block["name"] = "Mesh"
    path.write_text(json.dumps(data | {"author": "me"}))
    with pytest.warns(InputWarning, match='several blocks share a name \\("Mesh"\\)'):
        back = read(path)
    assert back.names[:3] == ("Mesh.0", "Mesh.1", "Mesh.2")
    assert back.metadata == {"author": "me"}
    path.write_text(json.dumps(data | {"supports": ["Mesh"]}))
    with pytest.raises(InputError, match='6 blocks are named "Mesh"; give their indices'):
        read(path)


def test_faces_listed_twice_count_once(tmp_path):
    asm = arch(4, 0.2)
    path = write(asm, tmp_path / "doubled.json")
    data = json.loads(path.read_text())
    data["blocks"][3]["faces"] += [face[1:] + face[:1] for face in data["blocks"][3]["faces"]]
    path.write_text(json.dumps(data))
    with pytest.warns(InputWarning, match='1 blocks list faces twice \\(the first is "voussoir1"\\)'):
        back = read(path)
    np.testing.assert_allclose(back.volume, asm.volume)


def test_not_a_mesh(tmp_path):
    path = tmp_path / "junk.glb"
    path.write_bytes(b"no mesh at all")
    with pytest.raises(InputError, match=r"junk\.glb: cannot be read as a mesh"):
        read(path, supports=[0])


def test_open_solid_in_a_mesh_is_named(tmp_path):
    path = write(arch(4, 0.2), tmp_path / "open.obj")
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:-1]) + "\n")
    with pytest.raises(InputError, match='block "voussoir3": its surface is open'):
        read(path, supports=["left", "right"])


def test_writing_nowhere(tmp_path):
    with pytest.raises(InputError, match="no such directory"):
        write(arch(4, 0.2), tmp_path / "gone" / "a.json")
    with pytest.raises(InputError, match='cannot write "\\.doc"'):
        write(arch(4, 0.2), tmp_path / "a.doc")


ODD = [
    "plain",
    "with blanks",
    "two  blanks",
    "a/b\\c",
    "камень ☃",
    "50 %",
    "#3 {x}",
    ".hidden",
    "world",
    "tab\there",
    "nul.",
]


def odd_names():
    """A tower of bricks with names that some format might not like, far from the origin."""
    blocks = [
        box(
            (7, 8, k),
            (8, 9, k + 1 + (k + 1) / 300),
            name=name,
            density=1.0 + k % 3,
            group=["", "wall", "wall.north side", "a/b.c"][k % 4],
        )
        for k, name in enumerate(ODD)
    ]
    return assembly(blocks, supports=[0, 3], friction=0.55)


def corners_of(asm, name):
    corners = asm.block_vertices(asm.names.index(name))
    return corners[np.lexsort(np.round(corners, 4).T)]


@pytest.mark.parametrize("target", ["odd.json", "odd.obj", "odd.glb", "folder"])
def test_names_groups_and_corners_survive(tmp_path, target):
    asm = odd_names()
    back = read(write(asm, tmp_path / target), supports=["plain", "a/b\\c"] if target == "folder" else None)
    assert set(back.names) == set(ODD)
    order = [back.names.index(name) for name in ODD]
    assert [back.groups[i] for i in order] == list(asm.groups)
    assert back.support[order].tolist() == asm.support.tolist()
    if target != "folder":
        assert back.names == asm.names
        assert back.density.tolist() == asm.density.tolist()
        assert (back.friction, back.gravity.tolist()) == (asm.friction, asm.gravity.tolist())
    rtol = 0.0 if target in ("odd.json", "odd.obj") else 1e-6
    for name in ODD:
        np.testing.assert_allclose(corners_of(back, name), corners_of(asm, name), rtol=rtol)


@pytest.mark.parametrize("format", [None, "ply", "stl"])
def test_a_directory_holds_one_file_a_block(tmp_path, chapel, format):
    directory = write(chapel, tmp_path / "chapel", format=format)
    suffix = f".{format or 'ply'}"
    files = [p for p in directory.rglob("*") if p.is_file()]
    assert {p.suffix for p in files} == {suffix}
    assert len(files) == chapel.n_blocks
    supports = [chapel.names[i] for i in np.flatnonzero(chapel.support)]
    back = read(directory, supports=supports)
    assert sorted(zip(back.names, back.groups, strict=True)) == sorted(zip(chapel.names, chapel.groups, strict=True))
    assert find_interfaces(back).n_interfaces == find_interfaces(chapel).n_interfaces
    assert assess(back.with_(friction=chapel.friction)).outcome is assess(chapel).outcome
    with pytest.raises(InputError, match="already holds"):
        write(chapel, directory)


def test_bad_directories(tmp_path):
    with pytest.raises(InputError, match=r"the directory holds no \.ply, \.stl or \.obj files"):
        read(tmp_path, supports=[0])
    (tmp_path / "stone.stl").write_text("not a mesh")
    with pytest.raises(InputError, match=r"stone\.stl: cannot be read as a mesh|stone\.stl: is no surface"):
        read(tmp_path, supports=[0])
    with pytest.raises(InputError, match='cannot be written as "obj"; it can be: ply, stl'):
        write(arch(3, 0.2), tmp_path, format="obj")


#: The metre and its parts, and the international inch and foot.
METRES = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}


@pytest.mark.parametrize(("units", "metres"), METRES.items())
def test_other_units_are_converted_on_request(tmp_path, units, metres):
    asm = arch(4, 0.2)
    for path in (
        write(asm.with_(vertices=asm.vertices / metres), tmp_path / "arch.obj"),
        write(asm.with_(vertices=asm.vertices / metres), tmp_path / "arch.json", format="compas-assembly"),
    ):
        np.testing.assert_allclose(read(path, units=units).vertices, asm.vertices, rtol=0, atol=1e-15)
    assert set(UNITS) == set(METRES)


def test_units_that_a_file_names(tmp_path):
    path = write(arch(4, 0.2), tmp_path / "arch.json")
    with pytest.raises(InputError, match='units are "m" in the file and "mm" were asked for'):
        read(path, units="mm")
    data = json.loads(path.read_text())
    path.write_text(json.dumps(data | {"units": "mm"}))
    with pytest.raises(InputError, match='units are "mm"; only "m" is read unless others are asked for'):
        read(path)
    np.testing.assert_allclose(read(path, units="mm").vertices, arch(4, 0.2).vertices / 1000, rtol=1e-15)
    del data["units"]
    path.write_text(json.dumps(data))
    np.testing.assert_allclose(read(path, units="cm").vertices, arch(4, 0.2).vertices / 100, rtol=1e-15)


def test_unknown_units(tmp_path, root):
    path = write(arch(4, 0.2), tmp_path / "arch.obj")
    with pytest.raises(InputError, match="units are 'furlong'; known are: m, dm, cm, mm, in, ft"):
        read(path, units="furlong")
    with pytest.raises(InputError, match="a scene is in metres"):
        read(root / "examples" / "chapel.toml", units="mm")


def glb_nodes(path):
    """Extras of the nodes of a GLB that have a mesh, read without trimesh."""
    raw = path.read_bytes()
    content = json.loads(raw[20 : 20 + int.from_bytes(raw[12:16], "little")])
    return [node["extras"] for node in content["nodes"] if "mesh" in node]


def test_a_verdict_becomes_attributes_of_the_blocks(tmp_path):
    verdict = assess(arch(12, 0.08))
    nodes = glb_nodes(write_verdict(verdict, tmp_path / "thin.glb"))
    text = write_verdict(verdict, tmp_path / "thin.obj").read_text()
    notes = [json.loads(line[len("# blockstat ") :]) for line in text.splitlines() if line.startswith("# blockstat")][
        1:
    ]
    assert [node["name"] for node in nodes] == list(verdict.assembly.names)
    for rows in (nodes, notes):
        assert [row["displacement"] for row in rows] == verdict.motion.tolist()
        assert [row["mechanism"] for row in rows] == verdict.mechanism.tolist()
        assert [row["demand"] for row in rows] == verdict.demand().tolist()
        assert [row["support"] for row in rows] == verdict.assembly.support.tolist()
    assert max(row["displacement"] for row in nodes) == pytest.approx(1.0)
    assert read(tmp_path / "thin.glb").names == read(tmp_path / "thin.obj").names == verdict.assembly.names


def test_values_that_do_not_fit(tmp_path):
    asm = arch(4, 0.2)
    for values in ({"a": [1.0]}, {"a": [np.nan] * 6}, {"name": [1.0] * 6}, {"a": 1.0}, {"a": ["x"] * 6}):
        with pytest.raises(InputError, match="one finite number or list a block"):
            write(asm, tmp_path / "a.glb", values=values)
    for target in ("a.json", "a.stl", "folder"):
        with pytest.raises(InputError, match=r"values are written to \.glb and \.obj only"):
            write(asm, tmp_path / target, values={"a": [1.0] * 6})


def test_the_outline_of_triangles_is_one_loop_or_none():
    square = np.array([(0, 1, 2), (0, 2, 3)])

    def loop(triangles, *boundary):
        return _loop(np.array(triangles), {tuple(sorted(edge)) for edge in boundary})

    assert loop(square, (0, 1), (1, 2), (2, 3), (3, 0)) == [0, 1, 2, 3]
    assert loop(square[:, ::-1], (0, 1), (1, 2), (2, 3), (3, 0)) == [2, 1, 0, 3]
    assert loop(square) == []  # no edge is on the boundary
    assert loop(square, (0, 1), (1, 2), (2, 3)) == []  # the loop is open
    assert loop(square, (0, 1), (1, 2), (2, 0), (2, 3), (3, 0)) == []  # two edges leave a corner
    apart = [(0, 1, 2), (3, 4, 5)]
    assert loop(apart, (0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3)) == []  # two loops
