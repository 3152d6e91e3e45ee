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


def form_of(order):
    return f"binary_{'little' if order == '<' else 'big'}_endian"


def spread(order, *, extra=(), sizes=(3, 4, 6)):
    """Prisms on 3, 4 and 6 corners about the z axis, 2 wide and 1 high, in single precision; their volumes too."""
    corners, faces = [], []
    for k, n in enumerate(sizes):
        angle, first = np.arange(n) * 2 * np.pi / n, len(corners)
        for height in (0.0, 1.0):
            corners += [(3.0 * k + np.cos(a), np.sin(a), height) for a in angle]
        faces += [[*range(first, first + n)][::-1], [*range(first + n, first + 2 * n)]]
        faces += [[first + i, first + (i + 1) % n, first + n + (i + 1) % n, first + n + i] for i in range(n)]
    lines = ["ply", f"format {form_of(order)} 1.0", "comment by hand", f"element vertex {len(corners)}"]
    lines += [*(f"property float {axis}" for axis in "xyz"), "element camera 2", "property list uchar short views"]
    lines += [f"element face {len(faces)}", *extra, "property list uchar uint vertex_indices", "end_header", ""]
    data = "\n".join(lines).encode() + b"".join(struct.pack(f"{order}3f", *p) for p in corners)
    data += struct.pack(f"{order}Bh", 1, -7) + struct.pack(f"{order}B2h", 2, 5, 6)
    for face in faces:
        for line in extra:
            data += struct.pack(f"{order}B2f", 2, 0.5, 0.5) if "list" in line else struct.pack(f"{order}h", 300)
        data += struct.pack(f"{order}B{len(face)}I", len(face), *face)
    return data, [n / 2 * np.sin(2 * np.pi / n) for n in sizes]


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("extra", [(), ("property short flags", "property list uchar float texcoord")])
def test_binary_faces_may_differ_in_their_number_of_corners(tmp_path, order, extra):
    path = tmp_path / "spread.ply"
    data, areas = spread(order, extra=extra)
    path.write_bytes(data)
    found = read(path, supports=[0])
    np.testing.assert_allclose(found.volume, areas, rtol=1e-6)
    assert [sorted(len(face) for face in found.faces_of(k)) for k in range(3)] == [
        [3, 3, 4, 4, 4],
        [4] * 6,
        [4] * 6 + [6, 6],
    ]


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_binary_file_that_is_cut_short_anywhere_is_refused(tmp_path, order):
    path = tmp_path / "short.ply"
    data, _ = spread(order, sizes=(3, 4))
    for end in range(data.index(b"end_header") + 11, len(data)):
        path.write_bytes(data[:end])
        with pytest.raises(InputError, match=r"short\.ply: cannot be read as a mesh: it is cut short: it holds fewer "):
            read(path, supports=[0])
    path.write_bytes(data + b"\1")
    with pytest.raises(InputError, match=r"short\.ply: .* holds more than its header says$"):
        read(path, supports=[0])


def with_lists(path, before="", after="", *, row="{0}"):
    """The pile as a text, with more properties of each face before and after the list of its corners."""
    text = ply(path, pile()).read_text()
    text = text.replace("property list", before + "property list").replace("end_header", after + "end_header")
    start, body = text.split("end_header\n")
    rows = body.splitlines()
    faces = [row.format(line) for line in rows[24:]]
    path.write_text("\n".join([start + "end_header", *rows[:24], *faces]) + "\n")
    return path


@pytest.mark.parametrize(
    ("before", "after", "row"),
    [
        ("property uchar red\n", "property list uchar float texcoord\n", "7 {0} 2 0.5 0"),
        ("property list uchar float texcoord\n", "property float quality\n", "2 1e-3 0 {0} 1"),
        ("property uchar red\nproperty uchar green\n", "", "7 8 {0}"),
    ],
)
def test_a_text_may_have_more_of_each_face_before_and_after_its_corners(tmp_path, before, after, row):
    found = read(with_lists(tmp_path / "more.ply", before, after, row=row), supports=[0])
    np.testing.assert_allclose(found.volume, [1, 2, 3])
    assert [len(found.faces_of(i)) for i in range(3)] == [6, 6, 6]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("4 0 3 2 1", "4.5 0 3 2 1"), "the length of a list is not a whole number from 0"),
        (("4 0 3 2 1", "-4 0 3 2 1"), "the length of a list is not a whole number from 0"),
        (("4 0 3 2 1", "4 0 3 2 1.5"), "a corner of a face has a number that is not whole"),
        (("4 0 3 2 1", "4 0 3 two 1"), "it holds a word where a number should be"),
        (("4 0 3 2 1", "4 0 3 2 1 0"), "it holds more than its header says"),
        (("4 0 3 2 1\n", ""), "it is cut short: it holds fewer faces than its header says"),
        (
            ("property list uchar int vertex_indices", "property int vertex_indices"),
            "it holds more than its header says",
        ),
        (("format ascii 1.0\n", ""), "its header does not say whether .* before its elements"),
        (("element vertex 24", "element vertex -24"), "its header has a line that is not understood"),
        (("double y", "double x"), "its header names a property twice"),
        (("double y", "double up"), "its header names no vertices with x, y and z"),
        (("end_header", "end"), 'its header has no line "end_header"'),
    ],
)
def test_a_text_that_is_not_as_its_header_says_is_refused_in_words(tmp_path, change, words):
    path = ply(tmp_path / "odd.ply", pile())
    assert change[0] in path.read_text()
    path.write_text(path.read_text().replace(*change, 1))
    with pytest.raises(InputError, match=rf"odd\.ply: cannot be read as a mesh: {words}$"):
        read(path, supports=[0])


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
        ("a.ply", head(8, 6, "binary_little_endian").encode() + bytes(30), ": it is cut short: .* vertices .*"),
        ("a.glb", b"nonsense" * 9, ': it does not begin with "glTF"'),
        ("a.glb", struct.pack("<4sIIII", b"glTF", 2, 40, 20, 7) + bytes(20), ": its first part is not JSON"),
        ("a.glb", b"no", ""),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex secret\nend_header\n",
            ": its header has a line .* understood",
        ),
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
