"""The table of static and dynamic verdicts, and what a notebook, CSV and JSON get of it."""

import csv
import json
from dataclasses import replace

import pytest

from blockstat import InputError
from dynsim import Comparison, Comparisons, compare, verify_many
from dynsim.cli.rows import print_comparisons
from evidence.scenes.small import arch, assembly, box, stack


def jammed():
    """A block between two fixed ones, with nothing below: a thrust that nothing makes could hold it."""
    blocks = [box((-1, 0, 0), (0, 1, 1)), box((1, 0, 0), (2, 1, 1)), box((0, 0, 0), (1, 1, 1))]
    return assembly(blocks, supports=[0, 1], name="jammed <b>")


@pytest.fixture(scope="module")
def table():
    made = [stack(2, name="stack"), arch(9, 0.07, name="thin"), jammed(), stack(0, name="ground")]
    return compare(made, jobs=2)


@pytest.mark.parametrize("judge", [compare, verify_many])
def test_no_assemblies_are_refused(judge):
    gone = iter([stack(2)])
    assert len([*gone]) == 1
    for none in ([], gone):
        with pytest.raises(InputError, match="there are no assemblies"):
            judge(none)


def test_rows_come_in_order_with_three_verdicts(table):
    assert [(row.name, row.static, row.coulomb, row.dynamic) for row in table] == [
        ("stack", "stable", "stable", "stands"),
        ("thin", "unstable", "unstable", "falls"),
        ("jammed <b>", "stable", "stable_only_by_self_stress", "falls"),
        ("ground", None, None, None),
    ]  # fmt: skip
    assert "nothing to simulate" in table[3].note
    assert table[1].cosine == pytest.approx(1, abs=0.02)
    assert table[0].cosine is None
    assert all(row.dynamic_seconds > 0 for row in table if row.dynamic)


def test_confusion_counts_the_judged(table):
    assert table.confusion() == {("stable", "stands"): 1, ("unstable", "falls"): 1, ("stable", "falls"): 1}
    assert table.confusion("coulomb")[("stable_only_by_self_stress", "falls")] == 1
    with pytest.raises(InputError, match="there are: static, coulomb"):
        table.confusion("bullet")


def test_disagreements_are_a_table(table):
    assert [row.name for row in table.disagreements] == ["jammed <b>"]
    assert isinstance(table.disagreements, Comparisons)
    assert table.disagreements[0].agree_coulomb is True
    differs = Comparison(name="a stand on self-stress", agree=True, agree_coulomb=False)
    assert list(Comparisons((differs,)).disagreements) == [differs]


def test_a_row_agrees_where_both_static_verdicts_agree():
    half = Comparison("open", static="stable", coulomb="undecided", dynamic="stands", agree=True, agree_coulomb=None)
    assert half.explain().splitlines()[0] == "open: Statics or Bullet do not decide."
    html = Comparisons((half, replace(half, coulomb="stable", agree_coulomb=True)))._repr_html_()
    assert html.count(">yes</td>") == 1


def test_csv_and_json_hold_the_same(table, tmp_path):
    with table.write_csv(tmp_path / "rows.csv").open() as file:
        lines = list(csv.DictReader(file))
    rows = json.loads(table.write_json(tmp_path / "rows.json").read_text())["rows"]
    assert [Comparison(**row) for row in rows] == list(table)
    assert len(lines) == len(rows) == 4
    for line, row in zip(lines, rows, strict=True):
        assert {key: "" if value is None else str(value) for key, value in row.items()} == line


def test_a_notebook_shows_a_row_for_each_and_escapes_names(table):
    html = table._repr_html_()
    assert html.count("<tr>") == 1 + len(table)
    assert "jammed &lt;b&gt;" in html
    assert "<b>" not in html
    assert "4 assemblies, 3 with verdicts" in html
    assert html.count(">no</td>") == 1


def test_one_assembly_is_a_table_of_one_row():
    assert [row.dynamic for row in compare(stack(1), jobs=1)] == ["stands"]


def test_a_row_without_verdicts_or_cosine_says_so_in_a_line():
    bare = Comparison(name="ground", note="nothing to simulate")
    assert bare.explain().splitlines() == [f"ground: {bare.outcome.value}", "Note: nothing to simulate."]
    judged = Comparison(name="wall", static="unstable", dynamic="falls", agree=True, agree_coulomb=True, cosine=0.987)
    assert judged.explain().splitlines()[1:] == [
        "Force field: unstable. Coulomb friction: no verdict. Bullet: falls.",
        "Cosine of the static mechanism with Bullet's first motion: 0.99.",
    ]


@pytest.mark.parametrize("name", ["wall [v1]", "bridge[red]", "wall [/old]"])
def test_names_in_brackets_are_printed_as_they_are(capsys, name):
    row = Comparison(
        name=name, blocks=1, interfaces=1, static="stable", score=0.0, dynamic="stands",
        static_seconds=0.0, dynamic_seconds=0.0,
    )  # fmt: skip
    print_comparisons(Comparisons((row, Comparison(name=f"{name} again"))))
    printed = capsys.readouterr().out
    assert f" {name} " in printed
    assert f" {name} again " in printed


def test_a_name_of_no_encoding_is_written_with_its_code(tmp_path):
    path = Comparisons((Comparison(name="caf\udce9"),)).write_csv(tmp_path / "rows.csv")
    assert path.read_text(encoding="utf-8").splitlines()[1].startswith(r"caf\udce9,")
