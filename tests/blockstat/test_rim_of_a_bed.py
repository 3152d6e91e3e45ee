"""At the rim of a bed that is open or overlaps by a fraction of a millimetre there is no key; a step is one.

Friction is .5, so that a block slides from 26.6 degrees on, and is pushed off by half its weight. It is
too flat to tip.
"""

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, Outcome, assess, find_interfaces, limit_load
from blockstat.contact.features import ContactKind
from evidence.scenes.small import box, prism

FRICTION = 0.5
STEEP = np.radians(35.0)
GAPS = (-2e-4, -1e-4, -1e-5, 0.0, 1e-5, 1e-4, 2e-4)
#: Turns of all there is and orders of the blocks do not change an answer.
TURNS = {"as drawn": np.eye(3), "turned": Rotation.from_rotvec([0.4, -0.9, 1.3]).as_matrix()}
PLACES = [pytest.param(turn, order, id=f"{name}-{order}") for (name, turn), order in product(TURNS.items(), (1, -1))]
SIDEWAYS = [sign * axis for axis in np.eye(3)[:2] for sign in (1.0, -1.0)]


def leaning(blocks, toward, turn, order, angle=STEEP):
    """Set blocks of which the first is the support on a slope that falls that way, in a place and an order."""
    gravity = 9.81 * (np.sin(angle) * np.asarray(toward, float) - np.cos(angle) * np.array([0.0, 0.0, 1.0]))
    turned = [Block(np.asarray(block.vertices, float) @ turn.T, block.faces) for block in blocks][::order]
    support = 0 if order > 0 else len(blocks) - 1
    return Assembly.from_blocks(turned, supports=[support], friction=FRICTION, gravity=turn @ gravity)


def in_halves(block, first):
    """Divide each quadrilateral of a block along its first or its second diagonal."""
    ways = [[(0, 1, 2), (0, 2, 3)], [(0, 1, 3), (1, 2, 3)]]
    halves = [[face[k] for k in half] for face, one in zip(block.faces, first, strict=True) for half in ways[int(one)]]
    return Block(block.vertices, halves)


def flush(seed, gap):
    """A block on another, sides flush: corners off by up to .05 mm, faces in two triangles, the bed open by a gap."""
    rng = np.random.default_rng(seed)
    step = rng.choice([1e-5, 1e-4])
    rise = step * rng.choice([0.0, 0.1, 1.0])
    blocks = []
    for low, high in ((-0.5, 0.0), (gap, gap + 0.25)):
        whole = box((0, 0, low), (1, 0.6, high))
        corners = np.asarray(whole.vertices, float) + rng.uniform(-0.5, 0.5, (8, 3)) * [step, step, rise]
        blocks.append(in_halves(Block(corners, whole.faces), rng.random(6) >= 0.5))
    return blocks


def slides(blocks, turn, order):
    for toward in SIDEWAYS:
        assert assess(leaning(blocks, toward, turn, order)).outcome is Outcome.UNSTABLE
        push = limit_load(leaning(blocks, toward, turn, order, angle=0.0), turn @ toward)
        # A bed whose corners are off by .05 mm leans by some 2e-4.
        assert (push.lower, push.upper) == pytest.approx((FRICTION, FRICTION), abs=5e-4)


@pytest.mark.parametrize(("turn", "order"), PLACES)
@pytest.mark.parametrize("seed", [2, 12, 17, 43, 66, 82, 276, 481, 719])
@pytest.mark.parametrize("gap", GAPS)
def test_a_block_flush_with_the_one_below_it_slides_whatever_the_error_of_its_bed(gap, seed, turn, order):
    slides(flush(seed, gap), turn, order)


GROUND = [(-0.5, -1), (2, -1), (2, 0), (0, 0)]


def before_a_step(height, gap, lean):
    """A block 25 cm high whose lower edge is at the foot of a step; its front leans back by a length at its top."""
    step = prism([*GROUND, (0, height), (-0.5, height)], 1.0)
    block = prism([(0, gap), (0.6, gap), (0.6, gap + 0.25), (lean, gap + 0.25)], 0.6)
    return [step, Block(np.asarray(block.vertices, float) + [0, 0.2, 0], block.faces)]


