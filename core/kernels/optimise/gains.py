"""Gains of candidates over cells that are covered already. All values are integers: any order gives the same sums."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import kernel, lean, parallel_kernel
from riglens.core.kernels.voxels.bits import popcount


class Cover(NamedTuple):
    """Cells of n candidates on o objects, e different cells in all.

    Candidate c has the runs starts[c] to starts[c + 1]; run r has the cells ends[r] to ends[r + 1] of object `of[r]`.
    worth (rows, most + 1): value of an object with that many cells, by row[o]; more cells than `most` add nothing.
    """

    starts: np.ndarray
    of: np.ndarray
    ends: np.ndarray
    cells: np.ndarray
    worth: np.ndarray
    row: np.ndarray


@lean
def _gain(cover: Cover, one: int, covered: np.ndarray, known: np.ndarray) -> int:
    total, most = 0, cover.worth.shape[1] - 1
    for run in range(cover.starts[one], cover.starts[one + 1]):
        new = 0
        for place in range(cover.ends[run], cover.ends[run + 1]):
            new += covered[cover.cells[place]] == 0
        if new:
            thing = cover.of[run]
            worth, before = cover.worth[cover.row[thing]], known[thing]
            total += worth[min(before + new, most)] - worth[min(before, most)]
    return int(total)


@kernel
def gains(
    cover: Cover, ids: np.ndarray, covered: np.ndarray, known: np.ndarray, share: int, shares: int, to: np.ndarray
) -> None:  # fmt: skip
    """Write what each candidate of a share adds to covered cells (e,) and to the cells known of objects (o,)."""
    for place in range(share, ids.size, shares):
        to[place] = _gain(cover, ids[place], covered, known)


class Fused(NamedTuple):
    """Hits of n candidates on o objects, each of which is found with the chance 1 - (1 - L)(1 - C): L by its number of
    points and cells, from curve (rows, most + 1), C the largest of the chances of sensors by themselves.

    Candidate c has the runs starts[c] to starts[c + 1]; run r has points[r], the cells ends[r] to ends[r + 1] and
    chance[r] of object `of[r]`. row, weight (o,): of objects, the weight in integers for a chance of 1.
    """

    starts: np.ndarray
    of: np.ndarray
    ends: np.ndarray
    cells: np.ndarray
    points: np.ndarray
    chance: np.ndarray
    curve: np.ndarray
    row: np.ndarray
    weight: np.ndarray


@lean
def _fused_gain(
    fused: Fused, one: int, covered: np.ndarray, known: np.ndarray, chance: np.ndarray, worth: np.ndarray
) -> int:
    total, most = 0, fused.curve.shape[1] - 1
    for run in range(fused.starts[one], fused.starts[one + 1]):
        thing = fused.of[run]
        count = known[thing] + fused.points[run]
        for place in range(fused.ends[run], fused.ends[run + 1]):
            count += covered[fused.cells[place]] == 0
        missed = 1.0 - fused.curve[fused.row[thing], min(count, most)]
        missed *= 1.0 - max(chance[thing], fused.chance[run])
        total += int(np.rint(fused.weight[thing] * (1.0 - missed))) - worth[thing]
    return int(total)


@kernel
def fused_gains(
    fused: Fused,
    ids: np.ndarray,
    covered: np.ndarray,
    known: np.ndarray,
    chance: np.ndarray,
    worth: np.ndarray,
    share: int,
    shares: int,
    to: np.ndarray,
) -> None:
    """Write what each candidate of a share adds to covered cells (e,), and to objects (o,) with numbers that are known,
    chances of other sensors and worth."""
    for place in range(share, ids.size, shares):
        to[place] = _fused_gain(fused, ids[place], covered, known, chance, worth)


@kernel
def change(cover: Cover, one: int, by: int, covered: np.ndarray, known: np.ndarray) -> None:
    """Add a candidate (by = 1), or take it away again (by = -1)."""
    for run in range(cover.starts[one], cover.starts[one + 1]):
        for place in range(cover.ends[run], cover.ends[run + 1]):
            cell = cover.cells[place]
            if by > 0:
                known[cover.of[run]] += covered[cell] == 0
            covered[cell] += by
            if by < 0:
                known[cover.of[run]] -= covered[cell] == 0


@kernel
def add_shares(cover: Cover, shares: np.ndarray, to: np.ndarray) -> None:
    """Add the shares of candidates (n,) up over the cells (e,) that they hit."""
    for one in range(shares.size):
        if shares[one] > 0.0:
            for place in range(cover.ends[cover.starts[one]], cover.ends[cover.starts[one + 1]]):
                to[cover.cells[place]] += shares[one]


@parallel_kernel
def slopes(cover: Cover, sums: np.ndarray, slope: np.ndarray, workers: int, to: np.ndarray) -> None:
    """Write a supergradient (n,) at cells' sums (e,), from the slopes of objects (o,)."""
    for worker in numba.prange(workers):
        for one in range(worker, to.size, workers):
            total = 0.0
            for run in range(cover.starts[one], cover.starts[one + 1]):
                new = 0
                for place in range(cover.ends[run], cover.ends[run + 1]):
                    new += sums[cover.cells[place]] < 1.0
                total += slope[cover.of[run]] * new
            to[one] = total


