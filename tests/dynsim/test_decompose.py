"""Concave blocks as convex pieces, also where their faces are warped."""

import sys
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from blockstat import Assembly, Block, InputError, assess, box, find_interfaces
from blockstat.geometry.triangulation import triangulate
from blockstat.model import assemble, dome, fan_vault, sail_vault
from dynsim import verify
from dynsim.engine import bodies
from dynsim.engine.bodies import shapes
from dynsim.engine.decompose import star_pieces

needs_lmgc90 = pytest.mark.skipif(find_spec("compas_lmgc90") is None, reason="compas_lmgc90 is not installed")


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


def warped_vault(kind: str) -> Assembly:
    """A thin vault of doubly curved stones, whose beds are two triangles each and stand on those of the next stone."""
    if kind == "fan":
        blocks = fan_vault(
            spans=[4.66, 4.66], rise=2.33, foot=0.58, rings=3, voussoirs=4, thickness=0.2, springers=0.3
        )  # fmt: skip
    else:
        blocks = sail_vault(spans=[5, 5], rise=1.5, thickness=0.15, courses=4, voussoirs=2, springers=0.3)
    supports = [block.name for block in blocks if "springer" in block.name]
    return Assembly.from_blocks(blocks, supports=supports, friction=0.7)


#: A stone of a dome in herringbone bond: a bar of quadrilateral section, bent in its middle by a fifth of its length.
BENT_FACES = [
    [0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11], [5, 4, 7, 6], [4, 3, 8, 7], [3, 2, 9, 8], [2, 1, 10, 9], [1, 0, 11, 10],
    [0, 5, 6, 11],
]  # fmt: skip
BENT_CORNERS = [
    (-0.686, 1.501, -0.14), (-1.041, 1.012, 0.489), (-0.01, -0.008, 0.481), (0.64, -1.303, 0.489),
    (1.216, -1.116, -0.14), (0.468, 0.34, -0.133), (0.212, 0.154, -0.397), (0.926, -1.21, -0.416),
    (0.374, -1.389, 0.187), (-0.227, -0.165, 0.169), (-1.206, 0.785, 0.187), (-0.865, 1.254, -0.416),
]  # fmt: skip


def test_a_stone_with_bent_faces_keeps_its_volume_in_a_few_exact_pieces(monkeypatch):
    # Diagonals across its two bent faces make a surface of another volume, of which the cuts lose a fifth.
    monkeypatch.setitem(sys.modules, "coacd", None)  # a mesh made anew would be thirty pieces, and take seconds
    stone = Assembly.from_blocks([Block(np.array(BENT_CORNERS), BENT_FACES, name="stone")], supports=["stone"])
    (found,) = shapes(stone)
    assert len(found.pieces) < 10
    volume = sum(ConvexHull(piece).volume for piece in found.pieces)
    assert volume == pytest.approx(float(stone.volume[0]), rel=0.1)


@pytest.mark.parametrize("amount", [0.0, 1e-3])
def test_bent_voussoirs_come_apart_at_their_bend_also_where_they_are_warped(amount):
    # A voussoir in running bond lies on two others, and is bent in the middle of its bed: two hexahedra.
    found = shapes(warped_dome(amount, rings=4))
    assert [len(shape.pieces) for shape in found] == [2] * len(found)
    corners = [len(piece) for shape in found for piece in shape.pieces]
    assert np.mean(corners) < 8.5  # eight each, and at a few cuts a corner of a warped face


def boundary(pieces, corners: np.ndarray) -> float:
    """How far any corner of a block lies inside one of its pieces."""
    inside = [(corners @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1) for hull in pieces]
    return float(-np.min(inside))


@pytest.mark.parametrize("kind", ["fan", "sail"])
def test_pieces_of_warped_stones_fill_their_block_and_leave_the_next_one_alone(kind):
    vault = warped_vault(kind)
    hulls = [[ConvexHull(piece @ shape.rotation.T + middle) for piece in shape.pieces]
             for shape, middle in zip(shapes(vault, exact=True), vault.centroid, strict=True)]  # fmt: skip
    # The volume of the hulls is that of the pieces, as they are convex.
    volume = np.array([sum(hull.volume for hull in own) for own in hulls])
    assert np.abs(volume / vault.volume - 1).max() < 6e-3
    deepest = [
        boundary(hulls[one], vault.block_vertices(other)) / vault.size[one]
        for pair in find_interfaces(vault).pair for one, other in (pair, pair[::-1])
    ]  # fmt: skip
    assert len(deepest) > 50
    assert max(deepest) < 2e-3


