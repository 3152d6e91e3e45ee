"""Every reference value, to the digits it is printed with. Sources: at the top of the modules in tests/references."""

import math

import pytest

from references import SECTIONS, Row

ROWS = [
    pytest.param(row, id=f"{row.tag} {row.name}", marks=[pytest.mark.slow] if row.slow else [])
    for rows in SECTIONS.values()
    for row in rows
]


@pytest.mark.parametrize("row", ROWS)
def test_reference(row, request):
    if row.name.startswith("wedge"):
        request.getfixturevalue("cases")
    ours, bracket = row.compute()
    assert ours == pytest.approx(row.value, rel=0, abs=row.accepted)
    assert math.isnan(bracket) or bracket <= max(2 * row.accepted, 1e-6 * abs(ours))


def test_a_value_off_by_a_unit_of_its_last_digit_is_no_agreement():
    row = Row("D", "", ".107348", lambda: (0.1073486, math.nan))
    assert row.accepted == pytest.approx(5e-7)
    assert abs(row.compute()[0] - row.value) > row.accepted
