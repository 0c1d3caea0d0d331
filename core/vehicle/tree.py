"""Build the tree of boxes around triangles, a level at a time; loads the compiler."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.body.solid import GROWN, Tree

LEAF = 4
"""Triangles in a leaf of the tree at most."""
Numbers = NDArray[np.int64]


def tree_of(corners: NDArray[np.float64]) -> Tree:
    """Return the tree of triangles (t, 3, 3), split at the median along the longest side until few are left."""
    count = len(corners)
    low, high, order = corners.min(axis=1), corners.max(axis=1), np.arange(count)
    nodes = _nodes_of(count) if count else 0
    bounds, leaf, skip = np.empty((nodes, 6)), np.empty((nodes, 2), np.int64), np.empty(nodes, np.int64)
    node, first, size = (np.full(min(count, 1), value, np.int64) for value in (0, 0, count))
    while node.size:
        bounds[node, :3] = _of_each(np.minimum, low[order], first, size) - GROWN
        bounds[node, 3:] = _of_each(np.maximum, high[order], first, size) + GROWN
        leaf[node, 0], leaf[node, 1] = first, np.where(size <= LEAF, size, 0)
        skip[node] = node + _nodes_of_each(size)
        node, first, size = (of_node[size > LEAF] for of_node in (node, first, size))
        longest = np.argmax(bounds[node, 3:] - bounds[node, :3], axis=1)
        _sort(low + high, longest, first, size, order)
        half = size // 2
        node = _in_turn(node + 1, node + 1 + _nodes_of_each(half))
        first, size = _in_turn(first, first + half), _in_turn(half, size - half)
    return Tree(corners[order], order, bounds, leaf, skip)


@cache
def _nodes_of(count: int) -> int:
    """Return the number of nodes of a tree of triangles."""
    return 1 if count <= LEAF else 1 + _nodes_of(count // 2) + _nodes_of(count - count // 2)


def _nodes_of_each(sizes: Numbers) -> Numbers:
    distinct, which = np.unique(sizes, return_inverse=True)
    return np.array([_nodes_of(int(size)) for size in distinct], np.int64)[which]


def _of_each(
    best: np.ufunc, corners: NDArray[np.float64], first: Numbers, size: Numbers
) -> NDArray[np.float64]:
    """Return the lowest or highest corner (k, 3) of the triangles of each node, whose places ascend."""
    ends = np.append(corners, corners[:1], axis=0)  # a place behind the last
    return np.asarray(best.reduceat(ends, _in_turn(first, first + size))[::2])


def _sort(middle: NDArray[np.float64], axis: Numbers, first: Numbers, size: Numbers, order: Numbers) -> None:
    """Sort the triangles of each node along its axis; equal ones keep their order."""
    node = np.repeat(np.arange(len(size)), size)
    places = np.arange(len(node)) + np.repeat(first - np.cumsum(size) + size, size)
    chosen = order[places]
    order[places] = chosen[np.lexsort((middle[chosen, axis[node]], node))]


def _in_turn(one: Numbers, other: Numbers) -> Numbers:
    """Return numbers of two arrays (k,) in turn, (2 k,)."""
    return np.stack([one, other], axis=1).ravel()
