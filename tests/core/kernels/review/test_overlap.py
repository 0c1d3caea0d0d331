"""The kernels of safety reviews on cases small enough for a pencil."""

from __future__ import annotations

import math

import numpy as np

from riglens.core.kernels.objects.cylinders import count_on_cylinders
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.review.blind import lowest_around, lowest_levels, three_lowest
from riglens.core.kernels.review.overlap import covered_levels, sum_by_sector
from riglens.core.kernels.runtime import codes
from riglens.core.kernels.voxels.entropy_codes import Entropies

NONE = 0xFFFF


def words(*values: int) -> np.ndarray:
    return np.array(values, np.uint64)


def test_the_lowest_level_of_a_column_counts_over_its_words_and_within_what_counts() -> None:
    stack = np.array([[0b1000, 1, 0, 0b100], [0b10, 0, 0, 1 << 63]], np.uint64)
    keep = words(0b1100, 1, 0, 0xFFFFFFFFFFFFFFFF)
    for workers in (1, 2):
        for voxels, wanted in zip(stack, ([3, 64 + 2], [NONE, 64 + 63]), strict=True):
            lowest = np.empty(2, np.uint16)
            lowest_levels(voxels, keep, 2, NONE, workers, lowest)
            assert lowest.tolist() == wanted


def test_around_a_column_the_lowest_level_counts() -> None:
    lowest = np.full((2, 2, 3), NONE, np.uint16)
    lowest[0, 0] = [5, NONE, 1]
    lowest[1, 1, 1] = 2
    for workers in (1, 2):
        around = np.full((2, 2, 3), 7, np.uint16)
        across = np.array([[0, -1], [0, 0], [0, 1], [1, 0]])
        for one, to in zip(lowest, around, strict=True):
            lowest_around(one, across, NONE, workers, to)
        assert around[0].tolist() == [[5, 1, 1], [NONE] * 3]
        assert around[1].tolist() == [[NONE, 2, NONE], [2, 2, 2]]  # the row ahead counts in the middle alone


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


def test_entropies_are_summed_run_by_run_and_by_sector() -> None:
    """Two columns, in sectors 0 and 1; entropies 1, 10 (levels 1 and 2) in the first, 100 in the second."""
    starts, first, code = words(0b011, 0b001), np.array([0, 2, 3], np.uint32), np.array([0, 1, 2], np.uint16)
    palette = np.array([[1, 2, 3, 0], [10, 20, 30, 0], [100, 200, 300, 0]], np.uint32)
    entropies, sectors = (
        Entropies(words(0b111, 0b111), starts, first, code, palette),
        np.array([0, 1], np.uint8),
    )
    for voxels, wanted in (
        (words(0b111, 0b111), [[21, 42, 63, 0], [300, 600, 900, 0]]),
        (words(0b100, 0b101), [[10, 20, 30, 0], [200, 400, 600, 0]]),
        (words(0b001, 0), [[1, 2, 3, 0], [0, 0, 0, 0]]),
    ):
        sums = np.zeros((2, 4), np.int64)
        sum_by_sector(voxels, sectors, 1, entropies, sums)
        assert sums.tolist() == wanted


def test_columns_of_two_words_are_of_one_sector() -> None:
    starts, first, codes = words(1, 1, 1, 1), np.arange(5, dtype=np.uint32), np.arange(4, dtype=np.uint16)
    palette = np.array([[1, 0, 0, 0], [10, 0, 0, 0], [100, 0, 0, 0], [1000, 0, 0, 0]], np.uint32)
    total = np.zeros((2, 4), np.int64)
    entropies = Entropies(words(1, 1, 1, 1), starts, first, codes, palette)
    sum_by_sector(entropies.keep, np.array([1, 0], np.uint8), 2, entropies, total)
    assert total[:, 0].tolist() == [1100, 11]


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


def test_a_cone_leans_with_what_lies_above_or_below() -> None:
    slope = math.sqrt(0.5)
    for up in (slope, -slope):
        post = np.array([[5.0, 0.0, 0.5, *sorted((8.0 * up, 6.0 * up))]])
        counts = np.zeros((1, 2), np.int64)
        count_on_cylinders(rays_to((slope, 0.0, up)), post, np.array([[slope, 0.0, up, 0.9]]), counts)
        assert counts[0].tolist() == [1, 1]
