"""Work on dask's distributed scheduler: a worker that is killed loses nothing and changes nothing."""

import contextlib
import json
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import joblib
import numpy as np
import pytest

from blockstat import (
    Plan,
    Random,
    Step,
    assess_plan,
    assess_stages,
    assess_states,
    build_by_courses,
    fragility,
    grid,
    latin_hypercube,
    parameters,
    reliability,
    scene_from,
    sweep,
)  # fmt: skip
from blockstat.errors import InputError
from blockstat.model import arch, assemble
from blockstat.system.workers import count_workers

distributed = pytest.importorskip("distributed")
KILLED = distributed.scheduler.KilledWorker

#: Where a worker is killed, dask starts another, and now and then it does not: such tests are slow ones.
TIMEOUT = 60  # [s]
SIDE = (1, 0, 0)
RING = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=9, springers=0.3))
#: A draw has a number for each joint and for each shared corner: a batch of them is an array of several kilobytes.
UNCERTAIN = {"friction": Random("lognormal", 0.6, 0.1, each="joint"), "corner": Random("normal", 0.0, 0.003)}


POSTS = scene_from(
    {
        "name": "post",
        "parameters": {"h": {"value": 1.0, "min": 1.0, "max": 2.0, "step": 0.2}},
        "elements": {"post": {"kind": "pier", "size": [0.5, 0.5], "height": "= h", "courses": 2}},
    }
)


def survived(scene, memory):
    """A measure that kills its worker at the last of six designs, when the others are done."""
    if parameters(scene)["parameters.h"].value > 1.9:
        time.sleep(1.0)
        os.kill(os.getpid(), signal.SIGKILL)
    return {"static": "stable"}


def slow(scene, memory):
    """A measure that takes long enough for its worker to be killed in the middle."""
    time.sleep(0.2)
    return {"static": "stable", "height": parameters(scene)["parameters.h"].value}


def workers_inside(scene, memory):
    return {"static": "stable", "inside": count_workers(None)}


