"""The display grid shows the field faithfully: few cells, entropies conserved, shares as plain sums."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.scene.columns import empty_words, pack
from riglens.core.scene.pog import Pog
from riglens.core.view.display import DisplayGrid
from tests.core.builders import dense_h, evaluate, grid_of, rig_of, spinning, synthetic_pog

GRID = grid_of(13, 11, 70, 0.5)
FRAMES = 20


def scene(seed: int, share: float = 0.05) -> tuple[Pog, EntropyField]:
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, FRAMES + 1, (*GRID.shape, 3)) * (rng.random((*GRID.shape, 3)) < share)
    pog = synthetic_pog(GRID, counts, FRAMES)
    return pog, EntropyField.from_pog(pog)


def cell_rows(display: DisplayGrid) -> dict[tuple[int, ...], int]:
    """Row of each cell by its block indices, from its centre."""
    blocks = np.floor((display.centres_m - np.array(GRID.origin_m)) / display.cell_m).astype(int)
    return {tuple(block): row for row, block in enumerate(blocks.tolist())}


def per_cell(display: DisplayGrid, values: np.ndarray) -> np.ndarray:
    """Plain sums of dense values (nx, ny, nz) over the cells; fails when a value has no cell."""
    rows, sums = cell_rows(display), np.zeros(len(display.centres_m))
    for voxel in np.argwhere(values):
        sums[rows[tuple((voxel // display.block).tolist())]] += values[tuple(voxel)]
    return sums


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), limit=st.sampled_from([1, 5, 60, 400, 200_000]))
def test_cells_stay_within_the_limit_and_are_as_fine_as_it_allows(seed: int, limit: int) -> None:
    pog, field = scene(seed)
    display = DisplayGrid.build(pog, field, limit)
    assert 0 < len(display.centres_m) <= limit
    assert display.cell_m == display.block * GRID.voxel_m
    if display.block > 1:
        finer = np.unique(pog.index.ijk() // (display.block - 1), axis=0)
        assert len(finer) > limit
    assert len(cell_rows(display)) == len(display.centres_m)


@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1), limit=st.sampled_from([5, 400, 200_000]))
def test_cells_hold_sums_of_entropy_largest_p_and_share_seen(seed: int, limit: int) -> None:
    pog, field = scene(seed)
    display = DisplayGrid.build(pog, field, limit)
    seen_mask = np.random.default_rng(seed).random(GRID.shape) < 0.5
    words = pack(GRID, seen_mask)
    h = dense_h(field) / QUANTA_PER_NAT
    for cls in range(3):
        entropy, share = display.entropy(cls), display.seen_share(cls, words)
        plain = per_cell(display, h[..., cls])
        assert entropy == pytest.approx(plain, rel=1e-6)
        assert entropy.sum(dtype=float) == pytest.approx(field.h_total_nat(cls), rel=1e-6)
        assert ((share >= 0.0) & (share <= 1.0)).all()
        seen = per_cell(display, h[..., cls] * seen_mask)
        expected = np.divide(seen, plain, out=np.zeros_like(plain), where=plain > 0.0)
        assert share == pytest.approx(expected, abs=1e-6)


def test_the_probability_of_a_cell_is_the_largest_of_its_voxels() -> None:
    pog, field = scene(3)
    display = DisplayGrid.build(pog, field, 400)
    rows = cell_rows(display)
    for cls in range(3):
        largest = np.zeros(len(display.centres_m))
        for voxel, p in zip(pog.index.ijk(), pog.probability(cls), strict=True):
            row = rows[tuple((voxel // display.block).tolist())]
            largest[row] = max(largest[row], p)
        assert display.probability(cls) == pytest.approx(largest, rel=1e-6)


def test_with_room_enough_every_occupied_voxel_is_a_cell() -> None:
    pog, field = scene(4)
    display = DisplayGrid.build(pog, field)
    expected = np.stack([GRID.centres_m(axis)[pog.index.ijk()[:, axis]] for axis in range(3)], axis=1)
    assert display.block == 1
    assert np.allclose(display.centres_m, expected)


def test_nothing_and_everything_seen() -> None:
    pog, field = scene(5)
    display = DisplayGrid.build(pog, field, 100)
    assert not display.seen_share(0, empty_words(GRID)).any()
    everything = display.seen_share(0, field.index.words)
    assert set(np.unique(everything)) <= {0.0, 1.0}
    assert np.array_equal(everything > 0.0, display.entropy(0) > 0.0)


def test_the_number_of_sensors_of_a_cell_is_that_of_most_of_its_entropy() -> None:
    pog, field = scene(8)
    display = DisplayGrid.build(pog, field, 60)
    covers = np.random.default_rng(8).integers(0, 5, GRID.shape)
    found = display.prevailing(0, np.array([pack(GRID, covers >= level) for level in (1, 2, 3)]))
    h = dense_h(field)[..., 0]
    plain = [per_cell(display, h * (np.minimum(covers, 3) == number)) for number in range(4)]
    assert np.array_equal(found, np.argmax(plain, axis=0))
    assert set(np.unique(found)) == {0.0, 1.0, 2.0, 3.0}


def test_the_entropy_of_a_set_is_spread_over_its_cells() -> None:
    pog, field = scene(9)
    display = DisplayGrid.build(pog, field, 60)
    mask = np.random.default_rng(9).random(GRID.shape) < 0.3
    plain = per_cell(display, dense_h(field)[..., 1] * mask) / QUANTA_PER_NAT
    assert display.seen_entropy(1, pack(GRID, mask)) == pytest.approx(plain, rel=1e-6)


def test_the_seen_set_of_an_evaluation_fits() -> None:
    pog, field = scene(6)
    display = DisplayGrid.build(pog, field, 300)
    result = evaluate(field, rig_of(spinning((0.1, 0.2, 5.0), beams=9, count=90)))
    share, entropy = display.seen_share(0, result.seen["lidar"]), display.entropy(0)
    seen = float((share.astype(float) * entropy).sum()) / field.h_total_nat(0)
    assert seen == pytest.approx(result.scores.classes["car"].lidar.seen, rel=1e-5)
    assert seen > 0.0


def test_an_empty_pog_has_no_cells() -> None:
    pog = synthetic_pog(GRID, np.zeros((*GRID.shape, 3), np.int64), FRAMES)
    display = DisplayGrid.build(pog, EntropyField.from_pog(pog))
    assert display.centres_m.shape == (0, 3)
    assert display.entropy(0).shape == display.probability(0).shape == (0,)
    assert display.seen_share(0, empty_words(GRID)).shape == (0,)


def test_what_was_asked_before_changes_no_answer() -> None:
    pog, field = scene(7)
    words = pack(GRID, np.random.default_rng(7).random(GRID.shape) < 0.5)
    used = DisplayGrid.build(pog, field, 300)
    for cls in (0, 1, 1, 0, 2, 0):
        fresh = DisplayGrid.build(pog, field, 300)
        assert np.array_equal(used.seen_share(cls, words), fresh.seen_share(cls, words))
        assert np.array_equal(used.entropy(cls), fresh.entropy(cls))
