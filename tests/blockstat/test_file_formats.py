"""What each file format says, on files written by hand: OBJ, native JSON, folders, meshes, scenes and surfaces."""

import json
import re
import struct
import warnings

import numpy as np
import pytest
import trimesh

from blockstat import (
    Assembly,
    Block,
    InputError,
    JointLaw,
    Tie,
    friction_limit,
    load_scene,
    read,
    scene_from,
    scene_text,
    write,
)
from blockstat.errors import InputWarning, NoSupportError
from blockstat.io.compas.read import is_compas
from blockstat.io.files import read_parts
from blockstat.io.folder import folder_parts
from blockstat.io.mesh import block_mesh, mesh_parts, read_whole
from blockstat.io.names import distinct_names
from blockstat.io.native import native_parts
from blockstat.io.obj import NOTE, read_obj, split_solids
from blockstat.io.parts import Parts, chosen_supports, doubts, in_frame, is_marked, metres_in
from blockstat.io.raw.runs import closed_runs
from blockstat.io.scene_text import _table
from blockstat.io.surface import read_surface
from evidence.scenes.small import assembly, box, prism

TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
CORNERS = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 4.0)]
#: A tetrahedron as lines of an OBJ, with corners counted from the first and from the last.
SOLID = [f"v {x} {y} {z}" for x, y, z in CORNERS] + ["f 1 3 2", "f 1/7 2//3 4/1/1", "f -4 -1 -2", "f 2 3 -1"]


def obj(tmp_path, *lines):
    path = tmp_path / "made.obj"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_corners_of_an_obj_are_counted_from_the_first_or_from_the_last(tmp_path):
    solids, shared = read_obj(obj(tmp_path, *SOLID))
    assert shared == {}
    assert [(s.name, s.vertices, s.faces) for s in solids] == [("", CORNERS, TETRAHEDRON)]
    assert solids[0].extras == {"name": "", "group": ""}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_an_obj_is_read_in_the_encoding_that_its_first_bytes_tell(tmp_path, encoding, ends):
    path = tmp_path / "made.obj"
    path.write_bytes(ends.join(["o stone", *SOLID]).encode(encoding))
    solids, _ = read_obj(path)
    np.testing.assert_array_equal(solids[0].vertices, read_obj(obj(tmp_path, *SOLID))[0][0].vertices)


def test_objects_or_groups_of_an_obj_are_its_solids(tmp_path):
    moved = [f"v {x + 9} {y} {z} 1.0" for x, y, z in CORNERS]
    second = ["f 5 7 6", "f 5 6 8", "f 5 8 7", "f -3 -2 -1  # the last"]
    lines = ["g all.of it", "o one", *SOLID, "", "o two  words", "g", *moved, *second]
    solids, _ = read_obj(obj(tmp_path, *lines))
    assert [(s.name, s.extras["group"]) for s in solids] == [("one", "all.of it"), ("two words", "")]
    assert solids[1].vertices == [(x + 9, y, z) for x, y, z in CORNERS]
    assert solids[1].faces == TETRAHEDRON
    solids, _ = read_obj(obj(tmp_path, "g first", *SOLID, "g second", *moved, *second))
    assert [(s.name, s.extras["group"], s.faces) for s in solids] == [
        ("first", "", TETRAHEDRON), ("second", "", TETRAHEDRON),
    ]  # fmt: skip
    for none in ("default", "off", ""):
        assert read_obj(obj(tmp_path, "o one", f"g {none}", *SOLID))[0][0].extras["group"] == ""
    assert read_obj(obj(tmp_path, "o one", "g one", *SOLID))[0][0].extras["group"] == ""
    assert read_obj(obj(tmp_path, "o one", "g other", *SOLID))[0][0].extras["group"] == "other"


def test_a_group_of_an_obj_goes_on_where_its_name_comes_again(tmp_path):
    moved = [f"v {x + 9} {y} {z}" for x, y, z in CORNERS]
    other = ["f 5 7 6", "f 5 6 8", "f 5 8 7", "f 6 7 8"]
    lines = [*SOLID[:4], *moved, "g wall", *SOLID[4:6], "g default", *other, "g wall", "f 1 4 3", "f 2 3 4"]
    solids, _ = read_obj(obj(tmp_path, *(line.replace("f -4 -1 -2", "f 1 4 3") for line in lines)))
    assert [(s.name, len(s.faces)) for s in solids] == [("wall", 4), ("default", 4)]
    again = ["g", *SOLID[4:6], "g wall", *other, "g", "f 1 4 3", "f 2 3 4"]  # faces without a group are one, too
    solids, _ = read_obj(obj(tmp_path, *SOLID[:4], *moved, *again))
    assert [(s.name, len(s.faces)) for s in solids] == [("", 4), ("wall", 4)]
    # Objects of one name are several.
    lines = [*SOLID[:4], *moved, "o wall", *SOLID[4:6], "f 1 4 3", "f 2 3 4", "o wall", *other]
    assert [len(s.faces) for s in read_obj(obj(tmp_path, *lines))[0]] == [4, 4]


def test_notes_of_an_obj_are_of_their_object_and_the_first_of_all(tmp_path):
    lines = [NOTE + '"friction": 0.3}', "o one", NOTE + '"support": true, "density": 5.0, "name": "o ne"}', *SOLID]
    solids, shared = read_obj(obj(tmp_path, *lines))
    assert shared == {"friction": 0.3}
    assert solids[0].name == "o ne"
    assert solids[0].extras == {"name": "o ne", "group": "", "support": True, "density": 5.0}
    grouped, shared = read_obj(obj(tmp_path, NOTE + '"friction": 0.3}', "g one", *SOLID))
    assert shared == {"friction": 0.3}
    assert grouped[0].extras == {"name": "one", "group": ""}
    parts = mesh_parts(obj(tmp_path, *lines))
    assert (parts.supports, parts.options, parts.up) == ([0], {"name": "made", "friction": 0.3}, "z")
    assert (parts.blocks[0].name, parts.blocks[0].density) == ("o ne", 5.0)


def test_each_bad_line_of_an_obj_is_named(tmp_path):
    lines = ["v 0 0", "v 0 0 x", *SOLID, "f 1 2 7", "f 0 1 2", "f a b c", "vn 1 2", NOTE + '"a": }', "f 1 2 -7"]
    with pytest.raises(InputError) as caught:
        read_obj(obj(tmp_path, *lines))
    named = [(text.split(":")[0], text.split('"')[1]) for text in caught.value.args]
    assert named == [
        ("line 1", "v"), ("line 2", "v"), ("line 11", "f"), ("line 12", "f"), ("line 13", "f"),
        ("line 15", "# blockstat"), ("line 16", "f"),
    ]  # fmt: skip
    assert "of an OBJ file" in str(caught.value)
    deep = NOTE + '"a": ' + 20_000 * "[" + 20_000 * "]" + "}"
    with pytest.raises(InputError, match='line 3: cannot be read as "# blockstat" of an OBJ file'):
        read_obj(obj(tmp_path, "o a", *SOLID[:1], deep))
    ok = [*SOLID, "f 1 2 3 4"]  # the last corner exists
    assert len(read_obj(obj(tmp_path, *ok))[0][0].faces) == 5


def test_one_object_without_a_note_is_cut_into_its_closed_parts(tmp_path):
    moved = [f"v {x + 9} {y} {z}" for x, y, z in CORNERS]
    apart = [*SOLID, *moved, "f 5 7 6", "f 5 6 8", "f 5 8 7", "f 6 7 8"]
    found = mesh_parts(obj(tmp_path, *apart), supports=[0])
    assert [np.min(b.vertices, axis=0).tolist() for b in found.blocks] == [[0, 0, 0], [9, 0, 0]]
    assert [b.name for b in found.blocks] == ["", ""]
    shared = [*SOLID, "v -1 0 0", "f 1 5 3", "f 1 4 5", "f 3 5 4", "f 1 3 4"]  # two that share a face
    found = mesh_parts(obj(tmp_path, *shared), supports=[1])
    assert [np.min(b.vertices, axis=0).tolist() for b in found.blocks] == [[0, 0, 0], [-1, 0, 0]]
    noted = mesh_parts(obj(tmp_path, "o a", NOTE + '"support": true}', *apart))
    assert len(noted.blocks) == 1
    one = read_obj(obj(tmp_path, "o only", *SOLID))[0][0]
    assert split_solids(one) == [one]


