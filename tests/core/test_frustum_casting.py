"""Cameras that roll and pitch are cast voxel by voxel; the set is that of their rays, one by one and exactly."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.engine.caster import Caster
from riglens.core.engine.frustums import make_frustum
from riglens.core.rig.model import Camera
from riglens.core.rig.presets import preset
from riglens.core.scene.grid import VoxelGrid
from tests.core.builders import camera, field_of, grid_of, seen_by, seen_ray_by_ray
from tests.core.oracle import exact_cover

GRID = grid_of(24, 20, 11, 0.25)
FIELD = field_of(GRID)
seeds = st.integers(0, 2**32 - 1)


def tilted_camera(seed: int, cast: tuple[int, int], hfov_deg: float) -> Camera:
    """A camera somewhere in or near the grid, often on faces and corners, turned anyhow."""
    rng = np.random.default_rng(seed)
    cells = rng.integers(-4, np.array(GRID.shape) + 5) + rng.choice([0.0, 0.5, 0.317], 3)
    position = np.array(GRID.origin_m) + cells * GRID.voxel_m
    rpy_deg = rng.choice([0.0, 30.0, -90.0, 180.0, rng.uniform(-180, 180)], 3) + rng.choice([0.0, 1.25])
    return camera(position, tuple(float(a) for a in rpy_deg), cast, hfov_deg)


def is_walked_by_voxels(sensor: Camera) -> bool:
    """Whether the short cut under test is the one taken."""
    return make_frustum(sensor, Caster(FIELD).rays(sensor, "exact")) is not None


@settings(max_examples=6)
@given(seed=seeds, hfov_deg=st.sampled_from([10.0, 20.0]))
def test_a_dense_camera_in_any_pose_covers_what_the_oracle_says(seed: int, hfov_deg: float) -> None:
    sensor = tilted_camera(seed, (20, 12), hfov_deg)
    assert is_walked_by_voxels(sensor)
    assert np.array_equal(seen_by(FIELD, sensor), exact_cover(GRID, [sensor]))


@settings(max_examples=40)
@given(seed=seeds, hfov_deg=st.sampled_from([30.0, 70.0, 110.0, 160.0]), share=st.sampled_from([0.1, 1.0]))
def test_voxel_walking_and_ray_walking_agree(seed: int, hfov_deg: float, share: float) -> None:
    sensor = tilted_camera(seed, (400, 225), hfov_deg)
    assert is_walked_by_voxels(sensor) or hfov_deg == 160.0
    field = field_of(GRID, np.random.default_rng(seed).random(GRID.shape) < share)
    assert np.array_equal(seen_by(field, sensor), seen_ray_by_ray(field, sensor))


@pytest.mark.parametrize(
    "rpy_deg", [(1.5, 5.0, 3.0), (0.0, 20.0, 0.0), (-10.0, -3.0, 120.0), (90.0, 0.0, 45.0)]
)
def test_a_tilted_native_camera_covers_the_voxels_of_all_its_rays(
    rpy_deg: tuple[float, float, float],
) -> None:
    field = field_of(VoxelGrid(0.4))
    native = preset("Wide").sensors[0].replace(cast=(1600, 900), rpy_deg=rpy_deg)
    seen = seen_by(field, native)
    assert seen.sum() > 1_000
    assert np.array_equal(seen, seen_ray_by_ray(field, native))
