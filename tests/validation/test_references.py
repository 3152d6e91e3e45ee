"""Every reference value, to the digits it is printed with. Sources: at the top of the modules in tests/references."""

import math

import pytest

from references import SECTIONS
from references.row import Row, Value

ROWS = [
    pytest.param(row, id=f"{row.tag} {row.name}", marks=[pytest.mark.slow] if row.slow else [])
    for rows in SECTIONS.values()
    for row in rows
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
        row = Row(tag, "", ".107348", lambda: Value(0.1073491))
        assert row.accepted == pytest.approx(accepted)
        assert abs(row.compute().ours - row.value) > row.accepted
