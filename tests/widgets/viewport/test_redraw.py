"""When a view is drawn, and that others have a turn between the parts of a long picture."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest
from PySide6.QtCore import QObject, QTimer

from riglens.widgets.timers import Timers, single_shot
from riglens.widgets.viewport.redraw import REST_MS, Parts, Redraw
from tests.hand_clock import HandTimers
from tests.waiting import TIMEOUT_MS

PARTS = 5


class View(QObject):
    """Notes what it is asked to draw; each part takes a turn."""

    def __init__(self, timers: Timers) -> None:
        super().__init__()
        self.is_moving = False
        self.notes: list[str] = []
        self.redraw = Redraw(self, self.draw, self.draw_rested, lambda: not self.is_moving, timers)

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


WHOLE = [*(f"part {part}" for part in range(PARTS)), "whole"]


@pytest.fixture
def timers() -> HandTimers:
    return HandTimers()


@pytest.fixture
def view(qapp, timers: HandTimers) -> Iterator[View]:
    made = View(timers)
    yield made
    made.redraw.stop()


def draw_until(view: View, timers: HandTimers, note: str) -> None:
    """Let the view draw until it has noted this."""
    while note not in view.notes:
        assert timers.run_next(), view.notes


def test_others_have_a_turn_between_the_parts(qtbot) -> None:
    view = View(single_shot)  # Qt's own timers: the turns are those of its event loop
    others = QTimer(view)
    others.timeout.connect(lambda: view.notes.append("other"))
    others.start(0)
    view.redraw.request()
    qtbot.waitUntil(lambda: view.redraw.is_at_rest, timeout=TIMEOUT_MS)
    others.stop()
    assert [note for note in view.notes if note != "other"] == WHOLE
    for first, second in itertools.pairwise(WHOLE):
        assert "other" in view.notes[view.notes.index(first) : view.notes.index(second)]


def test_a_change_in_between_waits_until_the_picture_is_whole_and_gets_its_own(view, timers) -> None:
    view.redraw.request()
    draw_until(view, timers, "part 1")
    view.redraw.request()
    view.redraw.request()
    timers.run_out()
    assert view.notes == WHOLE + WHOLE


def test_motion_gives_up_the_parts_and_is_drawn_at_once(view, timers) -> None:
    view.redraw.request()
    draw_until(view, timers, "part 1")
    view.is_moving = True
    view.redraw.request()
    timers.run_out()
    done = view.notes.index("given up")
    assert view.notes[:done] == WHOLE[:done] and done < PARTS
    assert view.notes[done + 1 :] == ["frame", *WHOLE]


def test_motion_is_drawn_frame_by_frame_and_once_in_full_when_it_rests(view, timers) -> None:
    for _ in range(3):
        view.is_moving = True
        view.redraw.request()
        timers.advance(REST_MS - 1)
    assert view.notes == ["frame"] * 3
    timers.run_out()
    assert view.notes == ["frame"] * 3 + WHOLE


def test_a_frame_that_is_put_off_to_the_next_turn_is_drawn_there(view, timers) -> None:
    view.is_moving = True
    view.redraw.next_turn()
    assert view.redraw.is_at_rest, "nothing has been asked for"
    view.redraw.request()
    view.redraw.next_turn()
    assert view.notes == []
    timers.advance(0)
    assert view.notes == ["frame"]


def test_a_rested_frame_that_is_put_off_comes_a_whole_rest_later(view, timers) -> None:
    view.is_moving = True
    view.redraw.request()
    timers.advance(REST_MS - 1)
    view.redraw.postpone_rest()
    timers.advance(REST_MS - 1)
    assert view.notes == ["frame"] and view.redraw.is_busy
    timers.advance(1)
    assert view.notes == ["frame", *WHOLE] and view.redraw.is_at_rest


def test_a_view_that_is_closed_between_two_parts_draws_no_more(view, timers) -> None:
    view.redraw.request()
    draw_until(view, timers, "part 1")
    view.redraw.stop()
    view.redraw.request()
    timers.run_out()
    assert view.notes[-1] == "given up" and view.redraw.is_at_rest
