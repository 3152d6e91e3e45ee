"""The live page as an enemy would try it: other origins, other names, uploads that reach out, work without end."""

import http.client
import json
import struct
import time
from pathlib import Path

import numpy as np
import pytest

from blockstat import InputError, load_scene, read, write
from blockstat.app.background import Crashed, Limits, Worker
from blockstat.app.design import Model, open_model
from blockstat.app.files import read_upload
from blockstat.view.three_d.guard import HEADERS, Guard
from browser import CHAPEL
from evidence.scenes.small import stack
from page_tasks import count_for_ever, fill_memory

SECRET = "hunter2:x:0:0"
MESH = '[elements.vault]\nkind = "mesh_vault"\nfile = {}\nthickness = 0.1\n'


@pytest.mark.parametrize(
    ("path", "host", "origin", "handshake", "admitted"),
    [
        ("/token/", "127.0.0.1:8321", None, False, True),
        ("/token", "localhost:8321", "http://localhost:8321", True, True),
        ("/token", "127.0.0.1:8321", "http://localhost:8321", True, True),
        ("/token/?websocket=ws://127.0.0.1", "127.0.0.1:8321", None, False, True),
        ("/token", "127.0.0.1:8321", None, True, False),  # a browser always names the origin of a handshake
        ("/token", "127.0.0.1:8321", "null", True, False),
        ("/token", "127.0.0.1:8321", "https://example.org", True, False),
        ("/token", "127.0.0.1:8321", "http://127.0.0.1:8322", True, False),
        ("/token", "127.0.0.1:8321", "http://localhost:8321.example.org", True, False),
        ("/token/", "example.org:8321", None, False, False),  # rebound to 127.0.0.1
        ("/token/", "127.0.0.1", None, False, False),
        ("/token/", None, None, False, False),
        ("/", "127.0.0.1:8321", None, False, False),
        ("/toke/", "127.0.0.1:8321", None, False, False),
        ("//token/", "127.0.0.1:8321", None, False, False),
        ("/töken/", "127.0.0.1:8321", None, False, False),
    ],
)
def test_requests_are_admitted_from_this_machine_with_the_token(path, host, origin, handshake, admitted):
    assert Guard("token").admits(path, 8321, host, origin, handshake=handshake) is admitted


def test_tokens_differ_and_are_long():
    tokens = {Guard().token for _ in range(100)}
    assert len(tokens) == 100
    assert min(map(len, tokens)) >= 32  # 24 bytes


@pytest.fixture
def address():
    pytest.importorskip("viser")
    from blockstat.view.three_d.page import start_viser, stop_viser

    server, found = start_viser(port=0)
    yield found
    stop_viser(server)


def asked(address, **headers):
    """The answer to a request as a browser would send it from elsewhere."""
    host, _, path = address.removeprefix("http://").partition("/")
    connection = http.client.HTTPConnection(host, timeout=30)
    connection.request("GET", f"/{path}", headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer, body


def test_a_server_answers_only_at_its_whole_address(address):
    answer, body = asked(address)
    assert answer.status == 200
    assert b"<html" in body
    assert {name: answer.headers[name] for name in HEADERS} == HEADERS
    root = address[: address.index("/", len("http://")) + 1]
    for other, headers in [
        (root, {}),
        (root + "wrong/", {}),
        (address, {"Host": "example.org"}),
        (address, {"Origin": "https://example.org"}),
    ]:
        answer, body = asked(other, **headers)
        assert answer.status == 403
        assert b"<html" not in body
        assert b"whole address" in body


def test_a_page_of_another_origin_cannot_open_a_socket(address):
    import viser
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect

    socket = address.replace("http://", "ws://").rstrip("/")
    here = address[: address.index("/", len("http://"))]
    options = {"subprotocols": [f"viser-v{viser.__version__}"], "compression": None}
    with connect(socket, origin=here, **options) as opened:
        assert opened.recv(timeout=30)
    for other, origin in [(socket, "https://example.org"), (socket, None), (here.replace("http", "ws"), here)]:
        with pytest.raises(InvalidStatus) as refused, connect(other, origin=origin, **options):
            pass
        assert refused.value.response.status_code == 403


OUTSIDE = ("{secret}", "../secret.obj", "a/../../secret.obj", "link.obj", "C:/secret.obj", "\\\\host\\secret.obj",
           "..\\secret.obj")  # fmt: skip


@pytest.mark.parametrize("name", OUTSIDE)
def test_an_uploaded_scene_names_no_file_outside_the_folder(tmp_path, name):
    folder, secret = tmp_path / "inside", tmp_path / "secret.obj"
    folder.mkdir()
    secret.write_text(SECRET)
    (folder / "link.obj").symlink_to(secret)
    text = "name = 'x'\n" + MESH.format(json.dumps(name.format(secret=secret)))
    with pytest.raises(InputError, match=r"elements\.vault\.file: .* relative path inside the folder") as refused:
        read_upload("x.toml", text.encode(), "", folder=folder)
    assert SECRET not in str(refused.value)


def test_an_uploaded_scene_reads_files_inside_the_folder(root, tmp_path):
    text = (root / "examples" / "canopy.toml").read_text()
    model = read_upload("canopy.toml", text.encode(), "", folder=root / "examples")
    assert model.built(model.start).n_blocks == read(root / "examples" / "canopy.toml").n_blocks
    alone = read_upload("canopy.toml", text.encode(), "")
    with pytest.raises(InputError, match="no such file"):
        alone.built(alone.start)
    with pytest.raises(InputError, match=r"option \"place\"; options are: folder"):
        load_scene(root / "examples" / "canopy.toml", place=tmp_path)


def glb(tree, binary=b""):
    """A GLB of a JSON chunk, and of a binary chunk where there is one."""
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks + binary


def triangles(uri, length):
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": uri, "byteLength": length}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": length}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": length // 12, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0, "name": "stone"}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }


