"""Waiting for what must come, however slow the computer is: a time limit here only ends a test that has failed."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QDeadlineTimer
from PySide6.QtTest import QTest

TIMEOUT_S = 60.0
TIMEOUT_MS = 60_000


def wait_for(is_true: Callable[[], object]) -> None:
    """Let Qt work until something is so."""
    end = QDeadlineTimer(TIMEOUT_MS)
    while not is_true():
        assert not end.hasExpired(), "waited in vain"
        QTest.qWait(1)
