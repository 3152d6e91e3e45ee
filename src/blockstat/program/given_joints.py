"""The joints that a caller gives in place of a search: whether they can be those of the assembly."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError

#: Axes of joints are of length one, and at right angles, to this; those of files in single precision, too.
ORTHONORMAL = 1e-5


def check_given(assembly: Assembly, interfaces: Interfaces, *, displaced: bool = False) -> None:
    """Raise InputError for joints that cannot be joints of an assembly.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        What a caller gives for their joints.
    displaced : bool
        Whether blocks have moved, so that points need not be near both blocks.

    Raises
    ------
    InputError
        For arrays that do not go together, and for a joint that is at fault, with the names of its blocks: numbers that
        are not finite, a block with itself, no points or points away from its blocks, axes that are not orthonormal, a
        friction that is negative.

    Notes
    -----
    A point is away from a block where it is further from the box about it than the smaller block of the joint is large.
    The gap of no joint is as wide as that.
    """
    for fault in _faults_of_shape(assembly, interfaces):
        raise InputError(f"interfaces: {fault}")
    for bad, fault in _faults_of_joints(assembly, interfaces, displaced) if interfaces.n_interfaces else ():
        if bad.any():
            one, two = (f'"{assembly.names[block]}"' for block in interfaces.pair[int(np.argmax(bad))])
            raise InputError(f"interfaces: the joint of {one} and {two} {fault}")


def _faults_of_shape(assembly: Assembly, given: Interfaces) -> Iterator[str]:
    """What does not go together, in words; later ones may assume that earlier ones are none."""
    n = len(given.pair)
    shapes = {"pair": (n, 2), "frame": (n, 3, 3), "area": (n,), "gap": (n,), "start": (n + 1,), "friction": (n,)}
    points = len(given.point)
    shapes |= {"kind": (n,), "point": (points, 3), "share": (points,)}
    for name, shape in shapes.items():
        own = getattr(given, name)
        if own is not None and np.shape(own) != shape:
            yield f"{name} has the shape {np.shape(own)}; it must be {shape} for {n} joints of {points} points"
    for name in ("pair", "start"):
        if not np.issubdtype(np.asarray(getattr(given, name)).dtype, np.integer):
            yield f"{name} has numbers that are not whole"
    if n and not 0 <= given.pair.min() <= given.pair.max() < assembly.n_blocks:
        yield f"a joint is of a block that is not among the {assembly.n_blocks} of the assembly"
    if given.start[0] != 0 or given.start[-1] != points or (np.diff(given.start) < 0).any():
        yield f"start must grow from 0 to the number of points, {points}"


def _faults_of_joints(assembly: Assembly, given: Interfaces, displaced: bool) -> Iterator[tuple[np.ndarray, str]]:
    """Which joints are at fault, and how; later ones may assume that earlier ones are none."""
    yield given.pair[:, 0] == given.pair[:, 1], "is of a block with itself"
    yield np.diff(given.start) == 0, "has no points"
    bad = ~np.isfinite(given.frame).all(axis=(1, 2)) | ~np.isfinite(given.area) | ~np.isfinite(given.gap)
    bad[given.point_interface[~np.isfinite(given.point).all(axis=1)]] = True
    yield bad, "has numbers that are not finite"
    products = np.einsum("nij,nkj->nik", given.frame, given.frame)
    skew = np.abs(products - np.eye(3)).max(axis=(1, 2)) > ORTHONORMAL
    yield skew | (np.linalg.det(given.frame) < 0), "has a frame that is not three right-handed axes of length one"
    if given.friction is not None:
        yield ~(given.friction >= 0), "has a friction that is not 0 or more"
    if not displaced:
        yield _are_away(assembly, given), "has points that are not near both of them"


def _are_away(assembly: Assembly, given: Interfaces) -> np.ndarray:
    """Which joints have points away from one of their blocks."""
    lower, upper = assembly.bounds
    point, own, away = given.point[:, None], given.pair[given.point_interface], np.zeros(len(given.pair), dtype=bool)
    outside = np.linalg.norm(point - np.clip(point, lower[own], upper[own]), axis=2).max(axis=1)
    away[given.point_interface[outside > assembly.size[own].min(axis=1)]] = True
    return away
