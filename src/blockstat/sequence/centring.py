"""Centring: where its boards push on blocks, how these follow when it is lowered by a little, and which joints open.

Boards lie under soffits and push without friction, normal to them. The pressure on a plane face has its resultant
somewhere in the convex hull of what it acts on, as pushes at the corners of that hull have: the props of a centring.

Props that are lowered by d along their lines allow blocks to sink by d there and no more. With rigid blocks the loads
do the most work that joints and props allow::

    maximise w'u   subject to   A'u in K*,   B'u >= -d,

which is the dual of the least total force of the props, d sum r. So u are the multipliers of equilibrium in that
program (`blockstat.sequence.props`): a prop that carries a force lets its block sink by d, and w'u = d sum r. What
stands by itself needs no force and does not move: the centring comes free. Joints hinge at the points where they keep
touching.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.assembly import block_indices
from blockstat.contact.faces import REGROWTH, flatness, frames, outline_hull, uncovered
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import InputError, check_positive, known_options
from blockstat.geometry.clipping import corners as spanning
from blockstat.geometry.polyhedron import point_velocity
from blockstat.loads import up_of
from blockstat.result import Result, plain
from blockstat.sequence.props import Falsework, FalseworkOutcome, Prop, held_by_props
from blockstat.sequence.states import State
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Joints that open by less than this share of the lowering are closed: the accuracy of the program.
CLOSED = 1e-4
#: Faces within this fraction of a block's size of the plane of a joint are in it, what joints leave free of a face is
#: nothing below this fraction of it, and where it is narrower than this fraction of the block's size no board fits.
IN_PLANE = 1e-3
#: Faces that look down equally, to rounding.
AS_STEEP = 1e-6
#: A face whose normal is within 60 degrees of the opposite of a soffit's is across the block from it.
ACROSS = 0.5


@dataclass(frozen=True, eq=False)
class Decentring(Result):
    """What moves when a centring is lowered."""

    assembly: Assembly
    interfaces: Interfaces  #: the joints of the state
    falsework: Falsework  #: the least forces of the props before
    lowering: float  #: [m]
    displacement: Floats  #: of the centroids, and rotations, shape (n_blocks, 6) [m, rad]
    opening: Floats  #: of each joint where it opens most, shape (n_interfaces,) [m]
    hinges: Ints  #: joints that open at some points and keep touching at others

    @property
    def moving(self) -> Ints:
        """Blocks that follow the centring."""
        reach = np.abs(self.displacement[:, :3]).max(axis=1) + np.abs(self.displacement[:, 3:]).max(axis=1)
        return np.flatnonzero(reach > CLOSED * self.lowering)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With the blocks that follow the centring and the joints that hinge.
        """
        names = self.assembly.names
        return {
            "lowering": self.lowering,
            "total": self.falsework.total,
            "moving": [names[k] for k in self.moving],
            "hinges": [
                {"between": [names[k] for k in self.interfaces.pair[j]], "opening": float(self.opening[j])}
                for j in self.hinges
            ],
        }

    def explain(self) -> str:
        """Return the result in words.

        Returns
        -------
        str
            One fact a line.
        """
        if not len(self.moving):
            return "The centring comes free: the blocks stand without it."
        names = self.assembly.names
        lines = [f"Lowered by {1e3 * self.lowering:g} mm, {len(self.moving)} blocks follow the centring."]
        for joint in self.hinges:
            a, b = (names[k] for k in self.interfaces.pair[joint])
            lines.append(f'"{a}" and "{b}" hinge: their joint opens by {plain(1e3 * float(self.opening[joint]))} mm.')
        return "\n".join(lines)


