"""The orbiting camera: pixels and view rays agree, views are named, zoom and pan follow the mouse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.scene.grid import VoxelGrid
from riglens.widgets.drawing.camera import VIEWS, OrbitCamera, framed, view_camera

SIZE = (1200, 800)
cameras = st.builds(
    OrbitCamera,
    focal_m=st.tuples(*[st.floats(-20.0, 20.0)] * 3),
    distance_m=st.floats(1.0, 100.0),
    azimuth_deg=st.floats(-180.0, 180.0),
    elevation_deg=st.floats(-89.0, 90.0),
    parallel=st.booleans(),
)
pixels = st.tuples(st.floats(0.0, 1200.0), st.floats(0.0, 800.0))


@given(cameras, pixels, st.floats(1.0, 50.0))
def test_a_point_on_the_view_ray_of_a_pixel_is_seen_at_that_pixel(camera, pixel, distance_m):
    ray = camera.ray(pixel, SIZE)
    seen = camera.project(ray.origin_m + distance_m * ray.direction, SIZE)[0]
    assert np.allclose(seen[:2], pixel, atol=1e-5)
    assert seen[2] > 0.0


@given(cameras, pixels, st.floats(0.5, 2.0))
def test_zooming_keeps_what_is_under_the_cursor_there(camera, pixel, factor):
    plane_point = camera.ray(pixel, SIZE)
    depth = camera.distance_m / float(plane_point.direction @ camera.axes()[2])
    target = plane_point.origin_m + depth * plane_point.direction
    after = camera.zoomed(factor, pixel, SIZE)
    assert np.allclose(after.project(target, SIZE)[0][:2], pixel, atol=1e-4)


@given(cameras, st.floats(-300.0, 300.0), st.floats(-300.0, 300.0))
def test_panning_moves_the_focal_point_with_the_mouse(camera, dx_px, dy_px):
    seen = camera.panned(dx_px, dy_px, SIZE).project(np.array(camera.focal_m), SIZE)[0]
    assert np.allclose(seen[:2], [600.0 + dx_px, 400.0 + dy_px], atol=1e-5)


@given(cameras, st.floats(-900.0, 900.0), st.floats(-900.0, 900.0))
def test_orbiting_keeps_the_distance_and_never_turns_the_world_upside_down(camera, dx_px, dy_px):
    after = camera.orbited(dx_px, dy_px, SIZE)
    assert after.distance_m == camera.distance_m and after.focal_m == camera.focal_m
    assert after.axes()[1][2] >= -1e-12


def test_from_above_x_points_right_and_y_up():
    camera = view_camera("top", VoxelGrid(), 1.5)
    centre, ahead, left = camera.project(np.array([[0.0, 0, 0], [5.0, 0, 0], [0, 5.0, 0]]), SIZE)[:, :2]
    assert ahead[0] > centre[0] and ahead[1] == pytest.approx(centre[1])
    assert left[1] < centre[1] and left[0] == pytest.approx(centre[0])


@pytest.mark.parametrize(
    ("view", "right_hand_side"), [("front", [0, 1, 0]), ("rear", [0, -1, 0]), ("left", [-1, 0, 0])]
)
def test_side_views_look_from_where_they_say(view, right_hand_side):
    right, up, _ = view_camera(view, VoxelGrid(), 1.5).axes()
    assert np.allclose(right, right_hand_side) and np.allclose(up, [0, 0, 1])


@pytest.mark.parametrize("aspect", [0.6, 1.6, 3.0])
@pytest.mark.parametrize("roi_m", [(60.0, 40.0, 4.0), (20.0, 80.0, 4.0)])
def test_the_top_view_shows_the_whole_region_of_interest(aspect, roi_m):
    size = (round(600 * aspect), 600)
    camera = view_camera("top", VoxelGrid(0.5, roi_m), size[0] / size[1])
    corners = np.array([[x, y, 0.0] for x in (-1, 1) for y in (-1, 1)]) * [roi_m[0] / 2, roi_m[1] / 2, 1.0]
    seen = camera.project(corners, size)[:, :2]
    assert (seen >= 0).all() and (seen <= size).all()


@pytest.mark.parametrize("aspect", [1.0, 1.6, 2.5])
def test_the_wide_iso_view_shows_the_whole_region_of_interest(aspect):
    size, grid = (round(800 * aspect), 800), VoxelGrid()
    corners = np.array([[x, y, z] for x in (-30.0, 30.0) for y in (-20.0, 20.0) for z in (0.0, 4.0)])
    seen = view_camera("iso", grid, aspect, wide=True).project(corners, size)[:, :2]
    assert (seen >= 0).all() and (seen <= size).all()


def test_an_unknown_view_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match=r"view must be iso, top, front, left, rear.*got 'below'"):
        view_camera("below", VoxelGrid(), 1.5)
    assert VIEWS == ("iso", "top", "front", "left", "rear")


@pytest.mark.parametrize("size", [(1200, 800), (500, 900)])
def test_framed_points_are_all_in_the_picture_and_one_is_seen_from_five_metres(size):
    camera = OrbitCamera(azimuth_deg=20.0, elevation_deg=35.0)
    places = np.array([[-2.3, -0.9, 0.0], [2.3, 0.9, 1.5], [0.0, 3.0, 2.0]])
    seen = framed(camera, places, size).project(places, size)[:, :2]
    assert (seen > 0).all() and (seen < size).all()
    one = framed(camera, places[:1], size)
    assert (one.focal_m, one.distance_m) == ((-2.3, -0.9, 0.0), 5.0)
    assert (one.azimuth_deg, one.elevation_deg) == (20.0, 35.0)


def test_the_right_side_is_looked_at_from_the_right():
    camera = view_camera("right", VoxelGrid(), 1.5)
    assert camera.position_m()[1] < -5.0 and camera.parallel
