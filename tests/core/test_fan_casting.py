"""Upright sensors, cast plane by plane: planes along the axes, and the parts of the grid that workers get."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from riglens.core.engine.caster import Caster
from riglens.core.engine.fans import make_fan, make_profile, share_rows
from riglens.core.kernels.fans.fan import work_by_row
from riglens.core.rig.model import Lidar
from riglens.core.scene.grid import VoxelGrid
from tests.core.builders import field_of, lidar, seen_by, seen_ray_by_ray, spinning

GRID = VoxelGrid(roi_m=(24.0, 16.0, 4.0), voxel_m=0.2)


@pytest.mark.parametrize("yaw_deg", [0.0, 90.0, -90.0, 180.0])
@pytest.mark.parametrize("beside_m", [0.0, 1e-13, -1e-13, 1e-10, -1e-10, 3e-9, -3e-9, 1e-7, 0.07])
def test_planes_along_the_axes_beside_and_within_faces(yaw_deg: float, beside_m: float) -> None:
    field, elevations = field_of(GRID), [-80.0, -40.0, -7.0, -1e-9, 0.0, 3.0, 33.0]
    for place in ((1.2, -2.6, 0.3), (-1.4, 2.8, 0.4), (11.8, 7.6, 0.0)):
        position = (place[0] + beside_m, place[1] - beside_m, place[2])
        sensor = lidar(position, (0.0, 0.0, yaw_deg), elevations, [0.0, 90.0, 180.0, 270.0, 12.0])
        assert np.array_equal(seen_by(field, sensor), seen_ray_by_ray(field, sensor))


@given(
    st.lists(st.floats(0.0, 1e6), min_size=1, max_size=60),
    st.integers(1, 9),
    st.integers(0, 59),
    st.integers(1, 60),
)
def test_parts_of_the_grid_follow_one_another_and_are_about_even(
    work: list[float], workers: int, x_from: int, rows: int
) -> None:
    x_from = min(x_from, len(work) - 1)
    x_to = min(x_from + rows, len(work))
    parts = share_rows(np.array(work), x_from, x_to, workers)
    assert parts.shape == (workers, 2)
    assert [*parts[:, 0], x_to] == [x_from, *parts[:, 1]]
    total, most = sum(work[x_from:x_to]), max(work[x_from:x_to])
    for start, end in parts:
        assert start <= end
        assert sum(work[start:end]) <= total / workers + most + 1e-9 * total


def _work(sensor: Lidar) -> NDArray[np.float64]:
    caster = Caster(field_of(GRID))
    rays = caster.rays(sensor, "exact")
    fan = make_fan(rays)
    profile = make_profile(fan, rays)
    assert profile is not None
    return work_by_row(fan, rays, profile)


def test_a_sensor_in_the_middle_has_as_much_to_walk_in_front_as_behind() -> None:
    work = _work(spinning((0.0, 0.05, 0.3), beams=16, count=360))
    front, behind = work[: len(work) // 2].sum(), work[len(work) // 2 :].sum()
    assert front == pytest.approx(behind, rel=0.1)


def test_a_sensor_at_the_front_has_most_to_walk_behind_and_nothing_where_it_does_not_look() -> None:
    work = _work(spinning((6.0, 0.05, 0.3), beams=16, count=360))
    assert work[:90].sum() > 1.5 * work[90:].sum()
    ahead = _work(lidar((6.0, 0.05, 0.3), elevations=[-4.0, 2.0], azimuths=[-3.0, 5.0]))
    assert ahead[:89].sum() == 0.0
    assert ahead[90:].min() > 0.0
