"""Blocks in the gap of a joint: the force goes through them, so their friction counts."""

import numpy as np
import pytest

from blockstat import JointLaw, Outcome, assess, find_interfaces
from evidence.scenes.small import assembly, box, prism, running_bond

BASE = box((-3, -3, -1), (3, 3, 0), name="base", group="base")
SLIPPERY = JointLaw(("sheet", "*"), friction=0.1)


def sheet(lower, upper, name="sheet"):
    return box(lower, upper, name=name, group="sheet")


def cube(bottom):
    return box((0, 0, bottom), (1, 1, 1 + bottom), name="cube", group="cube")


def tilted(blocks, degrees, **options):
    """Blocks on a slope with friction 0.7, and 0.1 on both sides of the sheets."""
    down = -np.array([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))])
    return assembly(blocks, friction=0.7, gravity=down, joints=[SLIPPERY], **options)


def joined(asm):
    found = find_interfaces(asm)
    pairs = {(asm.names[a], asm.names[b]) for a, b in found.pair}
    return pairs, [(asm.names[d.a], asm.names[d.b], d.reason) for d in found.dropped]


@pytest.mark.parametrize("width", [0.4, 1.0, 2.0])
@pytest.mark.parametrize("thickness", [1e-5, 5e-4, 2e-3, 5e-3])
def test_a_cube_on_a_slip_sheet_slides_at_the_friction_of_the_sheet(thickness, width):
    # tan 15 deg = .268 lies between the friction of the sheet and that of the stones; .1 = tan 5.71 deg.
    a, b = 0.5 - width / 2, 0.5 + width / 2
    blocks = [BASE, sheet((a, a, 0), (b, b, thickness)), cube(thickness)]
    pairs, dropped = joined(tilted(blocks, 15))
    assert pairs == {("base", "sheet"), ("sheet", "cube")}
    assert dropped == [("base", "cube", "between")]
    for degrees, outcome in ((15, Outcome.UNSTABLE), (5.8, Outcome.UNSTABLE), (5.6, Outcome.STABLE)):
        assert assess(tilted(blocks, degrees)).outcome is outcome


def test_pads_hold_two_blocks_apart():
    # The pads fill a part of the gap, and each lies only partly under the cube.
    pads = [sheet((x, y, 0), (x + 0.2, y + 0.2, 2e-3), f"pad{x}{y}") for x in (-0.1, 0.85) for y in (-0.1, 0.9)]
    asm = tilted([BASE, *pads, cube(2e-3)], 15)
    pairs, dropped = joined(asm)
    assert ("base", "cube") not in pairs
    assert len(pairs) == 8
    assert dropped == [("base", "cube", "between")]
    assert assess(asm).outcome is Outcome.UNSTABLE


def test_two_membranes_hold_two_blocks_apart():
    # Neither membrane touches both blocks.
    membranes = [sheet((-1, -1, k * 5e-4), (2, 2, (k + 1) * 5e-4), f"membrane{k}") for k in range(2)]
    pairs, dropped = joined(tilted([BASE, *membranes, cube(1e-3)], 15))
    assert pairs == {("base", "membrane0"), ("membrane0", "membrane1"), ("membrane1", "cube")}
    assert dropped == [("base", "cube", "between")]


def test_a_sheet_that_cannot_move_holds_blocks_apart_too():
    asm = tilted([BASE, sheet((-1, -1, 0), (2, 2, 5e-4)), cube(5e-4)], 15, supports=[0, 1])
    assert joined(asm) == ({("sheet", "cube")}, [("base", "cube", "between")])
    assert assess(asm).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1], [1, 2, 0], [2, 1, 0]])
def test_the_order_of_the_blocks_does_not_matter(order):
    blocks = [BASE, sheet((-1, -1, 0), (2, 2, 5e-4)), cube(5e-4)]
    pairs, _ = joined(tilted([blocks[i] for i in order], 15, supports=["base"]))
    assert {frozenset(pair) for pair in pairs} == {frozenset(("base", "sheet")), frozenset(("sheet", "cube"))}


def test_a_sheet_in_a_recess_leaves_the_joint_beside_it():
    # The cube stands on the base with one half, and with the other on a sheet that fills a recess.
    outline = [(-3, -1), (3, -1), (3, 0), (0.5, 0), (0.5, -5e-4), (-3, -5e-4)]
    base = prism(outline, 2.0, name="base", group="base")
    blocks = [base, sheet((-1, 0, -5e-4), (0.5, 1, 0)), cube(0)]
    asm = assembly(blocks)
    pairs, dropped = joined(asm)
    assert ("base", "cube") in pairs
    assert ("base", "cube", "between") in dropped
    found = find_interfaces(asm)
    own = (found.pair == [0, 2]).all(axis=1)
    assert found.area[own].tolist() == pytest.approx([0.5])


def test_an_open_head_joint_stays_beside_thin_blocks():
    # The slates touch both bricks, but do not stand in the gap between them.
    bricks = [box((0, 0, 0), (0.5, 0.2, 0.2), name="left"), box((0.502, 0, 0), (1, 0.2, 0.2), name="right")]
    slates = [
        box((0, 0, 0.2), (1, 0.2, 0.202), name="above"),
        box((0, 0.2, 0), (1, 0.202, 0.2), name="behind"),
    ]
    pairs, dropped = joined(assembly([BASE, *bricks, *slates]))
    assert ("left", "right") in pairs
    assert ("left", "right", "between") not in dropped


def test_rough_joints_of_real_walls_stay():
    # Every corner moves at random by up to a millimetre, so all joints are open or overlap a little.
    exact = running_bond(6, 6)
    noise = np.random.default_rng(3).uniform(-1e-3, 1e-3, exact.vertices.shape)
    rough = find_interfaces(exact.with_(vertices=exact.vertices + noise))
    assert rough.gap.max() > 1e-4
    assert [d for d in rough.dropped if d.reason == "between"] == []
    assert set(map(tuple, find_interfaces(exact).pair.tolist())) <= set(map(tuple, rough.pair.tolist()))
