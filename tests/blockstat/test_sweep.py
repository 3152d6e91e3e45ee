"""Sweeps: every design once, whatever dies on the way."""

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from importlib.util import module_from_spec, spec_from_file_location
from itertools import islice, product
from operator import itemgetter

import joblib
import numpy as np
import pytest

from blockstat import InputError, assess, build, with_values, write
from blockstat.design_search.sweep import grid, latin_hypercube, sweep, verdict_row
from blockstat.spec import parameters, scene_from
from evidence.scenes.small import HUT, assembly, box

SCENE = scene_from(HUT)
COUNTED = scene_from(HUT | {"vault": {"thickness": 0.3, "voussoirs": {"value": 7, "min": 5, "max": 9, "step": 2}}})


def slow_row(scene, memory):
    """As slow as it needs to be for something to die meanwhile."""
    time.sleep(0.05)
    return verdict_row(scene, memory)


def plain(rows):
    return [{k: v for k, v in row.items() if k != "seconds"} for row in rows]


def test_a_grid_is_every_combination_and_every_row_is_what_statics_say(tmp_path):
    designs = list(grid(SCENE))
    assert len({tuple(d.values()) for d in designs}) == len(designs) == 4 * 2
    result = sweep(SCENE, designs, tmp_path / "rows.jsonl", jobs=1)
    assert (result.designs, result.computed) == (8, 8)
    for row, values in zip(result.rows(), designs, strict=True):
        assembly = build(with_values(SCENE, values))
        assert {name: row[name] for name in values} == values
        assert row["static"] == assess(assembly).outcome.word
        assert row["volume"] == pytest.approx(assembly.volume[assembly.free].sum())


def test_the_first_designs_of_more_than_a_length_can_count_are_given():
    height = {"value": 3, "min": 2, "max": 3, "step": 0.01}
    piers = {f"p{k}": {"kind": "pier", "size": [1, 1], "courses": 2, "height": height} for k in range(10)}
    designs = [*islice(grid(scene_from({"name": "piers", "elements": piers})), 2)]
    assert [design["elements.p9.height"] for design in designs] == pytest.approx([3.0, 2.99])


def test_a_grid_is_a_sequence_that_can_be_gone_through_again(tmp_path):
    designs = grid(SCENE)
    lines = [found.steps() for found in parameters(SCENE).values()]
    combined = [dict(zip(parameters(SCENE), values, strict=True)) for values in product(*lines)]
    assert [*designs] == [*designs] == combined
    assert (len(designs), designs[5], designs[-1], designs[2:4]) == (8, combined[5], combined[-1], combined[2:4])
    with pytest.raises(IndexError):
        designs[8]
    assert sweep(SCENE, designs, tmp_path / "rows.jsonl", jobs=1).designs == 8


def test_a_sweep_of_no_designs_is_refused_and_leaves_no_file(tmp_path):
    gone = iter(grid(SCENE))
    assert len([*gone]) == 8
    for designs in ([], gone):
        with pytest.raises(InputError, match="there are no designs to sweep"):
            sweep(SCENE, designs, tmp_path / "rows.jsonl")
    assert not (tmp_path / "rows.jsonl").exists()


def test_a_latin_hypercube_puts_one_design_into_each_slice_of_each_range():
    designs = latin_hypercube(SCENE, 10, seed=3)
    for name, found in parameters(SCENE).items():
        share = (np.array([d[name] for d in designs]) - found.min) / (found.max - found.min)
        assert sorted(np.floor(10 * share)) == list(range(10))
    assert designs == latin_hypercube(SCENE, 10, seed=3) != latin_hypercube(SCENE, 10, seed=4)
    whole = {d["vault.voussoirs"] for d in latin_hypercube(COUNTED, 12)}
    assert whole == {5.0, 7.0, 9.0}


def test_many_processes_give_the_rows_of_one(tmp_path):
    designs = latin_hypercube(SCENE, 12)
    one = sweep(SCENE, designs, tmp_path / "one.jsonl", jobs=1, batch=3)
    two = sweep(SCENE, designs, tmp_path / "two.jsonl", jobs=2, batch=3)
    assert plain(one.rows()) == plain(two.rows())


