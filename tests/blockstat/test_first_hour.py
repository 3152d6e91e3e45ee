"""What meets a newcomer: examples, failures that say so, and what is not installed."""

import subprocess
import sys

from blockstat import grid, load_scene, scene_from, sweep
from blockstat.cli.commands import app
from blockstat.cli.examples import examples
from blockstat.cli.options import _status


def run(*words):
    return _status(lambda: app(list(map(str, words)), standalone_mode=False), "blockstat")


def test_examples_are_listed_and_written(tmp_path, capsys, monkeypatch, root):
    monkeypatch.chdir(tmp_path)
    assert run("example", "--list") == 0
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed] == sorted(path.stem for path in (root / "examples").glob("*.toml"))
    assert all(len(line.split()) > 4 for line in listed)
    assert run("example", "chapel", "-o", tmp_path / "mine.toml") == 0
    assert load_scene(tmp_path / "mine.toml").span == load_scene(root / "examples" / "chapel.toml").span
    assert run("example", "canopy") == 0
    assert (tmp_path / "canopy.obj").is_file()  # which the scene names
    assert run("example", "canopy") == 2
    assert "canopy.toml: exists; give another place by -o" in capsys.readouterr().err
    (tmp_path / "canopy.toml").unlink()
    assert run("example", "canopy") == 2
    assert not (tmp_path / "canopy.toml").exists()  # nothing is written where not all can be
    assert run("example", "cathedral") == 2
    assert 'no example "cathedral"; examples are: aqueduct, arcade' in capsys.readouterr().err


def test_every_example_has_one_name():
    assert len(examples()) == len({path.name for path in examples().values()})


def test_a_sweep_in_which_every_design_fails_says_so(tmp_path):
    # A door that is higher than the wall.
    hut = {"name": "hut", "length": 3.0, "span": 2.0, "doors": {"south": {"width": 0.5, "height": 9.0}}}
    hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.6, "step": 0.1}}
    scene = scene_from(hut)
    found = sweep(scene, grid(scene), tmp_path / "a.jsonl", jobs=1)
    assert found.outcome.word == "failed"
    assert found.failed == found.designs == 5
    assert "5 of 5 designs could not be judged: doors.south" in found.explain()
    again = sweep(scene, grid(scene), tmp_path / "a.jsonl", jobs=1)
    assert (again.outcome.word, again.computed) == ("failed", 0)
    assert again.summary()["failed"] == 5
    del hut["doors"]
    scene = scene_from(hut)
    good = sweep(scene, grid(scene), tmp_path / "b.jsonl", jobs=1)
    assert (good.outcome.word, good.failed, good.reasons) == ("complete", 0, "")


def test_bullet_that_is_not_installed_is_one_sentence(tmp_path):
    code = (
        "import sys\n"
        "class Absent:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'pybullet': raise ModuleNotFoundError(name)\n"
        "sys.meta_path.insert(0, Absent())\n"
        "from dynsim.cli.commands import main; main()"
    )
    path = tmp_path / "a.toml"
    path.write_text("[elements.a]\nkind = 'box'\nsize = [1, 1, 1]\n")
    found = subprocess.run([sys.executable, "-c", code, "verify", path], capture_output=True, text=True)
    assert found.returncode == 2
    assert found.stderr.count("\n") == 1
    assert "conda install -c conda-forge pybullet" in found.stderr
