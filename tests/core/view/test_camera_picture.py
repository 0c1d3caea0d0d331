"""A camera's picture agrees with its rays: what a pixel shows is what a ray through it hits first."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from riglens.core.kernels.rays.clip import clip_polygons
from riglens.core.rig.model import BrownConrady, KannalaBrandt
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensing.rays import sensor_rays
from riglens.core.sensors.camera import project_px
from riglens.core.vehicle.solid import Solid
from riglens.core.view.camera_picture import CameraPicture, camera_picture
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import BODY, cast
from riglens.core.view.projection import NEAR_M, Projection
from tests.core.view.view_cases import camera, frame_of, random_frame

GRID = VoxelGrid(0.5, (60.0, 40.0, 4.0))
NO_BODY = Solid.of(np.zeros((0, 3, 3)))
angles = st.floats(-180.0, 180.0)
tilts = st.floats(-30.0, 30.0)


def picture(seed: int = 1, **changes: float) -> CameraPicture:
    return camera_picture(camera(**changes), GRID, random_frame(seed), NO_BODY)  # type: ignore[arg-type]


@settings(max_examples=5)
@given(yaw=angles, pitch=tilts, roll=tilts, seed=st.integers(0, 2**32 - 1))
def test_the_box_on_top_is_the_one_that_the_ray_hits_first(
    yaw: float, pitch: float, roll: float, seed: int
) -> None:
    eye, boxes = camera(yaw, pitch, roll, cast=(32, 18)), random_frame(seed)
    shown = camera_picture(eye, GRID, boxes, NO_BODY)
    rays = sensor_rays(eye)
    hits = cast(eye.position, rays.directions, boxes, barrier_of(eye, NO_BODY), eye.range_m, has_ground=False)
    faces = [shown.face_at(x, y) for y in np.arange(10.0, 360, 20) for x in np.arange(10.0, 640, 20)]
    found = np.array([-1 if face is None else face.box for face in faces])
    assert np.count_nonzero(found != hits.what) <= 2  # pixels right on an edge may go either way


LENSES = (
    BrownConrady(k1=-0.28, k2=0.07, p1=0.001, p2=-0.002),
    BrownConrady(k1=0.1, k4=0.05),
    KannalaBrandt(k1=-0.02, k2=0.003),
)


@settings(max_examples=6)
@given(lens=st.sampled_from(LENSES), yaw=angles, pitch=tilts, seed=st.integers(0, 2**32 - 1))
def test_bent_lenses_bend_boxes_as_they_bend_rays(
    lens: BrownConrady | KannalaBrandt, yaw: float, pitch: float, seed: int
) -> None:
    matrix = {"hfov_deg": None, "fx": 300.0, "fy": 300.0, "cx": 320.0, "cy": 180.0}
    eye = camera(yaw, pitch, 0.0, cast=(32, 18), distortion=lens, **matrix)
    boxes = random_frame(seed)
    shown = camera_picture(eye, GRID, boxes, NO_BODY)
    rays = sensor_rays(eye, np.arange(32 * 18))
    hits = cast(
        eye.position,
        np.nan_to_num(rays.directions),
        boxes,
        barrier_of(eye, NO_BODY),
        eye.range_m,
        has_ground=False,
    )
    faces = [shown.face_at(x, y) for y in np.arange(10.0, 360, 20) for x in np.arange(10.0, 640, 20)]
    found = np.array([-1 if face is None else face.box for face in faces])
    assume(np.count_nonzero(hits.what >= 0) > 10)  # or there is nothing to compare
    assert np.count_nonzero(found != hits.what) <= 2  # pixels near an edge: curves are drawn as short lines


def test_a_fisheye_shows_what_lies_beside_the_car() -> None:
    eye = camera(
        distortion=KannalaBrandt(),
        hfov_deg=None,
        image=(640, 640),
        fx=200.0,
        fy=200.0,
        cx=320.0,
        cy=320.0,
        cast=(16, 16),
    )
    left = frame_of((2, (1.0, 6.0, 1.0), (1.0, 1.0, 2.0), 0.0))
    shown = camera_picture(eye, GRID, left, NO_BODY)
    assert shown.boxes_seen["pedestrian"] == 1
    face = shown.face_at(320.0 - 200.0 * math.atan2(5.5, 1.0), 330.0)
    assert face is not None and face.box == 0


@settings(max_examples=20)
@given(yaw=angles, pitch=tilts, roll=tilts)
def test_a_pixel_is_where_its_ray_goes(yaw: float, pitch: float, roll: float) -> None:
    eye = camera(yaw, pitch, roll, fx=500.0, fy=480.0, cx=300.0, cy=200.0, hfov_deg=None)
    rays = sensor_rays(eye)
    view = Projection(eye)
    points = np.array(eye.position) + rays.directions * 7.0
    pixels = project_px(eye, view.to_camera(points)).reshape(36, 64, 2)
    np.testing.assert_allclose(pixels[:, :, 0], np.broadcast_to(np.arange(5.0, 640, 10), (36, 64)), atol=1e-6)
    np.testing.assert_allclose(
        pixels[:, :, 1], np.broadcast_to(np.arange(5.0, 360, 10)[:, None], (36, 64)), atol=1e-6
    )


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_clipped_polygons_hold_the_points_above_all_planes_and_no_others(seed: int) -> None:
    rng = np.random.default_rng(seed)
    square = np.array([[[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]])
    planes = np.column_stack([rng.normal(size=(3, 2)), np.zeros(3), rng.uniform(-0.5, 0.8, 3)])
    clipped, counts = np.empty((1, 7, 3)), np.zeros(1, np.int64)
    clip_polygons(square, planes, clipped, counts)
    corners = clipped[0, : counts[0]]
    points = np.column_stack([rng.uniform(-1, 1, (4000, 2)), np.zeros(4000), np.ones(4000)])
    kept = float((points @ planes.T >= 0.0).all(axis=1).mean()) * 4.0
    turned = np.roll(corners, -1, axis=0)
    area = float(abs((corners[:, 0] * turned[:, 1] - turned[:, 0] * corners[:, 1]).sum()) / 2)
    assert area == pytest.approx(kept, abs=0.15)
    if len(corners):
        homogeneous = np.column_stack([corners, np.ones(len(corners))])
        assert (homogeneous @ planes.T > -1e-9).all()


def test_boxes_beside_and_behind_the_camera_do_not_fold_into_the_picture() -> None:
    wall = frame_of((0, (0.0, 3.0, 1.5), (60.0, 0.5, 3.0), 0.0), (1, (-5.0, 0.0, 1.0), (1.0, 1.0, 2.0), 0.0))
    shown = camera_picture(camera(), GRID, wall, NO_BODY)
    assert {face.box for face in shown.faces} == {0}
    for face in shown.faces:
        assert np.isfinite(face.corners_px).all()
        assert face.corners_px[:, 0].max() < 320.0  # a wall on the left stays on the left
    assert shown.boxes_seen == {"car": 1, "bicycle": 0, "pedestrian": 0}


def test_a_box_that_touches_the_lens_is_cut_off_in_front_of_it() -> None:
    shown = camera_picture(camera(), GRID, frame_of((0, (1.0, 0.0, 1.0), (1.99, 2, 1), 0.0)), NO_BODY)
    assert shown.faces and all(np.isfinite(face.corners_px).all() for face in shown.faces)
    assert min(face.range_m for face in shown.faces) < NEAR_M + 0.2


def test_the_horizon_of_a_level_camera_is_the_middle_row_and_the_ground_below_it() -> None:
    shown = picture()
    rows = np.concatenate(shown.horizon_px)[:, 1]
    np.testing.assert_allclose(rows, 180.0, atol=1e-6)
    assert shown.ground_px[:, 1].min() == pytest.approx(180.0, abs=0.1)
    assert shown.ground_px[:, 1].max() >= 360.0


def test_pitching_down_raises_the_horizon_and_looking_up_loses_the_ground() -> None:
    assert np.concatenate(picture(pitch_deg=10.0).horizon_px)[:, 1].max() < 180.0
    assert len(picture(pitch_deg=-60.0).ground_px) == 0
    assert picture(pitch_deg=-60.0).grid_px == []


def test_roi_lines_end_at_its_corners() -> None:
    eye = camera()
    view = Projection(eye)
    corner = project_px(eye, view.to_camera(np.array([[30.0, 20.0, 0.0]])))[0]
    ends = np.concatenate(picture().roi_px)
    assert np.linalg.norm(ends - corner, axis=1).min() < 1e-6


def test_a_line_out_of_view_on_both_sides_is_cut_off_just_beside_the_image() -> None:
    places = np.array([[10.0, 90.0, 1.6], [10.0, -50.0, 1.6]])
    for start, end in (places, places[::-1]):
        (path,) = Projection(camera()).lines(start[None], end[None])
        assert -20.0 < path[:, 0].min() <= 0.0 and 640.0 <= path[:, 0].max() < 660.0
        np.testing.assert_allclose(path[:, 1], 180.0)


def test_the_own_body_covers_the_pixels_whose_rays_hit_it() -> None:
    bonnet = np.array(
        [
            [[0.3, -1.0, 1.0], [2.5, -1.0, 1.0], [2.5, 1.0, 1.0]],
            [[0.3, -1.0, 1.0], [2.5, 1.0, 1.0], [0.3, 1.0, 1.0]],
        ]
    )
    solid, eye = Solid.of(bonnet), camera(image=(480, 270))
    shown = camera_picture(eye, GRID, FrameBoxes.none(), solid)
    rays = Projection(eye).directions(480, 270)
    hits = cast(
        eye.position, rays, FrameBoxes.none(), barrier_of(eye, solid), (0.0, math.inf), has_ground=False
    )
    np.testing.assert_array_equal(shown.body > 0, (hits.what == BODY).reshape(270, 480))
    assert 0.05 < shown.body_share < 0.5
    assert not shown.body[:130].any()


def test_a_camera_in_the_ground_shows_no_ground() -> None:
    eye = camera(position=(0.0, 0.0, -0.3))
    assert len(camera_picture(eye, GRID, FrameBoxes.none(), NO_BODY).ground_px) == 0


def test_boxes_behind_others_are_not_counted_as_seen() -> None:
    wall, behind = (0, (5.0, 0.0, 2.0), (0.5, 30.0, 4.0), 0.0), (2, (9.0, 0.0, 0.9), (0.5, 0.5, 1.8), 0.0)
    assert camera_picture(camera(), GRID, frame_of(wall, behind), NO_BODY).boxes_seen["pedestrian"] == 0
    assert camera_picture(camera(), GRID, frame_of(behind), NO_BODY).boxes_seen["pedestrian"] == 1
