"""More tries of an enemy: meshes, numbers, names, formulas and places. Each ends with one sentence and status 2."""

import gzip
import json
import math
import struct

import numpy as np
import pytest

from blockstat import (
    Assembly,
    InputError,
    Random,
    build_by_courses,
    find_order,
    read,
    reliability,
    safest_order,
    settle,
    settlement,
    write,
)
from blockstat.cli.commands import app
from blockstat.cli.options import _status
from evidence.scenes.small import box, stack

CUBE = {
    "name": "cube",
    "vertices": [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
    "faces": [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
}
TOP = CUBE | {"name": "top", "vertices": [[x, y, z + 1] for x, y, z in CUBE["vertices"]]}
TRIANGLES = [[a, b, c] for face in CUBE["faces"] for a, b, c in (face[:3], [face[0], *face[2:]])]


def native(**changes):
    return json.dumps({"supports": [0], "blocks": [CUBE, TOP]} | changes).encode()


def glb(*changes):
    """A cube, with changes (path of keys, value) of its JSON."""
    binary = np.array(CUBE["vertices"], np.float32).tobytes() + np.array(TRIANGLES, np.uint16).tobytes()
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "a"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
        "buffers": [{"byteLength": 168}],
    }  # fmt: skip
    for path, value in changes:
        place = tree
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def ply(head):
    return b"ply\nformat ascii 1.0\n" + head + b"\nend_header\n3 0 0 0\n"


def piece(height):
    return f"[elements.a]\nkind='box'\nsize=[1,1,{height}]\n".encode()


def formula(text):
    return piece(f'"= {text}"')


def freeform(height):
    head = "[elements.a]\nkind='freeform'\nx=[-1,1]\ny=[0,1]\nthickness=0.1\ncourses=4\nvoussoirs=4\n"
    return f"{head}height='{height}'\n".encode()


def compas(dtype, data):
    return json.dumps({"dtype": dtype, "data": data}).encode()


NAN = b"facet normal nan nan nan\nouter loop\nvertex nan 0 0\nvertex 1 0 0\nvertex 0 inf 0\nendloop\nendfacet\n"
FILES = {
    "count.glb": glb((("accessors", 0, "count"), 2**32)),
    "offset.glb": glb((("bufferViews", 0, "byteOffset"), -50)),
    "matrix.glb": glb((("nodes", 0, "matrix"), [1e308] * 16)),
    "uri.glb": glb((("buffers", 0, "uri"), "data:application/octet-stream;base64,!!!!")),
    "flat.glb": glb((("nodes", 0, "scale"), [0, 0, 0])),
    "type.glb": glb((("accessors", 1, "componentType"), 9999)),
    "draco.glb": glb((("extensionsRequired",), ["KHR_draco_mesh_compression"])),
    "meshopt.glb": glb((("extensionsRequired",), ["EXT_meshopt_compression"])),
    "negative.obj": b"o a\nv 0 0 0\nf -1000000 -2 -3\n",
    "nothing.obj": b"f 1 2 3\n",
    "long.obj": b"o a\n" + b"v " + b"1 " * 200_000 + b"\n",
    "library.obj": b"mtllib ../../etc/passwd\nusemtl x\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "many.stl": b"x" * 80 + struct.pack("<I", 0xFFFFFFFF) + bytes(50),
    "cut.stl": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n",
    "nan.stl": b"solid a\n" + 4 * NAN + b"endsolid\n",
    "many.ply": ply(b"element vertex 99999999999\nproperty float x\nproperty float y\nproperty float z"),
    "less.ply": ply(b"element vertex -5\nproperty float x"),
    "list.ply": ply(b"element vertex 1\nproperty list uchar float x"),
    "twice.json": b'{"blocks":[],"blocks":5,"supports":[0]}',
    "nan.json": native().replace(b"[1, 1, 1]", b"[NaN, 1, 1]", 1),
    "cells.json": native(joints=[{"between": ["*", "*"], "cells": 10**9}]),
    "tie.json": native(ties=[{"between": [0, 0], "points": [[0, 0, 0], [0, 0, 0]]}]),
    "slack.json": native(ties=[{"between": [0, 1], "points": [[0, 0, 0], [1e308, 0, 0]], "greatest": -5}]),
    "friction.json": native(friction=float("nan")),
    "gravity.json": native(gravity=[0, 0, -1e-320]),
    "support.json": native(supports=[0, -1]),
    "true.json": native(supports=[True]),
    "copies.json": native(blocks=[CUBE, CUBE | {"name": "b"}]),
    "inside.json": native(blocks=[CUBE | {"faces": CUBE["faces"] + [[0, 1, 2]] * 5}, TOP]),
    "small.json": native(blocks=[CUBE | {"vertices": (np.array(CUBE["vertices"]) * 1e-200).tolist()}, TOP]),
    "density.json": native(density="heavy"),
    "compas.json": compas(["a"], {}),
    "node.json": compas(
        "compas_assembly.datastructures/Assembly",
        {"graph": {"dtype": "g", "data": {"node": {"__import__('os').system('x')": {"block": None}}}}},
    ),
    "zipped.json": gzip.compress(native()),
    "archive.zip": b"PK\3\4junk",
    "date.toml": piece("2020-01-01"),
    "nan.toml": piece("nan"),
    "inf.toml": piece("inf"),
    "true.toml": piece("true"),
    "thin.toml": piece("1e-300"),
    "import.toml": formula("__import__('os').system('touch pwned')"),
    "class.toml": formula("(1).__class__"),
    "power.toml": formula("2**100000000"),
    "text.toml": formula("'a'*10**9"),
    "huge.toml": formula("1e308*1e308"),
    "zero.toml": formula("0/0"),
    "loop.toml": formula("[x for x in range(9**9)]"),
    "lambda.toml": formula("lambda: 1"),
    "attribute.toml": formula("a.size"),
    "itself.toml": b"[parameters]\np='= p'\n" + formula("p"),
    "far.toml": piece("1") + b"at=[1e300,0,0]\n",
    "path.toml": b"[elements.'../../x']\nkind='box'\nsize=[1,1,1]\n",
    "folder.toml": b"[elements.a]\nkind='mesh'\nfile='.'\n",
    "own.toml": b"[elements.a]\nkind='mesh_vault'\nfile='own.toml'\nthickness=0.1\n",
    "twice.toml": b"a=1\na=2\n",
    "complex.toml": freeform("x**x**x**9"),
    "pole.toml": freeform("1/(x-x)"),
}


def tried(capsys, *words):
    """Status and message of a command."""
    status = _status(lambda: app([str(word) for word in words], standalone_mode=False), "blockstat")
    return status, capsys.readouterr().err


def assert_one_sentence(status, message, errors=1):
    lines = [line for line in message.splitlines() if not line.startswith("warning: ")]
    assert status == 2, message
    assert len(lines) == errors
    assert all(line.startswith("blockstat: ") and len(line) < 1000 for line in lines)
    assert "internal error" not in message


@pytest.mark.parametrize("name", FILES)
@pytest.mark.filterwarnings("ignore")
def test_a_file_is_refused_with_one_sentence(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(FILES[name])
    supports = () if name.endswith((".json", ".toml")) else ("--supports", "0")
    errors = 2 if name == "far.toml" else 1  # the ground goes as far as the block that stands on it
    assert_one_sentence(*tried(capsys, "check", name, *supports), errors)
    assert [path.name for path in tmp_path.iterdir()] == [name]


WORDS = [
    f"reliability ok.json --uncertain friction=normal,0.7,0.1 --draws {'9' * 12}", "app ok.json --folder nowhere",
    "check ok.json --supports ,,,", "check ok.json --supports -1", f"check ok.json --supports {'9' * 30}",
    "check ok.json --friction nan", "check ok.json --friction -1", "check ok.json --gravity 0,0",
    "check ok.json --gravity nan,0,0", "check ok.json --gravity 1e300,0,0", "check ok.json --gap -1",
    "check ok.json --gap 2parsec", "check ok.json --gap nan", "check ok.json --gap 1e400mm",
    "check ok.json --units parsec", "check ok.json --up w", "check ok.json --solver x", "check ok.json --flow x",
    f"check ok.json --flow coulomb --tightnesses {'9' * 15}", "check ok.json -o place.obj", "check ok.json -o x.exe",
    "check ok.json -o none/x.glb", "check ok.json --imperfection x", "check ok.json --case x",
    "check ok.json --loads ok.json", "limit ok.json --load 0,0,0", "limit ok.json --load nan,0,0",
    "limit ok.json --load 1,0", "limit ok.json --directions 7", "limit ok.json --directions 4000000000",
    "limit ok.json --load 1,0,0 --tolerance 0", "limit ok.json --load 1,0,0 --tolerance nan",
    "sequence ok.json --plan ok.json", "sequence ok.json --held-at-most -3", "example ../../etc/passwd -o x.toml",
    "capacity ok.json --load 1,0,0 --steps -1", "settle ok.json --move cube:nan,0,0", "settle ok.json --move x",
    "prove ok.json -o place.obj", "repair ok.json -o r.json --gap nan", "tilt ok.json --axis 0,0,0",
    "app ok.json --port 99999999", "check place.obj", "check loop",
]  # fmt: skip


@pytest.mark.parametrize("words", WORDS)
@pytest.mark.filterwarnings("ignore")
def test_a_number_or_a_place_is_refused_with_one_sentence(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ok.json").write_bytes(native())
    (tmp_path / "place.obj").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    assert_one_sentence(*tried(capsys, *words.split()))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["loop", "ok.json", "place.obj"]


NAMES = ["../../evil", "/evil/place", "a/b", "..", "..\\w", "CON", "nul.x", "lpt1", "a\nb", "%2e", "50 %"]


@pytest.mark.parametrize("suffix", [".ply", ".stl"])
def test_names_of_blocks_are_no_places(suffix, tmp_path):
    made = [box((2 * k, 0, 0), (2 * k + 1, 1, 1), name=name) for k, name in enumerate(NAMES)]
    place = write(Assembly.from_blocks(made, supports=[0]), tmp_path / "blocks", format=suffix[1:])
    assert len(list(place.iterdir())) == len(NAMES)
    assert list(tmp_path.iterdir()) == [place]
    assert not {path.stem.split(".")[0].lower() for path in place.iterdir()} & {"con", "nul", "lpt1"}
    assert set(read(place, supports=[0]).names) == set(NAMES)


def test_names_are_no_script_in_a_report(tmp_path, capsys):
    script, image = "<script>alert(1)</script>", "<img src=x onerror=alert(2)>"
    path, page = tmp_path / "x.json", tmp_path / "x.html"
    named = [CUBE | {"name": script}, TOP | {"name": image}]
    path.write_bytes(native(blocks=named, name=f"</title>{script}"))
    status, _ = tried(capsys, "report", path, "-o", page)
    assert status == 0
    text = page.read_text()
    assert "alert(1)" in text
    assert script not in text
    assert image not in text


def test_a_name_with_a_line_end_is_no_line_of_an_obj(tmp_path):
    name = "a\nv 9 9 9\no b"
    path = write(Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), name=name)], supports=[0]), tmp_path / "a.obj")
    assert "\nv 9 9 9" not in path.read_text()
    assert read(path).names == (name,)