def test_a_sweep_goes_on_where_it_stopped(tmp_path):
    designs = list(grid(SCENE))
    path = tmp_path / "rows.jsonl"
    whole = sweep(SCENE, designs, path, jobs=1, batch=2)
    lines = path.read_text().splitlines(keepends=True)
    for keep in (len(lines) - 1, 4, 1):
        path.write_text("".join(lines[:keep]) + lines[keep][:20])
        again = sweep(SCENE, designs, path, jobs=1, batch=2)
        assert again.computed == len(lines) - keep
        assert plain(again.rows()) == plain(whole.rows())
    assert sweep(SCENE, designs, path, jobs=1).computed == 0


def test_a_file_of_another_sweep_is_refused(tmp_path):
    path = tmp_path / "rows.jsonl"
    sweep(SCENE, list(grid(SCENE))[:1], path, jobs=1)
    with pytest.raises(InputError, match="rows of another sweep"):
        sweep(scene_from(HUT | {"length": 2.5}), grid(SCENE), path)
    with pytest.raises(InputError, match="row 0 is of another design"):
        sweep(SCENE, list(grid(SCENE))[1:3], path, jobs=1)
    path.write_text(path.read_text() + "{\n")
    with pytest.raises(InputError, match="a line is damaged"):
        sweep(SCENE, grid(SCENE), path)
    for data in (b"a table\nof something else", b"begun"):
        path.write_bytes(data)
        with pytest.raises(InputError, match="a line is damaged"):
            sweep(SCENE, grid(SCENE), path)
        assert path.read_bytes() == data
    with pytest.raises(InputError, match=r'no parameter "roof"; parameters are: wall\.thickness, vault\.thickness'):
        list(grid(SCENE, ["roof"]))


def scaled_row(factor, scene, memory):
    return {"scaled": factor * verdict_row(scene, memory)["volume"]}


def test_a_measure_may_be_a_part_of_a_function_and_needs_a_name(tmp_path):
    path, designs = tmp_path / "rows.jsonl", list(grid(SCENE))[:2]
    volumes = [row["volume"] for row in sweep(SCENE, designs, tmp_path / "plain.jsonl", jobs=1).rows()]
    rows = sweep(SCENE, designs, path, measure=partial(scaled_row, 2.0), jobs=1).rows()
    assert [row["scaled"] for row in rows] == [2.0 * volume for volume in volumes]
    assert sweep(SCENE, designs, path, measure=partial(scaled_row, 2.0), jobs=1).computed == 0
    with pytest.raises(InputError, match="rows of another sweep"):
        sweep(SCENE, designs, path, measure=partial(scaled_row, 3.0), jobs=1)
    with pytest.raises(InputError, match=r"measure is .* must be a function or a functools\.partial of one"):
        sweep(SCENE, designs, path, measure=itemgetter("volume"), jobs=1)


MEASURE = """def measure(scene, memory, more=1.0):
    return {"static": "stable", "value": more + 1.0}
"""


@pytest.mark.parametrize(("old", "new"), [("more=1.0", "more=2.0"), ("+ 1.0", "- 1.0")])
def test_an_edited_measure_is_another_sweep(tmp_path, old, new):
    def measure(text, name):
        path = tmp_path / f"{name}.py"
        path.write_text(text)
        spec = spec_from_file_location("measures", path)
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.measure

    path, designs = tmp_path / "rows.jsonl", list(grid(SCENE))[:1]
    [row] = sweep(SCENE, designs, path, measure=measure(MEASURE, "first"), jobs=1).rows()
    assert row["value"] == 2.0
    same = sweep(SCENE, designs, path, measure=measure(f"# Other lines.\n\n{MEASURE}", "same"), jobs=1)
    assert same.computed == 0
    with pytest.raises(InputError, match="rows of another sweep"):
        sweep(SCENE, designs, path, measure=measure(MEASURE.replace(old, new), "edited"), jobs=1)
    with pytest.raises(InputError, match="rows of another sweep"):
        sweep(SCENE, designs, path, measure=partial(measure(MEASURE, "bound"), more=1.0), jobs=1)


def measured_by(count, scene, memory):
    """Calls a function that is bound to it."""
    return {"static": "stable", "value": count(scene)}


