"""Entropies of the informative voxels as fixed-point integers, so that sums do not depend on their order.

h = -p ln p - (1 - p) ln(1 - p) <= ln 2 nat is stored as round(h * 2^32) in 32 bits: the error of a voxel is at
most 2^-33 nat (1.2e-10), of a sum over n voxels at most n * 2^-33 nat (0.009 nat for 76.8 M voxels).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.voxels import bits
from riglens.core.kernels.voxels.entropy_codes import Entropies, Runs
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.scene.columns import Counts, VoxelIndex, codes_of
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog

QUANTA_PER_NAT = 1 << 32


def entropy_of_counts(counts: Counts, frames: int) -> NDArray[np.float64]:
    """Return h in nat (the terms of eq. 13) of counts out of `frames`, in their shape; 0 where p is 0 or 1."""
    h = np.zeros(counts.shape)
    between = (counts > 0) & (counts < frames)
    p = counts[between] / frames
    h[between] = -p * np.log(p) - (1.0 - p) * np.log1p(-p)
    return h


def nats(quanta: int) -> float:
    """Return the fixed-point entropy as a double, correctly rounded."""
    return int(quanta) / QUANTA_PER_NAT


@dataclass(frozen=True)
class EntropyField:
    """Informative voxels (h > 0 for some class) and their entropies, in units of 2^-32 nat.

    Voxels share few combinations of counts, neighbours in a column often the same: `runs` tells the row of
    `entropies_q` uint32 (m, 4) with the entropies of the three classes (the fourth entry is 0); frequent rows come
    first.
    """

    grid: VoxelGrid
    index: VoxelIndex
    runs: Runs
    entropies_q: NDArray[np.uint32]
    data: DataReport
    totals_q: tuple[int, ...]

    @classmethod
    def from_pog(cls, pog: Pog) -> EntropyField:
        """Make the entropies of a POG; voxels that are never or always occupied, for every class, drop out."""
        frames, rows = pog.data.frames, pog.rows
        is_informative = np.asarray(((rows > 0) & (rows < frames)).any(axis=1))
        if not is_informative.all():
            codes = pog.codes()
            keep, words = is_informative[codes], pog.index.words.copy()
            bits.keep_flagged(words, keep)
            pog = Pog.of(pog.grid, pog.data, VoxelIndex.of(pog.grid, words), rows[codes[keep]])
        entropies_q = np.zeros((len(pog.rows), 4), np.uint32)
        entropies_q[:, :3] = np.rint(entropy_of_counts(pog.rows, frames) * QUANTA_PER_NAT).astype(np.uint32)
        totals = tuple(int(total) for total in pog.uses @ entropies_q[:, :3].astype(np.int64))
        return cls(pog.grid, pog.index, pog.runs, entropies_q, pog.data, totals)

    @property
    def entropies(self) -> Entropies:
        """The informative voxels and their entropies as the kernels take them."""
        return Entropies(self.index.words, *self.runs, self.entropies_q)

    def codes(self) -> NDArray[np.unsignedinteger[Any]]:
        """Return the row of the palette of every informative voxel, (n,); a new array each time."""
        return codes_of(self.index, self.runs)

    def entropy_q(self, cls: int) -> NDArray[np.uint32]:
        """Return h of the informative voxels for one class of CLASSES in units of 2^-32 nat, (n,); a new array each
        time."""
        result: NDArray[np.uint32] = np.ascontiguousarray(self.entropies_q[:, cls])[self.codes()]
        return result

    def entropy_nat(self, cls: int) -> NDArray[np.float64]:
        """Return h in nat of the informative voxels for one class of CLASSES, (n,)."""
        result: NDArray[np.float64] = self.entropy_q(cls) / QUANTA_PER_NAT
        return result

    def h_total_nat(self, cls: int) -> float:
        """Return H(Omega) of one class of CLASSES in nat (paper, eq. 13)."""
        return nats(self.totals_q[cls])


assert len(CLASSES) == 3  # the kernels sum three classes side by side
