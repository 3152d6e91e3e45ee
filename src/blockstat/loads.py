"""Loads: a wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].

A load multiplier is a factor on one of these, on top of the weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import HUGE, InputError, known_options
from blockstat.geometry.convex_pieces import contains
from blockstat.geometry.triangulation import fans, triangulate
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A point this far outside its block, relative to the block's size, is on it: rounding of coordinates.
ON_BLOCK = 1e-6


def up_of(assembly: Assembly) -> Floats:
    """Return the unit vector against gravity.

    Parameters
    ----------
    assembly : Assembly
        Has the gravity.

    Returns
    -------
    array of float, shape (3,)
    """
    return -assembly.gravity / np.linalg.norm(assembly.gravity)


def horizontal(assembly: Assembly) -> Floats:
    """Return two unit vectors at right angles to gravity: x and y where gravity is vertical.

    Parameters
    ----------
    assembly : Assembly
        The blocks, with their gravity.

    Returns
    -------
    array of float, shape (2, 3)
        The horizontal part of x (of z, where gravity is along x), and what stands to its left seen from above.
    """
    up = up_of(assembly)
    first = np.array([1.0, 0.0, 0.0]) - up[0] * up
    if np.linalg.norm(first) < 1e-6:  # gravity along x: any direction will do
        first = np.array([0.0, 0.0, 1.0]) - up[2] * up
    first: Floats = first / np.linalg.norm(first)
    return np.array([first, np.cross(up, first)])


@dataclass(frozen=True, eq=False)
class WeightedLoads:
    """Loads that stay, with the factor on the weight that goes with them: so it follows densities that change.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], density=1000.0)
    >>> light = WeightedLoads(np.zeros((1, 6)), 0.9)
    >>> [light.more_weight(block)[0, 2].round(6).item() for block in (cube, cube.with_(density=800.0))]
    [981.0, 784.8]
    """

    beside: Floats  #: all that acts beside the weight, shape (n_blocks, 6) [N, N m]
    weight: float = 1.0  #: factor on the weight

    def more_weight(self, assembly: Assembly) -> Floats:
        """Return what the factor adds to the weight of the blocks.

        Parameters
        ----------
        assembly : Assembly
            The blocks, with the densities and the gravity that count.

        Returns
        -------
        array, shape (n_blocks, 6)
            Force [N] and moment about the centroid [N m], which is zero, on each block; against gravity for a factor
            below 1.
        """
        force = (self.weight - 1.0) * assembly.mass[:, None] * assembly.gravity
        return np.hstack([force, np.zeros_like(force)])

    def pressing(self, assembly: Assembly) -> Floats:
        """Return by how much the loads press down on the blocks beside what their masses weigh.

        A factor above 1 presses with them. One below 1 takes from the weight, and not from the loads.

        Parameters
        ----------
        assembly : Assembly
            As in `more_weight`.

        Returns
        -------
        array, shape (n_blocks,)
            Forces along gravity [N]; negative where loads lift a block.

        Examples
        --------
        >>> from blockstat import Assembly, box
        >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], density=1000.0)
        >>> roof = np.array([[0.0, 0, -500, 0, 0, 0]])
        >>> [WeightedLoads(roof, weight).pressing(cube).round(6).item() for weight in (0.9, 1.0, 1.1)]
        [500.0, 500.0, 1481.0]
        """
        acting = self.beside + self.more_weight(assembly) if self.weight > 1 else self.beside
        return acting[:, :3] @ -up_of(assembly)


#: Loads that stay, as analyses take them: a wrench on each block, shape (n_blocks, 6) [N, N m], or with the factor.
Loads = Floats | WeightedLoads


def weighted(loads: Loads) -> WeightedLoads:
    """Return loads that stay with the factor on the weight.

    Parameters
    ----------
    loads : array_like, shape (n_blocks, 6), or WeightedLoads
        A wrench on each block [N, N m], or these with a factor.

    Returns
    -------
    WeightedLoads
        As given, or a copy of the wrenches with the factor 1.
    """
    return loads if isinstance(loads, WeightedLoads) else WeightedLoads(np.array(loads, dtype=float))


@known_options
def acceleration(
    assembly: Assembly,
    direction: Sequence[float],
    *,
    group: str | None = None,
    profile: Sequence[Sequence[float]] | None = None,
) -> Floats:
    """Make a mass-proportional load in a direction, as strong as gravity: a multiplier is in units of the scene's g.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    direction : sequence of float, shape (3,)
        Direction of the acceleration, of any length.
    group : str, optional
        Load only the blocks of this group.
    profile : sequence of (height, factor), optional
        Factors on the acceleration at heights against gravity [m], in ascending order: linear between them, and those
        of the ends beyond.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For a direction that is none, an unknown group, or heights that do not ascend.

    Examples
    --------
    >>> from blockstat import Assembly, acceleration, box
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], density=1000.0)
    >>> acceleration(cube, (2, 0, 0)).round(3).tolist()
    [[9810.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    """
    unit = _direction(direction)
    load = np.zeros((assembly.n_blocks, 6))
    blocks = np.arange(assembly.n_blocks) if group is None else assembly.in_group(group)
    load[blocks, :3] = assembly.mass[blocks, None] * np.linalg.norm(assembly.gravity) * unit
    return load if profile is None else _by_height(assembly, load, profile)


def _by_height(assembly: Assembly, load: Floats, profile: Sequence[Sequence[float]]) -> Floats:
    """Body forces times factors that change with the height, with the moments that this makes."""
    try:
        height, factor = np.asarray(profile, dtype=float).T
    except (TypeError, ValueError):
        raise InputError(f"profile is {profile!r}; it must be pairs of a height and a factor") from None
    if not (np.isfinite([height, factor]).all() and (np.diff(height) > 0).all()):
        raise InputError(f"profile has heights {height.tolist()}; they must ascend")
    whole, first = _integrals_of(assembly, height, factor)
    by_volume = load[:, :3] / assembly.volume[:, None]
    return np.hstack([whole[:, None] * by_volume, np.cross(first, by_volume)])


def _integrals_of(assembly: Assembly, height: Floats, factor: Floats) -> tuple[Floats, Floats]:
    """The integrals over each block of a function f of the height, and of f r, r from the centroid.

    By the divergence theorem they are those of F n_z over the surface, where F' = f, and of F n_z r; that of f z is the
    integral of G n_z, where G' = z f. F and G are cubic at most between two heights, at which triangles are split.
    """
    up = up_of(assembly)
    block = np.repeat(assembly.face_block, np.diff(assembly.face_start))
    triangle = fans(assembly.vertices[assembly.face_vertices] - assembly.centroid[block], assembly.face_start)
    knot = height - (assembly.centroid @ up)[:, None]  # above the centroid, shape (n_blocks, k)
    for k in range(len(height)):
        triangle, block = _split(triangle, triangle @ up - knot[block, k, None], block)
    point, area = _quadrature(triangle, up)
    z = point @ up
    primitive, moment = np.zeros_like(z), np.zeros_like(z)
    ends = np.pad(knot[block], ((0, 0), (1, 1)), constant_values=(-np.inf, np.inf))
    slope = np.pad(np.diff(factor) / np.diff(height), 1)
    for k, rate in enumerate(slope):
        low, high, nearest = ends[:, k, None], ends[:, k + 1, None], max(k - 1, 0)
        at_centroid = factor[nearest] - rate * knot[block, nearest, None]
        for there, sign in ((np.clip(z, low, high), 1.0), (np.clip(0.0, low, high), -1.0)):
            primitive += sign * (at_centroid * there + rate * there**2 / 2)
            moment += sign * (at_centroid * there**2 / 2 + rate * there**3 / 3)
    level = point - z[..., None] * up
    first = np.einsum("tq,tqi->ti", area * primitive, level) + (area * moment).sum(axis=1)[:, None] * up
    sums = np.column_stack([(area * primitive).sum(axis=1), first])
    whole = np.zeros((assembly.n_blocks, 4))
    np.add.at(whole, block, sums)
    return whole[:, 0], whole[:, 1:]


def _quadrature(triangle: Floats, up: Floats) -> tuple[Floats, Floats]:
    """Points in triangles and their parts of the area seen from above, exact for polynomials of degree 4.

    Shapes (n, 9, 3) and (n, 9): Gauss points of a square whose one side shrinks to a corner.
    """
    node, weight = np.polynomial.legendre.leggauss(3)
    u, v = (part.ravel() for part in np.meshgrid((node + 1) / 2, (node + 1) / 2, indexing="ij"))
    share = np.column_stack([1 - u, u * (1 - v), u * v])
    twice = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]) @ up
    return share @ triangle, np.outer(twice, np.outer(weight, weight).ravel() / 4 * u)


def _split(triangle: Floats, above: Floats, block: Ints) -> tuple[Floats, Ints]:
    """Split triangles where a height changes its sign, `above` at their corners: each from a corner, twice at most."""
    while len(rows := np.flatnonzero((above * np.roll(above, -1, axis=1)).min(axis=1) < 0)):
        one, other = triangle[rows], triangle[rows]
        low, high = above[rows], above[rows]
        here = np.arange(len(rows))
        i = np.argmin(low * np.roll(low, -1, axis=1), axis=1)
        j = (i + 1) % 3
        part = low[here, i] / (low[here, i] - low[here, j])
        cut = one[here, i] + part[:, None] * (one[here, j] - one[here, i])
        one[here, j], other[here, i] = cut, cut
        low[here, j], high[here, i] = 0.0, 0.0
        triangle[rows], above[rows] = one, low
        triangle, above = np.concatenate([triangle, other]), np.concatenate([above, high])
        block = np.concatenate([block, block[rows]])
    return triangle, block


@known_options
def point_load(assembly: Assembly, block: int | str, point: Sequence[float], force: Sequence[float]) -> Floats:
    """Make the load of a force at a point of a block.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    block : str or int
        Name or number of the block.
    point : sequence of float, shape (3,)
        Where the force acts, in the block or on its surface [m].
    force : sequence of float, shape (3,)
        The force [N].

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For an unknown block, for a point that is not on its block, and for what is not three finite numbers.

    Examples
    --------
    >>> from blockstat import Assembly, box, point_load
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), name="cube")])
    >>> point_load(cube, "cube", (0.5, 0.5, 1.0), (10, 0, 0)).round(6).tolist()
    [[10.0, 0.0, 0.0, 0.0, 5.0, 0.0]]
    """
    named = assembly.blocks_named(block, "load")
    if len(named) != 1:
        raise InputError(f"load: {block!r} are {len(named)} blocks; give one")
    index = named[0]
    place, push = three(point, "point"), three(force, "force")
    if not on_block(assembly, int(index), place):
        low, high = (corner[index].round(4).tolist() for corner in assembly.bounds)
        raise InputError(
            f'point {place.tolist()} is not on block "{assembly.names[index]}", which lies between {low} and {high}'
        )
    load = np.zeros((assembly.n_blocks, 6))
    load[index, :3] = push
    load[index, 3:] = np.cross(place - assembly.centroid[index], push)
    return load


def on_block(assembly: Assembly, block: int, point: Floats) -> bool:
    """Return whether a point lies in a block or on its surface.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    block : int
        Number of the block.
    point : array, shape (3,)
        The point [m].

    Returns
    -------
    bool
        True where it does, to a millionth of the block's size.
    """
    faces = np.flatnonzero(assembly.face_block == block)
    normal, room = assembly.planes.normal[faces], ON_BLOCK * float(assembly.size[block])
    height = np.einsum("ij,ij->i", point - assembly.planes.centre[faces], normal)
    if (height <= room).all():
        return True
    corners = assembly.block_vertices(block)
    solid = corners[triangulate(corners, assembly.faces_of(block))]
    # On the surface of a concave block: a little below the face that it lies in.
    near = [point, *(point - 2 * room * normal[np.abs(height) <= room])]
    return any(contains(solid, place) for place in near)


def three(values: Any, what: str) -> Floats:
    """Return three finite numbers.

    Parameters
    ----------
    values : array_like, shape (3,)
        The numbers.
    what : str
        What they are, which begins the message of an error.

    Returns
    -------
    array, shape (3,)
        The numbers.

    Raises
    ------
    InputError
        For anything else.
    """
    vector = numbers(values)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InputError(f"{what} is {values!r}; it must be three finite numbers")
    return vector


def as_points(values: Any, what: str, least: int) -> Floats:
    """Return points in space.

    Parameters
    ----------
    values : array_like, shape (n, 3)
        Their coordinates.
    what : str
        What they are, which begins the message of an error.
    least : int
        How many there must be.

    Returns
    -------
    array, shape (n, 3)
        The coordinates.

    Raises
    ------
    InputError
        For anything else.
    """
    found = numbers(values)
    if found.ndim != 2 or len(found) < least or found.shape[1] != 3 or not np.isfinite(found).all():
        raise InputError(f"{what}: a list of points of three finite numbers is needed, {least} at least")
    return found


def numbers(values: Any) -> Floats:
    """Return an array of what are numbers.

    Parameters
    ----------
    values : array_like
        Of any shape.

    Returns
    -------
    array
        Of their shape; a single nan for what is no array of numbers.
    """
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        return np.array(np.nan)


def as_load(assembly: Assembly, load: Any) -> Floats:
    """Return a load as wrenches on the blocks.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    load : array_like, shape (3,) or (n_blocks, 6)
        Direction of an acceleration as strong as gravity, or a wrench on each block [N, N m].

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For another shape, values that no building bears, or a load that is zero on every free block.
    """
    try:
        values = np.asarray(load, dtype=float)
    except (TypeError, ValueError):
        given = repr(load) if isinstance(load, (str, bytes, list, tuple, dict)) else f"a {type(load).__name__}"
        raise InputError(
            f"load is {given}; three numbers (a direction) or an array of shape ({assembly.n_blocks}, 6) are needed, "
            "as `live` of a load case"
        ) from None
    if values.shape == (3,):
        return acceleration(assembly, list(values))
    if values.shape != (assembly.n_blocks, 6) or not np.isfinite(values).all():
        raise InputError(
            f"load has shape {values.shape}; three numbers (a direction) or finite values of shape "
            f"({assembly.n_blocks}, 6) are needed"
        )
    check_size(values)
    if not (np.abs(values[assembly.free]) > 1.0 / HUGE).any():
        raise InputError("load is zero on every free block")
    return values


def check_size(loads: Floats) -> None:
    """Check that loads are those of a building.

    Parameters
    ----------
    loads : array
        Wrenches on blocks [N, N m].

    Raises
    ------
    InputError
        For forces or moments without digits beside any other.
    """
    most = np.abs(loads).max(initial=0.0)
    if not most < HUGE:
        raise InputError(f"the largest force or moment of a load is {most:g}; it must be below {HUGE:g} N or N m")


def _direction(direction: Sequence[float]) -> Floats:
    vector = numbers(direction)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
        raise InputError(f"load direction is {[*map(float, vector.flat)]}; it must be three numbers, not all zero")
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)
