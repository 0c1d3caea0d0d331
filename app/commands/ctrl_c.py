"""Ctrl-C that is heard: some libraries swallow an exception that reaches them at a bad moment."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Protocol

AGAIN_S = 3.0
"""Time to tidy up after an interruption before it is taken as not heard."""


class Timer(Protocol):
    """What is used of a threading.Timer."""

    daemon: bool

    def start(self) -> None:
        """Call the function when the time is over."""

    def cancel(self) -> None:
        """Do not call it."""


@contextmanager
def insistent_interrupt(
    timer_of: Callable[[float, Callable[[], None]], Timer] = threading.Timer,
) -> Iterator[None]:
    """Within it, Ctrl-C interrupts the main thread again and again until the exception has come out here.

    The compiler calls back into Python while it makes a kernel, and what is raised there is lost.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    timers: list[Timer] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        timer = timer_of(AGAIN_S, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.daemon = True
        timers.append(timer)
        timer.start()
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    except Exception as error:
        if timers:  # what failed, failed for want of what the interruption left undone
            raise KeyboardInterrupt from error
        raise
    finally:
        signal.signal(signal.SIGINT, before)
        for timer in timers:
            timer.cancel()
