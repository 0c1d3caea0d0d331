"""Measure the processors that other programs leave idle, and limit the threads of an edit to them.

Threads that share some milliseconds of work wait for each other at its end, and on a computer without a processor to
spare for each that takes longer than the work: a LiDAR was moved in 18 ms by two threads, and in 13 ms by one.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import NamedTuple

import psutil

PERIOD_S = 0.25
"""Seconds for which a measurement is reused."""
LONG_MS = 20.0
"""Edits at least this long gain by every thread, even beside other programs."""
NOT_WORK = ("idle", "iowait", "guest", "guest_nice")
"""Times of the system that are not work of its processors, or are counted twice."""


class Work(NamedTuple):
    """Seconds of processor time since some moment: of all programs, and of this one."""

    everyone: float
    own: float


def work_until_now() -> Work:
    """Ask the system."""
    everyone, own = psutil.cpu_times()._asdict(), os.times()
    return Work(sum(s for name, s in everyone.items() if name not in NOT_WORK), own.user + own.system)


class Processors:
    """Processors left idle by other programs, measured a few times a second."""

    def __init__(
        self,
        count: int | None = None,
        clock: Callable[[], float] = time.monotonic,
        work: Callable[[], Work] = work_until_now,
    ) -> None:
        self._count, self._clock, self._work = count or os.cpu_count() or 1, clock, work
        self._since, self._until_then, self._free = clock(), work(), float(self._count)

    def threads(self, most: int, last_ms: float) -> int:
        """Return the number of threads, `most` at most, for an edit if the last one took `last_ms` milliseconds."""
        if most == 1 or last_ms >= LONG_MS:
            return most
        return min(most, max(1, int(self._free_now() + 0.5)))

    def _free_now(self) -> float:
        now = self._clock()
        if now - self._since >= PERIOD_S:
            work = self._work()
            everyone, own = (b - a for a, b in zip(self._until_then, work, strict=True))
            self._free = self._count - (everyone - own) / (now - self._since)
            self._since, self._until_then = now, work
        return self._free
