"""Refuse blocks that are not closed, outward-facing solids, and say which block and face is wrong."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from blockstat.errors import InputError, InputWarning
from blockstat.polyhedron import next_in_face

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A block whose mean thickness, volume over half its surface, is below this fraction of its box diagonal has no volume:
#: rounding of coordinates given to seven digits makes about 1e-7.
FLAT = 1e-7


def check_geometry(assembly: Assembly) -> None:
    """Raise InputError for the first block that is open, has an inverted face, or has no volume.

    Vertices with exactly equal coordinates count as one.
    """
    merged = _merged_vertices(assembly)
    _check_surface(assembly, merged)
    _warn_of_several_solids(assembly, merged)
    lower, upper = assembly.bounds
    diagonal = np.linalg.norm(upper - lower, axis=1)
    surface = np.bincount(assembly.face_block, assembly.planes.area, assembly.n_blocks)
    flat = np.flatnonzero(np.abs(assembly.volume) <= FLAT * diagonal * surface / 2)
    if len(flat):
        block = flat[0]
        raise InputError(f'block "{assembly.names[block]}": its volume is {assembly.volume[block]:.3g} m3; it is flat')
    inside_out = np.flatnonzero(assembly.volume < 0)
    if len(inside_out):
        raise InputError(
            f'block "{assembly.names[inside_out[0]]}": all its faces point inwards; '
            "list the corners counter-clockwise seen from outside"
        )


def _check_surface(assembly: Assembly, merged: np.ndarray) -> None:
    """Each edge must be walked once in each direction: twice one way is an inverted face, once alone a hole."""
    start = merged[assembly.face_vertices]
    end = start[next_in_face(assembly.face_start)]
    n = len(assembly.vertices)
    forward, backward = start * n + end, end * n + start
    values, _first, count = np.unique(forward, return_index=True, return_counts=True)
    corner_face = np.repeat(np.arange(len(assembly.face_block)), np.diff(assembly.face_start))

    position = np.minimum(np.searchsorted(values, backward), len(values) - 1)
    balance = np.where(values[position] == backward, count[position], 0)
    own = count[np.searchsorted(values, forward)]
    wrong = np.flatnonzero(own != balance)
    if not len(wrong):
        return
    block = assembly.face_block[corner_face[wrong[0]]]
    label = assembly.names[block]
    mine = wrong[assembly.face_block[corner_face[wrong]] == block]
    face_offset = np.searchsorted(assembly.face_block, block)
    if (own[mine] > 1).any():
        votes = np.bincount(corner_face[mine] - face_offset)
        raise InputError(
            f'block "{label}": face {votes.argmax()} is inverted against its neighbours; '
            "list the corners counter-clockwise seen from outside"
        )
    raise InputError(
        f'block "{label}": its surface is open ({len(mine)} edges without a neighbour, '
        f"the first at face {corner_face[mine[0]] - face_offset}); blocks must be closed solids"
    )


def _warn_of_several_solids(assembly: Assembly, merged: np.ndarray) -> None:
    """A block of separate solids moves as one rigid body, which is seldom what a mesh file means."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    # Solids that touch share corners, so corners are told apart by their index where that closes the surface.
    tail = assembly.face_vertices
    head = tail[next_in_face(assembly.face_start)]
    n = len(assembly.vertices)
    block = np.repeat(assembly.face_block, np.diff(assembly.face_start))
    loose = np.zeros(assembly.n_blocks, dtype=bool)
    forward, backward = tail * n + head, head * n + tail
    if not np.array_equal(np.sort(forward), np.sort(backward)):
        loose[block[~np.isin(backward, forward)]] = True
    tail, head = np.where(loose[block], merged[tail], tail), np.where(loose[block], merged[head], head)
    graph = sparse.coo_array((np.ones(len(tail)), (tail, head)), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    owner = np.full(count, -1)
    owner[label[tail]] = block
    several = np.flatnonzero(np.bincount(owner[owner >= 0], minlength=assembly.n_blocks) > 1)
    if len(several):
        text = (
            f'{len(several)} blocks hold separate solids that move as one (the first is "{assembly.names[several[0]]}")'
        )
        warnings.warn(InputWarning(text), stacklevel=4)


def _merged_vertices(assembly: Assembly) -> np.ndarray:
    """For each vertex the index of the first vertex of its block with the same coordinates."""
    block = np.repeat(np.arange(assembly.n_blocks), np.diff(assembly.vertex_start))
    keys = np.column_stack([block, assembly.vertices + 0.0])
    order = np.lexsort(keys.T[::-1])
    new = np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)])
    merged = np.empty(len(order), dtype=np.int64)
    merged[order] = order[new][np.cumsum(new) - 1]
    return merged
