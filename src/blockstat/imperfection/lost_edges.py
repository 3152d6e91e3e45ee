"""Joints that have lost a strip along each of their edges."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.coplanar import Patch
from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.geometry import clipping
from blockstat.geometry.polyhedron import next_in_face
from blockstat.imperfection.bare_contacts import BareContacts, common_part
from blockstat.imperfection.lost_patches import corner_speeds, joined_patches, lose_rims
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Share of the loss at which an edge vanishes up to which all corners move on straight lines: short of rounding.
BEFORE = 1.0 - 1e-9


def check_edges(what: str, interfaces: Interfaces) -> None:
    """Raise InputError for joints that are divided into cells, whose points are not their corners.

    Parameters
    ----------
    what
        What their edges are asked for; the message begins with it.
    interfaces
        The joints.

    Raises
    ------
    InputError
        Where there are cells.
    """
    if interfaces.share is not None:
        raise InputError(f"{what}: joints that are divided into cells have no edges to lose")


def lose_edges(interfaces: Interfaces, depth: Floats, assembly: Assembly | None = None) -> Interfaces:
    """Move the edges of joints inwards; joints of which nothing is left are no contacts any more.

    Parameters
    ----------
    interfaces
        Joints without cells.
    depth
        How far the edges of each joint move, shape (n_interfaces,) [m].
    assembly
        The blocks, whose faces lose strips as wide; None: only the joints lose them.

    Returns
    -------
    Interfaces
        The joints that are left. An edge on a face loses both ends; corners and crossings stay as they are. Of blocks
        that are given, what of edges and corners lies on a lost strip of a face is lost, and crossings that a slip as
        long as the strip is wide parts. A joint of several patches loses the edges of each: one that is narrower than
        twice the depth is lost.
    """
    return without_edges(interfaces, depth, assembly)[0]


def without_edges(interfaces: Interfaces, depth: Floats, assembly: Assembly | None = None) -> tuple[Interfaces, Ints]:
    """Move the edges of joints inwards, as `lose_edges`, and say which joints are left.

    Parameters
    ----------
    interfaces
        Joints without cells.
    depth
        How far the edges of each joint move, shape (n_interfaces,) [m].
    assembly
        The blocks, whose faces lose strips as wide; None: only the joints lose them.

    Returns
    -------
    interfaces : Interfaces
        The joints that are left.
    rows : Ints
        Their numbers among those given, shape (n_left,).
    """
    speed = edge_speeds(interfaces)
    plain = depth < BEFORE * first_event(interfaces, speed)
    plain[list(interfaces.parts)] = False
    bare = None if assembly is None else BareContacts(assembly, interfaces, depth)
    if bare is not None:
        plain &= interfaces.kinds == ContactKind.FACE
    k = interfaces.point_interface
    drawn = interfaces.drawn or interfaces
    lost = (depth[k] * plain[k])[:, None] * speed
    moved = replace(interfaces, patches=None, drawn=drawn, point=interfaces.point + lost)
    moved = replace(moved, area=np.where(plain, _areas(moved), interfaces.area))
    if plain.all():
        return moved, np.arange(interfaces.n_interfaces)
    points, area, kind = np.split(moved.point, interfaces.start[1:-1]), moved.area.copy(), interfaces.kinds.copy()
    pieces: list[Patch] = []
    for k in np.flatnonzero(~plain).tolist():
        if k in interfaces.parts:
            points[k], own = _lose_rims(interfaces, k, float(depth[k]), bare)
            area[k] = sum(patch.area for patch in own)
            kind[k] = {1: ContactKind.CORNER, 2: ContactKind.EDGE}.get(len(points[k]), ContactKind.FACE)
            pieces += own
            continue
        shrink = _inset if interfaces.kinds[k] == ContactKind.FACE else _shorten
        whole = points[k]
        points[k], area[k] = shrink(whole[None], interfaces.frame[k : k + 1], depth[k : k + 1])[0]
        if bare is not None and interfaces.kinds[k] != ContactKind.FACE and len(points[k]):
            points[k] = common_part(points[k], bare.left(k, whole))
    if interfaces.patches is not None and pieces:
        moved = replace(moved, patches=interfaces.patches.take(np.empty(0, np.int64)).with_more(pieces))
    if kind.any():
        moved = replace(moved, kind=kind)
    rows = np.flatnonzero([len(own) > 0 for own in points])
    left = [points[k] for k in rows]
    start = np.concatenate([[0], np.cumsum([len(own) for own in left])]).astype(np.int64)
    point = np.concatenate([np.empty((0, 3)), *left])
    return replace(moved.subset(rows), point=point, start=start, area=area[rows]), rows


def _lose_rims(interfaces: Interfaces, k: int, depth: float, bare: BareContacts | None) -> tuple[Floats, list[Patch]]:
    """Corners of the hull of a joint of several patches without their edges, and what is left of them."""
    frame, origin = interfaces.frame[k], interfaces.point[interfaces.start[k]]
    own = interfaces.parts[k]
    if bare is not None:
        own = [part if len(part) > 2 else _before_loss(part, bare.left(k, part), depth) for part in own]
    parts, hull = lose_rims([(part - origin) @ frame[1:].T for part in own if len(part)], depth)
    area = clipping.area
    left = [
        Patch(
            interfaces.pair[k], frame, origin, float(area(part[None], np.array([len(part)]))[0]) * (len(part) > 2),
            float(interfaces.gap[k]), part,
        )
        for part in parts
    ]  # fmt: skip
    return origin + hull @ frame[1:], left


def _before_loss(whole: Floats, left: Floats, depth: float) -> Floats:
    """An edge or a corner beside patches, so that nothing but what the faces leave of it is left without its ends."""
    if len(whole) < 2:
        return left
    (ends, _), *_ = _shorten(whole[None], whole, np.array([depth]))
    ends = common_part(ends, left) if len(ends) else ends
    along = depth * (whole[1] - whole[0]) / np.linalg.norm(whole[1] - whole[0])
    return ends + np.stack([-along, along])[: len(ends)]


def first_event(interfaces: Interfaces, speed: Floats) -> Floats:
    """Return how much joints may lose along their edges before an edge has no length any more.

    Parameters
    ----------
    interfaces
        Joints without cells.
    speed
        As `edge_speeds` gives it.

    Returns
    -------
    Floats
        Shape (n_interfaces,) [m]; infinite for corners and crossings.
    """
    following = next_in_face(interfaces.start)
    along = interfaces.point[following] - interfaces.point
    square = np.einsum("ij,ij->i", along, along)
    closing = -np.einsum("ij,ij->i", along, speed[following] - speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        life = np.where(closing > 0, square / closing, np.inf)
    return np.minimum.reduceat(life, interfaces.start[:-1])


def least_width(interfaces: Interfaces) -> Floats:
    """Return how wide each joint is across its narrowest direction.

    Parameters
    ----------
    interfaces
        Joints without cells.

    Returns
    -------
    Floats
        The least distance from an edge to the corner farthest from it; the length of an edge on a face, and 0 for
        corners and crossings. Of a joint of several patches, the least of those of its patches that have a width; two
        that are convex together are one. Shape (n_interfaces,) [m].
    """
    width = np.zeros(interfaces.n_interfaces)
    for k in range(interfaces.n_interfaces):
        corners = interfaces.point[interfaces.start[k] : interfaces.start[k + 1]]
        parts = [(part - corners[0]) @ interfaces.frame[k, 1:].T for part in interfaces.parts.get(k, [corners])]
        whole = joined_patches(parts) if len(parts) > 1 else parts
        width[k] = min((own for own in map(_width, whole) if own > 0), default=0.0)
    return width


def _width(corners: Floats) -> float:
    """The least width of a convex patch in its plane, the length of an edge, and 0 for a corner."""
    if len(corners) < 3:
        return float(np.linalg.norm(corners[-1] - corners[0]))
    along = np.roll(corners, -1, axis=0) - corners
    away = corners[None, :] - corners[:, None]
    height = np.abs(along[:, None, 0] * away[..., 1] - along[:, None, 1] * away[..., 0])
    return float((height.max(axis=1) / np.linalg.norm(along, axis=1)).min())


def _areas(interfaces: Interfaces) -> Floats:
    """Areas of convex patches from their corners; 0 for what is none."""
    k, first = interfaces.point_interface, interfaces.start[:-1]
    local = interfaces.point - interfaces.point[first][k]
    twice = np.add.reduceat(np.cross(local, local[next_in_face(interfaces.start)]), first)
    area = np.abs(np.einsum("ij,ij->i", twice, interfaces.frame[:, 0])) / 2
    return np.where(interfaces.kinds == ContactKind.FACE, area, 0.0)


def edge_speeds(interfaces: Interfaces) -> Floats:
    """Return how contact points move while the edges of their joints move inwards.

    Parameters
    ----------
    interfaces
        Joints without cells.

    Returns
    -------
    Floats
        Displacement of each point per displacement of the edges, shape (n_points, 3): a corner stays on both of its
        edges, an end of an edge on a face moves along it, and corners and crossings stay where they are. The edges of a
        joint of several patches are theirs.
    """
    k, kinds = interfaces.point_interface, interfaces.kinds
    following = next_in_face(interfaces.start)
    along = interfaces.point[following] - interfaces.point
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    inward = np.cross(interfaces.frame[k, 0], along)
    first = interfaces.start[:-1]
    middle = np.add.reduceat(interfaces.point, first) / np.diff(interfaces.start)[:, None]
    turn = np.add.reduceat(np.einsum("ij,ij->i", inward, middle[k] - interfaces.point), first)
    inward *= np.sign(turn)[k, None]
    before = np.empty_like(inward)
    before[following] = inward
    with np.errstate(invalid="ignore", divide="ignore"):  # of edges, whose two sides are opposite
        speed = (inward + before) / (1.0 + np.einsum("ij,ij->i", inward, before))[:, None]
    kind = kinds[k]
    speed = np.where(
        (kind == ContactKind.FACE)[:, None], speed, np.where((kind == ContactKind.EDGE)[:, None], along, 0)
    )
    for joint, parts in interfaces.parts.items():
        own, across = slice(interfaces.start[joint], interfaces.start[joint + 1]), interfaces.frame[joint, 1:]
        origin = interfaces.point[interfaces.start[joint]]
        flat = [(part - origin) @ across.T for part in parts]
        speed[own] = corner_speeds((interfaces.point[own] - origin) @ across.T, flat) @ across
    return speed


def _inset(corners: Floats, frame: Floats, depth: Floats) -> list[tuple[Floats, float]]:
    """Corners and area of polygons whose edges moved inwards; no corners where nothing is left."""
    n, size, _ = corners.shape
    if not n:
        return []
    origin = corners[:, :1]
    flat = np.einsum("nkj,nij->nki", corners - origin, frame[:, 1:])
    all_count: Ints = np.full(n, size)
    turned = clipping.area(flat, all_count) < 0
    flat[turned] = flat[turned, ::-1]
    polygon, count = clipping.inset(flat, depth)
    area = clipping.area(polygon, count)
    needed = clipping.corners(polygon, count, 1e-9 * np.sqrt(np.maximum(area, 0.0)))
    world = origin + np.einsum("nki,nij->nkj", polygon, frame[:, 1:])
    return [
        (points[live], float(own)) if own > 0 and live.sum() > 2 else (points[:0], 0.0)
        for points, live, own in zip(world, needed, area, strict=True)
    ]


def _shorten(corners: Floats, _: Floats, depth: Floats) -> list[tuple[Floats, float]]:
    """The ends of segments, moved towards each other; single points stay."""
    if corners.shape[1] != 2:
        return [(points, 0.0) for points in corners]
    along = corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(along, axis=1)
    step = (depth / length)[:, None] * along
    moved = np.stack([corners[:, 0] + step, corners[:, 1] - step], axis=1)
    return [(points if whole > 0 else points[:0], 0.0) for points, whole in zip(moved, length - 2 * depth, strict=True)]
