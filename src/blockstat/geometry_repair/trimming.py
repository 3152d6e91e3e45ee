"""Cut blocks that overlap where they meet: each loses its half of the overlap, up to one plane between them."""

from __future__ import annotations

from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from blockstat.assembly import Assembly, Block
from blockstat.contact.tolerance import allowed_gap
from blockstat.errors import InputError
from blockstat.geometry.convex_pieces import convex_pieces
from blockstat.geometry.inscribed_ball import inscribed_balls
from blockstat.geometry.triangulation import triangulate
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

#: A block may lose this part of its extent across the cut; with more gone, it is another block.
MOST = 0.25
#: Common parts thinner than this share of their extent are rounding.
ROUNDING = 1e-9
#: A block whose convex hull is larger by no more than this share is taken for its hull: bent faces, no notch.
NOTCH = 0.05


def trim_overlaps(assembly: Assembly, pairs: Ints, *, gap: float | str) -> tuple[Assembly, Floats]:
    """Cut pairs of overlapping blocks by the plane halfway through the overlap.

    The plane is parallel to that face of one of the two from which the overlap is least deep: the normal of the joint.
    Supports keep their shape, and the block on them loses all of the overlap: up to a plane for each convex piece of
    the support that reaches into it, the deepest first. Blocks that are cut become convex.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    pairs : array of int, shape (n, 2)
        Which overlap, as `blockstat.overlaps` finds them.
    gap : float or str
        The overlap that is none, as it was given there.

    Returns
    -------
    assembly : Assembly
        The blocks, those that were cut with new corners; masses are as given.
    cut : array of float, shape (n_blocks,)
        The furthest that a block was cut back by one plane [m].

    Raises
    ------
    InputError
        Naming two blocks, where one of them has a notch, or would lose more than a quarter of its extent.

    Examples
    --------
    >>> from blockstat import Assembly, box, overlaps
    >>> blocks = [box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2)), box((0, 0, 1.9), (1, 1, 3))]
    >>> stack = Assembly.from_blocks(blocks, supports=[0])
    >>> trimmed, cut = trim_overlaps(stack, overlaps(stack, gap=0.01)[0], gap=0.01)
    >>> cut.round(6).tolist(), trimmed.volume.round(6).tolist(), len(overlaps(trimmed, gap=0.01)[0])
    ([0.0, 0.05, 0.05], [1.0, 0.95, 1.05], 0)
    """
    solids = {int(block): _hull(assembly.block_vertices(block)) for block in np.unique(pairs)}
    cut = np.zeros(assembly.n_blocks)
    allowed = allowed_gap(assembly, gap)
    for a, b in pairs:
        if assembly.support[[a, b]].any():
            support, block = map(int, (a, b) if assembly.support[a] else (b, a))
            within = float(allowed[[a, b]].min() / 2)
            pieces = _support_pieces(assembly, support, solids[block], within)
            for _ in pieces:  # each cut parts the block from one of them for good
                normal, depth, offset = max((_way_out(own, solids[block], within) for own in pieces), key=itemgetter(1))
                if depth <= 0:
                    break
                solids[block] = _behind(assembly, (a, b), block, solids[block], normal, offset)
                cut[block] = max(cut[block], depth)
            continue
        normal, depth, face = _least_overlap(solids[a], solids[b])
        if depth <= 0:  # an earlier cut parted them
            continue
        for block, way in ((int(a), 1.0), (int(b), -1.0)):
            offset = way * (face - depth / 2)
            solids[block] = _behind(assembly, (a, b), block, solids[block], way * normal, offset)
            cut[block] = max(cut[block], depth / 2)
    return _replaced(assembly, {block: solids[block] for block in np.flatnonzero(cut).tolist()}), cut


def _hull(points: Floats) -> ConvexHull:
    from scipy.spatial import ConvexHull

    return ConvexHull(points)


def _support_pieces(assembly: Assembly, support: int, solid: ConvexHull, tolerance: float) -> list[Floats]:
    """Planes of the convex pieces of a support near a block."""
    vertices = assembly.block_vertices(support)
    surface = vertices[triangulate(vertices, assembly.faces_of(support))]
    corners = solid.points[solid.vertices]
    return convex_pieces([surface], corners.min(axis=0)[None], corners.max(axis=0)[None], np.array([tolerance]))[0]


