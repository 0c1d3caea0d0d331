"""The kernels of safety reviews on cases small enough for a pencil."""

from __future__ import annotations

import math

import numpy as np

from riglens.core.kernels.objects.cylinders import count_on_cylinders
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.review.blind import lowest_around, lowest_levels, three_lowest
from riglens.core.kernels.review.overlap import (
    Views,
    covered_levels,
    rows_of_sums,
    tally_views,
    total_by_sector,
)
from riglens.core.kernels.runtime import codes
from riglens.core.kernels.voxels.entropy_codes import Entropies

NONE = 0xFFFF


def words(*values: int) -> np.ndarray:
    return np.array(values, np.uint64)


def test_the_lowest_level_of_a_column_counts_over_its_words_and_within_what_counts() -> None:
    stack = np.array([[0b1000, 1, 0, 0b100], [0, 0, 0, 0], [0b10, 0, 0, 1 << 63]], np.uint64)
    keep = words(0b1100, 1, 0, 0xFFFFFFFFFFFFFFFF)
    for workers in (1, 2):
        lowest = np.empty((2, 2), np.uint16)
        lowest_levels(stack, np.array([0, 2]), keep, 2, NONE, workers, lowest)
        assert lowest.tolist() == [[3, 64 + 2], [NONE, 64 + 63]]


def test_around_a_column_the_lowest_level_counts_and_other_rows_stay() -> None:
    lowest = np.full((2, 2, 3), NONE, np.uint16)
    lowest[0, 0] = [5, NONE, 1]
    lowest[1, 1, 1] = 2
    for workers in (1, 2):
        around = np.full((3, 2, 3), 7, np.uint16)
        across = np.array([[0, -1], [0, 0], [0, 1], [1, 0]])
        lowest_around(lowest, across, NONE, workers, np.array([2, 0]), around)
        assert around[2].tolist() == [[5, 1, 1], [NONE] * 3] and around[1].tolist() == [[7] * 3] * 2
        assert around[0].tolist() == [[NONE, 2, NONE], [2, 2, 2]]  # the row ahead counts in the middle alone


def test_the_three_lowest_of_different_sensors_count_by_kind() -> None:
    around = np.full((5, 1, 3), NONE, np.uint16)
    around[0, 0], around[1, 0], around[3, 0], around[4, 0] = [5, 5, 1], [4, NONE, 9], [8, 0, 0], [6, 5, 0]
    levels = np.empty((3, 3, 1, 3), np.uint16)
    three_lowest(around, np.array([0, 1, 4]), np.array([0, 1, 1]), NONE, 2, levels)
    assert levels[0, :, 0].T.tolist() == [[4, 5, 6], [5, 5, NONE], [0, 1, 9]]
    assert levels[1, :, 0, 0].tolist() == [5, NONE, NONE] and levels[2, :, 0].T.tolist()[2] == [0, 9, NONE]
    three_lowest(around, np.zeros(0, np.int64), np.zeros(0, np.int64), NONE, 1, levels)
    assert (levels == NONE).all()


def test_voxels_of_one_two_and_three_sets_are_told_within_what_counts() -> None:
    stack = np.array([[0b1111, 1], [0, 0], [0b0111, 0], [0b0011, 0], [0b0001, 2]], np.uint64)
    for workers in (1, 2):
        levels = np.empty((3, 2), np.uint64)
        covered_levels(stack, np.array([0, 2, 3, 4]), words(0b1101, 1), workers, levels)
        assert levels.tolist() == [[0b1101, 1], [0b0101, 0], [0b0001, 0]]


def test_shares_are_those_of_voxels_counted_one_by_one() -> None:
    """Two columns, in sectors 0 and 1, three levels each; entropies 1, 10 (levels 1 and 2) in the first, 100 in the
    second; the level 3 does not count."""
    keep, starts = words(0b111, 0b111), words(0b011, 0b001)
    first, code = np.array([0, 2, 3], np.uint32), np.array([0, 1, 2], np.uint16)
    palette = np.array([[1, 2, 3, 0], [10, 20, 30, 0], [100, 200, 300, 0]], np.uint32)
    entropies = Entropies(keep, starts, first, code, palette)
    stack = np.array([[0b1111, 0b001], [0b0010, 0b011], [0b0010, 0b110], [0b0110, 0b110]], np.uint64)
    sectors = np.array([0, 1], np.uint8)
    crowds = np.array([[True] * 4, [False, True, True, True]])
    for workers in (1, 2):
        sums = np.zeros((workers, 2, rows_of_sums(4, 2), 4), np.int64)
        tally_views(Views(stack, np.arange(4), crowds, sectors, 1), entropies, sums)
        told = sums.sum(axis=0)
        alone, pairs, many = told[:, :4], told[:, 4:20].reshape(2, 4, 4, 4), told[:, 20:]
        assert alone[0, :, 0].tolist() == [1, 0, 0, 0] and alone[1, :, 0].tolist() == [0, 0, 0, 0]
        assert pairs[0, 0, 3].tolist() == [10, 20, 30, 0] and pairs[1, 0, 1, 0] == 100
        assert pairs[1, 2, 3, 0] == 100 and pairs.sum() == (10 + 20 + 30) + 2 * 600
        assert many[0, :, 0].tolist() == [10, 0]  # level 1 by all four
        assert many[1, :, 0].tolist() == [100, 100]  # level 1 by the last three
    total = np.zeros((2, 4), np.int64)
    total_by_sector(sectors, 1, entropies, total)
    assert total.tolist() == [[21, 42, 63, 0], [300, 600, 900, 0]]


