"""Actions of the window from specs: text, shortcut, icon, tooltip, place; menus, toolbar and help read them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu, QToolButton

from riglens.widgets.panels.controls.icons import icon

if TYPE_CHECKING:
    from riglens.app.window.places import Places


@dataclass(frozen=True)
class Spec:
    """One action; `group` makes it one choice out of several.

    `shortcut` may name several keys ("?; F1"). `menu` is its place in the menus ("file/open"), `tool` its section
    of the toolbar; both are listed in app/window/places.py. A menu alone ("view") is for an action that its
    feature puts into a submenu there.
    """

    key: str
    text: str
    tip: str
    shortcut: str = ""
    icon: str = ""
    menu: str = ""
    tool: str = ""
    group: str = ""
    is_checkable: bool = False


class Actions:
    """Actions of the window by key, in the order in which features add them; `bind` connects each to its function."""

    def __init__(self, window: QMainWindow, places: Places) -> None:
        self._window = window
        self._places = places
        self._actions: dict[str, QAction] = {}
        self._groups: dict[str, QActionGroup] = {}
        self._tips: dict[str, str] = {}
        self.specs: tuple[Spec, ...] = ()

    def __getitem__(self, key: str) -> QAction:
        return self._actions[key]

    def __iter__(self) -> Iterator[QAction]:
        return iter(self._actions.values())

    def add(self, specs: Iterable[Spec]) -> None:
        """Make actions and put them where their specs say."""
        for spec in specs:
            action = self._actions[spec.key] = self._make(spec)
            self.specs += (spec,)
            if "/" in spec.menu:
                self._places.add_to_menu(spec.menu, action)
            if spec.tool:
                self._places.add_to_toolbar(spec.tool, action)

    def _make(self, spec: Spec) -> QAction:
        action = QAction(spec.text, self._window)
        action.setObjectName(spec.key)
        if spec.icon:
            action.setIcon(icon(spec.icon))
        if spec.shortcut:
            action.setShortcuts(QKeySequence.listFromString(spec.shortcut))
        shown = shortcut_text(action)
        self._tips[spec.key] = f"{spec.tip} ({shown})" if shown else spec.tip
        action.setToolTip(self._tips[spec.key])
        action.setCheckable(spec.is_checkable or bool(spec.group))
        if spec.group:
            group = self._groups.setdefault(spec.group, QActionGroup(self._window))
            group.addAction(action)
        self._window.addAction(action)
        return action

    def allow(self, key: str, obstacle: str = "") -> None:
        """Enable an action, or disable it and say in its tooltip what is in the way, one sentence."""
        self[key].setEnabled(not obstacle)
        self[key].setToolTip("\n".join(filter(None, (self._tips[key], obstacle))))

    def keys(self, key: str) -> str:
        """Return the shortcuts of an action as a user reads them, empty when it has none."""
        return shortcut_text(self._actions[key])

    def bind(self, **slots: Callable[[], object]) -> None:
        """Connect actions by key."""
        for key, slot in slots.items():
            self._actions[key].triggered.connect(lambda _=False, slot=slot: slot())


def shortcut_text(action: QAction) -> str:
    """Return all shortcuts of an action in the system's notation."""
    return QKeySequence.listToString(action.shortcuts(), QKeySequence.SequenceFormat.NativeText).replace(
        ";", " or"
    )


def menu_button(name: str, picture: str, tip: str, menu: QMenu, text: str = "") -> QToolButton:
    """Return a toolbar button that opens a menu."""
    button = QToolButton()
    button.setObjectName(name)
    if picture:
        button.setIcon(icon(picture))
    button.setText(text)
    if text:
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    button.setToolTip(tip)
    button.setMenu(menu)
    button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    return button


class Choice(QToolButton):
    """A toolbar button with a menu of exclusive choices that shows the one in force."""

    def __init__(self, name: str, tip: str, choices: dict[str, QAction]) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setToolTip(tip)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._choices = choices
        menu = QMenu(self)
        menu.addActions(list(choices.values()))
        self.setMenu(menu)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)

    def keep_room(self, captions: Iterable[str]) -> None:
        """Stay as wide as the longest of these captions, so that a choice moves nothing else in the toolbar."""
        self.ensurePolished()
        wide = self.fontMetrics().horizontalAdvance
        longer_px = max(wide(f"{caption} ▾") for caption in captions) - wide(self.text())
        self.setMinimumWidth(self.sizeHint().width() + longer_px)

    def show_choice(self, key: str, caption: str, with_icon: bool = False) -> None:
        """Tick a choice and show it on the button."""
        action = self._choices[key]
        action.setChecked(True)
        self.setText(f"{caption} ▾")
        if with_icon:
            self.setIcon(action.icon())
