"""What walls must satisfy, by independent geometry: plans through shapely, areas by summing faces."""

from __future__ import annotations

import numpy as np
import shapely

from blockstat import Assembly, find_interfaces
from blockstat.contact.overlap.penetration import convex_blocks, overlaps
from blockstat.contact.tolerance import ROUNDING
from blockstat.model.solids import box


def grounded(blocks, **options):
    """An assembly on a fixed slab whose top is at z = 0."""
    corners = np.vstack([b.vertices for b in blocks])
    (x0, y0, _), (x1, y1, _) = corners.min(axis=0) - 1, corners.max(axis=0) + 1
    slab = box((x0, y0, -0.5), (x1, y1, 0.0), name="ground", group="ground")
    return Assembly.from_blocks([slab, *blocks], supports=[0], **options)


def band(path, thickness):
    """Plan of a run, closed if its path comes back to its first point."""
    if tuple(path[0]) == tuple(path[-1]):
        return shapely.LinearRing(path[:-1]).buffer(thickness / 2, join_style="mitre", mitre_limit=100)
    return shapely.LineString(path).buffer(thickness / 2, cap_style="flat", join_style="mitre", mitre_limit=100)


def check_solid(blocks, *, area: float, height: float, girth: float, tolerance: float = 1e-9):
    """Sound walls of upright faces without openings. area, girth : of the plan of their union [m2, m].

    Returns the assembly and its interfaces.
    """
    asm = grounded(blocks)
    faces = check(asm, volume=area * height, foot=area, outside=2 * area + girth * height, tolerance=tolerance)
    return asm, faces


def check(asm, *, volume: float, foot: float, outside: float, tolerance: float = 1e-9):
    """Convex blocks that do not overlap, fill a volume [m3], and leave no joint open; returns the interfaces.

    Every face of a block is in a joint or outside: the area of all faces is twice that of the joints, less the ground's
    side of the foot, plus the outer surface with the foot. foot, outside : areas of the union [m2].
    """
    faces, closed = tight(asm)
    grounds = (faces.pair == 0).any(axis=1)
    np.testing.assert_allclose(asm.volume[1:].sum(), volume, rtol=tolerance)
    np.testing.assert_allclose(faces.area[closed & grounds].sum(), foot, rtol=tolerance)
    joints = faces.area[closed & ~grounds].sum()
    np.testing.assert_allclose(surface(asm), 2 * joints + outside, rtol=tolerance)
    return faces


def tight(asm):
    """Convex blocks that do not overlap, each in a joint without a gap; returns the interfaces and which have none.

    The finder takes small gaps for joints, also those of sloping and upright faces that meet at an edge only; such
    count for nothing here. Faces that are bent by less than the rounding of single precision are one to it.
    """
    faces = find_interfaces(asm)
    assert convex_blocks(asm).all()
    assert len(overlaps(asm, gap=1e-9)[0]) == 0
    closed = faces.gap < 2 * ROUNDING * np.ptp(asm.vertices, axis=0).max()
    assert np.unique(faces.pair[closed]).tolist() == list(range(asm.n_blocks))
    return faces, closed


def surface(asm) -> float:
    """Area of all faces of all blocks but the first [m2]."""
    total = 0.0
    for f, (a, b) in enumerate(zip(asm.face_start, asm.face_start[1:], strict=False)):
        if asm.face_block[f] > 0:
            ring = asm.vertices[asm.face_vertices[a:b]]
            total += np.linalg.norm(np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0)) / 2
    return total


def head_joints(asm, faces=None):
    """Upright joints as (course z, segment in plan) by their lower end: list of (z0, z1, shapely LineString)."""
    faces = find_interfaces(asm) if faces is None else faces
    found = []
    for k in range(faces.n_interfaces):
        if abs(faces.frame[k, 0, 2]) > 1e-6 or 0 in faces.pair[k]:
            continue
        points = faces.point[faces.start[k] : faces.start[k + 1]]
        line = shapely.MultiPoint(points[:, :2]).convex_hull
        found.append((points[:, 2].min(), points[:, 2].max(), line))
    return found


def straight_joints(asm, faces=None):
    """Places in plan where an upright joint stands on another, as segments."""
    joints = head_joints(asm, faces)
    tops = {}
    for z0, z1, line in joints:
        tops.setdefault(round(z1, 6), []).append((z0, line))
    found = []
    for z0, _, line in joints:
        for _, below in tops.get(round(z0, 6), []):
            meeting = line.intersection(below.buffer(1e-7, cap_style="flat"))
            if meeting.length > 1e-3 * line.length:
                found.append(meeting)
    return found
