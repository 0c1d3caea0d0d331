"""Footprints are found in a thread, and the view draws them when they are known."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QCoreApplication
from pytestqt.qtbot import QtBot

from riglens.app.background.footprints import FootprintsRequest, find_footprints
from riglens.app.background.worker import BackgroundWorker, Context
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.footprints import Footprints
from riglens.core.errors import Cancelled
from riglens.core.footprint.ground import FOOTPRINTS, footprint
from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera
from riglens.core.vehicle.housings import car_of
from tests.app.window.desk import Desk, open_desk
from tests.waiting import TIMEOUT_S


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    return open_desk(qtbot)


@pytest.fixture
def waiting(desk: Desk) -> Iterator[Footprints]:
    Follow(desk.workbench).show_all()
    made = Footprints(desk.workbench, BackgroundWorker("footprints", find_footprints, close_s=TIMEOUT_S))
    yield made
    made.worker.close()


@pytest.fixture
def footprints(waiting: Footprints) -> Footprints:
    waiting.begin()
    settle(waiting)
    waiting.viewport.footprint_updates = 0
    return waiting


def settle(footprints: Footprints) -> None:
    assert footprints.worker.wait_until_idle(TIMEOUT_S)
    QCoreApplication.processEvents()


def show(desk: Desk, **fields: object) -> None:
    desk.viewport.show_state(replace(desk.viewport.state, **fields))  # type: ignore[arg-type]


def known(desk: Desk, name: str = "front"):
    rig, state = desk.document.rig, desk.viewport.state
    solid = None if state.solid_body is None else car_of(rig)
    return FOOTPRINTS.known(rig.sensor(name), state.ray_look.px_per_m, solid)


def place(desk: Desk, y_m: float) -> None:
    desk.document.move({"front": Pose((1.0, y_m, 1.41), desk.document.rig.sensor("front").rpy_deg)})


def test_footprints_are_found_free_until_the_car_is_solid_and_then_cut(
    desk: Desk, footprints: Footprints
) -> None:
    place(desk, 0.11)
    settle(footprints)
    free = known(desk)
    assert free is not None and desk.viewport.footprint_updates == 1
    show(desk, solid_body=desk.document.rig.vehicle)
    settle(footprints)
    cut = known(desk)
    assert cut is not None and desk.viewport.footprint_updates == 2
    wanted = footprint(desk.document.rig.sensor("front"), solid=car_of(desk.document.rig))
    for band, expected in zip(cut.bands, wanted.bands, strict=True):
        assert all(map(np.array_equal, band.patches, expected.patches))
    show(desk, selected="roof")
    settle(footprints)
    assert desk.viewport.footprint_updates == 2, "nothing that is drawn already is asked for"


def test_footprints_that_are_not_drawn_are_not_found(desk: Desk, footprints: Footprints) -> None:
    look = desk.viewport.state.ray_look
    show(desk, ray_look=replace(look, fill="none"))
    place(desk, 0.12)
    settle(footprints)
    assert known(desk) is None and desk.viewport.footprint_updates == 0
    show(desk, ray_look=look)
    settle(footprints)
    assert known(desk) is not None and desk.viewport.footprint_updates == 1
    limits = (77.0, 33.0)
    show(desk, ray_look=replace(look, px_per_m=limits), hidden=frozenset({"front"}))
    settle(footprints)
    assert known(desk) is None
    show(desk, hidden=frozenset())
    settle(footprints)
    assert known(desk) is not None


@pytest.mark.parametrize("end", ["counted", "not countable", "no scene", "edit"])
def test_at_the_start_they_wait_for_the_first_figures(desk: Desk, waiting: Footprints, end: str) -> None:
    limits = (61.0 + len(end), 31.0)
    show(desk, ray_look=replace(desk.viewport.state.ray_look, px_per_m=limits))
    settle(waiting)
    assert known(desk) is None
    if end == "counted":
        for is_whole in (False, True):
            settle(waiting)
            assert known(desk) is None
            desk.counter.answered.emit(None, SimpleNamespace(is_whole=is_whole))
            QCoreApplication.processEvents()
    elif end == "not countable":
        desk.counter.failed.emit("no boxes")
    elif end == "no scene":
        desk.recompute.load_ended.emit("cannot be read", None)
    else:
        place(desk, 0.16)
    QCoreApplication.processEvents()
    settle(waiting)
    assert known(desk) is not None


def test_in_a_drag_none_are_found_until_it_ends(desk: Desk, footprints: Footprints) -> None:
    desk.viewport.press("front")
    desk.viewport.drag_to("front", Pose((1.0, 0.13, 1.41)))
    settle(footprints)
    assert desk.document.rig.sensor("front").position == (1.0, 0.13, 1.41) and known(desk) is None
    desk.viewport.release("front")
    settle(footprints)
    assert known(desk) is not None


def test_what_is_not_wanted_any_more_is_given_up(desk: Desk) -> None:
    camera = Camera(name="c", position=(0.0, 0.14, 1.5), hfov_deg=60.0)
    request = FootprintsRequest((camera, camera.replace(position=(0.0, 0.15, 1.5))), (50.0,), None, ())
    asked = iter((False, True))
    context = Context[None](lambda: next(asked), lambda: False, lambda _: None, lambda _: None)
    with pytest.raises(Cancelled):
        find_footprints(request, context)
    found = [FOOTPRINTS.known(sensor, request.px_per_m, None) for sensor in request.sensors]
    assert found[0] is not None and found[1] is None
