"""Every reference value, to the digits it is printed with. Sources: see the modules of `evidence.references`."""

import math
import re

import pytest

from evidence.references import SECTIONS
from evidence.references.row import Row, Value

ROWS = [
    pytest.param(row, id=row.test, marks=[pytest.mark.slow] if row.slow else [])
    for module in SECTIONS.values()
    for row in module.ROWS
]


@pytest.mark.parametrize("row", ROWS)
def test_reference(row):
    if row.missing:
        pytest.skip("no directory of cases")
    ours, bracket = row.compute()
    assert ours == pytest.approx(row.value, rel=0, abs=row.accepted)
    assert math.isnan(bracket) or bracket <= max(2 * row.accepted, 1e-6 * abs(ours))


def test_a_value_off_by_a_unit_of_its_last_digit_is_no_agreement():
    for tag, accepted in (("P", 5e-7), ("D", 1e-6)):
        row = Row(tag, "", "", ".107348", lambda: Value(0.1073491))
        assert row.accepted == pytest.approx(accepted)
        assert abs(row.compute().ours - row.value) > row.accepted


def test_every_row_of_the_page_names_its_test_and_its_source(root):
    """First two columns: the test; last one: a work of the bibliography where the value is published."""
    page = [line.split(" | ") for line in (root / "docs" / "validation.md").read_text().splitlines() if "| " in line]
    shown = {f"{cells[0].strip('| ')} {cells[1]}": cells[-1].strip("| ") for cells in page if len(cells) == 8}
    del shown[" reference"]
    rows = {param.id: param.values[0] for param in ROWS}
    assert len(rows) == len(ROWS)
    assert set(shown) == set(rows)
    headings = re.findall(r"^## (.+)$", (root / "docs" / "bibliography.md").read_text(), re.MULTILINE)
    for name, row in rows.items():
        works = re.findall(r"\[([^]]+)\]\(bibliography\.md#([^)]+)\)", shown[name])
        assert row.source
        assert row.tag != "P" or ", ".join(work for work, _ in works) == row.source
        for work, anchor in works:
            assert work in headings
            assert anchor == work.lower().replace(" ", "-")
        for path in re.findall(r"\]\(\.\./([^)]+)\)", shown[name]):
            assert (root / path).exists()
