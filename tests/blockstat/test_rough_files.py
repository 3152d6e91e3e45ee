"""Files as exporters and scanners leave them: facets without area, turned or doubled ones, lines that go on."""

import json
import warnings
from itertools import pairwise

import numpy as np
import pytest

from blockstat import Assembly, InputError, InputWarning, assess, box, read, repair, write
from blockstat.io.mesh import mesh_parts
from blockstat.io.obj import read_obj
from blockstat.io.raw.runs import closed_runs, is_closed

GROUND = box((0, 0, -1), (1, 1, 0))
STONE = box((0, 0, 0), (1, 1, 1))
TOP = box((0.3, 0, 1), (2.1, 1, 2))  # its centroid, at 1.2, is beyond the stone's edge at 1
TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def triangles(block):
    corners = np.array(block.vertices, dtype=float)
    return [corners[[face[i] for i in half]] for face in block.faces for half in ((0, 1, 2), (0, 2, 3))]


def stl(path, facets):
    lines = ["solid all"]
    for facet in facets:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {' '.join(map(repr, corner))}" for corner in np.asarray(facet).tolist()]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid all\n"]))
    return path


def ply(path, facets):
    lines = ["ply", "format ascii 1.0", f"element vertex {3 * len(facets)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(facets)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(repr, corner)) for facet in facets for corner in np.asarray(facet).tolist()]
    lines += [f"3 {k} {k + 1} {k + 2}" for k in range(0, 3 * len(facets), 3)]
    path.write_text("\n".join(lines) + "\n")
    return path


def obj_lines(*blocks, start=0):
    lines = []
    for block in blocks:
        lines += ["v " + " ".join(map(repr, corner)) for corner in np.array(block.vertices, dtype=float).tolist()]
        lines += ["f " + " ".join(str(k + 1 + start) for k in face) for face in block.faces]
        start += len(block.vertices)
    return lines


HOLLOW = box((0.3, 0.3, 0.3), (0.7, 0.7, 0.7))
CAVITY = type(HOLLOW)(HOLLOW.vertices, [list(face)[::-1] for face in HOLLOW.faces], "")


def cube():
    return Assembly.from_blocks([STONE], supports=[0])


def spoilt():
    """Facets of the stone, one of which is without area, turned or listed twice, by what is wrong with it."""
    facets = triangles(STONE)
    a, b, _ = facets[0]
    return {
        "line first": [[a, a, b], *facets],
        "line within": [*facets[:5], [a, b, a], *facets[5:]],
        "point last": [*facets, [b, b, b]],
        "turned": [facets[0][::-1], *facets[1:]],
        "turned within": [*facets[:4], facets[4][::-1], *facets[5:]],
        "twice": [facets[0], facets[0][[1, 2, 0]], *facets[1:]],
        "again": [*facets, facets[0][[1, 2, 0]]],
    }


@pytest.mark.parametrize("form", [stl, ply])
@pytest.mark.parametrize("how", spoilt())
def test_a_spoilt_facet_does_not_weld_the_stones_that_follow(how, form, tmp_path):
    path = form(tmp_path / f"w.{form.__name__}", triangles(GROUND) + spoilt()[how] + triangles(TOP))
    repaired, report = repair(path, supports=[0])
    np.testing.assert_allclose(repaired.volume, [1, 1, 1.8], rtol=1e-6)
    assert sum(change.dropped + change.turned for change in report.changes) == 1
    assert assess(repaired).outcome.word == "unstable"


def test_facets_without_area_at_the_end_are_no_stone(tmp_path):
    a, b, _ = triangles(TOP)[0]
    path = stl(tmp_path / "w.stl", [*triangles(GROUND), *triangles(TOP), [a, a, b], [b, b, b]])
    np.testing.assert_allclose(repair(path, supports=[0])[0].volume, [1, 1.8], rtol=1e-6)


def test_facets_that_walk_one_edge_alike_do_not_keep_a_stone_open(tmp_path):
    """A stone of two cubes that share an edge; both facets that walk the edge upwards come first."""
    stone = triangles(box((0, 0, 0), (0.5, 0.5, 1))) + triangles(box((0.5, 0.5, 0), (1, 1, 1)))

    def walks_up(facet):
        sides = pairwise([*facet.tolist(), facet.tolist()[0]])
        return any(p[:2] == q[:2] == [0.5, 0.5] and p[2] < q[2] for p, q in sides)

    upwards = [facet for facet in stone if walks_up(facet)]
    assert len(upwards) == 2
    others = [facet for facet in stone if not walks_up(facet)]
    path = stl(tmp_path / "w.stl", triangles(GROUND) + upwards + others + triangles(TOP))
    with pytest.warns(match="separate solids"):
        np.testing.assert_allclose(read(path, supports=[0]).volume, [1, 0.5, 1.8], rtol=1e-6)


def test_a_turned_face_does_not_weld_the_stones_of_one_object(tmp_path):
    path = tmp_path / "w.obj"
    lines = obj_lines(GROUND, STONE, TOP)
    face = [k for k, line in enumerate(lines) if line[0] == "f"][7]
    lines[face] = "f " + " ".join(lines[face].split()[:0:-1])
    path.write_text("\n".join(lines))
    repaired, report = repair(path, supports=[0])
    np.testing.assert_allclose(repaired.volume, [1, 1, 1.8])
    assert [change.turned for change in report.changes] == [0, 1, 0]
    assert assess(repaired).outcome.word == "unstable"


def test_faces_that_are_folded_open_and_close_nothing():
    second = [[k + 4 for k in face] for face in TETRAHEDRON]
    folded = [[0, 0, 1], [2, 2, 2], [0, 1, 2, 1]]
    assert closed_runs([*folded, *TETRAHEDRON, *second]) == [range(0, 7), range(7, 11)]
    assert closed_runs([*TETRAHEDRON, *folded, *second]) == [range(0, 4), range(4, 11)]
    assert closed_runs([*TETRAHEDRON, *second, *folded]) == [range(0, 4), range(4, 11)]
    assert closed_runs(folded) == [range(0, 3)]
    # Two faces of the first are listed again after it, or all of them, as a solid of their own.
    assert closed_runs([*TETRAHEDRON, *TETRAHEDRON[:2], *second]) == [range(0, 6), range(6, 10)]
    assert closed_runs([*TETRAHEDRON, *TETRAHEDRON, *second]) == [range(0, 4), range(4, 8), range(8, 12)]
    # One corner of a face is listed twice.
    assert closed_runs([[0, 2, 2, 1], *TETRAHEDRON[1:], *second]) == [range(0, 4), range(4, 8)]
    assert is_closed([*TETRAHEDRON, *folded])
    assert not is_closed([*TETRAHEDRON, *second[:3]])


@pytest.mark.parametrize("gravity", [9.81, "down", [1, 2]])
@pytest.mark.parametrize("form", ["w.glb", "w.json"])
def test_a_gravity_that_is_no_vector_is_refused_whatever_is_up(form, gravity, tmp_path):
    path = tmp_path / form
    if form == "w.json":
        write(cube(), path, format="compas-assembly")
        data = json.loads(path.read_text())
        data["data"]["attributes"]["gravity"] = gravity
        path.write_text(json.dumps(data))
    else:
        write(cube(), path)
        change_glb(path, lambda content: content["scenes"][0]["extras"].update(gravity=gravity))
    for up in (None, "x"):
        with pytest.raises(InputError, match=f"{form}: gravity is .*; it must be three numbers"):
            read(path, supports=[0], up=up)
        with pytest.raises(InputError, match="it must be three numbers gx, gy, gz"):
            repair(path, supports=[0], up=up)


def change_glb(path, change):
    """Change the first part of a GLB, which is JSON."""
    data = path.read_bytes()
    size = int.from_bytes(data[12:16], "little")
    content = json.loads(data[20 : 20 + size])
    change(content)
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    sizes = [(20 + len(text) + len(rest)).to_bytes(4, "little"), len(text).to_bytes(4, "little")]
    path.write_bytes(data[:8] + b"".join(sizes) + b"JSON" + text + rest)


def test_a_face_of_an_obj_without_corners_is_named_by_its_line(tmp_path):
    path = tmp_path / "cut.obj"
    path.write_text("\n".join([*obj_lines(STONE), "f"]))
    for call in (read_obj, mesh_parts, lambda path: read(path, supports=[0]), lambda path: repair(path, supports=[0])):
        with pytest.raises(InputError, match='line 15: cannot be read as "f" of an OBJ file'):
            call(path)


@pytest.mark.parametrize("corner", [9, 0, -9])
def test_a_face_of_an_obj_with_a_corner_that_does_not_exist_says_which(tmp_path, corner):
    path = tmp_path / "cut.obj"
    path.write_text("\n".join([*obj_lines(STONE), f"f 1 2 {corner}"]))  # a cube has eight
    with pytest.raises(InputError) as error:
        read(path, supports=[0])
    assert str(error.value) == f'{path}: line 15: "f" has the corner {corner}, and 8 vertices come before it'


def test_a_line_of_an_obj_goes_on_after_a_backslash(tmp_path):
    path = tmp_path / "w.obj"
    lines = obj_lines(STONE)
    lines[3] = lines[3].replace(" ", " \\\n", 1)
    lines[-1] = lines[-1].replace(" ", " \\ \n\t")
    path.write_text("\n".join(["# from C:\\", "g C:\\", *lines]))
    assert read(path, supports=[0]).volume.tolist() == [1.0]
    path.write_text("\n".join([*obj_lines(STONE), "f 1 \\", "2 x", "f 1 \\", "2 \\"]) + "\nf 1 9\n")
    with pytest.raises(InputError) as caught:
        read_obj(path)
    assert [text.split(":")[0] for text in caught.value.args] == ["line 15", "line 17"]
    path.write_text("\n".join([*obj_lines(STONE)[:-1], " ".join(obj_lines(STONE)[-1].split()) + "\\"]))
    assert read(path, supports=[0]).volume.tolist() == [1.0]


@pytest.mark.filterwarnings("ignore:.*does not keep")
@pytest.mark.parametrize("header", [b"", b"solid cube"], ids=["plain", "solid"])
@pytest.mark.parametrize("fill", [b"\0", b"\n", b"\0\0", b"\r\n\r\n"], ids=["zero", "line", "zeros", "lines"])
def test_a_binary_stl_may_be_filled_up_at_its_end(fill, header, tmp_path):
    path = write(cube(), tmp_path / "w.stl")
    data = header + path.read_bytes()[len(header) :]
    path.write_bytes(data + fill)
    assert read(path, supports=[0]).volume.tolist() == [1.0]


@pytest.mark.filterwarnings("ignore:.*does not keep")
@pytest.mark.parametrize("fill", [b"\0" * 5, b"\1", b"\0" * 50], ids=["five", "one", "facet"])
def test_what_follows_a_binary_stl_is_not_left_out(fill, tmp_path):
    path = write(cube(), tmp_path / "w.stl")
    path.write_bytes(path.read_bytes() + fill)
    with pytest.raises(InputError):
        read(path, supports=[0])


@pytest.mark.filterwarnings("ignore:.*does not keep")
def test_a_binary_stl_that_is_cut_short_says_so(tmp_path):
    path = write(cube(), tmp_path / "w.stl")
    data = path.read_bytes()  # a cube has 12 triangles, of 50 bytes after the first 84
    assert data[80:84] == bytes([12, 0, 0, 0])
    for kept, told in (
        (84 + 50 * 11 + 49, "it says that it has 12 facets, and holds 11"),
        (84, "it says that it has 12 facets, and holds 0"),
        (83, "it has 83 bytes, and a binary STL begins with 84 before a facet"),
    ):
        path.write_bytes(data[:kept])
        with pytest.raises(InputError) as error:
            read(path, supports=[0])
        assert str(error.value) == f"{path}: it is cut short: {told}"


def test_a_mirrored_element_of_compas_is_a_solid(tmp_path):
    """The image in x = 0 of a prism over the triangle (1, 0), (3, 0), (3, 1): centroid x at -(1 + 3 + 3) / 3."""
    corners = [(x, y, z) for z in (0, 1) for x, y in ((1, 0), (3, 0), (3, 1))]
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
    prism = type(STONE)(np.array(corners, dtype=float), faces, "prism")
    path = tmp_path / "w.json"
    write(Assembly.from_blocks([STONE, prism], supports=[0]), path, format="compas-model")
    data = json.loads(path.read_text())
    element = list(data["data"]["elements"].values())[1]
    mirror = np.diag([-1.0, 1, 1, 1]).tolist()
    element["data"]["transformation"] = {"dtype": "compas.geometry/Reflection", "data": {"matrix": mirror}}
    path.write_text(json.dumps(data))
    found = read(path)
    np.testing.assert_allclose(found.volume, [1, 1])
    np.testing.assert_allclose(found.centroid[1], [-7 / 3, 1 / 3, 1 / 2])


def test_a_hollow_stone_is_one_block_and_a_stone_in_its_cavity_another(tmp_path):
    """A cube of 1 m with a cavity of 0.4 m, in which a cube of 0.2 m stands."""
    inner = box((0.4, 0.4, 0.3), (0.6, 0.6, 0.5))
    for form in (stl, ply):
        for order in ((STONE, CAVITY, inner), (CAVITY, inner, STONE)):
            facets = [facet for block in (GROUND, *order) for facet in triangles(block)]
            found = read(form(tmp_path / f"w.{form.__name__}", facets), supports=[0])
            np.testing.assert_allclose(np.sort(found.volume), [0.2**3, 1 - 0.4**3, 1], rtol=1e-6)
    path = tmp_path / "w.obj"
    path.write_text("\n".join(obj_lines(GROUND, STONE, CAVITY, inner)))
    np.testing.assert_allclose(read(path, supports=[0]).volume, [1, 1 - 0.4**3, 0.2**3])
    path.write_text("\n".join(obj_lines(STONE, CAVITY)))
    found = read(path, supports=[0])
    np.testing.assert_allclose(found.volume, [1 - 0.4**3])
    standing = Assembly.from_blocks([GROUND, *mesh_parts(path, supports=[0]).blocks], supports=[0])
    assert assess(standing).outcome.word == "stable"


def test_a_cavity_belongs_to_the_smallest_stone_around_it_and_a_stone_inside_out_to_none(tmp_path):
    """A cube of 3 m with a cavity of 2 by 2 by 1.5 m, in which a hollow cube of 1 m stands; a cube beside is turned."""
    shell, room = box((-1, -1, -1), (2, 2, 2)), box((-0.5, -0.5, 0), (1.5, 1.5, 1.5))
    room = type(room)(room.vertices, [list(face)[::-1] for face in room.faces], "")
    beside = box((5, 0, 0), (6, 1, 1))
    facets = [facet for block in (shell, STONE, CAVITY, room) for facet in triangles(block)]
    facets += [facet[::-1] for facet in triangles(beside)]
    path = stl(tmp_path / "w.stl", facets)
    with pytest.raises(InputError, match=r'"all\.2": all its faces point inwards'):
        read(path, supports=[0])
    found, _ = repair(path, supports=[0])
    np.testing.assert_allclose(found.volume, [27 - 2 * 2 * 1.5, 1 - 0.4**3, 1], rtol=1e-6)


def in_primitives(content, sizes):
    """Cut the first mesh of a GLB into primitives of so many triangles."""
    mesh, accessors = content["meshes"][0], content["accessors"]
    first = mesh["primitives"][0]
    indices = accessors[first["indices"]]
    mesh["primitives"] = []
    for start, size in zip(np.cumsum([0, *sizes]).tolist(), sizes, strict=False):
        mesh["primitives"].append(first | {"indices": len(accessors)})
        accessors.append(indices | {"byteOffset": 12 * start, "count": 3 * size})  # 4 bytes a corner


@pytest.mark.parametrize("sizes", [(6, 6), (1, 10, 1)])
def test_primitives_of_a_glb_that_close_together_are_one_stone(sizes, tmp_path):
    path = write(Assembly.from_blocks([box((0, 0, 0), (1, 2, 3), name="pier")], supports=[0]), tmp_path / "w.glb")
    change_glb(path, lambda content: in_primitives(content, sizes))
    found = read(path)
    np.testing.assert_allclose(found.volume, [6])
    np.testing.assert_allclose(found.centroid, [[0.5, 1, 1.5]])
    assert (found.names, len(found.faces_of(0))) == (("pier",), 6)

    def again(content):
        node = next(node for node in content["nodes"] if "mesh" in node)
        other = node | {"name": "second", "extras": {}, "matrix": np.array(node["matrix"]).tolist()}
        other["matrix"][12:15] = [4, 0, 0]
        content["nodes"].append(other)
        content["scenes"][0]["nodes"].append(len(content["nodes"]) - 1)

    change_glb(path, again)  # two nodes of one mesh
    found = read(path)
    assert found.names == ("pier", "second")
    np.testing.assert_allclose(found.centroid, [[0.5, 1, 1.5], [4.5, 1, 1.5]])


@pytest.mark.parametrize("far", [1.0, 3.0])
def test_primitives_of_a_glb_that_are_several_stones_are_not_joined(far, tmp_path):
    """Two cubes in one mesh, touching or apart: in primitives of one each they are two, in others they are open."""
    two = type(STONE)(
        np.vstack([STONE.vertices, np.array(STONE.vertices) + [far, 0, 0]]),
        [*STONE.faces, *([k + 8 for k in face] for face in STONE.faces)],
        "two",
    )
    with pytest.warns(match="separate solids"):
        apart = Assembly.from_blocks([two], supports=[0])
    path = write(apart, tmp_path / "w.glb")
    change_glb(path, lambda content: in_primitives(content, (12, 12)))
    np.testing.assert_allclose(read(path, supports=[0]).volume, [1, 1])
    path = write(apart, tmp_path / "w.glb")
    change_glb(path, lambda content: in_primitives(content, (6, 12, 6)))
    with pytest.raises(InputError):
        read(path, supports=[0])


def far_away(path, x, *, places=None):
    """Two cubes of 1 m on each other, at x, in single precision; in a GLB perhaps moved there by their nodes."""
    import trimesh

    meshes = []
    for block in (GROUND, STONE):
        corners = np.array(block.vertices, dtype=float) + (0.0 if places else x, 0.0, 0.0)
        meshes.append(trimesh.Trimesh(corners, np.array(block.faces)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)))
    if path.suffix != ".glb":
        trimesh.util.concatenate(meshes).export(path)
        return path
    scene = trimesh.Scene()
    for k, mesh in enumerate(meshes):
        transform = np.eye(4)
        transform[0, 3] = places[k] if places else 0.0
        scene.add_geometry(mesh, node_name=str(k), transform=transform)
    scene.export(path)
    return path


