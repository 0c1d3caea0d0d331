"""Features of the window one by one, on a desk without the window: each test takes milliseconds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from PySide6.QtWidgets import QLineEdit
from pytestqt.qtbot import QtBot

from riglens.app.window.features.appearance import Units
from riglens.app.window.features.car import Car
from riglens.app.window.features.edits import Edits
from riglens.app.window.features.files import Files
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.scores import BUSY, ScoresShown
from riglens.app.window.settings import Settings
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.widgets.panels.controls.messages import ProgressStrip
from riglens.widgets.panels.fields.quantity import DEGREES, MILLIMETRES
from riglens.widgets.panels.scores.table import FOLLOWS, ScoreTable
from tests.app.window.desk import Desk, open_desk
from tests.app.window_bench import LIDAR, RIG
from tests.hand_clock import HandTimers

POSE = Pose((0.1, 0.2, 2.5), LIDAR.rpy_deg)


@pytest.fixture
def desk(qtbot: QtBot) -> Iterator[Desk]:
    made = open_desk(qtbot)
    yield made
    made.workbench.closing.emit()


def asking(desk: Desk) -> Desk:
    """The desk with traffic loaded and a first question asked."""
    desk.load()
    desk.workbench.answers.ask()
    return desk


# ---------------------------------------------------------------------- scores
def test_the_settings_that_the_user_wants_are_the_sessions_and_shown(desk: Desk) -> None:
    ScoresShown(desk.workbench)
    wanted = MetricSettings("exact", "residual", 0.5)
    desk.panels.scores.settings_wanted.emit(wanted)
    assert desk.session.settings == replace(wanted, body=None)
    assert "rises" in desk.panels.scores.note


def test_an_answer_that_takes_long_has_a_bar_and_no_figure_until_it_is_there(desk: Desk) -> None:
    timers = HandTimers()
    ScoresShown(asking(desk).workbench, timers)
    desk.answer(0.25)
    desk.document.set_enabled(("roof",), False)
    strip = next(
        each for each in desk.workbench.status.findChildren(ProgressStrip) if each.left.text() == BUSY
    )
    assert desk.panels.scores.table.cell("car", "seen").text == "25.00 %" and not strip.is_running
    timers.run_out()
    assert desk.panels.scores.table.cell("car", "seen").text == FOLLOWS and strip.is_running
    desk.answer(0.5)
    assert desk.panels.scores.table.cell("car", "seen").text == "50.00 %" and not strip.is_running
    desk.document.set_enabled(("roof",), True)
    desk.answer(0.25)
    timers.run_out()
    assert desk.panels.scores.table.cell("car", "seen").text == "25.00 %" and not strip.is_running


def test_paper_details_are_folded_until_wanted_and_kept(desk: Desk) -> None:
    shown, kept = ScoresShown(asking(desk).workbench), Settings()
    table, weight = (
        desk.panels.scores.findChild(ScoreTable),
        desk.panels.scores.findChild(QLineEdit, "camera_weight"),
    )
    assert table is not None and weight is not None
    titles = table.figures.column_titles
    hidden = [title for place, title in enumerate(titles) if table.isColumnHidden(place)]
    details = "Entropy seen", "Cameras S-MIG, 10³ nat", "LiDARs S-MIG, 10³ nat"
    assert hidden == [heading for title in details for heading in (title, "change")]
    assert weight.isHidden()
    desk.panels.scores.set_details(True)
    assert (
        not any(table.isColumnHidden(place) for place in range(table.figures.columnCount()))
        and not weight.isHidden()
    )
    shown.keep(kept)
    desk.panels.scores.set_details(False)
    shown.restore(kept)
    assert desk.panels.scores.has_details


# ---------------------------------------------------------------------- pick, map


# ---------------------------------------------------------------------- the rig
def test_in_a_drag_the_panels_show_at_a_limited_rate_where_the_view_is_at_once(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    timers, told = HandTimers(), []
    Follow(desk.workbench, timers).show_all()
    desk.document.select("roof")
    inspector = desk.panels.inspector
    monkeypatch.setattr(inspector, "set_rig", lambda rig, _: told.append(rig.sensor("roof").position[0]))
    desk.document.begin_drag(("roof",))
    for step in range(1, 6):
        pose = Pose((float(step), 0.0, 2.0))
        desk.document.preview({"roof": pose})
        assert desk.viewport.state.rig.sensor("roof").pose == pose
        timers.advance(30)  # a pause of 100 ms ends within the fourth step
    assert told == [1.0, 4.0]
    desk.document.finish_drag()
    assert told == [1.0, 4.0, 5.0]
    timers.run_out()
    assert told == [1.0, 4.0, 5.0]


def test_a_refused_edit_is_said_and_what_is_true_is_shown_again(desk: Desk) -> None:
    Follow(desk.workbench).show_all()
    desk.document.set_locked(("roof",), True)
    shown = len(desk.viewport.states)
    desk.panels.tree.enabled_toggled.emit(("roof",), False)
    assert "locked" in desk.workbench.errors.message and len(desk.viewport.states) == shown + 1
    assert desk.document.rig.sensor("roof").enabled


def test_the_car_is_shown_anew_only_when_it_is_another(desk: Desk) -> None:
    Car(desk.workbench)
    desk.document.set_enabled(("roof",), False)
    longer = RIG.vehicle.replace(length=5.5)
    desk.document.apply(desk.document.rig.replace(vehicle=longer))
    assert desk.viewport.values("vehicle")[-1] == (longer,)
    states = len(desk.viewport.states)
    desk.document.set_enabled(("roof",), True)
    assert len(desk.viewport.states) == states


def test_undo_says_what_it_takes_back_from_the_first_move_of_a_drag_on(desk: Desk) -> None:
    Edits(desk.workbench)
    assert not desk.is_enabled("undo")
    desk.document.begin_drag(("roof",))
    desk.document.preview({"roof": POSE})
    assert desk.is_enabled("undo") and desk.workbench.actions["undo"].text() == "Undo move roof"
    desk.document.finish_drag()
    desk.act("undo")
    assert not desk.is_enabled("undo") and desk.is_enabled("redo")


# ---------------------------------------------------------------------- files, traffic, looks
def test_the_title_has_a_star_from_the_first_move_on(desk: Desk) -> None:
    Files(desk.workbench)
    assert not desk.workbench.window.isWindowModified()
    desk.document.begin_drag(("roof",))
    desk.document.preview({"roof": POSE})
    assert desk.workbench.window.isWindowModified()
    desk.document.cancel_drag()
    assert not desk.workbench.window.isWindowModified()


def test_units_are_kept_and_those_unknown_are_left_out(desk: Desk) -> None:
    units, kept = Units(desk.workbench), Settings()
    kept.write("units", ["mm", "furlong", 7])
    units.restore(kept)
    assert desk.panels.inspector.units == (MILLIMETRES, DEGREES)
    units.keep(kept)
    assert kept.read("units", []) == ["mm", "°"]
