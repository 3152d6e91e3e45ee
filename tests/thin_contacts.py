"""Blocks that touch at edges and corners, with their contacts written down by hand from vertices and faces.

The contacts follow the vertices, so that they can be had again for blocks that have moved a little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat import Block, Interfaces
from blockstat.contact.faces import frames
from blockstat.contact.features import ContactKind
from evidence.scenes.small import assembly, box

#: Numbers of the faces of a box.
BOTTOM, TOP, EAST = 0, 1, 3


@dataclass(frozen=True)
class Edge:
    """An edge of a block: two of its vertices."""

    block: int
    tail: int
    head: int


@dataclass(frozen=True)
class Contact:
    """A contact between blocks a < b.

    The normal is that of a face, (block, number), or of the two edges that cross. A point is a vertex, (block, number),
    or where two edges cross.
    """

    a: int
    b: int
    kind: ContactKind
    normal: tuple
    points: tuple


def vertex(asm, block, number):
    """A vertex of a block."""
    return asm.vertices[asm.vertex_start[block] + number]


def crossing(asm, one: Edge, two: Edge):
    """The middle of the shortest line between two edges, and the product of their directions."""
    p, q = vertex(asm, one.block, one.tail), vertex(asm, two.block, two.tail)
    d, e = vertex(asm, one.block, one.head) - p, vertex(asm, two.block, two.head) - q
    normal = np.cross(d, e)
    s, t, _ = np.linalg.solve(np.column_stack([d, -e, normal]), q - p)
    return (p + s * d + q + t * e) / 2, normal


def contacts(asm, rules) -> Interfaces:
    """The interfaces of contacts by hand."""
    normals, points, counts = [], [], []
    for rule in rules:
        if rule.kind is ContactKind.CROSSING:
            _, normal = crossing(asm, *rule.normal)
            outward = normal @ (asm.centroid[rule.b] - asm.centroid[rule.a])
        else:
            block, face = rule.normal
            normal = asm.planes.normal[np.searchsorted(asm.face_block, block) + face]
            outward = 1.0 if block == rule.a else -1.0
        normals.append(np.sign(outward) * normal / np.linalg.norm(normal))
        own = [crossing(asm, *p)[0] if isinstance(p[0], Edge) else vertex(asm, *p) for p in rule.points]
        points += own
        counts.append(len(own))
    none = np.zeros(len(rules))
    return Interfaces(
        pair=np.array([(rule.a, rule.b) for rule in rules]), frame=frames(np.array(normals)), area=none, gap=none,
        point=np.array(points), start=np.concatenate([[0], np.cumsum(counts)]),
        kind=np.array([rule.kind for rule in rules], np.int8),
    )  # fmt: skip


def extruded(outline, low, high, axis=1, **options) -> Block:
    """A prism along x or y over an outline in the plane (other axis, z).

    The outline is counter-clockwise as seen from -y for a prism along y, from +x for one along x. Vertices are those
    of the low end, then those of the high end.
    """
    n = len(outline)
    ends = [np.insert(np.asarray(outline, float), axis, at, axis=1) for at in (low, high)]
    near, far = list(range(n)), list(range(n, 2 * n))
    sides = [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
    faces = [near, far[::-1], *sides]
    if axis == 0:
        faces = [face[::-1] for face in faces]
    return Block(np.concatenate(ends), faces, **options)


def on_ridges(mu=0.8, eccentric=0.0, c=0.3):
    """Reference 7.2: a box 1.0 x 0.8 x 1.2 on two ridges along y; one is longer than the box, the other is shorter."""
    ridges = [
        extruded([(x - 0.1, -0.2), (x + 0.1, -0.2), (x, 0.0)], *ends, name=name)
        for name, x, ends in (("left", -c, (-0.2, 1.0)), ("right", c, (0.1, 0.7)))
    ]
    body = box((-0.5 + eccentric, 0, 0), (0.5 + eccentric, 0.8, 1.2), name="box")
    asm = assembly([*ridges, body], supports=[0, 1], friction=mu)
    ridge = Edge(0, 2, 5)
    ends = ((ridge, Edge(2, 0, 1)), (ridge, Edge(2, 3, 2)))
    return asm, (
        Contact(0, 2, ContactKind.EDGE, (2, BOTTOM), ends),
        Contact(1, 2, ContactKind.EDGE, (2, BOTTOM), ((1, 2), (1, 5))),
    )


def ladder(mu=0.5, length=4.0, thick=0.2, degrees=60.0):
    """Reference 7.4: a ladder of a thickness; the edges of its underside touch floor and wall."""
    angle = np.deg2rad(degrees)
    up, out = np.array([-np.cos(angle), np.sin(angle)]), thick * np.array([np.sin(angle), np.cos(angle)])
    foot = np.array([length * np.cos(angle), 0.0])
    outline = [foot, foot + out, foot + out + length * up, foot + length * up]
    floor, wall = box((-1, -1, -1), (4, 2, 0), name="floor"), box((-1, -1, 0), (0, 2, 5), name="wall")
    asm = assembly([floor, wall, extruded(outline, 0.0, 0.6, name="ladder")], supports=[0, 1], friction=mu)
    return asm, (
        Contact(0, 2, ContactKind.EDGE, (0, TOP), ((2, 0), (2, 4))),
        Contact(1, 2, ContactKind.EDGE, (1, EAST), ((2, 3), (2, 7))),
    )


def on_keels(mu=1.0, a=0.2, c=0.35):
    """Reference 7.3: a body with two keels along y at x = -a, a on two ridges along x at y = -c, c."""
    ridges = [
        extruded([(y - 0.1, -0.2), (y + 0.1, -0.2), (y, 0.0)], -0.5, 0.5, axis=0, name=name)
        for name, y in (("south", -c), ("north", c))
    ]
    outline = [(-a, 0.0), (0.0, 0.1), (a, 0.0), (2 * a, 0.1), (2 * a, 1.0), (-2 * a, 1.0), (-2 * a, 0.1)]
    body = extruded(outline, -0.6, 0.6, name="body")
    asm = assembly([*ridges, body], supports=[0, 1], friction=mu)
    keels = [Edge(2, k, k + len(outline)) for k in (0, 2)]
    pairs = [(Edge(ridge, 2, 5), keel) for ridge in (0, 1) for keel in keels]
    return asm, tuple(Contact(p[0].block, 2, ContactKind.CROSSING, p, (p,)) for p in pairs)


def on_three_corners(mu=0.8, hollow=0.1):
    """Reference 7.1: a tetrahedron of edge 1 whose base is pushed in, so that three corners stand on the floor."""
    angle = np.deg2rad([90.0, 210.0, 330.0])
    base = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) / np.sqrt(3)
    vertices = [*base, (0, 0, np.sqrt(2 / 3)), (0, 0, hollow)]
    faces = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]]
    floor = box((-1, -1, -1), (1, 1, 0), name="floor")
    asm = assembly([floor, Block(np.array(vertices), faces, name="tripod")], friction=mu)
    return asm, tuple(Contact(0, 1, ContactKind.CORNER, (0, TOP), ((1, k),)) for k in range(3))


def in_groove(mu=0.2):
    """Reference 7.5: an octagonal prism with two of its edges on the flanks of a V of 45 degrees to either side.

    The flanks lie along the axes, so gravity leans by 45 degrees.
    """
    angle = np.deg2rad(np.arange(0, 360, 45.0))
    outline = np.column_stack([np.cos(angle), np.sin(angle)])
    flanks = [box((-2, -1, -1), (-1, 2, 1), name="flank"), box((-1, -1, -2), (1, 2, -1), name="floor")]
    asm = assembly(
        [*flanks, extruded(outline, 0.0, 1.9, name="prism")], supports=[0, 1], friction=mu,
        gravity=np.array([-1.0, 0, -1.0]) / np.sqrt(2),
    )  # fmt: skip
    return asm, (
        Contact(0, 2, ContactKind.EDGE, (0, EAST), ((2, 4), (2, 12))),
        Contact(1, 2, ContactKind.EDGE, (1, TOP), ((2, 6), (2, 14))),
    )


def on_one_ridge(**options):
    """A box 1.0 x 0.8 x 1.2 balanced on the edge of one ridge."""
    ridge = extruded([(-0.1, -0.2), (0.1, -0.2), (0.0, 0.0)], 0.0, 0.8, name="ridge", group="ridge")
    asm = assembly([ridge, box((-0.5, 0, 0), (0.5, 0.8, 1.2), name="box", group="box")], **options)
    return asm, (Contact(0, 1, ContactKind.EDGE, (1, BOTTOM), ((0, 2), (0, 5))),)
