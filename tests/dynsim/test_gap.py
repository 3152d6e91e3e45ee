"""`--gap` in the commands of dynsim and on the live page: Bullet gets the joints that statics were asked for."""

import json
from functools import partial

import numpy as np
import pytest
from typer.main import get_command

from blockstat import Assembly, InputError, Plan, Step, assess, box, find_interfaces, load_scene, search, write
from blockstat.app.design import Judged, Question, open_model
from blockstat.app.evaluation import evaluated
from blockstat.app.files import read_upload
from blockstat.cli.commands import app as blockstat_app
from blockstat.cli.options import _status
from blockstat.design_search.search import Margin
from blockstat.model import arch, assemble
from dynsim import compare, limit, sequence, simulate, verify
from dynsim.cli.commands import app
from dynsim.panel.work import Fallen, Refused, let_fall

GAP = 2e-3


def tower(cubes: int = 2, gap: float = GAP) -> Assembly:
    """Cubes of 0.1 m with a gap below each: twice what counts as a joint unless a gap is stated."""
    blocks = [box((-0.1, -0.1, -0.05), (0.2, 0.2, 0), name="ground")]
    step = 0.1 + gap
    blocks += [box((0, 0, step * k + gap), (0.1, 0.1, step * (k + 1)), name=f"cube{k}") for k in range(cubes)]
    return Assembly.from_blocks(blocks, supports=[0])


@pytest.fixture
def glb(tmp_path):
    return write(tower(), tmp_path / "tower.glb", units="mm")


#: With its gaps of 2 mm as joints the tower tips about the middle of the lower one; without, nothing holds it.
COMMANDS = {
    "verify": ([], lambda found: found["settling"] < 1e-4 and found["verdict"] == "stands"),
    "shake": (["--pulse", "1,0,0,0.1"], lambda found: found["settling"] < 1e-4),
    "limit": (
        ["--load", "1,0,0", "--width", "0.1", "--no-check"],
        lambda found: found["static_upper"] == pytest.approx(0.05 / 0.102, rel=1e-3) and found["outcome"] == "limit",
    ),
    "compare": (
        ["--jobs", "1"],
        lambda found: [found["rows"][0][key] for key in ("interfaces", "static", "dynamic")] == [2, "stable", "stands"],
    ),
    "sequence": (["--plan", "PLAN"], lambda found: found["statics"]["verdicts"] == ["stable"] * 2),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_that_reads_a_file_takes_a_stated_gap(command, glb, tmp_path, capsys):
    plan = {"steps": [{"install": ["cube0"]}, {"install": ["cube1"]}]}
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    own, right = COMMANDS[command]
    own = [str(tmp_path / "plan.json") if text == "PLAN" else text for text in own]
    arguments = [command, str(glb), "--units", "mm", *own, "--json"]
    status = _status(lambda: app(arguments, standalone_mode=False), "dynsim")
    out = capsys.readouterr().out
    assert status != 0 or not right(json.loads(out))
    assert _status(lambda: app([*arguments, "--gap", "2 mm"], standalone_mode=False), "dynsim") == 0
    assert right(json.loads(capsys.readouterr().out))


#: Commands that judge nothing: they write blocks or examples.
WRITE = {"build", "convert", "example"}


@pytest.mark.parametrize("program", [blockstat_app, app], ids=["blockstat", "dynsim"])
def test_no_command_that_judges_lacks_the_option(program):
    for name, command in get_command(program).commands.items():
        options = {option for parameter in command.params for option in parameter.opts}
        assert name in WRITE or "--gap" in options, name


@pytest.mark.parametrize("command", ["verify", "limit", "compare", "sequence", "shake", "report", "app"])
@pytest.mark.parametrize(
    ("gap", "told"), [("2 miles", 'gap is "2 miles"'), ("0.7", "gap is 0.7"), ("nan", "gap is nan")]
)
def test_a_gap_that_is_none_is_refused_as_blockstat_refuses_it(command, gap, told, glb, tmp_path, capsys):
    own = {"limit": ["--load", "1,0,0"], "shake": ["--pulse", "1,0,0,0.1"], "report": ["-o", str(tmp_path / "r.html")]}
    arguments = [command, str(glb), *own.get(command, []), "--gap", gap]
    assert _status(lambda: app(arguments, standalone_mode=False), "dynsim") == 2
    said = capsys.readouterr().err
    assert told in said
    assert "it must be" in said
    assert len(said.splitlines()) == 1


def test_the_report_counts_the_joints_of_the_stated_gap(glb, tmp_path):
    page = tmp_path / "report.html"
    options = ["--units", "mm", "--gap", "2 mm", "--directions", "4", "-o", str(page)]
    assert _status(lambda: app(["report", str(glb), *options], standalone_mode=False), "dynsim") == 0
    text = page.read_text()
    assert "2 mm" in text
    assert "closed for Bullet by moving corners" in text


def test_bullet_gets_no_joint_that_the_gap_leaves_out():
    """Of gaps of 1 mm and 0.2 mm only the small one is closed where joints are searched up to 0.5 mm."""
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0.001), (0.1, 0.1, 0.101), name="loose")]
    blocks.append(box((0.5, 0, 0.0002), (0.6, 0.1, 0.1002), name="near"))
    scene = Assembly.from_blocks(blocks, supports=[0])
    found = verify(scene, gap="0.5 mm")
    fallen = 1e3 * -found.run.displacement[0, 1:, 2]
    assert fallen[0] == pytest.approx(1.0, abs=0.1)
    assert verify(scene).run.displacement[0, 1, 2] == pytest.approx(0.0, abs=1e-4)


