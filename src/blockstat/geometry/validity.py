"""Refuse blocks that are not closed, outward-facing solids, and say which block and face is wrong."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from blockstat.errors import InputError, InputWarning
from blockstat.geometry.components import connected_components
from blockstat.geometry.polyhedron import Polyhedra, next_in_face

#: A block whose mean thickness, volume over half its surface, is below this fraction of its box diagonal has no volume:
#: rounding of coordinates given to seven digits makes about 1e-7.
FLAT = 1e-7


def check_geometry(blocks: Polyhedra, names: Sequence[str]) -> None:
    """Check that every block is a closed solid whose faces look outwards.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks. Vertices with exactly equal coordinates count as one.
    names : sequence of str
        Their names, for the message.

    Raises
    ------
    InputError
        For each block that is open, has an inverted face, or has no volume.

    Warns
    -----
    InputWarning
        For a block that is several solids, apart or touching.
    """
    merged = merged_vertices(blocks)
    walked = _check_surface(blocks, names, merged)
    _warn_of_several_solids(blocks, names, merged, walked)
    lower, upper = blocks.bounds
    diagonal = np.linalg.norm(upper - lower, axis=1)
    surface = np.bincount(blocks.face_block, blocks.planes.area, blocks.n_blocks)
    flat = np.abs(blocks.volume) <= FLAT * diagonal * surface / 2
    wrong = [
        f'block "{names[block]}": its volume is {blocks.volume[block]:.3g} m3; it is flat'
        for block in np.flatnonzero(flat).tolist()
    ]
    wrong += [
        f'block "{names[block]}": all its faces point inwards; list their corners counter-clockwise seen from '
        "outside, or let `blockstat repair` turn them"
        for block in np.flatnonzero(~flat & (blocks.volume < 0)).tolist()
    ]
    if wrong:
        raise InputError(*wrong)


def _check_surface(blocks: Polyhedra, names: Sequence[str], merged: np.ndarray) -> np.ndarray:
    """Each edge must be walked as often one way as the other: twice one way is an inverted face, once alone a hole.

    Returns for each corner how often the edge to the next is walked its way.
    """
    start = merged[blocks.face_vertices]
    end = start[next_in_face(blocks.face_start)]
    n = len(blocks.vertices)
    forward, backward = start * n + end, end * n + start
    values, _first, count = np.unique(forward, return_index=True, return_counts=True)
    corner_face = np.repeat(np.arange(len(blocks.face_block)), np.diff(blocks.face_start))

    position = np.minimum(np.searchsorted(values, backward), len(values) - 1)
    balance = np.where(values[position] == backward, count[position], 0)
    own = count[np.searchsorted(values, forward)]
    wrong = np.flatnonzero(own != balance)
    if not len(wrong):
        return own
    at = blocks.face_block[corner_face[wrong]]
    found = (_surface_fault(int(block), names, blocks, corner_face, wrong[at == block], own) for block in np.unique(at))
    raise InputError(*found)


def _surface_fault(
    block: int, names: Sequence[str], blocks: Polyhedra, corner_face: np.ndarray, wrong: np.ndarray, own: np.ndarray
) -> str:
    """What is wrong with the surface of a block: the edges at fault, and how often each is walked."""
    first = np.searchsorted(blocks.face_block, block)
    if (own[wrong] > 1).any():
        votes = np.bincount(corner_face[wrong] - first)
        return (
            f'block "{names[block]}": face {votes.argmax()} is inverted against its neighbours; '
            "list its corners counter-clockwise seen from outside, or let `blockstat repair` turn it"
        )
    return (
        f'block "{names[block]}": its surface is open ({len(wrong)} edges without a neighbour, '
        f"the first at face {corner_face[wrong[0]] - first}); blocks must be closed solids"
    )


def _warn_of_several_solids(blocks: Polyhedra, names: Sequence[str], merged: np.ndarray, walked: np.ndarray) -> None:
    """A block of separate solids moves as one rigid body, which is seldom what a mesh file means."""
    # Solids that touch share corners, so corners are told apart by their index where that closes the surface.
    tail = blocks.face_vertices
    head = tail[next_in_face(blocks.face_start)]
    n = len(blocks.vertices)
    block = np.repeat(blocks.face_block, np.diff(blocks.face_start))
    loose = np.zeros(blocks.n_blocks, dtype=bool)
    forward, backward = tail * n + head, head * n + tail
    if not np.array_equal(np.sort(forward), np.sort(backward)):
        loose[block[~np.isin(backward, forward)]] = True
    tail, head = np.where(loose[block], merged[tail], tail), np.where(loose[block], merged[head], head)
    count, label = connected_components(n, np.column_stack([tail, head]))
    owner = np.full(count, -1)
    owner[label[tail]] = block
    apart = np.bincount(owner[owner >= 0], minlength=blocks.n_blocks) > 1
    # Solids that touch along an edge, or with a face, share its corners, and each walks the edge both ways.
    touching = np.bincount(block[walked > 1], minlength=blocks.n_blocks) > 0
    several = np.flatnonzero(apart | touching)
    if len(several):
        text = f'{len(several)} blocks hold separate solids that move as one (the first is "{names[several[0]]}")'
        warnings.warn(InputWarning(text), stacklevel=4)


def merged_vertices(blocks: Polyhedra) -> np.ndarray:
    """Return for each vertex the first vertex of its block with the same coordinates.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.

    Returns
    -------
    array of int, shape (n_vertices,)
        Numbers of vertices.
    """
    block = np.repeat(np.arange(blocks.n_blocks), np.diff(blocks.vertex_start))
    keys = np.column_stack([block, blocks.vertices + 0.0])
    order = np.lexsort(keys.T[::-1])
    new = np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)])
    merged = np.empty(len(order), dtype=np.int64)
    merged[order] = order[new][np.cumsum(new) - 1]
    return merged