def test_a_mesh_without_numbers_names_its_object(tmp_path):
    path = tmp_path / "matrix.glb"
    path.write_bytes(FILES[path.name])
    with pytest.raises(InputError, match=r'matrix\.glb: object "a": coordinates must be finite and below 1e\+30'):
        read(path, supports=[0])


def test_what_a_name_says_does_not_reach_the_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text('[elements."\\u001b[2J\\nblockstat: Stable"]\nkind = "peer"\n')
    status, message = tried(capsys, "check", "a.toml")
    assert status == 2
    assert "\x1b" not in message
    assert all(line.startswith("blockstat: a.toml: elements") for line in message.splitlines())


@pytest.mark.parametrize(
    ("text", "starts"),
    [
        ('[loads.w]\nkind = ["point"]\n', ["a.toml, line 2: loads.w.kind: no kind ['point']; kinds are: point"]),
        (
            'loads = 3\ncases = "x"\n',
            ["a.toml, line 1: loads: it must be a table", "a.toml, line 2: cases: it must be"],
        ),
        (
            "load = 3\n[cases.a]\nlive = 1\n",
            ["a.toml: load: unknown key", "a.toml, line 3: cases.a.live: it must give"],
        ),
        (  # a row of a list is no heading
            '[loads.w]\nkind = "patch"\ncorners = [\n  [0, 0, 1],\n  [1, 0, 1],\n  [1, 1, 1]\n]\npresure = 1\n',
            ["a.toml, line 8: loads.w.presure: unknown key", "a.toml, line 1: loads.w: a patch load needs pressure"],
        ),
        ('[ loads . "w" ] # wind\nkind = "gale"\n', ["a.toml, line 2: loads.w.kind: no kind"]),
    ],
)
def test_a_file_of_loads_is_refused_with_a_sentence_for_each_error(text, starts, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write(stack(2), "ok.json")
    (tmp_path / "a.toml").write_text(text)
    status, message = tried(capsys, "check", "ok.json", "--loads", "a.toml", "--case", "a")
    assert status == 2
    for line, start in zip(message.splitlines(), starts, strict=True):
        assert line.startswith(f"blockstat: {start}")


@pytest.mark.parametrize("kind", ['["pier"]', "{ a = 1 }", "3"])
def test_a_kind_that_is_no_word_is_refused(kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text(f"[elements.a]\nkind = {kind}\n")
    assert_one_sentence(*tried(capsys, "check", "a.toml"))


def test_a_film_without_end_is_refused(tmp_path, monkeypatch):
    pytest.importorskip("pybullet")
    from dynsim.cli.commands import app as dynamics

    monkeypatch.chdir(tmp_path)
    write(stack(2), "ok.json")
    with pytest.raises(InputError, match="--film takes a positive number of seconds, at most 600"):
        dynamics(["verify", "ok.json", "-o", "a.gif", "--film", "1e9"], standalone_mode=False)


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e200])
def test_a_displacement_whose_square_is_no_number_is_refused(size):
    # The length of 1e-200 is 0 in floating point: the division by it ended in a crash of a library.
    with pytest.raises(InputError, match=r"displacement is .*; it must be three numbers, not all zero"):
        settle(stack(2), {"ground": (size, 0, 0)})
    with pytest.raises(InputError, match=r"direction is .*; it must be three numbers, not all zero"):
        settlement(stack(2), ["ground"], (size, 0, 0))


