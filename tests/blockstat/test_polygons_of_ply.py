"""PLY files of polygons, files of nothing, and what formats do not keep."""

import re
import struct
import warnings

import numpy as np
import pytest

from blockstat import (
    Assembly,
    InputError,
    InputWarning,
    JointLaw,
    Tie,
    assess,
    load_scene,
    read,
    write,
    write_verdict,
)
from blockstat.io.surface import read_surface
from evidence.scenes.small import assembly, box, prism

READ = (".json", ".obj", ".glb", ".stl", ".ply")
#: A T in the y-z plane: 2 wide and 1 high below, 6 wide and 1 high above, so an area of 8.
T_SHAPE = [(-1, 0), (1, 0), (1, 1), (3, 1), (3, 2), (-3, 2), (-3, 1), (-1, 1)]


def head(corners, faces, form):
    lines = ["ply", f"format {form} 1.0", f"element vertex {corners}", *(f"property double {axis}" for axis in "xyz")]
    lines += [f"element face {faces}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(lines)


def ply(path, blocks, *, binary=False, shared=False, triangles=()):
    """Write polygons one block after another; the quads of the blocks in `triangles` are cut in two."""
    corners, faces = [], []
    for number, block in enumerate(blocks):
        points = [tuple(map(float, p)) for p in block.vertices]
        if not shared:
            index = {k: len(corners) + k for k in range(len(points))}
            corners += points
        else:
            corners += [p for p in dict.fromkeys(points) if p not in corners]
            index = {k: corners.index(p) for k, p in enumerate(points)}
        for face in block.faces:
            face = [index[int(k)] for k in face]
            faces += [[face[0], *face[1:3]], [face[0], *face[2:]]] if number in triangles else [face]
    if binary:
        data = b"".join(struct.pack("<3d", *p) for p in corners)
        data += b"".join(struct.pack(f"<B{len(f)}i", len(f), *f) for f in faces)
        path.write_bytes(head(len(corners), len(faces), "binary_little_endian").encode() + data)
    else:
        rows = [" ".join(map(repr, p)) for p in corners] + [" ".join(map(str, [len(f), *f])) for f in faces]
        path.write_text(head(len(corners), len(faces), "ascii") + "\n".join(rows) + "\n")
    return path


def pile():
    """Three boxes on one another of 1, 2 and 3 m3, whose corners coincide where the upper begins."""
    return [box((0, 0, z), (1, 1, z + h)) for z, h in ((0, 1), (1, 2), (3, 3))]


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("shared", [False, True])
def test_each_closed_solid_of_quads_is_a_block(tmp_path, binary, shared):
    path = ply(tmp_path / "pile.ply", pile(), binary=binary, shared=shared)
    found = read(path, supports=[0])
    np.testing.assert_allclose(found.volume, [1, 2, 3])
    assert found.names == ("pile.0", "pile.1", "pile.2")
    assert [len(found.faces_of(i)) for i in range(3)] == [6, 6, 6]


def test_solids_of_quads_and_of_triangles_and_of_polygons_in_one_file(tmp_path):
    hexagon = prism([(9, 0), (11, 0), (12, 1), (11, 2), (9, 2), (8, 1)], 2.0)  # area 2 * 2 + 1 + 1
    path = ply(tmp_path / "mixed.ply", [pile()[0], hexagon, pile()[1], pile()[2]], triangles=(2,))
    found = read(path, supports=[0])
    np.testing.assert_allclose(found.volume, [1, 2 * 6, 2, 3])
    assert [len(found.faces_of(i)) for i in range(4)] == [6, 8, 6, 6]


def test_a_concave_polygon_is_one_face(tmp_path):
    for turn in range(8):  # a fan is right from some corners only
        path = ply(tmp_path / "t.ply", [prism([*T_SHAPE[turn:], *T_SHAPE[:turn]], 1.0), pile()[0]])
        found = read(path, supports=[0])
        np.testing.assert_allclose(found.volume, [8, 1])
        assert sorted(len(face) for face in found.faces_of(0)) == [4] * 8 + [8, 8]


def test_a_corner_in_line_with_its_neighbours_leaves_no_gap(tmp_path):
    split = prism([(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)], 1.0)
    np.testing.assert_allclose(read(ply(tmp_path / "s.ply", [split, split]), supports=[0]).volume, [4, 4])


def test_faces_are_numbered_as_in_the_file(tmp_path):
    path = ply(tmp_path / "lost.ply", pile())
    lines = path.read_text().splitlines()
    lines[-1] = "4 0 1 2 24"  # 24 corners, 18 faces
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=r'object "lost": a face has a corner that does not exist \(face 17\)'):
        read(path, supports=[0])


@pytest.mark.parametrize("number", ["nan", "inf", "1e300"])
@pytest.mark.filterwarnings("error")
def test_a_quad_with_a_corner_that_is_nowhere_is_refused_in_words_alone(tmp_path, number):
    path = ply(tmp_path / "far.ply", pile())
    path.write_text(path.read_text().replace("0.0 0.0 0.0\n", f"{number} 0.0 0.0\n", 1))
    with pytest.raises(
        InputError, match=r'far\.ply: object "far": coordinates must be finite and below 1e\+30 \(vertex'
    ):
        read(path, supports=[0])


@pytest.mark.parametrize("suffix", READ)
def test_an_empty_file_is_called_so(tmp_path, suffix):
    path = tmp_path / f"none{suffix}"
    path.touch()
    with pytest.raises(InputError) as caught:
        read(path, supports=[0])
    assert str(caught.value) == f"{path}: the file is empty"


