"""Loads on free faces: along a line, on a patch, on all of a surface; and forces shared by blocks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError, known_options
from blockstat.loading.faces import ON, TOWARDS, Face, free_faces, integrated, selected
from blockstat.loading.placed import PlacedForces, at_points
from blockstat.loads import as_points, point_load, three
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A line this far outside a face, relative to the size of its block, runs along its edge: rounding.
EDGE = 1e-10

Blocks = Iterable[int | str] | int | str | None


@known_options
def body_load(assembly: Assembly, force: Sequence[float], *, blocks: Blocks = None, group: str | None = None) -> Floats:
    """Make the load of a force that blocks share by their masses, at their centroids.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    force : sequence of float, shape (3,)
        In total [N].
    blocks : names or numbers of blocks, optional
        Those that share it.
    group : str, optional
        The group that shares it; by default all free blocks do.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For an unknown block or group, or a force that is not three numbers.

    Examples
    --------
    >>> from blockstat import Assembly, body_load, box
    >>> pair = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 4))])
    >>> body_load(pair, (8, 0, 0))[:, 0].round(6).tolist()
    [2.0, 6.0]
    """
    chosen = selected(assembly, blocks, group)
    load = np.zeros((assembly.n_blocks, 6))
    share = assembly.mass[chosen] / assembly.mass[chosen].sum()
    load[chosen, :3] = share[:, None] * three(force, "force")
    return load


@known_options
def surface_load(
    assembly: Assembly,
    pressure: Sequence[float],
    towards: Sequence[float],
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> Floats:
    """Make an even load on all free faces that look in a direction.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    pressure : sequence of float, shape (3,)
        Force per area of the faces [N/m2], in any direction.
    towards : sequence of float, shape (3,)
        Where the loaded faces look: those within 45 degrees of it.
    blocks : names or numbers of blocks, optional
        Those that are loaded.
    group : str, optional
        The group that is loaded; by default all free blocks are.
    interfaces : Interfaces, optional
        Where blocks touch, which takes a part of a face out; searched for when None.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For an unknown block or group, or where no free face looks that way.

    Examples
    --------
    A wind of 800 N/m2 on the side of a wall.

    >>> from blockstat import Assembly, box, surface_load
    >>> wall = Assembly.from_blocks([box((0, 0, 0), (0.5, 4, 2), name="wall")])
    >>> surface_load(wall, (800, 0, 0), towards=(-1, 0, 0)).round(6).tolist()
    [[6400.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    """
    return surface_forces(assembly, pressure, towards, blocks=blocks, group=group, interfaces=interfaces).wrenches(
        assembly
    )


def surface_forces(
    assembly: Assembly,
    pressure: Sequence[float],
    towards: Sequence[float],
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> PlacedForces:
    """Make the forces of `surface_load` at their points.

    Parameters
    ----------
    assembly, pressure, towards, blocks, group, interfaces
        As in `surface_load`.

    Returns
    -------
    PlacedForces
        On the faces.

    Raises
    ------
    InputError
        As `surface_load` does.
    """
    force, look = three(pressure, "pressure"), three(towards, "towards")
    faces = facing(assembly, selected(assembly, blocks, group), look, interfaces, steepest=45.0)
    return integrated(assembly, faces, lambda points, _: np.broadcast_to(force, points.shape))


def facing(
    assembly: Assembly, chosen: Any, towards: Floats, interfaces: Interfaces | None, *, steepest: float = 90.0
) -> list[Face]:
    """Find the free faces of blocks that look in a direction.

    Parameters
    ----------
    assembly
        The blocks.
    chosen
        Numbers of those whose faces are wanted.
    towards
        The direction, shape (3,).
    interfaces
        Where blocks touch; searched for when None.
    steepest
        How far from it a face may look [degrees]; those along it, by a cosine of less than `TOWARDS`, are left out.

    Returns
    -------
    list of Face
        At least one.

    Raises
    ------
    InputError
        For a direction of nothing, and where no free face looks that way.
    """
    if not towards.any():
        raise InputError("towards is zero; it must be a direction")
    least = max(float(np.cos(np.deg2rad(steepest))) - ON, TOWARDS)
    unit = towards / np.linalg.norm(towards)
    faces = free_faces(assembly, chosen, towards=towards, interfaces=interfaces)
    faces = [face for face in faces if face.normal @ unit >= least]
    if not faces:
        raise InputError(f"no free face of these blocks looks towards {towards.tolist()}")
    return faces


@known_options
def patch_load(
    assembly: Assembly,
    corners: Any,
    pressure: Sequence[float],
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> Floats:
    """Make an even load on a plane polygon that lies on free faces, of one block or of several.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    corners : array_like, shape (n, 3)
        Of the polygon, in order [m].
    pressure : sequence of float, shape (3,)
        Force per area [N/m2].
    blocks : names or numbers of blocks, optional
        Those that may be loaded.
    group : str, optional
        The group that may be loaded; by default all free blocks.
    interfaces : Interfaces, optional
        Where blocks touch; searched for when None.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        Where the polygon does not lie on free faces, encloses no area, or has edges that cross.

    Examples
    --------
    >>> from blockstat import Assembly, box, patch_load
    >>> block = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    >>> corners = [(0, 0, 1), (0.5, 0, 1), (0.5, 1, 1), (0, 1, 1)]
    >>> patch_load(block, corners, (0, 0, -100)).round(6).tolist()
    [[0.0, 0.0, -50.0, 0.0, -12.5, 0.0]]
    """
    return patch_forces(assembly, corners, pressure, blocks=blocks, group=group, interfaces=interfaces).wrenches(
        assembly
    )


def patch_forces(
    assembly: Assembly,
    corners: Any,
    pressure: Sequence[float],
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> PlacedForces:
    """Make the forces of `patch_load` at their points.

    Parameters
    ----------
    assembly, corners, pressure, blocks, group, interfaces
        As in `patch_load`.

    Returns
    -------
    PlacedForces
        On the faces.

    Raises
    ------
    InputError
        As `patch_load` does.
    """
    from shapely import Polygon

    outline, force = as_points(corners, "corners of a patch", 3), three(pressure, "pressure")
    middle = outline.mean(axis=0)
    _, extent, axes = np.linalg.svd(outline - middle, full_matrices=False)
    if extent[1] <= ON * extent[0]:
        raise InputError("patch: its corners lie on a line; they must enclose an area")
    if not Polygon((outline - middle) @ axes[:2].T).exterior.is_simple:
        raise InputError("patch: its edges cross; list its corners in order round it")
    vector = 0.5 * np.cross(outline - middle, np.roll(outline, -1, axis=0) - middle).sum(axis=0)
    whole = float(np.linalg.norm(vector))
    parts = []
    for face in _near(assembly, outline, selected(assembly, blocks, group), interfaces):
        part = face.within(Polygon(face.flat(outline)))
        parts += [part] if part.region.area > 0 else []
    _check_covered(assembly, parts, sum(part.region.area for part in parts), whole, "patch", "m2")
    return integrated(assembly, parts, lambda points, _: np.broadcast_to(force, points.shape))


@known_options
def line_load(
    assembly: Assembly,
    start: Sequence[float],
    end: Sequence[float],
    force: Sequence[float],
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> Floats:
    """Make an even load along a line on free faces, of one block or of several.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    start, end : sequence of float, shape (3,)
        Ends of the line [m].
    force : sequence of float, shape (3,)
        Per length [N/m].
    blocks : names or numbers of blocks, optional
        Those that may be loaded.
    group : str, optional
        The group that may be loaded; by default all free blocks.
    interfaces : Interfaces, optional
        Where blocks touch; searched for when None.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        Where the line does not lie on free faces.

    Notes
    -----
    A part of the line along an edge belongs to the first block whose face it lies on.

    Examples
    --------
    >>> from blockstat import Assembly, box, line_load
    >>> block = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    >>> line_load(block, (0.25, 0, 1), (0.25, 1, 1), (0, 0, -8)).round(6).tolist()
    [[0.0, 0.0, -8.0, 0.0, -2.0, 0.0]]
    """
    return line_forces(assembly, start, end, force, blocks=blocks, group=group, interfaces=interfaces).wrenches(
        assembly
    )


def line_forces(
    assembly: Assembly,
    start: Sequence[float],
    end: Sequence[float],
    force: Sequence[float],
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> PlacedForces:
    """Make the forces of `line_load` at their points.

    Parameters
    ----------
    assembly, start, end, force, blocks, group, interfaces
        As in `line_load`.

    Returns
    -------
    PlacedForces
        On the faces.

    Raises
    ------
    InputError
        As `line_load` does.
    """
    from shapely import LineString

    ends = np.stack([three(start, "start"), three(end, "end")])
    push, length = three(force, "force"), float(np.linalg.norm(ends[1] - ends[0]))
    if not length:
        raise InputError(f"line from {ends[0].tolist()} to {ends[1].tolist()} has no length")
    left, taken = LineString([(0.0, 0.0), (length, 0.0)]), list[Any]()
    middles, forces = [np.empty((0, 3))], [np.empty((0, 3))]
    for face in _near(assembly, ends, selected(assembly, blocks, group), interfaces):
        flat = face.flat(ends)
        inside = LineString(flat).intersection(face.region.buffer(EDGE * float(assembly.size[face.block])))
        for piece in getattr(inside, "geoms", [inside]):
            if piece.geom_type != "LineString" or piece.is_empty:
                continue
            at = np.sort(np.linalg.norm(np.asarray(piece.coords)[[0, -1]] - flat[0], axis=1))
            own = left.intersection(LineString([(at[0], 0.0), (at[1], 0.0)]))
            left = left.difference(own)
            for part in getattr(own, "geoms", [own]):
                if part.length > 0:
                    middles.append(ends[[0]] + part.centroid.x / length * (ends[[1]] - ends[[0]]))
                    forces.append(part.length * push[None])
                    taken.append(face)
    _check_covered(assembly, taken, length - left.length, length, "line", "m")
    blocks_loaded = np.array([face.block for face in taken], dtype=np.int64)
    return at_points(assembly, blocks_loaded, np.concatenate(middles), np.concatenate(forces))


def _near(assembly: Assembly, points: Floats, chosen: Any, interfaces: Interfaces | None) -> list[Face]:
    """Free faces of blocks in whose plane all points lie."""
    low, high = assembly.bounds
    room = ON * assembly.size[:, None]
    beside = ((low - room <= points.max(axis=0)) & (high + room >= points.min(axis=0))).all(axis=1)
    faces = free_faces(assembly, np.intersect1d(chosen, np.flatnonzero(beside)), interfaces=interfaces)
    return [face for face in faces if np.abs(face.height(points)).max() <= ON * assembly.size[face.block]]


def _check_covered(assembly: Assembly, parts: Sequence[Face], found: float, whole: float, what: str, unit: str) -> None:
    """Raise InputError where a region lies on free faces only in part, or on some of them twice."""
    if abs(found - whole) > 10 * ON * whole:
        names = sorted({assembly.names[part.block] for part in parts})
        where = f" (of {', '.join(names[:5])})" if names else ""
        raise InputError(f"{found:.6g} of {whole:.6g} {unit} of the {what} lie on free faces{where}; all of it must")


def point_forces(assembly: Assembly, block: int | str, point: Sequence[float], force: Sequence[float]) -> PlacedForces:
    """Make the force of `blockstat.point_load` at its point.

    Parameters
    ----------
    assembly, block, point, force
        As in `blockstat.point_load`.

    Returns
    -------
    PlacedForces
        One force.

    Raises
    ------
    InputError
        As `blockstat.point_load` does.
    """
    wrench = point_load(assembly, block, point, force)
    loaded = assembly.blocks_named(block, "load")
    return at_points(assembly, loaded, three(point, "point")[None], wrench[loaded, :3])
