"""Timers are handed in: a window gets Qt's, a test drives its own by hand and never waits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from PySide6.QtCore import QObject, QTimer


class Timer(Protocol):
    """Interface of a single-shot QTimer, as far as it is used."""

    def start(self) -> None:
        """Run the slot after the interval; a running timer restarts."""

    def stop(self) -> None:
        """Do not run the slot after all."""

    def isActive(self) -> bool:
        """Return whether the slot is still to be run."""


Timers = Callable[[QObject, int, Callable[[], object]], Timer]
"""Makes a timer of an owner, an interval in milliseconds and a slot; with 0 ms the slot runs when Qt is idle."""


def single_shot(owner: QObject, interval_ms: int, slot: Callable[[], object]) -> Timer:
    """Return a timer on Qt's clock that lives as long as its owner."""
    timer = QTimer(owner)
    timer.setSingleShot(True)
    timer.setInterval(interval_ms)
    timer.timeout.connect(slot)
    return timer
