"""What the pages show is what the scripts wrote, and `make evidence` knows every script."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "docs"))
sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

import make_evidence
import make_pages
import results
from make_evidence import JOBS, Job, chosen, listed, made, run_all

ROOT = Path(__file__).parents[1]
RESULTS = sorted(make_pages.RESULTS.glob("*.md"))
NAMES = [job.name for job in JOBS]


@pytest.mark.parametrize("path", make_pages.pages(), ids=lambda path: path.name)
def test_the_blocks_of_a_page_are_the_results(path):
    assert make_pages.filled(path.read_text()) == path.read_text(), "run make pages"


def test_every_part_is_on_a_page():
    shown = {block for path in make_pages.pages() for block in make_pages.BLOCK.findall(path.read_text())}
    assert shown == {(path.stem, part) for path in RESULTS for part in results.load(path)[1]}


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_a_result_names_the_command_of_its_job(path):
    command, parts = results.load(path)
    assert all(parts.values())
    if path.stem != "evidence":
        (job,) = [job for job in JOBS if path in job.files()]
        assert command == f"python {job.command}"


def test_the_table_of_jobs_is_the_one_that_runs():
    (shown,) = results.load(make_pages.RESULTS / "evidence.md")[1].values()

    def jobs(table: str) -> list[list[str]]:
        return [row.split("|")[1:4] for row in table.splitlines()]

    assert jobs(shown) == jobs(listed(JOBS)), "run docs/make_evidence.py --list"


@pytest.mark.parametrize("job", JOBS, ids=NAMES)
def test_the_script_of_a_job_and_what_it_writes_are_there(job):
    script = ROOT / job.command.split()[0]
    if script.name == "compare_scenes.py" and not script.is_file():
        pytest.skip("the comparison of static and dynamic verdicts is not there yet")
    assert script.is_file()
    assert all(list(ROOT.glob(pattern)) for pattern in job.writes)


def test_every_picture_is_made_by_a_job():
    pictures = {path for path in (ROOT / "docs").rglob("*.png") if path.relative_to(ROOT).parts[1][0] != "_"}
    assert pictures <= {path for job in JOBS for path in job.files()}


def test_a_page_that_a_script_wrote_is_the_page_of_a_job():
    written = {
        path for path in (ROOT / "docs").glob("*.md") if re.search(r"^(Written|Made) by `", path.read_text(), re.M)
    }
    assert written <= {path for job in JOBS for path in job.files()}


def test_the_makefile_has_a_target_for_every_job():
    makefile = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    (targets,) = re.findall(r"^JOBS := (.*)$", makefile, re.M)
    assert sorted([*targets.split(), "validation", "dynamics-validation"]) == sorted(NAMES)


def test_results_are_read_as_they_were_saved(tmp_path):
    script = ROOT / "benchmarks" / "sweep.py"
    code = f"import sys; sys.argv = [{str(script)!r}, '--designs', '3']; sys.path.insert(0, {str(script.parent)!r}); "
    code += "import results; from pathlib import Path; parts = {'a': '| x |\\n|---|', 'b': 'One\\n\\n### two'}; "
    code += f"results.save(Path({str(tmp_path / 'new' / 'file.md')!r}), parts)"
    subprocess.run([sys.executable, "-c", code], check=True)
    command, parts = results.load(tmp_path / "new" / "file.md")
    assert command == "python benchmarks/sweep.py --designs 3"
    assert parts == {"a": "| x |\n|---|", "b": "One\n\n### two"}


def test_an_unknown_part_is_told():
    with pytest.raises(ValueError, match=r'no part "kritical".*critical'):
        make_pages.filled("<!-- results: glue kritical -->\n<!-- end -->")


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """Jobs run and write in a directory of their own."""
    monkeypatch.setattr(make_evidence, "ROOT", tmp_path)
    monkeypatch.setattr(make_evidence, "OUT", tmp_path / "out")
    return tmp_path


def writer(name: str, code: str = "open('{}.md', 'w')") -> Job:
    return Job(name, f'-c "{code.format(name)}"', (f"{name}.md",), 1)


def test_a_job_that_fails_stops_no_other_and_is_missing_afterwards(elsewhere, capsys):
    jobs = [writer("one"), writer("two", "raise SystemExit('no Chromium here')"), writer("three")]
    assert run_all(jobs) == ["two"]
    assert (elsewhere / "one.md").is_file()
    assert (elsewhere / "three.md").is_file()
    assert "no Chromium here" in capsys.readouterr().out
    assert chosen(jobs, [], missing=True) == [jobs[1]]


def test_a_job_that_leaves_its_file_as_it_was_has_failed(elsewhere, capsys):
    (elsewhere / "idle.md").write_text("old")
    os.utime(elsewhere / "idle.md", (0, 0))
    assert sorted(run_all([writer("idle", "pass"), writer("nothing", "pass")])) == ["idle", "nothing"]
    told = capsys.readouterr().out
    assert "did not write idle.md" in told
    assert "did not write nothing.md" in told


def test_the_time_of_a_job_counts_the_processes_it_waits_for(elsewhere):
    busy = "sum(range(20_000_000))"
    code = f"import subprocess, sys; subprocess.run([sys.executable, '-c', '{busy}']); open('{{}}.md', 'w')"
    job = writer("busy", code)
    assert run_all([job]) == []
    assert made(job)["process"] * 60 > 0.1