def test_a_run_of_faces_ends_where_its_surface_closes():
    assert closed_runs([]) == []
    assert closed_runs(TETRAHEDRON) == [range(0, 4)]
    assert closed_runs(TETRAHEDRON[:3]) == [range(0, 3)]
    second = [[k + 4 for k in face] for face in TETRAHEDRON]
    assert closed_runs([*TETRAHEDRON, *second[:2]]) == [range(0, 4), range(4, 6)]
    turned = [face[::-1] for face in TETRAHEDRON]
    assert closed_runs([*TETRAHEDRON[:3], turned[3]]) == [range(0, 4)]


def test_what_is_written_as_obj_counts_corners_through_the_file(tmp_path):
    asm = assembly(
        [box((0, 0, 0), (1, 2, 3), name="a"), box((1, 0, 0), (2, 2, 3), name="b c", group="g")], name="two  words"
    )
    path = write(asm, tmp_path / "w.obj", units="cm", up="x")
    lines = path.read_text().splitlines()
    assert lines[0] == "# two words: 2 blocks, in cm, x up"
    assert path.read_text().endswith("\n")
    faces = [[int(k) for k in line.split()[1:]] for line in lines if line.startswith("f ")]
    assert {k for face in faces[:6] for k in face} == set(range(1, 9))
    assert {k for face in faces[6:] for k in face} == set(range(9, 17))
    assert [line for line in lines if line[:2] in ("o ", "g ", "g")] == ["o a", "g ", "o b c", "g g"]
    notes = [json.loads(line[len(NOTE) - 1 :]) for line in lines if line.startswith(NOTE)]
    assert notes[1] == {"group": "", "density": 1.0, "support": True}
    np.testing.assert_allclose(read(path, units="cm", up="x").vertices, asm.vertices, atol=1e-12)
    alone = write(assembly([box((0, 0, 0), (1, 2, 3), name="a")]), tmp_path / "a.obj").read_text()
    assert "\ng" not in alone


def native(**changes):
    block = {"name": "a", "vertices": [list(c) for c in CORNERS], "faces": TETRAHEDRON}
    return {"blocks": [block, block | {"name": "b", "density": 3.0, "group": "g.h"}], "supports": ["b"]} | changes


def test_the_native_format_says_what_the_assembly_has(tmp_path):
    joint = {"between": ["g", "*"], "friction": 0.2, "tension": 1.0, "bond": 2.0, "cohesion": 3.0, "compression": 5e6}
    tie = {"between": ["a", 1], "points": [[0, 0, 0], [1, 2, 3]], "least": 1.0, "greatest": 2.0, "name": "rod"}
    data = native(name="n", density=7.0, friction=0.1, gravity=[1, 2, -3], joints=[joint], ties=[tie], extra={"k": [1]})
    parts = native_parts(data, "stem")
    assert [(b.name, b.group, b.density) for b in parts.blocks] == [("a", "", None), ("b", "g.h", 3.0)]
    assert parts.supports == ["b"]
    law = JointLaw(("g", "*"), friction=0.2, tension=1.0, bond=2.0, cohesion=3.0, compression=5e6)
    rod = Tie(("a", 1), ((0, 0, 0), (1, 2, 3)), 1.0, 2.0, name="rod")
    assert parts.options == {
        "name": "n", "density": 7.0, "friction": 0.1, "gravity": (1, 2, -3), "metadata": {"extra": {"k": [1]}},
        "joints": [law], "ties": [rod],
    }  # fmt: skip
    bare = native_parts(native(), "stem", supports=("a",))
    assert bare.supports == ["a"]
    assert bare.options == {
        "name": "stem", "friction": 0.7, "metadata": {}, "joints": [], "ties": [],
    }  # fmt: skip
    for wrong, kind in (([], "list"), ("x", "str"), (None, "NoneType")):
        with pytest.raises(InputError, match=f'the file holds a {kind}; an object with "blocks" is needed'):
            native_parts(wrong, "stem")


@pytest.mark.parametrize(("block", "label"), [
    ({"name": "odd", "faces": []}, 'block "odd": '), ({"faces": []}, 'block "block2": '), (3, 'block "block2": entry'),
    ({"name": "odd", "vertices": [["x", 0, 0]], "faces": []}, r'block "odd": vertices\[0\]\[0\]: '),
])  # fmt: skip
def test_a_bad_entry_of_a_native_file_is_named_by_its_block(block, label):
    data = native()
    data["blocks"].append(block)
    with pytest.raises(InputError, match=f"^{label}"):
        native_parts(data, "stem")


def test_a_key_that_no_tie_and_no_joint_has_is_refused():
    tie = {"between": ["a", 1], "points": [[0, 0, 0], [1, 2, 3]]}
    for changes in ({"ties": [tie | {"most": 1.0}]}, {"joints": [{"between": ["a", "b"], "most": 1.0}]}):
        with pytest.raises(InputError, match="most"):
            native_parts(native(**changes), "stem")


def test_a_key_that_no_block_has_is_refused_and_one_of_the_file_is_kept():
    data = native(author="me")
    data["blocks"][1] |= {"support": True, "weight": 3.0}
    with pytest.raises(InputError) as caught:
        native_parts(data, "stem")
    keys = "keys here are: vertices, faces, name, group, density"
    assert list(caught.value.args) == [f'block "b": {key}: unknown key; {keys}' for key in ("support", "weight")]
    assert native_parts(native(author="me"), "stem").options["metadata"] == {"author": "me"}


def test_one_support_of_a_native_file_is_a_name_or_a_number(tmp_path):
    path = tmp_path / "n.json"
    path.write_text(json.dumps(native()))
    for given, held in ((0, [True, False]), ("a", [True, False]), ("b", [False, True]), (["a", 1], [True, True])):
        assert read(path, supports=given).support.tolist() == held
    with pytest.raises(InputError, match='no block "none"'):
        read(path, supports="none")


def test_units_of_a_native_file_are_those_that_it_names(tmp_path):
    path = tmp_path / "n.json"
    for named, asked, metres in (
        (None, None, 1.0), ("m", None, 1.0), ("m", "m", 1.0), (None, "mm", 1e-3), ("ft", "ft", 0.3048),
    ):  # fmt: skip
        path.write_text(json.dumps(native(**({"units": named} if named else {}))))
        np.testing.assert_allclose(read(path, units=asked).vertices[:4], np.array(CORNERS) * metres, rtol=1e-15)
    for named, asked in (("ft", None), ("ft", "in"), ("m", "ft"), ("mm", "m")):
        path.write_text(json.dumps(native(units=named)))
        with pytest.raises(InputError, match=f'units are "{named}"'):
            read(path, units=asked)


def test_native_files_hold_what_is_there_and_no_more(tmp_path):
    law, rod = JointLaw(("*", "*"), bond=2.0), Tie(("a", "b"), ((0.5, 0.5, 0.0), (0.5, 0.5, 2.0)), 1.0, 3.0)
    asm = assembly([box((0, 0, 0), (1, 1, 1), name="a", group="g"), box((0, 0, 1), (1, 1, 2), name="b", density=4.0)])
    plain = json.loads(write(asm, tmp_path / "a.json").read_text())
    assert "joints" not in plain
    assert "ties" not in plain
    assert (plain["units"], plain.get("density"), plain["supports"]) == ("m", None, [0])
    assert [(b["name"], b.get("group"), b["density"]) for b in plain["blocks"]] == [("a", "g", 1.0), ("b", None, 4.0)]
    held = json.loads(write(asm.with_(joints=[law], ties=[rod]), tmp_path / "b.json", units="dm").read_text())
    assert held["units"] == "dm"
    assert held["ties"][0]["points"] == [[5.0, 5.0, 0.0], [5.0, 5.0, 20.0]]
    assert (held["ties"][0]["least"], held["ties"][0]["greatest"]) == (1.0, 3.0)
    with pytest.raises(InputError, match="the metadata cannot be written as JSON"):
        write(asm.with_(metadata={"a": {1, 2}}), tmp_path / "c.json")
    assert not (tmp_path / "c.json").exists()


def test_names_that_occur_more_than_once_are_numbered_past_those_that_are_taken():
    with pytest.warns(InputWarning, match='several blocks share a name \\("a"\\); they are numbered from .0'):
        assert distinct_names(["b", "a", "a.1", "", "a", "b", ""], []) == ["b.0", "a.0", "a.1", "", "a.2", "b.1", ""]
    assert distinct_names(["a", "", ""], ["a"]) == ["a", "", ""]
    with pytest.raises(InputError, match='supports: 2 blocks are named "a"; give their indices'):
        distinct_names(["a", "a", "c", "c"], ["d", 0, "a"])


