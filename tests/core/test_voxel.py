"""One voxel: its p and h are those of the POG, and a click on a display cell means the voxel under the cursor."""

import math

import numpy as np
import pytest

from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.voxel import voxel_facts, voxel_in_cell, word_and_bit
from riglens.core.scene.pog import Pog
from riglens.core.view.display import DisplayGrid
from tests.core.builders import grid_of, synthetic_pog

GRID = grid_of(8, 6, 70, 0.5)
FRAMES = 10


def pog_of(*occupied: tuple[tuple[int, int, int], tuple[int, int, int]]) -> Pog:
    counts = np.zeros((*GRID.shape, 3), np.int64)
    for voxel, per_class in occupied:
        counts[voxel] = per_class
    return synthetic_pog(GRID, counts, FRAMES)


def test_p_and_h_are_those_of_the_pog() -> None:
    facts = voxel_facts(pog_of(((3, 2, 66), (5, 0, 10))), (3, 2, 66))
    assert facts.p == (0.5, 0.0, 1.0)
    assert facts.h_nat == pytest.approx((math.log(2), 0.0, 0.0))
    assert facts.centre_m == pytest.approx((-0.25, -0.25, 33.25))
    assert facts.is_informative


@pytest.mark.parametrize("per_class", [(0, 0, 0), (10, 0, 10)])
def test_a_voxel_that_is_never_or_always_occupied_is_not_informative(per_class: tuple[int, int, int]) -> None:
    assert not voxel_facts(pog_of(((1, 1, 1), per_class)), (1, 1, 1)).is_informative


def test_counts_of_one_voxel_are_those_of_its_row() -> None:
    counts = np.random.default_rng(1).integers(0, 3, (*GRID.shape, 3))
    pog = synthetic_pog(GRID, counts, FRAMES)
    for voxel in np.ndindex(GRID.shape):
        assert (pog.counts_of(*word_and_bit(GRID, voxel)) == counts[voxel]).all()
    assert (pog.counts == counts[tuple(pog.index.ijk().T)]).all()


def test_of_the_voxels_of_a_cell_the_one_under_the_cursor_is_meant() -> None:
    pog = pog_of(((4, 2, 4), (3, 0, 0)), ((5, 3, 5), (2, 0, 0)), ((4, 3, 4), (0, 4, 0)))
    display = DisplayGrid.build(pog, EntropyField.from_pog(pog), 1)
    centre, down = display.centres_m[0].astype(float), np.array([0.0, 0.0, -1.0])

    def meant(cls: int, x_m: float, y_m: float) -> tuple[int, int, int]:
        return voxel_in_cell(pog, cls, centre, display.cell_m, (np.array([x_m, y_m, 9.0]), down))

    assert meant(0, 0.2, -0.3) == (4, 2, 4)
    assert meant(0, 0.8, 0.2) == (5, 3, 5)
    assert meant(1, 0.8, 0.2) == (4, 3, 4)


def test_a_cell_at_the_edge_of_the_grid_has_no_voxels_beyond_it() -> None:
    pog = pog_of(((7, 5, 69), (3, 0, 0)))
    ray = (np.array([0.0, 0.0, 60.0]), np.array([0.0, 0.0, -1.0]))
    assert voxel_in_cell(pog, 0, np.array([2.25, 1.75, 35.25]), 1.5, ray) == (7, 5, 69)
    assert voxel_in_cell(pog, 2, np.array([2.25, 1.75, 35.25]), 1.5, ray)[2] == 69


def test_a_cell_outside_the_grid_has_no_voxel() -> None:
    ray = (np.array([0.0, 0.0, 60.0]), np.array([0.0, 0.0, -1.0]))
    for words in (None, np.zeros(GRID.shape[0] * GRID.shape[1] * 2, np.uint64)):
        assert (
            voxel_in_cell(pog_of(((7, 5, 69), (3, 0, 0))), 0, np.array([90.0, 1.75, 3.25]), 1.5, ray, words)
            is None
        )


def test_of_a_seen_and_an_unseen_voxel_a_click_means_the_one_that_is_shown() -> None:
    near, far, sure = (4, 2, 4), (5, 3, 5), (4, 3, 5)
    pog = pog_of((near, (3, 0, 0)), (far, (2, 0, 0)), (sure, (FRAMES, 0, 0)))
    display = DisplayGrid.build(pog, EntropyField.from_pog(pog), 1)
    seen = np.zeros(GRID.shape[0] * GRID.shape[1] * 2, np.uint64)
    word, bit = word_and_bit(GRID, near)
    seen[word] |= np.uint64(bit)
    ray = (np.array([0.2, -0.3, 9.0]), np.array([0.0, 0.0, -1.0]))

    def meant(words: np.ndarray | None) -> tuple[int, int, int] | None:
        return voxel_in_cell(pog, 0, display.centres_m[0].astype(float), display.cell_m, ray, words)

    assert meant(None) == near and meant(seen) == near
    assert meant(~seen) == far  # not `sure`, whose entropy is 0: it is neither seen nor unseen
    assert meant(np.zeros_like(seen)) is None
