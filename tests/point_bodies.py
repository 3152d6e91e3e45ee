"""Bodies on edges and corners whose limits are known, as they are, turned, far from the origin and in other units."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from blockstat import Block, limit_load
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.program.equilibrium import weight
from evidence.scenes.small import assembly, box

EXACT = 1e-6
FLOOR = box((-9, -9, -1), (9, 9, 0), name="floor", group="floor")
#: The same scene as it is, turned, far from the origin, and in other units.
PLACES = {
    "here": lambda points: points,
    "turned": lambda points: points @ TURN.T,
    "utm": lambda points: points + [5e5, 5e6, 100],
    "turned, utm": lambda points: points @ TURN.T + [5e5, 5e6, 100],
    "millimetres": lambda points: 1e-3 * points,
    "kilometres": lambda points: 1e3 * points,
}
SCALE = {"millimetres": 1e-3, "kilometres": 1e3}
EVERYWHERE = pytest.mark.parametrize(
    ("place", "flip"), [*((place, False) for place in PLACES), ("here", True), ("turned, utm", True)]
)
TURN = Rotation.from_rotvec([0.3, -0.5, 1.1]).as_matrix()


def prism(outline, low, high, **options):
    """A prism along y with an outline in x and z, counter-clockwise seen from -y."""
    n = len(outline)
    vertices = [(x, low, z) for x, z in outline] + [(x, high, z) for x, z in outline]
    sides = [[i, n + i, n + (i + 1) % n, (i + 1) % n] for i in range(n)]
    return Block(vertices, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides], **options)


def moved(block, rotation=None, shift=(0.0, 0.0, 0.0)):
    turn = np.eye(3) if rotation is None else rotation
    return Block(np.asarray(block.vertices, float) @ np.asarray(turn).T + shift, block.faces, block.name)


def hull(points, **options):
    """The convex hull of points, in triangles."""
    points = np.asarray(points, dtype=float)
    found = ConvexHull(points)
    faces = []
    for simplex, plane in zip(found.simplices, found.equations, strict=True):
        a, b, c = points[simplex]
        outward = np.cross(b - a, c - a) @ plane[:3] > 0
        faces.append([int(i) for i in (simplex if outward else simplex[::-1])])
    return Block(points, faces, **options)


def placed(blocks, supports, *, place="here", flip=False, **options):
    """A scene moved to a place or with its blocks in reverse order, and the turn of its axes."""
    turn = TURN if "turned" in place else np.eye(3)
    blocks = [Block(PLACES[place](np.asarray(b.vertices, float)), b.faces, b.name, group=b.name) for b in blocks]
    if flip:
        blocks, supports = blocks[::-1], [len(blocks) - 1 - k for k in supports]
    return assembly(blocks, supports=supports, gravity=turn @ [0, 0, -1.0], **options), turn


def limit(blocks, supports, push, *, place="here", flip=False, friction=0.5, **options):
    """Bounds of the limit load of the last block."""
    scene, turn = placed(blocks, supports, place=place, flip=flip, friction=friction)
    return limit_load(scene, turn @ np.asarray(push, float), **options)


def torque_limit(blocks, supports, axis, *, place="here", flip=False, friction=0.5, **options):
    """Bounds of the torque on the last block, in its weight times a metre of the scene before it was scaled."""
    scene, turn = placed(blocks, supports, place=place, flip=flip, friction=friction)
    body = 0 if flip else len(blocks) - 1
    loads = np.zeros((len(blocks), 6))
    loads[body, 3:] = np.linalg.norm(weight(scene)[body]) * SCALE.get(place, 1.0) * turn @ np.asarray(axis, float)
    return limit_load(scene, loads, **options)


def agrees(found, exact):
    assert found.outcome is LoadOutcome.LIMIT
    assert found.lower == pytest.approx(exact, rel=EXACT)
    assert found.upper == pytest.approx(exact, rel=EXACT)


def tetrahedron(dent):
    """Regular, of edge 1, its base pushed in to a point; it stands on three vertices."""
    base = [(np.cos(t) / np.sqrt(3), np.sin(t) / np.sqrt(3), 0) for t in np.deg2rad([0, 120, 240])]
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 4, 2], [2, 4, 3], [3, 4, 1]]
    return Block([(0, 0, np.sqrt(2 / 3)), *base, (0, 0, dent)], faces, name="body")


def ridge(x, **options):
    return prism([(x - 0.2, 0), (x + 0.2, 0), (x, 0.2)], -1, 1, **options)


def crossed_keels(keels=(-0.2, 0.2)):
    """A body with keels along y on ridges along x at y = +-c, and c and the height of its centroid."""
    c = 0.35
    feet = [(x + dx, z) for x in keels for dx, z in ((-0.1, 0.3), (0.0, 0.0), (0.1, 0.3))]
    body = prism([(-0.4, 0.3), *feet, (0.4, 0.3), (0.4, 0.7), (-0.4, 0.7)], -1, 1, name="body")
    across = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
    rails = [moved(ridge(y), across, (0, 0, -0.2)) for y in (-c, c)]
    return [*rails, body], c, float(assembly([body]).centroid[0, 2])


def ladder(degrees, length=4.0, thick=0.2):
    """A box that leans from the floor against a wall with two edges of its underside."""
    angle = np.deg2rad(degrees)
    foot, head = np.zeros(2), length * np.array([np.cos(angle), np.sin(angle)])
    up = thick * np.array([-np.sin(angle), np.cos(angle)])
    wall = box((head[0], -3, 0), (head[0] + 1, 3, 6), name="wall")
    plan = [tuple(map(float, p)) for p in (foot, head, head + up, foot + up)]
    return [FLOOR, wall, prism(plan, -0.3, 0.3, name="body")]


def prism_in_a_groove():
    """An octagonal prism of circumradius 1 with two edges on the flanks of a V of half angle 45 degrees."""
    groove = prism([(-3, -1), (3, -1), (3, 3), (0, 0), (-3, 3)], -9, 9, name="groove")
    turns = np.deg2rad(45 * np.arange(8))
    octagon = [(float(np.cos(t)), float(np.sqrt(2) + np.sin(t))) for t in turns]
    return [groove, prism(octagon, -4, 4, name="body")]


def octahedron_in_a_corner():
    """An octahedron with three vertices on three faces at right angles, its axis vertical."""
    axis = np.array([[1, -1, 0], [1, 1, -2], [1, 1, 1]]) / np.sqrt([[2], [6], [3]])
    axis[1] = np.cross(axis[2], axis[0])
    slabs = [box((-1, -1, -1), (0, 4, 4)), box((0, -1, -1), (4, 0, 4)), box((0, 0, -1), (4, 4, 0))]
    r = 0.5
    tips = [r * np.ones(3) + sign * r * np.eye(3)[k] for k in range(3) for sign in (1, -1)]
    return [*(moved(slab, axis) for slab in slabs), moved(hull(tips, name="body"), axis)], axis
