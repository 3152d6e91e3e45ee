"""What the commands of `dynsim` refuse, say in words and write."""

import json
import re
import sys
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from matplotlib.figure import Figure

from blockstat import Assembly, InputError, InputWarning, Plan, Step, box, write, write_plan
from blockstat.cli.options import INTERRUPTED
from blockstat.design_search.candidate import Candidate, SearchResult
from blockstat.spec import scene_from
from building_sites import tee
from dynsim import Pulse, Settings, film_strip, incremental, past_verdict, plot_incremental, read_run, verify
from dynsim.cli.commands import app
from dynsim.cli.rows import side_by_side
from dynsim.earthquake.analysis import IncrementalAnalysis
from dynsim.judge.replay import _Site
from dynsim.view.film import write_movie
from pool_tasks import refused, warned

WIDTH, HEIGHT = 0.5, 1.0  #: the pillar tips at a horizontal acceleration of WIDTH / HEIGHT
WEIGHT = 2400 * WIDTH**2 * HEIGHT * 9.81  #: [N]


@pytest.fixture
def run(run_command):
    return partial(run_command, app, "dynsim")


def pillar():
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (WIDTH, WIDTH, HEIGHT), name="pillar")]
    gravity = (0, 0, -9.81)
    return Assembly.from_blocks(blocks, supports=["ground"], density=2400.0, friction=0.9, gravity=gravity)


@pytest.fixture
def file(tmp_path):
    return write(pillar(), tmp_path / "pillar.json")


@pytest.fixture
def loads(tmp_path):
    """A case that pushes the pillar at its centre less than tips it, and one that pushes it over."""
    path = tmp_path / "loads.toml"
    text = "".join(
        f'[loads.{name}]\nkind = "body"\nforce = [{share * WEIGHT}, 0, 0]\n[cases.{name}]\nlive = {{ {name} = 1 }}\n'
        for name, share in (("breeze", 0.4), ("gale", 0.6))
    )
    path.write_text(text + "[cases.calm]\nfactors = { breeze = 1 }\n")
    return path


@pytest.fixture
def record(tmp_path):
    """Half a second of a sine of 1 g."""
    times = np.linspace(0.0, 0.5, 26)
    rows = [f"{time:.3f},{9.81 * np.sin(4 * np.pi * time):.6f}" for time in times]
    path = tmp_path / "quake.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["verify", "{file}", "{file}", "--case", "gale", "--loads", "{loads}"], "--case goes with one file"),
        (["verify", "{file}", "--loads", "{loads}"], "--loads gives load cases; choose one by --case NAME"),
        (["verify", "{file}", "--threshold", "0"], "--threshold is 0.0; it must be a positive number of metres"),
        (["limit", "{file}"], "--load AX,AY,AZ or --case NAME with live loads is needed"),
        (["limit", "{file}", "--case", "calm", "--loads", "{loads}"], 'case "calm" has no live loads'),
        (["shake", "{file}"], "one of --record, --pulse and --ramp is needed; given: none"),
        (["shake", "{file}", "--pulse", "1,0,0,1", "--ramp", "1,0,0,1"], "is needed; given: --pulse, --ramp"),
        (["shake", "{file}", "--pulse", "1,0,0,1", "--scale", "9.81"], "--scale and --direction go with --record"),
        (["shake", "{file}", "--ramp", "1,0,0,1", "--direction", "0,1,0"], "--scale and --direction go with --record"),
        (["shake", "{file}", "--ramp", "1,0,0"], '--ramp is "1,0,0"; it must read AX,AY,AZ,SECONDS'),
        (["sequence", "{plan}"], "plan.json: names no assembly; write `dynsim sequence ASSEMBLY --plan PLAN.json`"),
    ],
)
def test_what_cannot_be_asked_is_one_line_and_status_two(run, tmp_path, file, loads, arguments, words):
    plan = tmp_path / "plan.json"
    write_plan(Plan((Step(("pillar",)),)), plan)
    places = {"file": file, "loads": loads, "plan": plan}
    status, out, err = run(*[argument.format(**places) for argument in arguments])
    assert (status, out) == (2, "")
    assert err.startswith("dynsim: ")
    assert words in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(("case", "verdict"), [("breeze", "Stands"), ("gale", "Falls")])
