"""Where docks and toolbar are: kept between sessions, and put back as they were at first on request."""

from __future__ import annotations

from typing import TYPE_CHECKING

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.settings import Settings

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

VERSION = 1
"""Counts up when docks are arranged anew, so that an old layout is not forced on them."""


class Layout(Feature):
    """Geometry and docks of the window. Its place is behind all features that add docks."""

    specs = (
        Spec(
            "reset_layout", "Reset layout", "Put panels, toolbar and window size back as they were at first",
            "Ctrl+Alt+0", menu="view/window",
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._first_state = window.saveState(VERSION)
        self._first_size = window.size()
        self.bind(reset_layout=self.reset)

    def reset(self) -> None:
        """Arrange the window as at the very first start."""
        self.window.showNormal()
        self.window.restoreState(self._first_state, VERSION)
        self.window.resize(self._first_size)

    def restore(self, settings: Settings) -> None:
        self.window.restoreGeometry(settings.read_bytes("window/geometry"))
        self.window.restoreState(settings.read_bytes("window/state"), VERSION)

    def keep(self, settings: Settings) -> None:
        settings.write_bytes("window/geometry", self.window.saveGeometry())
        settings.write_bytes("window/state", self.window.saveState(VERSION))
