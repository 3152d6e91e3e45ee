"""Ties at rest, ties that yield far beyond the weight, given forces that nothing else joins, and ties of one block."""

import numpy as np
import pytest

from blockstat import Assembly, InputError, LoadOutcome, Tie, box, limit_load, prove

GROUND, CUBE = box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube")
WALL = box((-3, -1, -1), (-2, 2, 3), name="wall")
BEAM, HUNG = box((-1, -1, 5), (2, 2, 6), name="beam"), box((0, 0, 2), (1, 1, 3), name="hung")
WEIGHT, FRICTION = 9810.0, 0.5


def scene(*blocks, tie):
    supports = [block.name for block in blocks if block.name in ("ground", "wall", "beam")]
    return Assembly.from_blocks(blocks, supports=supports, density=1000.0, friction=FRICTION, ties=[tie])


@pytest.mark.parametrize("height", [0.1, 0.5])
@pytest.mark.parametrize("least", [0.0, 0.1])
def test_joints_of_every_kind_carry_friction_and_the_force_of_a_tie(height, least):
    # Away from the wall friction and the yielding tie hold; towards it the tie pulls with what it does not let go of.
    tie = Tie(("wall", "cube"), ((-2, 0.5, height), (0, 0.5, height)), least=least * WEIGHT, greatest=0.3 * WEIGHT)
    for direction, limit in ((1, FRICTION + 0.3), (-1, FRICTION - least)):
        found = limit_load(scene(GROUND, WALL, CUBE, tie=tie), (direction, 0, 0), flow="coulomb")
        assert len(found.coulomb_kinds) == 3
        assert np.array(found.coulomb_kinds) == pytest.approx(limit, rel=1e-3)


def test_a_load_that_a_tie_bounds_far_beyond_the_weight_is_not_called_unbounded_without_a_word():
    hanging = Tie(("beam", "hung"), ((0.5, 0.5, 5), (0.5, 0.5, 3)), greatest=5e9)
    found = limit_load(scene(GROUND, BEAM, HUNG, tie=hanging), (0, 0, -1))
    assert found.outcome is LoadOutcome.UNBOUNDED
    assert any("ties have strengths, which bound the load" in text for text in found.warnings)
    endless = Tie(hanging.between, hanging.points)
    assert limit_load(scene(GROUND, BEAM, HUNG, tie=endless), (0, 0, -1)).warnings == ()


@pytest.mark.filterwarnings("error")
def test_a_block_that_hangs_on_a_given_force_alone_has_a_proof_without_forces():
    tie = Tie(("beam", "hung"), ((0.5, 0.5, 5), (0.5, 0.5, 3)), least=WEIGHT, greatest=WEIGHT)
    assert prove(scene(BEAM, HUNG, tie=tie)).content["proof"] == {"forces": []}


@pytest.mark.parametrize("between", [("cube", 1), (1, "cube"), ("cube", "1"), (np.int64(1), "cube")])
def test_a_tie_of_a_block_to_itself_is_refused(between):
    with pytest.raises(InputError, match=r'tie "rod": between is .*, both of them "cube"; it must be two blocks'):
        scene(GROUND, CUBE, tie=Tie(between, ((0.1, 0.1, 0.1), (0.9, 0.9, 0.9)), name="rod"))


def test_a_block_is_given_by_a_number_of_numpy():
    asm = Assembly.from_blocks([GROUND, CUBE], supports=np.int64(0))
    assert asm.support.tolist() == [True, False]
    assert asm.blocks_named(asm.free[0]).tolist() == [1]
