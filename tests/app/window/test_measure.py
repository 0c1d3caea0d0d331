"""The measuring tool: two clicks, a line that follows its sensors, and an end with Escape."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from pytestqt.qtbot import QtBot

from riglens.widgets.viewport.measured import GROUND, Measured, Place, measured_lines
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import RIG

ROOF, FRONT = (Place(sensor.position, sensor.name, sensor.name) for sensor in RIG.sensors)
FLOOR = Place((1.1, 0.2, 0.0), GROUND)


@pytest.fixture
def desk(qtbot: QtBot) -> Iterator[FullDesk]:
    with full_desk(qtbot) as made:
        yield made


def click(desk: FullDesk, *places: Place | None) -> None:
    for place in places:
        desk.viewport.place_picked.emit(place)


def test_two_clicks_measure_the_third_begins_anew_and_escape_ends_all(desk: FullDesk) -> None:
    desk.act("measure")
    assert desk.viewport.told[-1] == ("measure", True)
    click(desk, ROOF)
    assert desk.viewport.state.measured == Measured(ROOF)
    click(desk, None)
    assert desk.viewport.state.measured == Measured(ROOF)
    click(desk, FLOOR)
    assert desk.viewport.state.measured == Measured(ROOF, FLOOR)
    assert "2.147 m · dx +1.000  dy 0.000  dz \u22121.900 m" in desk.workbench.status.currentMessage()
    click(desk, FRONT)
    assert desk.viewport.state.measured == Measured(FRONT)
    desk.viewport.escaped.emit()
    assert desk.viewport.state.measured is None and not desk.workbench.actions["measure"].isChecked()
    assert desk.viewport.told[-1] == ("measure", False) and desk.workbench.status.currentMessage() == ""
    desk.viewport.escaped.emit()
    assert desk.viewport.told[-1] == ("measure", False)


def test_the_line_follows_a_sensor_that_is_dragged_and_goes_with_one_that_is_deleted(desk: FullDesk) -> None:
    desk.act("measure")
    click(desk, ROOF, FLOOR)
    desk.drag("roof", (1.1, 0.2, 2.5))
    found = desk.viewport.state.measured
    assert found is not None and found.distance_m == pytest.approx(2.5) and found.second == FLOOR
    desk.document.undo()
    assert desk.viewport.state.measured == Measured(ROOF, FLOOR)
    desk.document.delete(("front",))
    assert desk.viewport.state.measured == Measured(ROOF, FLOOR)
    desk.document.delete(("roof",))
    assert desk.viewport.state.measured is None and desk.workbench.actions["measure"].isChecked()


def test_one_tool_takes_the_clicks_and_another_rig_ends_it(desk: FullDesk) -> None:
    desk.act("pick")
    desk.act("measure")
    assert not desk.workbench.actions["pick"].isChecked()
    click(desk, ROOF)
    desk.act("pick")
    assert not desk.workbench.actions["measure"].isChecked() and desk.viewport.state.measured is None
    desk.act("measure")
    click(desk, ROOF)
    desk.document.show(RIG)
    assert desk.viewport.state.measured is None and not desk.workbench.actions["measure"].isChecked()


def test_what_is_said_has_units_signs_and_heights() -> None:
    found = Measured(ROOF, FLOOR)
    assert measured_lines(found) == (
        "2.147 m",
        "dx +1.000  dy 0.000  dz \u22121.900 m",
        "roof to ground: 1.900 and 0.000 m above the ground",
    )
    assert measured_lines(Measured(ROOF))[1] == "click the second point"