def _way_out(piece: Floats, solid: ConvexHull, within: float) -> tuple[Floats, float, float]:
    """The plane of the shallowest cut that parts a block from a piece of a support: its normal, the depth, its offset.

    Only what lies deeper in the block than `within` counts, half of what a joint may overlap: the ball of a deeper
    overlap has its middle there. The depth is 0 where nothing does.
    """
    from scipy.spatial import HalfspaceIntersection

    own = solid.equations[:, :3]
    normals = np.concatenate([own, piece[:, :3]])
    reach = np.concatenate([-solid.equations[:, 3] - within, piece[:, 3]])
    radius, centre = inscribed_balls(normals, reach, np.array([0, len(reach)]))
    if radius[0] <= ROUNDING * float(np.abs(reach - normals @ centre[0]).max()):
        return np.zeros(3), 0.0, 0.0
    common = HalfspaceIntersection(np.column_stack([normals, -reach]), centre[0]).intersections
    ways = np.concatenate([own, -piece[:, :3]])
    offset = (common @ ways.T).min(axis=0)
    depth = (solid.points[solid.vertices] @ ways.T).max(axis=0) - offset
    least = int(depth.argmin())
    return ways[least], float(depth[least]), float(offset[least])


def _least_overlap(one: ConvexHull, two: ConvexHull) -> tuple[Floats, float, float]:
    """Normal from the first to the second solid along which they overlap least, how far, and where the first ends."""
    normals = np.concatenate([one.equations[:, :3], -two.equations[:, :3]])
    reach = (one.points[one.vertices] @ normals.T).max(axis=0)
    depth = reach - (two.points[two.vertices] @ normals.T).min(axis=0)
    least = int(depth.argmin())
    return normals[least], float(depth[least]), float(reach[least])


def _behind(
    assembly: Assembly, pair: tuple[int, int], block: int, solid: ConvexHull, normal: Floats, offset: float
) -> ConvexHull:
    """The part of a solid where normal . x <= offset."""
    points = solid.points
    height = points @ normal - offset
    names = " and ".join(f'"{assembly.names[own]}"' for own in pair)
    advice = "draw them apart, or let `blockstat repair` close their joints"
    if solid.volume > (1.0 + NOTCH) * assembly.volume[block]:
        raise InputError(f'blocks {names} overlap, and "{assembly.names[block]}" has a notch: {advice}')
    own = height[solid.vertices]
    if own.max() > MOST * (own.max() - own.min()):
        raise InputError(
            f'blocks {names} overlap by so much that "{assembly.names[block]}" would lose {1e3 * own.max():,.0f} mm of '
            f"{1e3 * (own.max() - own.min()):,.0f} mm: {advice}"
        )
    first, second = np.unique(np.sort(solid.simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0).T
    crossing = height[first] * height[second] < 0
    first, second = first[crossing], second[crossing]
    share = height[first] / (height[first] - height[second])
    between = points[first] + share[:, None] * (points[second] - points[first])
    return _hull(np.concatenate([points[solid.vertices[own <= 0]], between]))


def _replaced(assembly: Assembly, solids: dict[int, ConvexHull]) -> Assembly:
    """The assembly with some blocks of other shape and the same mass."""
    blocks = []
    for number, name in enumerate(assembly.names):
        vertices, faces = assembly.block_vertices(number), [face.tolist() for face in assembly.faces_of(number)]
        density = float(assembly.density[number])
        if number in solids:
            solid = solids[number]
            vertices, faces = _surface(solid)
            density *= float(assembly.volume[number] / solid.volume)
        blocks.append(Block(vertices, faces, name, assembly.groups[number], density))
    kept = ("name", "friction", "gravity", "metadata", "joints", "ties")
    return Assembly.from_blocks(
        blocks, supports=np.flatnonzero(assembly.support).tolist(), **{key: getattr(assembly, key) for key in kept}
    )


def _surface(solid: ConvexHull) -> tuple[Floats, list[list[int]]]:
    """Corners and outward triangles of a convex hull."""
    row = np.full(len(solid.points), -1)
    row[solid.vertices] = np.arange(len(solid.vertices))
    corners, faces = solid.points[solid.vertices], row[solid.simplices]
    a, b, c = corners[faces].swapaxes(0, 1)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), solid.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return corners, faces.tolist()
