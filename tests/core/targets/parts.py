"""The parts of boxes in plain arrays, by a loop over boxes: what kernels work out for one part at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.targets.shapes import LOW_M, SHAPES, TALL_M, Part, Shape, kind_numbers

Doubles = NDArray[np.float64]
Kinds = Sequence[Sequence[tuple[Part, ...]]]


class Parts(NamedTuple):
    """Parts of n boxes, m in all: starts (n + 1,), box (m,), offset and half size (m, 3) in metres, is_glass (m,)."""

    starts: NDArray[np.int64]
    box: NDArray[np.int64]
    offset_m: Doubles
    half_m: Doubles
    is_glass: NDArray[np.bool_]


def parts_of(shape: Shape, cls: NDArray[np.uint8], size_m: Doubles) -> Parts:
    """Parts of boxes of classes (n,), as in Traffic, and sizes (n, 3) in metres."""
    return parts_by_kind(SHAPES, kind_numbers(shape, cls, size_m), size_m)


def parts_by_kind(kinds: Kinds, number: NDArray[np.uint8], size_m: Doubles) -> Parts:
    """Parts of boxes of kinds with these numbers (n,)."""
    box, bounds, glass = list[int](), list[Doubles](), list[bool]()
    for place, (one, size) in enumerate(zip(number.tolist(), size_m, strict=True)):
        share = np.clip((size[2] - LOW_M) / (TALL_M - LOW_M), 0.0, 1.0)
        for low, tall in zip(kinds[one][0], kinds[one][-1], strict=True):
            own, other = (
                np.array([[(a + b) / 2.0, (b - a) / 2.0] for a, b in (part.x, part.y, part.z)]).T * size / 2.0
                for part in (low, tall)
            )
            box.append(place)
            bounds.append(own + share * (other - own))
            glass.append(low.is_glass)
    starts = np.searchsorted(box, np.arange(len(size_m) + 1))
    both = np.array(bounds).reshape(-1, 2, 3)
    return Parts(starts, np.array(box, np.int64), both[:, 0], both[:, 1], np.array(glass, np.bool_))
