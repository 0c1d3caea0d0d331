"""What the picture detector is taught of an object leads back to the object."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.detect.views import LEAST_PX, Lenses, Marks, marks_of, places_of, wanted_in
from riglens.core.rig.model import Camera
from riglens.core.sensors.camera import project_px

CAMERAS = (
    Camera(name="wide", position=(0.5, 0.0, 1.8), hfov_deg=100.0, image=(640, 256), cast=(320, 128)),
    Camera(
        name="aside",
        position=(-1.0, 0.4, 1.2),
        rpy_deg=(0.0, 0.0, 110.0),
        hfov_deg=50.0,
        image=(640, 256),
        cast=(320, 128),
    ),
)


def seen(camera: Camera, centre_m: np.ndarray) -> Marks:
    """Marks of small objects, each visible around its centre."""
    local = (centre_m - np.array(camera.position)) @ camera.pose.rotation()
    place = project_px(camera, local) / 2.0 - 0.5
    low = np.floor(place).astype(np.int64)
    bounds = np.concatenate([low - 1, low + 2], axis=1)
    cls = np.arange(len(centre_m)).astype(np.uint8) % 3
    return marks_of(camera, np.full(len(centre_m), LEAST_PX), bounds, cls, centre_m)


def ahead_of(camera: Camera, count: int) -> np.ndarray:
    rng = np.random.default_rng(1)
    away, turn = rng.uniform(5.0, 40.0, count), np.radians(rng.uniform(-20.0, 20.0, count))
    turn += np.radians(camera.rpy_deg[2])
    along = np.stack([np.cos(turn), np.sin(turn)], axis=1) * away[:, None]
    return np.column_stack([along + np.array(camera.position[:2]), np.full(count, 1.0)])


@pytest.mark.parametrize("number", [0, 1])
def test_a_target_leads_back_to_the_place_of_its_object(number: int) -> None:
    lenses, centre_m = Lenses.of(CAMERAS), ahead_of(CAMERAS[number], 12)
    for place in centre_m:
        marks = seen(CAMERAS[number], place[None])
        peaks, figures, cells = wanted_in(marks, float(lenses.focal_px[number]), (128, 320), False)
        assert peaks.reshape(3, -1)[marks.cls[0], cells[0]] == 1.0
        found = places_of(lenses, number, cells, figures.astype(np.float64))
        assert np.hypot(*(found[0] - place[:2])) < 0.01 * np.hypot(*place[:2])


def test_a_peak_is_the_middle_of_the_pixels_of_an_object() -> None:
    bounds = np.array([[5, 3, 6, 4], [10, 20, 14, 21]])  # one pixel, and four in a row
    marks = marks_of(CAMERAS[0], np.full(2, LEAST_PX), bounds, np.zeros(2, np.uint8), ahead_of(CAMERAS[0], 2))
    assert marks.peak.tolist() == [[3.0, 5.0], [20.0, 11.5]]


def test_marks_far_beside_a_picture_are_one_width_of_it_away() -> None:
    camera = CAMERAS[0]
    beside = np.add(camera.position, [[2.0, 30.0, 0.0], [2.0, -30.0, 0.0]])
    marks = marks_of(camera, np.full(2, LEAST_PX), np.zeros((2, 4), int), np.zeros(2, np.uint8), beside)
    assert marks.column.tolist() == [-320.0, 640.0]


def test_beside_a_picture_bearings_go_on_as_between_its_outermost_pixels() -> None:
    lenses, columns = Lenses.of(CAMERAS[:1]), np.array([-3.0, 0.0, 1.0, 318.0, 319.0, 322.0])
    found = lenses.located(0, np.full(6, 64), columns, np.full(6, 10.0)) - np.array(CAMERAS[0].position[:2])
    turns = np.arctan2(found[:, 1], found[:, 0])
    assert turns[0] - turns[1] == pytest.approx(3.0 * (turns[1] - turns[2]))
    assert turns[4] - turns[5] == pytest.approx(3.0 * (turns[3] - turns[4]))


def test_a_mirrored_picture_is_taught_the_mirrored_object() -> None:
    camera, mirror = CAMERAS[0], np.array([1.0, -1.0, 1.0])
    centre_m = ahead_of(camera, 1)
    shape = (128, 320)
    one = wanted_in(seen(camera, centre_m), 250.0, shape, True)
    other = wanted_in(seen(camera, centre_m * mirror), 250.0, shape, False)
    assert abs(int(one[2][0]) - int(other[2][0])) <= 1  # cells are two pixels wide
    aside = [cells[0] % 160 + 4.0 * figures[0, 1] for _, figures, cells in (one, other)]
    assert one[1][0, 0] == pytest.approx(other[1][0, 0], rel=1e-6)
    assert aside[0] == pytest.approx(aside[1], abs=0.51)  # mirrored about the middle between two pixels


def test_a_scaled_lens_and_distance_are_the_same_to_the_net() -> None:
    marks = seen(CAMERAS[0], ahead_of(CAMERAS[0], 1))
    far = marks._replace(distance_m=2.0 * marks.distance_m)
    one, other = (wanted_in(of, px, (128, 320), False) for of, px in ((marks, 200.0), (far, 400.0)))
    assert one[1] == pytest.approx(other[1], abs=1e-5)


def test_objects_of_few_pixels_or_behind_the_camera_are_not_marked() -> None:
    centre_m = np.array([[10.0, 0.0, 1.0], [10.0, 1.0, 1.0], [-10.0, 0.0, 1.0]])
    bounds = np.tile([100, 50, 103, 53], (3, 1))
    pixels = np.array([LEAST_PX, LEAST_PX - 1, LEAST_PX])
    assert marks_of(CAMERAS[0], pixels, bounds, np.zeros(3, np.uint8), centre_m).cls.shape == (1,)


def test_pixels_say_where_their_rays_meet_flat_ground() -> None:
    lenses = Lenses.of(CAMERAS[:1])
    slope, near, focal = np.moveaxis(lenses.figures[0], -1, 0)
    assert (np.diff(slope[:, 160]) < 0.0).all()  # rows run downwards
    row = 100
    away_m = 1.8 / -slope[row, 160]
    assert 15.0 * np.exp(2.0 * near[row, 160]) == pytest.approx(away_m, rel=1e-5)
    assert np.unique(focal).size == 1
