"""Published plans of a dome of 72 parts, two robots (AssemblyEnv, Ziqi Wang, 2024): which steps stand.

The steps that do not stand and the least friction are those of an independent checker with its own joints and its own
conic program. It gives .6201, .6201 and .6204, to some 1e-4. The plans were made for a square friction "cone" of .5,
which reaches .707 at its corners, so that they stand at .7.
"""

import json

import pytest
from typer.testing import CliRunner

from blockstat import read
from blockstat.cli.commands import app
from blockstat.sequence.plan import least_friction, read_plan
from blockstat.sequence.states import Whole

FALL = {
    "dome_0703origin": ([89, 90, 91, 99, 100, 101, 108, 109, 110, 111], 0.6201),
    "dome_0703start1": ([47, 79, 80, 81, 82], 0.6201),
    "dome_0903shortee": ([80, 81, 114, 115], 0.6204),
}


@pytest.fixture(scope="module")
def sequences(cases):
    folder = cases.parent / "sequences"
    if not folder.is_dir():
        pytest.skip("no directory of sequences")
    return folder


@pytest.mark.parametrize("name", FALL)
@pytest.mark.parametrize("friction", ["0.7", "0.55"])
def test_the_steps_that_fall(sequences, name, friction):
    arguments = ["sequence", str(sequences / "dome72.json"), "--plan", str(sequences / f"{name}.json")]
    answer = CliRunner().invoke(app, [*arguments, "--friction", friction, "--json"])
    rows = json.loads(answer.stdout)["steps"]
    fall = [row["step"] for row in rows if row["verdict"] != "stable"]
    assert fall == (FALL[name][0] if friction == "0.55" else [])
    assert max(len(row["held"]) for row in rows) == 2
    assert len(rows[-1]["present"]) == 72


@pytest.mark.parametrize("name", FALL)
def test_the_least_friction_at_which_every_step_stands(sequences, name):
    assembly = read(sequences / "dome72.json")
    whole = Whole(assembly)
    steps, expected = FALL[name]
    states = read_plan(sequences / f"{name}.json", assembly).states()
    critical = [whole.state_of(*states[k], "state") for k in steps]
    low, high = least_friction(whole, critical)
    assert low < high
    assert high == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize("name", FALL)
def test_scores_found_around_a_change_are_those_of_the_whole(sequences, name):
    """A state judged alone knows nothing of earlier ones, and its penalty program is solved as a whole."""
    assembly = read(sequences / "dome72.json")
    states = read_plan(sequences / f"{name}.json", assembly).states()
    after_others = Whole(assembly, friction=0.55)
    scores = [after_others.assess(*after_others.state_of(*state, "state")).score for state in states]
    assert after_others.evidence.statistics["solved"] < 15
    for k in FALL[name][0]:
        alone = Whole(assembly, friction=0.55, interfaces=after_others.interfaces)
        verdict = alone.assess(*alone.state_of(*states[k], "state"))
        assert alone.evidence.statistics["nearby"] == 0
        assert scores[k] == pytest.approx(verdict.score, rel=1e-5)