@pytest.mark.parametrize(("turn", "order"), PLACES)
@pytest.mark.parametrize("gap", [0.0, 1e-6, 1e-5, 1e-4, 1e-3])
def test_the_foot_of_a_wall_holds_an_edge_on_a_bed_that_is_open(gap, turn, order):
    asm = leaning(before_a_step(1.0, gap, lean=0.1), [-1, 0, 0], turn, order)
    assert find_interfaces(asm).kinds.tolist() == [ContactKind.FACE, ContactKind.EDGE]
    assert assess(asm).outcome is Outcome.STABLE


@pytest.mark.parametrize(("turn", "order"), PLACES)
@pytest.mark.parametrize("lean", [0.0, 0.05, 0.1])
@pytest.mark.parametrize(("height", "gap"), [(0.02, 1e-4), (0.02, 1e-3), (1e-3, 0.0), (1e-3, 1e-5), (1e-3, 1e-4)])
def test_a_step_higher_than_the_bed_is_open_is_a_key(height, gap, lean, turn, order):
    asm = leaning(before_a_step(height, gap, lean), [-1, 0, 0], turn, order)
    assert assess(asm).outcome is Outcome.STABLE


@pytest.mark.parametrize(("turn", "order"), PLACES)
@pytest.mark.parametrize("lean", [0.0, 0.05])
def test_a_step_higher_than_the_bed_overlaps_is_a_key(lean, turn, order):
    asm = leaning(before_a_step(0.02, -1e-4, lean), [-1, 0, 0], turn, order)
    assert assess(asm).outcome is Outcome.STABLE


@pytest.mark.parametrize("seed", [5, 13, 122, 412])
def test_two_edges_that_cross_past_the_rim_are_no_key(seed):
    slides(flush(seed, -1e-4), np.eye(3), 1)


def post():
    """A floor and a post on it of one stone; the arris of the post rises from the floor at (0, .5, 0)."""
    floor, foot = [(-0.5, 0), (2, 0), (2, 1), (-0.5, 1)], [(-0.5, 0.8), (0, 0.5), (-0.5, 0.2)]
    corners = [*((x, y, 0) for x, y in floor + foot), *((x, y, -1) for x, y in floor), *((x, y, 1) for x, y in foot)]
    below = [[10, 9, 8, 7], [7, 8, 1, 0], [8, 9, 2, 1], [9, 10, 3, 2], [10, 7, 0, 6, 13, 11, 4, 3]]
    return Block(np.array(corners, float), [[*range(7)], *below, [4, 11, 12, 5], [5, 12, 13, 6], [11, 13, 12]])


@pytest.mark.parametrize("gap", [-1e-4, 1e-6, 1e-5, 1e-4, 1e-3])
def test_the_arris_of_a_post_holds_an_edge_on_a_bed_that_is_open(gap):
    # The edge meets the middle of the arris' foot, so that the block neither turns nor, as it is flat, tips.
    _, block = before_a_step(1.0, gap, lean=0.05)
    asm = leaning([post(), block], [-1, 0, 0], np.eye(3), 1)
    assert assess(asm).outcome is Outcome.STABLE


def before_a_wedge(height, near, far):
    """As before a step; the bed is open by one length at the step and by another one at the far end."""
    step, _ = before_a_step(height, 0.0, 0.0)
    block = prism([(0, near), (0.6, far), (0.6, 0.25), (0.1, 0.25)], 0.6)
    return [step, Block(np.asarray(block.vertices, float) + [0, 0.2, 0], block.faces)]


@pytest.mark.parametrize(("turn", "order"), PLACES)
@pytest.mark.parametrize(
    ("height", "near", "far"), [(6e-3, 0.0, 4e-3), (1.5e-3, 1e-3, 1e-3), (2.5e-3, 1e-3, 1e-3), (0.011, 4e-3, 4e-3)]
)
def test_a_step_that_reaches_past_an_open_bed_is_a_key(height, near, far, turn, order):
    asm = leaning(before_a_wedge(height, near, far), [-1, 0, 0], turn, order)
    assert assess(asm).outcome is Outcome.STABLE


