"""Which loads of a case act is said by every command, and a code check leaves out those that are live.

A slab 1 m wide, .5 m deep and 2 m high, of weight W, tips towards +y when pushed at its centre by .25 W. A wind that
blows at its centre towards -y adds its own force to what the push must be.
"""

import json
from functools import partial

import numpy as np
import pytest

from blockstat import Assembly, InputWarning, assess_fully, assessment_html, box, load_case, write
from blockstat.cli.commands import app
from dynsim.cli.commands import app as dynamics

SHARE = 0.0675  #: of the weight, 27 % of what tips the slab without it
WIND = SHARE * 2000 * 9.81  #: N
CASES = f"""\
[loads.wind]
kind = "body"
force = [0, {-WIND}, 0]
[cases.service]
live = {{ wind = 1 }}
weight = 0.9
[cases.earthquake]
factors = {{ wind = 1 }}
description = "wind that stays"
"""
LIVE = 'Loads: case "service": 0.9 weight + 1 wind (live)'


@pytest.fixture
def slab():
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 0.5, 2), name="slab")]
    return Assembly.from_blocks(blocks, supports=["ground"], density=2000.0, friction=0.9)


@pytest.fixture
def files(slab, tmp_path):
    (tmp_path / "cases.toml").write_text(CASES)
    return [str(write(slab, tmp_path / "slab.json")), "--loads", str(tmp_path / "cases.toml")]


@pytest.fixture
def run(run_command):
    return partial(run_command, app, "blockstat")


def test_a_code_check_leaves_live_loads_out_and_says_so(run, files):
    """With .9 of the weight to hold it down it tips at .225 W; a wind that stayed would make it .2925 W."""
    file, *loads = files
    asked = ["code-check", file, *loads, "--load", "0,1,0", "--case"]
    with pytest.warns(InputWarning, match="put them under factors if they act with the earthquake"):
        _, out, _ = run(*asked, "service")
    assert f"\n{LIVE}; the live loads are left out: put them under factors if they act with the earthquake.\n" in out
    found = json.loads(run(*asked, "service", "--json")[1])
    assert found["alpha0"] == pytest.approx(0.225, rel=1e-4)
    assert (found["case"], found["live_loads"]) == ("service", "left_out")
    assert found["combination"] == "0.9 weight + 1 wind (live)"
    assert any("are left out of the code check" in text for text in found["warnings"])
    out = run(*asked, "earthquake")[1]
    assert '\nLoads: case "earthquake": wind that stays (1 weight + 1 wind).\n' in out
    assert "left out" not in out
    found = json.loads(run(*asked, "earthquake", "--json")[1])
    assert found["alpha0"] == pytest.approx(0.25 + SHARE, rel=1e-4)
    assert "live_loads" not in found


def test_the_code_check_of_a_report_leaves_live_loads_out_and_its_limit_loads_do_not(slab):
    loads = {"wind": np.array([[0.0] * 6, [0, -WIND, 0, 0, 0, 0]])}
    case = load_case(slab, "service", loads, {"service": {"live": {"wind": 1}}})
    found = assess_fully(slab, directions=4, case=case, code={"demand": 0.1})
    check = dict(found.checks)["+y"]
    assert check.alpha0 == pytest.approx(0.25, rel=1e-4)
    assert found.directions.upper[found.directions.names.index("+y")] == pytest.approx(0.25 + SHARE, rel=1e-4)
    said = "are left out of the code check, for they are not permanent; put them under factors if they act"
    assert said in assessment_html(found).partition("<h2>Pictures")[0]
    stays = load_case(slab, "service", loads, {"service": {"factors": {"wind": 1}}})
    found = assess_fully(slab, directions=4, case=stays, code={"demand": 0.1})
    assert dict(found.checks)["+y"].alpha0 == pytest.approx(0.25 + SHARE, rel=1e-4)
    assert "left out of the code check" not in assessment_html(found)


def test_further_loads_act_beside_a_factor_on_the_weight(slab):
    """With .9 of the weight, and a wind beside the case: it tips at .225 W + the wind."""
    wind = np.array([[0.0] * 6, [0, -WIND, 0, 0, 0, 0]])
    case = load_case(slab, "light", {}, {"light": {"weight": 0.9}})
    found = assess_fully(slab, directions=4, case=case, loads=wind, code={"demand": 0.1})
    assert dict(found.checks)["+y"].alpha0 == pytest.approx(0.225 + SHARE, rel=1e-4)


@pytest.mark.parametrize(
    ("command", "live", "words"),
    [
        ("check", "act", "."),
        ("friction", "act", "."),
        ("tilt --axis=-1,0,0", "act", "."),
        ("tie --between ground,slab", "act", "."),
        ("settle --move ground:0,0,-0.001 --until 0", "act", "."),
        ("reliability --draws 2 --uncertain friction=uniform,0.8,0.9", "act", "."),
        ("limit", "grow", "; the live loads grow."),
        ("capacity --steps 3", "grow", "; the live loads grow."),
        ("limit --load 0,1,0", "stay", "; the live loads are held constant."),
        ("limit --directions 4", "stay", "; the live loads are held constant."),
        ("capacity --steps 3 --load 0,1,0", "stay", "; the live loads are held constant."),
        ("prove -o {folder}/proof.json", "act", "."),
        ("prove -o {folder}/proof.json --limit", "grow", "; the live loads grow."),
    ],
)
def test_every_command_says_which_loads_act(run, files, tmp_path, command, live, words):
    name, *options = command.format(folder=tmp_path).split()
    asked = [name, *files, "--case", "service", *options]
    assert f"{LIVE}{words}" in run(*asked)[1].splitlines()
    found = json.loads(run(*asked, "--json")[1])
    assert (found["case"], found["combination"]) == ("service", "0.9 weight + 1 wind (live)")
    assert found["live_loads"] == live


def test_without_a_case_no_loads_are_named(run, files):
    assert "Loads:" not in run("check", files[0])[1]
    assert "combination" not in json.loads(run("check", files[0], "--json")[1])


@pytest.mark.parametrize(
    ("command", "live", "words"),
    [
        ("verify", "act", "."),
        ("limit", "grow", "; the live loads grow."),
        ("limit --load 0,1,0", "stay", "; the live loads are held constant."),
    ],
)
def test_simulations_say_which_loads_act(run_command, files, command, live, words):
    name, *options = command.split()
    asked = [name, *files, "--case", "service", *options]
    assert f"{LIVE}{words}" in run_command(dynamics, "dynsim", *asked)[1].splitlines()
    found = json.loads(run_command(dynamics, "dynsim", *asked, "--json")[1])
    assert (found["case"], found["live_loads"]) == ("service", live)