def test_an_empty_scene_and_an_empty_surface_are_called_so(tmp_path):
    scene, surface, stones = tmp_path / "none.toml", tmp_path / "none.ply", tmp_path / "stones"
    stones.mkdir()
    for path in (scene, surface, stones / "a.stl"):
        path.touch()
    for call in (lambda: load_scene(scene), lambda: read(scene)):
        with pytest.raises(InputError, match=r"none\.toml: the file is empty$"):
            call()
    with pytest.raises(InputError, match=r"none\.ply: the file is empty$"):
        read_surface(surface)
    with pytest.raises(InputError, match=r"a\.stl: the file is empty$"):
        read(stones, supports=[0])


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.ply", b"nonsense", ': its first line is not "ply"'),
        ("a.ply", head(8, 6, "binary_little_endian").encode() + bytes(30), ": it is cut short, or .*"),
        ("a.glb", b"nonsense" * 9, ': it does not begin with "glTF"'),
        ("a.glb", struct.pack("<4sIIII", b"glTF", 2, 40, 20, 7) + bytes(20), ": its first part is not JSON"),
        ("a.glb", b"no", ""),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex secret\nend_header\n", ""),
    ],
)
def test_a_mesh_that_cannot_be_read_says_why_in_words(tmp_path, name, data, words):
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(InputError, match=rf"{name}: cannot be read as a mesh{words}$"):
        read(path, supports=[0])


@pytest.mark.parametrize("suffix", [".stl", ".ply"])
def test_what_a_format_of_triangles_does_not_keep_is_said(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    named = assembly([box((0, 0, 0), (1, 1, 1), name="base"), box((0, 0, 1), (1, 1, 2))])
    text = rf"a\{suffix}: \{suffix} does not keep supports, names of blocks, densities and gravity; "
    text += r"\.obj, \.glb and \.json do$"
    with pytest.warns(InputWarning, match=text):
        write(named, path)
    plain = assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))])
    with pytest.warns(InputWarning, match="does not keep supports, densities and gravity;"):
        write(plain, path)
    standard = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], supports=[0])
    with pytest.warns(InputWarning, match="does not keep supports;"):
        write(standard, path, up="y")
    grouped = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), group="wall")], friction=0.5)
    with pytest.warns(InputWarning, match="does not keep groups and friction;"):
        write(grouped, path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for other in ("a.obj", "a.glb", "a.json"):
            write(named, tmp_path / other)


@pytest.mark.parametrize(
    ("name", "format", "place"),
    [
        ("a.obj", None, r"\.obj"),
        ("a.glb", None, r"\.glb"),
        ("a.json", "compas-assembly", r"compas-assembly in \.json"),
        ("a.json", "compas-model", r"compas-model in \.json"),
    ],
)
def test_ties_laws_and_load_cases_that_a_format_has_no_place_for_are_said(tmp_path, name, format, place):
    blocks = [box((0, 0, 0), (1, 1, 1), name="base", group="g"), box((0, 0, 1), (1, 1, 2), name="top", density=7.0)]
    parameters = {"parameters": {"height": 1.0}, "material": {"glue": 10.0}, "loads": {}}
    bare = assembly(blocks, friction=0.5, metadata=parameters)
    rod = Tie(("base", "top"), ((0.5, 0.5, 0.5), (0.5, 0.5, 1.5)), greatest=1.0)
    whole = bare.with_(
        joints=[JointLaw(("g", "*"), cohesion=1.0)], ties=[rod], metadata={**parameters, "cases": {"a": {}}, "by": "me"}
    )
    with pytest.warns(InputWarning) as told:
        write(whole, tmp_path / name, format=format)
    text = rf"{name}: {place} does not keep joint laws, ties and metadata \(cases, by\); only a native \.json does$"
    assert [re.search(text, str(one.message)) is not None for one in told] == [True]
    assert told[0].filename == __file__
    with pytest.warns(InputWarning, match=rf"{place} does not keep ties; only a native"):
        write(bare.with_(ties=[rod]), tmp_path / name, format=format)
    with pytest.warns(InputWarning, match=rf"{place} does not keep metadata \(grid, many\); only a native"):
        write(bare.with_(metadata={"grid": np.ones(2), "many": False}), tmp_path / name, format=format)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write(bare, tmp_path / name, format=format)
        write(whole, tmp_path / "whole.json")


@pytest.mark.parametrize("format", ["ply", "stl"])
def test_what_a_directory_does_not_keep_is_said(tmp_path, format):
    blocks = [box((0, 0, 0), (1, 1, 1), name="base", group="g"), box((0, 0, 1), (1, 1, 2), name="top")]
    found = Assembly.from_blocks(blocks, supports=["base"], friction=0.5, density=7.0)
    text = "stones: a directory does not keep supports, densities and friction; .obj, .glb and .json do"
    with pytest.warns(InputWarning, match=f"{text}$"):
        write(found, tmp_path / "stones", format=format)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write(Assembly.from_blocks(blocks), tmp_path / "again", format=format)


def test_a_verdict_for_compas_says_what_it_does_not_keep(tmp_path):
    tower = assembly([box((0, 0, 0), (1, 1, 1), name="base"), box((0, 0, 1), (1, 1, 2), name="top")])
    verdict = assess(tower.with_(joints=[JointLaw(("*", "*"), friction=0.6)]))
    with pytest.warns(InputWarning, match=r"compas-model in \.json does not keep joint laws; only a native"):
        write_verdict(verdict, tmp_path / "v.json", format="compas-model")
