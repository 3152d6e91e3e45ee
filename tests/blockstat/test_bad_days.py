"""Full disks, two searches in one place, parents that die and Ctrl-C at any moment."""

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest

import blockstat
from blockstat import InputError, read, write
from blockstat.system import lock
from blockstat.system.lock import locked
from blockstat.system.writing import written_whole
from browser import CHAPEL
from evidence.scenes.small import stack

resource = pytest.importorskip("resource")

SUFFIXES = (".json", ".obj", ".glb", ".stl", ".ply")


@contextmanager
def full_disk():
    """Files of this process may not grow beyond 500 bytes; Python gets an OSError as of a full disk.

    No fixture, which would last while pytest writes its own report, perhaps to a file.
    """
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (500, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_keeps_the_old_file(suffix, tmp_path):
    path = write(stack(2), tmp_path / f"stack{suffix}")
    old = path.read_bytes()
    with full_disk(), pytest.raises(InputError) as refused:
        write(stack(30), path)
    assert str(refused.value).startswith(f"{path}: cannot be written (")
    assert str(refused.value).endswith("; the file that was there is kept")
    assert path.read_bytes() == old
    assert [place.name for place in tmp_path.iterdir()] == [path.name]


def test_a_new_file_on_a_full_disk_leaves_nothing(tmp_path):
    with full_disk(), pytest.raises(InputError, match=r"new\.json: cannot be written \(File too large\)$"):
        write(stack(30), tmp_path / "new.json")
    assert not list(tmp_path.iterdir())


def test_a_file_is_the_old_one_until_the_new_one_is_whole(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    path.chmod(0o600)
    (tmp_path / "link.txt").symlink_to(path)
    with written_whole(tmp_path / "link.txt") as place:
        place.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert (tmp_path / "link.txt").is_symlink()
    assert path.stat().st_mode & 0o777 == 0o600
    with pytest.raises(KeyboardInterrupt):
        write_half(path)
    assert path.read_text() == "new"
    assert len(list(tmp_path.iterdir())) == 2
    with written_whole(os.devnull) as place:
        place.write_text("a device is written to")
    assert not os.path.isfile(os.devnull)


def write_half(path):
    with written_whole(path) as place:
        place.write_text("half")
        raise KeyboardInterrupt


def test_a_directory_has_one_writer(tmp_path):
    code = "from blockstat.system.lock import locked\n"
    code += f"with locked({str(tmp_path)!r}): print('has it', flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", code], stdin=-1, stdout=-1, text=True) as other:
        assert other.stdout.readline() == "has it\n"
        with pytest.raises(InputError, match=f"process {other.pid} writes there"), locked(tmp_path):
            pass
        other.kill()
    assert list(tmp_path.iterdir())  # it was killed
    with locked(tmp_path):  # the system freed it
        pass
    assert not list(tmp_path.iterdir())


def test_a_lock_on_a_file_that_was_removed_meanwhile_keeps_nobody_out_and_is_taken_again(tmp_path, monkeypatch):
    """The second opens the file of the first, which ends and removes it, before it locks what it has opened."""
    take, first = lock._take, locked(tmp_path)
    first.__enter__()

    def take_late(handle):
        monkeypatch.setattr(lock, "_take", take)
        first.__exit__(None, None, None)
        take(handle)

    monkeypatch.setattr(lock, "_take", take_late)
    with locked(tmp_path):
        with pytest.raises(InputError, match=f"process {os.getpid()} writes there"), locked(tmp_path):
            pass
        assert len(list(tmp_path.iterdir())) == 1  # who is refused removes nothing
    assert not list(tmp_path.iterdir())


def test_a_second_search_in_one_place_says_so(tmp_path):
    pytest.importorskip("pybullet")
    from blockstat.cli.options import _status
    from dynsim.cli.commands import app

    scene, out = tmp_path / "hut.toml", tmp_path / "out"
    scene.write_text(CHAPEL)
    out.mkdir()
    with locked(out), pytest.raises(InputError, match="writes there"):
        app(["optimise", str(scene), "-o", str(out)], standalone_mode=False)
    assert _status(lambda: None, "dynsim") == 0
    assert not (out / "history.csv").exists()


