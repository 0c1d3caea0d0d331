"""Give freed memory back to the system: the C library keeps what threads have freed, hundreds of megabytes in time."""

from __future__ import annotations

import ctypes
import linecache
import sys
import threading
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

ARENAS, M_ARENA_MAX = 2, -8
"""Pools of memory for all threads, else eight for each processor that fill one after another; `mallopt` of glibc."""
OWN_PAGES_BYTES, M_MMAP_THRESHOLD = 8 << 20, -3
"""From this size on memory has pages of its own, which go back as soon as it is freed; else the C library raises the
limit to 32 MB, and what is freed stays between what is not. New pages cost 0.15 ms a megabyte, so that arrays of a
drag have none."""
WAIT_MS = 5000
"""From the first answer after the last time; during a drag once more."""


class FreedMemory(QObject):
    """Timer that releases freed memory soon after `note` was called, but not while `is_busy`."""

    resting = Signal()
    """Time to release what is of no use at rest."""

    def __init__(self, is_busy: Callable[[], bool], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._is_busy = is_busy
        self._timer = QTimer(self, singleShot=True, interval=WAIT_MS)
        self._timer.timeout.connect(self._give_back)

    def note(self, _: object = None) -> None:
        """Note that work was done, which has freed some."""
        if not self._timer.isActive():
            self._timer.start()

    def _give_back(self) -> None:
        if self._is_busy():
            self._timer.start()
        else:
            self.resting.emit()
            threading.Thread(target=trim, name="memory", daemon=True).start()


def share_memory() -> None:
    """Have threads share few pools of memory, where the C library makes many; for those that are yet to start."""
    if sys.platform == "linux" and hasattr(library := ctypes.CDLL(None), "mallopt"):
        library.mallopt(M_ARENA_MAX, ARENAS)
        library.mallopt(M_MMAP_THRESHOLD, OWN_PAGES_BYTES)


class _LastFile(dict[str, Any]):
    """Lines of the source that was read last."""

    def __setitem__(self, name: str, lines: Any) -> None:
        self.clear()
        super().__setitem__(name, lines)

    def __missing__(self, name: str) -> Any:
        return 0, None, [], name  # it was there when this thread looked, and another has read a source since


def keep_one_source() -> None:
    """Have Python keep the lines of one source at a time, for modules yet to be imported: Shiboken reads those of every
    module, 60 MB, and what is freed of them later lies between what is not."""
    linecache.cache = _LastFile()


def trim() -> None:
    """Give freed memory back now, where the C library is one that keeps it."""
    if sys.platform == "linux" and hasattr(library := ctypes.CDLL(None), "malloc_trim"):
        library.malloc_trim(0)
