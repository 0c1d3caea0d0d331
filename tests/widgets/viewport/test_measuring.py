"""Clicks while measuring: on a sensor, on the car, on the ground, and past everything; drags still turn the view."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from riglens.widgets.viewport.measured import BODY, GROUND, Measured, Place
from tests.widgets.mouse import hover
from tests.widgets.viewport.views import LIDAR, change, drag, listen, pixel_at, settle, to_point


def clicked(view, pixel) -> Place | None:
    found: list[Place | None] = []
    view.place_picked.connect(found.append)
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, pixel))
    view.place_picked.disconnect(found.append)
    (place,) = found
    return place


def test_clicks_find_sensors_body_and_ground_and_select_nothing(view) -> None:
    heard = listen(view)
    view.set_tool("measure", True)
    assert clicked(view, pixel_at(view, np.array(LIDAR.position))) == Place(LIDAR.position, "roof", "roof")
    roof_m = np.array([0.0, 0.0, view.state.vehicle.height])
    body = clicked(view, pixel_at(view, roof_m))
    assert body is not None and body.what == BODY and body.point_m == pytest.approx(roof_m, abs=0.16)
    ground_m = np.array([4.0, -3.0, 0.0])
    ground = clicked(view, pixel_at(view, ground_m))
    assert (
        ground is not None and ground.what == GROUND and ground.point_m == pytest.approx(ground_m, abs=0.03)
    )
    assert heard.signals == []


def test_past_everything_nothing_is_measured_and_drags_turn_the_view(view) -> None:
    view.set_view("front")
    settle(view)
    view.set_tool("measure", True)
    assert clicked(view, np.array([20.0, 20.0])) is None
    camera, heard = view.state.camera, listen(view)
    drag(view, np.array([60.0, 60.0]), np.array([200.0, 90.0]))
    assert view.state.camera != camera and heard.signals == []
    view.set_tool("measure", False)
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, np.array([20.0, 20.0])))
    assert heard.story() == ["sensor_picked"]


def test_the_line_is_drawn_over_everything_with_its_numbers_inside_the_view(view) -> None:
    settle(view)
    from tests.widgets.viewport.views import picture

    before = picture(view)
    change(view, measured=Measured(Place((0.0, 0.0, 0.3), BODY), Place((2.0, 1.0, 0.0), GROUND)))
    settle(view)
    assert np.abs(picture(view).astype(int) - before).max() > 40
    assert view._scene._measure.texts[0] == "2.256 m"
    change(view, measured=None)
    settle(view)
    assert view._scene._measure.texts == [] and np.array_equal(picture(view), before)


def test_a_rubber_band_follows_the_mouse_until_the_second_click(view) -> None:
    view.set_tool("measure", True)
    change(view, measured=Measured(Place(LIDAR.position, "roof", "roof")))
    texts = view._scene._measure.texts
    assert texts[1] == "click the second point"
    ground_m = np.array([4.0, -3.0, 0.0])
    hover(view._canvas, to_point(view, pixel_at(view, ground_m)))
    length_m = float(np.linalg.norm(ground_m - LIDAR.position))
    found = view._scene._measure.texts
    assert float(found[0].removesuffix(" m")) == pytest.approx(length_m, abs=0.03) and "to ground" in found[2]
    assert view.state.measured == Measured(Place(LIDAR.position, "roof", "roof"))  # nothing was clicked
    view._controller.leave()
    assert view._scene._measure.texts == texts
    second = Place((1.0, 0.0, 0.0), GROUND)
    change(view, measured=Measured(Place(LIDAR.position, "roof", "roof"), second))
    texts = view._scene._measure.texts
    hover(view._canvas, to_point(view, pixel_at(view, ground_m)))
    assert view._scene._measure.texts == texts