@pytest.fixture(scope="module")
def cluster():
    """Two workers on this machine; those that are started again find the tests, too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join(path for path in sys.path if path))
        options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": 50}
        with distributed.LocalCluster(**options) as found:
            yield found


@pytest.fixture
def client(cluster):
    with distributed.Client(cluster) as found:
        found.wait_for_workers(2, timeout=TIMEOUT)
        yield found


class Killer(distributed.diagnostics.plugin.SchedulerPlugin):
    """Kills a worker in the middle of a task, once some tasks are done."""

    name = "killer"

    def __init__(self, client, scheduler, after: int) -> None:
        self._scheduler, self._after = scheduler, after
        self._process = client.run(os.getpid)
        self.done: list[str] = []
        self.lost: list[str] = []  #: tasks that the killed worker had

    def transition(self, key, start, finish, *args, **kwargs) -> None:
        if start == "processing" and finish == "memory":
            self.done.append(str(key))
        if len(self.done) >= self._after and not self.lost:
            for worker in self._scheduler.workers.values():
                if worker.processing and worker.address in self._process:
                    self.lost = [str(task.key) for task in worker.processing]
                    os.kill(self._process[worker.address], signal.SIGKILL)
                    return


@contextlib.contextmanager
def one_killed(client, cluster, after: int = 1):
    """Under dask, with a worker that is killed in the middle; what it had is done by others."""
    killer = Killer(client, cluster.scheduler, after)
    cluster.scheduler.add_plugin(killer)
    try:
        with joblib.parallel_config(backend="dask"):
            yield
    finally:
        cluster.scheduler.remove_plugin(killer.name)
    assert killer.lost
    assert set(killer.lost) <= set(killer.done)


@pytest.mark.slow
def test_a_killed_worker_loses_no_draw_of_a_reliability_and_changes_none(client, cluster, tmp_path):
    uncertain = UNCERTAIN | {"push": Random("normal", 0.25, 0.1)}
    alone = reliability(RING, uncertain, load=SIDE, draws=100, file=tmp_path / "alone.jsonl")
    with one_killed(client, cluster):
        found = reliability(RING, uncertain, load=SIDE, draws=100, file=tmp_path / "draws.jsonl")

    def outcomes(name):
        rows = [json.loads(line) for line in (tmp_path / name).read_text().splitlines()[1:]]
        return sorted((row["draw"], row["outcome"]) for row in rows)

    assert outcomes("draws.jsonl") == outcomes("alone.jsonl")
    assert 0 < found.failures == alone.failures < 100


@pytest.mark.slow
def test_a_killed_worker_loses_no_row_of_a_sweep_and_changes_none(client, cluster, tmp_path):
    with one_killed(client, cluster):
        found = sweep(POSTS, grid(POSTS), tmp_path / "rows.jsonl", measure=slow, batch=1)
    numbers = [json.loads(line)["design"] for line in (tmp_path / "rows.jsonl").read_text().splitlines()[1:]]
    assert sorted(numbers) == list(range(6))
    assert [row["height"] for row in found.rows()] == [design["parameters.h"] for design in grid(POSTS)]


@pytest.mark.slow
def test_a_killed_worker_loses_no_draw_of_a_fragility_and_changes_none(client, cluster):
    with one_killed(client, cluster):
        found = fragility(RING, UNCERTAIN, SIDE, draws=32)
    assert np.array_equal(found, fragility(RING, UNCERTAIN, SIDE, draws=32))


@pytest.mark.slow
def test_a_killed_worker_loses_no_step_of_a_plan_and_changes_none(client, cluster):
    ring = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=31, springers=0.3))
    held = build_by_courses(ring).plan
    assert held is not None
    plan = Plan(tuple(Step(step.install) for step in held.steps), held.boundary)
    with one_killed(client, cluster):
        found = assess_plan(ring, plan, tilt=True)
    alone = assess_plan(ring, plan, tilt=True)
    assert len({outcome.word for outcome in alone.outcomes}) > 1
    assert found.outcomes == alone.outcomes
    assert found.tilt == alone.tilt
    assert [v.score for v in found.verdicts] == pytest.approx([v.score for v in alone.verdicts], abs=1e-6)


@pytest.mark.slow
def test_a_killed_worker_loses_no_state_and_changes_none(client, cluster):
    ring = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=25, springers=0.3))
    names = [ring.names[k] for k in ring.free]
    states = [(names[:count], names[count - held : count]) for count in range(2, 26) for held in (0, 1, 2)]
    with one_killed(client, cluster):
        found = assess_states(ring, states)
    alone = assess_states(ring, states)
    assert [v.outcome for v in found] == [v.outcome for v in alone]
    assert [v.score for v in found] == pytest.approx([v.score for v in alone], abs=1e-6)


def test_stages_on_workers_are_those_of_one_process(client):
    stages = [{"name": "ring", "place": ["arch"], "centring": ["arch"], "courses": True}, {"name": "decentring"}]
    ring = RING.with_(metadata={"stages": stages})
    with joblib.parallel_config(backend="dask"), distributed.get_task_stream(client) as stream:
        found = assess_stages(ring)
    assert stream.data
    assert found.explain() == assess_stages(ring).explain()


@pytest.mark.slow
def test_a_task_that_no_worker_survives_is_an_error_and_rows_that_came_are_kept(client, cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster.scheduler, "allowed_failures", 0)  # 3 by default: given up after the fourth worker
    path, designs = tmp_path / "rows.jsonl", [{"parameters.h": 1.0 + 0.2 * k} for k in range(6)]
    with joblib.parallel_config(backend="dask"), pytest.raises(KILLED):
        sweep(POSTS, designs, path, measure=survived, batch=1)
    assert path.read_text().count("\n") - 1 == 5
    client.wait_for_workers(2, timeout=TIMEOUT)
    with joblib.parallel_config(backend="dask"):
        assert sweep(POSTS, designs[:5], path, measure=survived, batch=1).computed == 0


def test_a_measure_keeps_its_calls_on_its_worker(client, tmp_path):
    with joblib.parallel_config(backend="dask"):
        rows = sweep(POSTS, latin_hypercube(POSTS, 4), tmp_path / "rows.jsonl", measure=workers_inside, batch=1).rows()
    assert [row["inside"] for row in rows] == [0] * 4


def test_the_client_may_be_named(cluster):
    with (
        distributed.Client(cluster, set_as_default=False) as client,
        joblib.parallel_config(backend="dask", client=client),
        distributed.get_task_stream(client) as stream,
    ):
        assert len(fragility(RING, UNCERTAIN, SIDE, draws=8)) == 8
    assert stream.data


def test_work_goes_to_a_single_worker_of_a_cluster_too():
    alone = fragility(RING, UNCERTAIN, SIDE, draws=8)
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": 50}
    with (
        distributed.LocalCluster(**options, processes=False) as lonely,
        distributed.Client(lonely) as client,
        joblib.parallel_config(backend="dask"),
    ):
        assert count_workers(None) == 1
        with distributed.get_task_stream(client) as stream:
            found = fragility(RING, UNCERTAIN, SIDE, draws=8)
        assert stream.data
    assert np.array_equal(found, alone)


def test_without_a_backend_one_process_works_unless_more_are_asked_for():
    assert count_workers(None) == count_workers(1) == 0
    assert count_workers(2) == 2
    with joblib.parallel_config(n_jobs=2):
        assert count_workers(None) == 2
    with pytest.raises(InputError, match="jobs is 0; it must be a whole number of at least 1"):
        fragility(RING, UNCERTAIN, SIDE, draws=2, jobs=0)


def test_the_commands_of_the_page_start_workers_for_a_client_by_address(root, tmp_path):
    page = (root / "docs" / "howto" / "cluster.md").read_text()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    page = page.replace("8786", port)
    (address,) = re.findall(r'client = Client\("(.+?)"\)', page)
    started = []
    try:
        for command in re.findall(r"^    (dask .+)$", page, re.MULTILINE):
            dask, *arguments = shlex.split(command)
            options = ["--dashboard-address", ":0"] if arguments[0] == "scheduler" else []
            line = [str(Path(sys.executable).with_name(dask)), *arguments, *options]
            started.append(subprocess.Popen(line, cwd=tmp_path, stderr=subprocess.DEVNULL))
        assert len(started) == 2
        with distributed.Client(address) as client, joblib.parallel_config(backend="dask"):
            client.wait_for_workers(2, timeout=TIMEOUT)
            assert count_workers(None) == 2
            client.run(sys.path.extend, [path for path in sys.path if path])
            assert len(fragility(RING, UNCERTAIN, SIDE, draws=8)) == 8
    finally:
        for process in reversed(started):
            process.terminate()
            try:
                process.wait(TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()