def test_supports_are_those_given_or_else_those_that_a_file_marks():
    names = ["a", "", *"cdefghijklmnopqrst"]
    assert chosen_supports([3, 1], None, names, "it") == [3, 1]
    assert chosen_supports([3, 1], ["a"], names, "it") == ["a"]
    assert chosen_supports([3], "a", names, "it") == ["a"]
    assert chosen_supports([3], 0, names, "it") == [0]
    assert chosen_supports([3], [], names, "it") == []
    with pytest.raises(NoSupportError) as caught:
        chosen_supports([], None, names, "it")
    assert str(caught.value) == (
        'it does not say which blocks are supports; give their names or numbers, or "lowest" for those that reach '
        "down to the lowest corner (blocks: a, block1, c, d, e, f, g, h and 12 more)"
    )
    with pytest.raises(NoSupportError, match=r"\(blocks: a, block1, c, d, e, f, g, h\)$"):
        chosen_supports([], None, names[:8], "it")


@pytest.mark.parametrize(("mark", "held"), [(True, True), (False, False), (0, False), (1, True), (1.0, True)])
def test_a_mark_of_a_support_is_a_truth_value(tmp_path, mark, held):
    note = NOTE + f'"support": {json.dumps(mark)}}}'
    moved = [f"v {x + 9} {y} {z}" for x, y, z in CORNERS] + ["f 5 7 6", "f 5 6 8", "f 5 8 7", "f 6 7 8"]
    parts = mesh_parts(obj(tmp_path, "o a", note, *SOLID, "o b", NOTE + '"support": true}', *moved))
    assert parts.supports == [0] * held + [1]
    assert is_marked("a", "support", mark) is held


@pytest.mark.parametrize("mark", ["false", "true", "no", 2, [True]])
def test_what_is_no_truth_value_marks_no_support(tmp_path, mark):
    note = NOTE + f'"support": {json.dumps(mark)}}}'
    moved = [f"v {x + 9} {y} {z}" for x, y, z in CORNERS] + ["f 5 7 6", "f 5 6 8", "f 5 8 7", "f 6 7 8"]
    with pytest.raises(InputError) as caught:
        read(obj(tmp_path, "o a", note, *SOLID, "o b", note, *moved))
    assert list(caught.value.args) == [
        f'{tmp_path / "made.obj"}: block "{name}": support is {mark!r}; it must be true, false, 0 or 1' for name in "ab"
    ]


def test_parts_scale_and_turn_with_their_ties_and_their_gravity():
    block, rod = Block(CORNERS, TETRAHEDRON, "a"), Tie(("a", "b"), ((1, 2, 3), (4, 5, 6)), 1.0, 2.0, name="rod")
    parts = Parts([block], ["a"], {"name": "n", "gravity": (1.0, 2.0, 3.0), "ties": [rod]})
    assert parts.scaled(1.0) is parts
    scaled = parts.scaled(0.5)
    np.testing.assert_array_equal(scaled.blocks[0].vertices, np.array(CORNERS) / 2)
    assert scaled.options["ties"][0].points == ((0.5, 1.0, 1.5), (2.0, 2.5, 3.0))
    assert (scaled.options["ties"][0].least, scaled.options["ties"][0].greatest) == (1.0, 2.0)
    assert scaled.options["gravity"] == (1.0, 2.0, 3.0)
    assert parts.turned(None) is parts
    assert parts.turned("z") is parts
    # Rotations that take each axis to z; of the two axes left the first stays first, x or y.
    for up, matrix in {
        "x": [[0, 1, 0], [0, 0, 1], [1, 0, 0]], "-x": [[0, 1, 0], [0, 0, -1], [-1, 0, 0]],
        "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    }.items():  # fmt: skip
        turned = parts.turned(up)
        assert np.linalg.det(matrix) == pytest.approx(1.0)
        np.testing.assert_allclose(turned.blocks[0].vertices, np.array(CORNERS) @ np.transpose(matrix))
        np.testing.assert_allclose(turned.options["gravity"], np.array(matrix) @ [1, 2, 3])
        np.testing.assert_allclose(
            turned.options["ties"][0].points, np.array([[1, 2, 3], [4, 5, 6]]) @ np.transpose(matrix)
        )
    with pytest.raises(InputError, match="up is 'w'; the axis that points up must be one of: x, y, z, -x, -y, -z"):
        parts.turned("w")
    bare = Parts([Block("abc", TETRAHEDRON, "a")], ["a"])
    assert bare.turned("x").blocks[0].vertices == "abc"
    with pytest.raises(InputError, match='block "a": vertices must be a list of'):
        bare.scaled(2.0).assembled()


def test_an_assembly_in_the_frame_of_a_file_is_what_its_reader_undoes():
    rod = Tie((0, 1), ((0.5, 0.5, 0.0), (0.5, 0.5, 2.0)), 1.0, 2.0)
    asm = assembly([box((0, 0, 0), (1, 2, 1)), box((0, 0, 1), (1, 2, 2))], ties=[rod], gravity=(1, 2, 3))
    assert in_frame(asm, None, None, "z") is asm
    assert in_frame(asm, "m", "z", "z") is asm
    assert in_frame(asm, None, "y", "y") is asm
    found = in_frame(asm, "cm", "y", "z")
    np.testing.assert_allclose(found.vertices, 100 * asm.vertices[:, [0, 2, 1]] * [1, 1, -1])
    np.testing.assert_allclose(found.gravity, (1, 3, -2))
    np.testing.assert_allclose(found.ties[0].points, [(50, 0, -50), (50, 200, -50)])
    for wrong in ({"units": "yd"}, {"up": "w"}):
        with pytest.raises(InputError, match=r"units are 'yd'|up is 'w'"):
            in_frame(asm, wrong.get("units"), wrong.get("up"), "z")
    assert metres_in(None) == 1.0
    assert [metres_in(unit) for unit in ("m", "dm", "cm", "mm", "in", "ft")] == [1, 0.1, 0.01, 0.001, 0.0254, 0.3048]


def test_doubts_begin_at_their_thresholds():
    def doubt(size, density=1000.0, gravity=-9.81, ground=1000.0, **options):
        blocks = [
            box((-1, -1, -1), (2, 2, 0), name="ground", density=ground),
            box((0, 0, 0), (size, size / 2, size / 4), name="stone", density=density),
        ]  # fmt: skip
        return doubts(Assembly.from_blocks(blocks, supports=["ground"], gravity=(0, 0, gravity)), **options)

    assert doubt(25.0) == []
    assert doubt(25.1)[0].startswith('block "stone" is 25.1 m long, longer than any stone laid')
    assert doubt(1.001e-3) == []
    assert doubt(0.999e-3)[0].startswith("no block is longer than 0.001 m; if the file is in larger units")
    assert doubt(1.0, density=200.0) == doubt(1.0, density=20e3) == doubt(1.0, density=1.0) == []
    assert doubt(1.0, density=199.0) == ["the density is 199 kg/m3; that of a file is in kg/m3"]
    assert doubt(1.0, density=20001.0)[0].startswith("the density is 20001 kg/m3")
    assert doubt(1.0, ground=1.0) == []  # supports have no weight
    for factor, told in ((0.99, 0), (1.01, 1)):
        weight = 6e10 * factor
        pull = -weight / (1e4 / 8)  # which is doubted, too
        heavy = [text for text in doubt(1.0, density=1e4, gravity=pull) if not text.startswith("gravity is")]
        assert len(heavy) == told
        assert not told or heavy[0].startswith(f"the blocks weigh {weight / 1e3:.2g} kN, more than the largest pyramid")
    pair = assembly(
        [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1), density=1.0), box((0, 0, 1), (1, 1, 2), density=300.0)]
    )
    assert doubts(pair) == ["densities go from 1 to 300 kg/m3; that of a file is in kg/m3"]
    assert doubts(assembly([box((0, 0, 0), (99, 1, 1))])) == []  # nothing is free


