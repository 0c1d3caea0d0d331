"""Distinct cells of several LiDARs, against sets, whichever LiDAR moves and however far apart the cells are."""

import numpy as np
import pytest

from riglens.core.kernels.objects.counts import CELLS, COLUMNS, FIRST_CELL, LAST_CELL
from riglens.core.kernels.objects.unique_cells import cell_of
from riglens.core.targets.contribution import Contribution
from riglens.core.targets.joining import JoinedCells, sorted_cells

OBJECTS, NEAR, FAR = 9, 6, 1 << 19


def contribution(rng: np.random.Generator, reach: int) -> Contribution:
    """Some of few cells on each object, so that LiDARs share many; none on some objects. They lie among the cells in
    another order than the objects."""
    lists = []
    for one in range(OBJECTS):
        of_object = np.random.default_rng(one).integers(-reach, reach, (12, 3)) + (1 << 20)
        keys = np.unique((of_object[:, 0] << 42) | (of_object[:, 1] << 21) | of_object[:, 2])
        lists.append(
            rng.permutation(keys[rng.random(keys.size) < (0.0 if one == rng.integers(OBJECTS) else 0.6)])
        )
    found, starts, at = np.zeros((COLUMNS, OBJECTS), np.int32), np.zeros(OBJECTS, np.int64), 0
    order = rng.permutation(OBJECTS)
    for one in order:
        along_axes = np.array([cell_of(key) for key in lists[one]]).reshape(-1, 3)
        found[CELLS, one], starts[one] = len(along_axes), at
        found[FIRST_CELL : FIRST_CELL + 3, one] = along_axes.min(axis=0, initial=1 << 21)
        found[LAST_CELL : LAST_CELL + 3, one] = along_axes.max(axis=0, initial=0)
        at += len(along_axes)
    return Contribution(1, found, starts, np.concatenate([lists[one] for one in order]))


def distinct(lidars: tuple[Contribution, ...], objects: int) -> list[int]:
    """Numbers of cells in sets."""
    return [
        len(
            {key for one in lidars for key in one.cells[one.cell_starts[o] :][: one.found[CELLS, o]].tolist()}
        )
        for o in range(objects)
    ]


@pytest.mark.parametrize("reach", [NEAR, FAR])
@pytest.mark.parametrize("workers", [1, 2])
def test_each_cell_counts_once_from_edit_to_edit(workers, reach):
    rng = np.random.default_rng(workers + reach)
    joined, lidars = JoinedCells(workers), tuple[Contribution, ...]()
    for edit in range(60):
        kind, place = rng.integers(6), int(rng.integers(len(lidars) + 1))
        if kind == 0:
            lidars = (*lidars[:place], contribution(rng, reach), *lidars[place:])
        elif kind == 1 and len(lidars) > 2:
            lidars = (*lidars[:place], *lidars[place + 1 :])
        elif kind == 2 and lidars:
            lidars = (*lidars, lidars[0])  # a twin
        elif lidars:
            place = min(place, len(lidars) - 1) if kind < 5 else 0
            lidars = (*lidars[:place], contribution(rng, reach), *lidars[place + 1 :])
        objects = OBJECTS if edit % 7 else OBJECTS - 3
        wanted = distinct(lidars, objects)
        assert joined.of(lidars, objects).tolist() == wanted
        if lidars:
            assert sorted_cells(lidars, objects).tolist() == wanted
