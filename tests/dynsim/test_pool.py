"""Many designs side by side."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import pool_tasks
from blockstat import InputError, write
from dynsim import Removal, SpeculativeRuns, run_many, verify, verify_many
from dynsim.parallel import pool
from evidence.scenes.small import arch, assembly, box, running_bond, stack


def bits(verdict):
    return verdict.run.displacement.tobytes() + verdict.run.rotation.tobytes()


def test_the_same_bits_whatever_the_number_of_processes():
    designs = [arch(9, 0.1), stack(3), arch(9, 0.2), running_bond(2, 2)]
    alone = [bits(verify(design)) for design in designs]
    for jobs in (1, 3):
        rows = verify_many(designs, jobs=jobs)
        assert rows.finished
        assert [bits(row.result) for row in rows] == alone
    # In another order, so that each comes after others in its process.
    assert [bits(row.result) for row in verify_many(designs[::-1], jobs=1)] == alone[::-1]


def test_answers_that_were_begun_ahead_are_the_same_bit_by_bit():
    designs = [arch(9, 0.1), arch(9, 0.2), stack(3)]
    with SpeculativeRuns(verify, jobs=2) as ahead:
        for design in designs[:2]:
            ahead.begin(design)
        assert [bits(ahead(design)) for design in designs] == [bits(verify(design)) for design in designs]
        assert bits(ahead(designs[0])) == bits(verify(designs[0]))


def test_what_fails_ahead_is_found_where_it_is_asked_for():
    with SpeculativeRuns(pool_tasks.fragile, jobs=1) as ahead:
        here = os.getpid()
        tasks = [(here, "dies"), (here, "fails"), (here, "")]
        for task in tasks:
            ahead.begin(task)
        assert ahead(tasks[0]) == here
        with pytest.raises(ValueError, match="fails"):
            ahead(tasks[1])
        assert ahead(tasks[2]) != here
    start = time.monotonic()
    with SpeculativeRuns(pool_tasks.slow, jobs=1) as ahead:
        ahead.begin(60.0)
    assert time.monotonic() - start < 30


def test_a_function_that_no_other_process_can_import_is_called_here():
    found = []

    def ask():
        with SpeculativeRuns(lambda number: 10 * number, jobs=1) as ahead:
            ahead.begin(4)
            found.append(ahead(4))

    asking = threading.Thread(target=ask, daemon=True)
    asking.start()
    asking.join(60.0)
    assert found == [40]


def test_loads_go_along_and_bad_designs_lose_their_row_only():
    loose = assembly([box((0, 0, 0), (1, 1, 1))], supports=[], name="loose")
    rows = verify_many([arch(9, 0.2), loose], loads=[Removal("voussoir4")], jobs=2)
    assert rows[0].result.outcome.word == "falls"
    assert rows[1].result is None
    assert rows[1].error == '"loose" has no supports; list the blocks that cannot move under "supports"'


def test_deaths_and_delays_lose_their_own_rows_only(monkeypatch):
    told, plain = [], pool.Line._ask

    def ask(line, function, argument):
        """The others may wait for a busy machine as long as they like."""
        given, line._timeout = line._timeout, line._timeout if argument == 3 else None
        try:
            return plain(line, function, argument)
        finally:
            line._timeout = given

    monkeypatch.setattr(pool.Line, "_ask", ask)
    rows = run_many(pool_tasks.mixed, range(8), jobs=2, timeout=3.0, progress=lambda index, row: told.append(index))
    assert [row.result for row in rows] == [0, None, None, None, None, None, 60, 70]
    assert [row.error for row in rows] == [
        "", "its process was killed by SIGKILL", "its process was killed by SIGSEGV", "took longer than 3 s",
        "its process ended by itself (status 3)", "internal error (ValueError: five)", "", "",
    ]  # fmt: skip
    assert sorted(told) == list(range(8))


def test_an_interrupt_keeps_what_is_done():
    def interrupt(index, row):
        if index == 1:
            raise KeyboardInterrupt

    start = time.monotonic()
    rows = run_many(pool_tasks.slow, [0.0, 0.1, 60.0], jobs=1, progress=interrupt)
    assert time.monotonic() - start < 30
    assert not rows.finished
    assert [row.result for row in rows] == [0.0, 0.1, None]
    assert rows[2].error == "interrupted before it was done"


def test_ctrl_c_on_the_command_line_keeps_the_rows(tmp_path):
    files = [write(stack(2), tmp_path / "a.json")]
    files += [write(running_bond(14, 10), tmp_path / f"wall{i}.json") for i in range(6)]
    table = tmp_path / "rows.csv"
    code = "from dynsim.cli.commands import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "compare", *map(str, files), "--jobs", "1", "-o", str(table)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while process.poll() is None and not table.is_file():
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    lines = table.read_text().splitlines()
    assert len(lines) == 8
    assert lines[1].startswith("assembly,3,2,stable")
    assert "interrupted before it was done" in lines[-1]
    assert "no verdict" in out


def test_a_task_that_other_processes_cannot_import():
    def local(number):
        return number

    rows = run_many(local, [1])
    assert "pickle" in rows[0].error


def test_warnings_come_with_the_row():
    rows = run_many(pool_tasks.warned, ["the joint is thin", "the joint is thin"], jobs=1)
    assert [row.warnings for row in rows] == [("the joint is thin",)] * 2


def test_bad_numbers():
    with pytest.raises(InputError, match="jobs is 0"):
        run_many(pool_tasks.slow, [0.0], jobs=0)
    with pytest.raises(InputError, match="timeout is -1"):
        run_many(pool_tasks.slow, [0.0], timeout=-1)
    assert len(run_many(pool_tasks.slow, [])) == 0


def command(*arguments):
    code = "from dynsim.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def test_several_files_on_the_command_line(tmp_path):
    good, thin = write(arch(9, 0.2), tmp_path / "good.json"), write(arch(9, 0.07), tmp_path / "thin.json")
    bad = tmp_path / "bad.json"
    bad.write_text("{")
    answer = command("verify", good, bad, thin, "--json", "--jobs", "2")
    assert answer.returncode == 0, answer.stderr
    rows = json.loads(answer.stdout)["rows"]
    assert [row["verdict"] for row in rows] == ["stands", None, "falls"]
    assert "not valid JSON" in rows[1]["error"]
    assert command("verify", good, thin, "-o", tmp_path / "run.glb").returncode == 2
    late = command("verify", good, "--timeout", "0.01")
    assert late.returncode == 2
    assert "took longer than 0.01 s" in late.stdout