def test_friction_that_may_be_an_angle_and_weights_that_may_be_in_kilonewtons_are_doubted():
    blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1))]
    asm = assembly(blocks)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for friction in (0.0, 3.0, np.inf):
            assert doubts(Assembly.from_blocks(blocks, supports=[0], friction=friction)) == []
            friction_limit(asm)  # which asks for high coefficients itself
    # tan 30 degrees is 1 / sqrt(3).
    for friction, angle in ((30.0, ": 30 degrees are 0.577"), (100.0, "")):
        told = re.escape(f"friction is {friction:g}; it is the tangent of an angle{angle}") + "$"
        with pytest.warns(InputWarning, match=told):
            Assembly.from_blocks(blocks, supports=[0], friction=friction)
    laws = [JointLaw(("*", "*"), friction=45), JointLaw(("*", "*"), cohesion=1.0)]
    assert doubts(asm.with_(joints=laws)) == [
        'friction between "*" and "*" is 45; it is the tangent of an angle: 45 degrees are 1'
    ]
    loads = {
        "rubble": {"kind": "fill", "level": 2, "unit_weight": 18},
        "clay": {"kind": "fill", "level": 2, "unit_weight": 1000.0},
        "wind": {"kind": "body", "force": [1, 0, 0]},
        "forces": np.zeros((2, 6)),
    }
    told = ["loads.rubble.unit_weight is 18 N/m3; if it is in kN/m3, give 18000"]
    assert doubts(asm.with_(metadata={"loads": loads})) == told
    assert doubts(asm.with_(metadata={"loads": loads}, support=np.ones(2, dtype=bool))) == told
    assert doubts(asm.with_(metadata={"loads": "none"})) == []


@pytest.mark.parametrize(("axis", "sign"), [(0, 1), (0, -1), (1, 1), (1, -1)])
def test_blocks_beside_their_supports_are_doubted_along_their_axis(axis, sign):
    def row(shift=0.0, rise=0.0, **options):
        """A support and three blocks in a row along an axis, moved along it and upwards."""
        blocks = []
        for k in range(4):
            low = np.array([0.0, 0.0, rise * (k > 0)])
            low[axis] += sign * (k + shift * (k > 0))
            blocks.append(box(low, low + 1, density=300.0))
        return doubts(assembly(blocks, gravity=(0, 0, -9.81), **options))

    name = ("-" if sign < 0 else "") + "xy"[axis]
    told = f"the blocks are beside their supports, along {name}, and not above them; if {name} is up, give --up {name}"
    assert row() == [told]
    assert row(supports=[0, 1]) == [told]
    assert row(supports=[0, 3]) == []  # supports at both ends
    assert row(supports=[1]) == []  # and between blocks
    assert row(supports=[]) == []
    assert row(shift=-1.2) == []  # one is before its support
    assert row(rise=2.0) == []  # they lie above as well
    # Beside along both axes, and by more of the scene's extent along the one: 9 of 10 against 8.5 of 17.
    support, stone = np.zeros((2, 3)), np.zeros((2, 3))
    support[1, axis], support[1, 1 - axis], support[1, 2] = 1.0, 9.0, 1.0
    stone[:, axis], stone[:, 1 - axis], stone[1, 2] = np.array([0.0, 1.0]) + 9.0 * sign, (9.0, 17.0), 1.0
    assert doubts(assembly([box(*support), box(*stone, density=300.0)], gravity=(0, 0, -9.81))) == [told]
    leaning = np.zeros(3)
    leaning[axis], leaning[2] = 9.0, -9.0
    blocks = [box((0, 0, 0), (1, 1, 1), density=300.0)]
    place = np.zeros(3)
    place[axis] = sign * 3
    assert doubts(assembly([*blocks, box(place, place + 1, density=300.0)], gravity=leaning)) == []


def test_a_json_file_is_of_compas_where_it_names_a_type_and_no_blocks():
    assert is_compas({"dtype": "a/B", "data": {}})
    assert not is_compas({"dtype": "a/B", "blocks": []})
    assert not is_compas({"data": {}})
    assert not is_compas(["dtype"])


@pytest.mark.parametrize(
    "data",
    [
        [{"dtype": "compas.datastructures/Mesh", "value": {"vertex": {}}}],
        {"dtype": "compas.datastructures/Network", "value": {}},
        {"attributes": {"name": "Network"}, "dna": {}, "dea": {"interface": None}, "node": {"0": {"x": 0.5}}},
        {"assembly": {"adjacency": {}}, "blocks": {"0": {"dea": {}, "vertex": {"1": {"x": -2.0}}}}},
    ],
)
def test_files_of_old_versions_of_compas_are_told_as_such(tmp_path, data):
    path = tmp_path / "old.json"
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match="written by COMPAS 1 or an older version; load it in COMPAS 2"):
        read_parts(path)


def test_supports_are_asked_for_by_the_names_that_can_be_given(tmp_path):
    path = write(Assembly.from_blocks([box((k, 0, 0), (k + 1, 1, 1)) for k in range(2)]), tmp_path / "two.json")
    data = json.loads(path.read_text())
    for block in data["blocks"]:
        block["name"] = "Mesh"
    path.write_text(json.dumps({"blocks": data["blocks"]}))
    with pytest.warns(InputWarning, match="numbered from .0"):
        assert read_parts(path, supports=[]).blocks[1].name == "Mesh.1"
    with pytest.raises(NoSupportError, match=r"\(blocks: Mesh\.0, Mesh\.1\)"):
        chosen_supports([], None, ["Mesh", "Mesh"], "the file")


def test_files_that_are_not_there_or_of_no_format_are_told_apart(tmp_path):
    with pytest.raises(
        InputError, match=r'cannot read "\.doc"; formats are: \.json, \.toml, \.obj, \.glb, \.stl, \.ply'
    ):
        read_parts(tmp_path / "a.doc")
    with pytest.raises(InputError, match=r"gone\.json: no such file"):
        read_parts(tmp_path / "gone.json")
    path = tmp_path / "UPPER.JSON"
    path.write_text(json.dumps(native()))
    assert read_parts(path).options["name"] == "UPPER"
    path.write_text("[")
    with pytest.raises(InputError) as caught:
        read_parts(path)
    assert str(caught.value).count(str(path)) == 1
    path.write_text("1" * 5000)
    with pytest.raises(InputError, match="holds a number of thousands of digits"):
        read_parts(path)


def test_what_cannot_be_written_is_told_before_anything_is(tmp_path):
    asm = assembly([box((0, 0, 0), (1, 1, 1), name="a")])
    for target, options, message in (
        ("a.toml", {}, r'cannot write "\.toml"; formats are: \.json, \.obj, \.glb, \.stl, \.ply'),
        ("a.json", {"format": "ply"}, 'cannot be written as "ply"; it can be: native, compas-assembly, compas-model'),
        ("a.obj", {"format": "native"}, r'cannot be written as "native"; it can be: \.obj'),
        ("a.json", {"values": {"v": [1.0]}}, r"values are written to \.glb and \.obj only"),
        ("a.stl", {"values": {"v": [1.0]}}, r"values are written to \.glb and \.obj only"),
        ("b/a.json", {}, "no such directory: "),
        ("a.obj", {"units": "yd"}, "units are 'yd'"),
        ("a.obj", {"values": {"density": [1.0]}}, 'values: "density" must be a name that is free'),
        ("a.obj", {"values": {"v": [1.0, 2.0]}}, 'values: "v" must be'),
    ):  # fmt: skip
        with pytest.raises(InputError, match=message):
            write(asm, tmp_path / target, **options)
    assert list(tmp_path.iterdir()) == []
    written = write(asm, tmp_path / "a.obj", values={"v": [[1.0, 2.0]]})
    assert '"v": [1.0, 2.0]' in written.read_text()
    assert write(asm, tmp_path / "a.json", values={}).is_file()


def test_a_folder_is_read_in_the_order_of_its_numbers(tmp_path):
    asm = assembly(
        [box((2 * k, 0, 0), (2 * k + 1, 1, 1), name=f"s{k}", group="g.h" if k > 9 else "") for k in range(12)]
    )
    folder = write(asm, tmp_path / "stones")
    parts = folder_parts(folder, supports=["s0"])
    assert [b.name for b in parts.blocks] == ["s10", "s11", *(f"s{k}" for k in range(10))]
    assert [b.group for b in parts.blocks] == ["g.h", "g.h", *[""] * 10]
    assert parts.options == {"name": "stones"}
    assert sorted(p.name for p in (folder / "g" / "h").iterdir()) == ["s10.ply", "s11.ply"]
    with pytest.raises(NoSupportError, match="a mesh does not say which blocks are supports"):
        folder_parts(folder)
    (folder / "notes.txt").write_text("no stone")
    (folder / "dir.ply").mkdir()
    (folder / "dir.obj").mkdir()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(folder_parts(folder, supports=["s0"]).blocks) == 12
    for other in ("s12.glb", "s2.GLB", "g/s3.glb"):
        (folder / other).write_text("not looked at")
    with pytest.warns(InputWarning, match=r"stones: of a directory \.ply, \.stl and \.obj are read, and not ") as told:
        assert len(folder_parts(folder, supports=["s0"]).blocks) == 12
    assert str(told[0].message).endswith(" and not g/s3.glb, s2.GLB, s12.glb")
    (folder / "g" / "bad.STL").write_text("no stone")
    with pytest.raises(InputError, match=r"^g/bad\.STL: "):
        folder_parts(folder, supports=["s0"])
    with pytest.raises(InputError, match=r"already holds \.ply, \.stl or \.obj files"):
        write(asm, folder)


