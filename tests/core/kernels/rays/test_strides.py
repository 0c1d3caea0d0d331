"""Rays in strides through a grid of 4 x 4 x 4: they mark what the exact walk meets, and decline what is close."""

from __future__ import annotations

import math

import numpy as np
import pytest

from riglens.core.kernels.fans.fan import FARTHEST_ORIGIN
from riglens.core.kernels.rays.strides import (
    _CLOSE,
    BITS,
    CLOSE,
    LONGEST,
    SLANTED,
    STEEPEST,
    _is_close,
    _strides_in_level,
    stride,
)
from riglens.core.kernels.rays.walk import FARTHEST, Ray, walk_exact
from tests.core.kernels.tiny import BOX, SHAPE, SIDE, Voxel, no_voxels, row, voxels_of

Place = tuple[float, float, float]
HEIGHT = 1.25
U = 2.0**-53


def unit(d: Place) -> Place:
    """The direction with length 1."""
    length = math.hypot(*d)
    return d[0] / length, d[1] / length, d[2] / length


def strode(g: Place, d: Place, near: float = 0.0, far: float = FARTHEST) -> set[Voxel] | None:
    """The voxels marked; None where the ray is left to the exact walk."""
    marks = no_voxels()
    is_clear = stride(g, unit(d), near, far, BOX, SHAPE, marks)
    return voxels_of(marks) if is_clear else None


def walked(g: Place, d: Place, near: float = 0.0, far: float = FARTHEST) -> set[Voxel]:
    """The voxels of the exact walk."""
    runs = np.empty((3 * SIDE + 3, 3), np.int32)
    count = walk_exact(Ray(g, unit(d), near, far), BOX, SIDE, runs)
    return {(int(c) // SIDE, int(c) % SIDE, z) for c, low, high in runs[:count] for z in range(low, high + 1)}


def test_a_ray_that_stays_in_its_row_and_level() -> None:
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.01, 0.01)) == row(range(4), 1, 1)
    assert strode((3.5, 1.4, HEIGHT), (-1.0, 0.01, 0.01)) == row(range(4), 1, 1)
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.0)) == row(range(4), 1, 1)


def test_a_stride_that_changes_the_column_marks_both() -> None:
    """From y = 1.4 with slope 1/2: at x = 1, 2, 3 it is at 1.65, 2.15, 2.65."""
    expected = {(0, 1, 1), (1, 1, 1), (1, 2, 1), (2, 2, 1), (3, 2, 1), (3, 3, 1)}
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.5, 0.0)) == expected
    turned = {(y, x, z) for x, y, z in expected}
    assert strode((1.4, 0.5, HEIGHT), (0.5, 1.0, 0.0)) == turned


def test_a_stride_that_changes_column_and_level_turns_in_their_order() -> None:
    """At x = 1.7 it is at y = 2, and at z = 2 where x = 1.8; the other one is at z = 2 where x = 1.6."""
    assert strode((0.5, 1.4, 1.35), (1.0, 0.5, 0.5)) == {
        (0, 1, 1), (1, 1, 1), (1, 2, 1), (1, 2, 2), (2, 2, 2), (3, 2, 2), (3, 3, 2), (3, 3, 3),
    }  # fmt: skip
    late = strode((0.5, 1.4, 1.45), (1.0, 0.5, 0.5))
    assert late is not None and {(1, 1, 1), (1, 1, 2), (1, 2, 2)} <= late and (1, 2, 1) not in late


def test_from_outside_it_begins_where_it_enters() -> None:
    assert strode((-5.0, 1.4, HEIGHT), (1.0, 0.0, 0.0)) == row(range(4), 1, 1)
    assert strode((2.4, 1.4, 9.3), (0.2, 0.0, -1.0)) == walked((2.4, 1.4, 9.3), (0.2, 0.0, -1.0)) != set()


@pytest.mark.parametrize(
    ("g", "d"),
    [
        ((-1.0, 1.4, HEIGHT), (-1.0, 0.1, 0.1)),
        ((0.5, 4.0, HEIGHT), (1.0, 0.0, 0.1)),  # the upper faces are outside of the grid
        ((0.5, -0.1, HEIGHT), (1.0, 0.0, 0.1)),
        ((-2.0, 1.4, HEIGHT), (1.0, 0.1, 3.0)),
    ],
)
def test_a_ray_that_misses_the_box_is_clear_and_marks_nothing(g: Place, d: Place) -> None:
    assert strode(g, d) == set()


def test_from_a_face_it_begins_on_the_side_to_which_it_goes() -> None:
    assert strode((2.0, 1.4, 2.0), (1.0, 0.1, -0.1)) == row((2, 3), 1, 1)
    assert strode((2.0, 1.4, 2.0), (-1.0, 0.1, 0.1)) == row((0, 1), 1, 2)


