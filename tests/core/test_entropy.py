"""Entropies follow the plain formula within the stated bound, and only informative voxels are kept."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.scene.pog import build_pog
from tests.core.builders import boxes_of, dense_h, grid_of, synthetic_pog
from tests.core.oracle import entropy_nat

GRID = grid_of(5, 4, 70)
BOUND_NAT = 2.0**-33


def field_of_counts(counts: list[tuple[int, int, int]], frames: int) -> EntropyField:
    """A field whose first voxels along x have these counts."""
    dense = np.zeros((*GRID.shape, 3), np.int64)
    dense[: len(counts), 0, 0] = counts
    return EntropyField.from_pog(synthetic_pog(GRID, dense, frames))


@given(frames=st.integers(1, 2000), seed=st.integers(0, 2**32 - 1))
def test_every_voxel_is_within_the_stated_bound(frames: int, seed: int) -> None:
    counts = np.random.default_rng(seed).integers(0, frames + 1, (*GRID.shape, 3))
    field = EntropyField.from_pog(synthetic_pog(GRID, counts, frames))
    expected = np.vectorize(entropy_nat)(counts, frames)
    assert np.abs(dense_h(field) / QUANTA_PER_NAT - expected).max() <= BOUND_NAT * (1 + 1e-6)
    assert field.index.count == (expected > 0.0).any(axis=-1).sum()
    for cls in range(3):
        total = expected[..., cls].sum()
        assert field.h_total_nat(cls) == pytest.approx(total, abs=GRID.voxel_count * BOUND_NAT)
        assert field.h_total_nat(cls) * QUANTA_PER_NAT == dense_h(field)[..., cls].sum()
        assert field.entropy_nat(cls).sum() == pytest.approx(total)


def test_half_the_frames_give_ln_2() -> None:
    assert field_of_counts([(1, 1, 1)], 2).entropy_nat(0)[0] == pytest.approx(math.log(2.0), abs=BOUND_NAT)


@pytest.mark.parametrize("frames", [3, 1000, 65535, 65536, 10**7])
def test_p_and_one_minus_p_have_the_same_entropy_down_to_one_frame(frames: int) -> None:
    field = field_of_counts([(1, frames - 1, frames)], frames)
    rare, common, always = (float(field.entropy_nat(cls)[0]) for cls in range(3))
    assert rare == pytest.approx(entropy_nat(1, frames), abs=BOUND_NAT)
    assert rare == common > 0.0
    assert always == 0.0


def test_never_and_always_occupied_voxels_drop_out() -> None:
    field = field_of_counts([(5, 0, 0), (0, 5, 5), (5, 1, 0), (0, 0, 0), (2, 2, 2)], 5)
    assert field.index.ijk()[:, 0].tolist() == [2, 4]
    assert [int(np.count_nonzero(field.entropy_q(c))) for c in range(3)] == [1, 2, 1]


def test_one_frame_leaves_nothing_informative() -> None:
    field = EntropyField.from_pog(build_pog(boxes_of((0, 0, (0, 0, 1), (2, 2, 2), 0.0), frames=1), GRID))
    assert (field.index.count, field.totals_q) == (0, (0, 0, 0))


def test_the_order_of_the_ids_is_that_of_the_columns() -> None:
    rng = np.random.default_rng(4)
    counts = rng.integers(0, 3, (*GRID.shape, 3))
    field = EntropyField.from_pog(synthetic_pog(GRID, counts, 9))
    ijk = field.index.ijk()
    assert np.array_equal(ijk, np.argwhere(counts.any(axis=-1)))
    assert field.index.first[-1] == field.index.count == len(ijk)
