"""Runs of neighbouring voxels that share one row of a table: far fewer than voxels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.voxels import entropy_codes
from riglens.core.kernels.voxels.entropy_codes import Runs
from riglens.core.scene.columns import VoxelIndex, Words

Rows = NDArray[np.uint16] | NDArray[np.uint32]


def runs_of(words: Words, rows: Rows) -> tuple[Runs, Rows, NDArray[np.int64]]:
    """Return runs of equal rows (voxels, 3) of the voxels of a set, the distinct rows (m, 3), most frequent first, and
    the number of voxels of each (m,)."""
    starts, first = np.empty(len(words), np.uint64), np.empty(len(words) + 1, np.uint32)
    numbers = np.empty(entropy_codes.find_runs(words, rows, starts, first), np.uint32)
    most = 1 << 16
    while True:
        firsts, uses = np.zeros(most, np.int64), np.zeros(most, np.int64)
        slots = np.full(2 * most, entropy_codes.EMPTY, np.int64)
        found = entropy_codes.number_runs(
            words, starts, rows, entropy_codes.Numbering(numbers, firsts, uses, slots)
        )
        if found >= 0:
            break
        most *= 4
    order = np.argsort(-uses[:found], kind="stable")
    ranks = np.empty(found, np.uint32)
    ranks[order] = np.arange(found, dtype=np.uint32)
    codes = np.empty(len(numbers), np.uint16) if found <= 1 << 16 else numbers
    entropy_codes.renumber(numbers, ranks, codes)
    return Runs(starts, first, codes), rows[firsts[:found][order]], uses[order]


def codes_of(index: VoxelIndex, runs: Runs) -> NDArray[np.unsignedinteger[Any]]:
    """Return the number of the row of every voxel, (n,); a new array each time."""
    codes = np.empty(index.count, runs.codes.dtype)
    entropy_codes.voxel_codes(index.words, runs.starts, runs.codes, codes)
    return codes
