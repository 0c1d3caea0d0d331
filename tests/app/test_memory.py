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


def test_lines_of_one_source_are_kept_and_those_of_others_read_again(monkeypatch):
    monkeypatch.setattr(linecache, "cache", {})
    memory.keep_one_source()
    for path in (__file__, memory.__file__, __file__):
        assert linecache.getlines(path) and list(linecache.cache) == [path]
