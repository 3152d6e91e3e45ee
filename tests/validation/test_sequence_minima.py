"""Exact minima of two construction sequences, by exhaustion over all states.

Numbers of stable states and orders and least numbers of hands are those of an independent enumeration with its own
force programs (exact cones, corner contacts). A: the least number held at rest, over orders of the largest.
"""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from blockstat import Assembly, Block, box, count_orders, find_interfaces
from blockstat.sequence.search import Search
from blockstat.sequence.states import Whole

pytestmark = pytest.mark.slow

COURSES = [
    [(0, 0.55), (0.55, 0.8), (1.2, 1.45), (1.45, 2)],
    [(0, 0.35), (0.35, 0.8), (1.2, 1.65), (1.65, 2)],
    [(0, 0.5), (0.5, 1.5), (1.5, 2)],  # the middle one is the lintel
    [(0.25, 0.85), (0.85, 1.15), (1.15, 1.75)],
]


def wall_with_a_lintel():
    """Fourteen stones in four courses over an opening of .4."""
    blocks = [box((-1, 0, -0.5), (3, 1, 0), name="ground")]
    for course, stones in enumerate(COURSES):
        for k, (x0, x1) in enumerate(stones):
            blocks.append(box((x0, 0, 0.2 * course), (x1, 1, 0.2 * (course + 1)), name=f"c{course}.{k}"))
    assembly = Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)
    faces = find_interfaces(assembly)
    return assembly, faces.subset(np.abs(faces.frame[:, 0, 0]) < 0.5)


def dome(rings):
    """Rings of eight stones between cones through the centre; radius 1, thickness .2, oculus open."""
    elevation = np.radians([0, 25, 50, 70])
    turn = 2 * np.pi * np.arange(9) / 8

    def at(radius, level, k):
        flat = radius * np.cos(elevation[level])
        return flat * np.cos(turn[k]), flat * np.sin(turn[k]), radius * np.sin(elevation[level])

    blocks = [box((-2, -2, -0.3), (2, 2, 0), name="ground")]
    for ring in range(rings):
        for k in range(8):
            corners = [at(r, level, j) for level in (ring, ring + 1) for j in (k, k + 1) for r in (0.9, 1.1)]
            faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
            blocks.append(Block(corners, faces, f"r{ring}.{k}"))
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)


def ring_states(ring):
    """The search on a dome up to a ring, and bits of its stones and of all below, which are complete and free.

    The reference has faces only: edges along edges, which leave states of the last ring undecided, are left out.
    """
    assembly = dome(ring + 1)
    faces = replace(find_interfaces(assembly), rims=None)
    search = Search(Whole(assembly, interfaces=faces), 8, "associated")
    stones = [1 << assembly.names.index(f"r{ring}.{k}") for k in range(8)]
    below = sum(1 << int(k) for k in assembly.free) - sum(stones)
    return search, stones, below


def test_the_stones_of_the_dome_are_those_of_the_reference():
    volume = dome(3).volume[1::8]
    assert volume == pytest.approx([0.057157276, 0.046446893, 0.023896450], abs=1e-9)


def test_a_wall_with_a_lintel_is_built_without_a_hand_at_rest_in_half_of_seven_million_orders():
    assembly, beds = wall_with_a_lintel()
    found = count_orders(assembly, interfaces=beds)
    assert (found.states, found.stable, found.undecided) == (16384, 747, 0)
    assert found.orders == 3_526_068
    assert found.rest == 0


@pytest.mark.parametrize(
    ("ring", "stable", "round"), [(0, 256, 8 * [0]), (1, 90, [1] + 7 * [0]), (2, 34, 3 * [1] + 5 * [0])]
)
def test_a_ring_of_the_dome_stands_closed_and_needs_one_hand_while_it_is_open(ring, stable, round):
    search, stones, below = ring_states(ring)
    sets = [sum(s for k, s in enumerate(stones) if chosen >> k & 1) for chosen in range(256)]
    stands = {one for one in sets if search.falls((below | one, 0)) is None}
    assert search.undecided == 0
    assert len(stands) == stable

    def held(one):
        """Least number of stones of the ring that must be held."""
        own = [s for s in stones if one & s]
        return next(
            count
            for count in range(9)
            if any(search.falls((below | one, sum(some))) is None for some in combinations(own, count))
        )

    assert [held(sum(stones[: k + 1])) for k in range(8)] == round
    peaks = [held(one) for one in sets]
    assert max(peaks) == (0 if ring == 0 else 4)  # the worst state
    least = {0: 0}
    for one in sorted(sets[1:], key=int.bit_count):
        least[one] = min(max(least[one & ~s], peaks[sets.index(one)]) for s in stones if one & s)
    assert least[sets[-1]] == (0 if ring == 0 else 1)  # A
