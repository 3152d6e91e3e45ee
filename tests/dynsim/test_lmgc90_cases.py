"""Bullet against LMGC90 (non-smooth contact dynamics) on assemblies of other projects; skipped where they are absent.

LMGC90's answer is the largest displacement after about two seconds, from the table beside the files.
"""

import importlib.util

import pytest

from blockstat import read
from dynsim import verify
from evidence.paths import CASES

#: Exactly at their limit: they may rest, creep or fall.
LIMIT_STATES = ("rbe_simplestack", "rbe_slide")
#: Motion that LMGC90's rests stay well below and its falls well above [m].
MOVED = 0.005


def convex_cases() -> list[tuple[str, float]]:
    manifest = CASES / "MANIFEST.md"
    if not manifest.is_file():
        return []
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]] for line in manifest.read_text().splitlines() if "|" in line
    ]
    return [(row[0], float(row[7])) for row in rows[2:] if row[7] and row[4] == "0"]


@pytest.mark.parametrize(("name", "moved"), convex_cases())
def test_the_verdict_is_that_of_lmgc90(cases, name, moved):
    outcome = verify(read(cases / f"{name}.json")).outcome.word
    if name in LIMIT_STATES:
        return
    assert outcome == ("falls" if moved > MOVED else "stands")


@pytest.mark.skipif(importlib.util.find_spec("compas_lmgc90") is None, reason="compas_lmgc90 is not installed")
@pytest.mark.parametrize(("name", "moved"), convex_cases())
def test_the_engine_lmgc90_says_the_same_as_lmgc90_by_itself(cases, name, moved):
    outcome = verify(read(cases / f"{name}.json"), engine="lmgc90").outcome.word
    if name in LIMIT_STATES:
        return
    assert outcome == ("falls" if moved > MOVED else "stands")
