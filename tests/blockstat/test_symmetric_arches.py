"""A keystone that sinks between two equal halves is on a ridge, and leans towards either half as any flaw has it.

Springers that part together differ from one that leaves the other by a movement of the whole arch, which no equilibrium
depends on. A load on the axis differs from one beside it by as little as that is away.
"""

import numpy as np
import pytest

from blockstat import capacity, settle_to_collapse
from blockstat.model import arch, assemble

LEFT, RIGHT = "springer.left", "springer.right"


def arch_of(voussoirs, thickness, span, turn=0.0):
    """An arch on springers, turned about the vertical; the direction of its span."""
    straight = assemble(
        arch(span=span, thickness=thickness, depth=0.5, voussoirs=voussoirs, springers=0.3), friction=0.8
    )
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return straight.with_(vertices=straight.vertices @ rotation.T), rotation[:, 0]


def spread_at_collapse(scene, along, left, right):
    moves = {name: part * along for name, part in ((LEFT, left), (RIGHT, right)) if part}
    path = settle_to_collapse(scene, moves)
    assert path.outcome.word == "collapse"
    return path.collapse * abs(right - left) / max(abs(left), abs(right))


@pytest.mark.parametrize("turn", [0.0, 2.1])
@pytest.mark.parametrize(("voussoirs", "thickness", "span"), [(9, 0.2, 2.0), (7, 0.3, 3.0)])
def test_springers_that_part_together_carry_the_arch_as_far_as_one_that_leaves(voussoirs, thickness, span, turn):
    scene, along = arch_of(voussoirs, thickness, span, turn)
    alone = spread_at_collapse(scene, along, 0.0, 1.0)
    assert spread_at_collapse(scene, along, -0.5, 0.5) == pytest.approx(alone, rel=1e-3)


def test_springers_that_come_together_carry_the_arch_as_far_as_one_that_comes():
    scene, along = arch_of(9, 0.3, 2.0)
    alone = spread_at_collapse(scene, along, 0.0, -1.0)
    assert spread_at_collapse(scene, along, 0.5, -0.5) == pytest.approx(alone, rel=1e-3)


@pytest.mark.parametrize(("voussoirs", "turn"), [(9, 2.1), (11, 0.0)])
def test_a_load_on_the_axis_is_carried_as_one_beside_it(voussoirs, turn):
    scene, along = arch_of(voussoirs, 0.25, 2.0, turn)
    crown, top = f"arch.{voussoirs // 2}", float(scene.vertices[:, 2].max())
    curves = []
    for off in (0.0, 1e-6):
        load = [(crown, off * along + (0, 0, top), (0, 0, -scene.free_weight))]
        curve = capacity(scene, load, control="mean", displacement=0.01)
        assert curve.outcome.word == "reached"
        curves.append(np.interp([1e-3, 5e-3, 9e-3], curve.displacement, curve.lower))
    assert curves[0] == pytest.approx(curves[1], rel=2e-3)
