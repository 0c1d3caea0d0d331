"""Run as a process of its own: `riglens` until the first picture of the 3D view, then the process ends."""

from __future__ import annotations

import os
import sys

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QMainWindow

from app import cli

PATIENCE_MS = 60_000


class UntilFirstPicture(QApplication):
    """The application that the window finds in place; it ends the process instead of serving the user."""

    @staticmethod
    def exec() -> int:
        """Run until the first frame of the 3D view in the window that is now open is on the screen."""
        from pyvistaqt import (
            QtInteractor,  # here, and not above: after the product has loaded it, in its order
        )

        [window] = [widget for widget in QApplication.topLevelWidgets() if isinstance(widget, QMainWindow)]
        [view] = window.findChildren(QtInteractor)
        view.frameSwapped.connect(lambda: os._exit(0))
        QTimer.singleShot(PATIENCE_MS, _give_up)
        QApplication.exec()
        return 1


def _give_up() -> None:
    print(f"no picture after {PATIENCE_MS // 1000} s", file=sys.stderr, flush=True)
    os._exit(1)


def main() -> int:
    """What the console script does, in an application that is already there."""
    UntilFirstPicture(["riglens"])
    return cli.main([])


if __name__ == "__main__":
    sys.exit(main())
