"""Blocks of many convex pieces: finely curved stones, supports of separate solids, and pieces that still overlap."""

import sys

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from typer.testing import CliRunner

from blockstat import Assembly, Block, InputError, box, write
from dynsim import Settings, World, verify
from dynsim.cli import commands
from dynsim.engine import bodies
from dynsim.engine.bodies import shapes
from dynsim.engine.decompose import Cut
from dynsim.engine.filling import fills, polygons_above
from evidence.scenes.small import prism


@pytest.fixture
def no_coacd(monkeypatch):
    """Without it, a block that no exact cut was found for is refused."""
    monkeypatch.setitem(sys.modules, "coacd", None)


def volume_of(pieces) -> float:
    return sum(ConvexHull(piece).volume for piece in pieces)


def joined(blocks, **options) -> Block:
    """One block of separate solids."""
    start = np.cumsum([0, *(len(block.vertices) for block in blocks)])
    corners = np.concatenate([np.asarray(block.vertices, dtype=float) for block in blocks])
    faces = [[i + first for i in face] for block, first in zip(blocks, start, strict=False) for face in block.faces]
    return Block(corners, faces, **options)


def cup_and_cap(cells: int, depth: float) -> Assembly:
    """Two cubes that meet in one curved surface, a paraboloid about the middle drawn by triangles; no gap, no overlap.

    A corner of the lower cube is at height 0, and the middle of its hollow at -depth.
    """
    line = np.linspace(-0.5, 0.5, cells + 1)
    x, y = (grid.reshape(-1) for grid in np.meshgrid(line, line))
    curved = np.column_stack([x, y, -depth * (1 - 4 * x**2) * (1 - 4 * y**2)])
    at = np.arange((cells + 1) ** 2).reshape(cells + 1, -1)
    a, b, c, d = at[:-1, :-1].reshape(-1), at[:-1, 1:].reshape(-1), at[1:, 1:].reshape(-1), at[1:, :-1].reshape(-1)
    upward = [*np.column_stack([a, b, c]).tolist(), *np.column_stack([a, c, d]).tolist()]
    rim = [*at[0, :-1], *at[:-1, -1], *at[-1, :0:-1], *at[:0:-1, 0]]
    n, four = len(curved), [rim[k * cells] for k in range(4)]

    def solid(height: float, name: str) -> Block:
        corners = np.vstack([curved, curved[four] + (0, 0, height)])
        faces = []
        for k in range(4):
            faces.append([*(rim * 2)[k * cells : (k + 1) * cells + 1], n + (k + 1) % 4, n + k])
        faces.append([n, n + 1, n + 2, n + 3])
        if height < 0:  # the side faces look outwards when what they hang from is above
            return Block(corners, [*upward, *(face[::-1] for face in faces)], name=name)
        return Block(corners, [*(face[::-1] for face in upward), *faces], name=name)

    return Assembly.from_blocks([solid(-1.0, "cup"), solid(1.0, "cap")], supports=["cup"], friction=0.7)


@pytest.mark.usefixtures("no_coacd")
def test_the_pieces_of_stones_that_meet_in_a_curved_surface_do_not_overlap():
    scene = cup_and_cap(6, 0.3)
    assert scene.volume.sum() == pytest.approx(2.0, rel=1e-9)
    found = shapes(scene)
    assert [shape.filled for shape in found] == [False, False]
    assert [volume_of(shape.pieces) for shape in found] == pytest.approx(scene.volume, rel=5e-3)
    with World(scene, Settings.named("fast")) as world:
        assert world.deepest_overlap() < 0.01
    assert world.filled == ()


@pytest.mark.usefixtures("no_coacd")
def test_a_comb_of_more_than_forty_teeth_keeps_its_gaps():
    teeth = [(x, z) for k in range(45) for x, z in ((2 * k, 0), (2 * k, 1), (2 * k + 1, 1), (2 * k + 1, 0))]
    comb = prism([(0, -1), (0, 0), *teeth[1:-1], (89, 0), (89, -1)][::-1], 2.0, name="comb")
    scene = Assembly.from_blocks([comb, box((0, 0, 1), (1, 1, 2))], supports=["comb"])
    assert scene.volume[0] == pytest.approx(2 * (89 + 45))
    (found, _) = shapes(scene)
    assert not found.filled
    assert volume_of(found.pieces) == pytest.approx(2 * (89 + 45), rel=1e-9)


