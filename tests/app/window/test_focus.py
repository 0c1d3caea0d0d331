"""The keyboard alone: Tab and Shift+Tab reach every field that can be seen, in reading order, and nothing unseen.

A pose is read by columns: its position, then its rotation.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDockWidget, QWidget
from pytestqt.qtbot import QtBot

from riglens.app.window.docks import is_in_sight
from tests.app.window_bench import Bench, open_bench
from tests.waiting import wait_for

MOST = 120


@pytest.fixture
def bench(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(qtbot, tmp_path, data=False) as opened:
        opened.document.select("front")
        yield opened


def walked(start: QWidget, key: Qt.Key) -> list[QWidget]:
    """What has the focus one after the other until it is at the start again."""
    start.setFocus(Qt.FocusReason.TabFocusReason)
    found = []
    while (focus := QApplication.focusWidget()) is not None and len(found) < MOST:
        found.append(focus)
        QTest.keyClick(focus, key)
        if QApplication.focusWidget() is start:
            return found
    pytest.fail(f"Tab does not come back to its start: {[w.objectName() for w in found]}")


def dock_of(widget: QWidget) -> QDockWidget | None:
    parent: QWidget | None = widget
    while parent is not None and not isinstance(parent, QDockWidget):
        parent = parent.parentWidget()
    return parent


def test_tab_goes_around_all_that_can_be_seen(bench: Bench) -> None:
    found = walked(bench.panels.tree, Qt.Key.Key_Tab)
    docks = {dock.objectName() for widget in found if (dock := dock_of(widget)) is not None}
    assert docks == {"Sensors", "Inspector", "Scores", "Library"}  # Scene, Map, ... are behind other tabs
    assert bench.find("x") in found and bench.find("range_m.to") in found


def test_shift_tab_goes_the_same_way_back(bench: Bench) -> None:
    there = walked(bench.panels.tree, Qt.Key.Key_Tab)
    back = walked(bench.panels.tree, Qt.Key.Key_Backtab)
    assert there[1:] == back[:0:-1]


def test_fields_of_the_inspector_follow_each_other_as_they_are_read(bench: Bench) -> None:
    form = bench.panels.inspector.form
    found = [w for w in walked(bench.panels.tree, Qt.Key.Key_Tab) if form.isAncestorOf(w)]
    places = [field.mapTo(form, QPoint(0, field.height() // 2)) for field in found]
    lines = [(round(place.y() / 20), place.x()) for place in places]
    names = [field.objectName() for field in found]
    first = names.index("x")
    assert names[first : first + 6] == ["x", "y", "z", "roll", "pitch", "yaw"]
    assert len(found) > 15
    for part in (lines[: first + 3], lines[first + 3 : first + 6], lines[first + 6 :]):
        assert part == sorted(part)
    assert max(lines[:first]) < lines[first] and lines[first + 5] < min(lines[first + 6 :])


def test_tab_does_not_end_in_a_table(bench: Bench) -> None:
    bench.act("snapshot")
    wait_for(lambda: is_in_sight(bench.workbench.docks["Compare"]))  # it comes to the front
    found = walked(bench.panels.tree, Qt.Key.Key_Tab)
    assert "Compare" in {dock.objectName() for w in found if (dock := dock_of(w)) is not None}
