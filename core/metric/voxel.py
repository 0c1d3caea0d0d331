"""Describe one voxel: its place, the probability of each class, and the voxel that a click on a display cell means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.metric.entropy import entropy_of_counts
from riglens.core.scene.columns import Words, words_per_column
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog

Voxel = tuple[int, int, int]
"""Indices along x, y, z of a voxel of the grid."""
Points = NDArray[np.float64]


@dataclass(frozen=True)
class VoxelFacts:
    """Figures of a voxel in the POG: centre (metres, vehicle frame), p and h (nat) per class of CLASSES."""

    voxel: Voxel
    centre_m: Vec3
    p: tuple[float, ...]
    h_nat: tuple[float, ...]

    @property
    def is_informative(self) -> bool:
        """Return whether it can change a score: h > 0 for some class."""
        return any(h > 0.0 for h in self.h_nat)


def word_and_bit(grid: VoxelGrid, voxel: Voxel) -> tuple[int, int]:
    """Return the number of the word that holds a voxel, and its bit as a number."""
    ix, iy, iz = voxel
    return (ix * grid.shape[1] + iy) * words_per_column(grid) + iz // 64, 1 << (iz % 64)


def voxel_facts(pog: Pog, voxel: Voxel) -> VoxelFacts:
    """Return the position, p and h of a voxel; p = 0 everywhere where no box ever was."""
    counts = pog.counts_of(*word_and_bit(pog.grid, voxel)).astype(np.int64)
    frames = max(pog.data.frames, 1)
    x, y, z = (float(pog.grid.centres_m(axis)[place]) for axis, place in enumerate(voxel))
    h_nat = tuple(float(h) for h in entropy_of_counts(counts, frames))  # type: ignore[arg-type]
    return VoxelFacts(voxel, (x, y, z), tuple(float(count) / frames for count in counts), h_nat)


def voxel_in_cell(
    pog: Pog,
    cls: int,
    centre_m: Points,
    cell_m: float,
    ray: tuple[Points, Points],
    meant: Words | None = None,
) -> Voxel | None:
    """Return the voxel of a display cell (its centre (3,) and edge) that a ray, origin and direction (3,), passes
    nearest.

    Voxels that the class was in come first; of a cell without any the nearest voxel is taken. With `meant`, words of
    the voxels that a click may mean, it is one of those and uncertain for the class; None when there is none, or when
    the cell lies outside the grid.
    """
    grid = pog.grid
    low = np.rint((centre_m - cell_m / 2 - np.array(grid.origin_m)) / grid.voxel_m).astype(np.int64)
    block = max(1, round(cell_m / grid.voxel_m))
    ranges = [np.arange(max(0, at), min(at + block, n)) for at, n in zip(low, grid.shape, strict=True)]
    voxels = np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, 3)
    listed = [(int(i), int(j), int(k)) for i, j, k in voxels]
    if meant is None:
        fits = [_count(pog, cls, voxel) > 0 for voxel in listed]
    else:
        fits = [_is_in(meant, grid, voxel) and _is_uncertain(pog, cls, voxel) for voxel in listed]
    if not listed or (meant is not None and not any(fits)):
        return None
    if any(fits):
        voxels = voxels[fits]
    origin, direction = ray
    offset = np.array(grid.origin_m) + (voxels + 0.5) * grid.voxel_m - origin
    beside = np.linalg.norm(offset - (offset @ direction)[:, None] * direction, axis=1)
    i, j, k = voxels[np.lexsort((offset @ direction, np.round(beside / grid.voxel_m, 6)))[0]]
    return int(i), int(j), int(k)


def _count(pog: Pog, cls: int, voxel: Voxel) -> int:
    return int(pog.counts_of(*word_and_bit(pog.grid, voxel))[cls])


def _is_uncertain(pog: Pog, cls: int, voxel: Voxel) -> bool:
    """Return whether h > 0: the class is present in some frames and absent in others."""
    return 0 < _count(pog, cls, voxel) < pog.data.frames


def _is_in(words: Words, grid: VoxelGrid, voxel: Voxel) -> bool:
    word, bit = word_and_bit(grid, voxel)
    return bool(int(words[word]) & bit)