def test_stones_in_several_formats_are_refused_and_not_read_twice(tmp_path):
    asm = assembly([box((2 * k, 0, 0), (2 * k + 1, 1, 1), name=f"s{k}", group="g" if k else "") for k in range(6)])
    folder = write(asm, tmp_path / "stones")
    others = write(asm, tmp_path / "others", format="stl")
    (folder / "g" / "s2.glb").write_text("of a directory, such files are not read")
    (others / "s0.stl").rename(folder / "g" / "s0.stl")  # a stone of another group may have the same name
    with pytest.warns(InputWarning, match="and not g/s2.glb"):
        assert len(read_parts(folder, supports=[0]).blocks) == 7
    (others / "g" / "s2.stl").rename(folder / "g" / "s2.STL")
    with pytest.raises(InputError, match=r"g/s2\.STL and g/s2\.ply are one stone in several formats, .* keep"):
        read_parts(folder, supports=[0])
    for k in (1, 3, 4, 5):
        (others / "g" / f"s{k}.stl").rename(folder / "g" / f"s{k}.stl")
    with pytest.raises(InputError, match=r"g/s1\.ply and g/s1\.stl, .* \(5 in all\) are the same stones in several"):
        read_parts(folder, supports=[0])


def obj_of(*cubes):
    """Text of an OBJ of unit cubes at places along x, each an object of the name before its place."""
    lines = []
    for k, (label, x) in enumerate(cubes):
        cube = box((x, 0, 0), (x + 1, 1, 1))
        lines += [f"o {label}"] * bool(label)
        lines += [f"v {a} {b} {c}" for a, b, c in np.asarray(cube.vertices).tolist()]
        lines += ["f " + " ".join(str(8 * k + corner + 1) for corner in face) for face in cube.faces]
    return "\n".join(lines) + "\n"


def test_a_folder_of_obj_files_is_a_block_a_file_or_an_object(tmp_path):
    for place in ("wall/north", "empty"):
        (tmp_path / place).mkdir(parents=True)
    (tmp_path / "piece10.obj").write_text(obj_of(("Cube", 10)))
    (tmp_path / "piece2.OBJ").write_text("vertex count = 8\n" + obj_of(("", 2)))
    (tmp_path / "wall" / "north" / "pair.obj").write_text(obj_of(("left", 4), ("right", 6)))
    write(assembly([box((20, 0, 0), (21, 1, 1), name="round")]), tmp_path / "more", format="stl")
    parts = read_parts(tmp_path, supports=["piece2"])
    assert {(own.name, own.group) for own in parts.blocks} == {
        ("piece2", ""),
        ("piece10", ""),
        ("pair.left", "wall.north"),
        ("pair.right", "wall.north"),
        ("round", "more"),
    }
    asm = Assembly.from_blocks(parts.blocks)
    assert dict(zip(asm.names, asm.centroid[:, 0].tolist(), strict=True)) == pytest.approx(
        {"piece2": 2.5, "piece10": 10.5, "pair.left": 4.5, "pair.right": 6.5, "round": 20.5}
    )
    assert asm.names.index("piece2") < asm.names.index("piece10")
    (tmp_path / "wall" / "none.obj").write_text("v 0 0 0\n")
    with pytest.raises(InputError, match=r"wall/none\.obj: is no surface of faces"):
        read_parts(tmp_path, supports=["piece2"])
    with pytest.raises(InputError, match=r"the directory holds no \.ply, \.stl or \.obj files"):
        read_parts(tmp_path / "empty", supports=[0])


def test_what_our_obj_files_note_counts_in_a_folder_too(tmp_path):
    for name, x, friction in (("a", 0, 0.5), ("b", 2, 0.5), ("c", 4, 0.6)):
        asm = Assembly.from_blocks([box((x, 0, 0), (x + 1, 1, 1))], supports=[0][: x == 0], friction=friction)
        write(asm.with_(density=1800.0 + x), tmp_path / f"{name}.obj")
    with pytest.raises(InputError, match="its files say different values of friction"):
        read_parts(tmp_path)
    (tmp_path / "c.obj").unlink()
    parts = read_parts(tmp_path)
    assert (list(parts.supports), parts.options["friction"]) == ([0], 0.5)
    assert [own.density for own in parts.blocks] == [1800.0, 1802.0]


@pytest.mark.parametrize(("name", "file"), [
    ("50%", "50%25"), ("a/b", "a%2Fb"), (".x", "%2Ex"), ("x.", "x%2E"), ("x ", "x%20"), ("con", "%63on"),
    ("Lpt1.x", "%4Cpt1.x"), ("console", "console"), ("a:b*c?", "a%3Ab%2Ac%3F"), ("a.b", "a.b"), ("nul", "%6Eul"),
    ("com", "com"), ("com12", "com12"), ('q"<>|', "q%22%3C%3E%7C"), ("x.y.", "x.y%2E"),
])  # fmt: skip
def test_names_that_a_file_system_refuses_are_quoted(tmp_path, name, file):
    asm = assembly([box((0, 0, 0), (1, 1, 1), name=name, group="a..b")])
    folder = write(asm, tmp_path / "f", format="stl")
    assert [p.relative_to(folder).as_posix() for p in folder.rglob("*.stl")] == [f"a/%/b/{file}.stl"]
    back = folder_parts(folder, supports=[0])
    assert (back.blocks[0].name, back.blocks[0].group) == (name, "a..b")


def test_coplanar_triangles_are_one_face_unless_it_has_a_hole(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    notched = prism([(0, 0), (4, 0), (4, 3), (2.5, 3), (2.5, 1), (1, 1), (1, 3), (0, 3)], 2.0)
    asm = assembly([notched])
    path = write(asm, tmp_path / "n.stl")
    vertices, faces = read_whole(path)
    assert sorted(len(face) for face in faces) == [4] * 8 + [8, 8]
    assert Assembly.from_blocks([Block(vertices, faces)]).volume[0] == pytest.approx(18.0, rel=1e-6)
    ring = trimesh.creation.annulus(r_min=1.0, r_max=2.0, height=1.0, sections=8)
    ring.export(tmp_path / "ring.stl")
    vertices, faces = read_whole(tmp_path / "ring.stl")
    back = Assembly.from_blocks([Block(vertices, faces)])
    assert back.volume[0] == pytest.approx(ring.volume, rel=1e-6)
    assert {len(face) for face in faces} == {3, 4}  # top and bottom stay triangles, the sides are joined
    assert sum(len(face) == 4 for face in faces) == 16


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".glb"])
def test_finely_faceted_stones_keep_their_volume(tmp_path, suffix):
    trimesh = pytest.importorskip("trimesh")
    n = 500  # facets of 0.36 degrees
    angle = np.linspace(0.0, np.pi, n + 1)
    drum = prism(np.column_stack([np.cos(angle), np.sin(angle)]), 1.0)
    mesh = block_mesh(assembly([drum]), 0)
    trimesh.Scene(mesh).export(tmp_path / f"drum{suffix}")
    (block,) = mesh_parts(tmp_path / f"drum{suffix}", supports=[0]).blocks
    assert Assembly.from_blocks([block]).volume[0] == pytest.approx(n / 2 * np.sin(np.pi / n), rel=1e-6)
    assert len(block.faces) == n + 3  # the two ends, the cut and the facets
    trimesh.Scene(trimesh.creation.box((3, 2, 1))).export(tmp_path / f"box{suffix}")
    assert len(mesh_parts(tmp_path / f"box{suffix}", supports=[0]).blocks[0].faces) == 6


