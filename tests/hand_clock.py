"""Clocks and timers that a test drives by hand, so that no test depends on how busy the computer is."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field

from PySide6.QtCore import QObject


class HandClock:
    """Stand-in for the system's clock in background threads: time stands still, or leaps over every rest.

    A thread that waits for a moment sleeps until a test comes to it by `advance`; once time leaps it goes on at once.
    """

    def __init__(self, leaps: bool = False) -> None:
        self._lock = threading.Lock()
        self._now_s = 0.0
        self._leaps = leaps
        self._sleepers: set[threading.Condition] = set()

    def now_s(self) -> float:
        """Return the seconds that have passed."""
        with self._lock:
            return self._now_s

    def wait(self, condition: threading.Condition, until_s: float | None) -> None:
        """Block until the condition is notified or a test has come to that moment."""
        with self._lock:
            if until_s is not None and self._leaps:
                self._now_s = max(self._now_s, until_s)
            if until_s is not None and until_s <= self._now_s:
                return
            self._sleepers.add(condition)
        condition.wait()

    def advance(self, seconds: float) -> None:
        """Let so much time pass."""
        with self._lock:
            self._now_s += seconds
        self._wake()

    def leap(self) -> None:
        """From now on no rest takes any time."""
        with self._lock:
            self._leaps = True
        self._wake()

    def stand_still(self) -> None:
        """From now on every rest lasts until `advance` or `leap`."""
        with self._lock:
            self._leaps = False

    def _wake(self) -> None:
        with self._lock:
            sleepers = tuple(self._sleepers)
        for condition in sleepers:
            with condition:
                condition.notify_all()


class HandTimer:
    """Stand-in for a single-shot QTimer; its slot runs when `HandTimers` comes to its time."""

    def __init__(self, timers: HandTimers, interval_ms: int, slot: Callable[[], object]) -> None:
        self._timers, self._interval_ms, self.slot = timers, interval_ms, slot

    def start(self) -> None:
        """Run the slot after the interval."""
        self._timers.schedule(self, self._interval_ms)

    def stop(self) -> None:
        """Do not run the slot after all."""
        self._timers.drop(self)

    def isActive(self) -> bool:
        """Whether the slot is still to be run."""
        return self._timers.is_active(self)


@dataclass
class HandTimers:
    """Makes timers, and is the clock by which they run: time passes in `advance` and `run_out` only."""

    now_ms: int = 0
    _due: dict[HandTimer, int] = field(default_factory=dict)
    """Running timers in the order of their start, with the time at which each is due."""

    def __call__(self, owner: QObject, interval_ms: int, slot: Callable[[], object]) -> HandTimer:
        """Make a timer, as `riglens.widgets.timers.single_shot` does."""
        return HandTimer(self, interval_ms, slot)

    def advance(self, ms: int) -> None:
        """Let so much time pass; timers that start meanwhile and are due by then run too."""
        end_ms = self.now_ms + ms
        while self._run_next(end_ms):
            pass
        self.now_ms = end_ms

    def run_next(self) -> bool:
        """Let time pass until the next timer is due, and run its slot; False when none is running."""
        return self._run_next(None)

    def run_out(self) -> None:
        """Let time pass until no timer is running."""
        while self.run_next():
            pass

    def schedule(self, timer: HandTimer, interval_ms: int) -> None:
        """Run a timer's slot after the interval; of those due at the same time the one started first is first."""
        self._due.pop(timer, None)
        self._due[timer] = self.now_ms + interval_ms

    def drop(self, timer: HandTimer) -> None:
        """Forget a timer."""
        self._due.pop(timer, None)

    def is_active(self, timer: HandTimer) -> bool:
        """Whether a timer is running."""
        return timer in self._due

    def _run_next(self, end_ms: int | None) -> bool:
        timer = min(self._due, key=self._due.__getitem__, default=None)
        if timer is None or (end_ms is not None and self._due[timer] > end_ms):
            return False
        self.now_ms = max(self.now_ms, self._due.pop(timer))
        timer.slot()
        return True
