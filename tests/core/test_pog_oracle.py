"""The POG counts frames as an independent count of voxel centres in boxes does."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, build_pog
from tests.core.builders import Boxes, boxes_of, grid_of
from tests.core.oracle import occupied_frames

GRID = VoxelGrid(0.4, (6.0, 4.8, 2.0))
TALL = VoxelGrid(0.25, (1.5, 1.0, 20.0))
seeds = st.integers(0, 2**32 - 1)


def random_boxes(rng: np.random.Generator, grid: VoxelGrid, frames: int = 12, upright: bool = False) -> Boxes:
    """Boxes of all classes in and around the ROI; some frames have none, some have many."""
    count = int(rng.integers(0, 25))
    roi = np.array(grid.roi_m)
    angles = rng.uniform(-180.0, 180.0, (count, 3))
    if upright:
        angles[:, 1:] = 0.0
    rotation = np.zeros((0, 3, 3))
    if count:
        rotation = Rotation.from_euler("ZYX", angles, degrees=True).as_matrix()
    if upright:
        rotation[:, 2, 2], rotation[:, 2, :2], rotation[:, :2, 2] = 1.0, 0.0, 0.0
    return Boxes(
        np.sort(rng.integers(0, frames, count)),
        rng.integers(0, 3, count).astype(np.uint8),
        rng.uniform(-0.7, 0.7, (count, 3)) * roi + [0.0, 0.0, roi[2] / 2],
        rng.uniform(0.05, 3.0, (count, 3)),
        rotation,
        frames,
        tuple(np.sort(rng.integers(0, frames, int(rng.integers(0, 4))))),
    )


def dense(pog: Pog) -> np.ndarray:
    """Counts for every voxel of the grid, (nx, ny, nz, 3)."""
    counts = np.zeros((*pog.grid.shape, 3), np.int64)
    i, j, k = pog.index.ijk().T
    counts[i, j, k] = pog.counts
    return counts


@settings(max_examples=60)
@given(seed=seeds, upright=st.booleans(), grid=st.sampled_from([GRID, TALL]))
def test_random_boxes_are_counted_as_the_oracle_does(seed: int, upright: bool, grid: VoxelGrid) -> None:
    boxes = random_boxes(np.random.default_rng(seed), grid, upright=upright)
    pog = build_pog(boxes, grid)
    assert np.array_equal(dense(pog), occupied_frames(grid, boxes.batches()))
    assert pog.counts.any(axis=1).all(), "only occupied voxels are kept"
    for cls in range(3):
        assert np.array_equal(pog.probability(cls), pog.counts[:, cls] / 12)
        assert ((pog.probability(cls) >= 0.0) & (pog.probability(cls) <= 1.0)).all()


@settings(max_examples=25)
@given(seed=seeds)
def test_the_split_into_batches_does_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes = random_boxes(rng, GRID)
    whole = Boxes(**{**vars(boxes), "split": ()})
    one_by_one = Boxes(**{**vars(boxes), "split": tuple(range(12))})
    assert np.array_equal(dense(build_pog(whole, GRID)), dense(build_pog(one_by_one, GRID)))


def test_overlapping_boxes_of_a_frame_count_once() -> None:
    same = (0, 0, (0.0, 0.0, 1.0), (2.0, 2.0, 2.0), 0.3)
    shifted = (0, 0, (0.7, 0.2, 1.0), (2.0, 2.0, 2.0), -0.5)
    pog = build_pog(boxes_of(same, same, shifted, same, frames=1), GRID)
    assert pog.counts[:, 0].max() == 1
    assert pog.probability(0).max() == 1.0


def test_classes_do_not_share_their_counts() -> None:
    place = ((0.0, 0.0, 1.0), (1.0, 1.0, 1.0), 0.0)
    pog = build_pog(boxes_of((0, 0, *place), (0, 2, *place), (1, 2, *place), frames=2), GRID)
    assert set(map(tuple, pog.counts.tolist())) == {(1, 0, 2)}


def test_frames_without_boxes_count_in_t() -> None:
    box = (3, 0, (0.0, 0.0, 1.0), (1.0, 1.0, 1.0), 0.0)
    assert build_pog(boxes_of(box, frames=8), GRID).probability(0).max() == 1 / 8


def test_faces_belong_to_the_box() -> None:
    grid = grid_of(8, 8, 4, 0.5)
    centre = (0.25, 0.25, 0.75)
    pog = build_pog(boxes_of((0, 0, centre, (1.0, 0.5, 0.999), 0.0), frames=1), grid)
    assert sorted(map(tuple, pog.index.ijk().tolist())) == [(3, 4, 1), (4, 4, 1), (5, 4, 1)]


def test_a_box_smaller_than_a_voxel_counts_only_around_a_centre() -> None:
    grid = grid_of(4, 4, 4)
    size = (0.1, 0.1, 0.1)
    assert build_pog(boxes_of((0, 0, (0.5, 0.5, 0.5), size, 0.0), frames=1), grid).index.count == 1
    assert build_pog(boxes_of((0, 0, (0.8, 0.5, 0.5), size, 0.0), frames=1), grid).index.count == 0


def test_boxes_outside_the_roi_or_far_away_are_not_counted() -> None:
    size = (4.0, 2.0, 1.5)
    far = [(0, 0, (x, 0.0, 0.5), size, 0.4) for x in (8.0, -8.0, 1e6, 1e18, -1e300)]
    below = (0, 0, (0.0, 0.0, -2.0), size, 0.0)
    assert build_pog(boxes_of(*far, below, frames=1), GRID).index.count == 0


def test_a_box_that_contains_the_whole_roi_fills_it() -> None:
    pog = build_pog(boxes_of((0, 1, (0.0, 0.0, 0.0), (100.0, 100.0, 100.0), 0.7), frames=1), GRID)
    assert pog.index.count == GRID.voxel_count


def test_a_data_set_of_empty_frames_gives_an_empty_pog() -> None:
    pog = build_pog(boxes_of(frames=5), GRID)
    assert (pog.index.count, pog.data.frames) == (0, 5)


def test_no_frames_at_all_are_refused() -> None:
    with pytest.raises(InputError, match="holds no frames"):
        build_pog(boxes_of(frames=0), GRID)


@pytest.mark.parametrize(("frames", "dtype"), [(65535, np.uint16), (65536, np.uint32), (70000, np.uint32)])
def test_counts_are_wide_enough_for_the_frames(frames: int, dtype: type) -> None:
    grid = grid_of(2, 2, 2)
    rows = np.zeros((frames, 3))
    everywhere = Boxes(
        np.arange(frames),
        np.zeros(frames, np.uint8),
        rows + 0.5,
        rows + 0.2,
        np.broadcast_to(np.eye(3), (frames, 3, 3)).copy(),
        frames,
    )
    pog = build_pog(everywhere, grid)
    assert pog.counts.dtype == dtype
    assert pog.counts.tolist() == [[frames, 0, 0]]
    assert pog.probability(0).tolist() == [1.0]


def test_progress_is_reported_and_may_cancel() -> None:
    heard: list[float] = []
    boxes = boxes_of((0, 0, (0.0, 0.0, 1.0), (1.0, 1.0, 1.0), 0.0), frames=1)
    build_pog(boxes, GRID, heard.append)
    assert heard[-1] == 1.0

    def cancel(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build_pog(boxes, GRID, cancel)
