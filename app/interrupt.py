"""Ctrl-C in the terminal ends the window in order."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager

from PySide6.QtCore import QSocketNotifier
from PySide6.QtWidgets import QApplication


@contextmanager
def quit_on_interrupt(app: QApplication) -> Iterator[None]:
    """Have Ctrl-C in the terminal end the program in order, although Qt's loop runs no Python by itself."""
    read_fd, write_fd = os.pipe()
    os.set_blocking(write_fd, False)
    notifier = QSocketNotifier(read_fd, QSocketNotifier.Type.Read, app)
    notifier.activated.connect(lambda *_: os.read(read_fd, 64))
    before = signal.signal(signal.SIGINT, lambda *_: app.quit())
    before_fd = signal.set_wakeup_fd(write_fd, warn_on_full_buffer=False)
    try:
        yield
    finally:
        signal.set_wakeup_fd(before_fd)
        signal.signal(signal.SIGINT, before)
        notifier.setEnabled(False)
        os.close(read_fd)
        os.close(write_fd)
