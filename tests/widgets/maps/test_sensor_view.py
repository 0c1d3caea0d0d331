"""The sensor view draws what the core computed: classes in their colours, nearest on top, beams row by row."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF
from PySide6.QtGui import QColor, QImage
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Camera, Lidar
from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.scene.grid import VoxelGrid
from riglens.core.vehicle.solid import Solid
from riglens.core.view.camera_picture import camera_picture
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.range_image import range_image
from riglens.widgets.maps.range_view import azimuth_text, azimuth_ticks, nearest_of, spread
from riglens.widgets.maps.sensor_view import SensorViewPanel
from riglens.widgets.theme import CLASS_COLOURS
from tests.waiting import TIMEOUT_MS
from tests.widgets.mouse import hover

GRID = VoxelGrid(0.5, (60.0, 40.0, 4.0))
NO_BODY = Solid.of(np.zeros((0, 3, 3)))
CAMERA = Camera(name="front", position=(0.0, 0.0, 1.5), image=(400, 200), hfov_deg=90.0, cast=(40, 20))
LIDAR = Lidar(name="roof", position=(0.0, 0.0, 2.0), elevations_deg=(-20.0, 5.0, -3.0))


def boxes(*rows: tuple[int, float, float]) -> FrameBoxes:
    """Boxes of 1 x 2 x 3 m on the ground from rows (class, x, y)."""
    return FrameBoxes(
        np.array([row[0] for row in rows], np.uint8),
        np.array([(row[1], row[2], 1.5) for row in rows]).reshape(-1, 3),
        np.tile((1.0, 2.0, 3.0), (len(rows), 1)),
        rotations_from_yaw(np.zeros(len(rows))),
    )


@pytest.fixture
def view(qtbot: QtBot) -> SensorViewPanel:
    view = SensorViewPanel()
    qtbot.addWidget(view)
    view.resize(480, 360)
    view.set_frames(100)
    with qtbot.waitExposed(view, timeout=TIMEOUT_MS):
        view.show()
    return view


def pixel(view: SensorViewPanel, x_px: float, y_px: float) -> QPointF:
    """Where a native pixel of the camera image is on the camera's widget."""
    area = view.camera.image_area
    return QPointF(area.left() + x_px / 400 * area.width(), area.top() + y_px / 200 * area.height())


def hue_at(view: SensorViewPanel, x_px: float, y_px: float) -> int:
    image: QImage = view.camera.grab().toImage()
    at = pixel(view, x_px, y_px) * image.devicePixelRatio()
    return image.pixelColor(at.toPoint()).hue()


def test_the_nearer_box_is_drawn_over_the_farther_one(view: SensorViewPanel) -> None:
    for near, far, cls in ((6.0, 12.0, 0), (12.0, 6.0, 1)):
        view.show_camera(camera_picture(CAMERA, GRID, boxes((0, near, 0.0), (1, far, 0.0)), NO_BODY))
        name = ("car", "bicycle")[cls]
        assert hue_at(view, 200, 100) == pytest.approx(QColor(CLASS_COLOURS[name]).hue(), abs=3)


def test_a_box_on_the_left_of_the_car_is_on_the_left_of_the_image(view: SensorViewPanel) -> None:
    view.show_camera(camera_picture(CAMERA, GRID, boxes((2, 8.0, 4.0)), NO_BODY))
    assert hue_at(view, 100, 100) == pytest.approx(QColor(CLASS_COLOURS["pedestrian"]).hue(), abs=3)
    assert hue_at(view, 300, 100) != pytest.approx(QColor(CLASS_COLOURS["pedestrian"]).hue(), abs=3)


def test_hovering_over_the_image_says_what_is_there_and_how_far(view: SensorViewPanel) -> None:
    view.show_camera(camera_picture(CAMERA, GRID, boxes((0, 8.0, 0.0)), NO_BODY))
    assert view.camera.readout() == "400 × 200 px · sees car 1"
    hover(view.camera, pixel(view, 200, 100).toPoint())
    assert view.camera.readout().endswith("car, 7.5 m away")
    hover(view.camera, pixel(view, 20, 20).toPoint())
    assert view.camera.readout().startswith("pixel ")


def test_the_rays_of_the_score_can_be_shown_on_the_image(qtbot: QtBot, view: SensorViewPanel) -> None:
    view.show_camera(camera_picture(CAMERA, GRID, boxes(), NO_BODY))
    before = view.camera.grab().toImage()
    view.rays.click()
    assert view.camera.grab().toImage() != before


