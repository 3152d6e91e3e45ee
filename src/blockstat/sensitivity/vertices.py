"""Derivatives of the limit load and of the score by every corner of the blocks, without solving again.

Envelope theorem, as in `blockstat.sensitivity.parameters`: with forces f in their joints' frames and twist u held
fixed,

    d lambda / dx = -d/dx u'(A f + w + lambda l)    with l' u = 1,
    d (1/2 |s|^2) / dx = d/dx u'(A (f - E s) + w).

Here x is a *shared point*: all corners of blocks that lie at one place move together, so that blocks that touch go on
touching. Its motion changes volumes, centroids and so weights and loads; turns the joints' frames; and takes contact
points along. The frame of a patch turns with the Newell normals of its faces, half by each side, that of an edge or a
corner on a face with the normal of that face, and that of two edges a and b that cross with a x b. A contact point at a
corner of a block goes where the corner goes. One at the crossing of two edges stays at their crossing; where the edges
of a rough mesh run together, it goes with their mean. The ends of ties stay where they are. Faces may go warped to
first order: volumes are then those of the faces split about their mean corner, as everywhere in this package.

Where a corner lies on another block's edge, moving it one way drags the contact point along and moving it the other
way may not: the derivative is that of motions after which it still lies there. For a motion of all points that
keeps faces planar and blocks in touch, the sum over points is the derivative of a design that moves so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad
from blockstat.analysis.verdict import Outcome, Verdict, relative_motion
from blockstat.assembly import Assembly
from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import ANGLE, GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.geometry.components import connected_components
from blockstat.geometry.polyhedron import next_in_face
from blockstat.loads import acceleration
from blockstat.program.ties import tie_wrenches
from blockstat.sensitivity.parameters import penalty_optimum, pinned, score_load
from blockstat.typing import Floats, Ints

#: Corners of different blocks this close, relative to the smallest block, are one point.
SHARED = 1e-6
#: A contact point this close to a corner or an edge, seen along the normal and relative to the blocks, lies on it.
ON = 1e-5
#: Edges at a smaller angle (sine) than this do not cross but run together.
ALONG = 1e-3


@dataclass(frozen=True, eq=False)
class PointGradient:
    """A value and its derivative by the places of all shared points; the ends of ties stay where they are."""

    value: float  #: limit load multiplier, or score
    points: Floats  #: shape (n_points, 3) [m]
    vertex_point: Ints  #: the point of each vertex of the assembly, shape (n_vertices,)
    gradient: Floats  #: shape (n_points, 3) [1/m]

    def along(self, motion: Floats) -> float:
        """Return the derivative along a motion of the points.

        Parameters
        ----------
        motion
            Shape (n_points, 3) [m].

        Returns
        -------
        float
            Change of the value; the motion times the gradient.
        """
        return float((self.gradient * motion).sum())


@known_options
def shared_points(assembly: Assembly, *, tolerance: float = SHARED) -> tuple[Floats, Ints]:
    """Return the places where corners lie.

    Parameters
    ----------
    assembly
        The blocks.
    tolerance
        Corners closer than this share a place, relative to the size of the smallest block.

    Returns
    -------
    points : Floats
        Shape (n_points, 3) [m].
    label : Ints
        The place of each vertex, shape (n_vertices,).

    Examples
    --------
    A cube on a cube has twelve places for sixteen corners.

    >>> from blockstat import Assembly, box, shared_points
    >>> cubes = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))], supports=[0])
    >>> points, label = shared_points(cubes)
    >>> points.shape, label.shape
    ((12, 3), (16,))
    """
    from scipy.spatial import KDTree

    close = KDTree(assembly.vertices).query_pairs(tolerance * float(assembly.size.min()), output_type="ndarray")
    count, label = connected_components(len(assembly.vertices), close)
    points = np.zeros((count, 3))
    np.add.at(points, label, assembly.vertices)
    return points / np.bincount(label, minlength=count)[:, None], label.astype(np.int64)


def limit_load_by_point(limit: LimitLoad, direction: Sequence[float], *, tolerance: float = SHARED) -> PointGradient:
    """Return the derivative of a limit load multiplier by the place of every shared point.

    Parameters
    ----------
    limit
        A limit load.
    direction
        Three numbers, the acceleration of which `limit` is the limit; the load follows the masses.
    tolerance
        See `shared_points`.

    Returns
    -------
    PointGradient
        In 1/m.

    Raises
    ------
    InputError
        When there is no limit, when `direction` is not that of its load, or for joints with strengths or bonds or
        without their edges.

    Examples
    --------
    A pillar 2 m high tips at width / height times its weight: higher by 1 m at 0.125 less, to first order.

    >>> import numpy as np
    >>> from blockstat import Assembly, box, limit_load, limit_load_by_point
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = limit_load_by_point(limit_load(pillar, (1, 0, 0)), (1, 0, 0))
    >>> higher = np.where(found.points[:, 2:] == 2.0, (0.0, 0.0, 1.0), 0.0)
    >>> round(found.value, 4), round(found.along(higher), 4)
    (0.25, -0.125)
    """
    multiplier, twist = pinned(limit, acceleration(limit.assembly, direction))
    return point_gradient(limit, multiplier, twist, field_of(limit.assembly, direction, multiplier), tolerance)


def field_of(assembly: Assembly, load: Any, multiplier: float) -> Floats:
    """Return the acceleration that acts on each block's mass at a multiple of a load.

    Parameters
    ----------
    assembly
        The blocks.
    load
        As in `blockstat.limit_load`; wrenches do not follow the masses.
    multiplier
        Of the load.

    Returns
    -------
    Floats
        Shape (n_blocks, 3) [m/s2].
    """
    field = np.tile(assembly.gravity, (assembly.n_blocks, 1))
    if np.shape(load) == (3,):
        field += multiplier * acceleration(assembly, load)[:, :3] / assembly.mass[:, None]
    return field


def point_gradient(
    limit: LimitLoad, multiplier: float, twist: Floats, field: Floats, tolerance: float = SHARED
) -> PointGradient:
    """Return the derivative of a limit load multiplier by the place of every shared point.

    Parameters
    ----------
    limit
        The limit load.
    multiplier, twist
        As `blockstat.sensitivity.parameters.pinned` gives them.
    field
        Acceleration of each block's mass, shape (n_blocks, 3) [m/s2].
    tolerance
        See `shared_points`.

    Returns
    -------
    PointGradient
        In 1/m.
    """
    by_vertex, _ = _by_vertex(limit, twist, limit.forces, field)
    return _gathered(limit.assembly, multiplier, -by_vertex, tolerance)


def score_by_point(verdict: Verdict, *, tolerance: float = SHARED) -> PointGradient:
    """Return the derivative of the score by the place of every shared point; zero for a stable verdict.

    Parameters
    ----------
    verdict
        A verdict without `loads`.
    tolerance
        See `shared_points`.

    Returns
    -------
    PointGradient
        In 1/m.

    Raises
    ------
    InputError
        For an infinite score, or for joints with strengths or bonds or without their edges.

    Examples
    --------
    A pillar that tips needs less adhesion once it is wider.

    >>> import numpy as np
    >>> from blockstat import Assembly, assess, box, score_by_point
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"], gravity=(3.0, 0.0, -9.81))
    >>> found = score_by_point(assess(pillar))
    >>> wider = np.where(found.points[:, :1] == 0.5, (1.0, 0.0, 0.0), 0.0)
    >>> found.along(wider) < 0 < found.value
    True
    """
    assembly = verdict.assembly
    if verdict.outcome is Outcome.STABLE:
        return _gathered(assembly, 0.0, np.zeros_like(assembly.vertices), tolerance)
    twist, net = penalty_optimum(verdict)
    tension = float(np.linalg.norm(verdict.adhesion))
    field = np.broadcast_to(assembly.gravity, (assembly.n_blocks, 3))
    energy, mass = _by_vertex(verdict, twist, net, field)
    load = score_load(assembly)
    size = np.linalg.norm(load, axis=1)
    heavier = mass * (load @ assembly.gravity / np.where(size > 0, size, 1.0))[assembly.vertex_block, None]
    change = (energy / tension - verdict.score * heavier) / size.sum()
    return _gathered(assembly, verdict.score, change, tolerance)


def _gathered(assembly: Assembly, value: float, by_vertex: Floats, tolerance: float) -> PointGradient:
    points, label = shared_points(assembly, tolerance=tolerance)
    gradient = np.zeros_like(points)
    np.add.at(gradient, label, by_vertex)
    return PointGradient(value, points, label, gradient)


def _by_vertex(result: LimitLoad | Verdict, twist: Floats, forces: Floats, field: Floats) -> tuple[Floats, Floats]:
    """Derivatives by each vertex of u'(A f + m field) and of the free blocks' mass, each shape (n_vertices, 3).

    field : acceleration on each block, shape (n_blocks, 3) [m/s2].
    """
    assembly, interfaces = result.assembly, result.interfaces
    if any(set(law.as_dict()) - {"between", "friction"} for law in assembly.joints):
        raise InputError("joints with strengths or bonds, which are shared by area, have no derivative by corners")
    if interfaces.drawn is not None:
        raise InputError("joints that have lost their edges have no derivative by corners, on which they do not lie")
    k, first = interfaces.point_interface, interfaces.start[:-1]
    a, b = interfaces.pair[k].T
    force = np.einsum("nij,ni->nj", interfaces.frame[k], forces)
    # A contact point that moves by dp changes the moments, by u: w . (dp x F) = dp . (F x w).
    by_contact = np.cross(force, twist[b, 3:] - twist[a, 3:])
    # A frame that turns by dt changes the forces: (dt x F) . V = dt . (F x V), and dt = n x dn.
    slip = relative_motion(assembly, interfaces, twist)
    world = np.einsum("nij,ni->nj", interfaces.frame[k], slip)
    by_normal = np.cross(np.add.reduceat(np.cross(force, world), first), interfaces.frame[:, 0])
    on_block = np.zeros((assembly.n_blocks, 3))
    if result.ties is not None:
        on_block += tie_wrenches(assembly, assembly.ties, result.ties)[:, :3]
    np.add.at(on_block, b, force)
    np.subtract.at(on_block, a, force)
    by_centroid = -np.cross(on_block, twist[:, 3:])
    by_mass = np.einsum("ij,ij->i", twist[:, :3], field)

    block = assembly.vertex_block
    volume, centroid = _integrals_by_vertex(assembly)
    mass = np.where(assembly.support, 0.0, assembly.density)[block, None] * volume
    change = by_mass[block, None] * mass + np.einsum("nij,nj->ni", centroid, by_centroid[block])
    for number in range(interfaces.n_interfaces):
        _add_joint(change, assembly, interfaces, number, by_contact, by_normal[number])
    return change, mass


def _integrals_by_vertex(assembly: Assembly) -> tuple[Floats, Floats]:
    """Derivatives of each vertex's block's volume, shape (n_vertices, 3) [m2], and centroid, (n_vertices, 3, 3).

    The last axis is the centroid's. The volume is that of the tetrahedra of
    `blockstat.geometry.polyhedron.integrals`, with
    the centroid as apex, so that first moments vanish and change by their own derivative alone.
    """
    vertex, start = assembly.face_vertices, assembly.face_start
    count = np.diff(start)
    block = np.repeat(assembly.face_block, count)
    following = next_in_face(start)
    a = assembly.vertices[vertex] - assembly.centroid[block]
    b = a[following]
    m = np.repeat(np.add.reduceat(a, start[:-1]) / count[:, None], count, axis=0)
    six, total = np.einsum("ij,ij->i", m, np.cross(a, b)), m + a + b

    def both(change: Floats) -> Floats:
        """Derivatives of volume (first on the last axis) and first moments, given that of six volumes."""
        moment = change[:, :, None] * total[:, None] + six[:, None, None] * np.eye(3)
        return np.concatenate([change[:, :, None] / 6, moment / 24], axis=2)

    corner = both(np.cross(b, m))
    np.add.at(corner, following, both(np.cross(m, a)))
    corner += np.repeat(np.add.reduceat(both(np.cross(a, b)), start[:-1]) / count[:, None, None], count, axis=0)
    result = np.zeros((len(assembly.vertices), 3, 4))
    np.add.at(result, vertex, corner)
    return result[:, :, 0], result[:, :, 1:] / assembly.volume[assembly.vertex_block][:, None, None]


def _add_joint(
    result: Floats, assembly: Assembly, interfaces: Interfaces, number: int, by_contact: Floats, by_normal: Floats
) -> None:
    """Add what one joint's contact points and normal say about the vertices that carry them."""
    sides: list[tuple[float, tuple[Ints, Ints, Floats]]] = []
    if interfaces.kinds[number] == ContactKind.CROSSING:
        _add_crossing_normal(result, assembly, interfaces, number, by_normal)
    else:
        sides = joint_sides(assembly, interfaces, number)
    for sign, (tail, head, edge) in sides:
        # Newell: the vector area of a side changes by dx x edge / 2 with edge from the corner before to the one after.
        first = assembly.vertices[tail[0]]  # about a corner nearby, for rounding
        area = (
            np.linalg.norm(np.cross(assembly.vertices[tail] - first, assembly.vertices[head] - first).sum(axis=0)) / 2
        )
        np.add.at(result, tail, sign * np.cross(edge, by_normal) / (2 * area * len(sides)))
    rims = [(tail, head) for _, (tail, head, _) in sides] if len(sides) == 2 else []
    for i in range(interfaces.start[number], interfaces.start[number + 1]):
        vertices, weights = point_carriers(assembly, interfaces, number, i, rims)
        np.add.at(result, vertices, np.einsum("nij,i->nj", weights, by_contact[i]))


