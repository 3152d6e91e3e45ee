"""Paths and curves do not depend on how large supports are, whether blocks stand on them or not."""

from functools import cache

import numpy as np
import pytest

from blockstat import Assembly, InputError, box, capacity, find_interfaces, settle, settle_to_collapse
from blockstat.large_displacement.displaced.contact_pairs import pairs_at_rest
from blockstat.large_displacement.linkage import after_event, jump
from blockstat.large_displacement.linkage.kinematics import pose_at
from evidence.scenes.small import prism
from tests.validation.test_large_displacement import SPREADING, assembled, voussoirs

#: A block of 0.48 m by 0.88 m in four parts, and a wall of bricks.
STACK = [box((0.02, 0.02, 0.5 * k), (0.5, 0.9, 0.5 * k + 0.5), name=f"block {k}") for k in range(4)]
WIDTHS = [(0.4 * (n - k % 2 / 2), 0.4 * (n - k % 2 / 2) + 0.4, k) for k in range(3) for n in range(2 + k % 2)]
BRICKS = [
    box((max(a, 0) + 0.1, 0.3, 0.2 * k), (min(b, 0.8) + 0.1, 0.55, 0.2 * k + 0.2), name=f"brick {k} {a:.1f}")
    for a, b, k in WIDTHS
]


@pytest.fixture(autouse=True)
def tried(monkeypatch):
    """The poses that jumps ask for; a jump that would never end fails."""
    asked = []

    def counted(*arguments, **options):
        asked.append(arguments)
        assert len(asked) <= 2 * jump.MAX_TRIALS
        return pose_at(*arguments, **options)

    monkeypatch.setattr(jump, "pose_at", counted)
    return asked


#: Bearings of the lintel narrower than this are none: a millionth of the smaller block (`CORNER_TOLERANCE`), here of at
#: most 1 m, and as much again by which the fall is located.
NO_BEARING = 2e-6


def lintel(side, *beside):
    """A lintel of 2.5 m that lies by 0.5 m on each of two cubes, and blocks that touch nothing."""
    low, high = 0.5 - side / 2, 0.5 + side / 2
    cubes = [box((0.5 - side, low, -side), (0.5, high, 0), name="left")]
    cubes.append(box((2, low, -side), (2 + side, high, 0), name="right"))
    blocks = [*cubes, box((0, 0, 0), (2.5, 1, 0.3), name="lintel"), *beside]
    supports = ["left", "right", *(block.name for block in beside)]
    return Assembly.from_blocks(blocks, supports=supports, friction=0.7, density=2000.0)


@pytest.mark.parametrize("side", [1, 3, 6, 12, 1000])
def test_a_lintel_falls_when_its_bearing_is_used_up_however_large_the_abutments_are(side):
    found = settle_to_collapse(lintel(side), {"right": (1, 0, 0)})
    assert found.outcome.word == "collapse"
    assert found.collapse == pytest.approx(0.5, abs=NO_BEARING)


@pytest.mark.parametrize("side", [2, 4, 100])
def test_a_support_that_touches_nothing_does_not_matter(side):
    far = box((-side, -side, -2 - 2 * side), (side, side, -2), name="far below")
    found = settle_to_collapse(lintel(1, far), {"right": (1, 0, 0)})
    assert found.outcome.word == "collapse"
    assert found.collapse == pytest.approx(0.5, abs=NO_BEARING)


@cache
def spreading(number, thickness, factor):
    """An arch on feet that reach so many times as far outwards, sideways and down."""
    y, z = (0.5 - 0.5 * factor, 0.5 + 0.5 * factor), (-0.3 * factor, 0)
    feet = [
        box((x0, y[0], z[0]), (x1, y[1], z[1]), name=name)
        for x0, x1, name in ((-0.7 - 0.6 * factor, -0.7, "left"), (0.7, 0.7 + 0.6 * factor, "right"))
    ]
    ring = assembled([*voussoirs(number, thickness), *feet], supports=("left", "right"), friction=0.7)
    return settle_to_collapse(ring, {"right": (1, 0, 0)})


@pytest.mark.parametrize(
    ("shape", "factor"), [*((shape, 10) for shape in SPREADING), ((10, 0.15), 1000), ((20, 0.15), 1000)], ids=str
)
def test_an_arch_falls_at_the_same_movement_on_feet_of_any_size(shape, factor):
    one, other = spreading(*shape, 1), spreading(*shape, factor)
    assert one.collapse == pytest.approx(SPREADING[shape][2], rel=1e-3)
    assert other.outcome.word == "collapse"
    assert other.collapse == pytest.approx(one.collapse, rel=1e-9)


def on_slab(blocks, side):
    ground = box((0.5 - side / 2, 0.5 - side / 2, -side), (0.5 + side / 2, 0.5 + side / 2, 0), name="ground")
    return Assembly.from_blocks([ground, *blocks], supports=["ground"], friction=0.6, density=2000.0)


