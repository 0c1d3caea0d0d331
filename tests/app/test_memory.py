"""What was freed goes back to the system soon after work, but not in the middle of a drag."""

import linecache

from pytestqt.qtbot import QtBot

from riglens.app.background import memory
from tests.waiting import TIMEOUT_MS


def test_memory_goes_back_after_work_and_waits_for_the_end_of_a_drag(qtbot: QtBot, monkeypatch):
    given, is_dragging = [], [True, False]
    monkeypatch.setattr(memory, "trim", lambda: given.append(len(is_dragging)))
    freed = memory.FreedMemory(lambda: is_dragging.pop(0))
    freed._timer.setInterval(0)
    freed.note()
    freed.note()
    qtbot.waitUntil(lambda: bool(given), timeout=TIMEOUT_MS)
    assert given == [0] and not freed._timer.isActive()


def test_source_lines_that_imports_have_read_go_with_it():
    assert linecache.getlines(__file__) and __file__ in linecache.cache
    memory.trim()
    assert __file__ not in linecache.cache and linecache.getlines(__file__)