def silent(path, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("error", InputWarning)
        return read(path, supports=[0], **options)


ADVICE = "export the model about a local origin, or in double precision (.obj)"


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".glb"])
def test_single_precision_far_from_the_origin_is_told_and_refused_where_it_loses_joints(tmp_path, suffix):
    # From 2^k to 2^(k + 1) numbers with 24 binary digits are 2^(k - 23) apart; joints of these cubes may be open by
    # 10 mm, and do not quite close from 1 mm.
    up = {"up": "z"} if suffix == ".glb" else {}
    assert silent(far_away(tmp_path / f"near{suffix}", 2.0**14 - 2), **up).volume.tolist() == [1.0, 1.0]  # 2^-10 m
    for x, told in ((2.0**14, "1.95 mm apart, 0.002 "), (2.0**17 - 2, "7.81 mm apart, 0.0078 ")):
        path = far_away(tmp_path / f"far{suffix}", x)
        with pytest.warns(InputWarning, match="single precision") as found:
            assert read(path, supports=[0], **up).volume.tolist() == [1.0, 1.0]
        text = str(found[0].message)
        assert text.startswith(f"{path}: the coordinates are in single precision, and so far from the origin")
        assert f"its numbers are {told}of the size of block" in text
        assert text.endswith(f"; joints open by as much: {ADVICE}")
    path = far_away(tmp_path / f"lost{suffix}", 2.0**17)
    with pytest.raises(InputError) as error:
        read(path, supports=[0], **up)
    assert str(error.value).startswith(f"{path}: the coordinates are in single precision")
    assert "its numbers are 15.6 mm apart, 0.016 of the size of block" in str(error.value)
    assert str(error.value).endswith(f"; joints are lost in that: {ADVICE}")
    with pytest.raises(InputError, match=r"its numbers are 0\.0156 mm apart, 0\.016 of the size"):
        read(path, supports=[0], units="mm", **up)


