"""When a view is drawn, and that others have a turn between the parts of a long picture."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest
from PySide6.QtCore import QObject, QTimer
from PySide6.QtTest import QTest

from riglens.widgets.viewport.redraw import Parts, Redraw

PARTS = 5


class View(QObject):
    """Notes what it is asked to draw; each part takes a turn."""

    def __init__(self) -> None:
        super().__init__()
        self.is_moving = False
        self.notes: list[str] = []
        self.redraw = Redraw(self, self.draw, self.draw_rested, lambda: not self.is_moving, rest_ms=30)

    def draw(self) -> None:
        self.notes.append("frame")

    def draw_rested(self) -> Parts:
        self.is_moving = False
        try:
            for part in range(PARTS):
                self.notes.append(f"part {part}")
                yield
            self.notes.append("whole")
        except GeneratorExit:
            self.notes.append("given up")
            raise

    def settle(self) -> None:
        while not self.redraw.is_at_rest:
            QTest.qWait(5)


WHOLE = [*(f"part {part}" for part in range(PARTS)), "whole"]


@pytest.fixture
def view(qapp) -> Iterator[View]:
    made = View()
    yield made
    made.redraw.stop()


def test_others_have_a_turn_between_the_parts(view: View) -> None:
    others = QTimer(view)
    others.timeout.connect(lambda: view.notes.append("other"))
    others.start(0)
    view.redraw.request()
    view.settle()
    others.stop()
    assert [note for note in view.notes if note != "other"] == WHOLE
    for first, second in itertools.pairwise(WHOLE):
        assert "other" in view.notes[view.notes.index(first) : view.notes.index(second)]


def test_a_change_in_between_waits_until_the_picture_is_whole_and_gets_its_own(view: View) -> None:
    view.redraw.request()
    QTest.qWait(0)
    while "part 1" not in view.notes:
        QTest.qWait(0)
    view.redraw.request()
    view.redraw.request()
    view.settle()
    assert view.notes == WHOLE + WHOLE


def test_motion_gives_up_the_parts_and_is_drawn_at_once(view: View) -> None:
    view.redraw.request()
    while "part 1" not in view.notes:
        QTest.qWait(0)
    view.is_moving = True
    view.redraw.request()
    view.settle()
    done = view.notes.index("given up")
    assert view.notes[:done] == WHOLE[:done] and done < PARTS
    assert view.notes[done + 1 :] == ["frame", *WHOLE]


def test_motion_is_drawn_frame_by_frame_and_once_in_full_when_it_rests(view: View) -> None:
    for _ in range(3):
        view.is_moving = True
        view.redraw.request()
        QTest.qWait(10)
    assert view.notes == ["frame"] * 3
    view.settle()
    assert view.notes == ["frame"] * 3 + WHOLE


def test_a_view_that_is_closed_between_two_parts_draws_no_more(view: View) -> None:
    view.redraw.request()
    while "part 1" not in view.notes:
        QTest.qWait(0)
    view.redraw.stop()
    view.redraw.request()
    QTest.qWait(60)
    assert view.notes[-1] == "given up" and view.redraw.is_at_rest