@pytest.mark.usefixtures("no_coacd")
@pytest.mark.filterwarnings("ignore:.*separate solids")
def test_a_support_of_separate_solids_is_each_of_them():
    # An L of two pieces more than once, and more boxes than one solid may have pieces.
    corner = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
    ells = [prism(corner, 1.0) for _ in range(2)]
    ells = [Block(np.asarray(ell.vertices) + (0, -4 - 4 * k, 0), ell.faces) for k, ell in enumerate(ells)]
    feet = joined([*(box((3 * k, 0, 0), (3 * k + 1, 1, 1)) for k in range(38)), *ells], name="feet")
    scene = Assembly.from_blocks([feet, box((0, 0, 1), (1, 1, 2), name="block")], supports=["feet"])
    found = shapes(scene)[0]
    assert not found.filled
    assert len(found.pieces) == 38 + 2 * 2
    assert volume_of(found.pieces) == pytest.approx(38 + 2 * 4, rel=1e-9)


@pytest.mark.filterwarnings("ignore:.*cavities")
def test_a_hollow_in_a_block_is_no_solid_of_its_own():
    inner = box((1, 1, 1), (2, 2, 2))
    shell = joined([box((0, 0, 0), (3, 3, 3)), Block(inner.vertices, [face[::-1] for face in inner.faces])])
    scene = Assembly.from_blocks([shell, box((0, 0, 3), (3, 3, 4))], supports=[0])
    found = shapes(scene)[0]
    assert not found.filled
    assert volume_of(found.pieces) == pytest.approx(26, rel=1e-9)


def test_pieces_that_fill_a_ditch_are_not_said_to_be_blocks_that_overlap(monkeypatch):
    def hull_only(surface, size, depth, **_):
        pieces = [ConvexHull(surface.reshape(-1, 3))]
        return Cut((pieces[0].points,), fills(surface, pieces, depth))

    monkeypatch.setattr(bodies, "convex_pieces", hull_only)
    monkeypatch.setattr(bodies, "prisms", lambda *_: [])
    ground = prism([(-3, -1), (3, -1), (3, 0), (1, 0), (1, -0.2), (0, -0.2), (0, 0), (-3, 0)], 2.0, name="ground")
    cube = box((0.2, 0.5, -0.2), (0.8, 1.1, 0.4), name="cube")
    with pytest.raises(InputError) as told:
        verify(Assembly.from_blocks([ground, cube], supports=["ground"]))
    assert 'no cut of "ground" into convex pieces was found' in str(told.value)
    assert 'the pieces of "ground" and "cube" overlap by 200 mm' in str(told.value)
    assert 'blocks "' not in str(told.value)


def test_what_many_planes_leave_of_a_triangle_is_one_polygon():
    # 200 tangents of a circle, and one line through its middle.
    angle = np.arange(200) * 2 * np.pi / 200
    planes = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(200)])
    left, corners = np.array([[(-9.0, -9, 0), (9, -9, 0), (0, 9, 0)]] * 2), np.array([3, 3])
    left[1] += (0, 0, 1)
    for plane in planes:
        left, corners = polygons_above(left, corners, 1 - left @ plane)
    assert corners.tolist() == [200, 200]
    assert [area(*each) for each in zip(left, corners, strict=True)] == pytest.approx([200 * np.tan(np.pi / 200)] * 2)
    left, corners = polygons_above(left, corners, left @ (0.0, 0.0, 1.0) + left @ (1.0, 0, 0) - 1.5)
    assert len(left) == 1  # x > 1.5 is beyond the circle, x > 0.5 is not
    assert area(left[0], corners[0]) == pytest.approx(np.pi / 3 - np.sqrt(3) / 4, rel=1e-3)


def area(polygon: np.ndarray, corners: int) -> float:
    (x, y), own = polygon[:corners, :2].T, polygon[:corners]
    assert np.ptp(own[:, 2]) == 0
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def test_the_first_line_of_a_wait_says_that_blocks_are_cut(monkeypatch, tmp_path):
    said, usual = [], commands.at_work
    monkeypatch.setattr(commands, "at_work", lambda text: said.append(text) or usual(text))
    scene = Assembly.from_blocks([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))], supports=[0])
    write(scene, tmp_path / "two.json")
    assert CliRunner().invoke(commands.app, ["verify", str(tmp_path / "two.json"), "--preset", "fast"]).exit_code == 0
    assert said == ["preparing 2 blocks (closing joints, cutting concave blocks, settling)"]
