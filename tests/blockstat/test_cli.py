import json
import math
import re
import subprocess
import sys
import time
from importlib.metadata import version

import pytest

from blockstat import Assembly, box, limit_load_by_direction, read, write
from blockstat.cli import progress
from blockstat.system import lines
from evidence.scenes.small import arch, stack


def run(*arguments, program="blockstat"):
    code = f"from {program}.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def check(*arguments):
    answer = run("check", *arguments, "--json")
    assert answer.returncode == 0, answer.stderr
    return json.loads(answer.stdout)


@pytest.fixture
def stones(tmp_path):
    return write(stack(3), tmp_path / "stones.json")


def test_check_prints_a_verdict(stones):
    answer = check(stones)
    assert answer["verdict"] == "stable"
    assert answer["score"] == 0.0
    assert (answer["blocks"], answer["interfaces"]) == (4, 3)
    assert answer["certificate"]["residual"] < 1e-9
    assert check(stones, "--gap", "2 mm")["interfaces"] == 3
    plain = run("check", stones)
    assert plain.returncode == 0
    assert "Stable: a force field" in plain.stdout


@pytest.mark.parametrize("program", ["blockstat", "dynsim"])
def test_version(program):
    answer = run("--version", program=program)
    assert (answer.returncode, answer.stdout.strip()) == (0, version("blockstat"))


def test_options_change_the_question(stones):
    assert check(stones, "--gravity", "0.4,0,-1")["verdict"] == "unstable"
    assert check(stones, "--friction", "0.1", "--gravity", "0.2,0,-1")["verdict"] == "unstable"
    assert check(stones, "--friction", "inf", "--gravity", "0.3,0,-1")["verdict"] == "stable"
    # Three cubes of height 3 tip at tan = 1/3, either way.
    for way in ("x,", "y,-"):
        assert check(stones, "--tilt", f"{way}18.43")["verdict"] == "stable"
        assert check(stones, "--tilt", f"{way}18.44")["verdict"] == "unstable"
    assert check(stones, "--tilt", "z,40")["verdict"] == "stable"
    assert check(stones, "--supports", "ground,stone0")["verdict"] == "stable"


def test_an_unstable_answer_names_what_moves_and_exits_with_zero(tmp_path):
    answer = check(write(arch(12, 0.08), tmp_path / "thin.json"))
    assert answer["verdict"] == "unstable"
    assert answer["score"] > 0
    assert answer["moving"][0].startswith("voussoir")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["check", "gone.json"], "gone.json: no such file"),
        (["check", ""], "blockstat: the name of a file is empty\n"),
        (["sequence", "{stones}", "--plan", "gone.json"], "blockstat: gone.json: no such file\n"),
        (["check", "{stones}", "--friction", "-1"], "friction is -1.0"),
        (["check", "{stones}", "--gravity", "1,2"], '--gravity is "1,2"; it must read GX,GY,GZ'),
        (["check", "{stones}", "--tilt", "w,5"], '--tilt is "w,5"'),
        (["check", "{stones}", "--solver", "magic"], "solver is 'magic'; it must be one of: auto, interior-point"),
        (["check", "{stones}", "--supports", "moon"], 'supports: no block "moon"'),
        (["check", "{stones}", "--gap", "7"], "gap is 7.0"),
        (["check", "{stones}", "--gap", "2 miles"], 'gap is "2 miles"; it must be a share of the block size'),
        (["build", "gone.toml", "-o", "x.json"], "gone.toml: no such file"),
        (["plot", "{stones}", "-o", "/nowhere/x.png"], "no such directory"),
        (["plot", "{stones}", "-o", "x.glb"], "only a mechanism is written as .glb"),
        (["check", "{stones}", "--tilt", "x"], '--tilt is "x"; it must read AXIS,DEGREES'),
        (["limit", "{stones}", "--load", "0,0,0"], "load direction is [0.0, 0.0, 0.0]"),
        (["plot", "{stones}", "--mechanism", "-o", "x.png"], "is stable and has no mechanism; give --load AX,AY,AZ"),
        (["plot", "{stones}", "--load", "1,0,0", "-o", "x.png"], "--load goes with --mechanism, --stone or --reserve"),
        (["plot", "{stones}", "--stone", "-o", "x.png"], "give its direction by --load AX,AY,AZ"),
        (["plot", "{stones}", "--plain", "--forces", "-o", "x.png"], "ask for one of them"),
        (["plot", "{stones}", "-o", "x.xyz"], 'x.xyz: no picture is written as ".xyz"; a picture is .png,'),
        (["plot", "{stones}", "-o", "x.pgf"], 'x.pgf: no picture is written as ".pgf"; a picture is .png,'),
        (["check"], "Missing argument"),
        (["check", "{stones}", "--magic"], "No such option: --magic; see `blockstat check --help`"),
        (["magic"], "No such command 'magic'; see `blockstat --help`"),
        (["check", "{stones}", "--friction", "x"], "Invalid value for '--friction': "),
    ],
)
def test_bad_input_is_one_message_and_status_two(stones, arguments, expected):
    answer = run(*[argument.format(stones=stones) for argument in arguments])
    assert answer.returncode == 2
    assert expected in answer.stderr
    assert "Traceback" not in answer.stderr
    assert answer.stdout == ""
    assert answer.stderr.startswith("blockstat: ")
    assert len(answer.stderr.splitlines()) == 1


