"""What the pages show is what the scripts wrote, and the list of jobs knows every script."""

import ast
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from evidence import paths, results
from evidence.bisection import bisect
from evidence.jobs import JOBS, Job
from evidence.pages import fill, gallery
from evidence.run import runner, sources, stamps
from evidence.run.runner import chosen, listed, run_all
from evidence.same_pages import differences
from evidence.scenes.small import assembly, box
from evidence.tables import table

ROOT = paths.ROOT
RESULTS = sorted(paths.RESULTS.glob("*.md"))
NAMES = [job.name for job in JOBS]


@pytest.mark.parametrize("path", fill.pages(), ids=lambda path: path.name)
def test_the_blocks_of_a_page_are_the_results(path):
    assert fill.page(path) == path.read_text(), "run make pages"


def test_every_part_is_on_a_page():
    shown = {block for path in fill.pages() for block in fill.BLOCK.findall(path.read_text())}
    assert shown == {(path.stem, part) for path in RESULTS for part in results.load(path)[1]}


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_a_result_names_the_command_of_its_job(path):
    command, parts = results.load(path)
    assert all(parts.values())
    if path.stem != "evidence":
        (job,) = [job for job in JOBS if path in job.files()]
        assert command == f"python {job.command}"


def test_the_table_of_jobs_is_the_one_that_runs():
    (shown,) = results.load(paths.RESULTS / "evidence.md")[1].values()
    assert shown == listed(JOBS), "run python -m evidence --list"


@pytest.mark.parametrize("job", JOBS, ids=NAMES)
def test_the_script_of_a_job_and_what_it_writes_are_there(job):
    flag, module, *_ = job.command.split()
    assert flag == "-m"
    assert (ROOT / module.replace(".", "/")).with_suffix(".py").is_file()
    assert all(list(ROOT.glob(pattern)) for pattern in job.writes)


def test_every_picture_is_made_by_a_job():
    pictures = {path for path in (ROOT / "docs").rglob("*.png") if path.relative_to(ROOT).parts[1][0] != "_"}
    assert pictures <= {path for job in JOBS for path in job.files()}


def test_a_page_that_a_script_wrote_is_the_page_of_a_job():
    written = {
        path for path in (ROOT / "docs").glob("*.md") if re.search(r"^(Written|Made) by `", path.read_text(), re.M)
    }
    assert written <= {path for job in JOBS for path in job.files()}


def test_the_makefile_names_jobs_that_are_there():
    (named,) = re.findall(r"^validation: ONLY := (.*)$", (ROOT / "Makefile").read_text(), re.M)
    assert set(named.split()) <= set(NAMES)


def test_results_are_read_as_they_were_saved(tmp_path):
    script = ROOT / "evidence" / "benchmarks" / "sweep.py"
    code = f"import sys; sys.argv = [{str(script)!r}, '--designs', '3']; "
    code += "from evidence import results; from pathlib import Path; "
    code += "parts = {'a': '| x |\\n|---|', 'b': 'One\\n\\n### two'}; "
    code += f"results.save(Path({str(tmp_path / 'new' / 'file.md')!r}), parts)"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
    command, parts = results.load(tmp_path / "new" / "file.md")
    assert command == "python -m evidence.benchmarks.sweep --designs 3"
    assert parts == {"a": "| x |\n|---|", "b": "One\n\n### two"}


def test_an_unknown_part_is_told():
    with pytest.raises(ValueError, match=r'no part "kritical".*critical'):
        fill.filled("<!-- results: glue kritical -->\n<!-- end -->")


def test_a_result_that_is_missing_is_told_with_its_job():
    with pytest.raises(ValueError, match=r"no docs/results/no_such\.md: run make evidence ONLY=no-such"):
        fill.filled("<!-- results: no_such part -->\n<!-- end -->")


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """Jobs run and write in a directory of their own; they depend on nothing."""
    monkeypatch.setattr(paths, "DOCS", tmp_path / "docs")
    monkeypatch.setattr(paths, "RESULTS", tmp_path / "docs" / "results")
    monkeypatch.setattr(runner, "OUT", tmp_path / "out")
    monkeypatch.setattr(stamps, "digest", lambda module: "as it was")
    return tmp_path


def writer(name: str, code: str = "open('{}.md', 'w')", **more) -> Job:
    return Job(name, f'-c "{code.format(name)}"', (f"{name}.md",), 1, **more)


def test_a_job_that_fails_stops_no_other_and_is_missing_afterwards(elsewhere, capsys):
    jobs = [writer("one"), writer("two", "raise SystemExit('no Chromium here')"), writer("three")]
    assert run_all(jobs) == ["two"]
    assert (elsewhere / "one.md").is_file()
    assert (elsewhere / "three.md").is_file()
    assert "no Chromium here" in capsys.readouterr().out
    assert chosen(jobs, [], missing=True) == [jobs[1]]