def point_carriers(
    assembly: Assembly, interfaces: Interfaces, number: int, point: int, rims: list[tuple[Ints, Ints]]
) -> tuple[Ints, Floats]:
    """Return the vertices that carry a contact point along.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.
    number
        Of the joint.
    point
        Number of one of its contact points.
    rims
        Vertices at the tails and heads of the edges round the joint, for each of two blocks; none where it has no area.

    Returns
    -------
    vertices : Ints
        Shape (n,).
    weights : Floats
        Shape (n, 3, 3): the point moves by the sum of weights @ displacement of the vertex.

    Raises
    ------
    InputError
        For a point that lies on no corner and on no edge.
    """
    pair, frame = interfaces.pair[number], interfaces.frame[number]
    tolerance = ON * float(assembly.size[pair].min())
    vertices, weights = _carriers(assembly.vertices, rims, interfaces.point[point], frame, tolerance)
    if not len(vertices):  # an edge or a corner of one block, on a face or an edge of the other
        edges = [edges_at(assembly, interfaces, number, point, int(block)) for block in pair]
        vertices, weights = _carriers(assembly.vertices, edges, interfaces.point[point], frame, tolerance)
    if not len(vertices):
        one, two = (assembly.names[block] for block in pair)
        raise InputError(f'"{one}" and "{two}": a contact point lies on no corner and on no edge')
    return vertices, weights