def gone(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().split()[2] == "Z"
    except FileNotFoundError:
        return True


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs /proc")
def test_workers_end_with_their_parent(tmp_path):
    task = (
        "import subprocess, sys; print(subprocess.Popen([sys.executable, '-c', sys.argv[1]]).pid, flush=True); input()"
    )
    busy = "from blockstat.system.process import end_with_parent; end_with_parent()\nwhile True: pass"
    parent = subprocess.Popen([sys.executable, "-c", task, busy], stdin=-1, stdout=-1, text=True)
    child = int(parent.stdout.readline())
    time.sleep(1.5)
    assert not gone(child)
    parent.kill()
    parent.wait()
    end = time.monotonic() + 20
    while not gone(child) and time.monotonic() < end:
        time.sleep(0.05)
    assert gone(child)


@pytest.mark.parametrize("module", ["blockstat", "dynsim"])
def test_nothing_is_imported_before_an_interrupt_is_heeded(module):
    """An interrupt leaves a stack trace while a command imports what comes before its first line: next to nothing."""
    place = os.path.dirname(os.path.dirname(os.path.abspath(blockstat.__file__)))
    code = f"import os, sys; before = set(sys.modules); import {module}.__main__\n"
    # Modules of version 0.1 are names without a file.
    code += "print(*sorted(name for name in set(sys.modules) - before if sys.modules[name].__spec__))"
    command, only = [sys.executable, "-S", "-c", code], {"PYTHONPATH": place}
    found = subprocess.run(command, env=only, capture_output=True, text=True, check=True)
    others = {name for name in found.stdout.split() if name.split(".")[0] not in ("blockstat", "dynsim")}
    assert others <= {"__future__"}
    assert len(found.stdout.split()) <= 8


def test_an_interrupt_in_a_finalizer_is_heeded_without_a_trace():
    """Imports have finalizers, in which Python prints what is raised and drops it."""
    code = """
import signal, time, weakref
from blockstat.system.process import Interruptions
interruptions = Interruptions()
interruptions.heed()
class Thing: pass
thing = Thing()
kept = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))
try:
    del thing
    print("goes on")
    for _ in range(1000):
        time.sleep(0.01)
    print("never interrupted")
except KeyboardInterrupt:
    print("interrupted", interruptions.came)
kept = weakref.finalize(Thing(), lambda: 1 / 0)
"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert found.stdout == "goes on\ninterrupted True\n"
    assert "KeyboardInterrupt" not in found.stderr
    assert "ZeroDivisionError" in found.stderr  # other errors there are printed as ever


@pytest.mark.parametrize("module", ["blockstat", "dynsim"])
def test_an_interrupt_at_any_moment_is_one_line(module, tmp_path):
    if module == "dynsim":
        pytest.importorskip("pybullet")
    path = write(stack(2), tmp_path / "a.json")
    assert read(path).n_blocks == 3
    # The clock begins when Python runs code of ours: what comes before is Python's own.
    code = "from blockstat.system.process import end_when_interrupted as e; e('x')\n"
    code += f"import {module}.__main__ as m; print('began', flush=True); m.main()"
    words = ["limit", str(path), "--load", "1,0,0"] if module == "blockstat" else ["verify", str(path)]
    waits = random.Random(7)
    for _ in range(6):
        process = subprocess.Popen([sys.executable, "-c", code, *words], stdout=-1, stderr=-1, text=True)
        assert process.stdout.readline() == "began\n"
        time.sleep(waits.uniform(0.0, 1.0))
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        assert process.returncode in (0, 130)  # it may have been done
        assert "Traceback" not in errors
        if process.returncode:
            assert errors.endswith("interrupted\n")
