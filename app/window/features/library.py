"""The library of sensor models, below the list of sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.window.feature import Feature
from riglens.app.window.features.sensors import Sensors
from riglens.core.rig.library import default_library
from riglens.widgets.panels.sensors.library import LibraryList

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class LibraryPanel(Feature):
    """Models to drag onto the car, or to add by a double click."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.list = LibraryList()
        once = Qt.ConnectionType.SingleShotConnection
        self.viewport.shown.connect(
            self._show, once
        )  # fifty rows with their figures: after the first picture
        window.theme_changed.connect(lambda _: self._show())
        self.list.add_wanted.connect(window.feature(Sensors).add)
        dock = window.add_dock("Library", self.list, Qt.DockWidgetArea.LeftDockWidgetArea)
        window.resizeDocks([window.docks["Sensors"], dock], [7, 3], Qt.Orientation.Vertical)

    def _show(self) -> None:
        """Show every model, in the colours of the theme."""
        self.list.set_entries(default_library().entries())
