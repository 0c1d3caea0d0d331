"""New, recent files, and files dropped on the window: each asks before it loses changes."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.app.window.settings import Settings
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import new_rig_file
from tests.app.window.desk import FullDesk
from tests.app.window_bench import BOXES, RIG, Bench, open_bench
from tests.waiting import TIMEOUT_MS

OTHER = Rig(name="other")


@pytest.fixture
def other(tmp_path: Path) -> Path:
    path = tmp_path / "other.yaml"
    path.write_text(new_rig_file(OTHER).text, encoding="utf-8")
    return path


def drop(bench: FullDesk, *paths: Path) -> bool:
    """Drag files over the window and let go; whether the window wanted them."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    copy, left, none = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    enter = QDragEnterEvent(QPoint(5, 5), copy, data, left, none)
    QApplication.sendEvent(bench.workbench.window, enter)
    if enter.isAccepted():
        QApplication.sendEvent(bench.workbench.window, QDropEvent(QPointF(5, 5), copy, data, left, none))
        QApplication.processEvents()
    return enter.isAccepted()


def test_new_starts_with_a_car_without_sensors(bench: FullDesk) -> None:
    bench.act("new")
    assert bench.document.rig.sensors == () and bench.document.path is None
    assert not bench.document.is_modified


def test_a_dropped_rig_is_opened(bench: FullDesk, other: Path) -> None:
    assert drop(bench, other)
    assert (bench.document.rig, bench.document.path) == (OTHER, other)


def test_a_dropped_mesh_becomes_the_body(bench: FullDesk, tmp_path: Path) -> None:
    mesh = tmp_path / "car.obj"
    mesh.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", encoding="utf-8"
    )
    assert drop(bench, mesh)
    assert bench.document.rig.vehicle.body == mesh.as_posix()
    bench.qtbot.waitUntil(lambda: bench.viewport.state.vehicle.body_mesh is not None, timeout=TIMEOUT_MS)
    bench.act("undo")
    assert bench.document.rig == RIG


@pytest.mark.parametrize("way", ["new", "drop", "recent"])
def test_unsaved_changes_are_asked_for(bench: FullDesk, other: Path, way: str) -> None:
    bench.document.rename("roof", "top")
    bench.workbench.kept.write("files/recent", [str(other)])
    changed = bench.document.rig
    if way == "new":
        bench.act("new")
    elif way == "drop":
        drop(bench, other)
    else:
        entries(bench)[0].trigger()
    assert bench.dialogs.asked == 1
    assert bench.document.rig == changed


def test_dropped_boxes_are_loaded(whole: Bench, tmp_path: Path) -> None:
    path = tmp_path / "more.csv"
    path.write_text(BOXES + "s,3,car,4,4,0.8,4.5,1.9,1.6,0\n", encoding="utf-8")
    assert drop(whole, path)
    whole.qtbot.waitUntil(lambda: "more.csv" in whole.workbench.status.scene.text(), timeout=TIMEOUT_MS)


def test_a_folder_that_holds_no_boxes_is_told(whole: Bench, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    drop(whole, tmp_path / "empty")
    whole.qtbot.waitUntil(lambda: "empty" in whole.workbench.errors.message, timeout=TIMEOUT_MS)
    whole.settle()


def test_a_file_of_another_kind_is_refused_with_what_is_accepted(bench: FullDesk, tmp_path: Path) -> None:
    drop(bench, tmp_path / "holiday.jpeg")
    assert "holiday.jpeg" in bench.workbench.errors.message
    assert ".yaml" in bench.workbench.errors.message
    assert bench.document.rig == RIG


def test_text_dragged_from_elsewhere_is_not_wanted(bench: FullDesk) -> None:
    assert not drop(bench)


def entries(bench: FullDesk) -> list:  # type: ignore[type-arg]
    recent = bench.features.recent
    recent.fill()
    return [action for action in recent.menu.actions() if not action.isSeparator()]


def test_opened_and_saved_files_are_recent_the_last_one_first(
    bench: FullDesk, other: Path, tmp_path: Path
) -> None:
    drop(bench, other)
    bench.dialogs.path = tmp_path / "copy.yaml"
    bench.act("save_as")
    drop(bench, other)
    assert bench.features.recent.paths == [other, tmp_path / "copy.yaml"]
    entries(bench)[1].trigger()
    assert bench.document.path == tmp_path / "copy.yaml"


def test_recent_files_are_kept_and_a_missing_one_is_greyed(qtbot: QtBot, tmp_path: Path, other: Path) -> None:
    file = tmp_path / "window.ini"
    with open_bench(qtbot, tmp_path, kept=Settings(file), wait=False) as bench:
        drop(bench, other)
    other.unlink()
    with open_bench(qtbot, tmp_path, kept=Settings(file), wait=False) as bench:
        first, clear = entries(bench)
        assert "other.yaml" in first.text() and not first.isEnabled()
        clear.trigger()
        assert bench.features.recent.paths == []
    assert Settings(file).read("files/recent", ["?"]) == []
