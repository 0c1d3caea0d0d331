"""How long something will take yet, from how far it is."""

from __future__ import annotations

import time
from collections.abc import Callable

WARM_UP_S = 1.0
RECENT = 0.3
"""Share of the newest estimate in the one that is shown: steady, and still soon right when the pace changes."""


class TimeLeft:
    """Told fractions of the work done (0..1), tells seconds left; None until there is something to go by."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._begun_s = clock()
        self._end_s: float | None = None

    def note(self, fraction: float) -> None:
        """So much is done now; smaller than before starts anew, as a second phase of the work does."""
        passed_s = self._clock() - self._begun_s
        if fraction <= 0.0:
            self._begun_s, self._end_s = self._clock(), None
        elif passed_s >= WARM_UP_S:
            end_s = self._begun_s + passed_s / min(fraction, 1.0)
            self._end_s = end_s if self._end_s is None else RECENT * end_s + (1.0 - RECENT) * self._end_s

    @property
    def seconds(self) -> float | None:
        """Seconds left from now, never negative."""
        return None if self._end_s is None else max(0.0, self._end_s - self._clock())


def duration_text(seconds: float) -> str:
    """Seconds in one or two words, coarser the longer: "5 s", "3 min", "1 h 20 min"."""
    if seconds < 60:
        return f"{max(1, round(seconds))} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
