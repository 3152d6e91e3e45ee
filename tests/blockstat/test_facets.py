"""Faces in one plane are one face, exactly and nearly; blocks without such faces cost nothing."""

import numpy as np
import pytest

from blockstat import Assembly, Block, InputError, assess, box, find_interfaces, read
from blockstat.geometry.triangulation import triangulate
from blockstat.surface.facets import facets


def in_triangles(block):
    vertices = np.asarray(block.vertices, dtype=float)
    return Block(vertices, triangulate(vertices, [np.array(face) for face in block.faces]).tolist())


def prism(outline, depth):
    """Right prism along y over an outline in the plane x, z, counter-clockwise seen from -y."""
    outline = np.asarray(outline, dtype=float)
    n = len(outline)
    vertices = [(x, y, z) for y in (0.0, depth) for x, z in outline]
    sides = [[(i + 1) % n, i, i + n, (i + 1) % n + n] for i in range(n)]
    return Block(vertices, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides])


def surface(blocks):
    """Sorted outlines as sets of places, one a face."""
    return sorted(sorted(map(tuple, blocks.vertices[f].round(9).tolist())) for f in faces(blocks))


def faces(blocks):
    return np.split(blocks.face_vertices, blocks.face_start[1:-1])


U = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]


@pytest.mark.parametrize("block", [box((0, 0, 0), (2, 1, 1)), prism(U, 1.0)], ids=["box", "U"])
def test_a_triangulated_block_gets_its_faces_back(block):
    whole = Assembly.from_blocks([block], supports=[0])
    merged = facets(Assembly.from_blocks([in_triangles(block)], supports=[0]))
    assert surface(merged) == surface(whole)
    np.testing.assert_allclose(merged.volume, whole.volume, rtol=1e-14)
    # Outlines keep their sense: normals point outward.
    assert sorted(map(tuple, merged.planes.normal.round(9))) == sorted(map(tuple, whole.planes.normal.round(9)))


def test_a_corner_on_a_straight_edge_goes_when_both_faces_are_merged():
    n = 4
    ticks = np.linspace(0, 1, n + 1)
    cells = [(a, b) for a in range(n) for b in range(n)]
    places, sides = {}, []

    def number(point):
        return places.setdefault(tuple(point), len(places))

    for axis in range(3):
        for end in (0.0, 1.0):
            for a, b in cells:
                ring = [(a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1)][:: 1 if end else -1]
                sides.append([number(np.roll((end, ticks[u], ticks[v]), axis)) for u, v in ring])
    fine = Assembly.from_blocks([Block(list(places), sides)], supports=[0])
    assert len(fine.face_block) == 96
    assert surface(facets(fine)) == surface(Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], supports=[0]))


def test_blocks_without_such_faces_are_not_copied():
    wall = Assembly.from_blocks([box((x, 0, 0), (x + 1, 1, 1)) for x in range(5)], supports=[0])
    assert facets(wall) is wall


