"""What the heatmap shows, and of which class of traffic."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from PySide6.QtCore import Qt

from app.actions import Choice, class_actions, heat_actions
from app.heatmap import HEAT_TITLES, HeatMode
from app.window.feature import Feature
from app.window.settings import Settings
from core.scene.boxes import CLASSES

if TYPE_CHECKING:
    from app.window.main_window import MainWindow


class Heat(Feature):
    """Two choices in the toolbar; `mode` and `class_name` are what evaluations ask for."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.mode: HeatMode = "probability"
        self.class_name = CLASSES[0]
        self._modes = Choice("heatmap", "What the heatmap shows", heat_actions(window, self.set_mode))
        self._classes = Choice(
            "class", "Class of traffic of heatmap and map", class_actions(window, self.set_class)
        )
        self._classes.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        window.places.add_to_toolbar("heat", self._modes)
        window.places.add_to_toolbar("heat", self._classes)
        self._show()

    def set_mode(self, mode: str) -> None:
        """Choose what the heatmap shows: a key of HEAT_TITLES."""
        self.mode = cast(HeatMode, mode)
        self._show()
        self.window.settings_changed.emit()

    def set_class(self, name: str) -> None:
        """Choose the class of traffic that the heatmap is about."""
        self.class_name = name
        self._show()
        self.window.settings_changed.emit()

    def restore(self, settings: Settings) -> None:
        mode, name = settings.read("heat/mode", self.mode), settings.read("heat/class", self.class_name)
        self.mode = mode if mode in HEAT_TITLES else self.mode
        self.class_name = name if name in CLASSES else self.class_name
        self._show()

    def keep(self, settings: Settings) -> None:
        settings.write("heat/mode", self.mode)
        settings.write("heat/class", self.class_name)

    def _show(self) -> None:
        self._modes.show_choice(self.mode, f"Heatmap: {HEAT_TITLES[self.mode]}")
        self._classes.show_choice(self.class_name, self.class_name, with_icon=True)
