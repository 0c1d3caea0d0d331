"""Waiting for what must come, however slow the computer is: a time limit here only ends a test that has failed.

It is long because kernels may have to be compiled first, beside everything else that a busy computer does.
"""

from __future__ import annotations

import time
from collections.abc import Callable

TIMEOUT_S = 300.0
TIMEOUT_MS = 300_000


def wait_for(is_true: Callable[[], object]) -> None:
    """Let Qt work until something is so."""
    from PySide6.QtTest import QTest  # not loaded by tests of commands

    _wait(is_true, lambda: QTest.qWait(1))


def poll(is_true: Callable[[], object]) -> None:
    """Look again and again at another process until something is so."""
    _wait(is_true, lambda: time.sleep(0.01))


def _wait(is_true: Callable[[], object], let_work: Callable[[], object]) -> None:
    end_s = time.monotonic() + TIMEOUT_S
    while not is_true():
        assert time.monotonic() < end_s, "waited in vain"
        let_work()
