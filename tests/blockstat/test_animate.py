"""The animated GLB: read back by trimesh, and parsed by hand against the mechanism it shows."""

import json
import struct

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import InputError, assess, limit_load, read
from blockstat.view.animation import write_mechanism
from blockstat.view.plot import mechanism_pose
from evidence.scenes.small import arch, running_bond

TYPES = {5126: ("<f4", 4), 5125: ("<u4", 4)}
WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def parse(path):
    """JSON content and a function from accessor index to array, by the letter of the specification."""
    data = path.read_bytes()
    magic, version, total = struct.unpack_from("<4sII", data)
    assert (magic, version, total) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    content = json.loads(data[20 : 20 + size])
    length, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0"
    binary = data[28 + size :]
    assert length == len(binary) == content["buffers"][0]["byteLength"]

    def array(index):
        accessor = content["accessors"][index]
        view = content["bufferViews"][accessor["bufferView"]]
        dtype, item = TYPES[accessor["componentType"]]
        width = WIDTH[accessor["type"]]
        start, count = accessor["byteOffset"], accessor["count"] * width
        assert start + count * item <= view["byteLength"]
        assert view.get("byteStride", width * item) == width * item
        return np.frombuffer(binary, dtype, count, view["byteOffset"] + start).reshape(-1, width)

    return content, array


CASES = {
    "falling arch": lambda: assess(arch(12, 0.08)),
    "pushed arch": lambda: limit_load(arch(12, 0.2), (1, 0, 0)),
    "wall pushed out": lambda: assess(running_bond(4, 3), gravity=(0.1, 0.6, -1)),
}


@pytest.fixture(params=CASES, ids=list(CASES))
def result(request):
    return CASES[request.param]()


def test_at_rest_it_is_the_assembly_turned_to_y_up(result, tmp_path):
    import trimesh

    asm = result.assembly
    scene = trimesh.load_scene(write_mechanism(result, tmp_path / "mech.glb"))
    lower, upper = asm.vertices.min(axis=0), asm.vertices.max(axis=0)
    # (x, y, z) of the z-up assembly is (x, z, -y) of the file.
    np.testing.assert_allclose(
        scene.bounds, [[lower[0], lower[2], -upper[1]], [upper[0], upper[2], -lower[1]]], atol=1e-6
    )
    assert scene.to_mesh().volume == pytest.approx(asm.volume.sum(), rel=1e-5)
    again = read(tmp_path / "mech.glb", supports=[asm.names[i] for i in np.flatnonzero(asm.support)])
    assert again.names == asm.names
    np.testing.assert_allclose(again.centroid, asm.centroid, atol=1e-6)
    np.testing.assert_allclose(again.volume, asm.volume, rtol=1e-5)


@pytest.mark.parametrize("amplitude", [None, 0.03])
def test_half_way_it_is_the_pose_of_the_mechanism(result, amplitude, tmp_path):
    content, array = parse(write_mechanism(result, tmp_path / "mech.glb", amplitude=amplitude, seconds=3.0))
    shift, turn = mechanism_pose(result, amplitude=amplitude)
    asm = result.assembly
    (animation,) = content["animations"]
    moving = np.zeros(asm.n_blocks, dtype=int)
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        assert sampler["interpolation"] == "LINEAR"
        times, values = array(sampler["input"])[:, 0], array(sampler["output"])
        assert (np.diff(times) > 0).all()
        assert (times[0], times[-1]) == (0.0, 3.0)
        node = content["nodes"][channel["target"]["node"]]
        block = asm.names.index(node["name"])
        moving[block] += 1
        middle = values[np.flatnonzero(times == 1.5)[0]]
        # There and back: the same from both ends, and at rest at them.
        np.testing.assert_allclose(values, values[::-1], atol=1e-6)
        if channel["target"]["path"] == "translation":
            np.testing.assert_allclose(values[0], asm.centroid[block], atol=1e-6)
            np.testing.assert_allclose(values[0], node["translation"], atol=1e-6)
            np.testing.assert_allclose(middle, asm.centroid[block] + shift[block], atol=1e-6)
        else:
            np.testing.assert_allclose(values[0], [0, 0, 0, 1])
            np.testing.assert_allclose(np.linalg.norm(values, axis=1), 1.0, atol=1e-6)
            np.testing.assert_allclose(Rotation.from_quat(middle).as_matrix(), turn[block], atol=1e-6)
    assert (moving[asm.support] == 0).all()
    moved = result.mechanism.any(axis=1)
    np.testing.assert_array_equal(moving, np.where(moved, 2, 0))