def test_blocks_of_a_glb_are_called_as_its_objects_are(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    scene, cube = trimesh.Scene(), trimesh.creation.box((1, 1, 1))
    places = {"base": "Cube.003", "7": "Cube.004", "keystone": "Cube.001"}
    for k, (node, mesh) in enumerate(places.items()):
        scene.add_geometry(cube, node_name=node, geom_name=mesh, transform=np.diag([k + 1.0] * 3 + [1.0]))
    scene.graph.update("cap", matrix=np.diag([4.0] * 3 + [1.0]), geometry="Cube.001")  # a linked copy
    scene.export(tmp_path / "pile.glb")
    found = {b.name: np.ptp(b.vertices[:, 0]) for b in mesh_parts(tmp_path / "pile.glb", supports=[0]).blocks}
    assert found == pytest.approx({"base": 1.0, "7": 2.0, "keystone": 3.0, "cap": 4.0})
    # A node without a name has that of its mesh.
    raw = (tmp_path / "pile.glb").read_bytes()
    size = int.from_bytes(raw[12:16], "little")
    content = json.loads(raw[20 : 20 + size])
    for node in content["nodes"]:
        node.pop("name")
    (tmp_path / "bare.glb").write_bytes(glb(content, raw[28 + size :]))
    with pytest.warns(InputWarning, match=r'several blocks share a name \("Cube.001"\)'):
        parts = mesh_parts(tmp_path / "bare.glb", supports=[0])
    assert sorted(b.name for b in parts.blocks) == ["Cube.001.0", "Cube.001.1", "Cube.003", "Cube.004"]


def test_solids_of_one_mesh_file_are_told_apart_where_they_touch(tmp_path):
    asm = assembly([box((0, 0, k), (1 + k, 1, k + 1), name=f"b{k}") for k in range(3)])
    for suffix in (".stl", ".ply"):
        parts = mesh_parts(write(asm, tmp_path / f"pile{suffix}"), supports=[0])
        assert [np.ptp(b.vertices[:, 0]) for b in parts.blocks] == pytest.approx([1, 2, 3])
        assert [b.name for b in parts.blocks] == ["pile.0", "pile.1", "pile.2"]
        assert parts.up == "z"
    single = mesh_parts(write(assembly([box((0, 0, 0), (1, 1, 1))]), tmp_path / "one.stl"), supports=[0])
    assert [b.name for b in single.blocks] == ["one"]
    glb = mesh_parts(write(asm, tmp_path / "pile.glb"))
    assert (glb.up, glb.supports, [b.name for b in glb.blocks]) == ("y", [0], ["b0", "b1", "b2"])
    assert glb.options == {"name": "pile", "friction": asm.friction, "gravity": [0.0, 0.0, -1.0]}


@pytest.mark.parametrize("suffix", [".stl", ".ply"])
def test_solids_that_share_no_corner_are_told_apart_in_any_order_of_their_triangles(tmp_path, suffix):
    solids = [trimesh.creation.box(bounds=[(0.7 * k, 0, 0), (0.7 * k + 0.5, 1, 1 + k)]) for k in range(4)]
    soup = trimesh.util.concatenate(solids)
    order = np.random.default_rng(3).permutation(len(soup.faces))
    mixed = trimesh.Trimesh(soup.vertices, soup.faces[order], process=False)
    mixed.export(tmp_path / f"mixed{suffix}")
    blocks = mesh_parts(tmp_path / f"mixed{suffix}", supports=[0]).blocks
    assert sorted(float(np.ptp(b.vertices[:, 2])) for b in blocks) == pytest.approx([1, 2, 3, 4])
    assert all(float(np.ptp(b.vertices[:, 0])) == pytest.approx(0.5) for b in blocks)


def test_a_mesh_without_faces_or_with_bad_corners_is_refused(tmp_path):
    path = obj(tmp_path, "v 0 0 0")
    with pytest.raises(InputError, match="the file holds no solid"):
        mesh_parts(path, supports=[0])
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    faces = "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    good = ["0 0 0", "2 0 0", "0 3 0", "0 0 4"]
    rows = ["3 0 2 1", "3 0 1 3", "3 0 3 2", "3 1 2 3"]
    ply = tmp_path / "p.ply"
    ply.write_text(head + faces + "\n".join([*good, *rows]) + "\n")
    assert Assembly.from_blocks([Block(*read_whole(ply))]).volume[0] == pytest.approx(4.0)
    ply.write_text(head + faces + "\n".join(["0 0 0", "inf 0 0", *good[2:], *rows]) + "\n")
    with pytest.raises(InputError, match=r"^coordinates must be finite and below 1e\+30 \(vertex 1\)"):
        read_whole(ply)
    with pytest.raises(InputError, match=r'^object "p": coordinates must be finite and below 1e\+30 \(vertex 1\)'):
        mesh_parts(ply, supports=[0])
    for corner in (4, -1):
        ply.write_text(head + faces + "\n".join([*good, *rows[:2], f"3 0 3 {corner}", rows[3]]) + "\n")
        with pytest.raises(InputError, match=r"a face has a corner that does not exist \(face 2\)"):
            read_whole(ply)
    ply.write_text(head + "end_header\n" + "\n".join(good) + "\n")
    with pytest.raises(InputError, match="is no surface of faces"):
        read_whole(ply)


def glb(content, data=b""):
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data if data else b""
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def test_a_compressed_glb_says_what_it_needs(tmp_path):
    path = tmp_path / "c.glb"
    content = {"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression", "KHR_other"]}
    path.write_bytes(glb(content))
    with pytest.raises(InputError, match="it needs KHR_draco_mesh_compression; export it without compression"):
        mesh_parts(path, supports=[0])
    content["extensionsRequired"] = ["EXT_meshopt_compression"]
    path.write_bytes(glb(content))
    with pytest.raises(InputError, match="it needs EXT_meshopt_compression; export"):
        mesh_parts(path, supports=[0])


CUBE = box((0, 0, 0), (1, 1, 1))


def cubes(path, *nodes, mode=4, accessor=None, **changes):
    """Write a GLB of a cube of 1 m, its low corner at the origin, which all of some nodes show."""
    triangles = np.array([(f[0], f[k], f[k + 1]) for f in CUBE.faces for k in (1, 2)], dtype="<u4")
    corners = np.asarray(CUBE.vertices)[:, [0, 2, 1]] * [1, 1, -1]  # y is up
    data = corners.astype("<f4").tobytes() + triangles.tobytes()
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "mode": mode}
    content = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [*range(len(nodes))]}],
        "nodes": [{"mesh": 0} | node for node in nodes], "meshes": [{"name": "cube", "primitives": [primitive]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"} | (accessor or {}),
            {"bufferView": 1, "componentType": 5125, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 144},
        ],
        "buffers": [{"byteLength": 240}],
    }  # fmt: skip
    path.write_bytes(glb(content | changes, data))
    return path


def places(path, supports=(0,)):
    """Names of the blocks of a file, and where their low corners are along x."""
    return [(b.name, round(float(np.min(b.vertices[:, 0])), 6)) for b in mesh_parts(path, supports=supports).blocks]


def test_blocks_of_a_glb_are_in_the_order_of_its_nodes(tmp_path):
    nodes = [{"name": name, "translation": [2 * k, 0, 0]} for k, name in enumerate(("c", "a", "b"))]
    path = cubes(tmp_path / "row.glb", *nodes)
    assert places(path) == [("c", 0), ("a", 2), ("b", 4)]
    cubes(path, *nodes, scenes=[{"nodes": [2, 0, 1]}])  # the order in which a scene lists them is none
    assert places(path) == [("c", 0), ("a", 2), ("b", 4)]
    twelve = [{"name": str(12 - k), "translation": [k, 0, 0]} for k in range(12)]
    assert places(cubes(path, *twelve)) == [(str(12 - k), k) for k in range(12)]


def test_objects_of_another_scene_of_a_glb_are_not_left_out_silently(tmp_path):
    """Only the scene that a file shows is read, as glTF 2.0 (3.5.1) says; nodes of no scene are shown nowhere."""
    nodes = [{"name": name, "translation": [2 * k, 0, 0]} for k, name in enumerate(("a", "b", "c"))]
    path = cubes(tmp_path / "two.glb", *nodes, scene=1, scenes=[{"nodes": [1]}, {"nodes": [0, 2]}])
    with pytest.raises(InputError, match='left out: "b"; export all in one scene'):
        mesh_parts(path, supports=[0])
    cubes(path, *nodes, {"name": "group", "children": [1], "mesh": 0}, scenes=[{"nodes": [0]}, {"nodes": [3]}])
    with pytest.raises(InputError, match='left out: "b", "group"; export'):
        mesh_parts(path, supports=[0])
    cubes(path, *nodes, scenes=[{"nodes": [0, 1]}, {"nodes": [0]}])
    assert places(path) == [("a", 0), ("b", 2)]


