"""Ctrl-C and SIGTERM in each phase of the program (a command, the start of the window, the window), and a prompt end.

No Qt here before there is a window: this is needed while Qt is being loaded.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

AGAIN_S = 3.0
"""Seconds for cleaning up before an interruption counts as lost."""
LOST_S = 0.05
"""Seconds until an interruption that Python reports as lost is sent again."""
GRACE_S = 1.0
"""Seconds that threads may outlive the window: the compilation of a kernel cannot be aborted."""
INTERRUPTED = 130
SIGNALS = (signal.SIGINT, signal.SIGTERM)
"""Ctrl-C, and what ends a job, a container or a session of the desktop: both leave no half-done work behind."""


@contextmanager
def _heard_by(handler: Callable[[int, FrameType | None], object]) -> Iterator[None]:
    """Have a handler called for the signals while the block runs."""
    before = {number: signal.signal(number, handler) for number in SIGNALS}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


# ---------------------------------------------------------------- commands


def _interrupt_main_thread() -> None:
    """Send Ctrl-C to the main thread from another one; Windows would end the process on `os.kill`."""
    if hasattr(signal, "pthread_kill"):  # also ends a call of the system that the main thread waits in
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)


class Alarm(Protocol):
    """Interface of threading.Timer, as far as it is used."""

    daemon: bool

    def start(self) -> None:
        """Call the function when the time is up."""

    def cancel(self) -> None:
        """Do not call it."""


@contextmanager
def insistent_interrupt(
    timer_of: Callable[[float, Callable[[], None]], Alarm] = threading.Timer,
) -> Iterator[None]:
    """Interrupt the main thread on Ctrl-C or SIGTERM repeatedly until the exception arrives here.

    The compiler calls back into Python while it makes a kernel, and exceptions raised there, or in a destructor,
    are lost.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    timers: list[Alarm] = []
    told = sys.unraisablehook

    def come_again(seconds: float) -> None:
        timer = timer_of(seconds, _interrupt_main_thread)
        timer.daemon = True
        timers.append(timer)
        timer.start()

    def tell(lost: sys.UnraisableHookArgs) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt):
            come_again(LOST_S)
        else:
            told(lost)

    def interrupt(number: int, frame: FrameType | None) -> None:
        come_again(AGAIN_S)
        raise KeyboardInterrupt

    try:
        sys.unraisablehook = tell
        with _heard_by(interrupt):
            yield
    except Exception as error:
        if timers:  # what failed, failed for want of what the interruption left undone
            raise KeyboardInterrupt from error
        raise
    finally:
        sys.unraisablehook = told
        for timer in timers:
            timer.cancel()


# ---------------------------------------------------------------- the start of the window, and its end


def leave_at_once(*_: object) -> None:
    """Notify the user and end the process; a signal handler."""
    os.write(2, b"riglens: interrupted\n")
    os._exit(INTERRUPTED)


@contextmanager
def leaving_on_interrupt() -> Iterator[None]:
    """End the process at once on Ctrl-C or SIGTERM, as long as there is nothing to lose.

    An exception would not do: Qt prints those that pass through it and continues, and crashes while it is loaded.
    """
    with _heard_by(leave_at_once):
        yield


class Grace:
    """Watchdog that ends the process when threads outlive the window for too long."""

    def __init__(self) -> None:
        self._timer: threading.Timer | None = None

    def start(self, code: int) -> None:
        """End the process with this exit code after GRACE_S; call it when all files are written."""
        self._timer = threading.Timer(GRACE_S, os._exit, (code,))
        self._timer.daemon = True
        self._timer.start()

    def cancel(self) -> None:
        """Cancel the forced exit."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer.join()


# ---------------------------------------------------------------- the window


@dataclass
class Interrupt:
    """Interruption by Ctrl-C or SIGTERM, until a window refuses to close."""

    came: bool = False

    @property
    def code(self) -> int:
        """The exit code of a program that ends now."""
        return INTERRUPTED if self.came else 0


@contextmanager
def quit_on_interrupt(app: QApplication) -> Iterator[Interrupt]:
    """Have Ctrl-C in the terminal, or SIGTERM, close all windows and end Qt's loop, which runs no Python by itself.

    The windows are closed by the loop, never in the middle of what Python does just then, such as drawing. A
    second Ctrl-C meanwhile ends the process at once.
    """
    import socket

    from PySide6.QtCore import QSocketNotifier

    interrupt = Interrupt()
    reader, writer = socket.socketpair()  # Qt watches no pipe on Windows
    writer.setblocking(False)

    def note(*_: object) -> None:
        if interrupt.came:
            leave_at_once()
        interrupt.came = True

    def heed() -> None:
        reader.recv(64)
        if interrupt.came:
            app.quit()
            interrupt.came = not any(window.isVisible() for window in app.topLevelWidgets())

    notifier = QSocketNotifier(reader.fileno(), QSocketNotifier.Type.Read, app)
    notifier.activated.connect(lambda *_: heed())
    before_fd = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    try:
        with _heard_by(note):
            yield interrupt
    finally:
        signal.set_wakeup_fd(before_fd)
        notifier.setEnabled(False)
        reader.close()
        writer.close()
