"""Files that ask for too much, or are no files: one sentence and status 2, before anything is built."""

import json
import os

import pytest

from blockstat import Assembly, InputError, build, load_scene, read
from blockstat.cli.commands import app
from blockstat.cli.options import _status
from blockstat.model.size import ALLOWED, MOST_BLOCKS, blocks_asked, most_blocks
from blockstat.spec import compose
from blockstat.spec.composition import Composition, resolve
from blockstat.spec.elements import kind_of
from evidence.scenes.small import box

CUBE = {
    "name": "cube",
    "vertices": [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
    "faces": [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
}
PIECE = "[elements.a]\nkind = 'box'\nsize = [1, 1, {}]\n"
WALL = "kind='walls'\nbrick=[{}, 0.2]\nruns={{a={{path=[[0.0,0.0],[{},0.0]],thickness=0.3,height=3.0{}}}}}"
HUT = "length=4.0\nspan=3.0\n[brick]\nlength={}\nheight={}\n"


def native(**changes):
    return json.dumps({"supports": [0], "blocks": [CUBE]} | changes).encode()


def run(path, capsys):
    """Exit status and message of `blockstat check`."""
    supports = ["--supports", "0"] if path.suffix in (".obj", ".glb", ".stl", ".ply") else []
    status = _status(lambda: app(["check", str(path), *supports], standalone_mode=False), "blockstat")
    return status, capsys.readouterr().err


TOO_MANY = {
    "pier": "kind='pier'\nsize=[1,1]\nheight=1\ncourses=1000000000",
    "digits": "kind='pier'\nsize=[1,1]\nheight=1\ncourses=" + "9" * 300,
    "cubed": "kind='box'\nsize=[1,1,1]\nrepeat=[" + "{number=1000000,by=[2,0,0]}," * 3 + "]",
    "doubled": "kind='box'\nsize=[1,1,1]\nrepeat=[" + "{number=2,by=[2,0,0]}," * 64 + "]",
    "brick": WALL.format("1e-6", "5.0", ""),
    "dust": WALL.format("1e-300", "5.0", ""),
    "leaves": WALL.format("0.5", "5.0", ",leaves=1000000000"),
    "long": WALL.format("0.5", "5e12", ""),
    "buttresses": WALL.format("0.5", "5.0", "")
    + "\nbuttresses=[{wall='a',width=0.3,projection=0.3,height=1.0,number=1,courses=1000000000,bonded=false}]",
    "sides": "kind='column'\ndiameter=0.5\nheight=1\ndrums=1\nsides=1000000000",
    "voussoirs": "kind='arch'\nspan=2\nthickness=0.2\ndepth=1\nvoussoirs=1000000000",
    "voussoir": "kind='arch'\nspan=2\nthickness=0.2\ndepth=1\nvoussoir=1e-12",
    "barrel": "kind='barrel'\nspan=2\nthickness=0.2\nlength=5\nbrick=1e-9\nvoussoirs=9",
    "dome": "kind='dome'\nspan=2\nthickness=0.2\nrings=100000\nvoussoirs=100000",
    "freeform": "kind='freeform'\nheight='x'\nx=[-1,1]\ny=[0,1]\nthickness=0.1\ncourses=100000\nvoussoirs=100000",
    "groin": "kind='groin'\nspans=[4,4]\nthickness=0.2\nvoussoirs=9\nbrick=1e-9",
    "tower": "kind='arc_wall'\nradius=3\nthickness=0.3\nheight=3\nbrick=[1e-7,1e-7]",
}


@pytest.mark.parametrize("name", TOO_MANY)
def test_counts_are_capped_before_anything_is_built(name, tmp_path, capsys, monkeypatch):
    path = tmp_path / f"{name}.toml"
    path.write_text(f"[elements.a]\n{TOO_MANY[name]}\n")
    monkeypatch.setattr(compose, "_placed", lambda *_: pytest.fail("an element is built"))
    status, message = run(path, capsys)
    assert status == 2
    assert "elements.a: about" in message
    assert "at most 300,000 are built (`--most-blocks N`" in message


@pytest.mark.parametrize("tail", [
    "[vault]\nvoussoirs=1000000001", "[windows.south]\nwidth=0.3\nheight=0.5\nnumber=1000000000",
    "[buttresses.south]\nwidth=0.3\nheight=0.5\nthickness=0.3\nnumber=1000000000", "",
])  # fmt: skip
def test_the_short_form_is_capped_too(tail, tmp_path, capsys):
    path = tmp_path / "hut.toml"
    path.write_text(HUT.format("0.5" if tail else "1e-6", "0.25") + tail)
    status, message = run(path, capsys)
    assert status == 2
    assert "at most 300,000 are built" in message


def test_an_option_raises_the_cap(tmp_path, capsys, monkeypatch):
    path = tmp_path / "pier.toml"
    path.write_text("[elements.a]\nkind='pier'\nsize=[1,1]\nheight=1\ncourses=8\n")
    monkeypatch.setenv(ALLOWED, "7")
    with pytest.raises(InputError, match="about 8 blocks are asked for; at most 7 are built"):
        read(path)
    words = ["--most-blocks", "8", "check", str(path)]
    assert _status(lambda: app(words, standalone_mode=False), "blockstat") == 0
    assert "Stable" in capsys.readouterr().out
    monkeypatch.setenv(ALLOWED, "many")
    with pytest.raises(InputError, match='BLOCKSTAT_MOST_BLOCKS is "many"'):
        most_blocks()


def test_what_is_asked_for_is_about_what_is_built(root):
    for path in (root / "examples").glob("*.toml"):
        scene = load_scene(path)
        if not isinstance(scene, Composition) or path.stem in ("basilica", "canopy"):
            continue
        plan = resolve(scene)
        asked = sum(
            blocks_asked(kind_of(own), {key: getattr(own, key) for key in own.__struct_fields__})
            for own in plan.elements.values()
        )
        assert asked < min(3 * build(scene).n_blocks, MOST_BLOCKS)


CHAIN = "".join(f'p{i}="= p{i + 1}"\n' for i in range(5000))
CHAIN = f"[parameters]\n{CHAIN}p5000=1\n" + PIECE.format("'= p0'")
BAD = {
    "empty.json": b"",
    "empty.toml": b"",
    "empty.obj": b"",
    "empty.glb": b"",
    "empty.stl": b"",
    "empty.ply": b"",
    "zeros.json": bytes(2_000_000),
    "zeros.toml": bytes(2_000_000),
    "zeros.obj": bytes(2_000_000),
    "zeros.glb": bytes(2_000_000),
    "zeros.stl": bytes(2_000_000),
    "zeros.ply": bytes(2_000_000),
    "deep.json": b'{"a":' * 100_000,
    "lists.json": b"[" * 200_000,
    "deep.toml": b"a = " + b"[" * 100_000,
    "dots.toml": b"[" + b".".join([b"a"] * 3000) + b"]\n",
    "notes.json": native()[:-1] + b',"m":' + b"[" * 900 + b"]" * 900 + b"}",
    "chain.toml": CHAIN.encode(),
    "tower.toml": PIECE.format("'= 9**9**9**9'").encode(),
    "brackets.toml": PIECE.format("'= " + "(" * 400 + "'").encode(),
    "surrogate.json": native(name="\ud800"),
    "block.json": native(blocks=[CUBE | {"name": "a\udfff"}]),
    "group.json": native(blocks=[CUBE | {"group": "\ud800"}]),
    "escape.json": native(blocks=[CUBE | {"name": "\x1b[2J"}]),
    "integer.json": native().replace(b"[0]", b"[" + b"1" * 6000 + b"]", 1),
    "integers.json": b"1" * 100_000,
    "integer.toml": PIECE.format("9" * 5000).encode(),
    "corner.json": native().replace(b"[0, 3,", b"[" + b"9" * 30 + b", 3,"),
    "density.json": native(density=10**400),
    "infinite.json": native().replace(b"[1, 1, 1]", b"[1e999, 1, 1]"),
    "utf16.toml": PIECE.format(1).encode("utf-16"),
    "bytes.json": b"\xff" * 1000,
}


@pytest.mark.parametrize("name", BAD)
def test_a_hostile_file_gets_one_sentence(name, tmp_path, capsys):
    path = tmp_path / name
    path.write_bytes(BAD[name])
    status, message = run(path, capsys)
    assert status == 2
    assert message.count("\n") == 1
    assert len(message) < 400 + len(str(path))
    assert "internal" not in message


@pytest.mark.parametrize(
    "name", ["pipe.json", "pipe.toml", "pipe.obj", "pipe.stl", "zero.json", "zero.obj", "loop.json"]
)
def test_what_is_no_file_is_not_waited_for(name, tmp_path, capsys):
    path = tmp_path / name
    if name.startswith("pipe"):
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero" if name.startswith("zero") else path)
    status, message = run(path, capsys)
    assert status == 2
    assert message.count("\n") == 1
    assert ("no such file" if name.startswith("loop") else "is no file but a pipe or a device") in message


def test_a_byte_order_mark_is_no_fault(tmp_path):
    for name, content in (("a.json", native()), ("a.toml", PIECE.format(1).encode())):
        path = tmp_path / name
        path.write_bytes(b"\xef\xbb\xbf" + content)
        assert read(path).n_blocks == (1 if name == "a.json" else 2)


def test_names_are_checked_in_python_too():
    block = box((0, 0, 0), (1, 1, 1), name="\ud800")
    with pytest.raises(InputError, match=r"the name of block 0, '\\ud800', holds a character"):
        Assembly.from_blocks([block], supports=[0])


def test_a_corner_of_a_mesh_that_does_not_exist(tmp_path, capsys):
    path = tmp_path / "a.ply"
    corners = "0 0 0\n1 0 0\n0 1 0\n"
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face 1\nproperty list uchar int vertex_indices\nend_header\n{corners}3 0 1 7\n"
    )
    status, message = run(path, capsys)
    assert status == 2
    assert "a face has a corner that does not exist" in message


def test_a_buttress_is_counted_by_the_bricks_of_its_face():
    keys = {"width": 2.0, "height": 3.0, "brick": (0.5, 0.25)}
    assert blocks_asked("buttress", keys) == (2.0 / 0.5) * (3.0 / 0.25)
    assert blocks_asked("buttress", keys | {"courses": 60}) == 60  # a whole number that is greater
