"""Limit the seconds of reading: the readers' own time, checked in their loops, by an injected clock."""

from __future__ import annotations

import time
from collections.abc import Callable

from riglens.core.errors import InputError

Clock = Callable[[], float]
"""Seconds that only ever grow, such as time.monotonic."""
MAX_RIG_S = 60.0
"""For a rig with all the files that belong to it."""
MAX_BOXES_S = 4 * 3600.0
"""For one pass over a data set, or over one part of it that is read by itself."""


class ReadingTime:
    """Limit of reading time; `check` raises beyond the limit."""

    def __init__(self, where: str, most_s: float, clock: Clock = time.monotonic) -> None:
        self._where, self._most_s, self._clock = where, most_s, clock
        self._since_s: float | None = clock()
        self._before_s = 0.0

    def pause(self) -> None:
        """Stop the clock while others process the data."""
        self._before_s, self._since_s = self.taken_s, None

    def go_on(self) -> None:
        """Read on."""
        self._since_s = self._clock()

    @property
    def taken_s(self) -> float:
        """Return the seconds spent reading so far."""
        return self._before_s + (0.0 if self._since_s is None else self._clock() - self._since_s)

    def check(self) -> None:
        """Raise InputError when it has taken too long."""
        if self.taken_s > self._most_s:
            raise InputError(f"{self._where}: reading took longer than {self._most_s:g} s")
