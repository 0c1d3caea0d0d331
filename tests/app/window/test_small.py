"""A low window gives the view the room that the scores do not need."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtWidgets import QApplication, QCheckBox, QTabBar, QToolButton
from pytestqt.qtbot import QtBot

from riglens.app.window import main_window
from riglens.app.window.features import appearance
from riglens.app.window.features.appearance import COMPACT_PX, FRAME
from riglens.core.figures.figure import CLASSES_AND_ALL
from riglens.core.rig.presets import preset
from riglens.widgets.panels.controls.style import apply_style
from riglens.widgets.panels.figures.table import Cell
from riglens.widgets.panels.scores.table import LONGEST_CHANGES, LONGEST_VALUE
from riglens.widgets.panels.sensors.rows import NAME
from riglens.widgets.panels.sensors.tree import TICK_PX
from tests.app.window_bench import Bench, open_bench
from tests.waiting import TIMEOUT_MS


@pytest.fixture
def low(qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setattr(main_window, "DEFAULT_SIZE", QSize(1024, 600))
    with open_bench(qtbot, tmp_path, wait=False) as opened:
        yield opened


def test_scores_take_no_more_than_their_rows_in_a_low_window(low: Bench) -> None:
    scores, dock = low.panels.scores, low.workbench.docks["Scores"]
    details, below = (
        scores.findChild(QCheckBox, "paper_details"),
        scores.findChild(QToolButton, "figures_help"),
    )
    assert low.window.height() < COMPACT_PX and details is not None and below is not None
    needed_px = scores.minimumSizeHint().height()
    low.qtbot.waitUntil(lambda: scores.height() <= needed_px + 24, timeout=TIMEOUT_MS)
    assert details.isVisible() and not below.isVisible()
    place = details.mapTo(scores.table, details.rect().center())
    assert place.x() < scores.table.verticalHeader().width()
    assert place.y() < scores.table.horizontalHeader().height()
    low.window.resizeDocks([dock], [needed_px + 120], Qt.Orientation.Vertical)
    low.qtbot.waitUntil(below.isVisible, timeout=TIMEOUT_MS)


def test_the_car_and_the_selected_sensor_are_in_sight_in_a_small_window(low: Bench) -> None:
    low.window.resize(QSize(960, 540))
    low.document.select("front")
    tree, view = low.panels.tree, low.viewport
    low.qtbot.waitUntil(lambda: low.window.height() <= 560, timeout=TIMEOUT_MS)
    place = tree.visualItemRect(tree._items["front"])
    assert tree.viewport().rect().intersects(place) and not place.isEmpty()
    assert view.height() >= 180 and view.width() >= 300


def test_no_word_of_the_start_rig_is_cut_in_a_small_window(
    qtbot: QtBot, tmp_path: Path, qapp: QApplication, plain_style: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    apply_style(qapp, False)
    for module in (main_window, appearance):  # a screen of 1920 x 1080 at scale 2
        monkeypatch.setattr(module, "room_around", lambda _: QRect(QPoint(), QSize(960, 540) + FRAME))
    with open_bench(qtbot, tmp_path, rig=preset("nuScenes car"), wait=False) as opened:
        tree, table = opened.panels.tree, opened.panels.scores.table
        longest_px = max(
            tree.fontMetrics().horizontalAdvance(sensor.name) for sensor in opened.document.rig.sensors
        )
        qtbot.waitUntil(lambda: tree.columnWidth(NAME) >= longest_px + TICK_PX, timeout=TIMEOUT_MS)
        assert not table.horizontalScrollBar().isVisible(), "all changes of the four figures are in sight"
        counted = [table.place_of(one.key) for one in table.shown if one.needs == "objects"]
        longest = (Cell(LONGEST_VALUE), Cell(LONGEST_CHANGES[1]))
        table.figures.show_columns(
            {place + part: [longest[part]] * len(CLASSES_AND_ALL) for place in counted for part in (0, 1)}
        )
        for place in (first + part for first in counted for part in (0, 1)):
            assert table.sizeHintForColumn(place) <= table.columnWidth(place)
        titles = [table.figures.headerData(counted[0] + part, Qt.Orientation.Horizontal) for part in (0, 1)]
        shown = [table.figures.index(0, counted[0] + part).data() for part in (0, 1)]
        assert titles == ["Pred. AP, %", "change, pp"] and shown == ["100.0 ±10.0", "−10.0 ±10.0"]
        bars = [bar for bar in opened.window.findChildren(QTabBar) if bar.isVisible() and bar.count() > 2]
        assert len(bars) > 1
        for bar in bars:
            shown_px = sum(bar.tabRect(place).width() for place in range(bar.count()))
            assert shown_px <= bar.width() and all(
                bar.tabRect(place).width() > bar.fontMetrics().horizontalAdvance(bar.tabText(place))
                for place in range(bar.count())
            )
