"""What a safety review asks of the voxels that sensors traverse, and of single objects that stand beside the car.

What how many sensors traverse; the entropy that is lost with each sensor, each pair and each group of sensors, by bits
that count in parallel, from scratch and after a move; rays that meet upright cylinders. Sums are integers, so neither
the order of the sensors and of their moves nor the number of workers matters.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.bits import FULL_WORD, first_run, popcount
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
PLUS, MINUS = np.uint64(1), FULL_WORD
"""Signs of what is added: products modulo 2^64 with the latter are those of -1."""


@lean_inlined
def _opposite(sign: np.uint64) -> np.uint64:
    """The other sign."""
    return np.uint64(0) - sign


@parallel_kernel
def covered_levels(
    stack: np.ndarray, slots: np.ndarray, keep: np.ndarray, workers: int, levels: np.ndarray
) -> None:
    """Write the voxels within keep (words,) that at least 1, 2, 3 of the sets of slots (n,) hold: levels uint64
    (3, words). stack uint64 (rows, words): sets of voxels."""
    size = keep.size
    for worker in numba.prange(workers):
        for word in range(size * worker // workers, size * (worker + 1) // workers):
            once, twice, thrice, within = np.uint64(0), np.uint64(0), np.uint64(0), keep[word]
            if within != 0:
                for i in range(slots.size):
                    bits = stack[slots[i], word] & within
                    thrice |= twice & bits
                    twice |= once & bits
                    once |= bits
            levels[0, word], levels[1, word], levels[2, word] = once, twice, thrice


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
def _add_signed(
    voxels: np.uint64, sign: np.uint64, word: int, entropies: Entropies, sums: np.ndarray
) -> None:
    """Add to sums (4,) the entropies of some voxels of a word, run by run, or with MINUS take them off."""
    starts, first = entropies.starts[word], np.int64(entropies.first[word])
    left = voxels
    while left != 0:
        run, within = first_run(left, starts)
        code = np.uint64(entropies.codes[np.uint64(first + run)])
        _weigh(popcount(within) * sign, entropies.palette_q, code, sums)
        left ^= within


@lean_inlined
def _add(voxels: np.uint64, word: int, entropies: Entropies, sums: np.ndarray) -> None:
    """Add to sums (4,) the entropies of some voxels of a word."""
    _add_signed(voxels, PLUS, word, entropies, sums)


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


@lean_inlined
def _change_two(
    own: np.ndarray,
    moved: int,
    two: np.uint64,
    sign: np.uint64,
    word: int,
    entropies: Entropies,
    pairs: np.ndarray,
) -> None:
    """Take off pairs (n, n, 4) voxels that exactly two others see and the moved sensor sees too (sign PLUS: now)."""
    for i in range(own.size):
        first = own[i] & two
        if i != moved and first != 0:
            for j in range(i + 1, own.size):
                if j != moved and first & own[j] != 0:
                    _add_signed(first & own[j], _opposite(sign), word, entropies, pairs[i, j])


@lean_inlined
def _change_one(
    own: np.ndarray,
    moved: int,
    one: np.uint64,
    sign: np.uint64,
    word: int,
    entropies: Entropies,
    singles: np.ndarray,
    pairs: np.ndarray,
) -> None:
    """Bring voxels that exactly one other sees from singles (n, 4) to pairs (n, n, 4), with MINUS back."""
    for i in range(own.size):
        shared = own[i] & one
        if i != moved and shared != 0:
            _add_signed(shared, _opposite(sign), word, entropies, singles[i])
            _add_signed(shared, sign, word, entropies, pairs[min(i, moved), max(i, moved)])


@lean_inlined
def _change_groups(
    own: np.ndarray,
    moved: int,
    bits: np.uint64,
    sign: np.uint64,
    members: np.ndarray,
    word: int,
    entropies: Entropies,
    groups: np.ndarray,
) -> None:
    """Bring groups (g, 4) in line with voxels that the moved sensor sees now, with MINUS no more."""
    for g in range(members.shape[0]):
        inside, outside = np.uint64(0), np.uint64(0)
        for i in range(own.size):
            if i != moved and members[g, i]:
                inside |= own[i]
            elif i != moved:
                outside |= own[i]
        if members[g, moved]:
            _add_signed(bits & ~inside & ~outside, sign, word, entropies, groups[g])
        else:
            _add_signed(bits & inside & ~outside, _opposite(sign), word, entropies, groups[g])


@lean_inlined
def _change_word(
    bits: np.uint64,
    sign: np.uint64,
    moved: int,
    word: int,
    kinds: np.ndarray,
    members: np.ndarray,
    entropies: Entropies,
    own: np.ndarray,
    levels: np.ndarray,
    singles: np.ndarray,
    pairs: np.ndarray,
    groups: np.ndarray,
) -> None:
    """Bring sums of one sector in line with bits of a word that the moved sensor sees now, with MINUS no more."""
    once, twice, thrice = np.uint64(0), np.uint64(0), np.uint64(0)
    same, other = np.uint64(0), np.uint64(0)
    for i in range(own.size):
        if i != moved:
            seen = own[i] & bits
            thrice |= twice & seen
            twice |= once & seen
            once |= seen
            if kinds[i] == kinds[moved]:
                same |= seen
            else:
                other |= seen
    _add_signed(twice & ~thrice, sign, word, entropies, levels[AT_LEAST_3])
    _add_signed(other & ~same, sign, word, entropies, levels[TWO_KINDS])
    _add_signed(bits & ~once, sign, word, entropies, singles[moved])
    if once & ~twice != 0:
        _change_one(own, moved, once & ~twice, sign, word, entropies, singles, pairs)
    if twice & ~thrice != 0:
        _change_two(own, moved, twice & ~thrice, sign, word, entropies, pairs)
    _change_groups(own, moved, bits, sign, members, word, entropies, groups)


@lean
def _change_columns(
    columns: tuple[int, int],
    moved: np.ndarray,
    before: np.ndarray,
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
    """As `change_losses`, of the columns from the first to the second number, for one worker."""
    for word in range(columns[0] * depth, columns[1] * depth):
        keep, changed = entropies.keep[word], np.uint64(0)
        for m in range(moved.size):
            changed |= (before[m, word] ^ stack[slots[moved[m]], word]) & keep
        if changed == 0:
            continue
        for i in range(slots.size):
            own[i] = stack[slots[i], word] & keep
        for m in range(moved.size):
            own[moved[m]] = before[m, word] & keep
        sector = np.int64(sectors[word // depth])
        for m in range(moved.size):
            now, old = stack[slots[moved[m]], word] & keep, own[moved[m]]
            for bits, sign in ((now & ~old, PLUS), (old & ~now, MINUS)):
                if bits != 0:
                    _change_word(
                        bits, sign, moved[m], word, kinds, members, entropies, own, levels[sector],
                        singles[sector], pairs[sector], groups[sector],
                    )  # fmt: skip
            own[moved[m]] = now
            before[m, word] = now


@parallel_kernel
def change_losses(
    moved: np.ndarray,
    before: np.ndarray,
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
    """Bring what `tally_losses` wrote in line with some sensors that have moved.

    moved (m,): places of these sensors in slots; before uint64 (m, words): their sets until now, which become those
    of now. All else as in `tally_losses`; the changes are added to what the sums hold.
    """
    workers, columns = levels.shape[0], sectors.size
    for worker in numba.prange(workers):
        part = (columns * worker // workers, columns * (worker + 1) // workers)
        own = np.zeros(slots.size, np.uint64)
        _change_columns(
            part, moved, before, stack, slots, kinds, members, sectors, depth, entropies, own, levels[worker],
            singles[worker], pairs[worker], groups[worker],
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