def joint_sides(
    assembly: Assembly, interfaces: Interfaces, number: int
) -> list[tuple[float, tuple[Ints, Ints, Floats]]]:
    """Return the faces whose normals are that of a joint, as edges round them, with the sign of their normals.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.
    number
        Of a joint that is no crossing.

    Returns
    -------
    list of (float, (Ints, Ints, Floats))
        Those of both blocks for a patch, and of the block with the face where an edge or a corner of the other lies on
        it: sign, vertices at the tails and heads of the edges, and the vector from the corner before to that after.
    """
    found = [_outline(assembly, interfaces, number, side) for side in (0, 1)]
    signs = (1.0, -1.0)
    if interfaces.area[number] > 0:
        return [(sign, outline) for sign, (_, outline) in zip(signs, found, strict=True)]
    owner = int(found[1][0] > found[0][0])
    return [(signs[owner], found[owner][1])]


def _add_crossing_normal(
    result: Floats, assembly: Assembly, interfaces: Interfaces, number: int, by_normal: Floats
) -> None:
    """Add what the normal a x b / |a x b| of two edges that cross says about their ends."""
    i = int(interfaces.start[number])
    edges = [edges_at(assembly, interfaces, number, i, int(block)) for block in interfaces.pair[number]]
    if not all(len(tail) for tail, _ in edges):
        return  # the contact point has no edge either, which is then said
    (tail_a, head_a), (tail_b, head_b) = ((tail[0], head[0]) for tail, head in edges)
    a, b = assembly.vertices[head_a] - assembly.vertices[tail_a], assembly.vertices[head_b] - assembly.vertices[tail_b]
    product = np.cross(a, b)
    along = by_normal * np.sign(product @ interfaces.frame[number, 0]) / np.linalg.norm(product)
    # by_normal is normal to n, so the change of length of the product has no part in it.
    for tail, head, change in ((tail_a, head_a, np.cross(b, along)), (tail_b, head_b, np.cross(along, a))):
        result[head] += change
        result[tail] -= change