def test_the_loads_of_a_case_push_in_bullet(run, file, loads, case, verdict):
    status, out, _ = run("verify", file, "--case", case, "--loads", loads, "--threshold", 0.05)
    assert status == 0
    head, acting, answer = out.splitlines()[:3]
    assert re.fullmatch(r"assembly: 2 blocks, \d+\.\d s", head)
    assert acting == f'Loads: case "{case}": 1 weight + 1 {case} (live).'
    assert answer.startswith(verdict)


def test_a_case_without_loads_is_the_weight_alone(run, file, tmp_path):
    cases = tmp_path / "none.toml"
    cases.write_text("[cases.dead]\nweight = 1.0\n")
    alone, dead = (
        json.loads(run("verify", file, "--json", *options)[1])
        for options in ((), ("--case", "dead", "--loads", cases))
    )  # fmt: skip
    assert (dead.pop("case"), dead.pop("combination")) == ("dead", "1 weight")
    assert alone.keys() == dead.keys()
    assert {key for key in alone if alone[key] != dead[key]} <= {"process_seconds"}


def test_a_run_is_named_where_it_was_written_and_only_there(run, file, tmp_path):
    target = tmp_path / "run.npz"
    assert "run: " not in run("verify", file)[1]
    assert run("verify", file, "-o", target)[1].splitlines()[-1] == f"run: {target}"
    assert read_run(target).assembly.names == ("ground", "pillar")


@pytest.mark.parametrize(("acceleration", "verdict"), [(0.4, "Stands"), (0.6, "Falls")])
def test_a_ramp_of_the_ground_tips_a_pillar_past_its_slenderness(run, file, acceleration, verdict):
    status, out, _ = run("shake", file, "--ramp", f"{9.81 * acceleration},0,0,2", "--threshold", 0.05)
    assert status == 0
    assert out.splitlines()[1].startswith(verdict)


def test_a_limit_is_said_in_words(run, file):
    status, out, _ = run("limit", file, "--load", "1,0,0", "--no-check", "--width", 0.1)
    assert status == 0
    assert re.match(r"assembly: 2 blocks, \d+\.\d s\n", out)
    # A block tips at its width over its height, and the runs of Bullet say so to a hundredth.
    lower, upper = map(float, re.search(r"^Multiplier between (\S+) and (\S+)\.$", out, re.MULTILINE).groups())
    assert 0.99 * lower <= WIDTH / HEIGHT <= 1.01 * upper
    assert upper - lower <= 0.1 * upper


def ida(file, record, *options):
    quick = ["--preset", "fast", "--jobs", 1, "--factor", 2, "--resolution", 0.5, "--beyond", 0]
    return ["ida", file, "--record", record, *quick, *options]


def test_an_incremental_analysis_is_said_in_words_with_its_picture(run, file, record, tmp_path):
    picture = tmp_path / "curves.png"
    status, out, _ = run(*ida(file, record, "--up-to", 0.2, "--plot", picture))
    lines = out.splitlines()
    assert status == 0
    assert re.fullmatch(r"assembly: 2 blocks, \d+\.\d s", lines[0])
    # A pillar of this slenderness does not even rock at 0.2 g.
    assert "quake: stands up to 0.2 g (2 runs)." in lines
    assert lines[-1] == f"picture: {picture}"
    assert picture.read_bytes()[:4] == b"\x89PNG"


