"""Sensors: add from the library, duplicate, delete, show or hide."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu, QToolButton

from app.actions import Spec
from app.window.feature import Feature
from core.geometry import Pose, Vec3
from core.rig.library import default_library, sensor_from_model
from core.rig.model import Rig
from widgets.panels.icons import icon

if TYPE_CHECKING:
    from app.window.main_window import MainWindow

GAP_M = 0.15
SELECTED_ONLY = ("duplicate", "delete", "hide")


class Sensors(Feature):
    """What is done to whole sensors; `add_menus` are the library by kind."""

    specs = (
        Spec(
            "duplicate", "Duplicate", "Add a copy of the selected sensor", "Ctrl+D", "duplicate",
            "sensor/edit", "sensor",
        ),
        Spec("delete", "Delete", "Delete the selected sensor", "Del", "delete", "sensor/edit", "sensor"),
        Spec(
            "hide", "Show or hide", "Show or hide the selected sensor in the view", "H", "eye",
            "sensor/edit", "sensor",
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.add_menus = {kind: self._library_menu(kind) for kind in ("lidar", "camera")}
        for kind, menu in self.add_menus.items():
            window.places.add_to_menu("sensor/add", menu)
            window.places.add_to_toolbar("add", menu_button(kind, menu))
        for key in ("duplicate", "delete"):
            window.places.add_to_menu("edit/sensor", window.actions_[key])
        self.bind(duplicate=self.duplicate, delete=self.delete, hide=self.toggle_hidden)
        window.rig_shown.connect(self._update)

    def _library_menu(self, kind: Any) -> QMenu:
        menu = QMenu("Add LiDAR" if kind == "lidar" else "Add camera", self.window)
        menu.setIcon(icon(kind))
        menu.setToolTipsVisible(True)
        for entry in default_library().entries(kind):
            action = menu.addAction(entry.title, partial(self.add, entry.name))
            action.setToolTip(entry.source)
            action.setObjectName(entry.name)
        return menu

    def add(self, model: str) -> None:
        """Add a sensor of a library model above the roof and select it."""
        kind = default_library().entry(model).kind
        pose = Pose(free_place(self.document.rig, kind))
        self.window.guarded(self.document.add)(sensor_from_model(model, f"{kind}_1", pose))

    def duplicate(self) -> None:
        """Add a copy of the selected sensor."""
        if self.document.selected is not None:
            self.window.guarded(self.document.duplicate)(self.document.selected)

    def delete(self) -> None:
        """Delete the selected sensor."""
        if self.document.selected is not None:
            self.window.guarded(self.document.delete)(self.document.selected)

    def toggle_hidden(self) -> None:
        """Show or hide the selected sensor."""
        name = self.document.selected
        if name is not None:
            self.document.set_hidden(name, name not in self.document.hidden)

    def _update(self) -> None:
        document, actions = self.document, self.window.actions_
        for key in SELECTED_ONLY:
            actions[key].setEnabled(document.selected is not None)
        actions["hide"].setIcon(icon("eye-off" if document.selected in document.hidden else "eye"))


def menu_button(kind: str, menu: QMenu) -> QToolButton:
    """A toolbar button that opens the menu of sensor models of a kind."""
    button = QToolButton()
    button.setObjectName(f"add_{kind}")
    button.setIcon(icon(kind))
    button.setText("+ ▾")
    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    button.setToolTip(menu.title())
    button.setMenu(menu)
    button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    return button


def free_place(rig: Rig, kind: str) -> Vec3:
    """A place above the middle of the roof where no sensor is yet."""
    z = rig.vehicle.height + (0.35 if kind == "lidar" else 0.15)
    x = 0.0
    while any(math.dist(sensor.position, (x, 0.0, z)) < GAP_M for sensor in rig.sensors):
        x -= 2 * GAP_M
    return round(x, 3), 0.0, round(z, 3)
