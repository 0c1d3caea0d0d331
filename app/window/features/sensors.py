"""Sensors: added from the library, put onto the car, and edited as a whole; which of them are locked."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from html import escape
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu

from riglens.app.session.document import Document
from riglens.app.window.actions import Spec, menu_button
from riglens.app.window.feature import Feature
from riglens.app.window.settings import Settings
from riglens.app.window.status import TOLD_MS
from riglens.app.window.workbench import Workbench
from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.edits import partner_of
from riglens.core.rig.library import Entry, default_library, sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.sensors.registry import AnyKind, kind_of, kinds, shown_kinds
from riglens.core.shown_text import visible
from riglens.core.vehicle.placing import PlacingRules
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.sensors.library import LibraryList

LOW_PX = 640
"""In a window lower than this the library has no room below the list of sensors."""
GAP_M = 0.15
HINT = (
    "Click on the car to put {name} there; Alt tilts it with the surface; Ctrl snaps to the grid and the centre line; "
    "Esc leaves it where it was."
)
RULES = {"place_upright": True, "place_below_rails": False}
"""Ways to put sensors on the car, and whether they are in use at first."""
IN_PLACE = "Copies of mirror pairs are linked and coincide with the originals: drag them away."
NONE_SELECTED, ONE_ONLY = "No sensor is selected.", "Select one sensor only."
LOCKED_KEY = "sensors/locked"
MOST_FILES = 100
"""Number of rig files whose locked sensors are remembered."""
SELECTED_ONLY, FREE_ONLY = ("duplicate", "hide", "lock"), ("delete", "enable")


class Sensors(Feature):
    """Actions on whole sensors; `add_menus` are the library by kind and maker."""

    specs = (
        Spec(
            "duplicate", "Duplicate", "Add copies of the selected sensors.", "Ctrl+D", "duplicate", "sensor/edit",
        ),
        Spec("delete", "Delete", "Delete the selected sensors.", "Del", "delete", "sensor/edit"),
        Spec(
            "hide", "Show or hide", "Show or hide the selected sensors in the view.", "H", "eye", "sensor/edit",
        ),
        Spec(
            "select_all", "Select all", "Select every sensor; Ctrl- or Shift-click adds or removes one.",
            "Ctrl+A", menu="edit/clipboard",
        ),
        Spec(
            "enable", "Include in scores", "Include the selected sensors in the scores, or exclude them.", "Ctrl+E",
            menu="sensor/edit",
        ),
        Spec(
            "lock", "Lock or unlock", "Protect the selected sensors from dragging, editing and deleting.",
            "Ctrl+L", "lock", "sensor/edit",
        ),
        Spec("rename", "Rename", "Rename the selected sensor.", "F2", menu="sensor/edit"),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.add_menus = {
            kind.name: self._library_menu(kind) for kind in kinds() if default_library().entries(kind.name)
        }
        in_toolbar = [kind.name for kind in shown_kinds(())]  # a narrow window has no room for more
        for kind, menu in self.add_menus.items():
            bench.places.add_to_menu("sensor/add", menu)
            if kind in in_toolbar:
                bench.places.add_to_toolbar("add", menu_button(f"add_{kind}", kind, menu.title(), menu, "+"))
        for key in ("duplicate", "delete"):
            bench.places.add_to_menu("edit/sensor", self.actions[key])
        self.bind(
            duplicate=self.duplicate,
            delete=self.delete,
            select_all=self.document.choose_all,
            hide=self.toggle_hidden,
            enable=self.toggle_enabled,
            lock=self.toggle_locked,
            rename=bench.panels.tree.rename_selected,
        )
        follow_marks(self.document, self._update)
        bench.panels.tree.menu_wanted.connect(self._fill_menu)

    def _library_menu(self, kind: AnyKind) -> QMenu:
        menu = QMenu(f"Add {kind.title}", self.bench.window)
        menu.setIcon(icon(kind.name))
        menu.setToolTipsVisible(True)
        for maker, entries in default_library().by_maker(kind.name).items():
            of_maker = QMenu(maker, menu)
            of_maker.setToolTipsVisible(True)
            menu.addMenu(of_maker)
            for entry in entries:
                action = add_entry(of_maker, entry.title, partial(self.add, entry.name))
                action.setToolTip(entry_tip(entry))
                action.setObjectName(entry.name)
        return menu

    def add(self, model: str) -> None:
        """Add a sensor of a library model above the roof and select it."""
        sensor = sensor_from_model(model, f"{default_library().entry(model).kind}_1", Pose())
        place = free_place(self.document.rig, kind_of(sensor).placement.above_roof_m)
        self.bench.guarded(self.document.add)(sensor.with_pose(Pose(place)))

    def duplicate(self) -> None:
        """Add copies of the selected sensors and select those."""
        if self.document.chosen:
            self.bench.guarded(self.document.duplicate)(self.document.chosen)
            rig = self.document.rig
            if any(partner_of(rig, name) in self.document.selection for name in self.document.selection):
                self.bench.status.showMessage(IN_PLACE, TOLD_MS)

    def delete(self) -> None:
        """Delete the selected sensors as one step."""
        if self.document.chosen:
            self.bench.guarded(self.document.delete)(self.document.chosen)

    def toggle_hidden(self) -> None:
        """Show the selected sensors if all are hidden, else hide them."""
        chosen = self.document.chosen
        self.document.set_hidden(chosen, not self.document.hidden.issuperset(chosen))

    def toggle_enabled(self) -> None:
        """Include the selected sensors in the scores if none is, else exclude all, as one step."""
        chosen = self.document.chosen
        counted = any(self.document.rig.sensor(name).enabled for name in chosen)
        if chosen:
            self.bench.guarded(self.document.set_enabled)(chosen, not counted)

    def toggle_locked(self) -> None:
        """Unlock the selected sensors if all are locked, else lock them."""
        chosen = self.document.chosen
        self.document.set_locked(chosen, not self.document.locked.issuperset(chosen))

    def _fill_menu(self, menu: QMenu) -> None:
        """Fill the sensor menu for a selection; also used as the list's context menu."""
        for key in ("rename", "duplicate", "mirror", "unlink", "place", "copy", "delete", "frame"):
            menu.addAction(self.actions[key])

    def _update(self) -> None:
        document, actions = self.document, self.actions
        chosen = document.chosen
        for key in SELECTED_ONLY:
            actions.allow(key, "" if chosen else NONE_SELECTED)
        hold = hold_of(document)
        for key in FREE_ONLY:
            actions.allow(key, hold)
        actions.allow("select_all", "" if document.rig.sensors else "The rig has no sensors.")
        actions.allow("rename", hold or ("" if len(chosen) == 1 else ONE_ONLY))
        all_hidden = bool(chosen) and document.hidden.issuperset(chosen)
        actions["hide"].setIcon(icon("eye-off" if all_hidden else "eye"))


