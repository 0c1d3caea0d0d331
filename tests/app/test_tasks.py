"""Long work runs beside the window: progress, cancel, one error, and nothing left behind."""

from __future__ import annotations

import gc
import threading
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QPushButton
from pytestqt.qtbot import QtBot

from riglens.app.background.tasks import Tasks
from riglens.core.errors import InputError
from riglens.core.scene.boxes import Progress
from riglens.widgets.panels.controls.messages import ProgressStrip
from tests.app.window_bench import open_bench
from tests.waiting import TIMEOUT_MS


@pytest.fixture
def tasks(qtbot: QtBot) -> Iterator[Tasks]:
    made = Tasks()
    yield made
    made.close()


def forever(progress: Progress) -> None:
    """Work that ends only when it is cancelled."""
    waiting = threading.Event()
    while not waiting.wait(0.002):
        progress(0.25)


def test_the_answer_arrives_on_the_interface_thread(qtbot: QtBot, tasks: Tasks) -> None:
    seen: list[object] = []
    tasks.run(
        "Adding", lambda progress: 1 + 1, lambda found: seen.extend((found, threading.current_thread()))
    )
    qtbot.waitUntil(lambda: not tasks._running, timeout=TIMEOUT_MS)
    assert seen == [2, threading.main_thread()]


def test_nothing_of_a_task_stays_when_it_has_ended(qtbot: QtBot, tasks: Tasks) -> None:
    worked_on = threading.Event()  # anything that can be referred to weakly
    gone = weakref.ref(worked_on)
    tasks.run("Adding", lambda progress, what=worked_on: None, lambda found: None)  # type: ignore[misc]
    del worked_on
    qtbot.waitUntil(lambda: not tasks._running, timeout=TIMEOUT_MS)
    gc.collect()
    assert gone() is None


def test_bad_input_is_one_line_without_details(qtbot: QtBot, tasks: Tasks) -> None:
    def refuse(progress: Progress) -> None:
        raise InputError("boxes.csv: line 3: x must be a number (got 'a')")

    said: list[tuple[str, str]] = []
    tasks.failed.connect(lambda message, details: said.append((message, details)))
    tasks.run("Reading", refuse, lambda _: said.append(("done", "")))
    qtbot.waitUntil(lambda: not tasks._running, timeout=TIMEOUT_MS)
    assert said == [("boxes.csv: line 3: x must be a number (got 'a')", "")]


def test_a_mistake_of_ours_names_the_task_and_has_a_traceback(qtbot: QtBot, tasks: Tasks) -> None:
    said: list[tuple[str, str]] = []
    tasks.failed.connect(lambda message, details: said.append((message, details)))
    tasks.run("Dividing", lambda progress: 1 // 0, print)
    qtbot.waitUntil(lambda: not tasks._running, timeout=TIMEOUT_MS)
    [(message, details)] = said
    assert message.startswith("Dividing: unexpected failure: ZeroDivisionError")
    assert "Traceback" in details


def test_a_cancelled_task_ends_without_an_answer_or_an_error(qtbot: QtBot, tasks: Tasks) -> None:
    said: list[str] = []
    tasks.failed.connect(lambda message, _: said.append(message))
    task = tasks.run("Waiting", forever, lambda _: said.append("done"), lambda: said.append("ended"))
    task.cancel()
    qtbot.waitUntil(lambda: not tasks._running, timeout=TIMEOUT_MS)
    assert said == ["ended"]


def test_the_status_bar_shows_long_work_and_its_cancel_ends_it(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        task = bench.workbench.tasks.run("Counting sheep", forever, print)
        strips = bench.workbench.status.findChildren(ProgressStrip)
        [strip] = [strip for strip in strips if strip.is_running]
        qtbot.waitUntil(strip.isVisible, timeout=TIMEOUT_MS)
        qtbot.waitUntil(lambda: strip.bar.value() == 250, timeout=TIMEOUT_MS)
        assert "Counting sheep" in strip.bar.format()
        cancel = strip.findChild(QPushButton)
        cancel.click()
        assert not cancel.isEnabled()
        qtbot.waitUntil(lambda: task not in bench.workbench.tasks._running, timeout=TIMEOUT_MS)


def test_closing_the_window_gives_up_what_runs(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.workbench.tasks.run("Counting sheep", forever, print)
        bench.window.close()
        assert not bench.workbench.tasks._running


def test_a_failed_task_is_told_in_the_message_bar_with_details(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.workbench.tasks.run("Dividing", lambda progress: 1 // 0, print)
        bar = bench.workbench.errors
        qtbot.waitUntil(lambda: bar.message != "", timeout=TIMEOUT_MS)
        assert "Traceback" in bar.details
        bar.findChild(QPushButton, "details").click()
        bar.findChild(QPushButton, "copy_details").click()
        copied = bench.clipboard()
        assert copied.startswith(bar.message) and bar.details in copied


def test_a_stage_of_unknown_length_is_named_and_shows_no_share_of_the_way(qtbot: QtBot) -> None:
    strip = ProgressStrip("Loading boxes")
    qtbot.addWidget(strip)
    strip.begin()
    strip.show_progress(0.4)
    strip.name_stage("Counting")
    strip.show_progress(0.5)
    assert "Loading boxes: counting" in strip.bar.toolTip() and strip.bar.text().startswith("Loa")
    strip.show_stage("Preparing the engine", "a minute or two")
    assert strip.bar.text() == "Preparing the engine" and strip.left.text() == "a minute or two"
    strip.begin()
    assert strip.bar.text().startswith("Loading boxes")
