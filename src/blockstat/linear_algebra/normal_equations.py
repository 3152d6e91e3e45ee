"""Normal equations of a conic program whose rows each touch two blocks.

Every row of the constraint belongs to one contact point and has entries in the columns of its two blocks only, so

    S = sum over rows t of t t'

is a matrix of small blocks with the pattern of the contact graph: one block a pair of touching blocks and one on the
diagonal for each. The pattern, its ordering and the places of all entries are found once; each update is a batched
product and a numeric factorisation.
"""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Iterator
from weakref import WeakValueDictionary

import numpy as np
from scipy import sparse

from blockstat.linear_algebra.factor import Factor, make_factor
from blockstat.typing import Floats, Ints

#: Added to the diagonal relative to itself: a block that turns freely about two points leaves S singular.
REGULARISATION = 1e-15
#: Rows multiplied at a time.
CHUNK = 8_000
#: Normal equations kept for the next program with the same rows, and the most blocks of one worth keeping.
KEPT, KEPT_BLOCKS = 6, 20_000


class _Known(threading.local):
    """What one thread keeps: graphs as long as somebody uses them, normal equations for the next program."""

    def __init__(self) -> None:
        self.graphs: WeakValueDictionary[tuple, _Graph] = WeakValueDictionary()
        self.normals: OrderedDict[tuple, BlockNormal] = OrderedDict()


known = _Known()


def normal_equations(pair: Ints, n_blocks: int, width: int) -> BlockNormal:
    """Return the normal equations of rows that each touch two blocks.

    Parameters
    ----------
    pair
        Blocks a and b of each row, -1 for a support, shape (n_rows, 2).
    n_blocks
        The number of blocks.
    width
        Unknowns a block.

    Returns
    -------
    BlockNormal
        That of an earlier program of this thread with the same rows, if there is one: its ordering is known.
    """
    key = (n_blocks, width, _digest(pair))
    normal = known.normals.pop(key, None) or BlockNormal(pair, n_blocks, width)
    if n_blocks <= KEPT_BLOCKS:
        known.normals[key] = normal
        while len(known.normals) > KEPT:
            known.normals.popitem(last=False)
    return normal


def _digest(index: Ints) -> bytes:
    return hashlib.sha256(np.ascontiguousarray(index).tobytes()).digest()


class BlockNormal:
    """S of some rows: each of a pair of blocks, `width` unknowns a block.

    Normal equations with the same touching blocks share one graph and so one factor: each is good until another is
    updated, and says so.
    """

    def __init__(self, pair: Ints, n_blocks: int, width: int) -> None:
        """Take the blocks a and b of each row, shape (n_rows, 2), -1 for a support."""
        low, high = np.minimum(pair[:, 0], pair[:, 1]), np.maximum(pair[:, 0], pair[:, 1])
        key = (low + 1) * (n_blocks + 1) + high + 1
        _, first, member, count = np.unique(key, return_index=True, return_inverse=True, return_counts=True)
        # Pairs with as many rows stand together, so that each batch is one product of stacked matrices.
        by_count = np.lexsort((first, count))
        rank = np.empty_like(by_count)
        rank[by_count] = np.arange(len(by_count))
        order = np.argsort(rank[member], kind="stable")
        self._chunks = [(size, low, high, _span(rows)) for size, low, high, rows in _chunks(count[by_count], order)]
        pairs = pair[first[by_count]]
        #: Rows that name their two blocks in the other order than the first row of these blocks.
        self._turned = np.flatnonzero(pair[:, 0] != pair[first[member], 0])
        name = (n_blocks, width, _digest(pairs))
        graph = known.graphs.get(name)
        if graph is None:
            graph = known.graphs[name] = _Graph(pairs, n_blocks, width)
        self._graph = graph

    def update(self, rows: Floats, ridge: float = 0.0) -> None:
        """Form and factor S + ridge I.

        Parameters
        ----------
        rows
            Entries of each row in the columns of its blocks, shape (n_rows, 2 width).
        ridge
            Added to the diagonal.

        Raises
        ------
        ArithmeticError
            When the factorisation fails.
        """
        graph = self._graph
        w = graph.width
        if len(self._turned):
            rows = rows.copy()
            rows[self._turned] = np.roll(rows[self._turned], w, axis=1)
        for count, first, last, where in self._chunks:
            part = rows[where] if isinstance(where, slice) else np.take(rows, where, axis=0)
            part = part.reshape(last - first, count, 2 * w)
            # Of one array and its own transpose numpy would fill in the symmetry, which costs more than the product.
            product = np.matmul(part.swapaxes(1, 2), part.copy())
            graph.own[0, first:last], graph.own[1, first:last] = product[:, :w, :w], product[:, w:, w:]
            graph.across[first:last] = product[:, :w, w:]
        graph.holder = self
        graph.refactor(ridge)

    def solve(self, right: Floats) -> Floats:
        """Return S^-1 times one or more right-hand sides.

        Parameters
        ----------
        right
            Shape (n,) or (n, k).

        Returns
        -------
        Floats
            Of the same shape.

        Raises
        ------
        RuntimeError
            When another program with the same graph has been factored since.
        """
        if self._graph.holder is not self:
            raise RuntimeError("these normal equations were updated by another program")
        return self._graph.factor.solve(right)


