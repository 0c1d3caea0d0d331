"""Distinct cells of objects, against sets: whether a table has a bit for each cell of their block or not."""

import numpy as np
import pytest

from riglens.core.kernels.objects.unique_cells import (
    cell_key,
    cell_of,
    keep_distinct,
    table_mask,
)

NEAR, FAR = 6, 1 << 20
"""Cells along each axis: in the one case a table has bits for all of them, in the other never."""


def random_cells(rng: np.random.Generator, number: int, reach: int) -> np.ndarray:
    """Keys of cells with many equal ones among them."""
    some = rng.integers(-reach, reach, (max(1, number // 2), 3)) + 0.5
    chosen = some[rng.integers(0, len(some), number)]
    start, along = (0.0, 0.0, 0.0), np.zeros((number, 3))
    along[:] = chosen * 0.2
    return np.array([cell_key(start, tuple(d), 1.0 - 1e-3) for d in along], np.int64)


def test_a_cell_is_packed_and_found_again():
    key = cell_key((0.0, 0.3, -0.3), (1.0, 0.0, 0.0), 5.0)
    assert [number - (1 << 20) for number in cell_of(key)] == [25, 1, -2]


@pytest.mark.parametrize("reach", [NEAR, FAR])
@pytest.mark.parametrize("number", [0, 1, 2, 7, 60])
def test_of_one_lidar_the_first_of_equal_cells_are_kept_in_order(number, reach):
    rng = np.random.default_rng(number + reach)
    cells = random_cells(rng, number, reach) if number else np.zeros(0, np.int64)
    wanted = list(dict.fromkeys(cells.tolist()))
    table = np.full(table_mask(max(number, 16)) + 1, -7, np.int64)  # as an object before left it
    kept, block = keep_distinct(number, cells, table)
    assert cells[:kept].tolist() == wanted
    along_axes = np.array([cell_of(cell) for cell in wanted]).reshape(-1, 3)
    if number:
        assert tuple(block) == (*along_axes.min(axis=0), *along_axes.max(axis=0))
    else:
        assert block.i0 > block.i1 and block.j0 > block.j1 and block.k0 > block.k1