@pytest.mark.parametrize("kind", ["normal", "lognormal", "uniform"])
@pytest.mark.parametrize(("first", "second"), [(0.6, 1e300), (1e300, 1e300), (0.6, math.nan), (math.nan, 0.6)])
def test_a_distribution_beyond_numbers_is_refused(kind, first, second):
    with pytest.raises(InputError, match=r"must be finite and below 1e\+30"):
        Random(kind, first, second)


def test_a_lognormal_mean_of_almost_nothing_is_refused():
    with pytest.raises(InputError, match="the mean is 1e-300; it must be positive, 1e-30 at least"):
        Random("lognormal", 1e-300, 1.0)
    assert math.isfinite(Random("lognormal", 1e-29, 1e29).value(1.0))


@pytest.mark.parametrize("seed", [-5, 1.5, "one"])
def test_a_seed_that_is_no_count_is_refused(seed):
    with pytest.raises(InputError, match=r"seed is .*; it must be a whole number of at least 0"):
        reliability(stack(2), {"friction": Random("normal", 0.6, 0.1)}, draws=5, seed=seed)


@pytest.mark.parametrize("seconds", [math.nan, -1.0, "soon"])
def test_a_time_that_is_none_is_refused(seconds):
    for search in (find_order, safest_order):
        with pytest.raises(InputError, match=r"seconds is .*; it must be a number of at least 0"):
            search(stack(2), held_at_most=1, seconds=seconds)
    with pytest.raises(InputError, match=r"seconds is .*; it must be a number of at least 0"):
        build_by_courses(stack(2), seconds=seconds)