def test_a_measure_that_has_no_name_of_its_own_is_refused_and_leaves_no_file(tmp_path):
    def inner(scene, memory):
        return {"static": "stable"}

    path, designs = tmp_path / "rows.jsonl", list(grid(SCENE))[:1]
    for measure in (lambda scene, memory: {}, inner, partial(measured_by, lambda scene: 1)):
        with pytest.raises(
            InputError, match=r"^measure is \".*<locals>.*\"; .*define a function with a name at the top"
        ):
            sweep(SCENE, designs, path, measure=measure, jobs=1)
    with pytest.raises(InputError, match="bound to it, which cannot be sent to processes"):
        sweep(SCENE, designs, path, measure=partial(measured_by, (value for value in ())), jobs=1)
    assert not path.exists()


def given_row(row, scene, memory):
    return row


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ({"design": 7}, 'measure gave the key "design", which a row has already'),
        ({"seconds": 7}, 'measure gave the key "seconds", which a row has already'),
        ({"vault.thickness": 7}, r'measure gave the key "vault\.thickness", which a row has already'),
        (None, "measure gave None; it must give a dict of values by name"),
        ([1.0], r"measure gave \[1\.0\]; it must give a dict"),
        ({"x": {1, 2}}, r"measure gave \{'x': \{1, 2\}\}; values must be numbers, text, True, False or None"),
    ],
)
def test_what_a_measure_may_not_give_is_named_and_leaves_no_file(tmp_path, row, words):
    path, designs = tmp_path / "rows.jsonl", [{"wall.thickness": 0.4}]
    with pytest.raises(InputError, match=words):
        sweep(SCENE, designs, path, measure=partial(given_row, row), jobs=1)
    assert not path.exists()


def test_a_measure_may_give_numbers_and_arrays_of_numpy(tmp_path):
    given = {"n": np.int64(2), "x": np.float32(0.5), "b": np.True_, "all": np.arange(3), "some": [np.int8(1)]}
    measure = partial(given_row, given)
    [row] = sweep(SCENE, list(grid(SCENE))[:1], tmp_path / "rows.jsonl", measure=measure, jobs=1).rows()
    assert {key: row[key] for key in given} == {"n": 2, "x": 0.5, "b": True, "all": [0, 1, 2], "some": [1]}


@pytest.mark.parametrize(
    ("designs", "words"),
    [
        (None, "designs is None; it must be a sequence of dicts of parameter values"),
        (3, "designs is 3; it must be a sequence"),
        ({"wall.thickness": 0.4}, r"designs is \{'wall\.thickness': 0\.4\}; it must be a sequence"),
        ([3], "design 0 is 3; designs must be a sequence of dicts"),
        ([{"wall.thickness": 0.4}, "wall"], "design 1 is 'wall'; designs must be"),
    ],
)
def test_what_is_no_design_is_told_by_its_number(tmp_path, designs, words):
    with pytest.raises(InputError, match=words):
        sweep(SCENE, designs, tmp_path / "rows.jsonl", jobs=1)


def test_rows_of_another_mesh_are_refused(tmp_path):
    path, vault = tmp_path / "rows.jsonl", tmp_path / "stones"
    width = {"value": 0.6, "min": 0.4, "max": 0.6, "step": 0.2}
    pier = {"kind": "pier", "size": [width, 0.5], "height": 1.0, "courses": 1, "at": [5, 0, 0]}
    scene = scene_from({"name": "s", "elements": {"stone": {"kind": "mesh", "file": str(vault)}, "pier": pier}})
    vault.mkdir()
    write(assembly([box((0, 0, 0), (1, 1, 1))], supports=[0]), vault)
    assert sweep(scene, grid(scene), path, jobs=1).failed == 0
    assert sweep(scene, grid(scene), path, jobs=1).computed == 0
    for file in vault.iterdir():
        file.unlink()
    write(assembly([box((0, 0, 0), (1, 1, 2))], supports=[0]), vault)
    with pytest.raises(InputError, match="rows of another sweep"):
        sweep(scene, grid(scene), path, jobs=1)


def test_a_design_that_cannot_be_built_is_a_row_with_its_reason(tmp_path):
    wide = {"width": {"value": 0.5, "min": 0.5, "max": 2.5, "step": 1.0}, "height": 0.5, "sill": 0.5}
    scene = scene_from(HUT | {"windows": {"south": wide}})
    rows = sweep(scene, grid(scene, ["windows.south.width"]), tmp_path / "rows.jsonl", jobs=1).rows()
    assert rows[0]["static"] == "error"
    assert rows[0]["note"].startswith("windows.south")