def test_no_arguments_print_the_help():
    answer = run()
    lines = (answer.stdout + answer.stderr).splitlines()
    assert lines[0].startswith("Usage: blockstat")
    assert len(lines) > 20
    assert any(line.split()[:1] == ["check"] for line in lines)
    assert "No such" not in answer.stderr


def test_check_says_what_the_flow_rule_adds(stones):
    added = "The loads alone cause forces without dilatancy and self-stress"
    assert added in run("check", stones, "--flow", "coulomb").stdout
    assert added not in run("check", stones).stdout
    assert added not in run("check", stones, "--flow", "coulomb", "--gravity", "0.4,0,-1").stdout


def test_build_and_plot(tmp_path, root):
    out = tmp_path / "chapel.json"
    answer = run("build", root / "examples" / "chapel.toml", "-o", out)
    assert answer.returncode == 0
    assert f"{read(out).n_blocks} blocks" in answer.stdout
    picture = tmp_path / "chapel.png"
    assert run("plot", out, "-o", picture).returncode == 0
    assert picture.read_bytes()[:4] == b"\x89PNG"


def test_plots_of_a_mechanism(stones, tmp_path):
    for name, magic in (("mech.png", b"\x89PNG"), ("mech.glb", b"glTF")):
        for question in (["--load", "1,0,0"], ["--gravity", "0.4,0,-1"]):
            out = tmp_path / name
            out.unlink(missing_ok=True)
            answer = run("plot", stones, "--mechanism", *question, "-o", out)
            assert answer.returncode == 0, answer.stderr
            assert out.read_bytes()[:4] == magic


@pytest.mark.parametrize("question", [["--joints"], ["--stone", "--load", "1,0,0"]])
def test_plots_of_joints_and_of_stones(stones, question, tmp_path):
    out = tmp_path / "picture.png"
    answer = run("plot", stones, *question, "-o", out)
    assert answer.returncode == 0, answer.stderr
    assert out.read_bytes()[:4] == b"\x89PNG"


def test_our_own_failure_is_status_one(stones, monkeypatch, capsys):
    from blockstat.cli import options as cli_options

    def broken():
        raise ZeroDivisionError("oops")

    assert cli_options._status(broken, "blockstat") == 1
    assert "internal error (ZeroDivisionError: oops)" in capsys.readouterr().err


def test_convert_and_units(tmp_path):
    path = write(stack(2), tmp_path / "stack.obj")
    target = tmp_path / "small.json"
    answer = run("convert", path, "--units", "mm", "--format", "compas-model", "-o", target)
    assert answer.returncode == 0, answer.stderr
    assert read(target).volume[1] == pytest.approx(1e-9)
    assert check(path, "--units", "cm")["verdict"] == "stable"
    wrong = run("check", path, "--units", "furlong")
    assert wrong.returncode == 2
    assert "units are 'furlong'; known are: m, dm" in wrong.stderr


def test_check_writes_the_verdict_beside_the_blocks(tmp_path):
    path = write(arch(12, 0.08), tmp_path / "thin.json")
    check(path, "-o", tmp_path / "thin.obj")
    moved = [float(value) for value in re.findall(r'"displacement": ([^,}]+)', (tmp_path / "thin.obj").read_text())]
    assert len(moved) == 14
    assert max(moved) == pytest.approx(1.0)
    wrong = run("check", path, "-o", tmp_path / "thin.stl")
    assert wrong.returncode == 2
    assert 'cannot write ".stl"; it is written as: .glb, .obj, .json' in wrong.stderr