def hanging():
    """A pillar that hangs over the edge of its ground by more than half."""
    blocks = [box((-1, -1, -1), (0.2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    return Assembly.from_blocks(blocks, supports=["ground"], name="hanging")


def test_what_falls_without_a_record_has_no_curves_and_no_picture(run, record, tmp_path):
    picture = tmp_path / "curves.png"
    status, out, _ = run(*ida(write(hanging(), tmp_path / "hanging.json"), record, "--plot", picture))
    assert status == 0
    assert "picture" not in out
    assert not picture.exists()
    found = incremental(hanging(), {"sine": Pulse((1.0, 0, 0), 0.5, "sine")}, settings=Settings.named("fast"), jobs=1)
    with pytest.raises(InputError, match="hanging: no runs under records to draw"):
        plot_incremental(found, picture)


def test_the_curve_of_a_record_that_fells_nothing_ends_at_its_last_run():
    weak = {"sine": Pulse((1.0, 0, 0), 0.5, "sine")}
    options = {"start": 0.1, "factor": 2.0, "up_to": 0.2, "settings": Settings.named("fast"), "jobs": 1}
    figure = plot_incremental(incremental(pillar(), weak, **options), Figure())
    # From the origin over both runs; a level line to a fall is not drawn.
    assert figure.axes[0].lines[0].get_ydata() == pytest.approx([0.0, 0.1, 0.2])


@pytest.mark.parametrize("kept", [True, False])
def test_an_interrupted_analysis_says_how_to_go_on_where_it_was_kept(run, file, record, tmp_path, monkeypatch, kept):
    ended = IncrementalAnalysis(pillar(), (), "pga", 3.0, 0.6, "", 0.95, False, 0.0)
    monkeypatch.setattr("dynsim.earthquake.analysis.incremental", lambda *_, **__: ended)
    status, out, err = run(*ida(file, record, *(["-o", tmp_path / "kept"] if kept else [])))
    assert status == INTERRUPTED == 130
    assert ("interrupted: the same command goes on from here" in out) is kept
    assert ("interrupted: nothing is kept; with -o DIR each run is, and the same command" in out) is not kept
    assert err.endswith("dynsim: interrupted\n")


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupted_analysis_does_not_advise_what_it_has_not_tried(run, file, record, monkeypatch, as_json):
    def told(_):
        def stop(_):
            raise KeyboardInterrupt

        return stop

    others = [record.with_name(f"other{k}.csv") for k in range(2)]
    for other in others:
        other.write_text(record.read_text())
    monkeypatch.setattr("dynsim.cli.ida._told", told)
    more = [text for other in others for text in ("--record", other)]
    status, out, _ = run(*ida(file, record, *more, *["--json"] * as_json))
    assert status == INTERRUPTED
    if as_json:
        told = json.loads(out)
        assert told["outcome"] == "incomplete"
        assert told["no_fragility"] == "fragility: 3 of 3 records have runs to come"
    else:
        assert "Incomplete: records have runs to come.\n" in out
        assert "No fragility: 3 of 3 records have runs to come.\n" in out
        assert not re.search("kept\\.|raise|add records|are needed", out)


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize(("runs", "bracketed"), [(0, None), (1, False), (3, True)])
def test_an_interrupt_leaves_the_runs_of_a_limit_and_the_bracket(run, file, monkeypatch, runs, bracketed, as_json):
    done = []

    def interrupted(*given, **options):
        if len(done) == runs:
            raise KeyboardInterrupt
        done.append(verify(*given, **options))
        return done[-1]

    monkeypatch.setattr("dynsim.judge.limit.verify_unasked", interrupted)
    status, out, err = run("limit", file, "--load", "1,0,0", "--width", 0.001, *["--json"] * as_json)
    assert status == (0 if bracketed else INTERRUPTED)
    assert err.endswith("dynsim: interrupted\n") is not bracketed
    if bracketed is None:
        assert out == ""
    elif as_json:
        told = json.loads(out)
        assert (told["outcome"], told["runs"]) == ("stopped", runs)
        stood = [trial["multiplier"] for trial in told["trials"] if trial["verdict"] == "stands"]
        moved = [trial["multiplier"] for trial in told["trials"] if trial["verdict"] != "stands"]
        assert (told["lower"], told["upper"]) == (max(stood), min(moved) if bracketed else None)
    else:
        assert "Stopped: the runs until then" in out
        assert ("Multiplier between " in out) is bracketed
        assert ("; it has not moved at any so far." in out) is not bracketed
        assert len(re.findall(r"^[\d.]+: (?:stands|falls|creeps), ", out, re.M)) == runs


SEARCHED = """\
name = "posts"
[parameters]
apart = { value = 0.7, min = 0.3, max = 0.7, step = 0.2 }
[elements.one]
kind = "box"
size = [0.5, 0.5, 1.0]
[elements.other]
kind = "box"
size = ["= apart", 0.5, 1.0]
at = ["= apart", 0, 0]
"""


def test_a_search_says_its_best_design_and_how_many_could_not_be_built(run, tmp_path):
    (tmp_path / "posts.toml").write_text(SEARCHED)
    status, out, _ = run("optimise", tmp_path / "posts.toml", "-o", tmp_path / "out", "--preset", "fast", "--jobs", 1)
    failed, best, report = out.splitlines()
    assert status == 0
    # One ends at 0.25, and the other begins at half of `apart`: at 0.5 they touch, and at 0.3 they overlap by 0.1 m.
    assert re.match(r'1 of [23] designs could not be judged: elements "one" and "other" overlap', failed)
    assert best == "best: parameters.apart = 0.5"
    assert report == f"report: {tmp_path / 'out' / 'report.html'}"
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.parametrize("finished", [True, False])
def test_an_interrupted_search_says_how_to_go_on(run, tmp_path, monkeypatch, finished):
    (tmp_path / "posts.toml").write_text(SEARCHED)
    scene = scene_from({"name": "post", "elements": {"post": {"kind": "box", "size": [1, 1, 1]}}})
    fell = Candidate({"height": 1.0}, "unstable", 1.0, "pruned", 1.0, 2, 0.0, 0.0)
    ended = SearchResult(scene, None, None, (fell,), finished=finished)
    monkeypatch.setattr("dynsim.design_search.optimise.optimise", lambda *_, **__: (ended, tmp_path / "report.html"))
    status, out, _ = run("optimise", tmp_path / "posts.toml", "-o", tmp_path / "out")
    said = [] if finished else ["interrupted: the same command goes on from here"]
    best = "no design of the space stood" if finished else "none so far"
    assert out.splitlines() == [*said, f"best: {best}", f"report: {tmp_path / 'report.html'}"]
    assert status == (0 if finished else INTERRUPTED)


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_while_the_report_is_drawn_leaves_the_best_design(run, tmp_path, monkeypatch, as_json):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    (tmp_path / "posts.toml").write_text(SEARCHED)
    monkeypatch.setattr("dynsim.design_search.optimise.write_designs", interrupt)
    options = ["-o", tmp_path / "out", "--preset", "fast", "--jobs", 1, *["--json"] * as_json]
    status, out, err = run("optimise", tmp_path / "posts.toml", *options)
    assert status == INTERRUPTED
    assert err.endswith("dynsim: interrupted\n")
    if as_json:
        told = json.loads(out)
        assert (told["best"], told["finished"], told["report"]) == ({"parameters.apart": 0.5}, True, None)
    else:
        first, _failed, best, report = out.splitlines()
        assert first == "interrupted while the report was drawn: the same command goes on from here"
        assert (best, report) == ("best: parameters.apart = 0.5", "report: not written")
    monkeypatch.undo()
    again = run("optimise", tmp_path / "posts.toml", *options)
    assert again[0] == 0
    assert (tmp_path / "out" / "report.html").is_file()


def test_a_group_that_the_largest_design_has_not_is_refused_before_anything_is_judged(run, tmp_path):
    (tmp_path / "posts.toml").write_text(SEARCHED)
    status, out, err = run("optimise", tmp_path / "posts.toml", "-o", tmp_path / "out", "--group", "roof", "--jobs", 1)
    assert (status, out) == (2, "")
    assert 'no group "roof"; groups are: ' in err
    assert not (tmp_path / "out" / "history.csv").exists()


@pytest.mark.parametrize("as_json", [False, True])
def test_a_search_in_which_every_simulation_fails_has_no_answer(run, tmp_path, monkeypatch, as_json):
    (tmp_path / "posts.toml").write_text(SEARCHED)
    monkeypatch.setattr("dynsim.design_search.optimise.verify", refused)
    options = ["-o", tmp_path / "out", "--jobs", 1, *(["--json"] if as_json else [])]
    status, out, err = run("optimise", tmp_path / "posts.toml", *options)
    assert status == 2
    # All designs of the line are examined: one overlaps, and the engine has no verdict on the others.
    words = "o design stood of the 3 examined (3 not judged)"
    assert err.endswith(f"dynsim: n{words}\n")
    assert f"N{words}." in (tmp_path / "out" / "report.html").read_text()
    if as_json:
        told = json.loads(out)
        assert (told["outcome"], told["sentence"]) == ("failed", "Failed: no design could be judged.")
        assert (told["unexamined"], told["undecided"]) == (0, 0)
    else:
        assert "the engine is out of order" in out.splitlines()[0]
        assert out.splitlines()[1] == f"best: n{words}"


def test_a_search_whose_largest_design_cannot_be_built_and_in_which_none_stands_has_a_report(run, tmp_path):
    """Two walls 2.5 m high and 0.8 m apart overlap at 1 m; under 0.51 g none up to 0.7 m wide stands."""
    wall = 'kind = "box"\nsize = ["= t", 0.5, 2.5]\n'
    scene = tmp_path / "walls.toml"
    scene.write_text(
        "[parameters]\nt = { value = 1.0, min = 0.1, max = 1.0, step = 0.3 }\n"
        f"[elements.a]\n{wall}[elements.b]\n{wall}at = [0.8, 0, 0]\n"
    )
    gravity = ["--gravity", "5,0,-9.81"]
    status, out, err = run("optimise", scene, *gravity, "-o", tmp_path / "out", "--preset", "fast", "--jobs", 1)
    assert status == 2
    assert err.endswith("dynsim: no design stood of the 4 examined (1 not judged)\n")
    assert out.splitlines()[-1] == f"report: {tmp_path / 'out' / 'report.html'}"
    page = (tmp_path / "out" / "report.html").read_text()
    assert "No design stood of the 4 examined (1 not judged)." in page
    assert "The first design that could be built (parameters.t 0.1)." in page


def test_the_report_of_a_search_states_what_was_asked_and_shows_the_worst_case(run, tmp_path, monkeypatch):
    """At the foot of a post 1 m high that leans by 7 degrees the resultant is tan 7 / 2 = 0.061 m off the middle."""
    scene = tmp_path / "post.toml"
    scene.write_text('name = "post"\n[parameters]\nt = { value = 0.5, min = 0.3, max = 0.5, step = 0.1 }\n')
    with scene.open("a") as file:
        file.write('[elements.post]\nkind = "box"\nsize = ["= t", 1.0, 1.0]\n')
    titles = []
    monkeypatch.setattr("matplotlib.axes.Axes.set_title", lambda _, text, **__: titles.append(text))
    given = ["--imperfection", "edge=100 mm", "--tilt", "y,7", "--threshold", 0.05, "--preset", "fast"]
    status, out, _ = run("optimise", scene, "-o", tmp_path / "out", "--jobs", 1, *given)
    # A foot of 0.3 m that loses 0.1 m at each edge ends 0.05 m off its middle, and one of 0.4 m 0.1 m.
    assert status == 0
    assert "best: parameters.t = 0.4" in out
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Judged with tilt y,7." in page
    asked = "strategy pruned, over line, imperfection edge=100 mm, threshold 0.05, preset fast"
    assert f"Searched with {asked}." in page
    # As drawn, that of 0.3 m stands.
    assert "(parameters.t 0.3) would move first, in the worst case of the imperfections: joints lose 100 mm" in page
    assert "rejected design: parameters.t 0.3\nunstable, first motion exaggerated" in titles


def test_a_warning_of_one_of_several_files_names_the_file(file):
    with pytest.warns(InputWarning, match=r"pillar\.json: rough joints"):
        rows = side_by_side([file], lambda _: "rough joints", warned, 1, None)
    assert rows[0].result == "rough joints"


def test_a_plan_is_carried_out_with_statics_beside_it_unless_they_are_not_asked_for(run, tmp_path):
    write(tee(), tmp_path / "tee.json")
    # The side blocks overhang the base by more than half: each falls as it is put in, and top alone holds both.
    steps = Step(("base",)), Step(("left", "right")), Step(("top",))
    write_plan(Plan(steps, assembly="tee.json"), tmp_path / "plan.json")
    target = tmp_path / "run.npz"
    status, both, _ = run("sequence", tmp_path / "plan.json")
    assert status == 0
    assert "1 steps do not stand, the first is step 1." in both
    assert "Statics and Bullet agree on 3 of 3 steps." in both
    assert "run: " not in both
    alone = run("sequence", tmp_path / "plan.json", "--no-statics", "-o", target)[1]
    assert "Statics" not in alone
    assert alone.splitlines()[-1] == f"run: {target}"
    assert read_run(target).assembly.names == tee().names


@pytest.fixture
def building(tmp_path):
    """A plan of three steps that stand, each with one block or two."""
    steps = Step(("base",)), Step(("left", "right"), ("left", "right")), Step(("top",))
    write(tee(), tmp_path / "tee.json")
    write_plan(Plan(steps, assembly="tee.json"), tmp_path / "plan.json")
    return tmp_path / "plan.json"


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("step", [0, 1, 2])
def test_an_interrupt_leaves_the_steps_that_were_carried_out(run, building, tmp_path, monkeypatch, step, as_json):
    """It comes when the last block of the step has been put in."""
    put_in, done = _Site._put_in, []

    def interrupted(self, block):
        put_in(self, block)
        done.append(block)
        if len(done) == (1, 3, 4)[step]:
            raise KeyboardInterrupt

    monkeypatch.setattr(_Site, "_put_in", interrupted)
    target = tmp_path / "run.npz"
    status, out, err = run("sequence", building, "-o", target, *["--json"] * as_json)
    assert status == INTERRUPTED
    assert err.endswith("dynsim: interrupted\n")
    if not step:
        assert (out, target.exists()) == ("", False)
        return
    ended = read_run(target)
    assert len(ended.times) == 1 + step
    assert np.isfinite(ended.placed[1:]).sum() == (1 if step == 1 else 3)  # without those of the step that has no end
    if as_json:
        told = json.loads(out)
        assert (told["verdict"], told["missing"], told["statics"]) == ("stopped", 3 - step, None)
        assert [row["verdict"] for row in told["steps"]] == ["stands"] * step
    else:
        first, head, stands, *_ = out.splitlines()
        assert first == "Stopped: an interrupt came before every step was judged."
        assert head.startswith(f"plan: {step} of 3 steps, ")
        assert stands.startswith("Each of these stands; ")
        assert "Statics: no answer, interrupted." in out


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_of_the_statics_leaves_the_run_in_bullet(run, building, monkeypatch, as_json):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("dynsim.comparison.steps.assess_plan", interrupt)
    status, out, _ = run("sequence", building, *["--json"] * as_json)
    assert status == INTERRUPTED
    if as_json:
        told = json.loads(out)
        assert (told["verdict"], told["missing"], told["statics"], len(told["steps"])) == ("stands", 0, None, 3)
    else:
        assert "Every step stands; " in out
        assert out.splitlines()[-1] == "Statics: no answer, interrupted."


def test_the_steps_that_are_carried_out_are_counted_meanwhile(run, building, monkeypatch):
    said = []

    @contextmanager
    def at_work(_):
        yield said.append

    monkeypatch.setattr("dynsim.cli.sequence.at_work", at_work)
    assert run("sequence", building, "--no-statics")[0] == 0
    assert said == [f"{done} of 3 steps carried out (Ctrl-C keeps them)" for done in (1, 2, 3)]


def test_a_place_that_no_run_is_written_to_is_refused_before_the_run(run, tmp_path, monkeypatch):
    file = write(tee(), tmp_path / "tee.json")
    write_plan(Plan((Step(("base",)),)), tmp_path / "plan.json")
    begun = []
    monkeypatch.setattr("dynsim.judge.replay.sequence", lambda *_, **__: begun.append("run"))
    status, out, err = run("sequence", file, "--plan", tmp_path / "plan.json", "-o", tmp_path / "run.txt")
    assert (status, out, begun) == (2, "", [])
    assert "run.txt: " in err


def test_what_cannot_be_written_is_refused_before_it_is_made(run, file, tmp_path, monkeypatch):
    status, out, err = run("compare", tmp_path / "none.json", "-o", tmp_path / "gone" / "rows.csv")
    assert (status, out) == (2, "")
    assert "rows.csv: no such directory: " in err
    begun = []
    monkeypatch.setattr("dynsim.judge.verify.verify", lambda *_, **__: begun.append("run"))
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)  # as where it is not installed
    status, out, err = run("verify", file, "-o", tmp_path / "run.mp4")
    assert (status, out, begun) == (2, "", [])
    assert "pip install imageio-ffmpeg" in err


@pytest.fixture(scope="module")
def verdict():
    return verify(hanging())


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (lambda found, folder: write_movie(found.run, folder / "fall.mov"), r"fall\.mov: cannot write \"\.mov\""),
        (lambda found, folder: write_movie(found.run, folder / "a.gif", frames_per_second=0), "0 frames a second"),
        (lambda found, folder: write_movie(found.run, folder / "a.gif", slower=0.0), r"0\.0 times slower"),
        (lambda found, folder: film_strip(found.run, folder / "none" / "a.png"), "no such directory"),
        (lambda found, folder: film_strip(found.run, folder / "a.png", times=[]), r"times are \[\]"),
        (lambda found, folder: film_strip(found.run, folder / "a.png", times=[0.0, -0.1]), "must lie between 0 and"),
        (lambda found, folder: film_strip(found.run, folder / "a.png", times=[99.0]), "must lie between 0 and"),
        (lambda found, _: past_verdict(replace(found, settings=None), 0.1), "does not know the settings of its run"),
    ],
)
def test_films_that_cannot_be_drawn_are_refused_and_leave_no_file(verdict, tmp_path, draw, words):
    with pytest.raises(InputError, match=words):
        draw(verdict, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_strip_shows_the_moments_nearest_to_those_asked_for(verdict, tmp_path, monkeypatch):
    titles = []
    monkeypatch.setattr("matplotlib.axes.Axes.set_title", lambda _, text, **__: titles.append(text))
    end = verdict.run.times[-1]
    film_strip(verdict.run, tmp_path / "strip.png", times=[end, 0.0])
    assert titles == [f"{end:.2f} s", "0.00 s"]
