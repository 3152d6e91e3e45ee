import json

import numpy as np
import pytest

from blockstat import InputError, InputWarning, assess, build, find_interfaces, load_scene, read, write
from problems import arch, assembly, box


@pytest.fixture(scope="module")
def chapel(root):
    return build(load_scene(root / "examples" / "chapel.toml"))


def test_native_json_is_exact(tmp_path, chapel):
    back = read(write(chapel, tmp_path / "chapel.json"))
    np.testing.assert_array_equal(back.vertices, chapel.vertices)
    np.testing.assert_array_equal(back.face_vertices, chapel.face_vertices)
    np.testing.assert_array_equal(back.support, chapel.support)
    np.testing.assert_array_equal(back.gravity, chapel.gravity)
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