def edges_at(assembly: Assembly, interfaces: Interfaces, number: int, point: int, block: int) -> tuple[Ints, Ints]:
    """Return the edges of a block through a contact point, seen along the normal, each once.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.
    number
        Of the joint.
    point
        Number of one of its contact points.
    block
        One of its two blocks.

    Returns
    -------
    tail, head : Ints
        Vertices, shape (n,) each.
    """
    first, last = np.searchsorted(assembly.face_block, [block, block + 1])
    corners = slice(assembly.face_start[first], assembly.face_start[last])
    tail = assembly.face_vertices[corners]
    head = assembly.face_vertices[next_in_face(assembly.face_start)][corners]
    tail, head = tail[tail < head], head[tail < head]  # the two faces of an edge go along it in opposite ways
    normal, plane = interfaces.frame[number, 0], interfaces.frame[number, 1:]
    start, along = assembly.vertices[tail] - interfaces.point[point], assembly.vertices[head] - assembly.vertices[tail]
    flat = along @ plane.T
    length = np.linalg.norm(flat, axis=1)
    lying = length > ALONG * np.linalg.norm(along, axis=1)
    share = np.clip(-((start @ plane.T) * flat).sum(axis=1) / np.where(lying, length, 1.0) ** 2, 0.0, 1.0)
    offset = start + share[:, None] * along
    size = float(assembly.size[interfaces.pair[number]].min())
    near = lying & (np.linalg.norm(offset @ plane.T, axis=1) <= ON * size)
    near &= np.abs(offset @ normal) <= _slack(assembly, interfaces, number)
    return tail[near], head[near]


