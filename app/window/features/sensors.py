"""Sensors: add from the library; duplicate, delete, show, hide, enable, lock and rename what is selected."""

from __future__ import annotations

import math
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import Spec, menu_button
from riglens.app.window.feature import Feature
from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.library import Entry, default_library, sensor_from_model
from riglens.core.rig.model import Rig
from riglens.widgets.panels.icons import icon

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

GAP_M = 0.15
SELECTED_ONLY = ("duplicate", "delete", "hide", "enable", "lock", "rename")


class Sensors(Feature):
    """What is done to whole sensors; `add_menus` are the library by kind and maker."""

    specs = (
        Spec(
            "duplicate", "Duplicate", "Add copies of the selected sensors", "Ctrl+D", "duplicate",
            "sensor/edit", "sensor",
        ),
        Spec("delete", "Delete", "Delete the selected sensors", "Del", "delete", "sensor/edit", "sensor"),
        Spec(
            "hide", "Show or hide", "Show or hide the selected sensors in the view", "H", "eye",
            "sensor/edit", "sensor",
        ),
        Spec(
            "enable", "Count or not", "Count the selected sensors in the scores, or not", "Ctrl+E",
            menu="sensor/edit",
        ),
        Spec(
            "lock", "Lock or unlock", "Guard the selected sensors against dragging, editing and deleting",
            "Ctrl+L", "lock", "sensor/edit",
        ),
        Spec("rename", "Rename", "Give the selected sensor another name", "F2", menu="sensor/edit"),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.add_menus = {kind: self._library_menu(kind) for kind in ("lidar", "camera")}
        for kind, menu in self.add_menus.items():
            window.places.add_to_menu("sensor/add", menu)
            window.places.add_to_toolbar("add", menu_button(f"add_{kind}", kind, menu.title(), menu, "+ ▾"))
        for key in ("duplicate", "delete"):
            window.places.add_to_menu("edit/sensor", window.actions_[key])
        self.bind(
            duplicate=self.duplicate,
            delete=self.delete,
            hide=self.toggle_hidden,
            enable=self.toggle_enabled,
            lock=self.toggle_locked,
            rename=window.tree.rename_selected,
        )
        window.rig_shown.connect(self._update)
        window.tree.menu_wanted.connect(self._fill_menu)

    def _library_menu(self, kind: Any) -> QMenu:
        menu = QMenu("Add LiDAR" if kind == "lidar" else "Add camera", self.window)
        menu.setIcon(icon(kind))
        menu.setToolTipsVisible(True)
        for maker, entries in default_library().by_maker(kind).items():
            of_maker = QMenu(maker, menu)
            of_maker.setToolTipsVisible(True)
            menu.addMenu(of_maker)
            for entry in entries:
                action = of_maker.addAction(entry.title, partial(self.add, entry.name))
                action.setToolTip(entry_tip(entry))
                action.setObjectName(entry.name)
        return menu

    def add(self, model: str) -> None:
        """Add a sensor of a library model above the roof and select it."""
        kind = default_library().entry(model).kind
        pose = Pose(free_place(self.document.rig, kind))
        self.window.guarded(self.document.add)(sensor_from_model(model, f"{kind}_1", pose))

    def duplicate(self) -> None:
        """Add copies of the selected sensors and select those."""
        if self.window.tree.chosen:
            self.window.guarded(self._duplicate)(self.window.tree.chosen)

    def _duplicate(self, names: tuple[str, ...]) -> None:
        self.window.tree.choose(self.document.duplicate(names))

    def delete(self) -> None:
        """Delete the selected sensors, as one step."""
        if self.window.tree.chosen:
            self.window.guarded(self.document.delete)(self.window.tree.chosen)

    def toggle_hidden(self) -> None:
        """Show the selected sensors if all are hidden, else hide them."""
        chosen = self.window.tree.chosen
        self.document.set_hidden(chosen, not self.document.hidden.issuperset(chosen))

    def toggle_enabled(self) -> None:
        """Let the selected sensors count if none does, else none, as one step."""
        chosen = self.window.tree.chosen
        counted = any(self.document.rig.sensor(name).enabled for name in chosen)
        if chosen:
            self.window.guarded(self.document.set_enabled)(chosen, not counted)

    def toggle_locked(self) -> None:
        """Unlock the selected sensors if all are locked, else lock them."""
        chosen = self.window.tree.chosen
        self.document.set_locked(chosen, not self.document.locked.issuperset(chosen))

    def _fill_menu(self, menu: QMenu) -> None:
        """What the sensor menu offers for a selection, in the list's context menu, too."""
        for key in ("rename", "duplicate", "mirror", "place", "copy", "delete", "frame"):
            menu.addAction(self.window.actions_[key])

    def _update(self) -> None:
        document, actions = self.document, self.window.actions_
        for key in SELECTED_ONLY:
            actions[key].setEnabled(document.selected is not None)
        if document.selected in document.locked:
            actions["delete"].setEnabled(not document.locked.issuperset(self.window.tree.chosen))
            actions["rename"].setEnabled(False)
        actions["hide"].setIcon(icon("eye-off" if document.selected in document.hidden else "eye"))


def entry_tip(entry: Entry) -> str:
    """What a model is known from, wrapped."""
    note = f"<p>{escape(entry.note)}</p>" if entry.note else ""
    return f"<p>{escape(entry.source)}</p>{note}"


def free_place(rig: Rig, kind: str) -> Vec3:
    """A place above the middle of the roof where no sensor is yet."""
    z = rig.vehicle.height + (0.35 if kind == "lidar" else 0.15)
    x = 0.0
    while any(math.dist(sensor.position, (x, 0.0, z)) < GAP_M for sensor in rig.sensors):
        x -= 2 * GAP_M
    return round(x, 3), 0.0, round(z, 3)
