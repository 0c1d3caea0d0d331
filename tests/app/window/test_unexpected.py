"""A mistake of ours is told once, with details to copy, and the window goes on."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from pytestqt.qtbot import QtBot

from riglens.app.window.unexpected import LOG, failures_told
from tests.app.window_bench import open_bench
from tests.waiting import TIMEOUT_MS


def fail() -> None:
    raise RuntimeError("the wheel came off")


def test_an_exception_in_a_slot_is_told_and_logged_and_the_window_goes_on(
    qtbot: QtBot, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with (
        open_bench(qtbot, tmp_path) as bench,
        failures_told(bench.workbench.report_error, tmp_path / "state"),
    ):
        QTimer.singleShot(0, fail)
        qtbot.waitUntil(lambda: bench.workbench.errors.message != "", timeout=TIMEOUT_MS)
        bar = bench.workbench.errors
        assert "RuntimeError: the wheel came off" in bar.message and "\n" not in bar.message
        assert "in fail" in bar.details
        assert "the wheel came off" in (tmp_path / "state" / LOG).read_text(encoding="utf-8")
        bench.act("new")
        assert bench.document.rig.sensors == ()
    assert "RuntimeError" in capfd.readouterr().err


def test_an_exception_in_a_thread_is_told_too(
    qtbot: QtBot, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told: list[str] = []
    with failures_told(lambda message, details: told.append(message), tmp_path):
        thread = threading.Thread(target=fail)
        thread.start()
        thread.join()
        qtbot.waitUntil(lambda: bool(told), timeout=TIMEOUT_MS)
    assert "the wheel came off" in told[0]


def test_without_a_log_folder_failures_are_told_all_the_same(
    qtbot: QtBot, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told: list[str] = []
    (tmp_path / "file").write_text("", encoding="utf-8")
    with failures_told(lambda message, details: told.append(message), tmp_path / "file"):
        QTimer.singleShot(0, fail)
        qtbot.waitUntil(lambda: bool(told), timeout=TIMEOUT_MS)
    assert LOG not in told[0]


def test_the_hooks_of_before_are_back_afterwards(tmp_path: Path) -> None:
    before = sys.excepthook, threading.excepthook
    with failures_told(print, tmp_path):
        assert sys.excepthook is not before[0]
    assert (sys.excepthook, threading.excepthook) == before