def beside_a_nose(gap):
    """A block flush with the rim of its bed, which has a re-entrant corner at (1, 0); a pyramid on the bed is a key.

    Its apex at (1.25, 0, .06) touches the side of the block. At (1, 0) only an overlap does.
    """
    plan = [(0, 0), (1, 0), (1, -0.3), (1.5, -0.3), (1.5, 0.6), (0, 0.6)]
    foot = [(1.2, -0.2, 0), (1.3, -0.2, 0), (1.3, -0.1, 0), (1.2, -0.1, 0), (1.25, 0, 0.06)]
    corners = [*((x, y, 0) for x, y in plan), *((x, y, -0.5) for x, y in plan), *foot]
    top = [[0, 1, 5], [1, 4, 5], [1, 2, 12, 15], [2, 3, 13, 12], [3, 4, 14], [3, 14, 13], [4, 1, 15], [4, 15, 14]]
    nose = [[12, 13, 16], [13, 14, 16], [14, 15, 16], [15, 12, 16]]
    sides = [[k, k + 6, (k + 1) % 6 + 6, (k + 1) % 6] for k in range(6)]
    bed = Block(np.array(corners, float), [*top, *nose, [*range(11, 5, -1)], *sides])
    return [bed, box((0, 0, gap), (1.5, 0.6, gap + 0.25))]


@pytest.mark.parametrize(("turn", "order"), PLACES)
def test_a_key_keeps_no_overlap_beside_it_in_being(turn, order):
    """A push at x = .3 turns the block about the nose; the bed then resists by friction alone.

    With all of the weight on the two corners that are furthest from the nose, at 1.387 and .650 m, it resists by no
    more than mu (1.387 + .650) / 2 / (1.25 - .3) = .536 of the weight.
    """
    asm = leaning(beside_a_nose(-1e-4), SIDEWAYS[0], turn, order, angle=0.0)
    free = int(np.flatnonzero(~asm.support)[0])
    push = turn @ np.array([0, -asm.free_weight, 0])
    arm = turn @ np.array([0.3 - 0.75, 0, 0])
    load = np.zeros((2, 6))
    load[free] = [*push, *np.cross(arm, push)]
    assert limit_load(asm, load).upper < 0.5 * (1.387 + 0.650) / 2 / 0.95


def test_a_ridge_that_touches_the_other_way_is_looked_at():
    """A tongue in a slot 3 mm higher than it: its ridge is at the ceiling of the slot, opposed to the bed below."""
    open_, top = 8e-3, 11.5e-3
    slot = [(-0.6, -1), (-0.01, -1), (-0.01, 0), (-0.5, 0), (-0.5, top), (-0.01, top), (-0.01, 1), (-0.6, 1)]
    tongue = [(-0.05, open_ + 5e-4), (-0.056, open_ + 3e-3), (-0.062, open_ + 5e-4), (-0.062, open_), (0, open_)]
    block = prism([(0, -0.5), (1, -0.5), (1, 0.5), (0, 0.5), (0, open_ + 5e-4), *tongue], 1.0)
    wall = prism(slot, 1.2)
    asm = Assembly.from_blocks([Block(np.asarray(wall.vertices) - [0, 0.1, 0], wall.faces), block], supports=[0])
    assert len(find_interfaces(asm).pair) == 3


def test_nothing_is_said_of_a_support_of_two_solids_when_its_blocks_are_moved_apart(recwarn):
    bed, block = flush(5, -1e-4)
    far = box((5, 0, -1), (6, 1, 0))
    corners = np.concatenate([bed.vertices, far.vertices])
    faces = [*bed.faces, *([k + len(bed.vertices) for k in face] for face in far.faces)]
    asm = Assembly.from_blocks([Block(corners, faces), block], supports=[0])
    recwarn.clear()
    find_interfaces(asm)
    assert not recwarn
