"""Recesses of a concave block stay open in the engines, however small they are beside the block."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, assess, box
from blockstat.geometry.triangulation import triangulate
from dynsim import verify
from dynsim.engine import bodies
from dynsim.engine.bodies import shapes
from dynsim.engine.decompose import Cut
from dynsim.engine.filling import fills, pieces_between_planes
from evidence.scenes.small import pitted, prism

#: Widths of the ground and depths of a ditch of 1 m in it [m]: from a fifteenth of the cube to a thousandth of the
#: ground.
DITCHES = [(20.0, 0.03), (100.0, 0.1), (6.0, 0.03)]
#: Half the width of a slab, its thickness, half the width of a pit in it and its depth [m].
PITS = [(2.0, 1.0, 0.15, 0.2), (50.0, 2.0, 0.1, 0.12), (0.5, 0.5, 0.1, 0.12)]


def over_a_ditch(wide, deep, x=-0.1):
    """A cube of 0.3 m that begins at x, on ground with a ditch from x = 0 to 1."""
    half = wide / 2
    outline = [(-half, -1), (half, -1), (half, 0), (1, 0), (1, -deep), (0, -deep), (0, 0), (-half, 0)]
    ground = prism(outline, wide, name="ground")
    cube = box((x, half, 0), (x + 0.3, half + 0.3, 0.3), name="cube")
    return Assembly.from_blocks([ground, cube], supports=["ground"])


def over_a_pit(slab, thick, pit, deep, share):
    """A cube about the middle of a square pit, of so much of its width."""
    half = share * pit
    cube = box((-half, -half, 0), (half, half, 2 * half), name="cube")
    return Assembly.from_blocks([pitted(slab, thick, pit, deep, name="ground"), cube], supports=["ground"])


def turned(scene):
    """The scene about an oblique axis, at an offset; gravity turns along."""
    turn = Rotation.from_rotvec([0.5, -0.3, 0.8]).as_matrix()
    return scene.with_(vertices=scene.vertices @ turn.T + (30.0, -20.0, 5.0), gravity=turn @ scene.gravity)


@pytest.mark.parametrize("place", [lambda scene: scene, turned], ids=["drawn", "turned"])
@pytest.mark.parametrize(
    "scene",
    [
        *(pytest.param(over_a_ditch(*size), id=f"ditch in {size[0]:g} m") for size in DITCHES),
        *(pytest.param(over_a_pit(*size, 0.8), id=f"pit in {2 * size[0]:g} m") for size in PITS),
    ],
)
def test_what_has_its_weight_over_a_recess_falls(scene, place):
    # Two thirds of the cube are over the ditch, and all of it over the pit.
    scene = place(scene)
    assert (assess(scene).outcome.word, verify(scene).outcome.word) == ("unstable", "falls")


@pytest.mark.parametrize("place", [lambda scene: scene, turned], ids=["drawn", "turned"])
@pytest.mark.parametrize(
    "scene",
    [
        # Two thirds of the cube are beside the ditch; another one is wider than the pit and lies on all four rims.
        *(pytest.param(over_a_ditch(*size, x=-0.2), id=f"ditch in {size[0]:g} m") for size in DITCHES),
        *(pytest.param(over_a_pit(*size, 1.2), id=f"pit in {2 * size[0]:g} m") for size in PITS),
    ],
)
def test_what_has_its_weight_beside_a_recess_stands(scene, place):
    scene = place(scene)
    assert (assess(scene).outcome.word, verify(scene).outcome.word) == ("stable", "stands")


@pytest.mark.parametrize("size", PITS)
def test_the_pieces_of_a_slab_with_a_pit_are_the_slab(size):
    scene = over_a_pit(*size, 0.8)
    found = shapes(scene)[0]
    hulls = [ConvexHull(piece) for piece in found.pieces]
    # Four walls and what is under the pit.
    assert len(hulls) == 5
    assert not found.filled
    assert sum(hull.volume for hull in hulls) == pytest.approx(float(scene.volume[0]), rel=1e-9)
    pit = [0.0, 0.0, -size[3] / 2] - scene.centroid[0]
    assert all((hull.equations[:, :3] @ pit + hull.equations[:, 3]).max() > 0 for hull in hulls)


def surface_of(block):
    corners = np.asarray(block.vertices, dtype=float)
    return corners[triangulate(corners, [np.array(face) for face in block.faces])]


def test_the_depth_of_a_filling_is_that_of_the_notch_below_the_hull():
    # The notch of the L ends at (1, 1); the hull ends at 2 x + z = 5, at 2 / sqrt(5) from there.
    ell = surface_of(prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)], 4.0))
    hull, deepest = ConvexHull(ell.reshape(-1, 3)), 2 / np.sqrt(5)
    assert fills(ell, [hull], 0.999 * deepest)
    assert not fills(ell, [hull], 1.001 * deepest)
    assert not fills(ell, pieces_between_planes(ell, 1e-6, 1e-6, 40), 1e-6)


def test_a_piece_beside_its_block_fills_though_no_face_reaches_into_it():
    cube = surface_of(box((0, 0, 0), (1, 1, 1)))
    corners = cube.reshape(-1, 3)
    assert not fills(cube, [ConvexHull(corners)], 1e-6)
    assert fills(cube, [ConvexHull(corners + (2, 0, 0))], 1e-6)


def test_a_filling_that_no_cut_avoids_is_told_by_the_name_of_its_block(monkeypatch):
    def hull_only(surface, size, depth, **_):
        pieces = [ConvexHull(surface.reshape(-1, 3))]
        return Cut((pieces[0].points,), fills(surface, pieces, depth))

    monkeypatch.setattr(bodies, "convex_pieces", hull_only)
    monkeypatch.setattr(bodies, "prisms", lambda *_: [])
    scene = over_a_ditch(6.0, 0.03)
    assert [shape.filled for shape in shapes(scene)] == [True, False]
    assert any('of "ground": pieces fill recesses' in text for text in verify(scene).warnings)


def test_a_pebble_far_away_changes_no_shape():
    """Stones with corners up to .5 mm off; a pebble of 1 cm lies 1.4 m from the nearest."""
    rng = np.random.default_rng(0)
    ground, stones = box((-3, -3, -1), (3, 3, 0)), [box((k, 0, 0), (k + 0.6, 0.6, 0.4)) for k in range(2)]
    rough = [Block(np.asarray(b.vertices) + rng.uniform(-5e-4, 5e-4, (8, 3)), b.faces) for b in stones]
    pebble = box((2, 2, 0), (2.01, 2.01, 0.01))
    alone, beside = (
        shapes(Assembly.from_blocks(b, supports=[0])) for b in ([ground, *rough], [ground, *rough, pebble])
    )
    assert [len(shape.pieces) for shape in beside[:3]] == [len(shape.pieces) for shape in alone] == [1, 1, 1]
