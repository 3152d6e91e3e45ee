"""Supports of many faces that rise above a plane, such as terrains: prisms under their faces."""

import sys

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from blockstat import Assembly, Block, InputError, box
from blockstat.geometry.triangulation import triangulate
from dynsim import verify
from dynsim.engine import bodies
from dynsim.engine.bodies import shapes
from dynsim.engine.filling import prisms
from evidence.scenes.small import prism
from tests.point_bodies import prism_in_a_groove

#: A terrain 6 m wide in cells of 0.5 m: flat in the middle, waves around.
HALF, CELLS, BASE = 3.0, 12, -2.0
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture
def no_coacd(monkeypatch):
    monkeypatch.setitem(sys.modules, "coacd", None)


def waves(x, y):
    return 0.3 * np.sin(3 * x) * np.cos(2 * y) - 0.35


def terrain(level, name="ground"):
    """The solid between a height by x and y, drawn in triangles, and a plane below it."""
    line = np.linspace(-HALF, HALF, CELLS + 1)
    x, y = (grid.reshape(-1) for grid in np.meshgrid(line, line, indexing="ij"))
    corners = np.column_stack([x, y, level(x, y)])
    at = np.arange(len(x)).reshape(CELLS + 1, -1)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    faces = [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    rim = np.concatenate([at[:-1, 0], at[-1, :-1], at[:0:-1, -1], at[0, :0:-1]])
    below = len(x) + np.arange(len(rim))
    corners = np.vstack([corners, np.column_stack([corners[rim][:, :2], np.full(len(rim), BASE)])])
    walls = np.column_stack([np.roll(rim, -1), rim, below, np.roll(below, -1)])
    return Block(corners, [*np.concatenate(faces).tolist(), *walls.tolist(), below[::-1].tolist()], name=name)


def padded(x, y):
    return np.where(np.maximum(np.abs(x), np.abs(y)) < 1.6, 0.0, waves(x, y))


def brick(x=0.0, y=0.0):
    return box((x - 0.5, y - 0.4, 0), (x + 0.5, y + 0.4, 0.3), name="brick")


def scene(level=padded, stone=None, pull=0.0):
    """A brick on a terrain, friction 0.4, pulled along x and y by that part of its weight in all."""
    found = Assembly.from_blocks([terrain(level), stone or brick()], supports=["ground"], friction=0.4)
    return found.with_(gravity=(0.6 * pull * 9.81, 0.8 * pull * 9.81, -9.81))


def volume_of(pieces) -> float:
    return sum(ConvexHull(piece).volume for piece in pieces)


@pytest.mark.usefixtures("no_coacd")
def test_a_terrain_is_cut_into_prisms_that_are_the_terrain():
    found = shapes(scene())[0]
    # The flat part of 6 x 6 cells is one prism, and each other half of a cell one at most.
    assert 100 < len(found.pieces) <= 1 + 2 * (12 * 12 - 6 * 6)
    assert not found.filled
    assert volume_of(found.pieces) == pytest.approx(scene().volume[0], rel=1e-9)


@pytest.mark.usefixtures("no_coacd")
@pytest.mark.parametrize(("pull", "word"), [(0.38, "stands"), (0.42, "falls")])
def test_a_brick_on_a_terrain_slides_at_its_friction(pull, word):
    assert verify(scene(pull=pull)).outcome.word == word


@pytest.mark.usefixtures("no_coacd")
def test_of_a_terrain_with_a_rough_underside_the_underside_is_left_out_where_nothing_reaches():
    top = terrain(padded)
    rough = np.asarray(top.vertices).copy()
    rough[(CELLS + 1) ** 2 :, 2] += 0.1 * np.arange(4 * CELLS) / (4 * CELLS)
    faces = [*top.faces[:-1], *([corner, following, len(rough)] for corner, following in around(top.faces[-1]))]
    ground = Block(np.vstack([rough, [(0.0, 0.0, -2.2)]]), faces, name="ground")
    found = shapes(Assembly.from_blocks([ground, brick()], supports=["ground"]))[0]
    lowest = min(piece[:, 2].min() for piece in found.pieces)
    assert lowest + Assembly.from_blocks([ground]).centroid[0, 2] == pytest.approx(rough[(CELLS + 1) ** 2 :, 2].max())
    with pytest.raises(InputError, match="no exact cut into convex pieces was found"):
        shapes(Assembly.from_blocks([ground, box((4, 0, -2.1), (5, 1, -1.0))], supports=["ground"]))


def around(face):
    return zip(face, [*face[1:], face[0]], strict=True)


def test_a_bridge_is_cut_above_its_soffit_and_only_where_nothing_is_below():
    # Feet 1 wide to height 0, soffit at 1, top at 2: a deck 4 x 1 x 1.
    bridge = prism([(-2, 0), (-1, 0), (-1, 1), (1, 1), (1, 0), (2, 0), (2, 2), (-2, 2)], 1.0)
    corners = np.asarray(bridge.vertices, dtype=float)
    surface = corners[triangulate(corners, [np.asarray(face) for face in bridge.faces])]
    above, below = np.array([(0.0, 0.0, 2.5)]), np.array([(0.0, 0.0, 0.5)])
    (deck,) = prisms(surface, 4.0, 1e-7, [UP], above)
    assert ConvexHull(deck).volume == pytest.approx(4.0)
    assert prisms(surface, 4.0, 1e-7, [UP], below) == []
    # Hanging from its top, or seen from its side, it is a relief above a plane, and all of it is cut.
    for up in (-UP, np.array([0.0, 1.0, 0.0])):
        assert volume_of(prisms(surface, 4.0, 1e-7, [up], below)) == pytest.approx(6.0)


@pytest.mark.parametrize("limit", ["MANY", "TOO_MANY"])
def test_a_terrain_on_whose_seams_a_block_stands_is_refused_before_its_faces_are_moved(monkeypatch, limit):
    def moved(*_, **__):
        raise AssertionError("a cut that moves the faces was tried")

    monkeypatch.setattr("coacd.run_coacd", moved)
    monkeypatch.setattr(bodies, limit, 100)
    with pytest.raises(InputError) as told:  # the flat part ends at x = 1.5, below the brick
        verify(scene(stone=brick(1.2)))
    said = str(told.value)
    assert f'support "ground" is not convex and has {2 * 12 * 12 + 4 * 12 + 1} faces' in said
    assert "Put boxes in its place" in said
    assert "--supports" in said


def test_a_groove_is_cut_into_its_two_flanks():
    (groove, _) = shapes(Assembly.from_blocks(prism_in_a_groove(), supports=[0]))
    assert len(groove.pieces) == 2
