"""The gizmo on the screen: its size, what of it can be grasped, and which handle a pixel means."""

import math

import numpy as np
import pytest

from riglens.core.geometry import Pose
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.gizmo.drag import MOVE_HANDLES, ROTATE_HANDLES, Handle
from riglens.widgets.gizmo.handles import RING_RADIUS, SIZE_PX, handle_polyline, hit_handle, place_gizmo

SIZE = (1000, 700)
POSE = Pose((0.2, 0.5, 2.2), (0.0, 0.0, 30.0))
CAMERA = OrbitCamera((0.0, 0.0, 1.0), 14.0, -50.0, 25.0)


def pixel_of(camera: OrbitCamera, point: np.ndarray) -> tuple[float, float]:
    x, y, _ = camera.project(point, SIZE)[0]
    return float(x), float(y)


@pytest.mark.parametrize("distance_m", [3.0, 14.0, 80.0])
def test_the_gizmo_has_the_same_size_on_the_screen_from_any_distance(distance_m):
    camera = OrbitCamera(POSE.position_m, distance_m, -50.0, 25.0)
    place = place_gizmo(POSE, "local", camera, SIZE)
    edge = np.array(POSE.position_m) + place.size_m * camera.axes()[0]
    centre = np.array(pixel_of(camera, np.array(POSE.position_m)))
    assert np.linalg.norm(np.array(pixel_of(camera, edge)) - centre) == pytest.approx(SIZE_PX, rel=1e-6)


@pytest.mark.parametrize("handle", MOVE_HANDLES + ROTATE_HANDLES)
@pytest.mark.parametrize("space", ["local", "world"])
def test_a_pixel_on_a_handle_means_that_handle(handle, space):
    place = place_gizmo(POSE, space, CAMERA, SIZE)
    mode = "move" if handle.kind == "move" else "rotate"
    line = handle_polyline(handle, place, CAMERA)
    line = line[~np.isnan(line).any(axis=1)]
    hits = [hit_handle(pixel_of(CAMERA, point), mode, place, CAMERA, SIZE) for point in line]
    assert hits.count(handle) >= 0.8 * len(hits)


def test_between_the_handles_there_is_nothing_to_grasp():
    place = place_gizmo(POSE, "world", CAMERA, SIZE)
    far_corner = np.array(POSE.position_m) + 1.4 * place.size_m * np.ones(3) / math.sqrt(3)
    assert hit_handle(pixel_of(CAMERA, far_corner), "both", place, CAMERA, SIZE) is None


def test_a_hidden_mode_cannot_be_grasped():
    place = place_gizmo(POSE, "world", CAMERA, SIZE)
    tip = np.array(POSE.position_m) + place.size_m * np.array([1.0, 0.0, 0.0])
    assert hit_handle(pixel_of(CAMERA, tip), "move", place, CAMERA, SIZE) == Handle("move", 0)
    assert hit_handle(pixel_of(CAMERA, tip), "rotate", place, CAMERA, SIZE) is None


def test_only_the_near_half_of_a_slanted_ring_can_be_grasped():
    place = place_gizmo(POSE, "world", CAMERA, SIZE)
    forward = CAMERA.axes()[2] * [1.0, 1.0, 0.0]
    radius = RING_RADIUS * place.size_m * forward / np.linalg.norm(forward)
    near, far = np.array(POSE.position_m) - radius, np.array(POSE.position_m) + radius
    assert hit_handle(pixel_of(CAMERA, near), "rotate", place, CAMERA, SIZE) == Handle("rotate", 2)
    assert hit_handle(pixel_of(CAMERA, far), "rotate", place, CAMERA, SIZE) != Handle("rotate", 2)


def test_a_ring_seen_face_on_can_be_grasped_all_round():
    camera = OrbitCamera(POSE.position_m, 10.0, -90.0, 90.0, parallel=True)
    place = place_gizmo(POSE, "world", camera, SIZE)
    assert not np.isnan(handle_polyline(Handle("rotate", 2), place, camera)).any()


def test_a_gizmo_behind_the_viewer_cannot_be_grasped():
    camera = OrbitCamera((0.0, -30.0, 2.0), 5.0, -90.0, 0.0)
    behind = Pose((0.0, -60.0, 2.0))
    place = place_gizmo(behind, "world", camera, SIZE)
    assert hit_handle((500.0, 350.0), "both", place, camera, SIZE) is None