def endless_row(scene, memory):
    return {"least": -np.inf, "all": [np.nan, {"most": np.inf}], "note": "none"}


def refuse(constant):
    raise AssertionError(f"{constant} is no JSON")


def test_numbers_that_are_not_finite_are_words_in_the_file_and_numbers_in_rows(tmp_path):
    path, designs = tmp_path / "rows.jsonl", list(grid(SCENE))[:1]
    (row,) = sweep(SCENE, designs, path, measure=endless_row, jobs=1).rows()
    _, line = path.read_text().splitlines()
    assert json.loads(line, parse_constant=refuse)["least"] == "-Infinity"
    assert (row["least"], row["all"][1], row["note"]) == (-np.inf, {"most": np.inf}, "none")
    assert np.isnan(row["all"][0])
    # A file of before says them bare.
    path.write_text(path.read_text().replace('"-Infinity"', "-Infinity").replace('"NaN"', "NaN"))
    kept = sweep(SCENE, designs, path, measure=endless_row, jobs=1)
    assert kept.computed == 0
    assert kept.rows()[0]["least"] == -np.inf
    assert np.isnan(kept.rows()[0]["all"][0])


def failing_row(scene, memory):
    if scene.wall.thickness.value < 0.5:
        raise ZeroDivisionError("too thin")
    return {}


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_measure_that_fails_names_the_design(tmp_path, jobs):
    path = tmp_path / "rows.jsonl"
    designs = [{"wall.thickness": thickness} for thickness in (0.6, 0.4)]
    told = r"measure raised ZeroDivisionError at design 1 \(wall\.thickness 0\.4\): too thin"
    with pytest.raises(RuntimeError, match=told) as raised:
        sweep(SCENE, designs, path, measure=failing_row, jobs=jobs)
    assert "ZeroDivisionError" in repr(raised.value.__cause__)
    assert not path.exists()  # so that the measure can be mended


KILLED = """
import sys
from blockstat.design_search.sweep import latin_hypercube, sweep
from test_sweep import SCENE, slow_row
sweep(SCENE, latin_hypercube(SCENE, 40), sys.argv[1], measure=slow_row, jobs=2, batch=2)
"""


@pytest.mark.slow
def test_after_a_kill_no_row_is_lost_and_none_is_doubled(tmp_path):
    path = tmp_path / "rows.jsonl"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(path)], env=environment, stderr=subprocess.DEVNULL, start_new_session=True
    )
    while process.poll() is None and not (path.is_file() and path.read_text().count("\n") > 6):
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = path.read_text().count("\n") - 1
    assert 0 < kept < 40
    result = sweep(SCENE, latin_hypercube(SCENE, 40), path, measure=slow_row, jobs=1)
    assert result.computed == 40 - kept
    assert [row["design"] for row in result.rows()] == list(range(40))


@pytest.mark.slow
def test_a_worker_of_a_cluster_killed_in_the_middle_loses_no_row(tmp_path):
    distributed = pytest.importorskip("distributed")
    path = tmp_path / "rows.jsonl"
    killed = []

    def kill_one(rows):
        if not killed and rows > 6:
            killed.extend(client.run(os.getpid).values())
            os.kill(killed[0], signal.SIGKILL)

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        client.run(sys.path.extend, [p for p in sys.path if p])
        with joblib.parallel_config(backend="dask"):
            result = sweep(SCENE, latin_hypercube(SCENE, 40), path, measure=slow_row, batch=2, progress=kill_one)
    assert killed
    numbers = [json.loads(line)["design"] for line in path.read_text().splitlines()[1:]]
    assert sorted(numbers) == list(range(40))
    assert result.computed == 40
    alone = sweep(SCENE, latin_hypercube(SCENE, 40), tmp_path / "alone.jsonl", measure=slow_row, jobs=1, batch=2)
    assert plain(alone.rows()) == plain(result.rows())


def test_a_sweep_tells_how_many_rows_are_done_those_of_before_too(tmp_path):
    designs, path, told = list(grid(SCENE))[:3], tmp_path / "rows.jsonl", []
    sweep(SCENE, designs[:1], path, jobs=1)
    sweep(SCENE, designs, path, jobs=1, batch=1, progress=told.append)
    assert told == [2, 3]


