"""Leaving without delay: at Ctrl-C while the window starts, and after its end when a thread goes on for too long.

No Qt here: this is needed while Qt is being loaded.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

GRACE_S = 1.0
"""How long threads may take to end after the window: compiling a kernel cannot be given up."""
INTERRUPTED = 130


def leave_at_once(*_: object) -> None:
    """End the process with a word to the user. A handler of signals."""
    os.write(2, b"riglens: interrupted\n")
    os._exit(INTERRUPTED)


@contextmanager
def leaving_on_interrupt() -> Iterator[None]:
    """While nothing is there that could be lost, Ctrl-C ends the process.

    An exception would not do: Qt prints those that pass through it and goes on, and crashes while it is loaded.
    """
    before = signal.signal(signal.SIGINT, leave_at_once)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


class Grace:
    """Ends the process when what was started with it has not ended in time."""

    def __init__(self) -> None:
        self._timer: threading.Timer | None = None

    def start(self, code: int) -> None:
        """End the process with this exit code in GRACE_S; everything that is to be kept has been written."""
        self._timer = threading.Timer(GRACE_S, os._exit, (code,))
        self._timer.daemon = True
        self._timer.start()

    def cancel(self) -> None:
        """All is over in good time, or was not begun."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer.join()
