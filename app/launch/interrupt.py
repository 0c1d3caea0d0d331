"""Ctrl-C in the terminal ends the window in order."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from PySide6.QtCore import QSocketNotifier
from PySide6.QtWidgets import QApplication

from riglens.app.launch.leaving import INTERRUPTED, leave_at_once


@dataclass
class Interrupt:
    """Whether Ctrl-C was pressed and not called off since by a window that stays open."""

    came: bool = False

    @property
    def code(self) -> int:
        """The exit code of a program that ends now."""
        return INTERRUPTED if self.came else 0


@contextmanager
def quit_on_interrupt(app: QApplication) -> Iterator[Interrupt]:
    """Have Ctrl-C in the terminal close all windows and end Qt's loop, although that runs no Python by itself.

    The windows are closed by the loop, never in the middle of what Python does just then, such as drawing. A
    second Ctrl-C meanwhile ends the process at once.
    """
    interrupt = Interrupt()
    read_fd, write_fd = os.pipe()
    os.set_blocking(write_fd, False)

    def note(*_: object) -> None:
        if interrupt.came:
            leave_at_once()
        interrupt.came = True

    def heed() -> None:
        os.read(read_fd, 64)
        if interrupt.came:
            app.quit()
            interrupt.came = not any(window.isVisible() for window in app.topLevelWidgets())

    notifier = QSocketNotifier(read_fd, QSocketNotifier.Type.Read, app)
    notifier.activated.connect(lambda *_: heed())
    before = signal.signal(signal.SIGINT, note)
    before_fd = signal.set_wakeup_fd(write_fd, warn_on_full_buffer=False)
    try:
        yield interrupt
    finally:
        signal.set_wakeup_fd(before_fd)
        signal.signal(signal.SIGINT, before)
        notifier.setEnabled(False)
        os.close(read_fd)
        os.close(write_fd)