def test_the_own_car_is_drawn_where_the_mask_says(view: SensorViewPanel) -> None:
    a, b, c, d = (0.5, -2.0, 1.0), (3.0, -2.0, 1.0), (3.0, 2.0, 1.0), (0.5, 2.0, 1.0)
    bonnet = np.array([[a, b, c], [a, c, d]])
    view.show_camera(camera_picture(CAMERA, GRID, boxes(), Solid.of(bonnet)))
    hover(view.camera, pixel(view, 200, 180).toPoint())
    assert view.camera.readout().endswith("own car")
    hover(view.camera, QPoint(1, 1))
    assert "own car" in view.camera.readout()


def test_hovering_over_a_range_image_names_beam_angles_and_what_is_hit(view: SensorViewPanel) -> None:
    view.show_ranges(range_image(LIDAR, boxes((1, 8.0, 0.0)), NO_BODY), 40.0)
    area, of_all = view.ranges.image_area, view.ranges.readout()
    hover(view.ranges, QPointF(area.center().x() - 1, area.top() + area.height() / 2).toPoint())
    assert view.ranges.readout().startswith("beam 3 of 3 · 3.00° down, ")
    assert view.ranges.readout().endswith("bicycle, 7.5 m")
    hover(view.ranges, QPointF(area.left() + 3, area.top() + 3).toPoint())
    assert view.ranges.readout().endswith("no return")
    for beside in (
        QPointF(area.center().x(), area.bottom() + 2),
        QPointF(area.right() + 2, area.center().y()),
    ):
        hover(view.ranges, beside.toPoint())
        assert view.ranges.readout() == of_all


def test_range_images_are_coloured_by_range_or_by_what_is_hit(view: SensorViewPanel) -> None:
    view.show_ranges(range_image(LIDAR, boxes((1, 8.0, 0.0)), NO_BODY), 40.0)
    area = view.ranges.image_area
    at = QPointF(area.center().x(), area.top() + area.height() / 2).toPoint()
    by_range = view.ranges.grab().toImage().pixelColor(at)
    view.colouring.setCurrentIndex(1)
    assert view.ranges.grab().toImage().pixelColor(at) == QColor(CLASS_COLOURS["bicycle"]) != by_range


def test_frames_are_chosen_by_number_or_slider_and_said_once(qtbot: QtBot, view: SensorViewPanel) -> None:
    chosen: list[int] = []
    view.frame_chosen.connect(chosen.append)
    view.frame.setValue(7)
    view.slider.setValue(12)
    assert chosen == [7, 12]
    assert view.chosen_frame == 12 == view.frame.value()


def test_a_chosen_frame_stays_while_it_exists(view: SensorViewPanel) -> None:
    view.frame.setValue(40)
    view.set_frames(60)
    assert view.chosen_frame == 40
    view.set_frames(10)
    assert view.chosen_frame == 9


def test_only_what_belongs_to_the_picture_is_offered(view: SensorViewPanel) -> None:
    view.show_camera(camera_picture(CAMERA, GRID, boxes(), NO_BODY))
    assert view.rays.isVisible() and not view.colouring.isVisible()
    view.show_ranges(range_image(LIDAR, boxes(), NO_BODY), 40.0)
    assert view.colouring.isVisible() and not view.rays.isVisible()
    view.show_text("Nothing")
    assert view.text.isVisible() and not view.frame.isVisible()


def test_axes_have_round_labels_that_fit() -> None:
    assert spread(16, 16) == list(range(16))
    assert spread(64, 10) == list(range(0, 64, 7))
    assert spread(3, 0) == [0]
    turn = 180.0 - np.arange(360.0)
    assert [text for _, text in azimuth_ticks(turn, 5)] == ["90° right", "ahead", "90° left", "behind"]
    assert [column for column, _ in azimuth_ticks(turn, 5)] == [270, 180, 90, 0]
    assert azimuth_ticks(np.array([30.0]), 5)[0] == (0, "30° left")
    assert azimuth_text(-180.0) == "behind"


def test_a_thin_thing_stays_in_a_range_image_with_more_azimuths_than_pixels() -> None:
    post = FrameBoxes(
        np.zeros(1, np.uint8),
        np.array([[6.0, 0.0, 1.5]]),
        np.array([[0.05, 0.05, 3.0]]),
        rotations_from_yaw(np.zeros(1)),
    )
    image = range_image(LIDAR, post, NO_BODY)
    row = int(np.flatnonzero((image.what == 0).any(axis=1))[0])
    for most in (400, 360, 100, 7):
        shown = nearest_of(image, most)
        assert len(shown) <= most and shown.max() < 360
        assert (np.take_along_axis(image.what, shown.T, axis=1)[row] == 0).sum() == 1
