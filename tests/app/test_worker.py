"""A worker answers the latest request, with progress and early answers, and its end never hangs."""

from __future__ import annotations

import os
import sys
import threading
import weakref
from collections.abc import Iterator

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from riglens.app.background.queue import BackgroundRequest
from riglens.app.background.worker import NICE, BackgroundWorker, Context
from riglens.core.errors import Cancelled, InputError
from tests.waiting import TIMEOUT_S

DIRECT = Qt.ConnectionType.DirectConnection


class Script:
    """Answers a request with its text in capitals; holds some until a test lets go, and fails by name."""

    def __init__(self) -> None:
        self.reached, self.go_on = threading.Event(), threading.Event()
        self.cancelled: list[object] = []

    def __call__(self, request: str | BackgroundRequest, context: Context[str]) -> str:
        name = request if isinstance(request, str) else request.name
        if name.startswith("held"):
            self.reached.set()
            assert self.go_on.wait(TIMEOUT_S)
            if context.is_stale():
                self.cancelled.append(request)
                raise Cancelled
        if name == "wrong":
            raise InputError("wrong input")
        if name == "broken":
            raise ZeroDivisionError("no way")
        if name == "early":
            context.publish("sample")
            context.report(0.5)
        return name.upper()


class Bench:
    def __init__(self) -> None:
        self.script = Script()
        self.worker = BackgroundWorker[str | BackgroundRequest, str](
            "letters", self.script, close_s=TIMEOUT_S
        )
        self.heard: list[tuple[object, ...]] = []
        for signal in (self.worker.answered, self.worker.answered_in_background, self.worker.progressed):
            signal.connect(lambda *found: self.heard.append(found), DIRECT)
        self.worker.failed.connect(lambda problem: self.heard.append((problem,)), DIRECT)

    def finish(self) -> list[tuple[object, ...]]:
        assert self.worker.wait_until_idle(TIMEOUT_S)
        return self.heard


@pytest.fixture
def bench(qtbot: QtBot) -> Iterator[Bench]:
    made = Bench()
    yield made
    made.script.go_on.set()
    made.worker.close()


def later(name: str) -> BackgroundRequest:
    return BackgroundRequest("group", name)


def test_a_request_is_answered_with_early_answers_and_progress(bench: Bench) -> None:
    bench.worker.ask("early")
    assert bench.finish() == [("early", "sample"), ("early", 0.5), ("early", "EARLY")]


def test_of_the_requests_that_wait_the_latest_is_answered(bench: Bench) -> None:
    bench.worker.ask("held")
    assert bench.script.reached.wait(TIMEOUT_S)
    bench.worker.ask("second")
    bench.worker.ask("third")
    bench.script.go_on.set()
    assert bench.finish() == [("third", "THIRD")] and bench.script.cancelled == ["held"]


def test_wrong_input_is_one_line_and_a_bug_has_a_traceback(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.worker.ask("wrong")
    assert bench.finish() == [("wrong input",)] and capsys.readouterr().err == ""
    bench.worker.ask("broken")
    assert bench.finish()[1] == ("Unexpected failure in the letters: ZeroDivisionError: no way",)
    assert "Traceback" in capsys.readouterr().err
    bench.worker.ask("next")
    assert bench.finish()[2] == ("next", "NEXT")


def test_a_dropped_request_is_not_answered_even_when_it_is_under_way(bench: Bench) -> None:
    bench.worker.ask("held")
    assert bench.script.reached.wait(TIMEOUT_S)
    bench.worker.drop()
    bench.script.go_on.set()
    assert bench.finish() == [] and bench.script.cancelled == ["held"]


def test_a_background_request_gives_way_and_is_answered_afterwards(bench: Bench) -> None:
    bench.worker.ask_in_background([later("held"), later("wrong")])
    assert bench.script.reached.wait(TIMEOUT_S)
    bench.worker.ask("edit")
    bench.script.go_on.set()
    assert bench.finish() == [("edit", "EDIT"), (later("held"), "HELD"), (later("wrong"), None)]


def test_a_dropped_group_is_not_answered(bench: Bench) -> None:
    bench.worker.ask_in_background([later("held"), later("next")])
    assert bench.script.reached.wait(TIMEOUT_S)
    bench.worker.drop_group("other")
    bench.worker.drop_group("group")
    bench.script.go_on.set()
    assert bench.finish() == []


def test_closing_ends_the_thread_and_nothing_is_answered_any_more(bench: Bench) -> None:
    bench.worker.ask("held")
    assert bench.script.reached.wait(TIMEOUT_S)
    assert bench.worker._thread._thread.daemon  # work that does not end cannot keep the program from ending
    bench.worker._queue.close()
    bench.script.go_on.set()
    bench.worker.close()
    assert not bench.worker._thread._thread.is_alive() and bench.heard == []


class Word(str):
    """A request of which the end can be watched."""


def test_a_thread_that_waits_holds_no_request(bench: Bench) -> None:
    word = Word("gone")
    held = weakref.ref(word)
    bench.worker.ask(word)
    assert bench.finish() == [("gone", "GONE")]
    bench.heard.clear()
    del word
    assert held() is None


@pytest.mark.skipif(sys.platform != "linux", reason="threads have no niceness of their own")
def test_the_thread_lets_the_interface_go_first(qtbot: QtBot) -> None:
    found = list[int]()
    own = os.getpriority(os.PRIO_PROCESS, 0)
    worker = BackgroundWorker[str, int](
        "niceness", lambda request, context: os.getpriority(os.PRIO_PROCESS, 0), close_s=TIMEOUT_S
    )
    worker.answered.connect(lambda _, niceness: found.append(niceness), DIRECT)
    worker.ask("how nice?")
    assert worker.wait_until_idle(TIMEOUT_S)
    worker.close()
    assert found == [min(own + NICE, 19)] and os.getpriority(os.PRIO_PROCESS, 0) == own
