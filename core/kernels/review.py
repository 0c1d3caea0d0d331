"""What a safety review asks of the voxels that sensors traverse, and of single objects that stand beside the car.

The lowest level of each column that sensors look into; the entropy that is lost with each sensor, each
pair and each group of sensors, by bits that count in parallel; rays that meet upright cylinders. Sums are integers, so
neither the order of the sensors nor the number of workers matters.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.bits import first_run, lowest_bit, popcount
from riglens.core.kernels.cast import Cast
from riglens.core.kernels.jit import inlined, kernel, lean, lean_inlined, parallel_kernel
from riglens.core.kernels.lattice import direction, rotated
from riglens.core.kernels.palette import Entropies
from riglens.core.kernels.predicates import Vector

AT_LEAST_3, TWO_KINDS = range(2)
"""Rows of the sums of what is covered: by three sensors or more, by cameras and LiDARs."""
COLUMNS = 4
"""Columns of all sums: the entropies of three classes in units of 2^-32 nat, and one that stays 0, because four numbers
are added at once."""


@parallel_kernel
def lowest_levels(
    stack: np.ndarray,
    slots: np.ndarray,
    keep: np.ndarray,
    depth: int,
    none: int,
    workers: int,
    lowest: np.ndarray,
) -> None:
    """Write the lowest level that each slot holds in each column, uint16 (n, columns); `none` where it holds none.

    stack uint64 (rows, words): sets of voxels, of which slots (n,) count, within keep (words,); depth: words of a
    column.
    """
    columns = lowest.shape[1]
    for worker in numba.prange(workers):
        begin, end = columns * worker // workers, columns * (worker + 1) // workers
        for i in range(slots.size):
            for column in range(begin, end):
                found = none
                for part in range(depth - 1, -1, -1):
                    word = stack[slots[i], column * depth + part] & keep[column * depth + part]
                    if word != 0:
                        found = 64 * part + int(lowest_bit(word))
                lowest[i, column] = found


@lean_inlined
def _sink(row: np.ndarray, first: np.ndarray, second: np.ndarray) -> None:
    """Put the levels of a row among the two lowest of each of its columns; without a branch, many columns at once."""
    for i in range(np.uint64(row.size)):
        level, best = row[i], first[i]
        second[i] = min(second[i], max(best, level))
        first[i] = min(best, level)


@lean_inlined
def _around(levels: np.ndarray, ix: int, offsets: np.ndarray, row: np.ndarray) -> None:
    """Lower each column of a row (ny,) to the lowest level (nx, ny) around it."""
    nx, ny = levels.shape
    for k in range(offsets.shape[0]):
        x, step = ix + offsets[k, 0], offsets[k, 1]
        if 0 <= x < nx and abs(step) < ny:
            to, of = row[max(0, -step) : ny - max(0, step)], levels[x, max(0, step) : ny - max(0, -step)]
            for i in range(np.uint64(to.size)):
                to[i] = min(to[i], of[i])


@parallel_kernel
def two_lowest(
    lowest: np.ndarray, kinds: np.ndarray, offsets: np.ndarray, none: int, workers: int, both: np.ndarray
) -> None:
    """Write the lowest and the second lowest of the sensors' levels around each column, uint16 (3, 2, nx, ny): of all
    sensors, of kind 0 and of kind 1; `none` where there is no such sensor.

    lowest uint16 (n, nx, ny): as `lowest_levels` writes; kinds (n,) 0 or 1; offsets (m, 2): which columns count as
    around one, by steps along x and y.
    """
    count, nx, ny = lowest.shape
    for worker in numba.prange(workers):
        row = np.empty(ny, np.uint16)
        for ix in range(nx * worker // workers, nx * (worker + 1) // workers):
            both[:, :, ix, :] = none
            for i in range(count):
                row[:] = none
                _around(lowest[i], ix, offsets, row)
                _sink(row, both[0, 0, ix], both[0, 1, ix])
                _sink(row, both[1 + kinds[i], 0, ix], both[1 + kinds[i], 1, ix])


@lean_inlined
def _weigh(count: np.uint64, palette_q: np.ndarray, code: np.uint64, sums: np.ndarray) -> None:
    """Add to sums int64 (4,) the entropies of some voxels of one code."""
    h0, h1 = np.uint64(palette_q[code, 0]), np.uint64(palette_q[code, 1])
    h2, h3 = np.uint64(palette_q[code, 2]), np.uint64(palette_q[code, 3])
    sums[0] += np.int64(count * h0)
    sums[1] += np.int64(count * h1)
    sums[2] += np.int64(count * h2)
    sums[3] += np.int64(count * h3)


@lean_inlined
def _add(voxels: np.uint64, word: int, entropies: Entropies, sums: np.ndarray) -> None:
    """Add to sums (4,) the entropies of some voxels of a word, run by run."""
    starts, first = entropies.starts[word], np.int64(entropies.first[word])
    left = voxels
    while left != 0:
        run, within = first_run(left, starts)
        code = np.uint64(entropies.codes[np.uint64(first + run)])
        _weigh(popcount(within), entropies.palette_q, code, sums)
        left ^= within


@kernel
def total_by_sector(sectors: np.ndarray, depth: int, entropies: Entropies, sums: np.ndarray) -> None:
    """Add up all entropies by the sector of their column: sums int64 (s, 4)."""
    for word in range(sectors.size * depth):
        _add(entropies.keep[word], word, entropies, sums[sectors[word // depth]])


@lean_inlined
def _add_alone(
    own: np.ndarray, alone: np.uint64, word: int, entropies: Entropies, singles: np.ndarray
) -> None:
    """Add to singles (n, 4) what each sensor alone sees, of words own (n,), where one does."""
    for i in range(own.size):
        if own[i] & alone != 0:
            _add(own[i] & alone, word, entropies, singles[i])


@lean_inlined
def _add_two(own: np.ndarray, two: np.uint64, word: int, entropies: Entropies, pairs: np.ndarray) -> None:
    """Add to pairs (n, n, 4) what exactly two sensors see, where two do."""
    for i in range(own.size):
        first = own[i] & two
        if first != 0:
            for j in range(i + 1, own.size):
                if first & own[j] != 0:
                    _add(first & own[j], word, entropies, pairs[i, j])


@lean_inlined
def _add_groups(
    own: np.ndarray, members: np.ndarray, word: int, entropies: Entropies, groups: np.ndarray
) -> None:
    """Add to groups (g, 4) what only members of each group see."""
    for g in range(members.shape[0]):
        inside, outside = np.uint64(0), np.uint64(0)
        for i in range(own.size):
            if members[g, i]:
                inside |= own[i]
            else:
                outside |= own[i]
        if inside & ~outside != 0:
            _add(inside & ~outside, word, entropies, groups[g])


@lean_inlined
def _tally_word(
    word: int,
    stack: np.ndarray,
    slots: np.ndarray,
    kinds: np.ndarray,
    members: np.ndarray,
    entropies: Entropies,
    own: np.ndarray,
    levels: np.ndarray,
    singles: np.ndarray,
    pairs: np.ndarray,
    groups: np.ndarray,
) -> None:
    """As `tally_losses`, of one word; own uint64 (n,) is room to work in, the sums are those of its sector."""
    keep = entropies.keep[word]
    once, twice, thrice = np.uint64(0), np.uint64(0), np.uint64(0)
    seen0, seen1 = np.uint64(0), np.uint64(0)
    for i in range(slots.size):
        bits = stack[slots[i], word] & keep
        own[i] = bits
        thrice |= twice & bits
        twice |= once & bits
        once |= bits
        if kinds[i] == 0:
            seen0 |= bits
        else:
            seen1 |= bits
    if once == 0:
        return
    if thrice != 0:
        _add(thrice, word, entropies, levels[AT_LEAST_3])
    if seen0 & seen1 != 0:
        _add(seen0 & seen1, word, entropies, levels[TWO_KINDS])
    if once & ~twice != 0:
        _add_alone(own, once & ~twice, word, entropies, singles)
    if twice & ~thrice != 0:
        _add_two(own, twice & ~thrice, word, entropies, pairs)
    _add_groups(own, members, word, entropies, groups)


@lean
def _tally_columns(
    columns: tuple[int, int],
    stack: np.ndarray,
    slots: np.ndarray,
    kinds: np.ndarray,
    members: np.ndarray,
    sectors: np.ndarray,
    depth: int,
    entropies: Entropies,
    own: np.ndarray,
    levels: np.ndarray,
    singles: np.ndarray,
    pairs: np.ndarray,
    groups: np.ndarray,
) -> None:
    """As `tally_losses`, of the columns from the first to the second number, for one worker."""
    for column in range(columns[0], columns[1]):
        sector = np.int64(sectors[column])
        for word in range(column * depth, (column + 1) * depth):
            _tally_word(
                word, stack, slots, kinds, members, entropies, own, levels[sector], singles[sector], pairs[sector],
                groups[sector],
            )  # fmt: skip


@parallel_kernel
def tally_losses(
    stack: np.ndarray,
    slots: np.ndarray,
    kinds: np.ndarray,
    members: np.ndarray,
    sectors: np.ndarray,
    depth: int,
    entropies: Entropies,
    levels: np.ndarray,
    singles: np.ndarray,
    pairs: np.ndarray,
    groups: np.ndarray,
) -> None:
    """Add up what sensors cover together, and what nobody else covers of each sensor, pair and group.

    stack uint64 (rows, words), slots (n,) of the sensors, kinds (n,) 0 or 1; members bool (g, n): who fails
    together; sectors uint8 (columns,) of which there are s. Written, one row for each worker: levels int64 (w, s, 2,
    4); singles (w, s, n, 4): voxels that a sensor alone covers; pairs (w, s, n, n, 4): voxels that exactly these two
    cover, first < second; groups (w, s, g, 4): voxels that only members of the group cover.
    """
    workers, columns = levels.shape[0], sectors.size
    for worker in numba.prange(workers):
        part = (columns * worker // workers, columns * (worker + 1) // workers)
        own = np.zeros(slots.size, np.uint64)
        _tally_columns(
            part, stack, slots, kinds, members, sectors, depth, entropies, own, levels[worker], singles[worker],
            pairs[worker], groups[worker],
        )  # fmt: skip


@inlined
def _stay_in(o: Vector, d: Vector, cylinder: np.ndarray, near: float, far: float) -> tuple[float, float]:
    """The part of a ray inside of an upright cylinder (5,): x, y, radius, bottom, top; empty when first >= second."""
    x, y = o[0] - cylinder[0], o[1] - cylinder[1]
    a, b = d[0] * d[0] + d[1] * d[1], x * d[0] + y * d[1]
    c = x * x + y * y - cylinder[2] * cylinder[2]
    if a > 0.0:
        inner = b * b - a * c
        if inner <= 0.0:
            return np.inf, -np.inf
        root = np.sqrt(inner)
        near, far = max(near, (-b - root) / a), min(far, (-b + root) / a)
    elif c >= 0.0:
        return np.inf, -np.inf
    if d[2] != 0.0:
        low, high = (cylinder[3] - o[2]) / d[2], (cylinder[4] - o[2]) / d[2]
        near, far = max(near, min(low, high)), min(far, max(low, high))
    elif not cylinder[3] <= o[2] <= cylinder[4]:
        return np.inf, -np.inf
    return near, far


@kernel
def count_on_cylinders(rays: Cast, cylinders: np.ndarray, cones: np.ndarray, counts: np.ndarray) -> None:
    """Count the rays, in metres, that meet each upright cylinder alone, over a positive length within their range.

    cylinders (m, 5): x, y, radius, bottom, top; cones (m, 4): unit direction from the sensor to the middle of each,
    and a cosine below which no ray can meet it. Written to counts int64 (m, 2): rays that get there before they end
    (`rays.ends`, metres, or none of them ends), and rays that would if nothing of the car stopped them.
    """
    planes = rays.planes.shape[0]
    o = (rays.origin[0], rays.origin[1], rays.origin[2])
    for ray in range(rays.rows.shape[0] * planes):
        d = rotated(rays.rotation, direction(rays.kind, rays.rows[ray // planes], rays.planes[ray % planes]))
        for k in range(cylinders.shape[0]):
            if d[0] * cones[k, 0] + d[1] * cones[k, 1] + d[2] * cones[k, 2] < cones[k, 3]:
                continue
            near, far = _stay_in(o, d, cylinders[k], rays.reach[0], rays.reach[1])
            if near < far:
                counts[k, 1] += 1
                if rays.ends.size == 0 or near < rays.ends[ray]:
                    counts[k, 0] += 1
