"""Work on dask's distributed scheduler: a worker that is killed loses nothing and changes nothing."""

import contextlib
import json
import os
import signal
import sys

import joblib
import numpy as np
import pytest

from blockstat import Random, assess_plan, assess_stages, assess_states, build_by_courses, fragility, reliability
from blockstat.errors import InputError
from blockstat.model import arch, assemble
from blockstat.system.workers import count_workers

distributed = pytest.importorskip("distributed")

SIDE = (1, 0, 0)
RING = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=9, springers=0.3))
#: A draw has a number for each joint and for each shared corner: a batch of them is an array of several kilobytes.
UNCERTAIN = {"friction": Random("lognormal", 0.6, 0.1, each="joint"), "corner": Random("normal", 0.0, 0.003)}


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
        found.wait_for_workers(2)
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
def one_killed(client, cluster, after: int = 2):
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


def test_a_killed_worker_loses_no_draw_of_a_reliability_and_changes_none(client, cluster, tmp_path):
    uncertain = UNCERTAIN | {"push": Random("normal", 0.25, 0.1)}
    alone = reliability(RING, uncertain, load=SIDE, draws=160, file=tmp_path / "alone.jsonl")
    with one_killed(client, cluster):
        found = reliability(RING, uncertain, load=SIDE, draws=160, file=tmp_path / "draws.jsonl")

    def outcomes(name):
        rows = [json.loads(line) for line in (tmp_path / name).read_text().splitlines()[1:]]
        return sorted((row["draw"], row["outcome"]) for row in rows)

    assert outcomes("draws.jsonl") == outcomes("alone.jsonl")
    assert 0 < found.failures == alone.failures < 160


def test_a_killed_worker_loses_no_draw_of_a_fragility_and_changes_none(client, cluster):
    with one_killed(client, cluster):
        found = fragility(RING, UNCERTAIN, SIDE, draws=64)
    assert np.array_equal(found, fragility(RING, UNCERTAIN, SIDE, draws=64))


def test_a_killed_worker_loses_no_step_of_a_plan_and_changes_none(client, cluster):
    ring = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=31, springers=0.3))
    plan = build_by_courses(ring).plan
    plan = type(plan)(tuple(type(step)(step.install) for step in plan.steps), plan.boundary)  # nothing is held
    with one_killed(client, cluster):
        found = assess_plan(ring, plan, tilt=True)
    alone = assess_plan(ring, plan, tilt=True)
    assert len({outcome.word for outcome in alone.outcomes}) > 1
    assert found.outcomes == alone.outcomes
    assert found.tilt == alone.tilt
    assert [v.score for v in found.verdicts] == pytest.approx([v.score for v in alone.verdicts], abs=1e-6)


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
    with pytest.raises(InputError, match="jobs is 0; at least one process is needed"):
        fragility(RING, UNCERTAIN, SIDE, draws=2, jobs=0)
