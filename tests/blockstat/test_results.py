"""Results have one face, options one set of names, and the package one entrance."""

import ast
import json
import math
import subprocess
import sys

import pytest

import blockstat
import dynsim
from blockstat import (
    Assembly,
    InputError,
    Result,
    SearchOutcome,
    SearchResult,
    Sentence,
    assess,
    assess_fully,
    box,
    friction_limit,
    limit_load,
    load_domain,
    repair,
    search,
    settlement,
    sweep,
    thrust_range,
    tilt_limit,
)
from evidence.scenes.small import arch


@pytest.fixture(scope="module")
def tower():
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="tower")]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=1.0, density=1000.0)


#: Parts of results, with an outcome of their own.
NO_RESULTS = {"ButtressStep", "ScaledRun", "StepRun"}
RESULTS = {
    "assess": (assess, ()),
    "limit_load": (limit_load, ((1, 0, 0),)),
    "thrust_range": (thrust_range, (["ground"], (0, 0, -1))),
    "settlement": (settlement, (["ground"], (0, 0, -1))),
    "load_domain": (load_domain, ((1, 0, 0), (0, 1, 0))),
    "tilt_limit": (tilt_limit, ("y",)),
    "friction_limit": (friction_limit, ()),
    "repair": (repair, ()),
    "assess_fully": (assess_fully, ()),
}


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_explains_itself_in_the_same_way(tower, name):
    function, arguments = RESULTS[name]
    found = function(tower, *arguments)
    result = found[1] if name == "repair" else found
    assert isinstance(result, Result)
    assert isinstance(result.outcome, Sentence)
    text = result.explain()
    assert text.splitlines()[0] == result.outcome.value
    assert str(result) == text
    assert result.outcome.value.split(":")[0] in result._repr_html_()
    summary = result.summary()
    assert summary["sentence"] == result.outcome.value
    assert summary.get("outcome", summary.get("status")) == result.outcome.word
    json.dumps(summary, allow_nan=False)


def test_a_notebook_shows_little_of_all_that_a_report_knows(tower):
    found = assess_fully(tower, directions=4)
    assert 500 < len(found._repr_html_()) < 5000
    assert [line for line in found.explain().splitlines() if line == "Limit load over the horizon"]
    assert found.summary()["answers"]["Limit load over the horizon"] == found.directions.summary()


def test_whatever_has_an_outcome_is_a_result():
    for package in (blockstat, dynsim):
        for kind in (getattr(package, name) for name in package.__all__):
            if isinstance(kind, type) and "outcome" in {*vars(kind), *getattr(kind, "__dataclass_fields__", ())}:
                assert issubclass(kind, Result) or kind.__name__ in NO_RESULTS, kind


@pytest.mark.parametrize("name", RESULTS)
def test_an_unknown_option_is_refused_by_the_function_that_was_called(tower, name):
    function, arguments = RESULTS[name]
    with pytest.raises(InputError, match=f'{name}: unknown option "flows"; options are: .*gap'):
        function(tower, *arguments, flows="coulomb")


def test_searches_and_sweeps_refuse_unknown_options_too():
    with pytest.raises(InputError, match='search: unknown option "judge"; options are: verify, '):
        search(None, judge=None)
    with pytest.raises(InputError, match='sweep: unknown option "worker"; options are: measure, jobs'):
        sweep(None, [], "x.jsonl", worker=1)


def test_permanent_loads_count_in_every_limit(tower):
    lean = blockstat.acceleration(tower, (1, 0, 0)) * 0.2
    alone, leaning = limit_load(tower, (1, 0, 0)), limit_load(tower, (1, 0, 0), loads=lean)
    assert leaning.lower == pytest.approx(alone.lower - 0.2, rel=1e-6)
    heavy = 0 * lean
    heavy[1, 2] = -1000.0
    weight = 2.0 * 1000.0 * 9.81
    assert thrust_range(tower, ["ground"], (0, 0, -1), loads=heavy).least == pytest.approx(weight + 1000.0, rel=1e-6)
    # A weight that does not turn with gravity steadies the tower: sin(a) h/2 = cos(a) b/2 + (P / W) b/2.
    angle = math.radians(tilt_limit(tower, "y", loads=heavy).value)
    assert math.sin(angle) * 1.0 == pytest.approx((math.cos(angle) + 1000.0 / weight) / 2, rel=1e-5)


def test_an_arch_pushes_a_support_that_gives_way():
    spread = settlement(arch(9, 0.3), ["right"], (1, 0, 0))
    close = settlement(arch(9, 0.3), ["right"], (-1, 0, 0))
    assert (spread.outcome.word, close.outcome.word) == ("pushes", "resists")
    assert spread.reaction > 0 > close.reaction


def test_a_search_says_whether_it_found_a_design():
    result = SearchResult(building=None, best=None, best_parameters=None, history=())
    assert result.outcome is SearchOutcome.NONE_STANDS
    assert result.explain().startswith(SearchOutcome.NONE_STANDS.value)
    stopped = SearchResult(building=None, best=None, best_parameters=None, history=(), finished=False)
    assert stopped.summary()["outcome"] == "interrupted"


@pytest.mark.parametrize("package", ["blockstat", "dynsim"])
def test_a_package_runs_as_a_module(package):
    answer = subprocess.run([sys.executable, "-m", package, "--version"], capture_output=True, text=True, check=False)
    assert (answer.returncode, answer.stderr, answer.stdout.strip()) == (0, "", blockstat.__version__)


def test_importing_the_package_imports_no_room():
    code = "import sys, blockstat; ours = lambda m: m.startswith('blockstat.') or m == 'numpy'\n"
    # Modules of version 0.1 are names without a file.
    code += "print([name for name, module in sys.modules.items() if ours(name) and module.__spec__])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    # But for what imports rooms on demand, of which no line of mathematics is one.
    needed = ["blockstat.system", "blockstat.system.old_names", "blockstat.system.on_demand"]
    assert sorted(ast.literal_eval(answer.stdout)) == needed
