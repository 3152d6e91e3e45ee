"""Blocks on shims: what is held apart, what still touches, and what lies beside. The answers are those of a beam."""

import numpy as np
import pytest

from blockstat import Assembly, Block, Outcome, assess, box, find_interfaces
from evidence.scenes.small import prism

#: Turns about the vertical, places as in a national grid, and orders of the blocks do not change an answer.
PLACES = {"here": (0.0, (0, 0, 0)), "turned": (0.7, (3, -2, 1)), "in a grid": (2.0, (5e5, 5e6, 0))}
ORDERS = {"as listed": 1, "reversed": -1}

BASE = box((-1, -1, -1), (2, 2, 0))


@pytest.fixture(params=[(place, order) for place in PLACES for order in ORDERS], ids="-".join)
def placed(request):
    """Set up blocks of which the first is the support; return the answer, the contacts and the number of each block."""
    turn, offset = PLACES[request.param[0]]
    step = ORDERS[request.param[1]]
    c, s = np.cos(turn), np.sin(turn)

    def build(blocks):
        turned = [
            Block(np.asarray(b.vertices) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + offset, b.faces)
            for b in blocks
        ]
        number = np.arange(len(blocks))[::step]
        asm = Assembly.from_blocks(turned[::step], supports=[int(np.flatnonzero(number == 0)[0])])
        found = find_interfaces(asm)
        pairs = {frozenset(number[pair].tolist()) for pair in found.pair}
        return assess(asm).outcome, pairs, found

    return build


def cube_on(bottom, *, cuts=(), triangles=False):
    """Unit cube over x = 0 to 1 whose lower face is divided by lines x = const, and each part into two triangles."""
    xs = [0.0, *cuts, 1.0]
    n = len(xs)
    vertices = [(x, y, bottom) for y in (0, 1) for x in xs]
    vertices += [(x, y, 1 + bottom) for y in (0, 1) for x in (0, 1)]
    parts = [[i, n + i, n + i + 1, i + 1] for i in range(n - 1)]
    if triangles:
        parts = [three for a, b, c, d in parts for three in ([a, b, c], [a, c, d])]
    top = [2 * n, 2 * n + 1, 2 * n + 3, 2 * n + 2]
    front, back = [*range(n), top[1], top[0]], [*range(2 * n - 1, n - 1, -1), top[3], top[2]]
    return Block(vertices, [*parts, top, front, back, [n - 1, 2 * n - 1, top[2], top[1]], [n, 0, top[0], top[3]]])


@pytest.mark.parametrize("triangles", [False, True])
@pytest.mark.parametrize("cuts", [(), (0.45,), (0.05, 0.2, 0.35, 0.6, 0.8)])
@pytest.mark.parametrize(("end", "outcome"), [(0.4, Outcome.UNSTABLE), (0.7, Outcome.STABLE)])
def test_a_cube_on_shims_stands_where_its_weight_is_between_them(placed, end, outcome, cuts, triangles):
    # The weight acts at x = .5. It is carried from x = 0 to `end` alone, for the rest of the base is 2 mm below.
    shims = [box((0, 0.1, 0), (0.1, 0.9, 0.002)), box((end - 0.1, 0.1, 0), (end, 0.9, 0.002))]
    found, pairs, _ = placed([BASE, cube_on(0.002, cuts=cuts, triangles=triangles), *shims])
    assert found is outcome
    assert pairs == {frozenset(pair) for pair in ((0, 2), (0, 3), (1, 2), (1, 3))}


@pytest.mark.parametrize("width", [1e-4, 1e-2])
def test_a_cube_on_wires_is_held_by_them_however_thin(placed, width):
    # As on shims: the wires end at x = .4, before the weight.
    wires = [box((x - width, 0.1, 0), (x, 0.9, 0.002)) for x in (0.1, 0.4)]
    found, pairs, _ = placed([BASE, cube_on(0.002), *wires])
    assert found is Outcome.UNSTABLE
    assert frozenset((0, 1)) not in pairs


