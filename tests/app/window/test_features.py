"""Features of the window one by one, on a desk without the window: each test takes milliseconds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PySide6.QtWidgets import QLineEdit
from pytestqt.qtbot import QtBot

from riglens.app.session.session import HeatChoice
from riglens.app.window.features.appearance import Theme, Units
from riglens.app.window.features.car import Car
from riglens.app.window.features.edits import Edits
from riglens.app.window.features.files import Files
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.frame import FrameView
from riglens.app.window.features.heat import Heat
from riglens.app.window.features.maps import Map
from riglens.app.window.features.pick import Pick
from riglens.app.window.features.scores import BUSY, ScoresShown
from riglens.app.window.features.sensors import Placing, Sensors
from riglens.app.window.features.targets import Targets
from riglens.app.window.settings import Settings
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.widgets.drawing.camera import ViewRay
from riglens.widgets.heatmap.pick import PickedCell
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.panels.controls.messages import ProgressStrip
from riglens.widgets.panels.fields.quantity import DEGREES, MILLIMETRES
from riglens.widgets.panels.scores.table import FOLLOWS, ScoreTable
from riglens.widgets.theme import DARK, LIGHT
from tests.app.window.desk import GRID, Desk, heatmap, open_desk
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


# ---------------------------------------------------------------------- heat
def test_the_choice_of_the_heatmap_is_the_sessions(desk: Desk) -> None:
    Heat(desk.workbench)
    desk.act("heat_unseen")
    desk.act("next_class")
    assert desk.session.heat == HeatChoice("unseen", "bicycle")
    desk.session.set_heat(HeatChoice("off", "pedestrian"))
    assert desk.workbench.actions["heat_off"].isChecked()
    assert desk.workbench.actions["class_pedestrian"].isChecked()


def test_the_view_shows_the_heatmap_of_the_answer_in_the_look_of_the_sliders(desk: Desk) -> None:
    heat = Heat(asking(desk).workbench)
    data = heatmap("POG probability, car")
    desk.answer(heatmap=data)
    assert desk.viewport.state.heatmap is data
    heat.panel.set_look(HeatLook(0.5, True, 0.8))
    assert desk.viewport.state.heat_look == HeatLook(0.5, True, 0.8)


def test_the_choice_of_the_heatmap_is_kept_and_nonsense_is_not_taken_up(desk: Desk) -> None:
    heat, kept = Heat(desk.workbench), Settings()
    desk.session.set_heat(HeatChoice("entropy", "bicycle"))
    heat.keep(kept)
    desk.session.set_heat(HeatChoice())
    heat.restore(kept)
    assert desk.session.heat == HeatChoice("entropy", "bicycle")
    kept.write("heat/mode", "thermal")
    kept.write("heat/class", "unicorn")
    heat.restore(kept)
    assert desk.session.heat == HeatChoice("entropy", "bicycle")


# ---------------------------------------------------------------------- baseline, scores, marginals, compare
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
    assert hidden == ["Cameras S-MIG, 10³ nat", "change", "LiDARs S-MIG, 10³ nat", "change"]
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
def cell(x_m: float, y_m: float, z_m: float) -> PickedCell:
    """A cell of the heatmap that is clicked from above."""
    centre = np.array([x_m, y_m, z_m])
    return PickedCell(0, centre, 0.5, ViewRay(centre + np.array([0.0, 0.0, 9.0]), np.array([0.0, 0.0, -1.0])))


def test_a_picked_voxel_is_marked_and_forgotten_with_escape(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("riglens.core.metric.voxel.voxel_in_cell", lambda *_: (20, 20, 1))
    Pick(desk.workbench, FrameView(desk.workbench, Targets(desk.workbench)))
    desk.viewport.cell_picked.emit(cell(0.25, 0.25, 0.75))
    assert desk.session.voxel is None  # there is no traffic yet
    desk.load()
    desk.viewport.cell_picked.emit(cell(0.25, 0.25, 0.75))
    marker = desk.viewport.state.marker
    assert desk.session.voxel == (20, 20, 1) and marker is not None and marker.edge_m == GRID.voxel_m
    desk.viewport.escaped.emit()
    assert desk.session.voxel is None and desk.viewport.state.marker is None


def test_the_map_asks_only_while_somebody_looks(desk: Desk) -> None:
    map_ = Map(desk.workbench)
    told: list[Any] = []
    desk.session.asked_changed.connect(lambda: told.append(desk.session.request().map_by))
    map_.panel.shown_chosen.emit()
    assert told == []
    _set_in_sight(map_, True)
    map_.panel.choice.setCurrentIndex(1)
    map_.panel.shown_chosen.emit()
    _set_in_sight(map_, False)
    assert told == ["any", "lidar"] and desk.session.request().map_by is None


def test_a_map_out_of_sight_does_not_hear_of_edits(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    map_ = Map(desk.workbench)
    heard: list[Any] = []
    monkeypatch.setattr(map_.panel.map, "set_rig", lambda rig, *_: heard.append(rig))
    desk.document.set_enabled(("roof",), False)
    assert heard == []
    _set_in_sight(map_, True)
    desk.document.set_enabled(("roof",), True)
    assert [rig.sensor("roof").enabled for rig in heard] == [False, True]
    _set_in_sight(map_, False)
    desk.document.set_enabled(("roof",), False)
    assert len(heard) == 2


def _set_in_sight(map_: Map, is_seen: bool) -> None:
    """Say that the dock came into sight, as Qt would have it found out."""
    map_.in_sight._is_seen = is_seen
    map_.in_sight.changed.emit(is_seen)


# ---------------------------------------------------------------------- the rig
def test_view_list_and_inspector_follow_the_document_and_are_told_once(desk: Desk) -> None:
    Follow(desk.workbench).show_all()
    shown = len(desk.viewport.states)
    desk.document.select("roof")
    desk.document.begin_drag(("roof",))
    desk.document.preview({"roof": POSE})
    assert desk.viewport.state.rig.sensor("roof").pose == POSE and desk.viewport.state.selected == "roof"
    desk.document.finish_drag()
    desk.document.undo()
    assert desk.viewport.state.rig == RIG
    assert (
        len(desk.viewport.states) == shown + 3
    )  # selected, moved, put back: the drag's end shows nothing new


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


def test_what_is_done_to_sensors_depends_on_selection_and_locks(desk: Desk) -> None:
    Follow(desk.workbench).show_all()
    Sensors(desk.workbench)
    Placing(desk.workbench)
    assert not any(desk.is_enabled(key) for key in ("delete", "rename", "place"))
    desk.panels.tree.choose(("roof",))
    assert all(desk.is_enabled(key) for key in ("delete", "rename", "place"))
    desk.act("hide")
    assert desk.document.hidden == {"roof"} and not desk.is_enabled("place")
    desk.act("lock")
    assert desk.document.locked == {"roof"} and not desk.is_enabled("rename")
    desk.act("delete")
    assert "roof: locked" in desk.workbench.errors.message and desk.document.rig.sensor("roof")


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


def test_a_chosen_theme_is_told_once_and_kept(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    styled: list[bool] = []
    monkeypatch.setattr(
        "riglens.app.window.features.appearance.apply_style", lambda app, dark: styled.append(dark)
    )
    theme = Theme(desk.workbench, Follow(desk.workbench))
    theme._shown = False
    told: list[bool] = []
    desk.workbench.theme_changed.connect(told.append)
    for key in ("theme_dark", "theme_dark", "theme_light"):
        desk.act(key)
    assert told == styled == [True, False]
    assert [palette for (palette,) in desk.viewport.values("palette")][-2:] == [DARK, LIGHT]
    kept = Settings()
    theme.keep(kept)
    assert kept.read("theme", "") == "theme_light"