def test_coulomb_options_of_the_command_line(tmp_path):
    path = tmp_path / "stack.json"
    write(stack(2, friction=0.3), path)
    answer = run("tilt", path, "--axis", "y", "--flow", "coulomb", "--json")
    found = json.loads(answer.stdout)
    assert len(found["kinds_deg"]) == 3
    assert found["stands_deg"] == max(stands for stands, _ in found["kinds_deg"])
    assert found["stands_deg"] == pytest.approx(math.degrees(math.atan(0.3)), abs=0.03)
    words = run("check", path, "--flow", "coulomb", "--tightnesses", "3").stdout
    assert "At 100 % of random tightnesses of the joints there is such a state." in words
    for wrong in (("--tightnesses", "3"), ("--flow", "coulomb", "--tightnesses", "-1")):
        answer = run("check", path, *wrong)
        assert answer.returncode == 2
        assert "--tightnesses is" in answer.stderr


def test_long_work_is_told_in_plain_lines_where_there_is_no_terminal(capsys, monkeypatch):
    monkeypatch.setattr(progress, "BEAT", 0.01)
    monkeypatch.setattr(lines, "EVERY", 0.02)
    with progress.at_work("judging 3 blocks") as say:
        time.sleep(0.5)
        say("drawing")
        time.sleep(0.5)
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "judging 3 blocks, 0 s"
    assert told[-1].startswith("drawing, ")
    assert "\x1b" not in "".join(told)


def test_every_direction_of_the_horizon_is_told():
    told = []
    slab = Assembly.from_blocks([box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 0.5, 2))], supports=[0])
    limit_load_by_direction(slab, 4, refine=False, progress=lambda *state: told.append(state))
    assert [(done, name) for done, name, _ in told] == [(1, "+x"), (2, "+y"), (3, "-x"), (4, "-y")]
    assert told[1][2].upper == pytest.approx(0.25)


def test_the_code_check_of_a_file(tmp_path):
    """A slab .5 m deep and 2 m high tips at 1/4: ag S = 2 alpha0 / 1.35, S = 1 on rock and 1.4 - .4 F0 ag on soil B."""
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 0.5, 2), name="slab")]
    file = write(Assembly.from_blocks(blocks, supports=["ground"]), tmp_path / "slab.json")
    asked = ["code-check", str(file), "--load", "0,1,0", "--ag"]
    found = json.loads(run(*asked, "0.3", "--json").stdout)
    assert found["outcome"] == "satisfied"
    assert found["ag_slv"] == pytest.approx(0.5 / 1.35, rel=1e-4)
    assert (found["moving"], found["joints"]["hinges"]) == (["slab"], [["ground", "slab"]])
    lines = run(*asked, "0.3").stdout.splitlines()
    assert "Joints of the mechanism: 1 hinge, 0 sliding, 0 opening." in lines
    assert "First to move: slab." in lines
    on_ridge = json.loads(run(*asked, "0.3", "--topography", "1.4", "--json").stdout)
    assert on_ridge["ag_slv"] == pytest.approx(0.5 / 1.35 / 1.4, rel=1e-4)
    assert on_ridge["outcome"] == "not_satisfied"
    ag = (1.4 - math.sqrt(1.4**2 - 4 * 0.375)) / 2  # ag (1.4 - ag) = 1.5 x .25, with S = 1.038
    on_soil = run(*asked, "0.3", "--soil", "B", "--q", "1.5", "--fc", "1").stdout
    assert f"ag = {ag:.5g}" in on_soil
    assert "asked for 0.3 g" in on_soil
    wrong = run(*asked, "15")
    assert (wrong.returncode, "--ag is 15; it is in units of g" in wrong.stderr) == (2, True)
    loads = tmp_path / "loads.toml"
    loads.write_text('[loads.roof]\nkind = "body"\nforce = [0, 0, -5000]\n\n[cases.roofed]\nfactors = {roof = 1}\n')
    roofed = run(*asked, "0.1", "--loads", str(loads), "--case", "roofed")
    assert "\nNot verified: the demand is borne without the inertia of permanent loads, whose mass" in roofed.stdout
    assert "Satisfied" not in roofed.stdout
    assert "masses=" not in roofed.stdout
