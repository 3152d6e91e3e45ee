"""Incremental dynamic analysis (Vamvatsikos & Cornell 2002) of a rocking block, and what it keeps."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

from blockstat import Assembly, InputError, InputWarning, box, write
from blockstat.system.lock import locked
from dynsim import AngularSprings, InertiaScale, Pulse, Ramp, Record, Settings, incremental, plot_incremental, verify
from dynsim.cli.commands import app
from dynsim.earthquake.hunt import Hunt, bracket
from dynsim.earthquake.motion import intensity_of
from dynsim.earthquake.runs import digest
from pool_tasks import DiesWhenMoved, Warns

G = 9.81
DOWN = np.array([0, 0, -G])
WIDTH, HEIGHT = 0.25, 2.0
SLOPE = WIDTH / HEIGHT  #: tangent of the slenderness: the block rocks from this share of gravity on
FREQUENCY = np.sqrt(3 * G / (2 * np.hypot(WIDTH, HEIGHT)))  #: p of Housner [1/s]


def pillar(width=WIDTH, height=HEIGHT, **options):
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (width, 1, height), name="pillar")]
    return Assembly.from_blocks(blocks, supports=["ground"], **{"friction": 2.0, "gravity": DOWN} | options)


def sine(ratio):
    """One period of a sine of 1 g, its circular frequency in units of p."""
    return Pulse((G, 0, 0), 2 * np.pi / (ratio * FREQUENCY), "sine")


def topples(intensity, ratio):
    """Whether the block topples under such a pulse: Housner's equation of rocking with full angles, integrated.

    Housner (1963); Zhang & Makris (2001): p^-2 theta'' = -sin(alpha sgn theta - theta) - a / g cos(alpha sgn theta -
    theta), and each impact leaves 1 - 3/2 sin^2 alpha of the angular velocity.
    """
    alpha, duration = np.arctan(SLOPE), sine(ratio).duration
    side = -1.0

    def rate(t, state):
        lean = alpha * side - state[0]
        ground = intensity * np.sin(2 * np.pi * t / duration) if t < duration else 0.0
        return [state[1], -(FREQUENCY**2) * (np.sin(lean) + ground * np.cos(lean))]

    def impact(t, state):
        return state[0] * side if t > since else 1.0

    def over(t, state):
        return abs(state[0]) - 1.4

    impact.terminal, impact.direction, over.terminal = True, -1, True
    now, state, last = duration * np.arcsin(SLOPE / intensity) / (2 * np.pi), np.zeros(2), duration + 5.0
    while now < last:
        since = now + 1e-6
        end = duration if now < duration - 1e-9 else last  # the pulse ends with a kink
        found = solve_ivp(rate, (now, end), state, events=[impact, over], rtol=1e-8, atol=1e-10, max_step=duration / 20)
        now, state = found.t[-1], found.y[:, -1]
        if len(found.t_events[1]):
            return True
        if len(found.t_events[0]):
            state = np.array([0.0, (1 - 1.5 * np.sin(alpha) ** 2) * state[1]])
            side = np.sign(state[1])
            if abs(state[1]) < 1e-3:
                return False
    return False


@pytest.mark.parametrize("ratio", [2.0, pytest.param(6.0, marks=pytest.mark.slow)])
def test_a_sine_pulse_topples_a_block_as_the_equation_of_rocking_says(ratio):
    # Within 2 % beside the bracket, as for rectangular pulses.
    options = {"start": 1.05 * SLOPE, "factor": 1.5, "resolution": 0.02, "beyond": 0, "jobs": 1}
    (curve,) = incremental(pillar(), [sine(ratio)], **options).curves
    assert 0.98 * curve.upper <= curve.lower < curve.upper
    assert not topples(0.98 * curve.lower, ratio)
    assert topples(1.02 * curve.upper, ratio)


def test_a_block_that_stands_again_under_more_is_told():
    # Zhang & Makris (2001): between toppling with an impact and toppling without one there is a gap, here at 1.5 g.
    ratio, steps = 7.0, (0.375, 0.75, 1.5, 3.0)
    expected = [topples(step, ratio) for step in steps]
    assert expected == [False, True, False, True]
    options = {"start": steps[0], "factor": 2.0, "up_to": 3.0, "resolution": 0.5, "beyond": 2, "jobs": 1}
    found = incremental(pillar(), {"short": sine(ratio)}, **options)
    (curve,) = found.curves
    assert {run.intensity: run.fell for run in curve.runs} == dict(zip(steps, expected, strict=True))
    assert (curve.lower, curve.upper, curve.resurrections) == (0.375, 0.75, (1.5,))
    assert "short: stands again at 1.5 g" in found.explain()
    assert found.summary()["records"][0]["resurrections"] == [1.5]


@pytest.mark.parametrize("limit", [0.03, 0.05, 0.2, 0.731, 2.9])
def test_a_hunt_brackets_the_limit_and_goes_on_from_any_run(limit):
    hunt = Hunt(start=0.05, factor=1.5, up_to=3.0, resolution=0.05, beyond=2)
    known = {}
    while (intensity := hunt.following(known)) is not None:
        assert intensity not in known
        known[intensity] = intensity > limit
    low, high = bracket(known)
    assert low <= limit < high
    assert high - low <= 0.05 * max(high, 0.05)
    # To a twentieth of the interval below the first step five halvings are needed, four elsewhere.
    assert len(known) <= sum(step <= limit for step in hunt.steps) + 1 + (5 if limit < 0.05 else 4) + hunt.beyond
    asked = list(known)
    for count, (_, after) in enumerate(pairwise(asked), start=1):
        assert hunt.following({at: known[at] for at in asked[:count]}) == after


@pytest.mark.parametrize("finer", [{"factor": 1.1}, {"start": 0.16, "factor": 1.9}], ids=["factor", "start"])
def test_a_hunt_by_shorter_steps_goes_on_from_another_and_sees_what_that_passed_over(finer):
    # A block falls from .28 to .33 and above .6; the steps .1, .2, .4, .8 pass over the first.
    def go_on(hunt, known):
        known = dict(known)
        while (intensity := hunt.following(known)) is not None:
            known[intensity] = 0.28 <= intensity < 0.33 or intensity > 0.6
        return known

    options = {"start": 0.1, "factor": 2.0, "up_to": 1.6, "resolution": 0.05, "beyond": 0}
    before = go_on(Hunt(**options), {})
    assert bracket(before)[0] <= 0.6 < bracket(before)[1]
    resumed, fresh = go_on(Hunt(**options | finer), before), go_on(Hunt(**options | finer), {})
    assert bracket(fresh)[1] < 0.33
    for known in (resumed, fresh):
        low, high = bracket(known)
        assert low < 0.28 <= high
        assert high - low <= 0.05 * high


def test_a_hunt_without_a_fall_ends_at_the_greatest_intensity():
    hunt, known = Hunt(start=0.05, factor=2.0, up_to=0.3, resolution=0.05, beyond=2), {}
    while (intensity := hunt.following(known)) is not None:
        known[intensity] = False
    assert list(known) == [0.05, 0.1, 0.2, 0.3]
    assert bracket(known) == (0.3, np.inf)


def test_intensity_measures_count_what_is_horizontal():
    pulse = Pulse((3.0, 4.0, 50.0), 0.5, "sine", start=0.3)
    assert intensity_of(pulse, DOWN, "pga") == pytest.approx(5.0 / G, rel=1e-6)
    assert intensity_of(pulse, DOWN, "pgv") == pytest.approx(5.0 * 0.5 / np.pi, rel=1e-5)  # a T / pi
    record = Record([0.0, 1.0, 3.0], [[0, 0, 9.0], [0, 2.0, 0], [0, 0, 0]])
    assert intensity_of(record, DOWN, "pga") == pytest.approx(2.0 / G)
    assert intensity_of(record, DOWN, "pgv") == pytest.approx(1.0 + 2.0)  # two triangles
    assert intensity_of(record, [-5.0, 0, 0], "pga") == pytest.approx(9.0 / G)  # down is -x
    back = Record([0.0, 1.0, 2.0, 3.0], [[0, 0, 0], [4.0, 0, 0], [-4.0, 0, 0], [0, 0, 0]])
    assert intensity_of(back, DOWN, "pgv") == pytest.approx(3.0)  # at 1.5 s, where the acceleration is 0


def test_records_of_other_strength_meet_at_the_same_intensity():
    options = {"start": 0.2, "factor": 2.0, "resolution": 0.5, "beyond": 0, "jobs": 1}
    weak = Record([0.0, 0.25, 0.5], np.outer([0.0, 1.0, 0.0], [1.0, 0, 0]))
    strong = Record([0.0, 0.25, 0.5], np.outer([0.0, 8.0, 0.0], [1.0, 0, 0]))
    one, other = incremental(pillar(), {"weak": weak, "strong": strong}, **options).curves
    assert [run.intensity for run in one.runs] == [run.intensity for run in other.runs]
    assert [run.scale for run in one.runs] == pytest.approx([8 * run.scale for run in other.runs])
    assert (one.lower, one.upper) == (other.lower, other.upper)


FAST = Settings.named("fast")
QUICK = {"start": 0.1, "factor": 2.0, "resolution": 0.25, "beyond": 0, "jobs": 2, "settings": FAST}
STOCKY = pillar(width=0.5)  #: it soon stops rocking
PULSES = {f"pulse{k}": Pulse((G, 0, 0), length, "sine") for k, length in enumerate((0.4, 0.6, 0.9))}


@pytest.fixture(scope="module")
def analysis():
    return incremental(STOCKY, PULSES, **QUICK)


def told(found):
    """What an analysis found, without the time that it took."""
    return [
        (curve.name, [(run.intensity, run.outcome, run.max_displacement, run.max_rotation) for run in curve.runs])
        for curve in found.curves
    ]


def test_the_result_says_what_fell_and_how_likely(analysis):
    assert analysis.outcome.word == "collapse"
    fitted = analysis.fragility()
    np.testing.assert_array_equal(fitted.upper, [curve.upper for curve in analysis.curves])
    assert analysis.curves[0].upper > analysis.curves[2].upper  # a longer pulse topples at less
    assert all(curve.first_block == "pillar" for curve in analysis.curves)
    summary = analysis.summary()
    json.dumps(summary, allow_nan=False)
    assert summary["fragility"]["median"] == fitted.median
    assert analysis.fragility(confidence=0.5).median_interval[0] > fitted.median_interval[0]


def test_a_second_call_goes_on_and_a_finer_one_only_adds(tmp_path, analysis):
    first = incremental(STOCKY, PULSES, directory=tmp_path, **QUICK)
    assert told(first) == told(analysis)
    file, again = tmp_path / "runs.jsonl", []
    file.write_bytes(file.read_bytes()[:-20])  # a line cut short costs that run alone
    assert told(incremental(STOCKY, PULSES, directory=tmp_path, progress=again.append, **QUICK)) == told(first)
    assert len(again) == 1
    finer = incremental(STOCKY, PULSES, directory=tmp_path, progress=again.append, **QUICK | {"resolution": 0.2})
    assert len(again) > 1
    for coarse, fine in zip(first.curves, finer.curves, strict=True):
        assert coarse.lower <= fine.lower < fine.upper <= coarse.upper
        assert fine.upper - fine.lower <= 0.2 * fine.upper


def test_a_directory_of_something_else_is_refused_and_kept(tmp_path):
    incremental(STOCKY, PULSES, directory=tmp_path, **QUICK | {"up_to": 0.1})
    before = (tmp_path / "runs.jsonl").read_bytes()
    for other, options in (
        (pillar(width=0.3), {}),
        (STOCKY.with_(friction=0.8), {}),
        (STOCKY, {"settings": Settings()}),
        (STOCKY, {"measure": "pgv"}),
        (STOCKY, {"actions": [InertiaScale(2.0)]}),
    ):
        with pytest.raises(InputError, match=r"runs\.jsonl: these are runs of another scene, other settings or"):
            incremental(other, PULSES, directory=tmp_path, **QUICK | options)
    changed = PULSES | {"pulse1": Pulse((G, 0, 0), 0.61, "sine")}
    with pytest.raises(InputError, match=r'its runs of "pulse1" are of another record'):
        incremental(STOCKY, changed, directory=tmp_path, **QUICK)
    with locked(tmp_path), pytest.raises(InputError, match="writes there"):
        incremental(STOCKY, PULSES, directory=tmp_path, **QUICK)
    assert (tmp_path / "runs.jsonl").read_bytes() == before


def test_what_verdicts_warn_of_is_told_once_and_kept(tmp_path):
    # The cube is drawn 8 mm above the ground: a joint to statics, which is closed for Bullet.
    blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0.008), (1, 1, 1.008), name="cube")]
    asm = Assembly.from_blocks(blocks, supports=["ground"])
    for _ in range(2):
        found = incremental(asm, {"weak": PULSES["pulse0"]}, directory=tmp_path, **QUICK | {"up_to": 0.2, "jobs": 1})
        (text,) = found.warnings
        assert text.startswith("1 joints that statics count as closed were open or overlapped")
        assert found.explain().count(text) == 1
        assert [run.warnings for run in found.curves[0].runs] == [(text,)] * 2


def test_an_action_that_has_acted_is_the_same():
    springs = AngularSprings(50.0)
    before = digest(springs)
    verify(STOCKY, settings=FAST, actions=[springs])
    assert digest(springs) == before != digest(AngularSprings(51.0))


def test_a_fall_of_a_group_alone_names_no_block(analysis):
    curve = analysis.curves[0]
    runs = tuple(replace(run, first_block=None) for run in curve.runs)
    found = replace(analysis, curves=(replace(curve, runs=runs),))
    assert f"falls at {curve.upper:.4g} g (" in found.explain()


def test_a_process_that_dies_costs_its_record_alone():
    # The weak pulse moves nothing up to the greatest intensity; the strong one kills its process at the first rocking.
    pulses = {"weak": Pulse((0, G, 0), 0.02, "sine"), "strong": PULSES["pulse2"]}
    found = incremental(STOCKY, pulses, actions=[DiesWhenMoved()], up_to=0.4, **QUICK)
    weak, strong = found.curves
    assert found.outcome.word == "incomplete"
    assert weak.complete
    assert weak.lower == 0.4
    assert strong.error == "its process ended by itself (status 3)"
    assert "strong: its process ended by itself" in found.explain()
    assert "No fragility: 2 records; at least three are needed." in found.explain()


def test_what_falls_without_a_record_needs_none():
    blocks = [box((-1, -1, -1), (0.1, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="leans")]
    found = incremental(Assembly.from_blocks(blocks, supports=["ground"]), PULSES, **QUICK)
    assert found.outcome.word == "falls_at_rest"
    assert found.explain() == found.outcome.value


def test_records_that_fell_nothing_are_censored():
    found = incremental(STOCKY, PULSES, **QUICK | {"up_to": 0.15})
    assert found.outcome.word == "stands"
    assert all(curve.upper == np.inf and curve.lower == 0.15 for curve in found.curves)
    assert found.summary()["fragility"] is None
    assert "0 of 3 records fell a block" in found.summary()["no_fragility"]


def test_the_picture_has_the_curves_and_the_fragility(analysis, tmp_path):
    figure = Figure()
    plot_incremental(analysis, figure)
    curves, fragility = figure.axes
    levels = {line.get_ydata()[-1] for line in curves.lines if line.get_linestyle() == "-"}
    assert {curve.upper for curve in analysis.curves} <= levels
    at, probability = max((line.get_data() for line in fragility.lines), key=lambda data: len(data[0]))
    np.testing.assert_allclose(probability, analysis.fragility().probability(at))
    plot_incremental(analysis, tmp_path / "ida.svg")
    assert (tmp_path / "ida.svg").read_text().count("<path") > 20
    with pytest.raises(InputError, match="no picture is written as"):
        plot_incremental(analysis, tmp_path / "ida.xyz")


@pytest.mark.parametrize(
    ("records", "options", "words"),
    [
        ([], {}, "no records; at least one is needed"),
        ({"a": Ramp((1.0, 0, 0), 1.0)}, {}, r'"a" is Ramp\(.*\); what is scaled is a Record or a Pulse'),
        ({"up": Pulse((0, 0, 5.0), 1.0)}, {}, '"up" has no horizontal motion, so its PGA is 0'),
        (PULSES, {"start": 0.0}, r"start is 0\.0; it must be above 0"),
        (PULSES, {"factor": 1.0}, r"factor is 1\.0; it must be above 1"),
        (PULSES, {"factor": 1.0001}, "that is more than 200 steps"),
        (PULSES, {"up_to": 0.01}, r"up_to is 0\.01; it must be at least start"),
        (PULSES, {"resolution": 1.5}, r"resolution is 1\.5; it must be from 0\.001 to below 1"),
        (PULSES, {"beyond": -1}, "beyond is -1; it must be a whole number"),
        (PULSES, {"confidence": 95}, "confidence is 95; it must be between 0 and 1"),
        (PULSES, {"measure": "sa"}, "measure is 'sa'; it must be one of: pga, pgv"),
        (PULSES, {"jobs": 0}, "jobs is 0; it must be a whole number of at least 1"),
    ],
)
def test_bad_input_is_one_sentence(records, options, words):
    with pytest.raises(InputError, match=words) as refused:
        incremental(STOCKY, records, **options)
    assert len(refused.value.args) == 1


def test_a_scene_that_cannot_be_simulated_is_refused():
    free = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    with pytest.raises(InputError, match="support"):
        incremental(free, PULSES, **QUICK)


COMMAND = ("--factor", "2", "--resolution", "0.2", "--beyond", "0", "--preset", "fast", "--json")


def arguments(folder):
    """The command on a pillar and three records, whose files are written."""
    write(STOCKY, folder / "pillar.json")
    times = np.arange(0, 1.0, 0.01)
    words = ["ida", str(folder / "pillar.json"), "--scale", "9.81", *COMMAND]
    for name, pulse in PULSES.items():
        rows = np.column_stack([times, [pulse.at(time)[0] / G for time in times]])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",")
        words += ["--record", str(folder / f"{name}.csv")]
    return words


def started(folder, *options):
    """The command in a process of its own."""
    words = [sys.executable, "-m", "dynsim", *arguments(folder), *options]
    return subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def timeless(value):
    """Plain values without process times and the file."""
    if isinstance(value, dict):
        return {key: timeless(part) for key, part in value.items() if "seconds" not in key and key != "file"}
    return [timeless(part) for part in value] if isinstance(value, list) else value


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    process = started(tmp_path_factory.mktemp("whole"), "--plot", "ida.png")
    out, err = process.communicate()
    assert process.returncode == 0, err
    found = json.loads(out)
    assert found.pop("plot") == "ida.png"
    return timeless(found)


@pytest.mark.parametrize(
    ("sign", "stops"),
    [(signal.SIGINT, (5,)), pytest.param(signal.SIGKILL, (2, 7, 12), marks=pytest.mark.slow)],
    ids=["SIGINT", "SIGKILL"],
)
def test_stopped_no_run_is_lost_and_the_result_is_the_same(tmp_path, whole, sign, stops):
    file, kept = tmp_path / "out" / "runs.jsonl", b""
    for rows in stops:
        process = started(tmp_path, "--output", "out")
        while process.poll() is None and not (file.is_file() and file.read_bytes().count(b"\n") > rows):
            time.sleep(0.01)
        assert process.poll() is None
        os.kill(process.pid, sign)
        out, err = process.communicate()
        assert "Traceback" not in err
        if sign is signal.SIGINT:
            assert process.returncode == 130
            assert json.loads(out)["finished"] is False
        assert file.read_bytes().startswith(kept)
        kept = file.read_bytes()[: file.read_bytes().rfind(b"\n") + 1]
    process = started(tmp_path, "--output", "out")
    out, err = process.communicate()
    assert process.returncode == 0, err
    assert timeless(json.loads(out)) == whole
    assert file.read_bytes().startswith(kept)
    asked = [(row["record"], row["intensity"]) for row in map(json.loads, file.read_text().splitlines()[1:])]
    assert len(asked) == len(set(asked)) == 1 + sum(len(record["runs"]) for record in whole["records"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--record", "pulse0.csv", "--record", "pulse0.csv"), r"--record pulse0\.csv is given twice"),
        (("--record", "gone.csv"), r"gone\.csv: no such file"),
        (("--plot", "ida.xyz"), r'ida\.xyz: no picture is written as "\.xyz"'),
        (("--direction", "0,0,1"), '"pulse0" has no horizontal motion'),
        (("--direction", "0,0"), '--direction is "0,0"; it must read X,Y,Z'),
        (("--output", "pillar.json"), r"pillar\.json: this file is read"),
        (("--resolution", "0"), "resolution is 0.0; it must be from 0.001"),
    ],
)
def test_the_command_refuses_bad_input(tmp_path, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    given = arguments(tmp_path)
    if (option := options[0]) in given and option != "--record":  # in the place of the value
        at = given.index(option)
        del given[at : at + 2]
    with pytest.raises(InputError, match=words):
        app([*given, *options], standalone_mode=False)


def test_a_record_is_given_once_however_its_file_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"--record pulse0\.csv is given twice"):
        app([*arguments(tmp_path), "--record", "pulse0.csv"], standalone_mode=False)


def test_bad_input_ends_with_one_line_and_status_2(tmp_path):
    process = started(tmp_path, "--factor", "0.5")
    out, err = process.communicate()
    assert (process.returncode, out) == (2, "")
    assert err == "dynsim: incremental: factor is 0.5; it must be above 1\n"


def test_a_fall_at_rest_that_is_kept_needs_no_run(tmp_path):
    blocks = [box((-1, -1, -1), (0.1, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="leans")]
    leaning = Assembly.from_blocks(blocks, supports=["ground"])
    first = incremental(leaning, PULSES, directory=tmp_path, **QUICK)
    before, runs = (tmp_path / "runs.jsonl").read_bytes(), []
    again = incremental(leaning, PULSES, directory=tmp_path, progress=runs.append, **QUICK)
    assert (first.outcome.word, again.outcome.word) == ("falls_at_rest", "falls_at_rest")
    assert runs == []
    assert (tmp_path / "runs.jsonl").read_bytes() == before


def test_a_creep_at_rest_is_a_warning(analysis):
    creeping = replace(analysis, at_rest="creeps")
    assert creeping.warnings == (*analysis.warnings, "without a record blocks neither rest nor fall: they creep")
    assert "they creep" in creeping.explain()
    assert "they creep" not in analysis.explain()


def test_what_all_runs_warn_of_is_told_once():
    weak = {name: Pulse((0, G, 0), 0.02, "sine") for name in ("a", "b")}
    with pytest.warns(InputWarning, match="cracked already") as told:
        incremental(STOCKY, weak, actions=[Warns("cracked already")], **QUICK | {"up_to": 0.1})
    assert [str(one.message) for one in told if "cracked" in str(one.message)] == ["cracked already"]


def test_without_a_run_at_rest_there_is_no_analysis():
    with pytest.raises(InputError, match=r"its process ended by itself \(status 4\)"):
        incremental(STOCKY, PULSES, actions=[Warns("", dies=True)], **QUICK | {"jobs": 1})


class Lasting:
    """A load of a user's own that is there throughout."""

    each_step, travel, end = False, 0.0, float("-inf")

    def __init__(self, strength):
        self.strength = strength

    def begin(self, world):
        pass

    def act(self, world, time):
        pass


def test_what_a_load_is_made_of_tells_the_runs_under_it_from_others(tmp_path):
    options = QUICK | {"up_to": 0.1, "jobs": 1}
    pulses = {"weak": PULSES["pulse0"]}
    first = incremental(STOCKY, pulses, directory=tmp_path, loads=[Lasting(1.0)], **options)
    again = incremental(STOCKY, pulses, directory=tmp_path, loads=[Lasting(1.0)], **options)
    assert told(again) == told(first)
    with pytest.raises(InputError, match="these are runs of another scene"):
        incremental(STOCKY, pulses, directory=tmp_path, loads=[Lasting(2.0)], **options)
