"""Blocks that slide over the edge or the corner of their bed: their curves do not depend on how a scene is turned."""

import numpy as np
import pytest

from blockstat import Assembly, Block, box, capacity
from blockstat.model.solids import prism

FAR = (5e5, 4.6e6, 0.0)
DIAGONAL = (0.5**0.5, 0.5**0.5, 0.0)


def curve_of(bed, block, along, turn, offset, friction, flow):
    """The curve of a block that is pushed along a bed, both turned about the vertical and moved."""
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    blocks = [Block(each.vertices @ rotation.T + offset, each.faces, name=each.name) for each in (bed, block)]
    scene = Assembly.from_blocks(blocks, supports=["bed"], friction=friction)
    return capacity(scene, rotation @ along, control="block", flow=flow)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (0.2, 0.8), (-0.1, 0.8)])
@pytest.mark.parametrize(
    ("turn", "offset", "friction"),
    [(0.0, (0, 0, 0), 0.4), (0.3, FAR, 0.4), (0.7, FAR, 0.4), (0.7, (0, 0, 0), 0.15), (6.2138198693009725, FAR, 0.4)],
)
def test_a_block_that_dilates_turns_where_its_force_leaves_the_bed(low, high, turn, offset, friction):
    """A cube of 1 m, whose centre is .8 m from the edge of its bed, rises by m d as it slides by d against friction m.

    The resultant of its weight and of the push m times as large goes through its centre, .5 + m d above the bed, which
    it meets m (.5 + m d) further on. That is at the edge where d + m (.5 + m d) = .8. There the joint is open by m d.
    From there on the block turns about the middle of it, which is b = .5 + m d / 2 below its centre and m b beside it:
    the push is then tan of the angle of that arm from the vertical, and zero when the centre is above its foot. None
    of this depends on how wide the block is, or on where its sides are beside those of the bed.
    """
    bed, block = box((0, 0, 0), (1.5, 1, 1), name="bed"), box((0.2, low, 1), (1.2, high, 2), name="block")
    curve = curve_of(bed, block, (1, 0, 0), turn, offset, friction, "associated")
    at_edge = (0.8 - 0.5 * friction) / (1 + friction**2)
    below = 0.5 + 0.5 * friction * at_edge
    end = at_edge + friction * below
    beside = np.minimum(end - curve.displacement, friction * below)
    expected = beside / np.sqrt(below**2 * (1 + friction**2) - beside**2)
    assert curve.outcome.word == "zero"
    assert curve.lower == pytest.approx(expected, abs=1e-4 * friction)
    assert curve.displacement[-1] == pytest.approx(end, rel=1e-5)
    assert [event.kind for event in curve.events] == ["change"]
    assert curve.events[0].parameter == pytest.approx(at_edge, rel=1e-5)


@pytest.mark.parametrize(("turn", "offset"), [(0.0, (0, 0, 0)), (1.2, FAR), (3.81, FAR), (0.257, FAR)])
@pytest.mark.parametrize("flow", ["coulomb", "associated"])
def test_a_block_that_slides_to_the_corner_of_its_bed_turns_over_an_edge(turn, offset, flow):
    """A cube of .6 m in the middle of a square of 1 m slides along the diagonal, at friction .3.

    Its centre is .3 m above the bed, and the corner is .5 sqrt(2) away. The resultant is there where d + .3 x .3 is
    as much; with dilatancy the centre has risen by .3 d, and (1 + .09) d + .09 is as much. On the corner alone the cube
    would be as a ball on a ridge, and most turns about it leave that at once. About one of the edges it turns until its
    centre is above that edge. The resultant was .3 b further than the centre along the diagonal, with b = .3, or with
    dilatancy .3 + .15 d below the centre. So the centre has .3 b cos 45 to go across the edge, of which cos 45 is along
    the push.
    """
    bed, block = box((0, 0, 0), (1, 1, 0.5), name="bed"), box((0.2, 0.2, 0.5), (0.8, 0.8, 1.1), name="block")
    curve = curve_of(bed, block, DIAGONAL, turn, offset, 0.3, flow)
    rise = 0.3 if flow == "associated" else 0.0
    at_corner = (0.5**0.5 - 0.09) / (1 + 0.3 * rise)
    below = 0.3 + 0.5 * rise * at_corner
    assert curve.outcome.word == "zero"
    assert curve.lower[curve.displacement <= at_corner] == pytest.approx(0.3, rel=1e-5)
    assert curve.displacement[-1] == pytest.approx(at_corner + 0.3 * below / 2, rel=1e-5)
    assert [event.kind for event in curve.events] == ["change"]


@pytest.mark.parametrize(("turn", "offset"), [(0.0, FAR), (0.5 * np.pi, FAR), (3.9276, FAR)])
def test_the_many_corners_of_a_joint_on_an_l_shaped_bed_do_not_hold_a_block(turn, offset):
    """A block of .8 x .6 x .8 m slides along the diagonal over the inner corner of its bed, (.9, .8), at friction .3.

    Two of its sides cross the two edges there, at (.9, .7 + u) and (.9 + u, .8) after a slip of u in x and in y, and
    all corners of the joint are on one side of the line through both. Its centre was at (.5, .4), so the resultant is
    at (.5 + u + k, .4 + u + k), with k = .3 x .4 cos 45. That is on the line where

        (u - .1) (u + k - .4) + u (k - .3) = 0.

    As the block rises by .3 of its slip d, its force meets the bed .09 d further on, and its sides do so as well:
    u = 1.09 d cos 45.
    """
    corners = np.array([(0, 0), (1.6, 0), (1.6, 0.8), (0.9, 0.8), (0.9, 1.6), (0, 1.6)])
    bed = prism(np.c_[corners, np.zeros(6)], np.c_[corners, np.ones(6)], name="bed")
    block = box((0.1, 0.1, 1), (0.9, 0.7, 1.8), name="block")
    curve = curve_of(bed, block, DIAGONAL, turn, offset, 0.3, "associated")
    k = 0.12 * 0.5**0.5
    u = max(np.roots([1.0, 2 * k - 0.8, 0.1 * (0.4 - k)]))
    assert [event.kind for event in curve.events] == ["change"]
    assert curve.events[0].parameter == pytest.approx(u * 2**0.5 / 1.09, rel=1e-5)
    assert curve.outcome.word == "zero"