def test_a_face_with_a_hole_stays_in_pieces():
    # A square tube: its two ends are rings, here of four trapezoids each.
    outer, inner = [(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (3, 1), (3, 3), (1, 3)]
    vertices = [(x, y, z) for z in (0.0, 1.0) for x, y in outer + inner]
    rings = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    faces = [[v + 8 for v in ring] for ring in rings] + [ring[::-1] for ring in rings]
    faces += [[i, (i + 1) % 4, (i + 1) % 4 + 8, i + 8] for i in range(4)]
    faces += [[4 + (i + 1) % 4, 4 + i, 4 + i + 8, 4 + (i + 1) % 4 + 8] for i in range(4)]
    tube = Assembly.from_blocks([Block(vertices, faces)], supports=[0])
    assert tube.volume[0] == pytest.approx(12.0)
    assert facets(tube) is tube


def bent(angle, *, length=1.0):
    """A block whose top is folded along the middle, higher there by length / 2 times tan(angle)."""
    rise = length / 2 * np.tan(angle)
    return prism([(0, 0), (length, 0), (length, 1), (length / 2, 1 + rise), (0, 1)], 1.0)


@pytest.mark.parametrize(("share", "n_faces"), [(1.01, 6), (0.99, 7)])
def test_a_folded_face_is_one_if_it_fits_between_two_planes(share, n_faces):
    # The fold lies length / 2 * tan(angle) over the plane through its ends, which is that of the vector area.
    angle = np.deg2rad(3.0)
    block = Assembly.from_blocks([bent(angle)], supports=[0])
    rise = 0.5 * np.tan(angle)
    assert len(facets(block, tolerance=np.array([share * rise])).face_block) == n_faces


@pytest.mark.parametrize(("degrees", "n_faces"), [(7.4, 6), (7.6, 7)])
def test_a_face_that_leans_further_is_another_one_however_flat(degrees, n_faces):
    block = Assembly.from_blocks([bent(np.deg2rad(degrees))], supports=[0])
    assert len(facets(block, tolerance=np.array([0.1])).face_block) == n_faces


def rough_pair(rng, noise):
    """Two blocks of triangles whose common face z = 0 is a grid of its own on each side, with noise."""
    blocks = []
    for side, cells in ((-1.0, 5), (1.0, 7)):
        ticks = np.linspace(0, 1, cells + 1)
        grid = [(x, y, rng.uniform(-noise, noise)) for x in ticks for y in ticks]
        n = cells + 1
        joint = [
            half
            for i in range(cells)
            for j in range(cells)
            for a, b, c, d in [(i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1)]
            for half in ((a, b, c), (a, c, d))
        ]
        rim = [i * n for i in range(n)] + [cells * n + j for j in range(1, n)]
        rim += [i * n + cells for i in range(cells - 1, -1, -1)] + list(range(cells - 1, 0, -1))
        m = len(rim)
        far = [(grid[v][0], grid[v][1], side) for v in rim]
        first = n * n
        walls = [[rim[i], rim[(i + 1) % m], first + (i + 1) % m, first + i] for i in range(m)]
        faces = [list(f)[::-1] for f in joint] + walls + [list(range(first, first + m))]
        blocks.append(Block(grid + far, faces if side > 0 else [f[::-1] for f in faces]))
    return Assembly.from_blocks(blocks, supports=[0], friction=0.6)


@pytest.mark.filterwarnings("ignore::blockstat.errors.InputWarning")
def test_rough_faces_make_one_joint_at_a_stated_gap():
    pair = rough_pair(np.random.default_rng(3), 2e-4)
    found = find_interfaces(pair, gap="2 mm")
    assert found.n_interfaces == 1
    assert found.area[0] == pytest.approx(1.0, rel=1e-3)
    assert abs(found.frame[0, 0, 2]) == pytest.approx(1.0, abs=1e-5)
    # Each side leaves its plane by up to the noise, and the gap says so.
    assert 2e-4 < found.gap[0] < 2e-3
    # A tilted floor: sliding begins at the coefficient of friction, whatever the triangles say.
    for slope, word in ((0.59, "stable"), (0.61, "unstable")):
        assert assess(pair, gravity=(9.81 * slope, 0, -9.81), gap="2 mm").outcome.word == word


@pytest.mark.parametrize("gap", ["2", "2 miles", "0 mm", "-1 mm", "mm", 0.3, None])
def test_a_gap_that_is_neither_share_nor_length_is_refused(gap):
    blocks = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))], supports=[0])
    with pytest.raises(InputError, match='or a length such as "2 mm"'):
        find_interfaces(blocks, gap=gap)


@pytest.mark.parametrize(("gap", "joints"), [("2 mm", 1), ("0.002 m", 1), ("0.19cm", 1), ("1.7 mm", 0), (0.0017, 0)])
def test_a_joint_is_as_open_as_the_stated_length(gap, joints):
    blocks = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1.0018), (1, 1, 2.0018))], supports=[0])
    assert find_interfaces(blocks, gap=gap).n_interfaces == joints


def glb_in_millimetres(path, gap, *, turn=0.0, away=0.0):
    """Write twenty bricks in a row, so many millimetres apart, in single precision: z up, turned and far away."""
    import trimesh

    rng, scene, end = np.random.default_rng(5), trimesh.Scene(), 0.0
    matrix = trimesh.transformations.rotation_matrix(turn, (0.3, 0.4, 0.5))
    for k in range(20):
        length = rng.uniform(100, 300)
        brick = trimesh.creation.box(bounds=[[end, 0, 0], [end + length, 100, 60]])
        brick.apply_transform(matrix)
        brick.apply_translation((away, away, 0))
        scene.add_geometry(brick, node_name=f"brick{k}", geom_name=f"brick{k}")
        end += length + gap
    scene.export(path)
    return path


@pytest.mark.parametrize(("turn", "away"), [(0.0, 0.0), (0.7, 0.0), (0.7, 1e3)])
def test_a_joint_of_exactly_the_stated_gap_is_one_in_single_precision(tmp_path, turn, away):
    path = glb_in_millimetres(tmp_path / "row.glb", 2.0, turn=turn, away=away)
    row = read(path, supports=["brick0"], units="mm", up="z")
    found = find_interfaces(row, gap="2 mm")
    assert (found.gap > 0.002).any()  # rounding opened some of them
    assert found.n_interfaces == 19


def test_a_joint_wider_than_the_stated_gap_is_none_and_the_message_shows_it(tmp_path):
    path = glb_in_millimetres(tmp_path / "row.glb", 2.003)
    verdict = assess(read(path, supports=["brick0"], units="mm", up="z"), gap="2 mm")
    assert not len(verdict.interfaces.pair)
    assert any("gap tolerance 2 mm" in text and "with 0.002003 m" in text for text in verdict.warnings)
