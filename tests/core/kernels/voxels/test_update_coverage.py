"""Settling one word: what a kind covers is brought up to date, and exactly what changed is counted, in whole numbers.

The grid is one column with levels 0 to 7. Levels 0 to 3 are one run (code 0) and levels 4 to 7 another (code 1); a
voxel of code 0 is worth 10, 1 and 0 for the three classes, one of code 1 is worth 100, 2 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest

from riglens.core.kernels.voxels import update_coverage as kernel
from riglens.core.kernels.voxels.entropy_codes import Entropies
from riglens.core.kernels.voxels.update_coverage import Region
from tests.core.kernels.tiny import Words, words

CAMERAS, LIDARS = 0, 1


PALETTE = np.array([[10, 1, 0, 0], [100, 2, 5, 0]], np.uint32)
NONE = [0, 0, 0, 0]
BROKEN = 0xAAAA_AAAA_AAAA_AAAA
"""Placed where nothing may be read."""
Sums = list[int]


class Cover(NamedTuple):
    """The sets of some sensors, slot by slot, and what all cameras and all LiDARs cover."""

    stack: Words
    union: Words


class Slots(NamedTuple):
    """Slots of a kind, by what becomes of them."""

    arrived: np.ndarray
    staying: np.ndarray
    leaving: np.ndarray


def settle(
    cover: Cover, slots: Slots, kind: int, region: Region, entropies: Entropies, workers: int
) -> np.ndarray:
    """The change of the sums."""
    free = np.full(entropies.keep.size, BROKEN, np.uint64)
    counts = np.zeros((max(slots.staying.size.bit_length(), 1), entropies.keep.size), np.uint64)
    others = kernel.Slots(slots.staying, np.zeros(0, np.int64))
    kernel.count_others(cover.stack, others, region, entropies.keep, workers, counts, free)
    some = kernel.Slots(slots.arrived, slots.leaving)
    kinds = np.array([kind, *(other for other in range(len(cover.union)) if other != kind)])
    return kernel.settle(cover.stack, cover.union, free, some, kinds, region, entropies, workers)


def one_word(keep: int = 0b1111_1111) -> Entropies:
    """The column of eight levels, or those of them that are informative."""
    starts = 0b0001_0001 & keep
    return Entropies(
        words(keep), words(starts), np.array([0, 2], np.uint32), np.array([0, 1], np.uint16), PALETTE
    )


def settled(
    cover: Cover,
    arrived: Sequence[int] = (),
    staying: Sequence[int] = (),
    leaving: Sequence[int] = (),
    kind: int = LIDARS,
    entropies: Entropies | None = None,
) -> tuple[Sums, Sums]:
    """By how much the sums of this kind and those of any sensor change: three classes and the number of voxels."""
    slots = Slots(*(np.array(group, np.int64) for group in (arrived, staying, leaving)))
    region = Region(0, 1, 0, 1, 1)
    change = settle(cover, slots, kind, region, entropies or one_word(), 1)
    return change[0].tolist(), change[1].tolist()


def cover_of(*stack: int, cameras: int = 0, lidars: int = 0) -> Cover:
    """Sets of some sensors, and what all cameras and all LiDARs covered before."""
    return Cover(words(*stack).reshape(-1, 1), words(cameras, lidars).reshape(2, 1))


def test_a_sensor_that_arrives_gains_its_voxels() -> None:
    cover = cover_of(0b0001_0011)
    assert settled(cover, arrived=[0]) == ([120, 4, 5, 3], [120, 4, 5, 3])
    assert cover.union.tolist() == [[0], [0b0001_0011]]


def test_a_sensor_that_leaves_loses_its_voxels_and_its_slot_is_cleared() -> None:
    cover = cover_of(0b0001_0011, lidars=0b0001_0011)
    assert settled(cover, leaving=[0]) == ([-120, -4, -5, -3], [-120, -4, -5, -3])
    assert cover.union.tolist() == [[0], [0]]
    assert cover.stack.tolist() == [[0]]


def test_a_sensor_that_moves_loses_what_it_left_and_gains_what_it_found() -> None:
    """From levels 2 to 5 to levels 4 to 7: two voxels of code 0 are lost, two of code 1 gained."""
    cover = cover_of(0b0011_1100, 0b1111_0000, lidars=0b0011_1100)
    assert settled(cover, arrived=[1], leaving=[0]) == ([180, 2, 10, 0], [180, 2, 10, 0])
    assert cover.union.tolist() == [[0], [0b1111_0000]]
    assert cover.stack.tolist() == [[0], [0b1111_0000]]


def test_what_another_sensor_of_the_kind_covers_is_neither_gained_nor_lost() -> None:
    cover = cover_of(0b0000_0111, 0b0011_0010, 0b0000_0010, lidars=0b0011_0111)
    assert settled(cover, arrived=[2], staying=[1], leaving=[0]) == ([-20, -2, 0, -2], [-20, -2, 0, -2])
    assert cover.union.tolist() == [[0], [0b0011_0010]]
    assert cover.stack[1, 0] == 0b0011_0010


def test_what_the_other_kind_covers_changes_this_kind_alone() -> None:
    cover = cover_of(0b0000_0011, cameras=0b0000_0001)
    assert settled(cover, arrived=[0]) == ([20, 2, 0, 2], [10, 1, 0, 1])
    assert cover.union.tolist() == [[0b0000_0001], [0b0000_0011]]


def test_cameras_are_settled_beside_lidars_as_lidars_beside_cameras() -> None:
    cover = cover_of(0b0000_0011, lidars=0b0000_0001)
    assert settled(cover, arrived=[0], kind=CAMERAS) == ([20, 2, 0, 2], [10, 1, 0, 1])
    assert cover.union.tolist() == [[0b0000_0011], [0b0000_0001]]


def test_voxels_lost_where_the_other_kind_looks_and_gained_where_it_does_not() -> None:
    """Of one code this kind loses two voxels and gains one, any sensor gains one: both counts share a number."""
    cover = cover_of(0b0000_0011, 0b0000_0100, cameras=0b0000_0011, lidars=0b0000_0011)
    assert settled(cover, arrived=[1], leaving=[0]) == ([-10, -1, 0, -1], [10, 1, 0, 1])


def test_voxels_gained_where_the_other_kind_looks_and_lost_where_it_does_not() -> None:
    cover = cover_of(0b0000_0100, 0b0000_0011, cameras=0b0000_0011, lidars=0b0000_0100)
    assert settled(cover, arrived=[1], leaving=[0]) == ([10, 1, 0, 1], [-10, -1, 0, -1])


def test_voxels_that_are_not_informative_count_for_nothing() -> None:
    cover = cover_of(0b0000_0011)
    assert settled(cover, arrived=[0], entropies=one_word(0b1111_1101)) == ([10, 1, 0, 1], [10, 1, 0, 1])
    assert cover.union.tolist() == [[0], [0b0000_0001]]


def test_several_sensors_arrive_at_once() -> None:
    cover = cover_of(0b0000_0011, 0b0001_0010)
    assert settled(cover, arrived=[0, 1])[0] == [120, 4, 5, 3]


def test_a_sensor_that_comes_back_to_the_same_place_changes_nothing() -> None:
    cover = cover_of(0b0101_0101, 0b0101_0101, lidars=0b0101_0101)
    assert settled(cover, arrived=[1], leaving=[0]) == (NONE, NONE)
    assert cover.union.tolist() == [[0], [0b0101_0101]]


# ---------------------------------------------------------------- many words


COUNT = 24
"""Words of the grid in the tests below: two rows of twelve words."""


def many_words() -> Entropies:
    """24 words of one run of four informative voxels each, the even ones with code 0, the odd ones with code 1."""
    return Entropies(
        np.full(COUNT, 0b1111, np.uint64),
        np.full(COUNT, 0b0001, np.uint64),
        np.arange(COUNT + 1, dtype=np.uint32),
        np.arange(COUNT, dtype=np.uint16) % 2,
        PALETTE,
    )


def worth(union: Words) -> Sums:
    """The sums of a set of voxels."""
    even, odd = (sum(int(word).bit_count() for word in union[kind::2]) for kind in (0, 1))
    return [10 * even + 100 * odd, even + 2 * odd, 5 * odd, even + odd]


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize("changing", [1, 2, 3, 12, 13, 15, 24])
def test_few_words_and_many_are_settled_alike_by_one_worker_and_by_several(
    changing: int, workers: int
) -> None:
    """One sensor arrives in some words, another stays in all; each holds two voxels that are not informative too."""
    stack = np.zeros((2, COUNT), np.uint64)
    stack[0, :changing] = 0b0011_0110
    stack[1] = 0b0011_0001
    cover = Cover(stack, np.zeros((2, COUNT), np.uint64))
    cover.union[LIDARS] = 0b0001
    everything = Region(0, 2, 0, 12, 12)
    slots = Slots(np.array([0]), np.array([1]), np.zeros(0, np.int64))
    change = settle(cover, slots, LIDARS, everything, many_words(), workers)
    assert cover.union[LIDARS].tolist() == [0b0111] * changing + [0b0001] * (COUNT - changing)
    gained = np.zeros(COUNT, np.uint64)
    gained[:changing] = 0b0110
    assert change.tolist() == [worth(gained), worth(gained)]


def test_nothing_outside_of_the_region_is_looked_at() -> None:
    stack = np.full((1, COUNT), 0b0001, np.uint64)
    cover = Cover(stack, np.zeros((2, COUNT), np.uint64))
    middle = Region(0, 2, 5, 2, 12)
    slots = Slots(np.array([0]), np.zeros(0, np.int64), np.zeros(0, np.int64))
    change = settle(cover, slots, LIDARS, middle, many_words(), 1)
    assert np.flatnonzero(cover.union[LIDARS]).tolist() == [5, 6, 17, 18]
    assert change[0].tolist() == [220, 6, 10, 4]


KIND_OF = {"lidar": LIDARS, "other lidar": LIDARS, "camera": CAMERAS, "probe": 2}


@pytest.mark.parametrize("kinds", [2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_after_many_edits_the_sums_are_those_of_the_union(seed: int, kinds: int) -> None:
    """Two LiDARs, a camera and perhaps a sensor of a third kind move about; each edit casts into a free slot."""
    rng = np.random.default_rng(seed)
    cover = Cover(np.zeros((5, COUNT), np.uint64), np.zeros((kinds, COUNT), np.uint64))
    everything, sums = Region(0, 2, 0, 12, 12), np.zeros((kinds + 1, 4), np.int64)
    names = [name for name, kind in KIND_OF.items() if kind < kinds]
    held: dict[str, int] = {}
    for _ in range(30):
        name = str(rng.choice(names))
        kind = KIND_OF[name]
        free = next(slot for slot in range(5) if slot not in held.values())
        leaving = [held.pop(name)] if name in held else []
        moved = rng.random(COUNT) < rng.choice([0.05, 0.9])
        before = cover.stack[leaving[0]] if leaving else np.zeros(COUNT, np.uint64)
        cover.stack[free] = np.where(moved, rng.integers(0, 64, COUNT, np.uint64), before)
        staying = [slot for other, slot in held.items() if KIND_OF[other] == kind]
        slots = Slots(np.array([free]), np.array(staying, np.int64), np.array(leaving, np.int64))
        change = settle(cover, slots, kind, everything, many_words(), 2)
        sums[kind] += change[0]
        sums[-1] += change[1]
        held[name] = free
    for found, union in zip(sums.tolist(), (*cover.union, np.bitwise_or.reduce(cover.union)), strict=True):
        assert found == worth(union)
    lidars = [cover.stack[slot] for name, slot in held.items() if KIND_OF[name] == LIDARS]
    assert np.array_equal(cover.union[LIDARS], np.bitwise_or.reduce(lidars) & np.uint64(0b1111))


# ---------------------------------------------------------------- others, counted


def tally(stack: Words, slots: Sequence[int]) -> np.ndarray:
    """By how many of some slots each of the 64 voxels of each word is seen, (words, 64)."""
    bits = (stack[list(slots), :, None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    return np.asarray(bits.sum(axis=0))


def number(counts: Words) -> np.ndarray:
    """The same of counts in binary digits."""
    weights = (1 << np.arange(len(counts)))[:, None, None]
    return np.asarray(
        (((counts[:, :, None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)) * weights).sum(axis=0)
    )


@pytest.mark.parametrize("workers", [1, 3])
def test_others_are_counted_and_no_more_in_any_order(workers: int) -> None:
    """Nine sensors become others and cease to be, some at a time, in a region that leaves out two words of a row."""
    rng = np.random.default_rng(workers)
    stack = rng.integers(0, 1 << 63, (9, COUNT), np.uint64) | rng.integers(0, 1 << 63, (9, COUNT), np.uint64)
    stack[:, [0, 11, 12, 23]] = 0
    keep, counts = rng.integers(0, 1 << 63, COUNT, np.uint64), np.zeros((4, COUNT), np.uint64)
    region, free, others = Region(0, 2, 1, 10, 12), np.full(COUNT, BROKEN, np.uint64), set[int]()
    inside = np.r_[1:11, 13:23]
    for wanted in ({0, 1, 2}, {1, 2, 3}, set(range(9)), {8}, set(), {4, 5}, {6, 7, 8, 0, 1, 2, 3}):
        slots = kernel.Slots(
            *(np.array(sorted(part), np.int64) for part in (wanted - others, others - wanted))
        )
        kernel.count_others(stack, slots, region, keep, workers, counts, free)
        others = wanted
        seen = tally(stack, sorted(others))
        assert np.array_equal(number(counts), seen)
        expected = keep & ~np.bitwise_or.reduce(stack[sorted(others)], axis=0, initial=np.uint64(0))
        assert np.array_equal(free[inside], expected[inside])
        assert (free[[0, 11, 12, 23]] == BROKEN).all()
