"""Frusta: what a sensor's field of view says by trigonometry, and nothing beyond the ROI."""

import math

import numpy as np
import pytest

from riglens.core.rig.model import Camera, KannalaBrandt, Lidar, LinearAngles
from riglens.core.scene.grid import VoxelGrid
from riglens.widgets.sensors.fills import fill_mesh

GRID = VoxelGrid(0.5, (60.0, 40.0, 4.0))
ROOF = Lidar(
    name="roof", position=(0.0, 0.0, 2.0), range_m=(0.5, 15.0),
    elevations_deg=LinearAngles(from_=-45.0, to=10.0, count=16),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=360),
)  # fmt: skip
FRONT = Camera(name="front", position=(1.0, 0.5, 1.5), hfov_deg=60.0, cast=(64, 36), rpy_deg=(0.0, 10.0, 0.0))


def filled(sensor):
    return fill_mesh(sensor, GRID, "#ff0000", 0.2)


@pytest.mark.parametrize("sensor", [ROOF, FRONT, FRONT.replace(rpy_deg=(30.0, -20.0, 200.0))], ids=str)
def test_nothing_is_filled_outside_the_region(sensor):
    points = filled(sensor).points
    assert (np.abs(points[:, 0]) <= 30.0 + 1e-4).all() and (np.abs(points[:, 1]) <= 20.0 + 1e-4).all()
    assert (points[:, 2] >= -1e-4).all() and (points[:, 2] <= 4.0 + 1e-4).all()


def test_the_frustum_of_a_camera_is_its_image_border_and_that_of_a_spinning_lidar_two_cones():
    tip = np.array(FRONT.position)
    camera, lidar = filled(FRONT), filled(ROOF)
    assert any(np.allclose(point, tip, atol=1e-6) for point in camera.points)
    border = camera.regular_faces[:, 1]
    assert len(set(border.tolist())) == len(border)  # once round, ray by ray
    faces = lidar.regular_faces
    slopes = [round(math.degrees(math.atan2(*_rise(lidar.points[face[1]]))), 3) for face in faces]
    assert set(slopes) == {-45.0, 10.0} and camera.n_cells == 2 * (32 + 18)


def _rise(point):
    return point[2] - 2.0, math.hypot(point[0], point[1])


def test_a_fisheye_without_rays_in_its_corners_has_surfaces_without_holes_in_their_numbers():
    eye = Camera(
        name="eye", position=(2.0, 0.0, 0.8), image=(1280, 960), cast=(64, 48), fx=320.0, fy=320.0, cx=640.0, cy=480.0,
        distortion=KannalaBrandt(k1=0.0, k2=0.0, k3=0.0, k4=0.0),
    )  # fmt: skip
    assert np.isfinite(filled(eye).points).all() and filled(eye).n_cells > 0


def test_a_surface_has_the_colour_and_the_opacity_that_were_asked_for():
    assert np.unique(filled(FRONT)["rgba"], axis=0).tolist() == [[255, 0, 0, 51]]