def hold_of(document: Document) -> str:
    """Return why the selected sensors cannot be moved or removed, one sentence; empty if they can."""
    fixed = document.fixed
    locked = [name for name in document.chosen if name in fixed]
    if locked:
        name = visible(locked[0])
        which = name if locked[0] in document.locked else f"The mirror image of {name}"
        return f"{which} is locked: unlock it in the list of sensors."
    return "" if document.is_free else NONE_SELECTED


def follow_marks(document: Document, update: Callable[[], None]) -> None:
    """Call this now, and whenever another sensor is selected, or others are hidden or locked."""
    for changed in (
        document.selection_changed, document.hidden_changed, document.locked_changed, document.rig_settled,
    ):  # fmt: skip
        changed.connect(update)
    update()


def entry_tip(entry: Entry) -> str:
    """Return the source of a model's figures, wrapped."""
    return "".join(f"<p>{escape(part)}</p>" for part in (entry.source, entry.note, entry.caveat()) if part)


def free_place(rig: Rig, above_roof_m: float) -> Vec3:
    """Return a free place that far above the middle of the roof."""
    z = rig.vehicle.height + above_roof_m
    x = 0.0
    while any(math.dist(sensor.position, (x, 0.0, z)) < GAP_M for sensor in rig.sensors):
        x -= 2 * GAP_M
    return round(x, 3), 0.0, round(z, 3)


class LibraryPanel(Feature):
    """Models to drag onto the car, or to add by a double click."""

    def __init__(self, bench: Workbench, sensors: Sensors) -> None:
        super().__init__(bench)
        self.list = LibraryList()
        once = Qt.ConnectionType.SingleShotConnection
        self.viewport.shown.connect(self._begin, once)  # a hundred rows: after the first picture
        self.list.add_wanted.connect(sensors.add)
        self._add_dock()

    def _add_dock(self) -> None:
        """Place the library below the larger list of sensors, in a low window as a tab of it."""
        docks, area = self.bench.docks, Qt.DockWidgetArea.LeftDockWidgetArea
        if self.bench.window.height() < LOW_PX:
            docks.add("Library", self.list, area, beside="Sensors")
            return
        dock = docks.add("Library", self.list, area)
        self.bench.window.resizeDocks([docks["Sensors"], dock], [3, 1], Qt.Orientation.Vertical)

    def _begin(self) -> None:
        self._show()
        self.bench.theme_changed.connect(lambda _: self._show())

    def _show(self) -> None:
        """Show every model, in the colours of the theme."""
        self.list.set_entries(default_library().entries())


