"""What the window keeps is on the disk soon after it changed, however the program ends; it fits on small screens."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QByteArray, QPropertyAnimation, QSize, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.app.window.features.appearance import FRAME, fitting_size
from riglens.app.window.keeping import DELAY_MS, Keeping
from riglens.app.window.settings import Settings
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import open_bench
from tests.hand_clock import HandTimers
from tests.waiting import wait_for

SMALL = QSize(960, 540)
"""A screen of 1920 x 1080 pixels with QT_SCALE_FACTOR=2."""


@pytest.fixture
def timers() -> HandTimers:
    return HandTimers()


@pytest.fixture
def desk(qtbot: QtBot, tmp_path: Path, timers: HandTimers) -> Iterator[FullDesk]:
    with full_desk(qtbot, kept=Settings(tmp_path / "window.ini")) as desk:
        Keeping(desk.workbench, desk.features, timers)
        yield desk


def on_disk(tmp_path: Path) -> Settings:
    """What another program finds in the file now."""
    return Settings(tmp_path / "window.ini")


def test_a_theme_that_was_chosen_is_on_the_disk_before_the_window_closes(
    desk: FullDesk, tmp_path: Path, timers: HandTimers, plain_style: None
) -> None:
    desk.act("theme_dark")
    assert on_disk(tmp_path).read("theme", "") == ""
    timers.advance(DELAY_MS)
    assert on_disk(tmp_path).read("theme", "") == "theme_dark"


def test_a_resized_window_and_a_closed_dock_are_on_the_disk_too(
    desk: FullDesk, tmp_path: Path, timers: HandTimers
) -> None:
    desk.workbench.window.show()
    timers.run_out()
    before = on_disk(tmp_path)
    geometry, state = before.read_bytes("window/geometry"), before.read_bytes("window/state")
    desk.workbench.window.resize(700, 500)
    desk.workbench.docks["Scores"].close()
    QApplication.processEvents()
    timers.advance(DELAY_MS)
    after = on_disk(tmp_path)
    assert QByteArray() != after.read_bytes("window/geometry") != geometry
    assert after.read_bytes("window/state") != state


def test_no_animation_of_a_dock_outlives_its_end(desk: FullDesk) -> None:
    """They used to pile up while docks were shown, hidden and resized."""
    window = desk.workbench.window
    window.show()
    docks = [desk.workbench.docks[name] for name in ("Scores", "Map", "Inspector", "Library", "Compare")]
    for step in range(8):
        dock = docks[step % len(docks)]
        dock.setVisible(not dock.isVisible())
        window.resize(900 + 10 * (step % 3), 700)
        QApplication.processEvents()
    wait_for(lambda: not window.findChildren(QPropertyAnimation))


def test_what_is_as_it_was_is_not_written_again(desk: FullDesk, tmp_path: Path, timers: HandTimers) -> None:
    desk.act("theme_light")
    timers.run_out()
    (tmp_path / "window.ini").write_text("", encoding="utf-8")
    desk.act("theme_light")
    timers.run_out()
    assert (tmp_path / "window.ini").read_text(encoding="utf-8") == ""


def test_a_maximised_window_stays_so_when_the_layout_is_reset(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, data=False) as bench:
        bench.window.setWindowState(Qt.WindowState.WindowMaximized)
        for dock in bench.workbench.docks:
            dock.hide()
        bench.act("reset_layout")
        assert bench.window.isMaximized()
        assert not any(dock.isHidden() for dock in bench.workbench.docks)


def test_the_window_can_be_as_small_as_a_small_screen(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, data=False) as bench:
        least, room = bench.window.minimumSizeHint(), SMALL - FRAME
        assert least.width() <= room.width() and least.height() <= room.height(), least
        for name in ("Inspector", "Scene", "Map", "Sensor view", "Scores", "Compare", "Library"):
            bench.workbench.docks.bring_up(name)
        bench.window.resize(room)
        assert bench.window.size() == room
        for title in ("Reading prototype.glb", "Writing the report"):
            bench.workbench.status.add_strip(title).show()
        bench.workbench.status.scene.setText("δ 0.1 m · a data set with a name " + 20 * "as long as it gets ")
        QApplication.processEvents()
        assert bench.window.size() == room


def test_a_window_is_no_larger_than_its_screen() -> None:
    assert fitting_size(QSize(1280, 800), SMALL) == SMALL - FRAME
    assert fitting_size(QSize(1280, 800), QSize(2560, 1440)) == QSize(1280, 800)