@kernel
def mark_runs(cover: Cover, first: np.ndarray, starts: np.ndarray, to: np.ndarray) -> None:
    """Set a bit for each cell of each run r, counted from the first cell (o,) of its object, in the words from
    starts[r] on."""
    for run in range(cover.of.size):
        begin = first[cover.of[run]]
        for place in range(cover.ends[run], cover.ends[run + 1]):
            at = cover.cells[place] - begin
            to[starts[run] + (at >> 6)] |= np.uint64(1) << np.uint64(at & 63)


@parallel_kernel
def losses(
    cover: Cover,
    known: np.ndarray,
    group: np.ndarray,
    runs: np.ndarray,
    begins: np.ndarray,
    owner: np.ndarray,
    starts: np.ndarray,
    bits: np.ndarray,
    workers: int,
    to: np.ndarray,
) -> None:
    """Add up the overlap of each pair, both gains minus their joint gain, and the gain of each candidate, by group (o,)
    of objects: to[g, a, b] for b <= a, int64 (groups, n, n).

    runs: by object o those from begins[o] to begins[o + 1], of rising candidates; owner (runs,): their candidates;
    starts and bits: see `mark_runs`.
    """
    most = cover.worth.shape[1] - 1
    for worker in numba.prange(workers):
        for thing in range(known.size):
            worth, before = cover.worth[cover.row[thing]], known[thing]
            for place in range(begins[thing], begins[thing + 1]):
                run = runs[place]
                one = owner[run]
                if one % workers != worker:
                    continue
                mine, start = cover.ends[run + 1] - cover.ends[run], starts[run]
                gain = worth[min(before + mine, most)] - worth[min(before, most)]
                to[group[thing], one, one] += gain
                for other_place in range(begins[thing], place):
                    other = runs[other_place]
                    together = before + mine + cover.ends[other + 1] - cover.ends[other]
                    theirs = worth[min(together - mine, most)]
                    for word in range(starts[run + 1] - start):
                        together -= int(popcount(bits[start + word] & bits[starts[other] + word]))
                    to[group[thing], one, owner[other]] += gain - (worth[min(together, most)] - theirs)


@kernel
def number_cells(
    starts: np.ndarray,
    counts: np.ndarray,
    keys: np.ndarray,
    base: np.ndarray,
    low: np.ndarray,
    span: np.ndarray,
    to: np.ndarray,
) -> bool:
    """Number the cells of objects (m,), three packed indices each, within the objects' blocks: lowest cells low (m, 3),
    cells along the axes span (m, 3), first number base (m,). False where one lies outside of its block."""
    filled, inside = 0, True
    for thing in range(starts.size):
        for place in range(starts[thing], starts[thing] + counts[thing]):
            key = keys[place]
            i = (key >> 42) - low[thing, 0]
            j = ((key >> 21) & 0x1FFFFF) - low[thing, 1]
            k = (key & 0x1FFFFF) - low[thing, 2]
            inside &= 0 <= i < span[thing, 0] and 0 <= j < span[thing, 1] and 0 <= k < span[thing, 2]
            to[filled] = base[thing] + (i * span[thing, 1] + j) * span[thing, 2] + k
            filled += 1
    return inside
