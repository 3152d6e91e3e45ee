"""Concave faces that an exporter cut into fans: folded triangles are no faces, and nothing is clamped by them."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import blockstat
from blockstat import Assembly, Block, assess, find_interfaces, limit_load
from blockstat.errors import InputError
from blockstat.surface.outlines import boundary, covered

#: The outline of an angle, seen along y: a foot 2 m long and 1 m high with an upright on it.
ANGLE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
#: A square frame around a square hole, joined by a bridge from corner to corner that is walked twice.
FRAME = [(0, 0), (3, 0), (3, 3), (0, 3), (0, 0), (1, 1), (1, 2), (2, 2), (2, 1), (1, 1)]
TURNED = Rotation.from_euler("xyz", [0.3, 0.7, 1.1]).as_matrix()
PLACES = {
    "as drawn": (np.eye(3), np.zeros(3), 1.0),
    "turned": (TURNED, np.zeros(3), 1.0),
    "far away": (TURNED, np.array([5e5, 5.4e6, 100.0]), 1.0),
    "in mm": (np.eye(3), np.zeros(3), 1000.0),
    "small": (TURNED, np.zeros(3), 0.01),
}


def prism(outline, depth=(0.0, 0.5)):
    """Vertices and faces of a prism along y; its front and back are polygons."""
    n = len(outline)
    vertices = np.array([(x, y, z) for y in depth for x, z in outline], dtype=float)
    sides = [[(k + 1) % n, k, k + n, (k + 1) % n + n] for k in range(n)]
    return vertices, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides]


def bar(low, high):
    return prism([(low[0], low[2]), (high[0], low[2]), (high[0], high[2]), (low[0], high[2])], (low[1], high[1]))


def fans(faces, first):
    """Each face as a fan of triangles about one of its corners."""
    found = []
    for face in faces:
        k = first % len(face)
        ring = face[k:] + face[:k]
        found += [[ring[0], a, b] for a, b in zip(ring[1:-1], ring[2:], strict=True)]
    return found


def mirrored(vertices, faces):
    return vertices * [-1, 1, 1], [face[::-1] for face in faces]


def assembled(solids, *, first=None, place="as drawn", digits=None):
    """The first solid carries the others; all faces are fans, or polygons if `first` is None."""
    turn, origin, scale = PLACES[place]
    blocks = []
    for k, (vertices, faces) in enumerate(solids):
        at = scale * vertices @ turn.T + origin
        at = at if digits is None else np.round(at, digits)
        blocks.append(Block(at, faces if first is None else fans(faces, first), name=f"stone {k}"))
    return Assembly.from_blocks(blocks, supports=[0], gravity=tuple(turn @ [0, 0, -9.81]))


def overhanging(length):
    """The angle, and a bar that lies on its foot and touches its upright 0.3 m or more from there."""
    return [prism(ANGLE), bar((1.3, 0, 1), (1.3 + length, 0.5, 2))]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("first", range(6))
def test_a_bar_whose_centre_is_beyond_the_foot_falls_however_the_angle_is_cut(first, mirror, place):
    """The bar rests up to x = 2; its centre at x = 2.15 is beyond, so no reaction balances its moment."""
    solids = [mirrored(*own) if mirror else own for own in overhanging(1.7)]
    drawn, cut = assembled(solids, place=place), assembled(solids, first=first, place=place)
    true, found = assess(drawn), assess(cut)
    scale = PLACES[place][2]
    assert found.outcome.word == "unstable"
    assert found.interfaces.n_interfaces == 1
    assert found.interfaces.area == pytest.approx([0.7 * 0.5 * scale**2], rel=1e-9 if place != "far away" else 1e-8)
    assert found.score == pytest.approx(true.score, rel=1e-6)
    assert cut.volume == pytest.approx(drawn.volume, rel=1e-9)


@pytest.mark.parametrize("first", range(6))
def test_a_bar_on_the_foot_tips_at_the_load_of_its_moments(first):
    """1 m long from x = 1.3 and 1 m high: about the edge x = 2 the weight has an arm of 0.2, the load one of 0.5."""
    limit = limit_load(assembled(overhanging(1.0), first=first), (1, 0, 0))
    assert limit.lower == pytest.approx(0.4, rel=1e-3)
    assert limit.upper == pytest.approx(0.4, rel=1e-3)


@pytest.mark.parametrize("digits", [6, 5, 4])
@pytest.mark.parametrize("first", range(6))
def test_corners_of_few_digits_do_not_hide_a_fold(first, digits):
    solids = [(0.3 * vertices, faces) for vertices, faces in overhanging(1.7)]
    assert assess(assembled(solids, first=first, place="turned", digits=digits)).outcome.word == "unstable"


@pytest.mark.parametrize("first", range(len(FRAME)))
def test_a_frame_with_a_bridge_to_its_hole_touches_a_lid_around_the_hole(first):
    """A lid of 2 m by 2 m covers the hole of 1 m by 1 m and rests on what is around it."""
    solids = [prism(FRAME), bar((0.5, 0.5, 0.5), (2.5, 0.8, 2.5))]
    found = find_interfaces(assembled(solids, first=first))
    assert found.area == pytest.approx([2.0 * 2.0 - 1.0], rel=1e-9)


def test_a_hole_of_merged_corners_is_cut_into_triangles_that_do_not_overlap():
    """Corners at one place count as one where each triangle has its own: then the bridge is no outline."""
    vertices, faces = prism(FRAME)
    triangles = fans(faces, 1)
    own = Block(vertices[np.concatenate(triangles)], np.arange(3 * len(triangles)).reshape(-1, 3).tolist())
    frame = Assembly.from_blocks([own])
    front = frame.planes.normal[:, 1] < -0.9
    assert frame.planes.area[front].sum() == pytest.approx(3.0 * 3.0 - 1.0, rel=1e-9)
    assert frame.volume == pytest.approx([0.5 * 8.0], rel=1e-12)


def write_obj(path, solids):
    lines, before = [], 1
    for k, (vertices, faces) in enumerate(solids):
        lines += [f"o stone{k}", *("v " + " ".join(map(repr, corner)) for corner in vertices.tolist())]
        lines += ["f " + " ".join(str(v + before) for v in face) for face in faces]
        before += len(vertices)
    path.write_text("\n".join(lines))


def write_json(path, solids):
    blocks = [
        {"name": f"stone{k}", "vertices": vertices.tolist(), "faces": faces}
        for k, (vertices, faces) in enumerate(solids)
    ]
    path.write_text(json.dumps({"name": "angle", "units": "m", "supports": [0], "blocks": blocks}))


def write_mesh(path, solids):
    import trimesh

    meshes = [trimesh.Trimesh(*own, process=False) for own in solids]
    whole = trimesh.util.concatenate(meshes)
    scene = trimesh.Scene({f"stone{k}": mesh for k, mesh in enumerate(meshes)})
    (scene if path.suffix == ".glb" else whole).export(path)


@pytest.mark.parametrize("suffix", ["obj", "json", "stl", "ply", "glb"])
@pytest.mark.parametrize("first", range(6))
def test_all_formats_answer_as_the_polygons_do(first, suffix, tmp_path):
    path = tmp_path / f"angle.{suffix}"
    solids = [(vertices, fans(faces, first)) for vertices, faces in overhanging(1.7)]
    {"obj": write_obj, "json": write_json}.get(suffix, write_mesh)(path, solids)
    verdict = assess(blockstat.read(path, supports=[0], **({"up": "z"} if suffix == "glb" else {})))
    assert verdict.outcome.word == "unstable"
    assert verdict.interfaces.area == pytest.approx([0.35], rel=1e-6)  # single precision
    assert verdict.score == pytest.approx(assess(assembled(overhanging(1.7))).score, rel=1e-5)


@pytest.mark.parametrize("thickness", [1e-2, 1e-4, 1e-5])
def test_the_two_sides_of_a_plate_or_a_blade_are_no_fold(thickness):
    plate = assembled([bar((0, 0, 0), (1, 1, thickness))], first=0)
    blade = assembled([prism([(0, 0), (1, 0), (1, thickness)])], first=0)
    assert len(plate.face_block) == 12
    assert len(blade.face_block) == 8


def test_solids_of_one_block_that_share_corners_stay_as_they_are():
    one, two = bar((0, 0, 0), (1, 1, 1)), bar((1, 0, 0), (2, 1, 1))
    vertices = np.concatenate([one[0], two[0]])
    faces = one[1] + [[k + 8 for k in face] for face in two[1]]
    unique, number = np.unique(vertices, axis=0, return_inverse=True)
    shared = [number.reshape(-1)[face].tolist() for face in faces]
    with pytest.warns(blockstat.InputWarning, match="hold separate solids"):
        pair = Assembly.from_blocks([Block(unique, shared)])
    assert len(pair.face_block) == 12


def test_a_fold_that_is_no_face_is_refused_by_name():
    """An outline that crosses itself: the signed sum looks both ways, in a strip thinner than the gap of a joint."""
    vertices, faces = prism([(0, 0), (4, 0), (4, 1), (1, 1), (1, -0.008), (0, -0.008)])
    with pytest.raises(InputError, match=r'block "stone 0": face [0-9]+ lies folded'):
        assembled([(vertices, faces)], first=4)


def test_faces_of_an_outline_with_a_hole_keep_corners_that_lie_on_its_sides():
    """A square of 2 with corners in the middle of its sides and a square hole of 1."""
    outer = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    hole = [(0.5, 0.5), (0.5, 1.5), (1.5, 1.5), (1.5, 0.5)]
    corners = np.array(outer + hole, dtype=float)
    edges = boundary([list(range(8)), list(range(8, 12))])
    found = covered(edges, dict(enumerate(corners)), 1e-9)
    assert boundary(found) == edges
    rings = [corners[face] for face in found]
    area = [np.sum(r[:, 0] * np.roll(r[:, 1], -1) - np.roll(r[:, 0], -1) * r[:, 1]) / 2 for r in rings]
    assert min(area) > 0
    assert sum(area) == pytest.approx(3.0, rel=1e-12)