def test_a_wide_gap_is_closed_however_the_functions_are_asked():
    scene = tower(6, 4e-3)
    joints = find_interfaces(scene, gap="4 mm")
    assert joints.n_interfaces == 6
    assert joints.searched == "4 mm"
    for found in (verify(scene, gap="4 mm"), verify(scene, interfaces=joints)):
        assert found.outcome.word == "stands"
        assert found.settling < 1e-4
    assert [row.interfaces for row in compare(scene, gap="4 mm", jobs=1)] == [6]
    tips = 0.05 / (0.314 - 0.002)  # about the middle of the lowest gap
    assert limit(scene, (1, 0, 0), gap="4 mm", width=0.1, check=False).static[1] == pytest.approx(tips, rel=1e-4)
    plan = Plan((Step(tuple(f"cube{k}" for k in range(6))),))
    assert sequence(scene, plan, gap="4 mm").steps[0].max_displacement < 1e-3


def test_blocks_that_overlap_by_less_than_a_stated_gap_are_not_cut():
    """Voussoirs that overlap by 3 % of their size: with that as the gap they are joints, closed by moving corners."""
    ring = assemble(arch(span=2.0, thickness=0.2, depth=0.5, voussoirs=15, springers=0.3), friction=0.7)
    vertices = ring.vertices.copy()
    for block in ring.free:
        own = slice(*ring.vertex_start[block : block + 2])
        vertices[own] += 0.03 * (vertices[own] - ring.centroid[block])
    swollen = ring.with_(vertices=vertices)
    found = verify(swollen, gap="10 mm")
    assert found.outcome.word == "stands"
    assert not any("cut back" in text for text in found.warnings)
    assert any("closed for Bullet by moving corners" in text for text in found.warnings)


@pytest.mark.parametrize("gap", ["2 miles", 7, None, float("nan"), "1e400 mm", "２ mm"])
def test_a_gap_that_is_none_is_refused_before_anything_is_judged(gap, tmp_path):
    (tmp_path / "posts.toml").write_text(POSTS)
    for call in (
        lambda: verify(tower(), gap=gap),
        lambda: simulate(tower(), gap=gap),
        lambda: limit(tower(), (1, 0, 0), gap=gap),
        lambda: compare(tower(), gap=gap, jobs=1),
        lambda: sequence(tower(), Plan((Step(("cube0", "cube1")),)), gap=gap),
        lambda: search(load_scene(tmp_path / "posts.toml"), verify=None, gap=gap),
    ):
        with pytest.raises(InputError, match=r"gap is .*; it must be"):
            call()


class Told(list):
    """A channel that keeps what is sent."""

    send = list.append


def test_the_page_opens_a_file_with_a_stated_gap(glb):
    for read in (
        lambda gap: open_model(glb, units="mm", gap=gap),
        lambda gap: read_upload("tower.glb", glb.read_bytes(), "", units="mm", gap=gap),
    ):
        near, default = read("2 mm"), read(None)
        judged = evaluated(Question(1, near, near.start), None)
        assert isinstance(judged, Judged)
        assert judged.verdict.interfaces.n_interfaces == 2
        assert judged.verdict.outcome.word == "stable"
        assert evaluated(Question(1, default, default.start), None).verdict.interfaces.n_interfaces == 0
        with pytest.raises(InputError, match='gap is "2 miles"; it must be a share of the block size, or a length'):
            read("2 miles")


def test_let_it_fall_has_the_joints_of_the_static_verdict():
    told = Told()
    let_fall(told, assess(tower(6, 4e-3), gap="4 mm"))
    assert isinstance(told[0], Fallen)
    assert told[0].verdict.outcome.word == "stands"
    assert np.abs(told[0].verdict.run.displacement).max() < 1e-3
    assert not isinstance(told[-1], Refused)


POSTS = """
name = "posts"
supports = ["ground"]
[parameters]
w = { value = 0.4, min = 0.1, max = 0.4, step = 0.1 }
[elements.base]
kind = "pier"
size = [0.5, 0.5]
height = 0.5
courses = 1
[elements.post]
kind = "pier"
size = ["= w", "= w"]
height = 1.0
courses = 1
at = [0.0, 0.0, 0.508]
"""


def test_a_search_judges_all_its_designs_with_the_gap(tmp_path):
    """A post 8 mm above its base tips about the middle of the gap."""
    path = tmp_path / "posts.toml"
    path.write_text(POSTS)
    scene = load_scene(path)
    assert search(scene, verify=None).best_parameters is None
    options = {"gap": "8 mm", "strategy": "gradient", "margin": Margin((1.0, 0.0, 0.0), 0.15)}
    found = search(scene, verify=partial(verify, gap="8 mm"), **options)
    assert found.best_parameters["parameters.w"] == pytest.approx(2 * 0.15 * (0.5 + 0.004), rel=1e-4)


def test_the_command_of_a_search_takes_a_gap(tmp_path, capsys):
    path, out = tmp_path / "posts.toml", tmp_path / "out"
    path.write_text(POSTS)
    command = ["optimise", str(path), "-o", str(out), "--json", "--jobs", "1"]
    run = lambda *more: _status(lambda: app([*command, *more], standalone_mode=False), "dynsim")  # noqa: E731
    assert run("--gap", "8 mm") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["best"]["parameters.w"] == pytest.approx(0.1)
    assert {row["dynamic"] for row in found["history"]} == {"stands"}
    assert "Judged with gap 8 mm." in (out / "report.html").read_text()
    assert run() == 2  # a history of another gap is not taken up
    assert "this history is of another search" in capsys.readouterr().err
    assert run("--gap", "8 miles") == 2
    assert 'gap is "8 miles"' in capsys.readouterr().err
