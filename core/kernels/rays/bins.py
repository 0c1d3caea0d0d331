"""Rays that fit no table, in bins by their place in the image plane of a pinhole."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.runtime.jit import lean_inlined


class Bins(NamedTuple):
    """Rays by their place (y / x, z / x) in the image plane: corner (2,) of the first bin, bins per unit (2,), number
    of bins (2,), and the numbers and places (rays, 2) of the rays, bin by bin; those of a bin begin at first (bins +
    1,)."""

    corner: np.ndarray
    scale: np.ndarray
    sizes: np.ndarray
    first: np.ndarray
    rays: np.ndarray
    places: np.ndarray


@lean_inlined
def bin_of(bins: Bins, axis: int, place: float) -> int:
    """Return the bin of a place along one axis of the image plane, at most one before the first or after the last."""
    number = np.floor((place - bins.corner[axis]) * bins.scale[axis])
    return int(min(max(number, -1.0), float(bins.sizes[axis])))


@lean_inlined
def bins_around(bins: Bins, axis: int, low: float, high: float) -> tuple[int, int]:
    """Return the first and the last bin between two places along one axis; for places outside all bins the nearest
    ones."""
    last = bins.sizes[axis] - 1
    return min(max(bin_of(bins, axis, low), 0), last), min(max(bin_of(bins, axis, high), 0), last)