def test_between_keys_no_corner_strays_from_the_mechanism(tmp_path):
    # Players join keys by straight lines and great circles; the true path is the twist taken s times.
    verdict = assess(arch(12, 0.08))
    content, array = parse(write_mechanism(verdict, tmp_path / "mech.glb", amplitude=0.5))
    (animation,) = content["animations"]
    for channel in animation["channels"]:
        if channel["target"]["path"] == "rotation":
            key = array(animation["samplers"][channel["sampler"]]["output"])
            vector = Rotation.from_quat(key).as_rotvec()
            twist = 0.5 * verdict.mechanism[channel["target"]["node"] - 1, 3:]
            share = (1 - np.cos(2 * np.pi * np.linspace(0, 1, len(key)))) / 2
            np.testing.assert_allclose(vector, share[:, None] * twist, atol=1e-6)
            assert np.linalg.norm(np.diff(vector, axis=0), axis=1).max() < 0.1


def test_arrays_are_what_their_accessors_say(result, tmp_path):
    content, array = parse(write_mechanism(result, tmp_path / "mech.glb"))
    asm = result.assembly
    for index, accessor in enumerate(content["accessors"]):
        values = array(index)
        assert np.isfinite(values).all()
        if "min" in accessor:
            np.testing.assert_array_equal(values.min(axis=0), np.float32(accessor["min"]))
            np.testing.assert_array_equal(values.max(axis=0), np.float32(accessor["max"]))
    views = content["bufferViews"]
    ends = [view["byteOffset"] + view["byteLength"] for view in views]
    assert [view["byteOffset"] for view in views] == [0, *ends[:-1]]
    assert ends[-1] == content["buffers"][0]["byteLength"]
    assert len(content["meshes"]) == asm.n_blocks
    speed = result.motion if hasattr(result, "motion") else None
    colours = []
    for mesh in content["meshes"]:
        (primitive,) = mesh["primitives"]
        corner, normal = (array(primitive["attributes"][key]) for key in ("POSITION", "NORMAL"))
        assert "min" in content["accessors"][primitive["attributes"]["POSITION"]]
        triangles = array(primitive["indices"]).reshape(-1, 3)
        # Flat: the stored normal is that of the triangle, outwards by its winding.
        a, b, c = (corner[triangles[:, k]] for k in range(3))
        face = np.cross(b - a, c - a)
        face /= np.linalg.norm(face, axis=1)[:, None]
        for k in range(3):
            np.testing.assert_allclose(normal[triangles[:, k]], face, atol=1e-4)
        colours.append(array(primitive["attributes"]["COLOR_0"])[0])
    # Plasma brightens all the way.
    if speed is not None:
        free = np.flatnonzero(~asm.support)
        brightness = np.array(colours)[free] @ [0.2126, 0.7152, 0.0722]
        assert (np.diff(brightness[np.argsort(speed[free])]) > -1e-3).all()


def test_bad_animations(tmp_path):
    verdict = assess(arch(12, 0.08))
    with pytest.raises(InputError, match=r"x\.png: an animated mechanism is written as \.glb"):
        write_mechanism(verdict, tmp_path / "x.png")
    with pytest.raises(InputError, match="no such directory"):
        write_mechanism(verdict, tmp_path / "gone" / "x.glb")
    with pytest.raises(InputError, match="seconds is 0"):
        write_mechanism(verdict, tmp_path / "x.glb", seconds=0)
    with pytest.raises(InputError, match="no mechanism to show"):
        write_mechanism(assess(arch(12, 0.2)), tmp_path / "x.glb")
