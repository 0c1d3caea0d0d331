"""Footprints and frusta: what a sensor's field of view and range say by trigonometry, and nothing beyond the ROI."""

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


def filled(sensor, fill="ground"):
    return fill_mesh(sensor, GRID, fill, "#ff0000", 0.2)


def area_m2(mesh) -> float:
    return float(mesh.triangulate().compute_cell_sizes()["Area"].sum())


def test_the_footprint_of_a_lidar_is_the_ring_between_its_lowest_beam_and_its_range():
    mesh = filled(ROOF)
    radius_m = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    reach_m = math.sqrt(15.0**2 - 2.0**2)
    assert radius_m.min() == pytest.approx(2.0, abs=1e-6) and radius_m.max() == pytest.approx(
        reach_m, abs=1e-5
    )
    assert area_m2(mesh) == pytest.approx(math.pi * (reach_m**2 - 2.0**2), rel=0.005)
    assert np.ptp(mesh.points[:, 2]) == 0.0


def test_the_footprint_of_a_camera_begins_where_its_lowest_row_meets_the_ground_and_ends_at_the_region():
    mesh = filled(FRONT)
    low = FRONT.replace(range_m=(0.0, 1000.0))
    assert mesh.bounds[1] == pytest.approx(30.0, abs=1e-5)
    _, fy_px, _, cy_px = FRONT.intrinsics_px()
    half = FRONT.image[1] / FRONT.cast[1] / 2  # the lowest ray goes through the middle of the lowest row
    steepest = math.radians(10.0) + math.atan((FRONT.image[1] - cy_px - half) / fy_px)
    ahead = mesh.points[np.abs(mesh.points[:, 1] - 0.5) < 0.1]
    assert ahead[:, 0].min() == pytest.approx(1.0 + 1.5 / math.tan(steepest), abs=0.01)
    assert area_m2(filled(low)) == pytest.approx(area_m2(mesh), rel=1e-6)


@pytest.mark.parametrize("fill", ["ground", "frusta"])
@pytest.mark.parametrize("sensor", [ROOF, FRONT, FRONT.replace(rpy_deg=(30.0, -20.0, 200.0))], ids=str)
def test_nothing_is_filled_outside_the_region(sensor, fill):
    points = filled(sensor, fill).points
    assert (np.abs(points[:, 0]) <= 30.0 + 1e-4).all() and (np.abs(points[:, 1]) <= 20.0 + 1e-4).all()
    assert (points[:, 2] >= -1e-4).all() and (points[:, 2] <= 4.0 + 1e-4).all()


@pytest.mark.parametrize(
    "sensor",
    [
        FRONT.replace(rpy_deg=(0.0, -60.0, 0.0)),
        ROOF.replace(range_m=(0.5, 1.5)),
        ROOF.replace(position=(0.0, 0.0, -0.5)),
        ROOF.replace(position=(100.0, 0.0, 2.0)),
    ],
    ids=["looks up", "too short", "in the ground", "far away"],
)
def test_what_does_not_reach_the_ground_has_no_footprint(sensor):
    assert filled(sensor).n_points == 0


def test_the_frustum_of_a_camera_is_its_image_border_and_that_of_a_spinning_lidar_two_cones():
    tip = np.array(FRONT.position)
    camera, lidar = filled(FRONT, "frusta"), filled(ROOF, "frusta")
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
    for fill in ("ground", "frusta"):
        assert np.isfinite(filled(eye, fill).points).all() and filled(eye, fill).n_cells > 0