class Placing(Feature):
    """Place on body, drops of library models, and arrow keys in the view."""

    specs = (
        Spec(
            "place", "Place on body", "Move the selected sensor with the mouse over the car until a click.",
            "P", "place", "sensor/place", "place", is_checkable=True,
        ),
        Spec(
            "place_upright", "Keep upright",
            "Keep sensors level when they are put on the car; Alt then tilts them with the surface.",
            menu="sensor/place", is_checkable=True,
        ),
        Spec(
            "place_below_rails", "Ignore roof rails", "Put sensors on the roof under rails, bars and aerials.",
            menu="sensor/place", is_checkable=True,
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        for key, is_used in RULES.items():
            self.actions[key].setChecked(is_used)
        self._set_rules()
        self.bind(place=self.place, place_upright=self._set_rules, place_below_rails=self._set_rules)
        self.viewport.placing_changed.connect(self._show)
        self.viewport.model_dropped.connect(bench.guarded(self.add))
        self.viewport.nudged.connect(bench.guarded(self.document.move))
        follow_marks(self.document, self._update)

    def place(self) -> None:
        """Start placing the selected sensor, or stop."""
        action = self.actions["place"]
        if not action.isChecked():
            self.viewport.cancel_drag()
        elif self.document.selected is None or not self.viewport.begin_placing():
            action.setChecked(False)

    def restore(self, settings: Settings) -> None:
        for key in RULES:
            self.actions[key].setChecked(settings.read(f"placing/{key}", RULES[key]))
        self._set_rules()

    def keep(self, settings: Settings) -> None:
        for key in RULES:
            settings.write(f"placing/{key}", self.actions[key].isChecked())

    def _set_rules(self) -> None:
        """Pass the ticked mounting options to the view."""
        upright, below_rails = (self.actions[key].isChecked() for key in RULES)
        placing = PlacingRules(upright=upright, below_rails=below_rails)
        self.viewport.show_state(replace(self.viewport.state, placing=placing))

    def add(self, model: str, pose: Pose) -> None:
        """Add a sensor of a library model at a pose and select it."""
        name = f"{default_library().entry(model).kind}_1"
        self.document.add(sensor_from_model(model, name, pose))

    def _show(self, active: bool) -> None:
        self.actions["place"].setChecked(active)
        if active:
            self.bench.status.showMessage(HINT.format(name=visible(self.document.selected or "")))
        else:
            self.bench.status.clearMessage()

    def _update(self) -> None:
        hidden = self.document.selected in self.document.hidden
        is_one = len(self.document.selection) == 1
        obstacle = hold_of(self.document) or ("" if is_one else ONE_ONLY)
        self.actions.allow("place", obstacle or ("The sensor is hidden." if hidden else ""))


class Locks(Feature):
    """Locked sensors by the path of the rig file, in the settings: a rig file holds no locks.

    A rig that was never saved has no path, so its locks end with the session.
    """

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.document.opened.connect(self._lock_again)
        self.document.locked_changed.connect(self._note)
        self.document.file_changed.connect(self._note)

    def restore(self, settings: Settings) -> None:
        self._lock_again()

    def _lock_again(self) -> None:
        """Lock what was locked when this file was open last."""
        if self.document.path is not None:
            names = self._kept().get(str(self.document.path.absolute()), [])
            self.document.keep_locked(tuple(name for name in names if isinstance(name, str)))

    def _note(self) -> None:
        path, settings = self.document.path, self.bench.kept
        if path is None:
            return
        settings.sync()  # another window may have locked sensors too
        kept, key, names = self._kept(), str(path.absolute()), sorted(self.document.locked)
        if kept.get(key, []) == names:
            return
        kept.pop(key, None)
        newest = {key: names} if names else {}
        settings.write(LOCKED_KEY, newest | dict(list(kept.items())[: MOST_FILES - 1]))
        settings.sync()

    def _kept(self) -> dict[str, list[Any]]:
        """Return names by path, the file locked last first."""
        found = self.bench.kept.read(LOCKED_KEY, {})
        return {path: names for path, names in found.items() if isinstance(names, list)}
