"""Keep-out zones on the car: painted with the left button, drawn exactly, and beside the car a drag turns the view."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from riglens.core.rig.model import Vehicle
from riglens.widgets.car.keep_out import KeepOut, Zone
from riglens.widgets.car.keep_out_layer import KeepOutLayer
from tests.widgets.viewport.views import change, drag, listen, picture, pixel_at, settle, to_point

ROOF_M = np.array([0.0, 0.0, 1.45])


def test_a_stroke_tells_where_it_touches_the_car_and_beside_it_a_drag_turns_the_view(view) -> None:
    heard: list[tuple] = []
    view.brushed.connect(lambda point_m, begins: heard.append((point_m, begins)))
    view.brush_ended.connect(heard.append)
    story, camera = listen(view), view.state.camera
    view.set_tool("paint", True)
    drag(view, pixel_at(view, ROOF_M), pixel_at(view, ROOF_M - [0.3, 0.0, 0.0]))
    (first, begins), *more, end = heard
    assert begins and first == pytest.approx(ROOF_M, abs=0.06) and end is True
    assert more and all(not begins for _, begins in more)
    assert more[-1][0] == pytest.approx(ROOF_M - [0.3, 0.0, 0.0], abs=0.06)
    assert view.state.camera == camera and story.signals == []
    heard.clear()
    drag(view, np.array([10.0, 10.0]), np.array([80.0, 30.0]))
    assert heard == [] and view.state.camera != camera


def test_escape_gives_a_stroke_up(view) -> None:
    heard: list[bool] = []
    view.brush_ended.connect(heard.append)
    view.set_tool("paint", True)
    QTest.mousePress(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, pixel_at(view, ROOF_M)))
    QTest.keyClick(view._canvas, Qt.Key.Key_Escape)
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, pixel_at(view, ROOF_M)))
    assert heard == [False]


def test_zones_are_seen_on_the_car_and_gone_again(view) -> None:
    settle(view)
    before = picture(view)
    change(view, keep_out=KeepOut((Zone("glass"),), ((*ROOF_M, 0.2),)))
    settle(view)
    assert np.abs(picture(view).astype(int) - before).max() > 40
    change(view, keep_out=None)
    settle(view)
    assert np.array_equal(picture(view), before)


class Room:
    """A renderer that holds nothing."""

    def AddActor(self, actor) -> None:
        """Take an actor."""


def test_spots_and_boxes_are_cut_exactly_out_of_the_skin() -> None:
    layer, vehicle = KeepOutLayer(Room()), Vehicle()
    spots = ((0.0, 0.0, 1.45, 0.2), (9.0, 0.0, 0.0, 0.1))
    box = ((-0.5, -2.0, 0.3), (0.5, 2.0, 0.6))
    layer.show(
        vehicle,
        KeepOut((Zone(None, (box,)), Zone("glass", (((0.0, -2.0, 0.0), (9.0, 2.0, 9.0)),))), spots),
    )
    zones, painted = (np.asarray(actor.mapper.GetInput().points) for actor in layer._actors)
    away_m = np.linalg.norm(painted - spots[0][:3], axis=1)
    assert away_m.max() == pytest.approx(0.2, abs=0.006)  # up to the edge, and a little off the skin
    door = zones[zones[:, 2] < 0.7]
    assert door[:, 0].min() == pytest.approx(-0.5, abs=0.006) and door[:, 0].max() == pytest.approx(
        0.5, abs=0.006
    )
    assert door[:, 2].min() >= 0.29 and zones[zones[:, 2] > 0.7][:, 0].min() >= -0.006
    pieces = dict(layer._pieces)
    layer.show(vehicle, KeepOut((), (*spots, (0.5, 0.0, 1.4, 0.1))))
    assert all(layer._pieces[spot] is pieces[spot] for spot in spots)  # a brush costs one spot
    assert not layer._actors[0].visibility and layer._actors[1].visibility
    layer.show(vehicle, None)
    assert not any(actor.visibility for actor in layer._actors)
