"""The pose of displaced blocks: a finite rotation of each block and a displacement of its centroid.

A point of a block that is at X at rest, with the centroid at C, is displaced to

    x = C + d + R (X - C),

where d is the displacement of the centroid [m] and R the rotation.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True, eq=False)
class Pose:
    """The positions of all blocks relative to the assembly at rest, and how far ties have yielded on the way there."""

    rotation: Floats  #: rotation matrices, shape (n_blocks, 3, 3)
    displacement: Floats  #: of the centroids, shape (n_blocks, 3) [m]
    #: by how much ties are longer than at rest for good, and struts shorter, shape (n_ties,) [m]; empty where none has
    #: yielded
    yielded: Floats = field(default_factory=lambda: np.empty(0))

    def centroids(self, assembly: Assembly) -> Floats:
        """Return the displaced centroids.

        Parameters
        ----------
        assembly
            The blocks at rest.

        Returns
        -------
        Floats
            Shape (n_blocks, 3) [m].
        """
        displaced: Floats = assembly.centroid + self.displacement
        return displaced


def free_sizes(assembly: Assembly) -> Floats:
    """Return the sizes of the blocks that are no supports; lengths of a path are judged by these alone.

    Supports may be of any size: a pier may stand on a stone or on a mountain.

    Parameters
    ----------
    assembly
        The blocks.

    Returns
    -------
    Floats
        Ascending by number of block [m].
    """
    sizes: Floats = assembly.size[~assembly.support]
    return sizes


def side_sizes(assembly: Assembly, pair: Ints) -> Floats:
    """Return the sizes by which the two sides of joints are judged: a support has that of the block on it.

    Parameters
    ----------
    assembly
        The blocks.
    pair
        The two blocks of each joint, shape (n, 2).

    Returns
    -------
    Floats
        Shape (n, 2) [m].
    """
    size, support = assembly.size[pair], assembly.support[pair]
    found: Floats = np.where(support & ~support[:, ::-1], size[:, ::-1], size)
    return found


def rest_pose(assembly: Assembly) -> Pose:
    """Return the pose in which no block has moved.

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


def displaced_points(assembly: Assembly, pose: Pose, block: Ints, point: Floats) -> Floats:
    """Return the displaced positions of material points.

    Parameters
    ----------
    assembly
        The blocks at rest.
    pose
        Their pose.
    block
        The block of each point, shape (n,).
    point
        Positions at rest, shape (n, 3) [m].

    Returns
    -------
    Floats
        Shape (n, 3) [m].
    """
    centroid = assembly.centroid[block]
    arm = point - centroid
    moved = centroid + pose.displacement[block] + np.einsum("nij,nj->ni", pose.rotation[block], arm)
    return _on_supports_exactly(assembly, pose, block, point + pose.displacement[block], moved)


def points_at_rest(assembly: Assembly, pose: Pose, block: Ints, point: Floats) -> Floats:
    """Return the positions at rest of material points whose displaced positions are given.

    Parameters
    ----------
    assembly
        The blocks at rest.
    pose
        Their pose.
    block
        The block of each point, shape (n,).
    point
        Displaced positions, shape (n, 3) [m].

    Returns
    -------
    Floats
        Shape (n, 3) [m]: the inverse of `displaced_points`.
    """
    arm = point - assembly.centroid[block] - pose.displacement[block]
    back = assembly.centroid[block] + np.einsum("nji,nj->ni", pose.rotation[block], arm)
    return _on_supports_exactly(assembly, pose, block, point - pose.displacement[block], back)


def _on_supports_exactly(assembly: Assembly, pose: Pose, block: Ints, shifted: Floats, turned: Floats) -> Floats:
    """Turned points; on supports that do not turn, shifted ones, as a far centroid would take their last digits."""
    straight = assembly.support & (pose.rotation == np.eye(3)).all(axis=(1, 2))
    return np.where(straight[block, None], shifted, turned)


def rotation_matrices(rotation: Floats) -> Floats:
    """Return the matrices of rotation vectors by Rodrigues' formula.

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


def displaced_assembly(assembly: Assembly, pose: Pose) -> Assembly:
    """Return the assembly with its blocks and ties in their displaced positions.

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
        ends = displaced_points(assembly, pose, pair, np.asarray(tie.points, dtype=float))
        ties.append(replace(tie, points=(ends[0].tolist(), ends[1].tolist())))
    vertices = displaced_points(assembly, pose, assembly.vertex_block, assembly.vertices)
    return replace(assembly, vertices=vertices, ties=tuple(ties))
