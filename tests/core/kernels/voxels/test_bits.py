"""Words of 64 voxels: the lowest bit is the ground, ids follow word and bit, a run ends where the next one starts."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.kernels.voxels import bits
from tests.core.kernels.tiny import words

ALL = (1 << 64) - 1


def test_ids_count_the_set_bits_before_a_word() -> None:
    assert bits.first_ids(words(0b1011, 0, 0b1)).tolist() == [0, 3, 3, 4]


def test_voxels_are_listed_column_by_column_from_the_ground_up() -> None:
    used = words(0b101, 0, 0, 1 << 63)  # columns (0, 0), (0, 1), (1, 0), (1, 1)
    listed = bits.list_voxels(used, bits.first_ids(used), 2, 1)
    assert listed.tolist() == [[0, 0, 0], [0, 0, 2], [1, 1, 63]]


def test_the_second_word_of_a_column_begins_at_level_64() -> None:
    used = words(1 << 63, 0b11)  # one column of two words
    assert bits.list_voxels(used, bits.first_ids(used), 1, 2)[:, 2].tolist() == [63, 64, 65]


def test_voxels_without_a_flag_are_cleared() -> None:
    used = words(0b1011, 0b110)
    bits.keep_flagged(used, np.array([True, False, True, False, True]))
    assert used.tolist() == [0b1001, 0b100]


@pytest.mark.parametrize(
    ("changed", "run", "within"),
    [
        (0b0000_0001, 0, 0b0000_0001),
        (0b0000_0110, 0, 0b0000_0110),
        (0b0000_1010, 0, 0b0000_0010),  # bit 3 starts the next run
        (0b0011_1000, 1, 0b0001_1000),  # bit 5 starts the one after
        (0b1110_0000, 2, 0b1110_0000),
        (1 << 63, 2, 1 << 63),  # the last run reaches to the top of the word
    ],
)
def test_changed_bits_are_taken_run_by_run(changed: int, run: int, within: int) -> None:
    starts = np.uint64(0b0010_1001)  # runs start at bits 0, 3 and 5
    found = bits.first_run(np.uint64(changed), starts)
    assert (int(found[0]), int(found[1])) == (run, within)


@pytest.mark.parametrize(
    ("low", "high", "mask"), [(3, 5, 0b111000), (0, 0, 1), (63, 63, 1 << 63), (0, 63, ALL)]
)
def test_a_mask_holds_both_ends(low: int, high: int, mask: int) -> None:
    assert int(bits.level_mask(low, high)) == mask


@pytest.mark.parametrize(
    ("low", "high", "marked"),
    [
        (1, 2, [0b110, 0, 0]),
        (62, 65, [0b11 << 62, 0b11, 0]),
        (64, 127, [0, ALL, 0]),
        (63, 128, [1 << 63, ALL, 1]),
    ],
)
def test_levels_are_marked_across_words(low: int, high: int, marked: list[int]) -> None:
    marks = words(0, 0, 0, 0)
    bits.mark_levels(marks, 1, low, high)
    assert marks.tolist() == [0, *marked]
