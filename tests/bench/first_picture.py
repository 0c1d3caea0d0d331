"""Run as a process of its own: `riglens` until the first picture of the 3D view, then the process ends."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

from riglens.app import commands as cli
from riglens.app.commands import start

if TYPE_CHECKING:  # loads Qt, which the product loads later
    from riglens.app.window.main_window import MainWindow

PATIENCE_MS = 60_000


def place_application(wait: Callable[[MainWindow], None]) -> None:
    """Put an application in place that the window finds, and that calls `wait` on it, to end the process, instead of
    serving the user."""
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication

    class Waiting(QApplication):
        @staticmethod
        def exec() -> int:
            """Run until `wait` ends the process."""
            from riglens.app.window.main_window import MainWindow

            [window] = [widget for widget in QApplication.topLevelWidgets() if isinstance(widget, MainWindow)]
            wait(window)
            QTimer.singleShot(PATIENCE_MS, _give_up)
            QApplication.exec()
            return 1

    Waiting(["riglens"])


def _give_up() -> None:
    print(f"not ready after {PATIENCE_MS // 1000} s", file=sys.stderr, flush=True)
    os._exit(1)


def start_with(wait: Callable[[MainWindow], None]) -> None:
    """Have the product's start place the application where it loads Qt, so that the order is its own."""
    load = start.load_packages

    def load_and_place() -> None:
        load()
        place_application(wait)

    start.load_packages = load_and_place


def until_first_picture(window: MainWindow) -> None:
    """End with the first frame of the 3D view that is on the screen."""
    window.bench.viewport.shown.connect(lambda: os._exit(0))


if __name__ == "__main__":
    start_with(until_first_picture)
    sys.exit(cli.main([]))