def test_what_cannot_be_swept_is_named():
    for number in (0, -3, 2.5):
        with pytest.raises(InputError, match=f"number is {number}; it must be a whole number of at least 1"):
            latin_hypercube(SCENE, number)
    with pytest.raises(InputError, match="seed is -1; it must be a whole number of at least 0"):
        latin_hypercube(SCENE, 2, seed=-1)
    fixed = scene_from(HUT | {"wall": {"thickness": 0.5, "height": 1.5}, "vault": {"thickness": 0.3, "voussoirs": 7}})
    for designs in (lambda: latin_hypercube(fixed, 2), lambda: list(grid(fixed))):
        with pytest.raises(
            InputError, match=r'"hut" has no parameter to sweep; write one as \{value, min, max, step\}'
        ):
            designs()


@pytest.mark.parametrize("options", [{"batch": 0}, {"batch": -1}, {"batch": 1.5}, {"jobs": 0}, {"jobs": -1}])
def test_a_sweep_without_a_process_or_a_design_at_a_time_is_refused(tmp_path, options):
    (name, value), path = *options.items(), tmp_path / "rows.jsonl"
    with pytest.raises(InputError, match=f"{name} is {value}; it must be a whole number of at least 1"):
        sweep(SCENE, grid(SCENE), path, **options)
    assert not path.exists()


def test_a_sweep_into_no_directory_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such directory"):
        sweep(SCENE, grid(SCENE), tmp_path / "none" / "rows.jsonl", jobs=1)
    with pytest.raises(InputError, match="is a directory; a file is needed"):
        sweep(SCENE, grid(SCENE), tmp_path, jobs=1)


def test_of_a_file_with_more_rows_only_those_of_the_designs_that_are_asked_count(tmp_path):
    path = tmp_path / "rows.jsonl"
    good, bad = list(grid(SCENE))[:2], [{"wall.thickness": thickness} for thickness in (9.0, 8.0)]
    everything = sweep(SCENE, [*good, *bad], path, jobs=1)
    assert (everything.outcome.word, everything.failed, len(everything.rows())) == ("complete", 2, 4)
    again = sweep(SCENE, good, path, jobs=1)
    assert (again.outcome.word, again.failed, again.reasons) == ("resumed", 0, "")
    assert again.rows() == everything.rows()[:2]


def test_a_design_with_an_unknown_parameter_is_named_each_time(tmp_path):
    path, designs = tmp_path / "rows.jsonl", [*list(grid(SCENE))[:1], {"roof": 1.0}]
    for _ in range(2):
        with pytest.raises(InputError, match=r'no parameter "roof"; parameters are: wall\.thickness'):
            sweep(SCENE, designs, path, jobs=1, batch=1)
    assert sweep(SCENE, designs[:1], path, jobs=1).computed == 0


#: A hut of a length from 2 to 4 m.
LONG = scene_from({"name": "hut", "length": {"value": 3, "min": 2, "max": 4, "step": 1}, "span": 2.0})


@pytest.mark.parametrize("length", [np.int64(3), np.float32(3), np.float64(3), 3])
def test_numbers_of_numpy_have_the_row_of_plain_ones(length, tmp_path):
    for computed in (1, 0):
        result = sweep(LONG, [{"length": length}], tmp_path / "rows.jsonl", jobs=1)
        assert result.computed == computed
        assert [(row["length"], row["static"]) for row in result.rows()] == [(3.0, "stable")]


@pytest.mark.parametrize("length", ["3", "long", None, [3], float("nan"), 10**400])
def test_what_is_no_number_is_told_by_its_parameter(length, tmp_path):
    with pytest.raises(InputError, match=r"^length"):
        sweep(LONG, [{"length": length}], tmp_path / "rows.jsonl", jobs=1)
    with pytest.raises(InputError, match=r"^length"):
        with_values(LONG, {"length": length})


def test_true_and_false_are_values_of_a_presence():
    vaulted = scene_from({"name": "hut", "length": 3.0, "span": 2.0, "vault": {"present": "search"}})
    for there in (True, False, np.True_):
        assert with_values(vaulted, {"vault.present": there}).vault.present.value == float(there)