def test_it_begins_and_ends_at_its_range() -> None:
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.01), 1.0, 2.0) == row((1, 2), 1, 1)
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.01), 1.0, 1.2) == row((1,), 1, 1)
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.01), 2.0, 1.0) == set()
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.01), 0.0, 2.5 * CLOSE) == row((0,), 1, 1)


@pytest.mark.parametrize(
    ("g", "d"),
    [
        ((0.5, 0.5, HEIGHT), (1.0, 1.0, 0.1)),  # through edges
        ((0.5, 1.4, 1.5), (1.0, 0.0, 1.0)),  # levels that change at faces
        ((0.5, 2.0, HEIGHT), (1.0, 0.0, 0.1)),  # in a face
        ((0.5, 1.4, 2.0), (1.0, 0.3, 0.0)),
        ((1.5, 1.5, 0.5), (1e-4, 0.0, 1.0)),  # steep
        ((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.5 * CLOSE)),
        ((0.5, 1.5 - 0.4 * SLANTED, 1.5 - 0.4), (1.0, SLANTED, 1.0)),
    ],
)
def test_what_is_close_is_left_to_the_exact_walk_or_the_same(g: Place, d: Place) -> None:
    assert strode(g, d) in (None, walked(g, d))


@pytest.mark.parametrize(
    ("g", "d"),
    [
        ((0.5, 1.4, 2.0), (1.0, 0.3, 0.0)),
        ((0.5, 2.0, HEIGHT), (1.0, 0.0, 0.1)),
        ((2.0, 3.5, 2.0), (0.0, -1.0, 0.0)),
        ((-1.0, 2.0, 3.0), (1.0, -0.0, -0.0)),
        ((0.5, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((0.5, 1.4, 2.0), (1.0, 0.3, 1e-17)),  # next to a face
        ((0.5, 1.4, 2.0), (1.0, 0.3, -1e-17)),
        ((3.5, 2.0, 2.0), (-1.0, -1e-17, 1e-17)),
        ((0.5, 1.4, 4.0), (1.0, 0.3, -1e-17)),  # under the upper face of the box
    ],
)
def test_a_ray_in_a_face_or_along_it_stays_in_one_cell(g: Place, d: Place) -> None:
    assert strode(g, d) == walked(g, d) != set()


def test_a_ray_that_comes_through_a_face_is_left_to_the_exact_walk() -> None:
    assert strode((0.5, 1.4, 2.0 + 4e-16), (1.0, 0.3, -1e-15)) is None


def test_a_ray_in_the_upper_face_of_the_box_marks_nothing() -> None:
    assert strode((0.5, 1.4, float(SIDE)), (1.0, 0.3, 0.0)) == set()
    assert strode((0.5, 1.4, 0.0), (1.0, 0.3, -1e-17)) == walked((0.5, 1.4, 0.0), (1.0, 0.3, -1e-17)) == set()


@pytest.mark.parametrize("off", [0.3 * CLOSE, -0.3 * CLOSE])
def test_what_is_close_to_an_edge_is_declined(off: float) -> None:
    """At x = 2 it is at y = 2; at x = 1.5 and y = 2 it is at z = 2; it comes in and ends beside a face."""
    assert strode((0.5, 0.5 + off, HEIGHT), (1.0, 1.0, 0.01)) is None
    assert strode((0.5, 0.75 + off, HEIGHT), (1.0, 0.5, 0.01)) is None
    assert strode((0.25, 1.5, 1.375 + off), (1.0, 0.4, 0.5)) is None
    assert strode((-1.0, 1.0 + off, HEIGHT), (1.0, math.copysign(1e-10, -off), 0.01)) is None
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.0), 0.0, 1.5 + off) is None
    assert strode((0.5, 1.4, HEIGHT), (1.0, 0.0, 0.0), 0.5 + off) is None


def test_random_rays_are_those_of_the_exact_walk_and_hardly_one_is_declined() -> None:
    rng = np.random.default_rng(5)
    declined = 0
    for _ in range(3000):
        x, y, z = (float(p) for p in rng.uniform(-1.0, SIDE + 1.0, 3))
        d = tuple(float(c) for c in rng.normal(size=3) * rng.choice([1.0, 1e-3, 0.2], 3))
        near = float(rng.choice([0.0, rng.uniform(0.0, 3.0)]))
        far = float(rng.choice([FARTHEST, near + rng.uniform(0.0, 4.0)]))
        seen = strode((x, y, z), (d[0], d[1], d[2]), near, far)
        declined += seen is None
        assert seen in (None, walked((x, y, z), (d[0], d[1], d[2]), near, far))
    assert declined < 150  # of which most are steep


