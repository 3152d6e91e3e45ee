"""The shape of a block in its own axes is the block: right-handed axes, its corners, its inertia."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Block, build
from blockstat.design_search.search import space_of
from dynsim import simulate, verify
from dynsim.engine import world as engine
from dynsim.engine.bodies import hull_obj, shapes
from evidence.benchmarks.search import NAMES, scene
from evidence.scenes.small import assembly, box, prism
from tests.point_bodies import hull

GROUND = box((-9, -9, -9), (9, 9, -8), name="ground")


def solids(seed):
    """A box, an oblique prism and the hull of points on a sphere, turned at random, corners in random order."""
    random = np.random.default_rng(seed)
    far = random.normal(size=(12, 3))
    plain = [
        box((0, 0, 0), (0.3, 0.5, 1.1)),
        prism([(0, 0), (1, 0), (1.4, 0.8), (0.3, 1)], 0.4),
        hull(far / np.linalg.norm(far, axis=1)[:, None]),
    ]
    for block in plain:
        vertices = np.asarray(block.vertices, float) @ Rotation.random(random_state=random).as_matrix().T
        order = random.permutation(len(vertices))
        place = np.argsort(order)
        yield Block(vertices[order], [[int(place[k]) for k in face] for face in block.faces])


@pytest.mark.parametrize("seed", range(8))
def test_a_shape_is_its_block_in_right_handed_principal_axes(seed):
    asm = assembly([GROUND, *solids(seed)], density=2.0)
    for block, shape in enumerate(shapes(asm)):
        turn = shape.rotation
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)
        np.testing.assert_allclose(turn @ np.diag(shape.inertia) @ turn.T, asm.inertia[block], rtol=1e-9, atol=1e-12)
        (piece,) = shape.pieces
        corners = piece @ turn.T + asm.centroid[block]
        distance = np.linalg.norm(corners[:, None] - asm.block_vertices(block)[None], axis=2)
        assert distance.min(axis=1).max() < 1e-12
        assert distance.min(axis=0).max() < 1e-12
        if shape.half_extents is not None:
            np.testing.assert_allclose(np.abs(piece).max(axis=0), shape.half_extents, rtol=1e-9)


def test_bricks_beside_voussoirs_fall_as_fast_as_in_another_engine():
    # Statics with Coulomb friction find no equilibrium. In LMGC90 (time step 2 ms) the furthest block has moved by
    # 11.2 mm ten looks after release. As boxes beside hulls the bricks were held: it was 2.6 mm.
    chapel = space_of(scene(), NAMES).at(dict(zip(NAMES, (0.5, 0.25, 0.9, 1), strict=True)))
    run = simulate(build(chapel), stop=lambda elapsed, *_: elapsed >= 0.199)
    moved = np.linalg.norm(run.since_release[10], axis=1).max()
    assert moved == pytest.approx(11.2e-3, rel=0.25)


def test_blocks_that_are_alike_share_a_shape_and_stand_on_it(monkeypatch):
    made = []
    monkeypatch.setattr(engine, "hull_obj", lambda pieces: made.append(len(pieces)) or hull_obj(pieces))
    wedge = prism([(0, 0), (0.5, 0), (0.4, 0.3)], 0.2)  # no box, so all are hulls
    bricks = [box((0.7 / 3 + x, 0, z), (0.7 / 3 + x + 0.5, 0.2, z + 0.3)) for x in (1, 2) for z in (0.0, 0.3, 0.6)]
    row = assembly([box((-1, -1, -0.2), (4, 1, 0)), wedge, *bricks])
    found = verify(row)
    assert len(made) == 3  # ground, wedge, brick
    assert found.outcome.word == "stands"
    assert np.linalg.norm(found.run.displacement[-1], axis=1).max() < 1e-4  # each in its own place
