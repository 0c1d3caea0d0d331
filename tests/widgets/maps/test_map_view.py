"""The map: north is ahead, colours tell empty, blind and seen apart, and the mouse finds places and sensors."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, QRect, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QWheelEvent
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.scene.grid import VoxelGrid
from riglens.core.view.top_view import BLIND, MOST, TopView
from riglens.widgets.maps.map_items import BLIND_COLOUR, PlaneView, ring_labels
from riglens.widgets.maps.map_view import MapView
from tests.waiting import TIMEOUT_MS
from tests.widgets.mouse import hover

GRID = VoxelGrid(0.5, (20.0, 20.0, 4.0))
LIDAR = Lidar(
    name="roof",
    position=(4.0, 2.0, 1.9),
    elevations_deg=LinearAngles(**{"from": -20.0, "to": 10.0, "count": 4}),
)
CAMERA = Camera(name="front", position=(-5.0, -3.0, 1.4), image=(160, 90), hfov_deg=90.0, cast=(32, 18))


def top_view() -> TopView:
    """Nothing but a blind spot ahead on the left and a seen one behind on the right."""
    entropy, seen, levels = np.zeros((40, 40)), np.zeros((40, 40)), np.zeros((40, 40), np.uint8)
    entropy[34:38, 30:34], levels[34:38, 30:34] = 2.0, BLIND
    entropy[4:8, 8:12], seen[4:8, 8:12], levels[4:8, 8:12] = 4.0, 1.0, MOST
    return TopView(
        0.5, (-10.0, -10.0), "car", "any", entropy.astype(np.float32), seen.astype(np.float32), levels
    )


@pytest.fixture
def view(qtbot: QtBot) -> MapView:
    view = MapView()
    qtbot.addWidget(view)
    view.resize(300, 360)
    view.set_grid(GRID)
    view.set_rig(Rig(sensors=(LIDAR, CAMERA)), frozenset(), frozenset({"roof"}))
    view.set_top_view(top_view())
    with qtbot.waitExposed(view, timeout=TIMEOUT_MS):
        view.show()
    return view


def colour_at(view: MapView, x_m: float, y_m: float) -> QColor:
    image: QImage = view.grab().toImage()
    ratio = image.devicePixelRatio()
    at = view.plane.to_px(x_m, y_m)
    return image.pixelColor(round(at.x() * ratio), round(at.y() * ratio))


def spot(view: MapView, x_m: float, y_m: float) -> QPoint:
    return view.plane.to_px(x_m, y_m).toPoint()


def test_ahead_is_up_and_left_is_left() -> None:
    plane = PlaneView.fitted(QRectF(0, 0, 200, 400), 60.0, 40.0)
    middle, ahead, left = plane.to_px(0, 0), plane.to_px(10, 0), plane.to_px(0, 10)
    assert ahead.y() < middle.y() and ahead.x() == middle.x()
    assert left.x() < middle.x() and left.y() == middle.y()


def test_places_survive_the_way_there_and_back_at_any_zoom() -> None:
    plane = (
        PlaneView.fitted(QRectF(0, 0, 200, 400), 60.0, 40.0)
        .zoomed(3.0, QPointF(20, 30))
        .shifted(QPointF(7, -9))
    )
    assert plane.to_m(plane.to_px(3.25, -7.5)) == pytest.approx((3.25, -7.5))


def test_zooming_leaves_what_is_under_the_mouse_where_it_is() -> None:
    plane, mouse = PlaneView.fitted(QRectF(0, 0, 200, 400), 60.0, 40.0), QPointF(150.0, 90.0)
    assert plane.zoomed(2.5, mouse).to_m(mouse) == pytest.approx(plane.to_m(mouse))


def test_blind_seen_and_empty_areas_have_colours_of_their_own(view: MapView) -> None:
    blind, seen, empty = (colour_at(view, *at) for at in ((8.0, 6.0), (-7.0, -5.0), (0.0, -8.0)))
    assert blind == QColor(BLIND_COLOUR)
    assert seen.red() > 200 and seen.green() > 200 and seen.blue() < 100  # the bright end of the colour bar
    assert len({blind.name(), seen.name(), empty.name()}) == 3


def test_hovering_says_place_share_and_entropy(view: MapView) -> None:
    hover(view, spot(view, -7.0, -5.0))
    assert view.readout() == "x -7.0  y -5.0 m · 100 % seen of 4 nat"
    hover(view, spot(view, 8.0, 6.0))
    assert "0 % seen of 2 nat" in view.readout()
    hover(view, spot(view, 0.0, -8.0))
    assert view.readout().endswith("no cars here")
    hover(view, spot(view, -5.0, -3.0))
    assert view.readout().startswith("front · ")


def test_without_the_mouse_it_says_how_much_is_blind(view: MapView) -> None:
    assert view.readout() == "50.0 % of the area with cars is blind"


def test_a_click_selects_a_sensor_or_names_the_place(qtbot: QtBot, view: MapView) -> None:
    with qtbot.waitSignal(view.sensor_clicked, timeout=TIMEOUT_MS) as picked:
        qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=spot(view, 4.0, 2.0))
    assert picked.args == ["roof"]
    with qtbot.waitSignal(view.place_clicked, timeout=TIMEOUT_MS) as placed:
        qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=spot(view, -8.0, 7.0))
    assert placed.args == pytest.approx([-8.0, 7.0], abs=0.1)


def test_hidden_sensors_are_neither_drawn_nor_found(qtbot: QtBot, view: MapView) -> None:
    view.set_rig(Rig(sensors=(LIDAR, CAMERA)), frozenset({"front"}), frozenset())
    with qtbot.waitSignal(view.place_clicked, timeout=TIMEOUT_MS):
        qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=spot(view, -5.0, -3.0))


def test_every_selected_sensor_is_marked(view: MapView) -> None:
    rig = Rig(sensors=(LIDAR, CAMERA))
    pictures = []
    for selected in ({"roof"}, {"front"}, {"roof", "front"}):
        view.set_rig(rig, frozenset(), frozenset(selected))
        pictures.append(view.grab().toImage())
    both = pictures.pop()
    for sensor, other in zip((LIDAR, CAMERA), pictures, strict=True):
        at = spot(view, *sensor.position[:2])
        area = QRect(at - QPoint(12, 12), at + QPoint(12, 12))
        assert other.copy(area) == both.copy(area)
    assert all(other != both for other in pictures)


def test_dragging_shifts_and_does_not_click(qtbot: QtBot, view: MapView) -> None:
    clicked: list[object] = []
    view.place_clicked.connect(lambda *place: clicked.append(place))
    start = spot(view, -8.0, 7.0)
    qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=start)
    for step in (8, 20, 40):
        hover(view, start + QPoint(step, 0), Qt.MouseButton.LeftButton)
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=start + QPoint(40, 0))
    assert not clicked
    assert view.plane.to_px(-8.0, 7.0).x() == pytest.approx(start.x() + 40, abs=1.0)


def test_the_wheel_zooms_and_a_double_click_shows_all_again(qtbot: QtBot, view: MapView) -> None:
    before, at = view.plane, QPointF(spot(view, -8.0, 7.0))
    for _ in range(3):
        event = QWheelEvent(
            at, view.mapToGlobal(at), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton,
            Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(view, event)
    assert view.plane.scale > 1.5 * before.scale
    qtbot.mouseDClick(view, Qt.MouseButton.LeftButton, pos=at.toPoint())
    assert view.plane == before


@pytest.mark.parametrize("size_px", [(160, 160), (250, 300), (304, 380), (600, 500), (1200, 700)])
def test_labels_of_rings_are_never_cut_by_map_or_region(size_px: tuple[int, int]) -> None:
    plane = PlaneView.fitted(QRectF(0, 0, *size_px), 60.0, 40.0)
    roi, label = plane.rectangle((-30, 30), (-20, 20)), QSizeF(28.0, 12.0)
    places = ring_labels(plane, roi, (10.0, 20.0, 30.0), label)
    assert len(places) >= 2
    for radius_m, at in places.items():
        x, y = plane.to_m(at)
        assert np.hypot(x, y) == pytest.approx(radius_m)
        box = QRectF(at.x() - 14.0, at.y() - 6.0, 28.0, 12.0)
        assert plane.area.contains(box) and (roi.contains(box) or not roi.intersects(box))


def test_a_larger_widget_shows_the_whole_roi_larger(view: MapView) -> None:
    before = view.plane.scale
    view.resize(600, 700)
    QApplication.processEvents()
    assert view.plane.scale > 1.7 * before