def test_a_job_that_fails_loses_its_stamp(elsewhere):
    job = writer("one", "import os; open('{}.md', 'w'); raise SystemExit(os.path.exists('spoilt'))")
    assert run_all([job]) == []
    assert stamps.current(job)
    (elsewhere / "spoilt").touch()
    assert run_all([job]) == ["one"]
    assert not stamps.stamps()


def test_a_job_whose_sources_have_changed_is_missing(elsewhere, monkeypatch):
    job = writer("one")
    assert run_all([job]) == []
    assert chosen([job], [], missing=True) == []
    monkeypatch.setattr(stamps, "digest", lambda module: "changed")
    assert chosen([job], [], missing=True) == [job]
    assert stamps.foot([job]).endswith("and the source has changed since.*")


def test_the_foot_names_the_commit_and_its_date(elsewhere):
    run_all([writer("one")])
    commit, date = stamps.head()
    assert stamps.foot([writer("one")]) == f"*The figures of this page are of commit `{commit}` of {date}.*"
    lines = stamps.foot([writer("one"), writer("two")]).splitlines()
    assert [line.partition(":")[0] for line in lines] == ["*Figures of one", "*Figures of two"]
    assert "not noted" in lines[1]


def test_scenes_that_a_quick_run_left_out_have_a_row_without_verdicts():
    cube = assembly([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))])
    cells = gallery.shown("cube", "A cube", "a cube", cube, None, {}).split("|")[2:-1]
    assert [cell.strip() for cell in cells] == ["A cube", "2", *5 * ["-"]]


def test_as_many_walls_are_compared_in_a_quick_run_as_are_predicted():
    fewer = {job.name: job.fewer for job in JOBS}
    assert fewer["experiments-measured"] == fewer["experiments"]


def test_a_quick_run_gives_the_options_for_fewer_scenes(elsewhere):
    code = "import sys; open('{}.md', 'w').write(' '.join(sys.argv[1:]))"
    job = writer("one", code, fewer="--scenes 3")
    assert run_all([job], quick=True) == []
    assert (elsewhere / "one.md").read_text() == "--scenes 3"


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
    assert run_all([writer("busy", code)]) == []
    assert stamps.stamps()["busy"].process * 60 > 0.1


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="hashes are of the syntax trees of Python 3.10 and 3.11")
@pytest.mark.release
@pytest.mark.parametrize("job", JOBS, ids=NAMES)
def test_the_figures_of_a_release_come_from_its_source(job):
    assert stamps.current(job), "run make evidence MISSING=1"
    assert not stamps.stamps()[job.name].commit.endswith("+"), "figures come from sources that are in no commit"


@pytest.mark.release
def test_the_figures_of_a_release_are_of_one_commit():
    assert len({stamps.stamps()[job.name].commit for job in JOBS}) == 1, "run make evidence"


def test_a_job_without_its_data_has_no_figures(elsewhere, capsys):
    job = replace(writer("one", "open('{}.md', 'w')"), needs=(elsewhere / "laboratory",))
    assert run_all([job]) == ["one"]
    assert f"no directory {elsewhere / 'laboratory'}" in capsys.readouterr().out
    assert "one" not in stamps.stamps()
    assert not (elsewhere / "one.md").exists()


def test_a_job_that_measures_the_clock_runs_when_the_others_are_done(elsewhere):
    wait = "import time; open('{}.md', 'w'); time.sleep(%g)"
    clock = replace(writer("clock", wait % 0), alone=True)
    others = [writer(name, wait % 0.5) for name in ("one", "two")]
    assert run_all([clock, *others]) == []
    ends = [(elsewhere / f"{job.name}.md").stat().st_mtime for job in others]
    assert (elsewhere / "clock.md").stat().st_mtime >= max(ends) + 0.5


def write_runs(directory: Path, page: str, **cells: tuple) -> None:
    """Directories of runs by name, each with the page filled in."""
    for name, own in cells.items():
        (directory / name).mkdir()
        (directory / name / "page.md").write_text(page.format(*own))


def test_pages_of_two_runs_are_the_same_but_for_seconds(tmp_path):
    page = "# Page\n\n| scene | verdict | with score [s] |\n|---|---|---|\n| hut | {} | {} |\n\nIt takes {} s.\n"
    write_runs(tmp_path, page, one=("stands", 1.5, 3), two=("stands", "2.25; 1.5", 4), three=("falls", 1.5, 3))
    assert differences(tmp_path / "one", tmp_path / "two") == []
    (only,) = differences(tmp_path / "one", tmp_path / "three")
    assert only.startswith("page.md:5\n- ")
    assert "falls" in only