def test_names_that_nodes_of_a_glb_share_are_numbered_and_told(tmp_path):
    nodes = [{"name": name, "translation": [2 * k, 0, 0]} for k, name in enumerate(("stone", "cap", "stone"))]
    path = cubes(tmp_path / "row.glb", *nodes)
    with pytest.warns(InputWarning, match=r'several blocks share a name \("stone"\)'):
        assert places(path) == [("stone.0", 0), ("cap", 2), ("stone.1", 4)]
    with pytest.raises(InputError, match='2 blocks are named "stone"; give their indices'):
        places(path, supports=["stone"])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"extensionsRequired": ["KHR_mesh_quantization", "KHR_materials_unlit"]},
            "it needs KHR_mesh_quantization; of extensions, it may need those of materials, textures and lights",
        ),
        ({"extensionsRequired": ["EXT_mesh_gpu_instancing"]}, "it needs EXT_mesh_gpu_instancing; of extensions"),
        ({"accessor": {"normalized": True}}, 'mesh "cube": its corners are stored as normalized numbers'),
        ({"accessor": {"sparse": {"count": 1}}}, 'mesh "cube": its corners are stored as sparse numbers'),
        *(({"mode": mode}, f'mesh "cube": it is drawn in mode {mode}; only triangles') for mode in (0, 1, 2, 3, 6)),
    ],
)
def test_what_of_a_glb_would_be_left_out_is_refused(tmp_path, changes, words):
    path = cubes(tmp_path / "c.glb", {"name": "a"}, {"name": "b"}, **changes)
    with pytest.raises(InputError, match=words):
        mesh_parts(path, supports=[0])


