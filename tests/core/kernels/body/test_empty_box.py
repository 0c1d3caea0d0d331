"""The box around a cell that holds nothing: empty, within its limits, and no layer can be added."""

import numpy as np
import pytest

from riglens.core.kernels.body.empty_box import grow_empty_box
from riglens.core.scene.columns import pack
from riglens.core.scene.grid import VoxelGrid


def grown(full: np.ndarray, cell: tuple[int, int, int], limits: list[int]) -> list[int]:
    box = grow_empty_box(
        pack(VoxelGrid(1.0, full.shape), full),
        np.array(full.shape, np.int64),
        np.array(cell, np.int64),
        np.array(limits, np.int64),
    )
    return [int(side) for side in box]


def inside(box: list[int]) -> tuple[slice, slice, slice]:
    return slice(box[0], box[1]), slice(box[2], box[3]), slice(box[4], box[5])


def test_an_empty_grid_is_void_up_to_the_limits() -> None:
    limits = [1, 5, 0, 4, 2, 7]
    assert grown(np.zeros((6, 4, 9), np.bool_), (2, 2, 3), limits) == limits


def test_a_cell_that_holds_something_has_no_void() -> None:
    assert grown(np.ones((3, 3, 3), np.bool_), (1, 1, 1), [0, 3, 0, 3, 0, 3]) == [0] * 6


def test_of_two_ways_to_grow_the_larger_box_counts() -> None:
    """A post beside the cell: growing along y first keeps the whole length of y, growing along x first stops there."""
    full = np.zeros((3, 12, 1), np.bool_)
    full[2, 6, 0] = True
    assert grown(full, (1, 4, 0), [0, 3, 0, 12, 0, 1]) == [0, 2, 0, 12, 0, 1]


@pytest.mark.parametrize("seed", range(8))
def test_no_layer_can_be_added(seed: int) -> None:
    rng = np.random.default_rng(seed)
    full = rng.random((7, 6, (5, 130)[seed % 2])) < rng.choice([0.005, 0.1])
    cell = tuple(int(rng.integers(size)) for size in full.shape)
    full[cell] = False
    limits = [
        bound for place, size in zip(cell, full.shape, strict=True) for bound in (max(place - 3, 0), size)
    ]
    box = grown(full, cell, limits)
    assert not full[inside(box)].any() and full[inside(box)].size > 0
    assert all(low <= place < high for place, low, high in zip(cell, box[::2], box[1::2], strict=True))
    for side in range(6):
        larger = list(box)
        larger[side] += 1 if side % 2 else -1
        assert box[side] == limits[side] or full[inside(larger)].any()
