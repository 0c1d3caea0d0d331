"""Where the 3D view is looked at from: parallel rays, views with names, sensors far away; and what a click means."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QInputDialog
from pytestqt.qtbot import QtBot

from riglens.app.window.dialogs import Dialogs
from riglens.app.window.features.views import LONGEST_NAME, MOST_SAVED, SAVED_KEY
from riglens.app.window.settings import Settings
from riglens.core.figures.heatmaps import NO_WORDS, Marks
from riglens.core.scene.grid import VoxelGrid
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera, ViewRay
from riglens.widgets.heatmap.pick import PickedCell
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import CAMERA, LIDAR, RIG

SIZE = (800, 600)
AWAY = OrbitCamera((1.0, 2.0, 3.0), 25.0, 30.0, 40.0)


def look(bench: FullDesk, camera: OrbitCamera) -> None:
    bench.viewport.show_state(replace(bench.viewport.state, camera=camera))


def test_orthographic_by_choice_stays_while_the_view_is_turned(bench: FullDesk) -> None:
    look(bench, AWAY)
    bench.act("ortho")
    flat = bench.viewport.state.camera
    assert flat == replace(AWAY, parallel=True, orthographic=True)
    assert flat.orbited(40, 10, SIZE).parallel and flat.zoomed(0.5, (3.0, 4.0), SIZE).parallel
    bench.act("ortho")
    assert bench.viewport.state.camera == AWAY


def test_a_side_view_is_parallel_until_it_is_turned() -> None:
    side = replace(AWAY, parallel=True)
    assert not side.orbited(40, 10, SIZE).parallel


def save(bench: FullDesk, name: str | None) -> None:
    bench.dialogs.name = name
    bench.act("save_view")


def titles(bench: FullDesk) -> list[str]:
    menu = bench.features.saved_views.menu
    menu.aboutToShow.emit()
    return [action.text() for action in menu.actions() if action.text()]


def test_a_view_is_saved_recalled_by_its_name_replaced_and_deleted(bench: FullDesk) -> None:
    look(bench, AWAY)
    save(bench, " Left & low ")
    look(bench, OrbitCamera())
    assert titles(bench) == ["Save view…", "Left && low", "Delete"]
    next(a for a in bench.features.saved_views.menu.actions() if a.text() == "Left && low").trigger()
    assert bench.viewport.state.camera == AWAY
    look(bench, AWAY.projected(True))
    save(bench, "Left & low")
    look(bench, AWAY)
    bench.features.saved_views.recall("Left & low")
    assert bench.viewport.state.camera == AWAY.projected(True)
    assert bench.workbench.actions["ortho"].isChecked()
    bench.features.saved_views.forget("Left & low")
    assert titles(bench) == ["Save view…"]


def test_saved_views_come_back_in_the_next_session(qtbot: QtBot) -> None:
    kept = Settings()
    with full_desk(qtbot, kept=kept) as bench:
        look(bench, AWAY)
        save(bench, "away")
    with full_desk(qtbot, kept=kept) as bench:
        assert bench.features.saved_views.cameras == {"away": AWAY}


def test_no_name_saves_nothing(bench: FullDesk) -> None:
    for name in [None, "", "   "]:
        save(bench, name)
        assert bench.features.saved_views.cameras == {}


def test_names_and_number_of_saved_views_have_limits(bench: FullDesk) -> None:
    save(bench, "x" * 500)
    assert list(bench.features.saved_views.cameras) == ["x" * LONGEST_NAME]
    for number in range(MOST_SAVED):
        save(bench, str(number))
    assert len(bench.features.saved_views.cameras) == MOST_SAVED
    assert f"at most {MOST_SAVED}" in bench.workbench.errors.message


@pytest.mark.parametrize("junk", [{"a": 3}, {"a": {"focal_m": [1e400, 0, 0]}}, {"a": {}}])
def test_junk_in_the_settings_is_no_view(bench: FullDesk, junk: dict[str, Any]) -> None:
    kept = Settings()
    kept.write(SAVED_KEY, junk)
    bench.features.saved_views.restore(kept)
    assert bench.features.saved_views.cameras == {}


def test_frame_all_says_which_sensor_is_too_far_away_to_be_in_it(bench: FullDesk) -> None:
    far = CAMERA.replace(position=(4000.0, 3000.0, 1.0))
    bench.document.show(RIG.replace(sensors=(LIDAR, far)))
    for key in ("frame_all", "frame"):
        bench.workbench.status.clearMessage()
        bench.act(key)
        assert bench.viewport.told[-1] == ("frame",)
        assert "front, 5,000 m away" in bench.workbench.status.currentMessage(), key
    bench.document.select("front")
    bench.act("frame")
    assert bench.viewport.told[-1] == ("frame", "front")


def test_frame_all_has_nothing_to_say_when_all_are_near(bench: FullDesk) -> None:
    bench.act("frame_all")
    assert bench.workbench.status.currentMessage() == ""


def click_means(
    desk: FullDesk, monkeypatch: pytest.MonkeyPatch, mode: str, **fields: Any
) -> list[int] | None:
    """Words of the voxels that a click on the first cell may mean, None for any; `fields` are those of the answer."""
    asked: list[Any] = []
    monkeypatch.setattr("riglens.core.metric.voxel.voxel_in_cell", lambda *given: asked.append(given[-1]))
    desk.load()
    desk.features.heat.set_mode(mode)
    result = desk.result()
    desk.workbench.answers.take(replace(result, **fields))
    centre = np.array([0.25, 0.25, 0.75])
    down = ViewRay(centre + np.array([0.0, 0.0, 9.0]), np.array([0.0, 0.0, -1.0]))
    desk.viewport.cell_picked.emit(PickedCell(0, centre, 0.5, down))
    (words,) = asked
    return None if words is None else [int(word) for word in words]


def test_a_click_on_cells_of_data_that_are_no_longer_loaded_means_nothing(
    desk: FullDesk, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert click_means(desk, monkeypatch, "entropy") is None  # any voxel
    asked: list[Any] = []
    monkeypatch.setattr("riglens.core.metric.voxel.voxel_in_cell", lambda *given: asked.append(given))
    desk.load(VoxelGrid(1.0, (20.0, 20.0, 4.0)))
    centre = np.array([0.25, 0.25, 0.75])
    desk.viewport.cell_picked.emit(
        PickedCell(0, centre, 0.5, ViewRay(centre + 9.0, np.array([0.0, 0.0, -1.0])))
    )
    assert not asked and desk.session.voxel is None


@pytest.mark.parametrize(("mode", "meant"), [("unseen", [~1, ~2]), ("seen", [1, 2]), ("entropy", None)])
def test_a_click_means_a_voxel_of_the_kind_that_is_drawn(
    desk: FullDesk, monkeypatch: pytest.MonkeyPatch, mode: str, meant: list[int] | None
) -> None:
    wanted = meant if meant is None else [word % 2**64 for word in meant]
    marks = Marks(NO_WORDS if meant is None else np.array([1, 2], np.uint64))
    assert click_means(desk, monkeypatch, mode, marks=marks) == wanted


def test_a_click_on_redundancy_means_a_voxel_that_so_many_sensors_see(
    desk: FullDesk, monkeypatch: pytest.MonkeyPatch
) -> None:
    marks = Marks(np.array([2, 0], np.uint64))
    assert click_means(desk, monkeypatch, "twice", marks=marks) == [2, 0]


@pytest.mark.parametrize(("net", "meant"), [(3.0, [1, 0]), (-3.0, [0, 4])])
def test_a_click_on_a_change_means_a_voxel_that_is_gained_or_lost_as_its_cell_is(
    desk: FullDesk, monkeypatch: pytest.MonkeyPatch, net: float, meant: list[int]
) -> None:
    cells = HeatmapData(
        np.array([[0.25, 0.25, 0.75]], np.float32), 0.5, np.array([net], np.float32), "Gained and lost", "nat",
        0.0, 5.0, scale="change",
    )  # fmt: skip
    before = np.array([0, 6], np.uint64)  # voxel 65 was seen before, too, and 66 no longer is
    marks = Marks(np.array([1, 2], np.uint64), before)
    found = click_means(desk, monkeypatch, "change", heatmap=cells, marks=marks)
    assert found == meant


def test_the_question_for_a_name_suggests_a_new_one(bench: FullDesk) -> None:
    suggested: list[str] = []

    def answer() -> None:
        dialog = QApplication.activeModalWidget()
        assert isinstance(dialog, QInputDialog)
        suggested.append(dialog.textValue())
        dialog.setTextValue("low")
        dialog.accept()

    for known in ([], ["View 1", "a"]):
        QTimer.singleShot(0, answer)
        assert Dialogs().view_name(bench.workbench.window, known) == "low"
    assert suggested == ["View 1", "View 2"]
