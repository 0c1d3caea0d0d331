"""The map from above is the plain sum over each column, whatever came before it, and tells blind from empty."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.scene.columns import empty_words, pack
from riglens.core.view.top_view import BLIND, EMPTY, LEAST, MOST
from riglens.core.view.top_views import TopViews
from tests.core.builders import dense_h, grid_of, synthetic_pog

GRID = grid_of(13, 11, 70, 0.5)
FRAMES = 20


def field_of(seed: int, share: float = 0.05) -> EntropyField:
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, FRAMES + 1, (*GRID.shape, 3)) * (rng.random((*GRID.shape, 3)) < share)
    return EntropyField.from_pog(synthetic_pog(GRID, counts, FRAMES))


def per_cell(values: np.ndarray, block: int) -> np.ndarray:
    """Plain sums of dense values (nx, ny, nz) over blocks of whole columns."""
    sums = np.zeros([-(-n // block) for n in GRID.shape[:2]])
    for ix, iy in np.ndindex(*GRID.shape[:2]):
        sums[ix // block, iy // block] += values[ix, iy].sum()
    return sums


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), limit=st.sampled_from([1, 20, 60, 1000]))
def test_cells_hold_the_entropy_of_their_columns_and_the_share_seen(seed: int, limit: int) -> None:
    field, mask = field_of(seed), np.random.default_rng(seed).random(GRID.shape) < 0.5
    views = TopViews(field, limit)
    h = dense_h(field) / QUANTA_PER_NAT
    for cls in range(3):
        view = views.view(cls, "any name", "any", pack(GRID, mask))
        total, seen = per_cell(h[..., cls], views.block), per_cell(h[..., cls] * mask, views.block)
        assert view.levels.size <= limit
        np.testing.assert_allclose(view.entropy_nat, total, rtol=1e-6)
        np.testing.assert_allclose(view.seen * view.entropy_nat, seen, rtol=1e-5, atol=1e-6)


@settings(max_examples=10)
@given(seeds=st.lists(st.integers(0, 2**32 - 1), min_size=2, max_size=4), cls=st.integers(0, 2))
def test_a_view_is_the_same_whatever_was_shown_before_it(seeds: list[int], cls: int) -> None:
    field = field_of(1)
    masks = [pack(GRID, np.random.default_rng(seed).random(GRID.shape) < 0.5) for seed in seeds]
    views = TopViews(field)
    for number, mask in enumerate(masks):
        last = views.view((cls + number) % 3 if number == 1 else cls, "any name", "any", mask)
    if len(masks) == 2:
        last = views.view(cls, "any name", "any", masks[-1])
    fresh = TopViews(field).view(cls, "any name", "any", masks[-1])
    np.testing.assert_array_equal(last.seen, fresh.seen)
    np.testing.assert_array_equal(last.levels, fresh.levels)


def test_blind_cells_differ_from_empty_ones_and_from_the_least_share() -> None:
    counts = np.zeros((*GRID.shape, 3), np.int64)
    counts[2, 3, 4, 0] = counts[2, 4, 4, 0] = counts[2, 4, 5, 0] = counts[7, 7, 7, 0] = 10
    field = EntropyField.from_pog(synthetic_pog(GRID, counts, FRAMES))
    seen = np.zeros(GRID.shape, bool)
    seen[2, 4, 4] = seen[7, 7, 7] = True
    view = TopViews(field).view(0, "car", "lidar", pack(GRID, seen))
    assert view.levels[0, 0] == EMPTY
    assert view.levels[2, 3] == BLIND
    assert view.levels[2, 4] == LEAST + round((MOST - LEAST) / 2)
    assert view.levels[7, 7] == MOST
    assert np.count_nonzero(view.levels) == 3
    assert view.blind_share() == pytest.approx(1 / 3)
    assert not view.is_empty


def test_a_class_without_boxes_has_an_empty_map() -> None:
    counts = np.zeros((*GRID.shape, 3), np.int64)
    counts[1, 1, 1, 0] = 5
    field = EntropyField.from_pog(synthetic_pog(GRID, counts, FRAMES))
    view = TopViews(field).view(2, "pedestrian", "any", empty_words(GRID))
    assert view.is_empty
    assert view.blind_share() == 0.0


def test_a_point_is_found_in_the_cell_around_it_and_nowhere_outside_the_roi() -> None:
    view = TopViews(field_of(3)).view(0, "car", "any", empty_words(GRID))
    x_low, y_low = view.origin_m
    assert view.cell_at(x_low + 0.01, y_low + 0.01) == (0, 0)
    assert view.cell_at(x_low + 2.7 * view.cell_m, y_low + 4.2 * view.cell_m) == (2, 4)
    assert view.cell_at(x_low - 0.01, 0.0) is None
    assert view.cell_at(0.0, -y_low + 0.01) is None
