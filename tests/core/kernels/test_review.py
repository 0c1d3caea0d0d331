"""The kernels of safety reviews on cases small enough for a pencil."""

from __future__ import annotations

import math

import numpy as np

from riglens.core.kernels import codes
from riglens.core.kernels.cast import Cast
from riglens.core.kernels.palette import Entropies
from riglens.core.kernels.review import (
    AT_LEAST_3,
    TWO_KINDS,
    count_on_cylinders,
    lowest_levels,
    tally_losses,
    total_by_sector,
    two_lowest,
)

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


def test_of_the_levels_around_a_column_the_two_lowest_of_different_sensors_count() -> None:
    lowest = np.full((3, 2, 3), NONE, np.uint16)
    lowest[0, 0] = [5, NONE, 1]
    lowest[1, 0, 1], lowest[1, 1, 1], lowest[2, 0, 1] = 4, 2, 9
    kinds = np.array([0, 1, 1])
    both = np.empty((3, 2, 2, 3), np.uint16)
    two_lowest(lowest, kinds, np.array([[0, 0]]), NONE, 2, both)
    assert both[0, 0, 0].tolist() == [5, 4, 1] and both[0, 1, 0].tolist() == [NONE, 9, NONE]
    assert both[1, 0, 0].tolist() == [5, NONE, 1] and both[2, :, 0, 1].tolist() == [4, 9]
    across = np.array([[0, -1], [0, 0], [0, 1], [1, 0]])
    two_lowest(lowest, kinds, across, NONE, 1, both)
    assert both[0, 0, 0].tolist() == [4, 1, 1] and both[0, 1, 0].tolist() == [5, 2, 4]
    assert both[2, 0, 0].tolist() == [4, 2, 4]  # the row ahead counts in the middle alone
    assert both[0, 0, 1].tolist() == [2, 2, 2]


def test_losses_are_those_of_voxels_counted_one_by_one() -> None:
    """Two columns, in sectors 0 and 1, three levels each; entropies 1, 10 (levels 1 and 2) in the first, 100 in the
    second; the level 3 does not count."""
    keep, starts = words(0b111, 0b111), words(0b011, 0b001)
    first, code = np.array([0, 2, 3], np.uint32), np.array([0, 1, 2], np.uint16)
    palette = np.array([[1, 2, 3, 0], [10, 20, 30, 0], [100, 200, 300, 0]], np.uint32)
    entropies = Entropies(keep, starts, first, code, palette)
    stack = np.array([[0b1111, 0b001], [0b0010, 0b011], [0b0010, 0b110], [0b0110, 0b110]], np.uint64)
    slots, kinds, sectors = np.arange(4), np.array([0, 0, 1, 1]), np.array([0, 1], np.uint8)
    members = np.array([[True, False, False, True], [False, True, True, True]])
    for workers in (1, 2):
        levels = np.zeros((workers, 2, 2, 4), np.int64)
        singles = np.zeros((workers, 2, 4, 4), np.int64)
        pairs = np.zeros((workers, 2, 4, 4, 4), np.int64)
        groups = np.zeros((workers, 2, 2, 4), np.int64)
        tally_losses(stack, slots, kinds, members, sectors, 1, entropies, levels, singles, pairs, groups)
        levels, singles, pairs, groups = (one.sum(axis=0) for one in (levels, singles, pairs, groups))
        assert levels[:, AT_LEAST_3, 0].tolist() == [
            10,
            100,
        ]  # level 1 of the first by all, of the second by 1, 2, 3
        assert levels[:, TWO_KINDS, 0].tolist() == [20, 100]
        assert singles[0, :, 0].tolist() == [1, 0, 0, 0] and singles[1, :, 0].tolist() == [0, 0, 0, 0]
        assert pairs[0, 0, 3].tolist() == [10, 20, 30, 0] and pairs[1, 0, 1, 0] == 100
        assert pairs[1, 2, 3, 0] == 100 and pairs.sum() == (10 + 20 + 30) + 2 * 600
        assert groups[0, :, 0].tolist() == [1 + 10, 0] and groups[1, :, 0].tolist() == [0, 100 + 100]
    total = np.zeros((2, 4), np.int64)
    total_by_sector(sectors, 1, entropies, total)
    assert total.tolist() == [[21, 42, 63, 0], [300, 600, 900, 0]]


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