class _Graph:
    """The pattern of S: one block a pair of touching blocks and one on the diagonal for each, and its factor."""

    def __init__(self, pairs: Ints, n_blocks: int, width: int) -> None:
        """Take the pairs of blocks a and b, shape (n_pairs, 2), -1 for a support, no two the same."""
        self._pairs, self.width, self._n = pairs, width, n_blocks
        self._upper, self._place = self._pattern()
        self._sum = self._diagonal_sum()
        # Kept from one update to the next: fresh memory costs more than what is written to it.
        self._values = np.empty((n_blocks + len(pairs), width, width))
        self.own = np.empty((2, len(pairs), width, width))  #: products of a with a and of b with b
        self.across = self._values[n_blocks:]  #: products of a with b
        self.factor: Factor = make_factor()
        self.holder: BlockNormal | None = None

    def refactor(self, ridge: float) -> None:
        """Factor what `own` and `across` hold now."""
        w = self.width
        diagonal = self._values[: self._n].reshape(self._n, w * w)
        diagonal[:] = self._sum @ self.own.reshape(-1, w * w)
        middle = np.arange(w) * (w + 1)
        scale = float(np.max(diagonal[:, middle], initial=1e-300))
        diagonal[:, middle] += ridge + REGULARISATION * diagonal[:, middle] + REGULARISATION**2 * scale
        np.take(self._values.reshape(-1), self._place, out=self._upper.data, mode="clip")  # "raise" would copy
        self.factor.update(self._upper)

    def _pattern(self) -> tuple[sparse.csr_array, Ints]:
        """The upper triangle with its entries' places among the values: blocks of the diagonal, then one a pair."""
        n, w = self._n, self.width
        both = np.flatnonzero((self._pairs >= 0).all(axis=1))
        low, high = np.sort(self._pairs[both], axis=1).T
        order = np.lexsort((high, low))
        low, high, both = low[order], high[order], both[order]
        turned = self._pairs[both, 0] > low  # what is kept of a with b is needed of b with a
        degree = np.bincount(low, minlength=n)
        after = np.arange(len(low)) - (np.cumsum(degree) - degree)[low]  # blocks before it in its row
        block, side = np.arange(n), np.arange(w)
        count = w * degree[:, None] + w - side
        start = np.concatenate([[0], np.cumsum(count)])
        column, place = np.empty(start[-1], dtype=np.int64), np.empty(start[-1], dtype=np.int64)
        for k in range(w):
            own = start[w * block + k][:, None] + side[: w - k]
            column[own] = (w * block)[:, None] + side[k:]
            place[own] = (w * w * block + w * k)[:, None] + side[k:]
            across = (start[w * low + k] + w - k + w * after)[:, None] + side
            column[across] = (w * high)[:, None] + side
            place[across] = (w * w * (n + both))[:, None] + np.where(turned[:, None], w * side + k, w * k + side)
        return sparse.csr_array((np.zeros(len(place)), column, start), shape=(n * w, n * w)), place

    def _diagonal_sum(self) -> sparse.csr_array:
        """Sums the products of a and of b of all pairs into the diagonal blocks."""
        side = np.concatenate(self._pairs.T)
        live = np.flatnonzero(side >= 0)
        return sparse.csr_array((np.ones(len(live)), (side[live], live)), shape=(self._n, len(side)))


def _chunks(count: Ints, order: Ints) -> Iterator[tuple[int, int, int, Ints]]:
    """Pairs with as many rows, few enough that these stay in the cache: rows of each, first and last pair, the rows."""
    sizes, starts = np.unique(count, return_index=True)
    ends = np.append(starts, len(count))[1:]
    done = 0
    for size, start, end in zip(sizes.tolist(), starts.tolist(), ends.tolist(), strict=True):
        step = max(CHUNK // size, 1)
        for first in range(start, end, step):
            last = min(first + step, end)
            taken = size * (last - first)
            yield size, first, last, order[done : done + taken]
            done += taken


def _span(rows: Ints) -> Ints | slice:
    """Rows that follow on each other as a slice, which needs no copy."""
    whole = (np.diff(rows) == 1).all()
    return slice(int(rows[0]), int(rows[-1]) + 1) if whole else rows
