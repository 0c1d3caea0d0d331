"""Run as a process of its own: `riglens` until the first picture of the 3D view, then the process ends."""

from __future__ import annotations

import os
import sys

from PySide6.QtWidgets import QApplication, QMainWindow

from app import cli


class UntilFirstPicture(QApplication):
    """The application that the window finds in place; it ends the process instead of serving the user."""

    @staticmethod
    def exec() -> int:
        """Run until VTK has drawn a frame of the window that is now open."""
        from pyvistaqt import (
            QtInteractor,
        )  # here, and not above: after the product has loaded it, in its order

        from widgets.viewport.scene import render_window

        [window] = [widget for widget in QApplication.topLevelWidgets() if isinstance(widget, QMainWindow)]
        [view] = window.findChildren(QtInteractor)
        render_window(view).AddObserver("EndEvent", lambda *_: os._exit(0))
        QApplication.exec()
        return 1


def main() -> int:
    """What the console script does, in an application that is already there."""
    UntilFirstPicture(["riglens"])
    return cli.main([])


if __name__ == "__main__":
    sys.exit(main())
