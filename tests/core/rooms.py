"""Small rooms of awkward proportions, in which fast ways of casting are held against the rays one by one."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from hypothesis import strategies as st

from riglens.core.metric.entropy import EntropyField
from riglens.core.scene.grid import VoxelGrid
from tests.core.builders import field_of, grid_of

seeds = st.integers(0, 2**32 - 1)
SMALL = grid_of(24, 20, 11, 0.25)
SMALL_FIELD = field_of(SMALL)
ROOMS = (
    (0.10, (8.0, 6.0, 2.0)),
    (0.05, (3.0, 2.0, 4.0)),
    (0.10, (30.0, 3.0, 1.0)),
    (0.37, (22.2, 14.8, 3.7)),
    (0.10, (12.0, 9.0, 0.1)),
    (0.10, (0.1, 12.0, 3.0)),
)
"""Voxel edge and region in metres: more than 64 levels, longer than rays stay close, one voxel thick."""


@lru_cache(maxsize=16)
def field_at(voxel_m: float, roi_m: tuple[float, float, float], share: float) -> EntropyField:
    """A field of a room in which a share of the voxels is informative."""
    grid = VoxelGrid(voxel_m, roi_m)
    return field_of(grid, np.random.default_rng(1).random(grid.shape) < share)
