"""Ties in Bullet against closed forms: a constant tendon, a tie that yields, a strut, and a portal that needs a tie."""

from __future__ import annotations

import numpy as np
import pytest

import dynsim
from blockstat import Assembly, Tie, box
from dynsim import Settings, World
from dynsim.bonds.ties import TieForces

WITHIN = 0.02  #: what Bullet is held to


def block_on_ground(*, ties=(), courses=1, width=0.5, height=2.0):
    """A stack of courses on the ground between two walls that are supports; the blocks weigh 1 N in total."""
    blocks = [
        box((-3, -1, -0.5), (4, 2, 0), name="ground"),
        box((-3, -1, 0), (-2, 2, 3), name="left"),
        box((3, -1, 0), (4, 2, 3), name="right"),
    ]
    rise = height / courses
    for k in range(courses):
        blocks.append(box((0, 0, k * rise), (width, 1, (k + 1) * rise), name=f"b{k}"))
    asm = Assembly.from_blocks(blocks, supports=["ground", "left", "right"], friction=0.9)
    weight = float(asm.mass[asm.free].sum() * 9.81)
    return asm.with_(ties=[Tie(t["between"], t["points"], *(weight * f for f in t["force"]), t.get("strut", False))
                           for t in ties])  # fmt: skip


def carried(asm):
    found = dynsim.limit(asm, (1, 0, 0), width=0.005, check=False)
    return found.lower, found.upper


def close(asm, expected):
    lower, upper = carried(asm)
    assert lower <= expected * (1 + WITHIN)
    assert upper >= expected * (1 - WITHIN)


@pytest.mark.parametrize(("force", "expected"), [(0.0, 0.25), (1.0, 0.5)])
def test_a_central_tendon_of_constant_force_holds_a_stack(force, expected):
    # Moments about the toe: alpha = (b / h) (1 + F / W).
    tendon = {"between": ("b3", "ground"), "points": ((0.25, 0.5, 2.0), (0.25, 0.5, 0.0)), "force": (force, force)}
    close(block_on_ground(ties=[tendon] if force else [], courses=4), expected)


def test_a_tie_that_yields_holds_a_block_with_its_strength():
    # alpha W h / 2 = W b / 2 + Ty h: alpha = b / h + 2 Ty / W.
    tie = {"between": ("b0", "left"), "points": ((0, 0.5, 2), (-2, 0.5, 2)), "force": (0.0, 0.1)}
    close(block_on_ground(ties=[tie]), 0.45)


def test_a_strut_pushes_and_a_slack_tie_does_nothing():
    strut = {"between": ("b0", "right"), "points": ((0.5, 0.5, 2), (3, 0.5, 2)), "force": (0.0, 0.1), "strut": True}
    close(block_on_ground(ties=[strut]), 0.45)
    slack = {**strut, "strut": False}
    close(block_on_ground(ties=[slack]), 0.25)


def test_a_portal_stands_with_a_tie_and_falls_without_or_with_one_too_weak():
    # references: T_min = .104038567 by moments of half an arch; one percent of thickness is some percent of T_min.
    from tests.validation.test_loads import portal

    assert dynsim.verify(portal()[0].with_(ties=())).outcome.word != "stands"
    assert dynsim.verify(portal(0.0, 0.09)[0]).outcome.word != "stands"
    assert dynsim.verify(portal(0.0, 0.13)[0]).outcome.word == "stands"
    assert dynsim.verify(portal(1.0, 1.0)[0]).outcome.word == "stands"


def test_ties_begin_each_run_as_they_were_built():
    """A tie that yields under twice its strength; in another run it pulls as before, bit by bit."""
    tie = {"between": ("b0", "left"), "points": ((0, 0.5, 2), (-2, 0.5, 2)), "force": (0.0, 0.1)}
    asm = block_on_ground(ties=[tie]).with_(gravity=(0.9 * 9.81, 0, -9.81))
    ties, runs = TieForces(asm), []
    for _ in range(2):
        with World(asm, Settings(), [ties]) as world:
            assert ties.force.tolist() == [0.0]
            for _ in range(15):
                world.advance()
            runs.append((ties.force, *world.poses()))
    assert runs[0][0] == pytest.approx(asm.ties[0].greatest)
    for first, second in zip(*runs, strict=True):
        np.testing.assert_array_equal(first, second)