def test_copies_that_a_node_of_a_glb_stands_for_are_refused(tmp_path):
    copied = {"name": "row", "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}}
    path = cubes(tmp_path / "c.glb", {"name": "a"}, copied, extensionsUsed=["EXT_mesh_gpu_instancing"])
    with pytest.raises(
        InputError, match=r'^object "row": it stands for copies \(EXT_mesh_gpu_instancing\); export each'
    ):
        mesh_parts(path, supports=[0])


def test_extensions_that_change_no_corner_and_odd_extras_are_read_over(tmp_path):
    harmless = ["KHR_materials_unlit", "KHR_texture_transform", "KHR_lights_punctual", "EXT_texture_webp"]
    assert places(cubes(tmp_path / "c.glb", {"name": "a"}, extensionsRequired=harmless)) == [("a", 0)]
    for extras in ("text", {"extras": "text"}, ["text"]):
        path = cubes(tmp_path / "c.glb", {"name": "a", "extras": "text"})
        raw = path.read_bytes()
        content = json.loads(raw[20 : 20 + int.from_bytes(raw[12:16], "little")])
        content["meshes"][0]["extras"] = extras
        path.write_bytes(glb(content, raw[-240:]))
        assert places(path) == [("a", 0)]


def stl(*solids):
    """Text of an STL: a name, and where the low corner of a cube of 1 m is along x."""
    lines = []
    for name, x in solids:
        corners = np.asarray(CUBE.vertices) + [x, 0, 0]
        lines.append(f"solid {name}".rstrip())
        for face in CUBE.faces:
            for own in ((face[0], face[k], face[k + 1]) for k in (1, 2)):
                points = [f"vertex {' '.join(map(str, corners[c].tolist()))}" for c in own]
                lines += ["facet normal 0 0 0", "outer loop", *points, "endloop", "endfacet"]
        lines.append(f"endsolid {name}".rstrip())
    return "\n".join(lines) + "\n"


def test_solids_of_an_stl_as_text_are_called_as_their_lines_say(tmp_path):
    path = tmp_path / "row.stl"
    for names in (("solid a", "wall", "b solid"), ("Mur \u00e9", "endsolid", "vertex 1"), ("10", "2", "1")):
        path.write_text(stl(*zip(names, (0, 2, 4), strict=True)), encoding="utf-8")
        assert places(path) == list(zip(names, (0, 2, 4), strict=True))
    path.write_text("\ufeff" + stl(("", 0), ("b", 2), ("", 4)).replace("solid", "  SOLID"), encoding="utf-8")
    path.write_text(path.read_text(encoding="utf-8").replace("end  SOLID", "\tENDSOLID"), encoding="utf-8")
    assert places(path) == [("row.0", 0), ("b", 2), ("row.2", 4)]
    for name, label in (("", "row"), ("a wall", "a wall")):
        path.write_text(stl((name, 3)))
        assert places(path) == [(label, 3)]
    path.write_text(stl(("a", 0), ("a", 2)))
    with pytest.warns(InputWarning, match=r'several blocks share a name \("a"\)'):
        assert places(path) == [("a.0", 0), ("a.1", 2)]


def test_an_stl_as_text_that_is_cut_short_is_refused(tmp_path):
    whole = stl(("a", 0), ("b", 2), ("c", 4))
    lines = whole.splitlines(keepends=True)
    path = tmp_path / "cut.stl"
    for left in (lines[:-1], lines[:-10], lines[: 2 * len(lines) // 3 + 1]):
        path.write_text("".join(left))
        with pytest.raises(
            InputError, match=r'cut\.stl: it is cut short: 3 lines begin with "solid" and 2 with "endsolid"'
        ):
            read(path, supports=[0])
    stones = tmp_path / "stones"
    stones.mkdir()
    (stones / "one.stl").write_text("".join(lines[:30]))
    with pytest.raises(InputError, match=r'one\.stl: it is cut short: 1 lines begin with "solid" and 0 with "end'):
        read(stones, supports=[0])


def test_what_a_glb_needs_is_said_in_its_first_part_and_not_in_its_numbers(tmp_path):
    path = tmp_path / "n.glb"
    words = b'"extensionsRequired": ["KHR_draco_mesh_compression"]'
    path.write_bytes(glb({"asset": {"version": "2.0"}}, words + b" " * (-len(words) % 4)))
    with pytest.raises(InputError) as caught:
        mesh_parts(path, supports=[0])
    assert "it needs" not in str(caught.value)


def test_a_name_like_the_root_of_a_scene_comes_back(tmp_path):
    asm = assembly([box((0, 0, 0), (1, 1, 1), name="world"), box((0, 0, 1), (1, 1, 2), name="other")])
    assert read(write(asm, tmp_path / "w.glb")).names == ("world", "other")


def test_tables_of_a_scene_are_written_with_their_headings():
    data = {
        "name": 'a "b"', "none": None, "flag": True, "off": False, "number": 3, "real": 0.1, "list": [1, (2.5, "x")],
        "range": {"value": 1, "min": 0, "max": None}, "empty": {}, "in ner": {"a": 1, "deep": {"b": [True]}},
        "last": {"c": "d"},
    }  # fmt: skip
    assert _table(data, "").splitlines() == [
        'name = "a \\"b\\""', "flag = true", "off = false", "number = 3", "real = 0.1", 'list = [1, [2.5, "x"]]',
        "range = { value = 1, min = 0 }", "empty = {  }", "", '["in ner"]', "a = 1", "", '["in ner".deep]',
        "b = [true]", "", "[last]", 'c = "d"',
    ]  # fmt: skip


@pytest.mark.parametrize(
    "word", ["\U0001f9f1 brick", "Kämpfer \uffff", "rubbed out \x7f", 'a\t"b"\r\n\\\x00\x1f\x85\u2028']
)
def test_a_scene_of_any_characters_reads_back(word, tmp_path):
    data = {"name": "hut", "length": 3.0, "span": 2.0, "description": word, "cases": {word: {"factors": {word: 1}}}}
    scene = scene_from(data | {"loads": {word: {"kind": "acceleration", "direction": [1, 0, 0]}}})
    path = tmp_path / "hut.toml"
    path.write_text(scene_text(scene), encoding="utf-8")
    assert load_scene(path) == scene


def test_a_surface_is_read_from_every_format_in_its_unit_and_its_axes(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    corners = np.array([(0, 0, 0), (2, 0, 1), (2, 3, 1), (0, 3, 0.5)])
    path = obj(tmp_path, *(f"v {x} {y} {z}" for x, y, z in corners), "f 1 2 3 4")
    found, faces = read_surface(path, units="cm")
    assert len(faces) == 1
    np.testing.assert_allclose(found[faces[0]], corners / 100, rtol=1e-12)
    mesh = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    for suffix in (".ply", ".stl"):
        mesh.export(tmp_path / f"s{suffix}")
        found, faces = read_surface(tmp_path / f"s{suffix}")
        assert len(found) == 4
        assert sorted(found[faces].round(6).tolist()) == sorted(corners[[[0, 1, 2], [0, 2, 3]]].tolist())
    mesh.export(tmp_path / "s.glb")  # whose y is up: what it has along y is the height
    found, faces = read_surface(tmp_path / "s.glb")
    np.testing.assert_allclose(sorted(found[:, 2]), sorted(corners[:, 1]), atol=1e-6)
    np.testing.assert_allclose(sorted(found[:, 1]), sorted(-corners[:, 2]), atol=1e-6)


def test_objects_of_a_surface_are_joined_where_their_corners_coincide(tmp_path):
    lines = ["o a", "v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "f 1 2 3 4"]
    more = ["o b", "v 1 0 0", "v 2 0 0", "v 2 1 0", "v 1.0000005 1 0", "f 5 6 7 8", "f 5 5 6"]
    found, faces = read_surface(obj(tmp_path, *lines, *more))
    assert (len(found), len(faces)) == (6, 2)
    assert len(set(faces[0]) & set(faces[1])) == 2
    apart, _ = read_surface(obj(tmp_path, *lines, *(line.replace("1.0000005", "1.00001") for line in more)))
    assert len(apart) == 7


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("far", [0.0, 4096.0])
def test_corners_of_a_surface_are_one_by_its_size_wherever_it_stands(tmp_path, axis, far):
    """The surface is 1 x 1 m: corners that are half a millimetre from each other are two."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 0.9995, 0), (0, 1, 0)])
    corners[:, axis] += far
    found, faces = read_surface(obj(tmp_path, *(f"v {x} {y} {z}" for x, y, z in corners), "f 1 2 3 5", "f 1 2 4"))
    assert len(found) == 5
    assert [len(face) for face in faces] == [4, 3]


def test_what_is_no_surface_is_refused_with_its_file(tmp_path):
    for target, message in (
        ("a.json", r'cannot read a surface from "\.json"; formats are: \.obj'),
        ("a.obj", "no such file"),
    ):
        with pytest.raises(InputError, match=f"{target}: {message}"):
            read_surface(tmp_path / target)
    path = obj(tmp_path, "v 0 0 0", "v 1 0 0", "v 0 1 0")
    with pytest.raises(InputError, match=r"made\.obj: the file holds no faces"):
        read_surface(path)
    with pytest.raises(InputError, match=r"made\.obj: line 1: "):
        read_surface(obj(tmp_path, "v 0 0"))
    with pytest.raises(InputError, match=r"made\.obj: its corners must be finite"):
        read_surface(obj(tmp_path, "v 0 0 nan", "v 1 0 0", "v 0 1 0", "f 1 2 3"))
    with pytest.raises(
        InputError, match=r"made\.obj: all corners of its faces are at one place; a surface must extend"
    ):
        read_surface(obj(tmp_path, "v 5 5 5", "v 5 5 5", "v 5 5 5", "f 1 2 3"))
    with pytest.raises(InputError, match=r"made\.obj: no face has three corners that are apart"):
        read_surface(obj(tmp_path, "v 0 0 0", "v 1 0 0", "v 1 0 0", "f 1 2 3"))
    junk = tmp_path / "junk.ply"
    junk.write_bytes(b"no mesh")
    with pytest.raises(InputError, match=r"junk\.ply: cannot be read as a mesh"):
        read_surface(junk)
    with pytest.raises(InputError, match="units are 'yd'"):
        read_surface(obj(tmp_path, "v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3"), units="yd")


def far_cube():
    """A cube of 0.3 m at UTM coordinates, where single precision has steps of 0.5 m."""
    return assembly([box((500000.0, 4600000.0, 200.0), (500000.3, 4600000.3, 200.3))], supports=[0])


def test_a_glb_far_from_the_origin_keeps_its_blocks(tmp_path):
    asm = far_cube()
    before = asm.vertices.copy()
    again = read(write(asm, tmp_path / "far.glb"))
    assert (asm.vertices == before).all()
    assert len(again.face_block) == 6
    for found, wanted in zip(again.bounds, asm.bounds, strict=True):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-7)


@pytest.mark.parametrize("name", ["far.stl", "far.ply", "far"])
def test_seven_digits_that_move_corners_are_told(name, tmp_path):
    with pytest.warns(InputWarning, match=r"seven digits, so corners moved by up to 0\.2 m"):
        write(far_cube(), tmp_path / name)


def test_a_fine_curve_far_from_the_origin_stays_a_curve(tmp_path):
    # Half a disc of radius 2 and a metre thick, in 800 steps. As text, an STL holds all digits.
    angle = np.linspace(0, np.pi, 801)
    x, z = 2 * np.cos(angle), 2 * np.sin(angle)
    near, far = (np.column_stack([x, np.full(801, y), z]) for y in (0.0, 1.0))
    quads = [(near[k], near[k + 1], far[k + 1], far[k]) for k in range(800)]
    quads.append((near[800], near[0], far[0], far[800]))
    triangles = [t for a, b, c, d in quads for t in ((a, c, b), (a, d, c))]
    triangles += [t for k in range(1, 800) for t in ((near[0], near[k], near[k + 1]), (far[0], far[k + 1], far[k]))]
    place = np.array([500000.0, 4600000.0, 200.0])
    lines = ["solid disc"]
    for triangle in triangles:
        corners = [f"vertex {' '.join(map(repr, (np.round(c, 9) + place).tolist()))}" for c in triangle]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    path = tmp_path / "disc.stl"
    path.write_text("\n".join([*lines, "endsolid disc"]))
    asm = read(path, supports=[0])
    # Of the curve no more than neighbours a millionth of the disc apart are one face.
    assert len(asm.face_block) > 40
    assert asm.volume == pytest.approx(800 * 2.0 * np.sin(np.pi / 800), rel=1e-5)


def test_faces_that_list_their_own_corners_are_one_block_or_as_many_as_close(tmp_path):
    lines = []
    for block in (box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))):
        for face in block.faces:
            lines += [f"v {' '.join(map(str, block.vertices[corner]))}" for corner in face] + ["f -4 -3 -2 -1"]
    assert read(obj(tmp_path, *lines[:30]), supports=[0]).volume.tolist() == pytest.approx([1.0])
    assert read(obj(tmp_path, *lines), supports=[0]).volume.tolist() == pytest.approx([1.0, 1.0])
    with pytest.raises(InputError, match="open"):
        read(obj(tmp_path, *lines[:25]), supports=[0])


@pytest.mark.parametrize(
    ("suffix", "form"),
    [(".json", "native"), (".json", "compas-assembly"), (".json", "compas-model"), (".obj", None), (".glb", None)],
)
def test_a_friction_without_limit_is_no_number_of_a_file(tmp_path, suffix, form):
    """JSON has no infinity: strict readers refuse what Python writes for it."""
    law = {"joints": [JointLaw(("*", "*"), friction=np.inf)]} if form == "native" else {}
    rough = assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))]).with_(friction=np.inf, **law)
    path = write(rough, tmp_path / f"rough{suffix}", format=form)
    assert b"Infinity" not in path.read_bytes()
    assert b'"friction": "inf"' in path.read_bytes().replace(b'"friction":"', b'"friction": "')
    for _ in range(2):
        again = read(path)
        assert again.friction == np.inf
        assert [joint.friction for joint in again.joints] == [np.inf] * len(rough.joints)
        if suffix == ".glb":
            break
        path.write_text(path.read_text().replace('"friction": "inf"', '"friction": Infinity'))  # as 0.2 wrote it


@pytest.mark.parametrize("given", ["high", "-inf", "nan"])
def test_other_texts_are_no_friction(tmp_path, given):
    path = write(assembly([box((0, 0, 0), (1, 1, 1))]), tmp_path / "one.json")
    path.write_text(path.read_text().replace('"friction": 0.7', f'"friction": "{given}"'))
    with pytest.raises(InputError, match=r"one.json: friction: it must be a number, not a text"):
        read(path)


def test_metadata_that_is_no_json_is_refused(tmp_path):
    odd = assembly([box((0, 0, 0), (1, 1, 1))]).with_(metadata={"note": np.inf})
    with pytest.raises(InputError, match="the metadata cannot be written as JSON"):
        write(odd, tmp_path / "odd.json")


@pytest.mark.parametrize(
    ("names", "group", "size"),
    [(["g", "b" * 260], "", 264), (["g", "ü" * 130], "", 264), (["b"], "p." + "q" * 300, 300)],
)
def test_a_block_whose_file_could_have_no_name_is_named_and_nothing_is_written(tmp_path, names, group, size):
    blocks = [box((0, 0, k), (1, 1, k + 1), name=name, group=group) for k, name in enumerate(names)]
    place = tmp_path / "blocks"
    with pytest.raises(InputError, match=rf'blocks: block "{names[-1][:20]}.* would need a name of {size} bytes'):
        write(Assembly.from_blocks(blocks), place)
    assert not place.exists()