def test_columns_of_two_words_are_of_one_sector() -> None:
    starts, first, codes = words(1, 1, 1, 1), np.arange(5, dtype=np.uint32), np.arange(4, dtype=np.uint16)
    palette = np.array([[1, 0, 0, 0], [10, 0, 0, 0], [100, 0, 0, 0], [1000, 0, 0, 0]], np.uint32)
    total = np.zeros((2, 4), np.int64)
    total_by_sector(
        np.array([1, 0], np.uint8), 2, Entropies(words(1, 1, 1, 1), starts, first, codes, palette), total
    )
    assert total[:, 0].tolist() == [1100, 11]


def shares_bit_by_bit(views: Views, entropies: Entropies) -> np.ndarray:
    """What `tally_views` adds up, voxel by voxel."""
    n, keep = len(views.slots), entropies.keep
    sums = np.zeros((3, rows_of_sums(n, len(views.crowds)), 4), np.int64)
    for word, bit in [(w, b) for w in range(keep.size) for b in range(64) if int(keep[w]) >> b & 1]:
        who = [i for i in range(n) if int(views.stack[views.slots[i], word]) >> bit & 1]
        run = int(entropies.first[word]) - 1
        run += bin(int(entropies.starts[word]) & ((2 << bit) - 1)).count("1")
        entropy = entropies.entropies_q[entropies.codes[run]].astype(np.int64)
        own = sums[views.sectors[word // views.depth]]
        if len(who) in (1, 2):
            own[who[0] if len(who) == 1 else n * (1 + who[0]) + who[1]] += entropy
        for g, crowd in enumerate(views.crowds):
            if len(who) > 2 and crowd[who].all():
                own[n * (1 + n) + g] += entropy
    return sums


def views_by_chance(rng: np.random.Generator) -> tuple[Views, Entropies]:
    """Five sensors that see anything of 40 words, two for each column."""
    keep = rng.integers(0, 1 << 20, 40, np.uint64)
    starts = rng.integers(0, 1 << 20, 40, np.uint64) & keep | (keep & (~keep + np.uint64(1)))
    runs = np.array([bin(int(word)).count("1") for word in starts])
    first = np.concatenate([[0], np.cumsum(runs)]).astype(np.uint32)
    palette = rng.integers(0, 1 << 32, (9, 4), np.uint32)
    entropies = Entropies(keep, starts, first, rng.integers(0, 9, runs.sum()).astype(np.uint16), palette)
    crowds = np.array([[True] * 5, [True, False, True, False, True], [False, False, True, True, True]])
    stack, sectors = rng.integers(0, 1 << 21, (6, 40), np.uint64), rng.integers(0, 3, 20).astype(np.uint8)
    return Views(stack, np.array([4, 0, 2, 3, 1]), crowds, sectors, 2), entropies


def test_shares_are_those_bit_by_bit() -> None:
    views, entropies = views_by_chance(np.random.default_rng(5))
    for workers in (1, 3):
        sums = np.zeros((workers, 3, rows_of_sums(5, 3), 4), np.int64)
        tally_views(views, entropies, sums)
        np.testing.assert_array_equal(sums.sum(axis=0), shares_bit_by_bit(views, entropies))


def rays_to(*directions: tuple[float, float, float], near: float = 0.0, far: float = math.inf) -> Cast:
    unit = np.array([np.array(d) / np.linalg.norm(d) for d in directions])
    return Cast(
        codes.LISTED, unit, np.zeros((1, 2)), np.array([0.0, 0.0, 1.0]), np.eye(3), np.array([near, far]),
        np.zeros(6, np.int64), np.zeros(3, np.int64), False, np.zeros(0),
    )  # fmt: skip


POST = np.array([[5.0, 0.0, 0.5, 0.0, 2.0]])
ANYWHERE = np.array([[1.0, 0.0, 0.0, -2.0]])


def count(rays: Cast, post: np.ndarray = POST) -> list[int]:
    counts = np.zeros((1, 2), np.int64)
    count_on_cylinders(rays, post, ANYWHERE, counts)
    return counts[0].tolist()


def test_a_ray_meets_a_cylinder_over_a_positive_length_and_before_its_end() -> None:
    ahead, past, down, over = (1.0, 0.0, 0.0), (1.0, 0.2, 0.0), (1.0, 0.0, -0.1), (1.0, 0.0, 0.3)
    assert count(rays_to(ahead, past, down, over)) == [2, 2]
    touching = (math.sqrt(25.0 - 0.25), 0.5, 0.0)
    assert count(rays_to(touching)) in ([0, 0], [1, 1])  # a tangent: what rounding makes of it
    assert count(rays_to(ahead, far=4.5)) == [0, 0] and count(rays_to(ahead, far=4.6)) == [1, 1]
    assert count(rays_to(ahead, near=5.6)) == [0, 0] and count(rays_to(ahead, near=5.0)) == [1, 1]
    assert count(rays_to(ahead, down)._replace(ends=np.array([4.4, 4.6]))) == [1, 2]
    above = rays_to((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
    assert count(above, np.array([[0.1, 0.0, 0.5, 1.5, 2.0]])) == [1, 1]
    assert count(above, np.array([[1.0, 0.0, 0.5, 1.5, 2.0]])) == [0, 0]


def test_a_cone_that_a_ray_is_outside_of_spares_the_test() -> None:
    counts = np.zeros((1, 2), np.int64)
    count_on_cylinders(rays_to((1.0, 0.0, 0.0)), POST, np.array([[0.0, 1.0, 0.0, 0.5]]), counts)
    assert not counts.any()
