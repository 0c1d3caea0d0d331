"""Neighbours with the same counts share a run, runs with the same counts share a code."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.voxels import entropy_codes
from riglens.core.kernels.voxels.entropy_codes import EMPTY, Numbering
from tests.core.kernels.tiny import Words, words

A, B, C = (1, 0, 0), (2, 0, 0), (2, 0, 1)


def runs_of(used: Words, *rows: tuple[int, int, int]) -> tuple[list[int], list[int]]:
    """Where the runs start, as words, and the number of runs before each word."""
    starts, first = np.empty(used.size, np.uint64), np.empty(used.size + 1, np.uint32)
    count = entropy_codes.find_runs(used, np.array(rows), starts, first)
    assert count == first[-1]
    return starts.tolist(), first.tolist()


def numbered(
    used: Words, starts: Words, most: int, slots: int, *rows: tuple[int, int, int]
) -> tuple[int, Numbering]:
    """How many combinations there are, and the table with their numbers."""
    table = Numbering(
        np.full(8, 99, np.uint32),
        np.zeros(most, np.int64),
        np.zeros(most, np.int64),
        np.full(slots, EMPTY, np.int64),
    )
    return entropy_codes.number_runs(used, starts, np.array(rows), table), table


def test_a_run_ends_where_the_counts_change() -> None:
    assert runs_of(words(0b1111), A, A, B, A) == ([0b1101], [0, 3])


def test_a_gap_between_voxels_does_not_end_a_run() -> None:
    assert runs_of(words(0b10110001), A, A, B, B) == ([0b00100001], [0, 2])


def test_a_run_ends_with_its_word() -> None:
    assert runs_of(words(0b1, 0, 0b11), A, A, A) == ([0b1, 0, 0b1], [0, 1, 1, 2])


def test_counts_differ_when_any_class_differs() -> None:
    assert runs_of(words(0b11), B, C) == ([0b11], [0, 2])
    assert runs_of(words(0b11), (0, 1, 0), (0, 2, 0)) == ([0b11], [0, 2])
    assert runs_of(words(0b11), (1, 1, 0), (2, 1, 0)) == ([0b11], [0, 2])


def test_equal_runs_share_a_number_in_the_order_of_appearance() -> None:
    found, table = numbered(words(0b1111, 0b11), words(0b1101, 0b11), 4, 8, A, A, B, A, C, B)
    assert found == 3
    assert table.numbers[:5].tolist() == [0, 1, 0, 2, 1]
    assert table.firsts[:3].tolist() == [0, 2, 4]  # the voxel that each combination was met in first
    assert table.uses[:3].tolist() == [3, 2, 1]  # voxels, not runs


def test_combinations_that_fall_on_one_slot_stay_apart() -> None:
    found, table = numbered(words(0b111), words(0b111), 3, 4, (4, 0, 0), (8, 0, 0), (4, 0, 0))
    assert found == 2
    assert table.numbers[:3].tolist() == [0, 1, 0]


def test_a_table_that_is_too_small_is_told() -> None:
    assert numbered(words(0b111), words(0b111), 2, 8, A, B, C)[0] == -1
    assert numbered(words(0b111), words(0b111), 3, 8, A, B, C)[0] == 3


def test_codes_go_from_runs_to_voxels() -> None:
    codes = np.empty(4, np.uint16)
    entropy_codes.voxel_codes(
        words(0b1011, 0b100), words(0b1001, 0b100), np.array([7, 5, 6], np.uint16), codes
    )
    assert codes.tolist() == [7, 7, 5, 6]


def test_frequent_combinations_take_the_low_codes() -> None:
    codes = np.empty(4, np.uint16)
    entropy_codes.renumber(np.array([0, 2, 1, 2], np.uint32), np.array([1, 2, 0], np.uint32), codes)
    assert codes.tolist() == [1, 0, 2, 0]