def test_rows_of_seconds_and_parts_about_speed_differ_in_no_run(tmp_path):
    page = "| | value |\n|---|---|\n| all draws [ms] | {} |\n| iterations | {} |\n\n{}\n\n- order {}%\n\n{}\n"
    begin, end = "<!-- results: solvers profiles -->", "<!-- end -->"
    write_runs(
        tmp_path, page,
        one=(17.6, 12, begin, 20, end), two=(19.1, 12, begin, 18, end), three=(17.6, 13, begin, 20, end),
        four=(17.6, 12, "", 20, end), five=(17.6, 12, "", 18, end),
    )  # fmt: skip
    assert differences(tmp_path / "one", tmp_path / "two") == []
    assert "| 13 " in differences(tmp_path / "one", tmp_path / "three")[0]
    assert "order" in differences(tmp_path / "four", tmp_path / "five")[0]


@pytest.mark.parametrize(
    "line",
    [
        "| scene | limit load | mass ratio | 4 times the weight |\n|---|---|---|---|\n| hut | {} | 3 | 5 |",
        "| scene | limit load | mass ratio | 4 times the weight |\n|---|---|---|---|\n| hut | 3 | {} | 5 |",
        "| scene | limit load | mass ratio | 4 times the weight |\n|---|---|---|---|\n| hut | 3 | 5 | {} |",
        "It takes 3 s. The error is {} times the resolution.",
        "The limit load is {}; it takes 3 s.",
    ],
)
def test_loads_ratios_and_multiples_are_no_times(line, tmp_path):
    write_runs(tmp_path, line, one=(1.25,), two=(1.5,))
    assert len(differences(tmp_path / "one", tmp_path / "two")) == 1


def test_which_methods_were_faster_is_about_time(tmp_path):
    page = "These were {}:\n\n- arches: {}\n\nThe end.\n\n- walls: {}\n"
    write_runs(
        tmp_path, page,
        one=("faster", "a", "c"), two=("faster", "b", "c"), three=("right", "a", "c"), four=("right", "b", "c"),
        five=("faster", "a", "d"),
    )  # fmt: skip
    assert differences(tmp_path / "one", tmp_path / "two") == []
    assert "arches" in differences(tmp_path / "three", tmp_path / "four")[0]
    assert "walls" in differences(tmp_path / "one", tmp_path / "five")[0]


def test_a_job_depends_on_what_it_imports_and_on_nothing_else():
    names = {str(path.relative_to(ROOT)) for path in sources.dependencies("evidence.pages.hard")}
    assert {"evidence/pages/hard.py", "evidence/hard/cases.py", "src/blockstat/analysis/assess.py"} <= names
    assert "src/blockstat/solve/interior_point.py" in names  # through others
    assert not [name for name in names if name.startswith(("src/dynsim", "src/blockstat/view"))]
    assert "evidence/benchmarks/cell.py" in {
        str(path.relative_to(ROOT)) for path in sources.dependencies("evidence.benchmarks.solvers")
    }


def test_comments_and_docstrings_are_no_source(tmp_path):
    first, second, third = (tmp_path / f"{name}.py" for name in "abc")
    first.write_text('"""One."""\n\ndef f(x):\n    """Twice."""\n    return 2 * x\n')
    second.write_text("def f(x):  # double\n\n    return (2 * x)\n")
    third.write_text("def f(x):\n    return 3 * x\n")
    assert sources.statements(first) == sources.statements(second) != sources.statements(third)


ROOMS = sorted({path.parent for path in (ROOT / "evidence").rglob("*.py")})


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: room.name)
def test_a_room_says_what_it_is_for_and_holds_at_most_twelve_modules(room):
    assert ast.get_docstring(ast.parse((room / "__init__.py").read_text()))
    assert len([path for path in room.glob("*.py") if path.name not in ("__init__.py", "__main__.py")]) <= 12


def test_no_script_edits_the_path_of_modules():
    edited = re.compile(r"sys\.path(\.(insert|append)\(|\[.*\] *=| *\+?= )")
    folders = ("evidence", "examples", "docs", "notebooks", "tests")
    files = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in (".py", ".ipynb")]
    assert len(files) > 100
    assert not [path for path in files if edited.search(path.read_text())]


def test_what_is_installed_knows_nothing_of_the_evidence():
    imported = re.compile(r"^\s*(from|import) evidence\b", re.M)
    assert not [path for path in (ROOT / "src").rglob("*.py") if imported.search(path.read_text())]


@pytest.mark.parametrize(("inside", "outside"), [(0.0, 1.0), (1.0, 0.0)])
def test_bisection_closes_in_from_either_side(inside, outside):
    limit = 0.3
    holds, fails = bisect(lambda x: (x < limit) == (inside < limit), inside, outside, 1e-6)
    assert abs(holds - fails) <= 1e-6
    assert (holds < limit) == (inside < limit)
    assert (fails < limit) == (outside < limit)


def test_a_table_has_a_line_a_row_and_no_double_space_in_an_empty_heading():
    assert table(["", "a"], [(1, "x")]) == "| | a |\n|---|---|\n| 1 | x |"
