"""Every action of the window in one table: text, shortcut, icon, tooltip; menus, toolbar and help read it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu, QToolBar, QToolButton

from app.heatmap import HEAT_TITLES
from core.scene.boxes import CLASSES
from widgets.panels.icons import icon, swatch
from widgets.theme import CLASS_COLOURS


@dataclass(frozen=True)
class Spec:
    """One action; `group` makes it one choice out of several."""

    key: str
    text: str
    tip: str
    shortcut: str = ""
    icon: str = ""
    group: str = ""
    is_checkable: bool = False


SPECS = (
    Spec("open", "Open…", "Open a rig file", "Ctrl+O", "open"),
    Spec("save", "Save", "Save the rig to its file", "Ctrl+S", "save"),
    Spec("save_as", "Save as…", "Save the rig to another file", "Ctrl+Shift+S"),
    Spec("screenshot", "Screenshot…", "Save the 3D view as a PNG picture", "F12", "screenshot"),
    Spec("quit", "Quit", "Close the window", "Ctrl+Q"),
    Spec("undo", "Undo", "Take back the last change", "Ctrl+Z", "undo"),
    Spec("redo", "Redo", "Do again what was taken back", "Ctrl+Shift+Z", "redo"),
    Spec("duplicate", "Duplicate", "Add a copy of the selected sensor", "Ctrl+D", "duplicate"),
    Spec("delete", "Delete", "Delete the selected sensor", "Del", "delete"),
    Spec("hide", "Show or hide", "Show or hide the selected sensor in the view", "H", "eye"),
    Spec("move", "Move", "Arrows on the selected sensor", "W", "move", "gizmo"),
    Spec("rotate", "Rotate", "Rings on the selected sensor", "E", "rotate", "gizmo"),
    Spec("both", "Move and rotate", "Arrows and rings on the selected sensor", "Q", "both", "gizmo"),
    Spec(
        "local", "Local axes", "Along the sensor's own axes; off: along those of the car", "L", "axes",
        is_checkable=True,
    ),
    Spec("iso", "Corner", "View from a corner", "1"),
    Spec("top", "Top", "View from above", "2"),
    Spec("front", "Front", "View of the front", "3"),
    Spec("left", "Left", "View of the left side", "4"),
    Spec("rear", "Rear", "View of the rear", "5"),
    Spec("frame", "Frame selection", "Bring the selected sensor into the middle of the view", "F", "frame"),
    Spec("boxes_file", "Box file…", "Score on a CSV, CSV.gz or Parquet table of boxes"),
    Spec("boxes_folder", "Box folder…", "Score on a KITTI or CARLA folder"),
    Spec("help", "Shortcuts and mouse", "What keys and mouse buttons do", "F1"),
    Spec("about", "About RigLens", "What this program computes"),
)  # fmt: skip

VIEWS = ("iso", "top", "front", "left", "rear")


class Actions:
    """The window's actions by key; `bind` gives each what it does, and none stays without."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self._actions: dict[str, QAction] = {}
        self._groups: dict[str, QActionGroup] = {}
        for spec in SPECS:
            self._actions[spec.key] = self._make(spec)

    def __getitem__(self, key: str) -> QAction:
        return self._actions[key]

    def _make(self, spec: Spec) -> QAction:
        action = QAction(spec.text, self._window)
        action.setObjectName(spec.key)
        if spec.icon:
            action.setIcon(icon(spec.icon))
        if spec.shortcut:
            action.setShortcut(QKeySequence(spec.shortcut))
        shown = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        action.setToolTip(f"{spec.tip} ({shown})" if shown else spec.tip)
        action.setCheckable(spec.is_checkable or bool(spec.group))
        if spec.group:
            group = self._groups.setdefault(spec.group, QActionGroup(self._window))
            group.addAction(action)
        self._window.addAction(action)
        return action

    def bind(self, **slots: Callable[[], object]) -> None:
        """Connect actions by key."""
        for key, slot in slots.items():
            self._actions[key].triggered.connect(lambda _=False, slot=slot: slot())

    def fill(self, menu: QMenu | QToolBar, keys: str) -> None:
        """Add actions by key, separated by blanks; | is a separator."""
        for key in keys.split():
            if key == "|":
                menu.addSeparator()
            else:
                menu.addAction(self._actions[key])


class Choice(QToolButton):
    """A toolbar button with a menu of exclusive choices that shows the one in force."""

    def __init__(self, name: str, tip: str, choices: dict[str, QAction]) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setToolTip(tip)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = QMenu(self)
        group = QActionGroup(self)
        self._choices = choices
        for key, action in choices.items():
            action.setCheckable(True)
            action.setData(key)
            group.addAction(action)
            menu.addAction(action)
        self.setMenu(menu)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)

    def show_choice(self, key: str, caption: str, with_icon: bool = False) -> None:
        """Tick a choice and show it on the button."""
        action = self._choices[key]
        action.setChecked(True)
        self.setText(f"{caption} ▾")
        if with_icon:
            self.setIcon(action.icon())


def heat_actions(window: QMainWindow, chosen: Callable[[str], None]) -> dict[str, QAction]:
    """One action per heatmap mode."""
    actions: dict[str, QAction] = {}
    for mode, title in HEAT_TITLES.items():
        actions[mode] = QAction(title, window)
        actions[mode].triggered.connect(lambda _=False, mode=mode: chosen(mode))
    return actions


def class_actions(window: QMainWindow, chosen: Callable[[str], None]) -> dict[str, QAction]:
    """One action per traffic class."""
    actions = {}
    for name in CLASSES:
        actions[name] = QAction(swatch(CLASS_COLOURS[name]), name, window)
        actions[name].triggered.connect(lambda _=False, name=name: chosen(name))
    return actions


def shortcut_rows(actions: Actions) -> list[tuple[str, str]]:
    """Shortcut and what it does, for the help."""
    rows = []
    for spec in SPECS:
        shown = actions[spec.key].shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        if shown:
            rows.append((shown, spec.tip))
    return rows
