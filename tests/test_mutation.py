"""Mutation testing itself: which mutations are made, which tests meet them, and what the page says."""

import ast
import re

import pytest

from evidence.mutation import mutations
from evidence.mutation import reach as reaching
from evidence.mutation.judge import KILLED, SURVIVED, UNREACHED, Judgement
from evidence.mutation.mutations import ROOMS, SOURCE, Mutation, changed_lines, files
from evidence.mutation.reach import Reach, deciding_line
from evidence.mutation.run import equivalents, equivalents_page, page

CODE = """
def share(values: list[int | None], most: float = 1.0) -> float | None:
    total: int | float = 0
    for value in values:
        total = total + value
    return total / most if total > most else None
"""


def judged(outcome, after, room="blockstat/io"):
    tests = 0 if outcome == UNREACHED else 4
    return Judgement(f"{room}/a.py:AddNot:{after}", room, outcome, "if a:", after, 3, "", tests, tests // 2, 1.0)


def test_the_rooms_are_there():
    assert all(any(str(path.relative_to(SOURCE)).startswith(room) for path in files()) for room in ROOMS)


def test_equivalent_mutants_are_of_lines_that_are_there():
    for (name, before, _), reason in equivalents().items():
        lines = [line.strip() for line in (SOURCE / name).read_text().splitlines()]
        assert all(line in lines for line in before.splitlines()), f"{name}: {before}"
        assert reason.endswith(".")


def test_mutations_change_one_place_and_no_annotation(tmp_path, monkeypatch):
    pytest.importorskip("cosmic_ray")
    monkeypatch.setattr(mutations, "SOURCE", tmp_path)
    path = tmp_path / "blockstat" / "io" / "share.py"
    path.parent.mkdir(parents=True)
    path.write_text(CODE)
    found = [mutation for changes in mutations.sites(path).values() for mutation in changes]
    lines = {changed_lines(CODE, mutation.text()) for mutation in found}
    assert ("total = total + value", "total = total - value") in lines
    assert ("total: int | float = 0", "total: int | float = 1") in lines
    assert any(after == "for value in []:" for _, after in lines)
    for before, after in lines:
        assert "int & " not in after, "an annotation"
        assert "total << value" not in after, "numbers have no bits"
        assert before != after
    for mutation in found:
        ast.parse(mutation.text())
        assert mutation.room == "blockstat/io"
    monkeypatch.setattr(mutations, "files", lambda rooms: [path])
    one, other = (mutations.sample(5, seed) for seed in (1, 1))
    assert one == other
    assert len({(mutation.path, mutation.line, mutation.operator) for mutation in one}) == 5
    assert mutations.sample(5, 2) != one


SOURCE_OF_LINES = """LIMIT = 3


def first(
    a,
    *,
    b=2,
):
    try:
        c = (a
             + b)
    except ValueError:
        c = 0
    return c


class Held:
    size: int = 4

    @property
    def twice(self):
        return 2 * self.size
"""


@pytest.mark.parametrize(
    ("line", "first"),
    [(1, None), (4, None), (6, None), (7, None), (9, 9), (10, 10), (11, 10), (13, 13), (14, 14), (18, None), (20, None),
     (21, None), (22, 22)],
)  # fmt: skip
def test_a_line_counts_as_its_statement_and_outside_of_functions_as_the_module(line, first):
    assert deciding_line(SOURCE_OF_LINES, line) == first


def test_the_fastest_test_that_reaches_a_line_comes_first(tmp_path, monkeypatch):
    monkeypatch.setattr(reaching, "SOURCE", tmp_path)
    (tmp_path / "a.py").write_text(SOURCE_OF_LINES)
    lines = {"a.py": {1: {"slow"}, 10: {"slow", "fast"}, 13: {"fast"}, 14: {"", "slow"}, 22: set()}}
    reach = Reach({"slow": 2.0, "fast": 0.1}, lines)

    def tests(line):
        return reach.tests(Mutation("a.py", "core/AddNot", 0, line))

    assert tests(11) == ["fast", "slow"]
    assert tests(13) == ["fast"]
    assert tests(1) == ["fast", "slow"]  # run once, by the test that imported it: any test of the file may see it
    assert tests(7) == ["fast", "slow"]
    assert tests(14) == ["slow"]
    assert tests(22) == []


def test_the_page_counts_by_room_and_shows_survivors():
    found = [judged(KILLED, "x"), judged(SURVIVED, "y"), judged(UNREACHED, "z"), judged(SURVIVED, "w")]
    found.append(judged(KILLED, "x", "dynsim/judge"))
    first = {found[0].key: judged(SURVIVED, "x")}
    text = page(found, 9, 7, {("blockstat/io/a.py", "if a:", "w"): "It does nothing."}, first)
    assert "5 of 9 mutants were judged." in text
    assert "| `blockstat/io` | 4 | 1 | 1 | 1 | 1 | 33.3 % | 0.0 % |" in text
    assert "| `dynsim/judge` | 1 | 1 | 0 | 0 | 0 | 100.0 % | 100.0 % |" in text
    assert "| all | 5 | 2 | 1 | 1 | 1 | 50.0 % | 25.0 % |" in text
    _, left = text.split("### Survivors of sample 7\n")
    assert left.count("```diff") == 2
    assert "+y" in left
    assert "no test reaches it" in left
    assert "+w" not in left


def test_equivalent_mutants_of_one_reason_are_one_block_of_diffs():
    found = [judged(KILLED, "x"), judged(SURVIVED, "y"), judged(UNREACHED, "z"), judged(SURVIVED, "w")]
    known = {("blockstat/io/a.py", "if a:", after): "It does nothing." for after in "xyw"}
    text = equivalents_page(found, known)
    (block,) = re.findall(r"It does nothing\.\n\n```diff\n(.*?)```", text, re.S)
    assert block.splitlines()[1::3] == ["-if a:", "-if a:"]
    assert block.splitlines()[2::3] == ["+y", "+w"]
    assert block.startswith("@@ blockstat/io/a.py, line 3; 4 tests reach it, 2 were run @@")