def test_text_and_double_precision_far_from_the_origin_are_read_as_they_are(tmp_path):
    x = 4812345.25
    moved = [type(own)(np.array(own.vertices, dtype=float) + (x, 0, 0), own.faces, "") for own in (GROUND, STONE)]
    facets = [facet for own in moved for facet in triangles(own)]
    asm = Assembly.from_blocks(moved, supports=[0])
    double = ply(tmp_path / "t.ply", facets)
    double.write_text(double.read_text().replace("property float", "property double"))
    for path in (stl(tmp_path / "t.stl", facets), double, write(asm, tmp_path / "t.obj")):
        found = silent(path)
        np.testing.assert_allclose(found.volume, 1.0, rtol=1e-8)
        assert found.vertices[:, 0].min() == x
    with pytest.raises(InputError, match="single precision"):
        silent(ply(tmp_path / "single.ply", facets))


def written_as(path, form, place, side=0.5):
    """Two cubes on each other, in text, with numbers in one form."""
    x, y, z = place
    lines = ["solid all"] * (path.suffix == ".stl")
    for k in range(2):
        cube = box((x, y, z + k * side), (x + side, y + side, z + (k + 1) * side))
        corners = [" ".join(form % value for value in corner) for corner in np.array(cube.vertices).tolist()]
        if path.suffix == ".stl":
            for face in cube.faces:
                for half in ((0, 1, 2), (0, 2, 3)):
                    lines += ["facet normal 0 0 0", "outer loop"]
                    lines += [*(f"vertex {corners[face[i]]}" for i in half), "endloop", "endfacet"]
        else:
            lines += [f"o stone{k}", *(f"v {corner}" for corner in corners)]
            lines += ["f " + " ".join(str(corner + 1 + 8 * k) for corner in face) for face in cube.faces]
    lines += ["endsolid all"] * (path.suffix == ".stl")
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("suffix", [".obj", ".stl"])
def test_text_of_few_digits_far_from_the_origin_is_told(tmp_path, suffix):
    # The last of n digits of a number from 10^k to 10^(k + 1) is worth 10^(k + 1 - n); cubes of 0.5 m may have joints
    # that are open by 5 mm.
    near, far, map_place = (500.123, 1.234, 0.0), (50000.1, 1.234, 0.0), (500000.1, 1.234, 0.0)
    fine = [("%.6g", near), *((form, place) for form in ("%.3f", "%.17g", "%r", "%.9e") for place in (far, map_place))]
    for form, place in fine:
        np.testing.assert_allclose(silent(written_as(tmp_path / f"fine{suffix}", form, place)).volume, 0.125, rtol=1e-6)
    for form, place, told in (
        (
            "%.6g",
            (5000.12, 1.234, 0.0),
            "6 digits, and so far from the origin the last of them is worth 10 mm, 0.02 of",
        ),
        ("%.6g", far, "6 digits, and so far from the origin the last of them is worth 100 mm, 0.2 of"),
        ("%e", far, "7 digits, and so far from the origin the last of them is worth 10 mm, 0.02 of"),
    ):
        path = written_as(tmp_path / f"few{suffix}", form, place)
        with pytest.warns(InputWarning, match="corners are rounded to that: export the model about a local") as found:
            np.testing.assert_allclose(read(path, supports=[0]).volume, 0.125, rtol=1e-6)
        assert str(found[0].message).startswith(f"{path}: no coordinate has more than {told} the size of block")
    path = written_as(
        tmp_path / f"map{suffix}", "%.6g", map_place
    )  # from 500000 to 500001 instead of 500000.6; no side below 1 m is known
    with pytest.warns(InputWarning, match=r"worth 1e\+03 mm, 1 of the size"):
        np.testing.assert_allclose(read(path, supports=[0]).volume, 0.25, rtol=1e-6)
    path = written_as(tmp_path / f"mm{suffix}", "%.6g", (5000120.0, 0.25, 0.0), side=500.0)
    with pytest.warns(InputWarning, match=r"the last of them is worth 10 mm, 0\.02 of the size"):
        read(path, supports=[0], units="mm")


