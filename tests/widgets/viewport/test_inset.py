"""The selected camera's picture in a corner of the view: the scene through its lens, and none for other sensors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtWidgets import QWidget
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Camera, Lidar, Rig
from riglens.core.sensors.camera import field_of_view_deg
from riglens.widgets.drawing.camera import through
from riglens.widgets.viewport.inset import CameraInset
from riglens.widgets.viewport.scene_state import SceneState
from tests.hand_clock import HandTimers

FRONT = Camera(name="front", position=(0.4, 0.0, 1.5), image=(160, 90), hfov_deg=65.0)
WIDE = FRONT.replace(name="wide", hfov_deg=150.0)
RIG = Rig(sensors=(FRONT, WIDE, Lidar(name="top", position=(0.0, 0.0, 1.9), elevations_deg=(-10.0, 0.0))))


@pytest.fixture
def inset(qtbot: QtBot, xvfb: None) -> Iterator[CameraInset]:
    view, timers = QWidget(), HandTimers()
    view.resize(800, 600)
    qtbot.addWidget(view)
    made = CameraInset(view, timers)
    made.timers = timers  # type: ignore[attr-defined]
    view.show()
    yield made
    made.release()


def drawn(inset: CameraInset) -> np.ndarray:
    inset.timers.run_out()  # type: ignore[attr-defined]
    image = inset._image
    return np.array(
        [image.pixel(x, y) for x in range(0, image.width(), 8) for y in range(0, image.height(), 8)]
    )


def test_a_selected_camera_shows_its_picture_and_a_turn_changes_it(inset: CameraInset) -> None:
    state = SceneState(rig=RIG, selected="front")
    inset.follow(state)
    assert inset.isVisible() and inset.box is not None and inset.box.width < 0.3 * 800
    before = drawn(inset)
    image = inset._image
    assert image.width() / image.height() == pytest.approx(160 / 90, rel=0.02)
    turned = RIG.with_sensor("front", FRONT.replace(rpy_deg=(0.0, 30.0, 0.0)))
    inset.follow(replace(state, rig=turned))
    assert (drawn(inset) != before).mean() > 0.1


@pytest.mark.parametrize("name", ["wide", "top", None])
def test_other_sensors_and_lenses_too_wide_show_none(inset: CameraInset, name: str | None) -> None:
    inset.follow(SceneState(rig=RIG, selected="front"))
    inset.follow(SceneState(rig=RIG, selected=name))
    assert inset.isHidden() and inset.box is None


def test_it_is_shown_only_on_request_and_where_there_is_room(inset: CameraInset) -> None:
    state = SceneState(rig=RIG, selected="front")
    inset.follow(state)
    inset.set_wanted(False)
    assert inset.isHidden()
    inset.set_wanted(True)
    assert inset.isVisible()
    inset.parentWidget().resize(300, 200)
    inset.follow(state)
    assert inset.isHidden()


def test_the_view_through_a_lens_spans_its_field_from_its_place() -> None:
    camera = FRONT.replace(rpy_deg=(0.0, 10.0, 40.0))
    lens = through(camera)
    assert lens is not None and np.allclose(lens.position_m(), camera.position)
    assert np.allclose(lens.axes()[2], camera.pose.rotation()[:, 0])
    assert lens.view_angle_deg == field_of_view_deg(camera)[1]
