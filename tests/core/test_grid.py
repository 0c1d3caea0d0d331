"""The grid: what it accepts, where its voxels lie, and that it is refused when it does not fit in memory."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.scene.columns import VoxelIndex, empty_words, pack, unpack
from riglens.core.scene.grid import VoxelGrid
from tests.core.builders import grid_of


def test_the_default_is_the_roi_of_the_paper() -> None:
    grid = VoxelGrid()
    assert grid.shape == (600, 400, 40)
    assert grid.origin_m == (-30.0, -20.0, 0.0)
    assert grid.voxel_count == 9_600_000


@pytest.mark.parametrize(
    ("voxel_m", "shape"),
    [(0.05, (1200, 800, 80)), (0.2, (300, 200, 20)), (0.4, (150, 100, 10)), (0.025, (2400, 1600, 160))],
)
def test_other_voxels_divide_the_roi(voxel_m: float, shape: tuple[int, int, int]) -> None:
    assert VoxelGrid(voxel_m).shape == shape


@pytest.mark.parametrize("side", [0.0, -4.0, math.nan, math.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_roi_that_is_no_length_is_refused_by_its_name(side: float, axis: int) -> None:
    roi = [4.0, 4.0, 4.0]
    roi[axis] = side
    with pytest.raises(InputError, match=rf"^roi_m {'LWH'[axis]} must be above 0"):
        VoxelGrid(0.5, (roi[0], roi[1], roi[2]))


@pytest.mark.parametrize("roi", [(4.2, 4.0, 4.0), (4.0, 4.0, 0.2), (60.0, 40.0, 4.05)])
def test_a_roi_that_is_no_multiple_of_the_voxel_is_refused_with_the_nearest_length(
    roi: tuple[float, ...],
) -> None:
    with pytest.raises(InputError, match=r"must be a multiple of the voxel edge 0\.5 m, such as"):
        VoxelGrid(0.5, (roi[0], roi[1], roi[2]))


@given(count=st.integers(1, 3000), voxel_m=st.sampled_from([0.01, 0.05, 0.1, 0.3, 0.7, 1 / 3, 0.025]))
def test_every_whole_number_of_voxels_is_accepted(count: int, voxel_m: float) -> None:
    assert VoxelGrid(voxel_m, (count * voxel_m, voxel_m, voxel_m)).shape == (count, 1, 1)


@pytest.mark.parametrize("voxel_m", [1e-4, 1e-9, 1e-300])
def test_a_grid_beyond_any_memory_is_refused_at_once(voxel_m: float) -> None:
    with pytest.raises(InputError, match="too large"):
        VoxelGrid(voxel_m)


def test_columns_beyond_the_reach_of_their_index_are_refused() -> None:
    with pytest.raises(InputError, match="too large"):
        VoxelGrid(0.001, (60.0, 40.0, 0.001))


def test_a_grid_that_does_not_fit_in_free_memory_is_refused_with_its_size() -> None:
    grid = VoxelGrid(0.01)
    with pytest.raises(InputError, match=r"9600000000 voxels|6000 x 4000 x 400 voxels needs .* GB") as caught:
        grid.require_memory(1e6, "this test")
    assert "\n" not in str(caught.value)
    grid_of(2, 2, 2).require_memory(1.0, "this test")


@given(st.tuples(*[st.integers(0, 11)] * 3))
def test_centres_lie_half_a_voxel_behind_whole_grid_coordinates(cell: tuple[int, int, int]) -> None:
    grid = grid_of(12, 12, 12, 0.25)
    centre = tuple(float(grid.centres_m(axis)[i]) for axis, i in enumerate(cell))
    assert grid.to_grid(centre) == tuple(i + 0.5 for i in cell)


def test_more_voxels_than_ids_are_refused() -> None:
    grid = VoxelGrid(1.0, (8192.0, 8193.0, 64.0))
    full = np.broadcast_to(np.uint64(2**64 - 1), (8192 * 8193,))  # one word, shown everywhere
    with pytest.raises(ValueError, match="4,294,967,295"):
        VoxelIndex.of(grid, full)


@given(
    seed=st.integers(0, 2**32 - 1),
    nz=st.sampled_from([1, 7, 63, 64, 65, 130]),
    share=st.sampled_from([0.0, 0.01, 0.5, 1.0]),
)
def test_sets_of_voxels_survive_packing_and_are_numbered_in_order(seed: int, nz: int, share: float) -> None:
    grid = grid_of(4, 3, nz)
    mask = np.random.default_rng(seed).random(grid.shape) < share
    words = pack(grid, mask)
    assert words.shape == empty_words(grid).shape
    assert np.array_equal(unpack(grid, words), mask)
    index = VoxelIndex.of(grid, words)
    assert index.count == mask.sum()
    assert np.array_equal(index.ijk(), np.argwhere(mask))
    column = np.pad(mask, ((0, 0), (0, 0), (0, -nz % 64))).reshape(12 * (-(-nz // 64)), 64)
    assert np.array_equal(index.first, np.concatenate([[0], np.cumsum(column.sum(axis=1))]))
    if mask.any():
        low, high = np.argwhere(mask).min(axis=0), np.argwhere(mask).max(axis=0) + 1
        assert index.bounds.reshape(3, 2).T.tolist() == [low.tolist(), high.tolist()]
    else:
        assert (np.diff(index.bounds.reshape(3, 2)) == 0).all()
