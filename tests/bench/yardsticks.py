"""What RigLens is measured against: the straightforward Numba solution, the published algorithm, numpy boxes.

All are written plainly on purpose; the walk of plain DDA is shared with the accuracy study.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numba
import numpy as np
import scipy.stats
from numpy.typing import NDArray

from riglens.core.kernels.rays.plain import walk_dense

Voxel = tuple[int, int, int]


@numba.njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _sum_dense(seen: NDArray[Any], h: NDArray[Any]) -> float:
    """Entropy of the seen voxels: one pass over the whole grid."""
    total = 0.0
    for i in range(seen.size):
        if seen[i]:
            total += h[i]
    return total


@numba.njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _sum_at_once(seen: NDArray[Any], words: NDArray[Any], h: NDArray[Any]) -> tuple[float, float, float]:
    """Entropy of the seen voxels for three classes: one pass, eight voxels at a time where none is seen."""
    a, b, c = 0.0, 0.0, 0.0
    for word in range(words.size):
        if words[word] == 0:
            continue
        for i in range(8 * word, 8 * word + 8):
            if seen[i]:
                a, b, c = a + h[i, 0], b + h[i, 1], c + h[i, 2]
    for i in range(8 * words.size, seen.size):
        if seen[i]:
            a, b, c = a + h[i, 0], b + h[i, 1], c + h[i, 2]
    return a, b, c


class PlainDda:
    """Plain DDA on one thread: dense bytes for the covered set, dense float32 entropies per class."""

    def __init__(self, entropies: list[NDArray[np.float32]]) -> None:
        self._h = [h.ravel() for h in entropies]
        self.seen = np.zeros(entropies[0].shape, np.uint8)

    def cast(
        self,
        origin: NDArray[np.float64],
        directions: NDArray[np.float64],
        reach: tuple[float, float] = (0.0, math.inf),
    ) -> None:
        """Mark what the rays traverse; origin (3,) in grid units, directions (n, 3), reach from and to in voxels."""
        walk_dense(origin, directions, *reach, 1, self.seen)

    def sums(self) -> list[float]:
        """Covered entropy per class in nat, one class after the other."""
        return [float(_sum_dense(self.seen.ravel(), h)) for h in self._h]

    def sums_at_once(self) -> list[float]:
        """Covered entropy per class in nat, as a competent program sums: all classes at once, skipping zeros."""
        seen = self.seen.ravel()
        return list(_sum_at_once(seen, seen[: seen.size // 8 * 8].view(np.uint64), self._woven))

    @cached_property
    def _woven(self) -> NDArray[np.float32]:
        """The entropies of all classes side by side, (voxels, 3)."""
        return np.stack(self._h, axis=1)

    def clear(self) -> None:
        """Forget what was seen."""
        self.seen[:] = 0


def published_points(start: Voxel, ends: set[str]) -> list[Voxel]:
    """Voxels of all lines from one voxel to ends "x;y;z", in one list, as the paper's program does it."""
    points: list[Voxel] = []
    for end in ends:
        x, y, z = (int(number) for number in end.split(";"))
        points.extend(published_line(start, (x, y, z)))
    return points


def published_line(start: Voxel, end: Voxel) -> list[Voxel]:
    """3D Bresenham in pure Python, one tuple per voxel."""
    cell = list(start)
    delta = [abs(e - s) for s, e in zip(start, end, strict=True)]
    step = [1 if e > s else -1 for s, e in zip(start, end, strict=True)]
    drive = delta.index(max(delta))
    error = [2 * d - delta[drive] for d in delta]
    voxels = [start]
    for _ in range(delta[drive]):
        for axis in range(3):
            if axis == drive:
                cell[axis] += step[axis]
                continue
            if error[axis] >= 0:
                cell[axis] += step[axis]
                error[axis] -= 2 * delta[drive]
            error[axis] += 2 * delta[axis]
        voxels.append((cell[0], cell[1], cell[2]))
    return voxels


def published_entropy(points: list[Voxel], probability: NDArray[Any]) -> float:
    """Sum of h over a list of voxels, each looked up and given to scipy, every meeting counted."""
    total = 0.0
    for point in points:
        p = probability[point]
        if p == 0.0 or p == 1.0:
            continue
        total += scipy.stats.entropy([1 - p, p])
    return total


class NumpyFill:
    """Boxes into counts of frames with numpy: for each box its voxel centres at once."""

    def __init__(
        self, shape: tuple[int, int, int], origin_m: tuple[float, float, float], voxel_m: float
    ) -> None:
        self.counts = np.zeros((3, *shape), np.uint32)
        self._last = np.full((3, *shape), -1, np.int32)
        self._origin_m, self._voxel_m = np.array(origin_m), voxel_m

    def fill(
        self, frame: int, cls: int, centre_m: NDArray[Any], size_m: NDArray[Any], rotation: NDArray[Any]
    ) -> None:
        """Count one box; a voxel counts once per frame and class."""
        reach_m = np.abs(rotation) @ (size_m / 2)
        low = np.floor((centre_m - reach_m - self._origin_m) / self._voxel_m - 0.5).astype(int)
        high = np.ceil((centre_m + reach_m - self._origin_m) / self._voxel_m + 0.5).astype(int)
        low, high = np.maximum(low, 0), np.minimum(high, self.counts.shape[1:])
        if (low >= high).any():
            return
        x, y, z = (
            self._origin_m[a] + (np.arange(low[a], high[a]) + 0.5) * self._voxel_m - centre_m[a]
            for a in range(3)
        )
        x, y, z = x[:, None, None], y[None, :, None], z[None, None, :]
        inside = np.ones(high - low, np.bool_)
        for axis in range(3):
            local = rotation[0, axis] * x + rotation[1, axis] * y + rotation[2, axis] * z
            inside &= np.abs(local) <= size_m[axis] / 2
        where: tuple[Any, ...] = (cls, *(slice(a, b) for a, b in zip(low, high, strict=True)))
        inside &= self._last[where] != frame
        self._last[where][inside] = frame
        self.counts[where] += inside
