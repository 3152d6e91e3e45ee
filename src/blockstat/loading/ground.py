"""Fluid, earth and fill: pressure on faces that grows with depth, and loads that spread on their way down.

Soil acts as a load alone: it presses, and resists nothing. Its resistance to arches that move into it is left out,
which is on the safe side where it would help.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.tolerance import allowed_gap
from blockstat.errors import InputError, InputWarning, check_number, check_positive, is_number, known_options, rough
from blockstat.loading.faces import ON, Face, integrated, selected
from blockstat.loading.on_faces import facing
from blockstat.loading.placed import PlacedForces
from blockstat.loads import numbers, three, up_of
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

Blocks = Iterable[int | str] | int | str | None


@known_options
def fluid_pressure(
    assembly: Assembly,
    level: float,
    unit_weight: float,
    towards: Sequence[float],
    *,
    coefficient: float = 1.0,
    surcharge: float = 0.0,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> Floats:
    """Make the pressure of a fluid or of earth on free faces: K (unit weight x depth + surcharge), normal to them.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    level : float
        Height of the surface, measured against gravity [m]; nothing acts above it.
    unit_weight : float
        Of the fluid or the earth [N/m3].
    towards : sequence of float, shape (3,)
        Where the loaded faces look: into the fluid. All are loaded but those along it, which lean this way by a cosine
        of less than 0.01, as rounding makes them.
    coefficient : float, optional
        K: 1 for a fluid; of active earth pressure or of that at rest for earth [-].
    surcharge : float, optional
        Vertical pressure on the surface of the earth [N/m2].
    blocks : names or numbers of blocks, optional
        Those that are loaded.
    group : str, optional
        The group that is loaded; by default all free blocks are.
    interfaces : Interfaces, optional
        Where blocks touch; searched for when None.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        Where no free face looks that way below the level, or for a bad number: a coefficient or a surcharge below 0
        would pull.

    Examples
    --------
    Water 2 m deep pushes with 1/2 gamma h^2 a metre, at a third of its depth.

    >>> from blockstat import Assembly, box, fluid_pressure
    >>> wall = Assembly.from_blocks([box((0, 0, 0), (1, 1, 3))])
    >>> load = fluid_pressure(wall, 2.0, 9810.0, towards=(-1, 0, 0))
    >>> load.round(6).tolist()
    [[19620.0, 0.0, 0.0, 0.0, -16350.0, 0.0]]
    """
    forces = fluid_forces(
        assembly,
        level,
        unit_weight,
        towards,
        coefficient=coefficient,
        surcharge=surcharge,
        blocks=blocks,
        group=group,
        interfaces=interfaces,
    )
    return forces.wrenches(assembly)


def fluid_forces(
    assembly: Assembly,
    level: float,
    unit_weight: float,
    towards: Sequence[float],
    *,
    coefficient: float = 1.0,
    surcharge: float = 0.0,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> PlacedForces:
    """Make the forces of `fluid_pressure` at their points.

    Parameters
    ----------
    assembly, level, unit_weight, towards, coefficient, surcharge, blocks, group, interfaces
        As in `fluid_pressure`.

    Returns
    -------
    PlacedForces
        On the faces.

    Raises
    ------
    InputError
        As `fluid_pressure` does.
    """
    check_positive("unit_weight", unit_weight)
    check_number("level", level)
    for name, value in (("coefficient", coefficient), ("surcharge", surcharge)):
        check_number(name, value, least=0)
    faces = facing(assembly, selected(assembly, blocks, group), three(towards, "towards"), interfaces)
    up = up_of(assembly)
    wet = [part for face in faces if (part := _below(face, up, level)).region.area > 0]
    if not wet:
        raise InputError(f"no free face of these blocks looks towards {list(towards)} below the level {level:g}")

    def traction(points: Floats, normal: Floats) -> Floats:
        depth = level - points @ up
        return -coefficient * (unit_weight * depth + surcharge)[:, None] * normal

    return integrated(assembly, wet, traction)


@known_options
def fill_load(
    assembly: Assembly,
    level: float,
    unit_weight: float,
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> Floats:
    """Make the dead load of fill up to a level: on each free face that looks up, the weight of the column above it.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    level : float
        Height of the surface of the fill, measured against gravity [m].
    unit_weight : float
        Of the fill [N/m3].
    blocks : names or numbers of blocks, optional
        Those that carry it.
    group : str, optional
        The group that carries it, such as an arch ring; by default all free blocks.
    interfaces : Interfaces, optional
        Where blocks touch; searched for when None.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        Where no free face looks up below the level, or two lie above each other; for a bad number.

    Notes
    -----
    The load is vertical. The fill has no strength and resists nothing. Upright faces, which look up by a cosine of less
    than 0.01, as rounding makes them, carry none.

    Examples
    --------
    >>> from blockstat import Assembly, box, fill_load
    >>> slab = Assembly.from_blocks([box((0, 0, 0), (2, 1, 1))])
    >>> fill_load(slab, 1.5, 18000.0).round(6).tolist()
    [[0.0, 0.0, -18000.0, 0.0, 0.0, 0.0]]
    """
    return fill_forces(assembly, level, unit_weight, blocks=blocks, group=group, interfaces=interfaces).wrenches(
        assembly
    )


def fill_forces(
    assembly: Assembly,
    level: float,
    unit_weight: float,
    *,
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> PlacedForces:
    """Make the forces of `fill_load` at their points.

    Parameters
    ----------
    assembly, level, unit_weight, blocks, group, interfaces
        As in `fill_load`.

    Returns
    -------
    PlacedForces
        On the faces.

    Raises
    ------
    InputError
        As `fill_load` does.
    """
    check_number("level", level)
    check_positive("unit_weight", unit_weight)
    up = up_of(assembly)
    faces = facing(assembly, selected(assembly, blocks, group), up, interfaces)
    covered = [part for face in faces if (part := _below(face, up, level)).region.area > 0]
    if not covered:
        raise InputError(f"no free face of these blocks lies below the level {level:g}")
    _check_single(assembly, covered)

    def traction(points: Floats, normal: Floats) -> Floats:
        return -(unit_weight * (level - points @ up) * (normal @ up))[:, None] * up

    return integrated(assembly, covered, traction)


@known_options
def dispersed_load(
    assembly: Assembly,
    point: Sequence[float],
    force: float,
    *,
    spread: float,
    footprint: Sequence[float] = (0.0, 0.0),
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> Floats:
    """Make the load of a vertical force on fill that spreads on its way down to the faces below.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    point : sequence of float, shape (3,)
        Centre of the load on the surface of the fill [m].
    force : float
        Downwards [N].
    spread : float
        How far the load spreads to each side for each metre of depth [-]: 0.5 for one to two. It is the tangent of an
        angle.
    footprint : sequence of float, shape (2,), optional
        Sides of the loaded rectangle on the surface, along x and y [m].
    blocks : names or numbers of blocks, optional
        Those that may carry it.
    group : str, optional
        The group that may carry it, such as an arch ring; by default all free blocks.
    interfaces : Interfaces, optional
        Where blocks touch; searched for when None.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        Where no free face lies below the point, or two lie above each other; for a bad number.

    Warns
    -----
    InputWarning
        With a spread that may be an angle.

    Notes
    -----
    The rectangle has grown by twice spread x depth at the depth of the next face below the point. There the pressure is
    even over the plan. Where a part of the rectangle reaches beyond the faces, the rest carries all of the force. What
    stands above the point carries none. The fill resists nothing.

    Examples
    --------
    >>> from blockstat import Assembly, box, dispersed_load
    >>> slab = Assembly.from_blocks([box((0, 0, 0), (4, 4, 1)), box((4, 0, 0), (8, 4, 1))])
    >>> load = dispersed_load(slab, (3.5, 2, 2), 1000.0, spread=1.0)
    >>> load[:, 2].round(6).tolist()
    [-750.0, -250.0]
    """
    warn_of_spread("spread", spread)
    forces = dispersed_forces(
        assembly, point, force, spread=spread, footprint=footprint, blocks=blocks, group=group, interfaces=interfaces
    )
    return forces.wrenches(assembly)


def dispersed_forces(
    assembly: Assembly,
    point: Sequence[float],
    force: float,
    *,
    spread: float,
    footprint: Sequence[float] = (0.0, 0.0),
    blocks: Blocks = None,
    group: str | None = None,
    interfaces: Interfaces | None = None,
) -> PlacedForces:
    """Make the forces of `dispersed_load` at their points.

    Parameters
    ----------
    assembly, point, force, spread, footprint, blocks, group, interfaces
        As in `dispersed_load`.

    Returns
    -------
    PlacedForces
        On the faces.

    Raises
    ------
    InputError
        As `dispersed_load` does.
    """
    check_positive("force", force)
    check_number("spread", spread, least=0)
    faces = facing(assembly, selected(assembly, blocks, group), up_of(assembly), interfaces)
    return dispersed(assembly, faces, three(point, "point"), force, spread, footprint)


def warn_of_spread(what: str, spread: Any) -> None:
    """Warn of a spread that may be an angle.

    Parameters
    ----------
    what
        What it is; the sentence begins with it.
    spread
        What was given.

    Warns
    -----
    InputWarning
        With the tangent of the angle.
    """
    if is_number(spread) and (doubt := rough(what, float(spread))) is not None:
        warnings.warn(InputWarning(doubt), stacklevel=4)


def dispersed(
    assembly: Assembly, faces: Sequence[Face], place: Floats, force: float, spread: float, footprint: Sequence[float]
) -> PlacedForces:
    """Make the forces of a force on fill over faces that are known.

    Parameters
    ----------
    assembly, force, spread, footprint
        As in `dispersed_load`.
    faces
        Free faces that look up.
    place
        Centre of the load on the surface, shape (3,) [m].

    Returns
    -------
    PlacedForces
        On the faces.

    Raises
    ------
    InputError
        As in `dispersed_load`.
    """
    from shapely import box

    up = up_of(assembly)
    depth = depths(assembly, faces, place)
    if not depth:
        raise InputError(f"no free face of these blocks lies below the point {place.tolist()}")
    loaded = numbers(footprint)
    if loaded.shape != (2,) or not np.isfinite(loaded).all():
        raise InputError(f"footprint is {footprint!r}; the two sides of the loaded area are needed, finite [m]")
    sides = loaded + 2 * spread * min(depth)
    if not (sides > 0).all():
        raise InputError(f"the load at {place.tolist()} has an area of {sides.tolist()} m below; both must be above 0")
    plan = _plan(up)
    flat = plan @ place
    rectangle = box(*(flat - sides / 2), *(flat + sides / 2))
    # What stands above the load carries none of it.
    level = float(place @ up) + ON * assembly.size
    lower = [part for face in faces if (part := _below(face, up, float(level[face.block]))).region.area > 0]
    parts = [part for face in lower if (part := _under(face, plan, up, rectangle)).region.area > 0]
    _check_single(assembly, parts)
    carried = sum(part.region.area * float(part.normal @ up) for part in parts)
    return integrated(assembly, parts, lambda _, normal: -(force / carried * (normal @ up))[:, None] * up)


def depths(assembly: Assembly, faces: Sequence[Face], place: Floats) -> list[float]:
    """Return how far below a point faces lie that are not above it.

    Parameters
    ----------
    assembly
        The blocks.
    faces
        Free faces that look up.
    place
        The point, shape (3,) [m].

    Returns
    -------
    list of float
        Depths of at least 0 [m]; a face at the height of the point, to rounding, is not above it. Empty where all are.
    """
    up = up_of(assembly)
    found = [(face, float(place @ up) - height) for face, height in below(faces, place, up)]
    return [max(depth, 0.0) for face, depth in found if depth >= -ON * float(assembly.size[face.block])]


def below(faces: Sequence[Face], place: Floats, up: Floats) -> list[tuple[Face, float]]:
    """Find the faces below or above a point in plan, each with its height there.

    Parameters
    ----------
    faces
        Free faces that look up.
    place
        The point, shape (3,) [m].
    up
        Unit vector against gravity, shape (3,).

    Returns
    -------
    list of Face and float
        Heights [m]; two faces where the point lies on a joint.
    """
    from shapely import Point

    found = []
    for face in faces:
        there = place - up * float(face.height(place)) / float(face.normal @ up)
        if face.region.distance(Point(face.flat(there))) <= ON * face.region.length:
            found.append((face, float(there @ up)))
    return found


def _plan(up: Floats) -> Floats:
    """Rows of two horizontal directions, x and y where up is z, shape (2, 3)."""
    first = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
    first = first - (first @ up) * up
    first: Floats = first / np.linalg.norm(first)
    return np.stack([first, np.cross(up, first)])


def _under(face: Face, plan: Floats, up: Floats, region: Any) -> Face:
    """The part of a face that lies under a region of the plan."""
    from shapely import Polygon

    corners = np.asarray(region.exterior.coords) @ plan
    drop = (corners - face.origin) @ face.normal / float(face.normal @ up)
    return face.within(Polygon(face.flat(corners - drop[:, None] * up)))


def _below(face: Face, up: Floats, level: float) -> Face:
    """The part of a face below a level."""
    from shapely import Polygon, box

    slope = face.frame[1:] @ up
    room = level - float(face.origin @ up)
    steep = float(np.linalg.norm(slope))
    if steep < ON:
        return face if room > 0 else Face(face.block, face.frame, face.origin, Polygon())
    # In the face, along its line of slope: below is what lies on one side of a line.
    along, across = slope / steep, np.array([-slope[1], slope[0]]) / steep
    far = 2.0 * max(abs(value) for value in face.region.bounds)
    corners = np.array(box(-far, -far, min(max(room / steep, -far), far), far).exterior.coords)
    return face.within(Polygon(corners @ np.stack([along, across])))


def _check_single(assembly: Assembly, faces: Sequence[Face]) -> None:
    """Raise InputError where two faces lie above each other in plan."""
    from shapely import STRtree, transform

    up = up_of(assembly)
    plan, allowed = _plan(up), allowed_gap(assembly, GAP)
    shapes = []
    for face in faces:
        whole = transform(face.region, lambda flat, face=face: (face.origin + flat @ face.frame[1:]) @ plan.T)
        # Drawn in: what meets along a line, but for the gap of a joint, does not lie above each other.
        shapes.append(whole.buffer(-allowed[face.block] / 2))
    for i, j in zip(*STRtree(shapes).query(shapes, predicate="intersects"), strict=True):
        if i < j:
            names = " and ".join(f'"{assembly.names[faces[k].block]}"' for k in (i, j))
            raise InputError(f"free faces of {names} lie above each other; name the group that carries the load")