@known_options
def centring(
    assembly: Assembly,
    blocks: Iterable[str],
    *,
    present: Iterable[str] | None = None,
    interfaces: Interfaces | None = None,
) -> list[Prop]:
    """Return the props that stand for the boards of a centring: pushes on the soffits of blocks, normal to them.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    blocks : iterable of str
        The names of those that rest on the centring, now or later.
    present : iterable of str, optional
        The names of those that are there, supports aside; by default all. The others get no props, and take no room.
    interfaces : Interfaces, optional
        The joints of the whole assembly. They are searched for if not given.

    Returns
    -------
    list of Prop
        Those of a block one after the other. It has none where joints leave nothing free of its soffits. Each pushes
        without friction on a corner of the convex hull of what they leave free of a soffit.

    Notes
    -----
    Boards that push on all soffits, normal to them and wherever they like, can balance a state if and only if these
    props can. A soffit is a face that looks down and that no joint covers: a groin stone has two, a warped stone has
    all its triangles, and so has an edge of a vault that leans out. A joint with a block that is absent is none, but
    for two kinds, which no boards carry: one with a block that rests on the same centring, and one that reaches from
    the intrados to the extrados, as the beds of an arch do. The intrados is the face that looks down with the largest
    free plan, and the extrados is across from it, within 60 degrees.

    Examples
    --------
    A block on nothing bears on the four corners of its base.

    >>> from blockstat import Assembly, box, centring
    >>> blocks = [box((-2, 0, -1), (-1, 1, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> sorted(prop.point for prop in centring(assembly, ["block"]))
    [(0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0)]
    """
    joints = find_interfaces(assembly) if interfaces is None else interfaces
    there, mates = assembly.support.copy(), np.zeros(assembly.n_blocks, dtype=bool)
    there[slice(None) if present is None else block_indices(assembly.names, present, "centring: present")] = True
    chosen = assembly.blocks_named(blocks, "centring")
    mates[chosen] = True
    stands = np.logical_or(there[joints.pair].all(axis=1), mates[joints.pair].all(axis=1))
    side, numbers = np.argsort(joints.pair, axis=None, kind="stable"), np.arange(assembly.n_blocks + 1)
    first_joint = np.searchsorted(joints.pair.ravel()[side], numbers).tolist()
    first_face = np.searchsorted(assembly.face_block, numbers).tolist()
    looks_down = _looks_down(assembly)
    found = []
    for block in chosen[there[chosen]].tolist():
        faces = np.arange(first_face[block], first_face[block + 1])
        low = faces[looks_down[faces]]
        every = side[first_joint[block] : first_joint[block + 1]] // 2  # a joint has two sides
        for face, corners in _soffits(assembly, joints, faces, low, every, every[stands[every]]):
            push = tuple((-assembly.planes.normal[face]).tolist())
            found += [Prop(assembly.names[block], tuple(corner), push) for corner in corners.tolist()]
    return found


def _looks_down(assembly: Assembly) -> np.ndarray:
    """Which faces overhang by more than their corners may be off; others are upright, and no board lies under them."""
    corners = assembly.vertices[assembly.face_vertices]
    first = assembly.face_start[:-1]
    extent = np.maximum.reduceat(corners, first) - np.minimum.reduceat(corners, first)
    plan = -(assembly.planes.normal @ up_of(assembly)) * assembly.planes.area
    # In plan a face is at least as wide as its area there over its length.
    return plan > flatness(assembly, GAP)[assembly.face_block] * np.linalg.norm(extent, axis=1)


def _soffits(
    assembly: Assembly, joints: Interfaces, faces: Ints, low: Ints, every: Ints, own: Ints
) -> list[tuple[int, Floats]]:
    """Those of the faces of a block that boards carry, each with the corners of what its own joints leave free of it.

    The faces that look down are given as well. Every joint of the block, those with blocks that are not there too,
    tells which of its faces are beds.
    """
    normal, up = assembly.planes.normal, up_of(assembly)
    slope = dict(zip(faces.tolist(), (-normal[faces] @ up).tolist(), strict=True))
    room = {face: _free(assembly, joints, own, face) for face in low.tolist()}
    room = {face: part for face, part in room.items() if part[0] > 0}
    if not room:
        return []
    first = max(room, key=lambda face: slope[face] * room[face][0])
    across = faces[normal[faces] @ normal[first] < -ACROSS].tolist()
    beyond = {vertex for face in across for vertex in _corners(assembly, face)}

    def carried(face: int) -> bool:
        as_steep = slope[face] >= slope[first] * (1 - AS_STEEP)
        through = bool(beyond.intersection(_corners(assembly, face)))
        return as_steep or not through or not len(_in_face(assembly, joints, every, face))

    return [(face, room[face][1]) for face in room if carried(face)]


def _corners(assembly: Assembly, face: int) -> list[int]:
    """The numbers of the corners of a face."""
    return assembly.face_vertices[assembly.face_start[face] : assembly.face_start[face + 1]].tolist()


