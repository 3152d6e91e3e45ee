"""What every element of masonry must satisfy, for the tests of the builders."""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np

from blockstat import find_interfaces
from blockstat.contact.overlap.penetration import convex_blocks, overlaps
from blockstat.contact.tolerance import ROUNDING


def sound(assembly, *, convex: bool = False):
    """The interfaces of an assembly whose joints close, whose blocks do not overlap and all touch another.

    Joints may be open by the rounding of single precision on both sides: faces that are bent by less are one in the
    search.

    convex : whether every block must be convex. Overlaps of curved blocks are measured piece by piece, to rounding of
    the pieces.
    """
    faces = find_interfaces(assembly)
    extent = np.ptp(assembly.vertices, axis=0).max()
    assert faces.gap[faces.kinds == 0].max() < 2 * ROUNDING * extent
    assert not [d for d in faces.dropped if d.reason == "gap"]
    assert np.unique(faces.pair).tolist() == list(range(assembly.n_blocks))
    if convex:
        assert convex_blocks(assembly).all()
    assert len(overlaps(assembly, gap=1e-9 if convex else 1e-6)[0]) == 0
    return faces


def joint_areas(assembly, faces) -> dict[tuple[str, str], float]:
    """Area of contact of each pair of blocks by their names, supports first [m2]."""
    found: dict[tuple[str, str], float] = defaultdict(float)
    for (a, b), area in zip(faces.pair, faces.area, strict=True):
        a, b = sorted((int(a), int(b)), key=lambda i: (not assembly.support[i], i))
        found[assembly.names[a], assembly.names[b]] += area
    return dict(found)


def outline_volume(assembly) -> float:
    """Volume inside the surface that is left when the faces two blocks share, corner for corner, are taken away [m3].

    Equal to the sum of the blocks' volumes only where neighbours share whole faces. Raises AssertionError when the
    rest is not a closed surface: then faces that should match do not.
    """
    _, index = np.unique(assembly.vertices, axis=0, return_inverse=True)
    index = index.ravel()
    faces = [
        index[assembly.face_vertices[a:b]] for a, b in zip(assembly.face_start, assembly.face_start[1:], strict=False)
    ]
    number = Counter(frozenset(face.tolist()) for face in faces)
    assert max(number.values()) == 2
    where = np.empty((index.max() + 1, 3))
    where[index] = assembly.vertices
    volume, edges = 0.0, Counter()
    for face in faces:
        if number[frozenset(face.tolist())] == 2:
            continue
        ring = where[face] - where[0]
        volume += float(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) @ ring.mean(axis=0)) / 6
        for a, b in zip(face, np.roll(face, -1), strict=True):
            edges[int(a), int(b)] += 1
    assert all(count == edges[b, a] for (a, b), count in list(edges.items())), "shared faces do not match"
    return volume
