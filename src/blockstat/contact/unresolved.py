"""Contacts without a unique normal: edge along edge, corner on an edge, corner on corner.

They are in no program. The normals that separate the two blocks at the point form a cone. The normals about which a
motion has `g_n >= mu |g_t|` are those within `pi/2 - atan(mu)` of the velocity, a convex cone too. So a motion that
keeps clear of the extreme normals keeps clear of all.

A corner with a notch is cut into convex cones. Each pair of cones of the two blocks has its own normals, and blocks
pass each other where all pairs do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.coplanar import Patches
from blockstat.contact.faces import as_searched, frames
from blockstat.contact.features import ContactKind, Features, Search
from blockstat.contact.interfaces import ANGLE, GAP, WIDTH, Interfaces
from blockstat.contact.known_contacts import Contacts, Tolerances, covered, covers, features_of, search_of
from blockstat.contact.tolerance import allowed_gap, stated_length
from blockstat.geometry.polyhedron import members
from blockstat.surface.corner_cones import corner_cones
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A normal separates two cones of directions when none leans across its plane by more than this sine.
LEAN = 1e-4
#: An interface of parts of blocks has their normal to within this sine: its plane may be the mean of many facets.
ALIKE = float(np.sin(ANGLE))
#: Contacts whose normals are sought at once.
CHUNK = 2000


@dataclass(frozen=True, eq=False)
class Unresolved:
    """Contacts without a unique normal, one a row."""

    pair: Ints  #: shape (n, 2), blocks a < b
    point: Floats  #: shape (n, 3) [m]
    reason: tuple[str, ...]  #: "edge along edge", "corner on edge" or "corner on corner"
    normal: Floats  #: extreme normals of all contacts, from a to b, shape (n_normals, 3)
    contact: Ints  #: the contact of each normal, ascending, shape (n_normals,)
    line: Ints  #: contacts at the two ends of each edge along an edge, shape (n_lines, 2)

    def among(self, pairs: Ints, n_blocks: int) -> Unresolved:
        """Return the contacts of some pairs of blocks.

        Parameters
        ----------
        pairs : array of int, shape (n, 2)
            Blocks a < b.
        n_blocks : int
            Of the assembly.

        Returns
        -------
        Unresolved
            The contacts of these pairs alone.
        """
        return self.only(np.isin(self.pair @ [n_blocks, 1], pairs @ [n_blocks, 1]))

    def only(self, chosen: np.ndarray) -> Unresolved:
        """Return some of the contacts.

        Parameters
        ----------
        chosen : array of bool, shape (n,)
            Which.

        Returns
        -------
        Unresolved
            These contacts alone.
        """
        normals = chosen[self.contact]
        reason = tuple(word for word, is_chosen in zip(self.reason, chosen, strict=True) if is_chosen)
        place = np.cumsum(chosen) - 1
        whole = chosen[self.line].all(axis=1)
        return Unresolved(
            self.pair[chosen], self.point[chosen], reason, self.normal[normals], place[self.contact[normals]],
            place[self.line[whole]],
        )  # fmt: skip

    def as_corners(self) -> Interfaces:
        """Return the contacts as corners on faces, one for each extreme normal.

        Whatever forces the true contacts can carry, these can carry.

        Returns
        -------
        Interfaces
            One point each.
        """
        n = len(self.contact)
        none, kind = np.zeros(n), np.full(n, ContactKind.CORNER, np.int64)
        pair, point = self.pair[self.contact], self.point[self.contact]
        return Interfaces(pair, frames(self.normal), none, none, point, np.arange(n + 1), kind=kind)

    def beside(self, interfaces: Interfaces) -> Interfaces:
        """Return interfaces and after them these contacts as corners on faces.

        Parameters
        ----------
        interfaces : Interfaces
            Interfaces of the same blocks.

        Returns
        -------
        Interfaces
            All contacts; none is left unresolved.
        """
        more = self.as_corners()
        columns = ("pair", "frame", "area", "gap", "point", "kinds")
        pair, frame, area, gap, point, kind = (
            np.concatenate([getattr(interfaces, c), getattr(more, c)]) for c in columns
        )
        start = np.concatenate([interfaces.start, interfaces.start[-1] + more.start[1:]])
        outlines, share = interfaces.outlines, interfaces.share
        if outlines is not None:
            outlines = (*outlines, *more.point[:, None])
        if share is not None:
            share = np.concatenate([share, np.ones(more.n_points)])
        friction = interfaces.friction
        if friction is not None:  # the roughest: what falls with these, falls
            friction = np.concatenate([friction, np.full(len(more.pair), friction.max(initial=0.0))])
        found = Interfaces(
            pair, frame, area, gap, point, start, interfaces.dropped, outlines, share, interfaces.patches, kind
        )
        return replace(found, friction=friction, crushed=interfaces.crushed, moved=interfaces.moved)


def unresolved_contacts(
    assembly: Assembly, interfaces: Interfaces, *, gap: float | str = GAP, pairs: Ints | None = None
) -> Unresolved:
    """Find the contacts without a unique normal.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Their interfaces, as `find_interfaces` gives them.
    gap : float or str, optional
        As in `find_interfaces`.
    pairs : array of int, shape (n, 2), optional
        Pairs among which to look; None for `interfaces.rims`.

    Returns
    -------
    Unresolved
        The contacts that are no part of an interface, nor of one before it lost its edges. Where a block has a notch
        that ends there, the contacts of its convex parts of which the normal of no interface separates the two.
    """
    pairs = interfaces.rims if pairs is None else pairs
    if pairs is None or not len(pairs):
        none = np.empty((0, 2), np.int64)
        return Unresolved(none, np.empty((0, 3)), (), np.empty((0, 3)), np.empty(0, np.int64), none)
    blurred = stated_length(gap) is not None
    tolerances = Tolerances(allowed_gap(assembly, gap), WIDTH, float(np.sin(ANGLE)), blurred)
    assembly = as_searched(assembly, gap)
    search = search_of(assembly, pairs, tolerances, rims=True)
    known = _known(interfaces.drawn or interfaces, pairs, assembly.n_blocks)
    lines, dots = (found.take(found.rim) for found in features_of(search, tolerances.steepest))
    # The surface that an interface lies in bounds an edge, or a convex corner, on its side.
    search = _as_deep_as_warped(search)
    lines = lines.take(~covered(search, lines, known, -np.inf))
    dots = dots.take(_saddles(search, dots) | ~covered(search, dots, known, -np.inf))
    return _bounded(search, lines, dots, known)


def _as_deep_as_warped(search: Search) -> Search:
    """A search whose reach is more by what faces of both blocks leave their planes: an interface of them does, too."""
    warp = np.zeros(search.assembly.n_blocks)
    np.maximum.at(warp, search.assembly.face_block, search.assembly.planes.warp)
    return replace(search, reach=search.reach + warp[search.pairs].min(axis=1))


def _known(interfaces: Interfaces, pairs: Ints, n_blocks: int) -> Contacts:
    """The interfaces of some pairs as contacts."""
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    key = pairs[order] @ [n_blocks, 1]
    wanted = interfaces.pair @ [n_blocks, 1]
    place = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    own = np.flatnonzero(key[place] == wanted)
    outlines = [interfaces.outline(k) for k in own.tolist()]
    origin = np.array([o[0] for o in outlines]).reshape(-1, 3)
    frame = interfaces.frame[own]
    flat = [(o - o[0]) @ f[1:].T for o, f in zip(outlines, frame, strict=True)]
    count = np.array([len(o) for o in outlines], dtype=np.int64)
    corner = np.concatenate([np.empty((0, 2)), *flat])
    pair, area, gap = interfaces.pair[own], interfaces.area[own], interfaces.gap[own]
    patches = Patches(pair, frame, origin, area, gap, corner, count, np.zeros(len(own)))
    return Contacts(order[place[own]], interfaces.kinds[own], patches)


def _bounded(search: Search, lines: Features, dots: Features, known: Contacts) -> Unresolved:
    """The contacts that have normals, each point once, with the extreme ones."""
    n_ends = 2 * len(lines.row)
    row = np.concatenate([np.repeat(lines.row, 2), dots.row])
    point: Floats = np.concatenate([lines.ends.reshape(-1, 3), dots.ends[:, 0]])
    own, other = (np.concatenate([np.repeat(getattr(lines, f), 2), getattr(dots, f)]) for f in ("own", "other"))
    corner = (own < 0) & (other < 0)
    place = _places(search, row, point)
    saddle = np.flatnonzero(np.concatenate([np.zeros(n_ends, bool), _saddles(search, dots)]))
    saddle = saddle[np.lexsort((~corner[saddle], place[saddle]))]
    notched, finest = np.unique(place[saddle], return_index=True)
    saddle, beside = saddle[finest], np.isin(place, notched)
    # The edges that end at a notch are part of it, but for those that go on along each other.
    whole = np.flatnonzero(~beside | (np.arange(len(row)) < n_ends))
    parted, parts = _parts(search, dots.take(saddle - n_ends), known)
    sides = [_directions(search, row[whole], feature[whole]) for feature in (own, other)]
    owner = np.concatenate([*(k for k, _ in sides), len(whole) + np.repeat(np.arange(len(parts)), [*map(len, parts)])])
    source = np.concatenate([whole, saddle[parted]])
    owner, normal = _extreme_normals(len(source), owner, np.concatenate([*(d for _, d in sides), *parts]))
    group = np.where(beside[source], len(row) + np.arange(len(source)), place[source])
    _, first, contact = np.unique(group[owner], return_index=True, return_inverse=True)
    order, kept = np.argsort(contact, kind="stable"), source[owner[first]]
    number = np.full(len(row), -1)
    number[source[owner]] = contact
    ends = number[:n_ends].reshape(-1, 2)
    reason = tuple(
        "edge along edge" if k < n_ends else "corner on corner" if corner[k] else "corner on edge" for k in kept
    )
    return Unresolved(
        search.pairs[row[kept]], point[kept], reason, normal[order], contact[order], ends[(ends >= 0).all(axis=1)]
    )


def _places(search: Search, row: Ints, point: Floats) -> Ints:
    """The number of the place of each contact; contacts of one pair at one place have the same."""
    local = point - search.assembly.vertices[search.assembly.vertex_start[search.pairs[row, 0]]]
    grid = np.round(local / (10 * search.rounding[row])[:, None])
    return np.unique(np.column_stack([row, grid]), axis=0, return_inverse=True)[1].reshape(-1)


def _saddles(search: Search, dots: Features) -> np.ndarray:
    """At which contacts of corners one has a notch."""
    return _notched(search, dots.own) | _notched(search, dots.other)


def _notched(search: Search, feature: Ints) -> np.ndarray:
    """Which features are corners with a notch."""
    found = feature < 0
    found[found] = search.topology.saddle[~feature[found]]
    return found


def _parts(search: Search, dots: Features, known: Contacts) -> tuple[Ints, list[Floats]]:
    """The contacts of the convex parts of blocks at corners with notches, and the directions of both parts.

    Left out are those at which the normal of an interface separates the parts: what opens there passes.
    """
    item, cover = covers(search, dots, known, -np.inf)
    normal = known.patches.frame[cover, 0]
    left = np.flatnonzero(~_separated(search, dots, item, normal))
    number: list[int] = []
    found: list[Floats] = []
    rest = dots.take(left)
    both = zip(*(_convex(search, rest.row, feature) for feature in (rest.own, rest.other)), strict=True)
    for k, (one, two) in zip(left.tolist(), both, strict=True):
        own = normal[item == k]
        for direction in (np.concatenate(sides) for sides in product(one, two)):
            if not ((direction @ own.T).max(axis=0, initial=-1.0) <= ALIKE).any():
                number.append(k)
                found.append(direction)
    return np.array(number, dtype=np.int64), found


def _separated(search: Search, dots: Features, item: Ints, normal: Floats) -> np.ndarray:
    """At which contacts a normal separates the two blocks as a whole, and so all of their parts.

    item, normal : a contact each, ascending, and a normal there
    """
    lean = np.full(len(item), -1.0)
    for feature in (dots.own, dots.other):
        owner, direction = _directions(search, dots.row, feature)
        order = np.argsort(owner, kind="stable")
        first = np.searchsorted(owner[order], np.arange(len(dots.row) + 1))
        row, place = members(first[item], np.diff(first)[item])
        np.maximum.at(lean, row, np.einsum("ij,ij->i", direction[order[place]], normal[row]))
    separated = np.zeros(len(dots.row), dtype=bool)
    separated[item[lean <= ALIKE]] = True
    return separated


def _convex(search: Search, row: Ints, feature: Ints) -> list[list[Floats]]:
    """For each feature the directions of its convex parts, turned round for the second block of a pair."""
    owner, direction = _directions(search, row, feature)
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], np.arange(len(row) + 1))
    found = [[direction[order[first:last]]] for first, last in pairwise(starts.tolist())]
    at = np.flatnonzero(_notched(search, feature))
    vertex, number = np.unique(search.topology.corner[~feature[at]], return_inverse=True)
    cones = corner_cones(search.assembly, vertex)
    for k, sign, own in zip(at, _signs(search, row[at], feature[at]), number, strict=True):
        found[k] = [sign * cone for cone in cones[own]]
    return found


def _extreme_normals(n: int, owner: Ints, direction: Floats) -> tuple[Ints, Floats]:
    """The contact, ascending, and the direction of the extreme normals of planes that keep two features apart.

    n : number of contacts
    owner, direction : of what goes on from a contact, turned round for the second feature
    """
    order = np.argsort(owner, kind="stable")
    owner, direction = owner[order], direction[order]
    count = np.bincount(owner, minlength=n)
    width = int(count.max(initial=0))
    column = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    sides = np.zeros((n, width, 3))
    sides[owner, column] = direction
    one, two = np.triu_indices(width, 1)
    found = [np.empty(0, np.int64)], [np.empty((0, 3))]
    for first in range(0, n, CHUNK):
        part = sides[first : first + CHUNK]
        across = np.cross(part[:, one], part[:, two])
        length = np.linalg.norm(across, axis=2)
        across = np.concatenate([across, -across], axis=1) / np.tile(np.where(length > 0, length, 1.0), 2)[..., None]
        lean = (across @ part.swapaxes(1, 2)).max(axis=2, initial=-1.0)
        contact, normal = np.nonzero((lean <= LEAN) & (np.tile(length, 2) > LEAN))
        found[0].append(contact + first)
        found[1].append(across[contact, normal])
    owner, normal = np.concatenate(found[0]), np.concatenate(found[1])
    _, once = np.unique(np.column_stack([owner, normal.round(6)]), axis=0, return_index=True)
    return owner[once], normal[once]


def _directions(search: Search, row: Ints, feature: Ints) -> tuple[Ints, Floats]:
    """Directions in which a block goes on from an edge or a corner, turned round for the second block of a pair."""
    topo = search.topology
    edges, corners = np.flatnonzero(feature >= 0), np.flatnonzero(feature < 0)
    edge, corner = feature[edges], ~feature[corners]
    ends = search.assembly.vertices[topo.edge[edge]]
    along = (ends[:, 1] - ends[:, 0]) / np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[:, None]
    around = np.concatenate([np.stack([along, -along], axis=1), topo.inward[edge]], axis=1)
    which, spoke = members(topo.spoke_start[corner], np.diff(topo.spoke_start)[corner])
    owner = np.concatenate([np.repeat(edges, 4), corners[which]])
    direction = np.concatenate([around.reshape(-1, 3), topo.spoke[spoke]])
    return owner, direction * _signs(search, row, feature)[owner, None]


def _signs(search: Search, row: Ints, feature: Ints) -> Floats:
    """1 for the features of the first block of a pair, -1 for those of the second."""
    topo = search.topology
    start = np.where(feature >= 0, topo.edge[np.maximum(feature, 0), 0], topo.corner[np.maximum(~feature, 0)])
    return np.where(search.assembly.vertex_block[start] == search.pairs[row, 0], 1.0, -1.0)
