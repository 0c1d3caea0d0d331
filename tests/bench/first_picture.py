"""Run as a process of its own: `riglens` until the first picture of the 3D view, then the process ends."""

from __future__ import annotations

import os
import sys

from riglens.app import commands as cli
from riglens.app.commands import start

PATIENCE_MS = 60_000


def end_at_first_picture() -> None:
    """Put an application in place that the window finds, and that ends the process instead of serving the user."""
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication, QMainWindow

    class UntilFirstPicture(QApplication):
        @staticmethod
        def exec() -> int:
            """Run until the first frame of the 3D view in the window that is now open is on the screen."""
            from riglens.widgets.viewport.viewport_base import ViewportBase

            [window] = [
                widget for widget in QApplication.topLevelWidgets() if isinstance(widget, QMainWindow)
            ]
            [view] = window.findChildren(ViewportBase)
            view.shown.connect(lambda: os._exit(0))
            QTimer.singleShot(PATIENCE_MS, _give_up)
            QApplication.exec()
            return 1

    UntilFirstPicture(["riglens"])


def _give_up() -> None:
    print(f"no picture after {PATIENCE_MS // 1000} s", file=sys.stderr, flush=True)
    os._exit(1)


def run() -> int:
    """What the console script does; the application joins where the product loads Qt, so that the order is its own."""
    load = start.load_packages

    def load_and_place() -> None:
        load()
        end_at_first_picture()

    start.load_packages = load_and_place
    return cli.main([])


if __name__ == "__main__":
    sys.exit(run())