def alike(one, other):
    """Whether two curves are the same but for rounding, and have as many points."""
    assert one.outcome is other.outcome
    assert len(one.points) == len(other.points)
    assert one.displacement == pytest.approx(other.displacement, rel=1e-9, abs=1e-12)
    assert one.lower == pytest.approx(other.lower, rel=1e-9, abs=1e-9 * one.lower[0])


@pytest.mark.parametrize(("blocks", "load"), [(STACK, (1, 0, 0)), (BRICKS, (0, 1, 0))], ids=["stack", "wall"])
def test_the_curve_of_a_wall_is_the_same_on_a_slab_of_any_size(blocks, load):
    small = capacity(on_slab(blocks, 1), load, control=blocks[-1].name)
    for side in (100, 1000):
        alike(capacity(on_slab(blocks, side), load, control=blocks[-1].name), small)


def test_bricks_that_slide_in_the_plane_of_their_wall_go_the_same_way_on_a_slab_of_any_size():
    """With the same joints: which of many equal mechanisms is found depends on their last digits."""
    joints = find_interfaces(on_slab(BRICKS, 1))
    small, large = (capacity(on_slab(BRICKS, side), (1, 0, 0), interfaces=joints) for side in (1, 1000))
    assert any("finite steps" in text for text in small.warnings)
    alike(large, small)


@pytest.mark.parametrize("side", [1, 1000])
def test_a_corner_beside_the_corner_of_the_ground_is_not_that_corner(side):
    beside = [box((5e-4, 5e-4, 0), (0.5, 0.5, 0.5), name="block")]
    ground = box((0, 0, -side), (side, side, 0), name="ground")
    asm = Assembly.from_blocks([ground, *beside], supports=["ground"], friction=0.6, density=2000.0)
    pairs = pairs_at_rest(asm, find_interfaces(asm))
    assert pairs.corner.tolist() == [[False, True]] * 4


def stepped(side):
    """Ground that is 0.3 m lower from x = 0 on, so far to all sides."""
    profile = [(-side, -side), (side, -side), (side, -0.3), (0, -0.3), (0, 0), (-side, 0)]
    return prism(profile, side, name="ground")


@pytest.mark.parametrize("side", [2, 1000])
def test_a_block_slides_to_the_edge_of_a_step_however_large_the_ground_is(side):
    """Friction 0.1 at half the height of 0.2 m: the resultant is 0.01 m before the centroid, 0.25 m behind the edge.

    So it turns from 0.24 m on, and falls when its centroid is above the edge.
    """
    block = box((-0.5, 0.1, 0), (0, 0.6, 0.2), name="block")
    asm = Assembly.from_blocks([stepped(side), block], supports=["ground"], friction=0.1, density=2000.0)
    curve = capacity(asm, (1, 0, 0), control="block", displacement=0.3)
    assert [event.kind for event in curve.events] == ["change"]
    assert curve.events[0].parameter == pytest.approx(0.24, rel=1e-3)
    assert curve.displacement[-1] == pytest.approx(0.25, rel=1e-3)


def test_a_jump_that_creeps_is_given_up_as_not_followed(monkeypatch, tried):
    landings = []

    def creeping(linkage, start, parameter, step, **options):
        tried.append(step)
        return pose_at(linkage, start, parameter, step, **options) if np.abs(step).max() < 1e-7 else None

    def recorded(*arguments):
        landings.append(jump.jump(*arguments))
        return landings[-1]

    monkeypatch.setattr(jump, "pose_at", creeping)
    monkeypatch.setattr(after_event, "jump", recorded)
    ring = assembled(
        [
            *voussoirs(20, 0.2),
            box((-1.3, 0, -0.3), (-0.7, 1, 0), name="left"),
            box((0.7, 0, -0.3), (1.3, 1, 0), name="right"),
        ],
        supports=("left", "right"),
        friction=0.7,
    )
    capacity(ring, (1, 0, 0), displacement=0.3)
    assert landings
    assert landings[0].linkage is None
    assert not landings[0].fell
    assert len(tried) == jump.MAX_TRIALS


@pytest.mark.parametrize("side", [0.05, 0.5, 50])
def test_a_joint_may_stick_out_of_a_region_by_the_rounding_of_the_block_on_it(side):
    """Of a block of 1 m a millionth is rounding, on a support of any size."""
    place = [box((-side / 2, -side / 2, -side), (side / 2, side / 2, 0), name="stone")]
    asm = Assembly.from_blocks([*place, box((-0.5, -0.5, 0), (0.5, 0.5, 1), name="block")], supports=["stone"])
    edge = min(side, 1.0) / 2
    moved = settle(asm, {(5e-7 - edge, -1, -1, 1, 1, 1): (0, 0, -0.01)})
    assert moved.foundations[0].joints.tolist() == [0]
    with pytest.raises(InputError, match="partly"):
        settle(asm, {(5e-6 - edge, -1, -1, 1, 1, 1): (0, 0, -0.01)})
