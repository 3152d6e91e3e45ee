"""Contacts that are known of the pairs of a search, and what of edges and corners lies in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstat.contact.coplanar import Patches
from blockstat.contact.faces import INSIDE, frames, position
from blockstat.contact.features import ContactKind, Features, Search, crossings, on_faces, together
from blockstat.geometry.broad_phase import row_pairs
from blockstat.geometry.polyhedron import Polyhedra
from blockstat.geometry.topology import edge_topology
from blockstat.typing import Floats, Ints

#: Cosine of the normals of a patch and of an edge in it: faces nearer to opposed than this may be one joint.
ONE_PATCH = float(np.cos(np.deg2rad(15.0)))


@dataclass(frozen=True)
class Tolerances:
    """What counts as touching."""

    allowed: Floats  #: gap of a joint of each block, shape (n_blocks,) [m]
    rounding: float  #: lengths below this, relative to the smaller block, are nothing
    steepest: float  #: largest sine of the angle between a contact and a face that counts as lying on it
    blurred: bool = False  #: whether a rim is as wide as the gap: the geometry is no more exact than that


def search_of(assembly: Polyhedra, pairs: Ints, tolerances: Tolerances, *, rims: bool) -> Search:
    """Return a search for the edges and corners of some pairs.

    Parameters
    ----------
    assembly : Polyhedra
        The blocks.
    pairs : array of int, shape (n, 2)
        The pairs.
    tolerances : Tolerances
        What counts as touching.
    rims : bool
        Whether contacts on rims are wanted too.

    Returns
    -------
    Search
        The pairs with the edges of their blocks.
    """
    reach = tolerances.allowed[pairs].min(axis=1)
    rounding = tolerances.rounding * assembly.size[pairs].min(axis=1)
    beyond = reach if tolerances.blurred else rounding
    topology = edge_topology(assembly, np.unique(pairs))
    return Search(assembly, topology, pairs, reach, rounding, beyond, rims)


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts of the pairs of a search, one a row."""

    row: Ints  #: number of the pair
    kind: Ints
    patches: Patches

    def with_more(self, kind: ContactKind, features: Features, pairs: Ints) -> Contacts:
        """Return these contacts and then some of edges or corners.

        Parameters
        ----------
        kind : ContactKind
            Of all the others: `EDGE`, `CORNER` or `CROSSING`.
        features : Features
            The others; none of them gives these contacts as they are.
        pairs : array of int, shape (n_pairs, 2)
            Pairs of the search, by which the rows of the features are numbered.

        Returns
        -------
        Contacts
            The others are patches without area about the middle of their ends: of two corners for an edge, of one
            otherwise.
        """
        n = len(features.row)
        if not n:
            return self
        frame, origin = frames(features.normal), features.ends.mean(axis=1)
        flat = np.einsum("nkj,ntj->nkt", features.ends - origin[:, None], frame[:, 1:])
        points = 2 if kind == ContactKind.EDGE else 1
        new = Patches(
            pairs[features.row], frame, origin, np.zeros(n), features.gap, flat[:, :points].reshape(-1, 2),
            np.full(n, points), np.zeros(n),
        )  # fmt: skip
        both: list[Any] = [np.concatenate(x) for x in zip(self.patches.columns(), new.columns(), strict=True)]
        kinds = np.concatenate([self.kind, np.full(n, kind, np.int64)])
        return Contacts(np.concatenate([self.row, features.row]), kinds, Patches(*both))


def features_of(search: Search, steepest: float) -> list[Features]:
    """Find the contacts of edges and corners of all pairs of a search.

    Parameters
    ----------
    search : Search
        The pairs; with its `rims` contacts on rims are found too, but no edges across edges, which are never on one.
    steepest : float
        Largest sine of the angle between an edge and the face that it rests on.

    Returns
    -------
    list of Features
        Edges on faces, corners on faces and, unless rims are wanted, edges across edges; rows are numbers of pairs.
    """
    found: list[list[Features]] = [[], []] if search.rims else [[], [], []]
    first = 0
    for part in search.chunks():
        for side in (0, 1):
            for kind, features in zip(found, on_faces(part, side, steepest), strict=False):
                kind.append(features.shifted(first))
        if not search.rims:
            found[2].append(crossings(part).shifted(first))
        first += len(part.pairs)
    return [together(kind) for kind in found]