def _slack(assembly: Assembly, interfaces: Interfaces, number: int) -> float:
    """How far from the plane of a joint its faces and edges lie: as far as `find_interfaces` merges them [m]."""
    return float(interfaces.gap[number]) + GAP * float(assembly.size[interfaces.pair[number]].min())


def _outline(
    assembly: Assembly, interfaces: Interfaces, number: int, side: int
) -> tuple[float, tuple[Ints, Ints, Floats]]:
    """Edges round the faces of block a (side 0) or b (side 1) on a joint, and how well their normals agree with it.

    The edges are the vertices at their tails and heads, and for each tail the vector from the corner before it to the
    corner after it.
    """
    block, normal = int(interfaces.pair[number, side]), (1.0, -1.0)[side] * interfaces.frame[number, 0]
    middle = interfaces.point[interfaces.start[number] : interfaces.start[number + 1]].mean(axis=0)
    first, last = np.searchsorted(assembly.face_block, [block, block + 1])
    planes = assembly.planes
    off = np.abs(np.einsum("ij,ij->i", planes.centre[first:last] - middle, planes.normal[first:last]))
    agreement = planes.normal[first:last] @ normal
    slack = _slack(assembly, interfaces, number)
    if interfaces.area[number] > 0:
        off = np.where(agreement > np.cos(ANGLE), off, np.inf)
        slack = max(slack, float(off.min()))
    else:
        # The normal is that of one face, and of those in its plane. Others that meet it at the contact have their own.
        best = agreement[off <= slack].max(initial=-1.0)
        off = np.where(agreement >= best - ALONG**2, off, np.inf)
    tail, head, edge = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty((0, 3))]
    for face in first + np.flatnonzero(off <= slack):
        own = assembly.face_vertices[assembly.face_start[face] : assembly.face_start[face + 1]]
        after = own[next_in_face(np.array([0, len(own)]))]
        tail.append(own)
        head.append(after)
        edge.append(assembly.vertices[after] - assembly.vertices[np.roll(own, 1)])
    near = off <= slack
    outline = np.concatenate(tail), np.concatenate(head), np.concatenate(edge)
    return float(agreement[near].max(initial=-1.0)), outline