@pytest.mark.parametrize("uri", ["{secret}", "../secret.bin", "./secret.bin", "sub/secret.bin", "link.bin"])
def test_buffers_of_a_glb_are_beside_it(tmp_path, uri):
    folder, secret = tmp_path / "inside", tmp_path / "secret.bin"
    (folder / "sub").mkdir(parents=True)
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")[[0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]]
    for place in (secret, folder / "sub" / "secret.bin", folder / "beside.bin"):
        place.write_bytes(points.tobytes())
    (folder / "link.bin").symlink_to(secret)
    path = folder / "stone.glb"
    path.write_bytes(glb(triangles("beside.bin", points.nbytes)))
    assert read(path, supports=[0]).volume == pytest.approx([1 / 6])
    path.write_bytes(glb(triangles(uri.format(secret=secret), points.nbytes)))
    with pytest.raises(InputError, match="it names a file that is not beside it"):
        read(path, supports=[0])


@pytest.mark.parametrize("name", ["x.obj", "x.json", "x.toml", "x.glb", "x.stl", "x.ply"])
def test_errors_do_not_quote_files(tmp_path, name):
    heads = {".obj": "v ", ".stl": "solid\nfacet normal ", ".ply": "ply\nformat ascii 1.0\nelement vertex 1\n"}
    path = tmp_path / name
    path.write_text(heads.get(path.suffix, "") + SECRET + "\n")
    with pytest.raises(InputError) as refused:
        read(path, **({} if name == "x.toml" else {"supports": [0]}))
    assert "hunter2" not in str(refused.value)


def ended(work, limits, timed):
    """What is left of a worker beyond its limits."""
    said, begin = [], time.monotonic()
    worker = Worker(work, report=lambda _, message: said.append(message), limits=limits, timed=timed)
    while not any(isinstance(message, Crashed) for message in said) and time.monotonic() - begin < 60:
        time.sleep(0.01)
    assert not worker.running
    return said[-1].message


def test_work_without_end_is_stopped():
    message = ended(count_for_ever, Limits(seconds=0.5), True)
    assert message.startswith("stopped after 0.5 s")
    assert "--most-seconds" in message


def test_work_that_grows_is_stopped():
    pytest.importorskip("resource")
    message = ended(fill_memory, Limits(gigabytes=1.0), False)
    assert message.startswith("stopped at 1 GB of memory")


def test_a_design_that_takes_too_long_fails_and_the_next_is_judged(tmp_path):
    from blockstat.app.design import Failed, Judged
    from blockstat.app.follow import Follower

    path = tmp_path / "hut.toml"
    path.write_text(CHAPEL)
    model, calls, told = open_model(path), [], []
    follower = Follower(calls.append, told.append, limits=Limits(seconds=0.0))

    def until(kind):
        begin = time.monotonic()
        while not any(isinstance(message, kind) for message in told) and time.monotonic() - begin < 60:
            follower.tick()
            if calls:
                calls.pop(0)()
            time.sleep(0.005)
        assert isinstance(told[-1], kind)

    follower.ask(model, model.start)
    until(Failed)
    assert "stopped after 0 s" in told[-1].message
    follower._limits = Limits()
    follower.ask(model, model.start)
    until(Judged)
    follower.stop()


def test_an_answer_that_comes_after_its_design_was_given_up_is_dropped(tmp_path):
    from blockstat.app.design import Failed
    from blockstat.app.follow import Follower

    path = tmp_path / "hut.toml"
    path.write_text(CHAPEL)
    model, calls, told = open_model(path), [], []
    follower = Follower(calls.append, told.append, limits=Limits(seconds=0.0))
    follower.ask(model, model.start)
    begin = time.monotonic()
    while len(calls) < 2 and time.monotonic() - begin < 60:  # that it has begun, and its answer
        time.sleep(0.005)
    calls.pop(0)()
    time.sleep(0.001)  # beyond its limit
    follower.tick()
    calls.pop(0)()
    follower.stop()
    assert [type(message) for message in told] == [Failed]


def test_an_upload_is_read_in_a_process_of_its_own(tmp_path):
    from blockstat.app.files import send_upload

    content = write(stack(2), tmp_path / "stones.json").read_bytes()

    def sent(*given):
        said = []
        Worker(send_upload, *given, "m", "z", None, None, report=lambda _, message: said.append(message))
        begin = time.monotonic()
        while not said and time.monotonic() - begin < 60:
            time.sleep(0.01)
        return said[0]

    model = sent("stones.json", content, "")
    assert isinstance(model, Model)
    assert model.assembly.n_blocks == 3
    assert str(sent("stones.json", b"{}", "")).startswith("stones.json: blocks is missing; keys here are: blocks, name")
    assert Path("stones.json").exists() is False
