"""What the detector sees of a sweep, by hand, and what it shall answer."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from riglens.core.detect.pillars import FEATURES, SLICES_M, Region, Sample, Samples, pillars, wanted

REGION = Region(16.0, 8.0)


def at(*points: tuple[float, float, float]) -> np.ndarray:
    return np.array(points, np.float32).reshape(-1, 3)


def literal(points: np.ndarray, bright: np.ndarray) -> dict[int, list[float]]:
    """Figures of each occupied cell, one cell after the other."""
    cells: dict[int, list[int]] = {}
    for number, (x, y, z) in enumerate(points.astype(np.float64)):
        row, column = int(np.floor((x + 8) / 0.25)), int(np.floor((y + 4) / 0.25))
        if 0 <= row < 64 and 0 <= column < 32 and z < 4:
            cells.setdefault(row * 32 + column, []).append(number)
    found = {}
    for cell, mine in cells.items():
        x, y, z = points[mine].astype(np.float64).T
        counts = [((z >= a) & (z < b)).sum() for a, b in pairwise(SLICES_M)]
        found[cell] = [
            np.log1p(len(mine)) / 4, z.max() / 2, z.min() / 2, z.mean() / 2, bright[mine].mean() / 255,
            np.mean((x + 8) / 0.25 % 1) - 0.5, np.mean((y + 4) / 0.25 % 1) - 0.5, *(np.log1p(counts) / 3),
        ]  # fmt: skip
    return found


def test_figures_are_those_of_a_literal_reckoning() -> None:
    rng = np.random.default_rng(0)
    points = (rng.uniform([-9, -5, -0.1], [9, 5, 4.5], (900, 3))).astype(np.float32)
    bright = rng.uniform(0, 255, 900).astype(np.float32)
    cell, features = pillars(points, bright, REGION)
    expected = literal(points, bright)
    assert cell.tolist() == sorted(expected)
    assert features == pytest.approx(
        np.array([expected[one] for one in cell.tolist()]), abs=2e-3
    )  # half precision


def test_the_order_of_points_does_not_matter() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform(-3, 3, (500, 3)).astype(np.float32)
    order = rng.permutation(500)
    one, other = pillars(points, points[:, 0], REGION), pillars(points[order], points[order, 0], REGION)
    assert (one[0] == other[0]).all() and np.allclose(one[1], other[1], atol=1e-3)


def test_no_points_are_no_cells() -> None:
    cell, features = pillars(at((0, 0, 5.0), (99, 0, 1)), np.zeros(2, np.float32), REGION)
    assert cell.shape == (0,) and features.shape == (0, FEATURES)


def test_what_cameras_say_is_averaged_over_the_points_of_a_column() -> None:
    points, bright = at((0.1, 0.1, 1.0), (0.12, 0.1, 1.1), (1.0, 1.0, 0.5)), np.zeros(3, np.float32)
    said = np.array([[1.0, 0.0], [1.0, 0.5], [0.0, 0.0]])
    cell, features = pillars(points, bright, REGION, said)
    plain = pillars(points, bright, REGION)
    assert (cell == plain[0]).all() and (features[:, :FEATURES] == plain[1]).all()
    assert features[:, FEATURES:].tolist() == [[1.0, 0.25], [0.0, 0.0]]
    assert pillars(at(), bright[:0], REGION, said[:0])[1].shape == (0, FEATURES + 2)


def sample(*objects: tuple[int, float, float, int]) -> Sample:
    cls, x, y, points = np.array(objects, np.float64).reshape(-1, 4).T
    nothing = pillars(at(), np.zeros(0, np.float32), REGION)
    return Sample(*nothing, cls.astype(np.uint8), np.stack([x, y], axis=1), points.astype(np.int64))


def test_a_peak_stands_where_an_object_with_points_stands() -> None:
    peaks, places, cells = wanted(sample((0, 0.6, -0.1, 4), (2, 3.2, 3.2, 0)), REGION)
    assert peaks.shape == (3, 32, 16)
    assert np.argwhere(peaks == 1.0).tolist() == [[0, 17, 7]]
    assert places == pytest.approx(np.array([[0.2, 0.8]]))
    assert cells.tolist() == [17 * 16 + 7]
    assert peaks[0, 18, 7] == pytest.approx(np.exp(-1 / (2 * 1.6**2)))
    assert not peaks[1:].any()


def test_peaks_at_the_edge_are_cut_and_near_ones_do_not_add_up() -> None:
    peaks, _, _ = wanted(sample((1, -8.0, -4.0, 1), (1, -7.0, -4.0, 1)), REGION)
    assert peaks.max() == 1.0 and peaks[1, 0, 0] == peaks[1, 2, 0] == 1.0
    assert peaks[1, 1, 0] == pytest.approx(np.exp(-0.5))


def test_of_two_objects_in_a_cell_the_later_says_where() -> None:
    _, places, cells = wanted(sample((0, 0.1, 0.1, 1), (1, 0.4, 0.4, 1)), REGION)
    assert len(cells) == 1 and places == pytest.approx(np.array([[0.8, 0.8]]))


@pytest.mark.parametrize("mirror", range(4))
def test_mirrored_cells_are_those_of_the_mirrored_region(mirror: int) -> None:
    cells = np.arange(np.prod(REGION.shape), dtype=np.int32).reshape(REGION.shape)
    flipped = cells[:: -1 if mirror & 2 else 1, :: -1 if mirror & 1 else 1]
    np.testing.assert_array_equal(REGION.mirrored(cells, mirror), flipped)


def test_packed_samples_come_back() -> None:
    one, other = sample((0, 1, 1, 3)), sample((1, 2, 2, 5), (2, 0, 0, 0))
    filled = one._replace(cell=np.array([3], np.int32), features=np.ones((1, FEATURES), np.float16))
    packed = Samples.of([7, 2, 9], iter([filled, other, sample()]))
    assert packed.frame.tolist() == [7, 2, 9] and len(packed) == 3
    for place, expected in enumerate([filled, other, sample()]):
        for column, wanted_column in zip(packed[place], expected, strict=True):
            assert (column == wanted_column).all() and column.dtype == wanted_column.dtype