@pytest.mark.parametrize("open_", [0.0, 1e-8, 1e-6, 1e-4])
@pytest.mark.parametrize(("shim", "outcome"), [(0.0, Outcome.STABLE), (0.6, Outcome.UNSTABLE)])
def test_a_block_on_a_shim_and_on_its_edge_is_a_beam_on_two_supports(placed, open_, shim, outcome):
    # The edge is at x = 1, the weight near .5: between the edge and a shim at 0, beside those at .55 to .65 and 1.
    slope = -0.002 / np.sqrt(1 - 0.002**2)
    c, s = np.sqrt(1 - 0.002**2), 0.002
    block = prism([(1 - c, s + open_), (1, open_), (1 + s, c + open_), (1 - c + s, s + c + open_)], 1.0)
    left, right = shim - 0.05, shim + 0.05
    top = [s + open_ + slope * (x - (1 - c)) for x in (left, right)]
    pad = prism([(left, 0), (right, 0), (right, top[1]), (left, top[0])], 1.0)
    found, pairs, contacts = placed([BASE, block, pad])
    assert found is outcome
    assert frozenset((0, 1)) in pairs
    assert contacts.contacts["edge"] == 1


@pytest.mark.parametrize("open_", [0.0, 1e-8, 1e-3])
def test_an_edge_on_another_level_than_the_shim_carries(placed, open_):
    # A beam on a shim at x = .1 to .2 and on its wedge at x = 2, half a metre above the shim.
    base = prism([(-1, -1), (3, -1), (3, 0.5), (1.5, 0.5), (1.5, 0), (-1, 0)], 1.0)
    wedge = [(1.7, 0.8), (2, 0.5 + open_), (2.3, 0.8)]
    beam = prism([(0, 0.002), (0.3, 0.002), (0.3, 0.8), *wedge, (2.3, 1.5), (0, 1.5)], 1.0)
    found, pairs, contacts = placed([base, beam, box((0.1, 0.1, 0), (0.2, 0.9, 0.002))])
    assert found is Outcome.STABLE
    assert pairs == {frozenset(pair) for pair in ((0, 1), (0, 2), (1, 2))}
    assert contacts.contacts["edge"] == 1


@pytest.mark.parametrize("divided", [False, True])
@pytest.mark.parametrize(("open_", "over"), [(0, 0), (1e-5, 0), (0, 2e-5), (1e-5, 2e-5), (1e-4, 1e-4), (1e-5, 9e-4)])
def test_a_feather_edge_drawn_too_long_leaves_the_bed_beside_it(placed, open_, over, divided):
    # The weight at x = -.2 stands on the bed from -1.4 to 0; the wedge beside it bears from 0 on alone.
    t = np.tan(np.deg2rad(10))
    base = prism([(-2, -1), (1, -1), (1, -t), (0, 0), (-2, 0)], 1.0)
    feather = prism([(-over, open_), (1, -t), (1, open_)], 1.0)
    bed = [(-1.4, open_), *([(-0.5, open_)] if divided else []), (1, open_)]
    found, pairs, _ = placed([base, feather, prism([*bed, (1, 1), (-1.4, 1)], 1.0)])
    assert found is Outcome.STABLE
    assert frozenset((0, 2)) in pairs


@pytest.mark.parametrize(
    ("tip", "outcome"), [(0.002, Outcome.UNSTABLE), (0.001, Outcome.UNSTABLE), (1e-4, Outcome.STABLE)]
)
def test_an_edge_in_the_plane_of_the_shim_carries_where_it_is_drawn_to_meet(placed, tip, outcome):
    # The beam of 2.3 m tips about its shim at x = .1 to .2 unless its wedge at x = 2 meets the base, 2 mm below.
    wedge = [(1.7, 0.8), (2, tip), (2.3, 0.8)]
    beam = prism([(0, 0.002), (0.3, 0.002), (0.3, 0.8), *wedge, (2.3, 1.5), (0, 1.5)], 1.0)
    base = box((-1, -1, -1), (3, 2, 0))
    found, pairs, _ = placed([base, beam, box((0.1, 0.1, 0), (0.2, 0.9, 0.002))])
    assert found is outcome
    assert (frozenset((0, 1)) in pairs) is (outcome is Outcome.STABLE)


