"""What a user is handed: every result has one face, options say what they may be, the package runs as a program."""

import dataclasses
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import blockstat
import dynsim
from blockstat import Assembly, InputError, Plan, Step, acceleration, assess
from blockstat.result import Result, Sentence
from blockstat.spec import scene_from
from dynsim import Agreement, AngularSprings, Comparison, Comparisons, Constant, Removal, Settings, verify
from evidence.scenes.small import stack

FAST = Settings.named("fast")


def hall():
    sides = {"south": {"number": 1, "thickness": 0.4, "width": 0.4, "height": 1.0}}
    return scene_from(
        {
            "name": "hall", "length": 3.0, "span": 2.4, "brick": {"length": 1.0, "height": 0.5},
            "wall": {"thickness": 0.8, "height": 1.5}, "vault": {"thickness": 0.2, "voussoirs": 7}, "buttresses": sides,
        }
    )  # fmt: skip


def uncracked(assembly: Assembly):
    """A verdict of a building that stands without a crack."""
    stands = SimpleNamespace(word="stands")
    cracks = SimpleNamespace(per_group=dict)
    return SimpleNamespace(outcome=stands, cracks=cracks, run=SimpleNamespace(process_seconds=0.0))


@pytest.fixture(scope="module")
def results():
    verdict = verify(stack(1), settings=FAST)
    rows = dynsim.compare(stack(1), settings=FAST, jobs=1)
    limit = dynsim.limit(stack(1, 0.5, 2.0), (1, 0, 0), settings=FAST, width=0.2, check=False)
    built = dynsim.sequence(stack(1), Plan((Step((stack(1).names[-1],)),)), settings=FAST)
    pulses = [dynsim.Pulse((1.0, 0, 0), duration, "sine") for duration in (0.3, 0.5, 1.0)]
    shaken = dynsim.incremental(stack(1, 0.2, 1.0), pulses, settings=FAST, factor=2.0, beyond=0, jobs=1)
    results = [verdict, verdict.cracks, limit, rows, rows[0], built, dynsim.buttress_loop(hall(), uncracked)]
    return [*results, shaken, shaken.fragility()]


def test_every_result_answers_explains_itself_and_has_plain_values(results):
    for result in results:
        assert isinstance(result, Result)
        assert isinstance(result.outcome, Sentence)
        assert result.explain()
        assert str(result) == result.explain()
        assert result.summary()
        assert result._repr_html_().startswith(("<pre", "<p>"))


def test_all_results_of_the_package_are_results(results):
    handed = {type(result) for result in results}
    public = [getattr(dynsim, name) for name in dynsim.__all__]
    with_outcome = {kind for kind in public if isinstance(kind, type) and hasattr(kind, "explain")}
    assert with_outcome == handed


@pytest.mark.parametrize(
    ("row", "outcome"),
    [
        (Comparison("a"), Agreement.NO_VERDICT),
        (Comparison("a", static="stable", agree=True, agree_coulomb=True), Agreement.AGREE),
        (Comparison("a", static="stable", agree=True, agree_coulomb=False), Agreement.DIFFER),
        (Comparison("a", static="undecided"), Agreement.OPEN),
    ],
)
def test_a_row_says_whether_statics_and_bullet_agree(row, outcome):
    assert row.outcome is outcome
    assert Comparisons((row, Comparison("b"))).outcome is outcome
    assert Comparison(**row.summary()) == row


def test_wrenches_act_as_in_statics():
    # A block of 0.5 x 2 m tips at a quarter of its weight, by statics and in Bullet alike.
    asm = stack(1, 0.5, 2.0)
    for share, static, dynamic in ((0.24, "stable", "stands"), (0.26, "unstable", "falls")):
        wrench = share * acceleration(asm, (1, 0, 0))
        assert assess(asm, loads=wrench).outcome.word == static
        assert verify(asm, loads=wrench, settings=FAST).outcome.word == dynamic
        assert verify(asm, loads=[wrench], settings=FAST).outcome.word == dynamic


def test_one_load_is_a_load_and_no_wrench_is_none():
    one, listed = (verify(stack(2), loads=loads, settings=FAST) for loads in (Removal(1), [Removal(1)]))
    np.testing.assert_array_equal(one.run.displacement, listed.run.displacement)
    dry, nothing = (verify(stack(2), loads=loads, settings=FAST) for loads in ((), np.zeros((3, 6))))
    np.testing.assert_array_equal(dry.run.displacement, nothing.run.displacement)


@pytest.mark.parametrize(
    ("loads", "words"),
    [
        ([AngularSprings(5.0)], "is no load; loads are Constant, Tilt"),
        ([(1, 0, 0)], "is no load"),
        (np.ones((2, 6)), r"loads have shape \(2, 6\); finite values of shape \(3, 6\) are needed"),
        ([Constant((0.1, 0, 0)), np.full((3, 6), np.nan)], "finite values"),
    ],
)
def test_what_is_no_load_is_refused(loads, words):
    with pytest.raises(InputError, match=words):
        verify(stack(2), loads=loads)


def test_an_unknown_setting_is_refused_with_the_settings_there_are():
    with pytest.raises(InputError, match="no setting 'timestep'; settings are: time_step, quick_step"):
        Settings.named("fast", timestep=1e-3)
    assert dataclasses.replace(FAST, end=1.0) == Settings.named("fast", end=1.0)


@pytest.mark.parametrize(
    ("function", "options"),
    [
        (dynsim.verify, "settings, loads, actions, gap, interfaces, engine, statics, progress"),
        (dynsim.simulate, "settings, stop, loads, actions, hold, gap, interfaces, engine, progress"),
        (dynsim.limit, "loads, settings, width, check, gap, interfaces, progress"),
        (dynsim.compare, "settings, closely, engines, gap, interfaces, jobs, timeout, progress"),
        (dynsim.verify_many, "settings, loads, actions, interfaces, jobs, timeout, progress"),
        (dynsim.run_many, "names, jobs, timeout, progress"),
        (
            dynsim.optimise,
            "names, settings, jobs, under, conditions, options, strategy, over, margin, snap, points, imperfections, "
            "target, gap, answered",
        ),
        (dynsim.buttress_loop, "progress"),
        (
            dynsim.incremental,
            "measure, start, factor, up_to, resolution, beyond, confidence, loads, actions, settings, gap, interfaces, "
            "directory, jobs, progress",
        ),
        (blockstat.find_interfaces, "gap, near"),
        (blockstat.read, "supports, units, up"),
        (blockstat.write, "format, values, units, up"),
    ],
    ids=lambda value: value.__name__ if callable(value) else "",
)
def test_a_misspelt_option_is_refused_with_the_options_there_are(function, options):
    words = f'{function.__name__}: unknown option "sttings"; options are: {options}'
    with pytest.raises(InputError) as refused:
        function(stack(1), sttings=FAST)
    assert str(refused.value) == words


def test_the_program_refuses_a_file_that_does_not_exist():
    wrong = subprocess.run([sys.executable, "-m", "dynsim", "verify", "none.json"], capture_output=True, text=True)
    assert (wrong.returncode, wrong.stdout) == (2, "")