def covered(search: Search, features: Features, known: Contacts, least: float) -> np.ndarray:
    """Return which features lie whole in one known contact of their pair.

    Parameters
    ----------
    search : Search
        The pairs, with the reach and the rounding of each.
    features : Features
        Contacts of edges or corners, shape (n,).
    known : Contacts
        The contacts that are known; rows of both are numbers of the pairs of the search.
    least : float
        Least cosine between the normals of a feature and of the contact that it lies in; -inf for any.

    Returns
    -------
    array of bool, shape (n,)
        True where both ends are no further from the plane of the contact than the reach of the pair, and in its polygon
        or beside it by no more than twice the rounding and what the angle between the normals makes of the reach.
    """
    found = np.zeros(len(features.row), dtype=bool)
    found[covers(search, features, known, least)[0]] = True
    return found


def covers(search: Search, features: Features, known: Contacts, least: float) -> tuple[Ints, Ints]:
    """Return the known contacts in which features lie whole.

    Parameters
    ----------
    search, features, known, least
        As of `covered`.

    Returns
    -------
    feature, contact : array of int, shape (n,)
        Numbers of both, ascending by feature.
    """
    one, two = (np.argsort(rows, kind="stable") for rows in (features.row, known.row))
    # Beside a polygon by rounding, and by what an angle makes of the reach.
    margin = 2 * (search.reach + search.rounding)
    ends, boxes = features.ends[one], known.patches.take(two).boxes()
    item, cover = row_pairs(features.row[one], (ends.min(axis=1), ends.max(axis=1)), known.row[two], boxes, margin)
    item, cover = one[item], two[cover]
    order = np.lexsort((cover, item))
    item, cover = item[order], cover[order]
    alike_enough = np.einsum("ij,ij->i", known.patches.frame[cover, 0], features.normal[item]) >= least
    item, cover = item[alike_enough], cover[alike_enough]
    lies = inside(search, features.take(item), known.patches, cover, search.reach[features.row[item]])
    return item[lies], cover[lies]


def inside(search: Search, features: Features, patches: Patches, cover: Ints, depth: Floats) -> np.ndarray:
    """Return whether each feature lies in its patch.

    Parameters
    ----------
    search : Search
        The pairs of the features, with the rounding of each.
    features : Features
        Contacts of edges or corners, shape (n,).
    patches : Patches
        The patches.
    cover : array of int, shape (n,)
        Number of the patch of each feature.
    depth : array of float, shape (n,)
        How far both of its ends may be from the plane of the patch [m].

    Returns
    -------
    array of bool, shape (n,)
        True for those that lie in their patch, or beside it by rounding.
    """
    found = np.zeros(len(cover), dtype=bool)
    local = np.einsum("nkj,ntj->nkt", features.ends - patches.origin[cover][:, None], patches.frame[cover])
    near = np.flatnonzero(np.abs(local[..., 0]).max(axis=1, initial=0.0) <= depth)
    if not len(near):
        return found
    local, cover, depth, features = local[near], cover[near], depth[near], features.take(near)
    # Seen along another normal, a point off the plane lies beside its place by as much as the normals differ.
    alike = np.einsum("ij,ij->i", patches.frame[cover, 0], features.normal)
    aside = 2 * search.rounding[features.row] + depth * np.sqrt(np.clip(1 - alike**2, 0.0, 1.0))
    first = (np.cumsum(patches.count) - patches.count)[cover]
    width = int(patches.count[cover].max())
    column = np.minimum(np.arange(width), patches.count[cover][:, None] - 1)
    polygon = patches.corner[first[:, None] + column]
    no_rim = np.zeros(polygon.shape[:2], dtype=bool)
    within = position(local[..., 1:], polygon, no_rim, aside) == INSIDE
    at_corner = np.linalg.norm(local[..., None, 1:] - polygon[:, None], axis=3).min(axis=2) <= aside[:, None]
    found[near] = (within | at_corner).all(axis=1)
    return found
