"""The comparisons of static and dynamic verdicts: their scenes, their memory, their page."""

import json
import sys
from dataclasses import asdict
from functools import partial

import pytest

from blockstat import write
from dynsim.comparison.compare import compare_one
from evidence.comparisons import cases, scenes, verdicts
from evidence.comparisons.kept import Kept
from evidence.scenes.small import arch, stack


def test_more_than_three_hundred_small_scenes_of_every_family():
    found = [*scenes.references(), *scenes.randoms(250)]
    assert len(found) > 300
    assert len({scene.name for scene in found}) == len(found)
    assert {scene.family for scene in found} == {"reference", *scenes.RANDOM}
    assert max(scene.assembly.n_blocks for scene in found) <= scenes.MOST_BLOCKS
    known = [scene.stands for scene in found if scene.stands is not None]
    assert known.count(True) == known.count(False) > 20


def test_what_is_done_is_not_done_again_and_a_line_cut_short_is(tmp_path):
    path = tmp_path / "rows.jsonl"
    designs = [stack(1, name="one"), arch(9, 0.07, name="thin")]
    ask = partial(compare_one, closely=True)
    first = Kept(path).ask(ask, "verdicts", designs, asdict, 1)
    assert [row["dynamic"] for row in first] == ["stands", "falls"]
    # A function that only fails answers nothing: everything comes from the file.
    again = Kept(path).ask(len, "verdicts", designs, asdict, 1)
    assert again == first
    whole = path.read_text().splitlines()
    path.write_text(whole[0] + "\n" + whole[1][:40])
    mended = Kept(path).ask(ask, "verdicts", designs, asdict, 1)
    assert [row["dynamic"] for row in mended] == ["stands", "falls"]
    assert all(json.loads(line)["key"] for line in path.read_text().splitlines())
    other = [stack(1, name="one", friction=0.4)]
    (row,) = Kept(path).ask(len, "verdicts", other, asdict, 1)
    assert "static" not in row
    assert row["note"]


@pytest.mark.slow
def test_a_small_run_writes_a_page_with_its_pictures(tmp_path, monkeypatch, capsys):
    page = tmp_path / "comparison.md"
    monkeypatch.setattr(verdicts, "KEPT", tmp_path / "rows.jsonl")
    monkeypatch.setattr(sys, "argv", ["x", "--scenes", "14", "--limits", "3", "--jobs", "2", "--write", str(page)])
    verdicts.main()
    text = page.read_text()
    pictures = [part.split(")")[0] for part in text.split("](")[1:]]
    assert {"comparison/limits.png", "comparison/cosines.png"} <= set(pictures)
    assert all((tmp_path / name).stat().st_size > 3000 for name in pictures)
    assert "| stable |" in capsys.readouterr().out


def test_a_directory_of_assemblies_is_compared(tmp_path, monkeypatch, capsys):
    folder = tmp_path / "cases"
    folder.mkdir()
    write(stack(2), folder / "stack.json")
    write(arch(9, 0.07), folder / "thin.json")
    (folder / "notes.md").write_text("not an assembly")
    table = tmp_path / "rows.csv"
    monkeypatch.setattr(sys, "argv", ["x", str(folder), "--quick", "--jobs", "1", "--csv", str(table)])
    cases.main()
    said = capsys.readouterr()
    assert "| unstable | 0 | 0 | 1 | 1 |" in said.out
    assert "left out" in said.err
    assert [line.split(",")[0] for line in table.read_text().splitlines()] == ["name", "stack", "thin"]