def _carriers(
    vertices: Floats, edges: list[tuple[Ints, Ints]], point: Floats, frame: Floats, tolerance: float
) -> tuple[Ints, Floats]:
    """Vertices that carry a contact point along and how, dp = sum of weights @ dx, shape (n, 3, 3).

    edges : vertices at the tails and heads of the edges of each block that come into question.
    """
    plane = frame[1:]
    ends = [np.concatenate(both) for both in edges]
    at = [t[np.linalg.norm((vertices[t] - point) @ plane.T, axis=1) <= tolerance] for t in ends]
    found = [np.unique(t) for t in at if len(t)]
    if found:
        share = np.concatenate([np.full(len(t), 1 / len(t) / len(found)) for t in found])
        return np.concatenate(found), share[:, None, None] * np.eye(3)
    if not edges:
        return np.empty(0, np.int64), np.empty((0, 3, 3))
    tail, head = (np.concatenate(column) for column in zip(*edges, strict=True))
    start, along = (vertices[tail] - point) @ plane.T, (vertices[head] - vertices[tail]) @ plane.T
    length = np.linalg.norm(along, axis=1)
    share = -(start * along).sum(axis=1) / length**2
    off = np.abs(start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / length
    on = np.flatnonzero((off <= tolerance) & (share > 0) & (share < 1))
    side = along[on] / length[on, None]
    turn = np.abs(side[:, None, 0] * side[None, :, 1] - side[:, None, 1] * side[None, :, 0])
    if turn.max(initial=0.0) < ALONG:
        # Edges that run together carry the point with them; their crossing runs away with any rounding.
        part = np.concatenate([1 - share[on], share[on]]) / max(len(on), 1)
        return np.concatenate([tail[on], head[on]]), part[:, None, None] * np.eye(3)
    pair = on[list(np.unravel_index(turn.argmax(), turn.shape))]
    # Across each edge the point keeps up with the edge, along the normal with the mean of both.
    across = np.column_stack([-along[pair, 1], along[pair, 0]]) @ plane
    solve = np.linalg.inv(np.vstack([across, frame[0]]))
    carried = [np.outer(solve[:, e], across[e]) + np.outer(solve[:, 2], frame[0]) / 2 for e in (0, 1)]
    parts = [(1 - share[pair[e]], share[pair[e]]) for e in (0, 1)]
    weights = np.stack([part * carried[e] for e in (0, 1) for part in parts[e]])
    return np.array([tail[pair[0]], head[pair[0]], tail[pair[1]], head[pair[1]]]), weights