def test_a_star_is_cut_without_moving_a_face():
    # A cube with a pyramid cut out of its top, whose apex lies low: five pieces about a point under the apex.
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)] + [[0.5, 0.5, 0.6]], dtype=float)
    faces = [[0, 2, 1], [1, 2, 3], [0, 1, 4], [1, 5, 4], [1, 3, 5], [3, 7, 5], [3, 2, 7], [2, 6, 7], [2, 0, 6],
             [0, 4, 6], [4, 5, 8], [5, 7, 8], [7, 6, 8], [6, 4, 8]]  # fmt: skip
    pieces = star_pieces(corners[np.array(faces)], 1.0)
    hulls = [ConvexHull(piece) for piece in pieces]
    assert sum(hull.volume for hull in hulls) == pytest.approx(1 - 0.4 / 3, rel=1e-9)
    assert boundary(hulls, corners) < 1e-7
    assert len(hulls) <= 8  # of 14 tetrahedra


def test_a_block_of_which_no_point_sees_all_faces_is_no_star():
    # The L is one, as seen from its corner; the Z has no such point.
    assert star_pieces(prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]), 1.0) is not None
    assert star_pieces(prism([(0, 0), (2, 0), (2, 2), (3, 2), (3, 3), (1, 3), (1, 1), (0, 1)]), 1.0) is None


def prism(outline) -> np.ndarray:
    """Triangles of a prism of unit height on a plane outline."""
    low = np.column_stack([np.array(outline, dtype=float), np.zeros(len(outline))])
    corners, n = np.concatenate([low, low + [0, 0, 1]]), len(outline)
    sides = [[k, (k + 1) % n, (k + 1) % n + n, k + n] for k in range(n)]
    return corners[triangulate(corners, [*map(np.array, sides), np.arange(n)[::-1], np.arange(n, 2 * n)])]


@pytest.mark.slow
@needs_lmgc90
@pytest.mark.parametrize("kind", ["fan", "sail"])
def test_thin_vaults_of_warped_stones_stand_as_statics_say(kind):
    # Hulls of such stones stand out of their hollow faces.
    vault = warped_vault(kind)
    assert assess(vault, flow="coulomb").outcome.word == "stable"
    assert verify(vault, engine="lmgc90").outcome.word == "stands"


@needs_lmgc90
@pytest.mark.parametrize(("degrees", "outcome"), [(25, "stands"), (28, "falls")])
def test_a_slab_in_pieces_slides_on_a_stone_in_pieces_as_whole_ones_do(monkeypatch, degrees, outcome):
    # tan 26.57 deg = .5. The pieces of one meet those of the other along the diagonals of both faces. In Bullet such a
    # slab stays at 40 deg.
    def in_pieces(assembly, *, exact):
        return [
            replace(shape, half_extents=None, pieces=tuple(star_of_a_box(shape.pieces[0])))
            for shape in shapes(assembly, exact=exact)
        ]

    monkeypatch.setattr("dynsim.engine.lmgc90.shapes", in_pieces)
    blocks = [box((-0.5, -0.4, -0.3), (0.5, 0.4, 0), name="stone"), box((-0.5, -0.4, 0), (0.5, 0.4, 0.2), name="slab")]
    down = np.radians(degrees)
    gravity = 9.81 * np.array([np.sin(down), 0.0, -np.cos(down)])
    slab = Assembly.from_blocks(blocks, supports=["stone"], friction=0.5, gravity=gravity)
    assert verify(slab, engine="lmgc90").outcome.word == outcome


def star_of_a_box(corners: np.ndarray) -> list[np.ndarray]:
    """A tetrahedron on each triangle of its surface, with the centre."""
    hull = ConvexHull(corners)
    return [np.vstack([corners[triangle], corners.mean(axis=0)]) for triangle in hull.simplices]


@pytest.mark.slow
def test_a_dome_of_warped_blocks_stands_and_its_shapes_hardly_overlap():
    found = verify(warped_dome(1e-3))
    assert found.outcome.word == "stands"
    assert found.run.initial_overlap < 4e-3  # warped by 1e-3 m on either side


def test_a_block_that_needs_coacd_says_what_to_install(monkeypatch):
    monkeypatch.setattr(bodies, "convex_pieces", lambda *_, **__: None)
    monkeypatch.setitem(sys.modules, "coacd", None)
    with pytest.raises(InputError, match=r'needs the package coacd: pip install "blockstat\[dynamics\]"'):
        shapes(Assembly.from_blocks([Block(BENT_CORNERS, BENT_FACES)]))
