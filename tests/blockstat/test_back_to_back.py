"""Faces that lie back to back are no joint, however thin the tips between them.

A block hangs with its tips under the tips of two ledges, and nothing is below it. Each tip pushes it down and none up,
so it falls: the weight does work on a straight fall, which opens every contact.
"""

import numpy as np
import pytest

from blockstat import Assembly, LoadOutcome, Outcome, assess, find_interfaces, limit_load
from evidence.scenes.edges import turned
from evidence.scenes.small import box, prism

DRAWN = np.eye(3)
TURNED = np.linalg.qr(np.array([[2.0, -1.0, 0.5], [1.0, 3.0, 0.2], [0.3, -0.4, 1.0]]))[0]
TURNED = TURNED * np.sign(np.linalg.det(TURNED))


def mirrored(outline):
    return [(2 - x, z) for x, z in outline][::-1]


def feather(thick, length):
    """Tips that taper to an edge: of the ledges from above, of the block from below."""
    ledge = [(-1, 0), (length, 0), (0, thick), (-0.3, 0.5), (-1, 0.5)]
    block = [(0, 0), (length, -thick), (length + 0.1, -0.3), (1.9 - length, -0.3), (2 - length, -thick), (2, 0)]
    return ledge, block


def lip(thick, length):
    """Tips as thick as each other all over."""
    ledge = [(-1, 0), (length, 0), (length, thick), (-0.1, thick), (-0.3, 0.5), (-1, 0.5)]
    block = [(0, 0), (0, -thick), (length + 0.1, -thick), (length + 0.2, -0.3)]
    return ledge, block + mirrored(block)


def hung(outlines, turn=DRAWN):
    ledge, block = outlines
    named = {"left": ledge, "right": mirrored(ledge), "hung": block}
    bodies = [turned(prism(outline, 1.0), turn, name=name) for name, outline in named.items()]
    return Assembly.from_blocks(bodies, supports=["left", "right"], friction=0.6, gravity=turn @ (0, 0, -9.81))


@pytest.mark.parametrize("turn", [DRAWN, TURNED], ids=["drawn", "turned"])
@pytest.mark.parametrize("length", [0.05, 0.2])
@pytest.mark.parametrize("thick", [0.0005, 0.002, 0.004, 0.012])
@pytest.mark.parametrize("tip", [feather, lip])
def test_a_block_that_hangs_under_two_tips_falls_however_thin_they_are(tip, thick, length, turn):
    scene = hung(tip(thick, length), turn)
    verdict = assess(scene)
    assert verdict.outcome is Outcome.UNSTABLE
    assert verdict.interfaces.pair.tolist() == [[0, 2], [1, 2]]
    np.testing.assert_allclose(verdict.interfaces.frame[:, 0], [turn @ (0, 0, -1)] * 2, atol=1e-12)
    np.testing.assert_allclose(verdict.interfaces.area, length, rtol=1e-9)


def test_beds_that_overlap_less_than_they_are_thick_stay_joints():
    """A tile of 4 mm that sinks .5 mm into its bed: the shorter way out is up, and the tile carries the block on it."""
    tile = box((0, 0, -0.0005), (0.3, 0.3, 0.0035), name="tile")
    above = box((0, 0, 0.0035), (0.3, 0.3, 0.3), name="above")
    scene = Assembly.from_blocks(
        [box((-1, -1, -1), (1, 1, 0), name="bed"), tile, above], supports=["bed"], friction=0.6
    )
    assert find_interfaces(scene).pair.tolist() == [[0, 1], [1, 2]]
    assert assess(scene).outcome is Outcome.STABLE


def test_a_push_down_on_hooked_tips_is_not_carried():
    limit = limit_load(hung(feather(0.002, 0.2)), (0, 0, -1))
    assert limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE
