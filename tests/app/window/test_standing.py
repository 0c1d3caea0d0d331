"""Sensors off the body, inside it or in the ground are marked everywhere, and follow a drag."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from PySide6.QtCore import QCoreApplication
from pytestqt.qtbot import QtBot

from riglens.app.background.standing import StandFinder, StandRequest
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.standing import Standing
from riglens.core.rig.model import Rig
from riglens.core.vehicle.solid import CarBody
from riglens.core.vehicle.standing import stand
from riglens.widgets.panels.sensors.rows import NAME, PROBLEM
from tests.app.window.desk import Desk, open_desk
from tests.waiting import TIMEOUT_S

ON_ROOF, CABIN, GROUND = (0.1, 0.0, 1.5), (0.0, 0.0, 0.9), (3.0, 0.0, -0.2)


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    made = open_desk(qtbot)
    made.workbench.answers.ask()
    return made


@pytest.fixture
def standing(desk: Desk) -> Iterator[Standing]:
    Follow(desk.workbench).show_all()
    made = Standing(desk.workbench, StandFinder(close_s=TIMEOUT_S))
    yield made
    made.finder.close()


def settle(standing: Standing) -> None:
    assert standing.finder.wait_until_idle(TIMEOUT_S)
    QCoreApplication.processEvents()


def start(desk: Desk, standing: Standing) -> None:
    desk.load()
    desk.answer()
    settle(standing)


def marked(desk: Desk) -> dict[str, str]:
    tree, rig = desk.panels.tree, desk.document.rig
    found = {sensor.name: tree.item_of(sensor.name).data(NAME, PROBLEM) for sensor in rig.sensors}
    return {name: problem for name, problem in found.items() if problem}


def test_nothing_is_said_before_the_first_scores(desk: Desk, standing: Standing) -> None:
    desk.load()
    settle(standing)
    assert marked(desk) == {} and desk.viewport.state.masts == ()


def test_a_sensor_in_the_air_is_marked_in_list_view_and_inspector(desk: Desk, standing: Standing) -> None:
    start(desk, standing)
    rig = desk.document.rig
    problem = stand(rig.sensor("roof").position, CarBody(rig.vehicle).solid()).problem
    assert "above the body: needs a bracket" in problem and marked(desk)["roof"] == problem
    assert problem.capitalize() in desk.panels.tree.item_of("roof").toolTip(NAME)
    mast = next(mast for mast in desk.viewport.state.masts if mast.name == "roof")
    assert mast.full == problem and mast.foot_m[2] == pytest.approx(1.41, abs=0.02)
    assert "to be held by brackets" in desk.panels.inspector._rig_form.places
    desk.document.select("roof")
    assert desk.panels.inspector._lidar_form.place == problem


@pytest.mark.parametrize(
    ("place", "said", "short"),
    [(CABIN, "inside the body", "inside"), (GROUND, "below the ground", "0.20 m deep")],
)
def test_a_sensor_inside_or_in_the_ground_is_seen_through_both(
    desk: Desk, standing: Standing, place: tuple[float, float, float], said: str, short: str
) -> None:
    start(desk, standing)
    desk.drag("roof", place)
    settle(standing)
    mast = next(mast for mast in desk.viewport.state.masts if mast.name == "roof")
    assert marked(desk)["roof"] == said and mast.is_buried and mast.short == short
    assert f"roof: {said}" in desk.panels.inspector._rig_form.places


def test_the_mark_follows_the_drag_and_goes_on_the_roof(desk: Desk, standing: Standing) -> None:
    start(desk, standing)
    desk.viewport.press("roof")
    desk.drag("roof", ON_ROOF)
    settle(standing)
    assert "roof" not in marked(desk)
    assert "roof" not in [mast.name for mast in desk.viewport.state.masts]


def test_a_body_that_was_not_read_says_nothing(desk: Desk, standing: Standing) -> None:
    start(desk, standing)
    assert marked(desk)
    rig = desk.document.rig
    desk.document.apply(rig.replace(vehicle=rig.vehicle.replace(body="car.ply")))
    settle(standing)
    assert marked(desk) == {} and desk.viewport.state.masts == ()


def test_only_what_moved_is_found_anew(standing: Standing, monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[object] = []

    def counted(place_m, solid):
        found.append(place_m)
        return stand(place_m, solid)

    monkeypatch.setattr("riglens.app.background.standing.stand", counted)
    body, still = CarBody(Rig().vehicle), ("a", (0.0, 0.0, 2.0))
    for x in (0.1, 0.2):
        standing.finder.ask(StandRequest(body, (still, ("b", (x, 0.0, 2.0)))))
        settle(standing)
    assert found == [(0.0, 0.0, 2.0), (0.1, 0.0, 2.0), (0.2, 0.0, 2.0)]
