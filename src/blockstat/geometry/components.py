"""Connected components of graphs given by their edges."""

from __future__ import annotations

import numpy as np

from blockstat.typing import Ints


def connected_components(n_nodes: int, edges: Ints) -> tuple[int, Ints]:
    """Return how many components a graph has, and the component of each node.

    Parameters
    ----------
    n_nodes : int
        Number of nodes.
    edges : array of int, shape (n_edges, 2)
        The two nodes of each edge, in any order.

    Returns
    -------
    count : int
        Number of components; a node without an edge is one.
    label : array of int, shape (n_nodes,)
        Component of each node, numbered from 0 in the order of their first nodes.
    """
    from scipy import sparse
    from scipy.sparse import csgraph

    edges = np.asarray(edges).reshape(-1, 2)
    graph = sparse.coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n_nodes, n_nodes))
    count, label = csgraph.connected_components(graph, directed=False)
    return int(count), label
