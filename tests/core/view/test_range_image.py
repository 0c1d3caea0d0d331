"""A range image lists beams from the highest down and azimuths from left to right, with the ranges of its rays."""

import numpy as np
import pytest

from riglens.core.rig.model import Lidar, LinearAngles
from riglens.core.vehicle.solid import Solid
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import GROUND, NOTHING
from riglens.core.view.range_image import range_image, wrapped_deg
from tests.core.view.view_cases import frame_of

NO_BODY = Solid.of(np.zeros((0, 3, 3)))


def lidar(**changes: object) -> Lidar:
    fields: dict[str, object] = {
        "name": "roof",
        "position": (0.0, 0.0, 2.0),
        "elevations_deg": (-10.0, 5.0, -30.0, -1.0),
        "azimuths_deg": LinearAngles(**{"from": 0.0, "to": 360.0, "count": 72}),
    }
    return Lidar(**(fields | changes))  # type: ignore[arg-type]


def test_rows_go_down_and_columns_from_left_to_right_however_the_sensor_lists_them() -> None:
    image = range_image(lidar(), FrameBoxes.none(), NO_BODY)
    assert image.elevations_deg.tolist() == [5.0, -1.0, -10.0, -30.0]
    assert image.beams.tolist() == [1, 3, 0, 2]
    assert image.azimuths_deg[0] == 180.0
    assert (np.diff(image.azimuths_deg) == -5.0).all()


def test_a_ray_has_the_offset_of_its_beam_which_is_not_that_of_its_row() -> None:
    image = range_image(lidar(azimuth_offsets_deg=(1.0, 2.0, 3.0, 4.0)), FrameBoxes.none(), NO_BODY)
    assert [image.azimuth_deg(row, 0) for row in range(4)] == [182.0, 184.0, 181.0, 183.0]


def test_on_flat_ground_ranges_follow_from_height_and_elevation() -> None:
    image = range_image(lidar(), FrameBoxes.none(), NO_BODY)
    assert (image.what[0] == NOTHING).all() and np.isinf(image.range_m[0]).all()
    assert (image.what[1:] == GROUND).all()
    expected = 2.0 / np.sin(np.radians([1.0, 10.0, 30.0]))
    np.testing.assert_allclose(image.range_m[1:], np.broadcast_to(expected[:, None], (3, 72)))
    assert image.returns == 3 * 72


def test_a_box_on_the_left_is_in_the_left_half() -> None:
    boxes = frame_of((2, (0.0, 6.0, 1.0), (1.0, 1.0, 3.0), 0.0))
    image = range_image(lidar(), boxes, NO_BODY)
    columns = np.flatnonzero((image.what == 0).any(axis=0))
    assert len(columns) > 0
    assert (image.azimuths_deg[columns] > 80.0).all() and (image.azimuths_deg[columns] < 100.0).all()
    assert image.range_m[1, columns[len(columns) // 2]] == pytest.approx(5.5, rel=0.02)
    assert image.box_classes.tolist() == [2]


def test_a_turned_sensor_sees_the_same_box_elsewhere() -> None:
    boxes = frame_of((0, (8.0, 0.0, 1.0), (1.0, 1.0, 3.0), 0.0))
    image = range_image(lidar(rpy_deg=(0.0, 0.0, 90.0)), boxes, NO_BODY)
    columns = np.flatnonzero((image.what == 0).any(axis=0))
    assert np.median(image.azimuths_deg[columns]) == pytest.approx(-90.0, abs=5.0)


def test_of_very_many_rays_only_some_are_cast() -> None:
    image = range_image(lidar(), FrameBoxes.none(), NO_BODY, max_rays=50)
    assert image.range_m.size <= 50
    assert image.thinned == (1, 6)
    tiny = range_image(lidar(azimuths_deg=(0.0,)), FrameBoxes.none(), NO_BODY, max_rays=2)
    assert tiny.range_m.shape == (2, 1)


def test_angles_wrap_into_one_turn() -> None:
    np.testing.assert_allclose(
        wrapped_deg(np.array([-180.0, 180, 190, -190, 0, 360])), [180, 180, -170, 170, 0, 0]
    )
