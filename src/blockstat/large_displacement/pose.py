"""Where displaced blocks are: a finite rotation and a displacement of the centroid for each of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True, eq=False)
class Pose:
    """The positions of all blocks against those of the file."""

    rotation: Floats  #: shape (n_blocks, 3, 3)
    displacement: Floats  #: of the centroids, shape (n_blocks, 3) [m]


def rest(assembly: Assembly) -> Pose:
    """Return the pose in which nothing has moved.

    Parameters
    ----------
    assembly
        The blocks.

    Returns
    -------
    Pose
        Of all blocks.
    """
    return Pose(np.tile(np.eye(3), (assembly.n_blocks, 1, 1)), np.zeros((assembly.n_blocks, 3)))


def places(assembly: Assembly, pose: Pose, block: Ints, point: Floats) -> Floats:
    """Return where points of blocks have gone.

    Parameters
    ----------
    assembly
        The blocks at rest.
    pose
        Their pose.
    block
        The block of each point, shape (n,).
    point
        Where the points are at rest, shape (n, 3) [m].

    Returns
    -------
    Floats
        Shape (n, 3) [m].
    """
    arm = point - assembly.centroid[block]
    return assembly.centroid[block] + pose.displacement[block] + np.einsum("nij,nj->ni", pose.rotation[block], arm)


def origins(assembly: Assembly, pose: Pose, block: Ints, place: Floats) -> Floats:
    """Return where points of blocks are at rest, given where they have gone: the inverse of `places`.

    Parameters
    ----------
    assembly
        The blocks at rest.
    pose
        Their pose.
    block
        The block of each point, shape (n,).
    place
        Where the points are, shape (n, 3) [m].

    Returns
    -------
    Floats
        Shape (n, 3) [m].
    """
    arm = place - assembly.centroid[block] - pose.displacement[block]
    return assembly.centroid[block] + np.einsum("nji,nj->ni", pose.rotation[block], arm)


def turned(rotation: Floats) -> Floats:
    """Return the matrices of rotation vectors (Rodrigues).

    Parameters
    ----------
    rotation
        Axis times angle, shape (n, 3) [rad].

    Returns
    -------
    Floats
        Shape (n, 3, 3).
    """
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(rotation).as_matrix()


def displaced(assembly: Assembly, pose: Pose) -> Assembly:
    """Return the assembly with its blocks and ties where they have gone.

    Parameters
    ----------
    assembly
        The blocks at rest.
    pose
        Their pose.

    Returns
    -------
    Assembly
        The same blocks, displaced.
    """
    ties = []
    for tie in assembly.ties:
        pair = assembly.blocks_named(tie.between, tie.label)
        ends = places(assembly, pose, pair, np.asarray(tie.points, dtype=float))
        ties.append(replace(tie, points=(ends[0].tolist(), ends[1].tolist())))
    vertices = places(assembly, pose, assembly.vertex_block, assembly.vertices)
    return replace(assembly, vertices=vertices, ties=tuple(ties))
