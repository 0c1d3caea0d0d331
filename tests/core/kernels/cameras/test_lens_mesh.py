"""Voxels on all sides of a camera are hit exactly when one of its rays, tested one by one, hits them."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.engine.caster import Caster
from riglens.core.engine.meshes import make_mesh
from riglens.core.kernels.cameras.lens_mesh import any_ray_hits
from riglens.core.rig.model import BrownConrady, Camera
from riglens.core.sensing.rays import sensor_rays
from tests.core.builders import field_of, grid_of

FIELD = field_of(grid_of(16, 16, 16))


@pytest.mark.parametrize("has_stopped", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_a_voxel_is_hit_if_a_ray_that_is_cast_passes_it(seed: int, has_stopped: bool) -> None:
    rng = np.random.default_rng(seed)
    camera = Camera(
        name="C", position=(*rng.uniform(-2.0, 2.0, 2), 8.3), rpy_deg=tuple(rng.uniform(-180.0, 180.0, 3)),
        image=(640, 480), cast=(24, 18), fx=880.0, fy=880.0, cx=300.0, cy=250.0, distortion=BrownConrady(k1=-0.1),
    )  # fmt: skip
    rays = Caster(FIELD).rays(camera, "exact")
    is_cast = np.ones(camera.ray_count, np.bool_)
    if has_stopped:
        is_cast[rng.random(camera.ray_count) < 0.6] = False
        rays = rays._replace(is_stopped=~is_cast)
    found = make_mesh(camera, rays)
    assert found is not None
    origin, directions = rays.origin, sensor_rays(camera).directions[is_cast]
    cells = np.floor(origin) + np.concatenate([rng.integers(-2, 3, (100, 3)), rng.integers(-9, 10, (400, 3))])
    ahead = np.floor(
        origin + rng.uniform(0.0, 9.0, (300, 1)) * directions[rng.integers(len(directions), size=300)]
    )
    work, hits = np.empty((8, 3)), 0
    for cell in np.concatenate([cells, ahead + rng.integers(-1, 2, (300, 3))]).astype(int).tolist():
        near, far = (cell - origin) / directions, (np.array(cell) + 1.0 - origin) / directions
        begin = np.maximum(np.minimum(near, far).max(axis=1), 0.0)
        expected = bool((begin < np.maximum(near, far).min(axis=1)).any())
        assert any_ray_hits(found.view, found.bins, tuple(cell), work) == expected, cell
        hits += expected
    assert 30 < hits < 700
