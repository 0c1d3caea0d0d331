"""A window comes back as it was left, whatever stands in the settings file; the user's own file is never touched."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QSettings, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.app.session.session import HeatChoice
from riglens.app.window.features.sensors import LOCKED_KEY, MOST_FILES
from riglens.app.window.settings import Settings
from riglens.core.user_folders import config_folder, state_folder
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.panels.controls.style import apply_style, shows_dark
from riglens.widgets.theme import DARK, LIGHT
from tests.app.window.desk import FullDesk
from tests.app.window_bench import open_bench

KEYS = (
    "window/geometry", "window/state", "theme", "heat/mode", "heat/class", "rays/look", "gizmo/mode", "gizmo/local",
    "gizmo/snap", "view/camera", "files/recent", "sensors/locked", "compare/bars",
)  # fmt: skip
JUNK = ('"junk"', "[1, null]", '{"focal_m": [1e400, 0, 0]}', "12", "true", "{", '"\ufffd"', "[" * 5000)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "window.ini"


def test_what_was_chosen_is_there_again_the_next_time(qtbot: QtBot, tmp_path: Path, file: Path) -> None:
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        heat = bench.features.heat
        heat.set_mode("entropy")
        heat.set_class("bicycle")
        bench.act("rotate")
        bench.act("local")
        bench.act("snap")
        camera = OrbitCamera((1.0, 2.0, 3.0), 25.0, 30.0, 40.0, True)
        bench.viewport.show_state(replace(bench.viewport.state, camera=camera))
        bench.workbench.docks["Scene"].hide()
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        assert bench.session.heat == HeatChoice("entropy", "bicycle")
        assert bench.workbench.actions["rotate"].isChecked() and bench.workbench.actions["local"].isChecked()
        assert (bench.viewport.state.gizmo_mode, bench.viewport.state.gizmo_space) == ("rotate", "local")
        assert bench.workbench.actions["snap"].isChecked() and bench.viewport.state.snap
        assert bench.viewport.state.camera == OrbitCamera((1.0, 2.0, 3.0), 25.0, 30.0, 40.0, True)
        assert bench.workbench.docks["Scene"].isHidden()


def test_locks_come_back_with_the_file_that_they_belong_to(qtbot: QtBot, tmp_path: Path, file: Path) -> None:
    mine, other = tmp_path / "mine.yaml", tmp_path / "other.yaml"
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        bench.document.save(mine)
        bench.document.select("roof")
        bench.act("lock")
        assert bench.document.locked == {"roof"}
        bench.document.save(other)
        bench.act("lock")
        assert not bench.document.locked
        bench.document.open(mine)
        assert bench.document.locked == {"roof"}
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        assert not bench.document.locked
        bench.document.open(other)
        assert not bench.document.locked
        bench.document.open(mine)
        assert bench.document.locked == {"roof"}


def test_locks_of_many_files_do_not_pile_up(qtbot: QtBot, tmp_path: Path, file: Path) -> None:
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        bench.workbench.kept.write(
            LOCKED_KEY, {f"/rigs/{number}.yaml": ["roof"] for number in range(MOST_FILES)}
        )
        bench.document.save(tmp_path / "rig.yaml")
        bench.document.set_locked(("front",), True)
        kept = bench.workbench.kept.read(LOCKED_KEY, {})
        assert len(kept) == MOST_FILES and kept[str(tmp_path / "rig.yaml")] == ["front"]


def test_reset_layout_brings_back_what_was_closed(qtbot: QtBot, tmp_path: Path, file: Path) -> None:
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        for dock in bench.workbench.docks:
            dock.hide()
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        assert all(dock.isHidden() for dock in bench.workbench.docks)
        bench.act("reset_layout")
        assert not any(dock.isHidden() for dock in bench.workbench.docks)


def junk_in(file: Path, junk: str) -> Settings:
    store = QSettings(str(file), QSettings.Format.IniFormat)
    for key in KEYS:
        store.setValue(key, junk)
    store.sync()
    return Settings(file)


def test_junk_in_the_settings_is_not_taken_up(bench: FullDesk, file: Path) -> None:
    for junk in JUNK:
        for feature in bench.features:
            feature.restore(junk_in(file, junk))
        assert bench.workbench.actions["both"].isChecked(), junk
        assert bench.viewport.chosen_camera() is None, junk


def test_a_window_opens_with_junk_for_its_geometry(qtbot: QtBot, tmp_path: Path, file: Path) -> None:
    with open_bench(qtbot, tmp_path, kept=junk_in(file, JUNK[0]), data=False) as bench:
        assert bench.window.isVisible()


@pytest.mark.parametrize("content", [b"\x00\xff" * 500, b"[window]\nstate=@Variant(\x00\x00", b"=\n[[[\n"])
def test_a_broken_settings_file_is_like_none(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    settings = Settings(file)
    assert settings.read("heat/class", "car") == "car" and settings.read_bytes("window/state").isEmpty()
    settings.write("heat/class", "pedestrian")
    settings.sync()
    assert Settings(file).read("heat/class", "") == "pedestrian"


def test_a_value_of_another_type_gives_the_default() -> None:
    settings = Settings()
    settings.write("key", ["a"])
    assert settings.read("key", "default") == "default"
    assert settings.read("key", False) is False
    assert settings.read("key", []) == ["a"]
    assert settings.read_bytes("key").isEmpty()


def test_tests_keep_away_from_the_settings_of_the_user() -> None:
    assert "riglens-tests-" in str(config_folder()) and "riglens-tests-" in str(state_folder())


def test_a_forced_theme_is_everywhere_at_once_and_kept(
    qtbot: QtBot, tmp_path: Path, file: Path, plain_style: None
) -> None:
    told: list[bool] = []
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        bench.workbench.theme_changed.connect(told.append)
        bench.act("theme_dark")
        assert shows_dark()
        assert bench.viewport.state.palette == DARK
        assert told == [True]
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        assert bench.features.theme.choice == "theme_dark"
        assert shows_dark()


def test_the_theme_follows_the_system_while_the_window_is_open(
    qtbot: QtBot, tmp_path: Path, plain_style: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    with open_bench(qtbot, tmp_path, data=False) as bench:
        apply_style(_app(), dark=False)
        monkeypatch.setattr("riglens.app.window.features.appearance.is_dark", lambda: True)
        QGuiApplication.styleHints().colorSchemeChanged.emit(Qt.ColorScheme.Dark)
        assert shows_dark()
        assert bench.viewport.state.palette == DARK
        bench.act("theme_light")
        QGuiApplication.styleHints().colorSchemeChanged.emit(Qt.ColorScheme.Dark)
        assert not shows_dark()
        assert bench.viewport.state.palette == LIGHT


def _app() -> QApplication:
    app = QApplication.instance()
    assert isinstance(app, QApplication)
    return app
