"""Concave blocks as convex pieces, also where their faces are warped."""

import numpy as np
import pytest

from blockstat import Assembly, Block
from blockstat.model import assemble, dome
from dynsim import verify
from dynsim.engine.bodies import shapes


def warped_dome(amount: float, rings: int = 9, voussoirs: int = 10) -> Assembly:
    """A dome whose faces are triangulated and whose corners, shared ones together, are moved at random [m]."""
    drawn = assemble(
        dome(span=10.0, thickness=0.5, rings=rings, voussoirs=voussoirs, oculus=1.0), friction=0.7, supports=["dome.0"]
    )
    _, corner = np.unique(np.round(drawn.vertices, 6), axis=0, return_inverse=True)
    shift = np.random.default_rng(0).uniform(-amount, amount, (corner.max() + 1, 3))
    moved = drawn.vertices + shift[corner.reshape(-1)]
    blocks = []
    for number, name in enumerate(drawn.names):
        low, high = drawn.vertex_start[number : number + 2]
        faces = [[int(f[0]), int(f[i]), int(f[i + 1])] for f in drawn.faces_of(number) for i in range(1, len(f) - 1)]
        blocks.append(Block(moved[low:high], faces, name=name, group=drawn.groups[number]))
    return Assembly.from_blocks(
        blocks, supports=[name for name in drawn.names if name.startswith("dome.0.")], friction=0.7
    )


@pytest.mark.parametrize("amount", [0.0, 1e-3])
def test_bent_voussoirs_come_apart_at_their_bend_also_where_they_are_warped(amount):
    # A voussoir in running bond lies on two others, and is bent in the middle of its bed: two hexahedra.
    found = shapes(warped_dome(amount, rings=4))
    assert [len(shape.pieces) for shape in found] == [2] * len(found)
    corners = [len(piece) for shape in found for piece in shape.pieces]
    assert np.mean(corners) < 8.5  # eight each, and at a few cuts a corner of a warped face


@pytest.mark.slow
def test_a_dome_of_warped_blocks_stands_and_its_shapes_hardly_overlap():
    found = verify(warped_dome(1e-3))
    assert found.outcome.word == "stands"
    assert found.run.initial_overlap < 4e-3  # warped by 1e-3 m on either side