def test_round_places_and_directions_are_those_of_the_exact_walk() -> None:
    rng = np.random.default_rng(6)
    clear = 0
    for _ in range(3000):
        x, y, z = (float(p) for p in rng.integers(-2, 11, 3) / 2.0)
        d = tuple(float(c) for c in rng.integers(-3, 4, 3))
        if d == (0.0, 0.0, 0.0):
            continue
        seen = strode((x, y, z), (d[0], d[1], d[2]))
        clear += bool(seen)
        assert seen in (None, walked((x, y, z), (d[0], d[1], d[2])))
    assert clear > 100


ONE = 1 << BITS


@pytest.mark.parametrize(
    "rise", [0, 1, -1, 3 << 36, -(3 << 36), 12345678901, -9876543210, ONE, -ONE, 5 * ONE]
)
@pytest.mark.parametrize(
    "above",
    [
        0,
        _CLOSE,
        _CLOSE + 1,
        ONE // 2,
        ONE // 2 + 1,
        ONE - _CLOSE - 1,
        ONE - _CLOSE,
        ONE,
        -1,
        -ONE // 2,
        3 * ONE,
    ],
)
def test_strides_that_end_in_a_level_are_counted(above: int, rise: int) -> None:
    expected = 0
    while expected < 500 and 0 <= above + expected * rise < ONE and not _is_close(above + expected * rise):
        expected += 1
    count = int(_strides_in_level(above, rise))
    assert min(count, 500) == expected or (rise == 0 and 1 <= count <= expected)


def test_the_last_stride_in_a_level_may_end_as_close_to_a_face_as_is_clear() -> None:
    for strides in (1, 2, 7, 1000):
        for off, more in ((0, 1), (1, 0)):
            rise = (ONE - 2 * _CLOSE - 2 - strides) // strides
            above = ONE - _CLOSE - 1 - strides * rise + off
            assert int(_strides_in_level(above, rise)) == strides + more
            assert int(_strides_in_level(ONE - above, -rise)) == strides + more


def test_long_flat_rays_are_those_of_the_exact_walk() -> None:
    """Through 90 x 50 columns of 70 levels: many strides in each level, up and down, along both axes."""
    rng, shape, clear = np.random.default_rng(7), (90, 50, 70), 0
    box, runs = np.array([0, 90, 0, 50, 0, 70]), np.empty((300, 3), np.int32)
    for _ in range(800):
        place = tuple(float(p) for p in rng.uniform(0.0, shape))
        d = tuple(float(c) for c in rng.normal(size=3) * (1.0, 1.0, rng.choice([0.0, 1e-3, 0.05, 0.5])))
        marks = np.zeros(90 * 50 * 2, np.uint64)
        if not stride(place, unit((d[0], d[1], d[2])), 0.0, FARTHEST, box, np.array(shape), marks):
            continue
        expected, clear = np.zeros_like(marks), clear + 1
        g = (place[0], place[1], place[2])
        count = walk_exact(Ray(g, unit((d[0], d[1], d[2])), 0.0, FARTHEST), box, 50, runs)
        for column, low, high in runs[:count].tolist():
            for level in range(low, high + 1):
                expected[2 * column + level // 64] |= np.uint64(1 << level % 64)
        assert np.array_equal(marks, expected)
    assert clear > 780


def test_columns_of_several_words() -> None:
    """A ray that climbs from level 60 to 70 marks the levels in both words of its columns."""
    marks = np.zeros(4 * 2 * 2, np.uint64)
    box, shape = np.array([0, 4, 0, 2, 0, 100]), np.array([4, 2, 100])
    assert stride((0.5, 0.5, 60.3), unit((1.0, 0.0, 2.6)), 0.0, FARTHEST, box, shape, marks)
    runs = np.empty((200, 3), np.int32)
    count = walk_exact(Ray((0.5, 0.5, 60.3), unit((1.0, 0.0, 2.6)), 0.0, FARTHEST), box, 2, runs)
    expected = {(int(c), z) for c, low, high in runs[:count] for z in range(low, high + 1)}
    found = {(w // 2, 64 * (w % 2) + b) for w in range(16) for b in range(64) if int(marks[w]) >> b & 1}
    assert found == expected and max(z for _, z in found) > 66


def test_what_is_called_clear_is_clear() -> None:
    """Places where strides begin, and what is added up over a grid, are good to a small part of what must be clear."""
    longest = 3.0 * FARTHEST_ORIGIN * STEEPEST
    begins = 8.0 * U * longest
    strides = 2.0 * FARTHEST_ORIGIN * (0.5 * 2.0**-BITS + STEEPEST * 2.0 * U) + 2.0**-BITS
    assert begins + strides < CLOSE / 4.0
    assert 8.0 * U * 3.0 * FARTHEST_ORIGIN / SLANTED < CLOSE / 4.0
    assert FARTHEST_ORIGIN * 2.0**BITS * 2.0 < 2.0**62
    assert 2.0 * FARTHEST_ORIGIN * math.sqrt(3.0) < LONGEST