def test_round_numbers_far_from_the_origin_are_as_exact_as_they_look(tmp_path):
    silent(written_as(tmp_path / "metres.obj", "%.6g", (500001.0, 2.0, 0.0), side=1.0))
    silent(written_as(tmp_path / "halves.obj", "%.7g", (500001.0, 2.0, 0.0)))


def test_files_of_few_digits_in_a_directory_are_told_together(tmp_path):
    (tmp_path / "stones").mkdir()
    for name, place in (("far", (50000.1, 1.0, 0.0)), ("near", (0.0, 1.234, 0.0))):
        written_as(tmp_path / "stones" / f"{name}.obj", "%.6g", place)
    with pytest.warns(InputWarning, match=r'is worth 100 mm, 0\.2 of the size of block "far\.stone0"'):
        read(tmp_path / "stones", supports=["near.stone0"])


def test_a_directory_and_the_places_of_objects_far_from_the_origin_are_judged_too(tmp_path):
    (tmp_path / "stones").mkdir()
    write(Assembly.from_blocks([GROUND], supports=[0]), tmp_path / "stones" / "a.stl")
    far = np.array(STONE.vertices, dtype=float) + (2.0**17, 0, 0)
    with pytest.warns(InputWarning):
        write(Assembly.from_blocks([STONE], supports=[0]).with_(vertices=far), tmp_path / "stones" / "b.stl")
    with pytest.raises(InputError, match=r'15\.6 mm apart, 0\.016 of the size of block "b"; joints are lost'):
        read(tmp_path / "stones", supports=[0])
    with pytest.raises(InputError, match=r"15\.6 mm apart"):
        silent(far_away(tmp_path / "own.glb", 0.0, places=(2.0**17, 2.0**17 + 1)), up="z")
    one = silent(far_away(tmp_path / "one.glb", 0.0, places=(2.0**17, 2.0**17)), up="z")  # moved as one
    assert one.vertices[:, 0].min() == 2.0**17
