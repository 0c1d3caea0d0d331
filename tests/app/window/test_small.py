"""A low window gives the view the room that the scores do not need."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QCheckBox, QToolButton
from pytestqt.qtbot import QtBot

from riglens.app.window import main_window
from riglens.app.window.features.appearance import COMPACT_PX
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