@pytest.fixture(params=list(PLACES))
def turned(request):
    """Turn blocks and a direction about the vertical, and move the blocks."""
    turn, offset = PLACES[request.param]
    c, s = np.cos(turn), np.sin(turn)
    across = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])

    def build(blocks, direction, **options):
        moved = [Block(np.asarray(b.vertices, float) @ across + offset, b.faces) for b in blocks]
        direction = np.asarray(direction, float) @ across
        return Assembly.from_blocks(moved, **{"supports": [0], "friction": 0.5} | options), direction

    return build


#: Tangent of a slope of 35 degrees; the coefficient of friction is .5.
STEEP = np.array([np.sin(np.deg2rad(35)), 0, -np.cos(np.deg2rad(35))])


def on_a_slope(turned, blocks, supports):
    _, down = turned(blocks, 9.81 * STEEP)
    return assess(turned(blocks, down, supports=supports, gravity=down)[0])


@pytest.mark.parametrize("sunk", [0.0, 1e-5, 1e-4, 1e-3, 4e-3])
@pytest.mark.parametrize("higher", [0.0, -1e-3, 0.01, 0.5])
@pytest.mark.parametrize("divided", [False, True])
def test_a_floor_of_two_blocks_holds_no_more_than_one_however_a_block_sinks_into_it(turned, divided, higher, sunk):
    # The front of the block is at the joint of the floors. It slides, unless the second floor is higher.
    if divided:
        floor = [box((0, 0, -0.5), (1, 1, 0)), box((1, 0, -0.5), (2, 1, higher))]
    else:
        floor = [prism([(0, -0.5), (2, -0.5), (2, higher), (1, higher), (1, 0), (0, 0)], 1.0)]
    block = box((0.4, 0.2, -sunk), (1, 0.8, 0.25))
    found = on_a_slope(turned, [*floor, block], list(range(len(floor))))
    assert found.outcome is (Outcome.STABLE if higher > 0 else Outcome.UNSTABLE)
    reasons = {dropped.reason for dropped in found.interfaces.dropped}
    assert ("overlap" in reasons) is (divided and sunk > max(-higher, 0) and higher <= 0)


@pytest.mark.parametrize("sunk", [1e-5, 1e-4, 1e-3])
def test_bricks_in_stack_bond_with_beds_that_overlap_have_no_keys(turned, sunk):
    # Two piles side by side on one support: on the slope both upper bricks slide down, and nothing stands before them.
    ground = box((0, 0, -0.5), (3, 1, 0))
    lower = [box((1, 0, 0), (1.4, 0.4, 0.2)), box((1.4, 0, 0), (1.8, 0.4, 0.2))]
    upper = [box((x, 0.05, 0.2 - sunk), (x + 0.4, 0.35, 0.4)) for x in (1, 1.4)]
    found = on_a_slope(turned, [ground, *lower, upper[0]], [0, 1, 2])
    assert found.outcome is Outcome.UNSTABLE
    found = on_a_slope(turned, [ground, *lower, *upper], [0, 1, 2])
    assert found.outcome is Outcome.UNSTABLE
    pairs = {tuple(pair) for pair in found.interfaces.pair.tolist()}
    assert pairs == {(1, 3), (2, 4), (3, 4)}


@pytest.mark.parametrize("thin", [5e-4, 2e-3])
def test_a_thin_plate_before_a_block_holds_it_where_it_sinks_elsewhere(turned, thin):
    # A block with a foot sinks by 1 mm into the floor; the plate stands higher up, between the block and a wall.
    floor = prism([(0, -0.5), (2, -0.5), (2, 1), (1.2, 1), (1.2, 0), (0, 0)], 1.0)
    plate = box((1, 0.2, 0.1), (1.2, 0.8, 0.1 + thin))
    found = on_a_slope(turned, [floor, plate, box((0.4, 0.2, -1e-3), (1, 0.8, 0.25))], [0, 1])
    assert found.outcome is Outcome.STABLE