def _in_face(assembly: Assembly, joints: Interfaces, own: Ints, face: int) -> Ints:
    """Those of some joints of a block that lie in a face of it."""
    block, normal, centre = assembly.face_block[face], assembly.planes.normal[face], assembly.planes.centre[face]
    offset = np.abs((joints.point[joints.start[own]] - centre) @ normal)
    along = np.abs(joints.frame[own, 0] @ normal)
    return own[(offset < IN_PLANE * assembly.size[block]) & (along > 1 - IN_PLANE)]


def _free(assembly: Assembly, joints: Interfaces, own: Ints, face: int) -> tuple[float, Floats]:
    """What joints of its block leave free of a face: its area [m2], and the corners of its convex hull."""
    import shapely

    block, normal, centre = assembly.face_block[face], assembly.planes.normal[face], assembly.planes.centre[face]
    axes = frames(normal[None])[0, 1:]
    corners = assembly.vertices[_corners(assembly, face)]
    free = shapely.make_valid(shapely.Polygon((corners - centre) @ axes.T))  # warped corners may cross
    least, width = IN_PLANE * free.area, IN_PLANE * float(assembly.size[block])
    covers = _in_face(assembly, joints, own, face)
    patches = []
    for joint in covers.tolist():
        whole = joints.point[joints.start[joint] : joints.start[joint + 1]]
        patches += [(points - centre) @ axes.T for points in joints.parts.get(joint, [whole])]
    free = uncovered(free, patches, [width] * len(patches))
    parts = shapely.MultiPolygon([part for part in shapely.get_parts(shapely.get_parts(free)) if part.area > least])
    if parts.is_empty:
        return 0.0, np.empty((0, 3))
    hull = outline_hull(shapely.get_coordinates(parts))
    if len(covers):  # a strip that is cut off leaves a stub
        hull = hull[spanning(hull[None], np.array([len(hull)]), np.array([REGROWTH * width]))[0]]
    low, high = (bound[block] for bound in assembly.bounds)
    return parts.area, np.clip(centre + hull @ axes, low, high)  # those of a warped face may be beyond its box


@known_options
def decentring(
    assembly: Assembly,
    state: State,
    props: Sequence[Prop],
    *,
    lowering: float = 0.001,
    friction: float | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> Decentring:
    """Lower all props of a state by a small amount.

    Parameters
    ----------
    assembly : Assembly
        All blocks, with dry joints.
    state : (sequence of str, sequence of str)
        Blocks that are present, and those among them that are held, as of `assess_states`.
    props : sequence of Prop
        Under blocks that are present and free.
    lowering : float, optional
        How far each prop gives way along its line [m].
    friction, gap, interfaces
        As of `assess_states`.

    Returns
    -------
    Decentring
        The displacements and the joints that open. Where several motions do the same work it is one of them.

    Raises
    ------
    InputError
        For a prop under a block that is not present or held, a lowering that is not a finite length above 0, or props
        that are not proven to hold the state.

    Examples
    --------
    A block on nothing sinks with its prop; one on the ground needs none.

    >>> from blockstat import Assembly, box, decentring, hoists
    >>> blocks = [box((-2, 0, -1), (-1, 1, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = decentring(assembly, (["block"], []), hoists(assembly, ["block"]), lowering=0.01)
    >>> found.displacement[1, 2].round(6).item()
    -0.01
    """
    check_positive("lowering", lowering)
    options: dict[str, Any] = {"friction": friction, "gap": gap, "interfaces": interfaces}
    problem, found, twist = held_by_props(assembly, state, props, least="total", **options)
    if found.outcome is not FalseworkOutcome.HELD:
        why = {
            FalseworkOutcome.NOT_HELD: "no forces in these props balance the blocks",
            FalseworkOutcome.UNDECIDED: "these props are proven neither to hold the blocks nor not to",
        }
        raise InputError(f"decentring: {why[found.outcome]}, so there is nothing to lower")
    displacement = lowering * problem.to_blocks(twist)
    faces = problem.interfaces
    joint = faces.point_interface
    one, two = (point_velocity(assembly, displacement, faces.pair[joint, side], faces.point) for side in (0, 1))
    gaps = np.einsum("nj,nj->n", faces.frame[joint, 0], two - one)
    most, least = np.zeros(faces.n_interfaces), np.full(faces.n_interfaces, np.inf)
    np.maximum.at(most, joint, gaps)
    np.minimum.at(least, joint, gaps)
    hinges = np.flatnonzero((most > CLOSED * lowering) & (least <= CLOSED * lowering))
    return Decentring(assembly, faces, found, lowering, displacement, most, hinges)
