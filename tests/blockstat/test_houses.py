"""Everything of a wall at once: corners of walls of different bond, height, batter and coping, openings, buttresses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import assess
from blockstat.model import Buttress, Coping, Opening, Run, walls
from blockstat.model.walling.run import BONDS, HEADS
from walls import grounded, tight

RISE = {"segmental": 0.2, "pointed": 0.7, "elliptic": 0.3}

sides = st.fixed_dictionaries(
    {
        "thickness": st.floats(0.3, 0.6),
        "bond": st.sampled_from(BONDS),
        "batter": st.sampled_from([(0.0, 0.0), (0.03, 0.0), (0.01, 0.02)]),
        "coping": st.sampled_from([None, Coping(overhang=0.06)]),
    }
)


@settings(max_examples=20, deadline=None)
@given(
    south=sides, west=sides, rest=sides, leaves=st.integers(1, 2), heights=st.sampled_from([(2.5, 3.0), (3.0, 2.5)]),
    gable=st.sampled_from([0.0, 1.5]), head=st.sampled_from(HEADS), brick=st.floats(0.35, 0.55),
    bonded=st.booleans(), weathering=st.sampled_from([0.0, 0.25]), lean=st.floats(-1, 1),
)  # fmt: skip
def test_any_house_is_sound(south, west, rest, leaves, heights, gable, head, brick, bonded, weathering, lean):
    opening = Opening(width=0.8, height=1.2, head=head, rise=RISE.get(head), at=[2.1])
    low = heights[0]
    runs = [
        Run(name="south", path=[(0, 0), (8, 0)], height=low, openings=[opening], leaves=leaves, **south),
        Run(name="west", path=[(0, 5), (0, 0)], height=low, gable=gable, **west),
        Run(name="rest", path=[(8, 0), (8 + lean, 5), (5, 5)], height=heights[1], **rest),
    ]
    spec = Buttress(
        wall="south", at=[4.5, 6.4], width=0.5, projection=0.8, height=1.75, steps=[(1.0, 0.5)], weathering=weathering,
        bonded=bonded,
    )  # fmt: skip
    blocks = walls(runs, brick=(brick, 0.25), buttresses=[spec])
    asm = grounded(blocks)
    tight(asm)
    wanted = {"ground", "wall.south", "wall.west", "wall.rest", "buttress.south.1", "buttress.south.2"}
    wanted |= {"wall.south.lintel" if head == "lintel" else "wall.south.arch"}
    wanted |= {f"wall.{run.name}.coping" for run in runs if run.coping is not None}
    assert set(asm.groups) == wanted


@pytest.mark.parametrize("bond", BONDS)
def test_a_gabled_house_stands(bond):
    door = Opening(width=0.9, height=1.5, head="semicircular", depth=0.3)
    runs = [
        Run(name="south", path=[(0, 0), (5, 0)], thickness=0.5, height=2.4, bond=bond, openings=[door]),
        Run(name="north", path=[(0, 4), (5, 4)], thickness=0.5, height=2.4, bond=bond),
        Run(name="west", path=[(0, 0), (0, 4)], thickness=0.5, height=2.4, bond=bond, gable=1.2),
        Run(name="east", path=[(5, 0), (5, 4)], thickness=0.5, height=2.4, bond=bond, gable=1.2),
    ]
    asm = grounded(walls(runs, brick=(0.5, 0.3)))
    assert assess(asm).outcome.word == "stable"
    # Two long walls and two gables between their axes, half a metre more at the corners.
    plan = 2 * 0.5 * (5.5 + 3.5)
    inner = asm.volume[asm.in_group("wall")].sum()
    stones = len(asm.in_group("wall.south.arch"))
    void = 0.9 * 1.5 + stones / 2 * 0.45**2 * np.sin(np.pi / stones)
    assert inner == pytest.approx(plan * 2.4 + 2 * 0.5 * 4.5 * 1.2 / 2 - 0.5 * void, rel=1e-9)
