"""Every command by a few letters of its name: a field to type into, and the commands that fit, best first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QColor, QKeyEvent
from PySide6.QtWidgets import QDialog, QLineEdit, QTreeWidget, QTreeWidgetItem, QVBoxLayout, QWidget

from riglens.widgets.panels.controls.building import filled
from riglens.widgets.panels.controls.style import MARGIN, plain_tip, tones

WIDTH_PX, HEIGHT_PX, KEYS_PX = 560, 380, 150
MOST_SHOWN = 200
_MOVES = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)


@dataclass(frozen=True)
class Command:
    """An action with the menus that lead to it, such as ("Sensor", "Align"), and its keys."""

    title: str
    menus: tuple[str, ...]
    keys: str
    action: QAction

    @property
    def words(self) -> str:
        """The menus that lead to the command, and its title."""
        return " › ".join((*self.menus, self.title))


SYNONYMS = {
    "remove": "delete", "clone": "duplicate", "ruler": "measure", "zoom": "frame", "screenshot": "picture",
    "image": "picture", "reference": "baseline", "pin": "baseline", "blind": "test objects", "fov": "fields of view",
    "range": "detection", "failure": "redundancy", "coverage": "heatmap", "hotkeys": "shortcuts", "keys": "shortcuts",
    "undock": "panels", "dock": "panels", "flip": "mirror", "colours": "theme",
}  # fmt: skip
"""Words of other programs and of trade for words of the menus."""
NOTHING_FOUND = "Nothing found: try another word"


def fitting(commands: Sequence[Command], typed: str) -> list[Command]:
    """Return the commands that say every typed word, else its synonym, else in their tooltips; those that can be chosen
    first, then by their title."""
    parts = typed.casefold().split()
    meant = [SYNONYMS.get(part, part) for part in parts]
    for words, are_tips in ((parts, False), (meant, False), (meant, True)):
        found = [command for command in commands if all(word in _said(command, are_tips) for word in words)]
        if found:
            return sorted(found, key=lambda command: (not command.action.isEnabled(), _rank(command, words)))
    return []


def _said(command: Command, with_tip: bool) -> str:
    return f"{command.words}\n{command.action.toolTip() if with_tip else ''}".casefold()


def _rank(command: Command, parts: Sequence[str]) -> int:
    """Return how far from the beginning of the title the typed words are; 0 is best."""
    title = command.title.casefold()
    if not parts or title.startswith(parts[0]):
        return 0
    if any(word.startswith(parts[0]) for word in title.split()):
        return 1
    return 2 if parts[0] in title else 3


class CommandPalette(QDialog):
    """Type, choose with the arrow keys, Return runs, Esc closes."""

    def __init__(self, commands: Sequence[Command], parent: QWidget | None = None) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._commands = commands
        self.typed = QLineEdit()
        self.typed.setPlaceholderText("Search commands, sensor models, presets, views…")
        self.typed.textChanged.connect(self._show)
        self.typed.installEventFilter(self)
        self.rows = QTreeWidget()
        self.rows.setColumnCount(2)
        self.rows.setHeaderHidden(True)
        self.rows.setRootIsDecorated(False)
        self.rows.setUniformRowHeights(True)
        self.rows.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.rows.setColumnWidth(0, WIDTH_PX - KEYS_PX)
        self.rows.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.rows.itemClicked.connect(lambda _: self.run())
        filled(QVBoxLayout(self), self.typed, self.rows, margins=(MARGIN,) * 4)
        self._found: list[Command] = []
        self._show("")
        self.resize(WIDTH_PX, HEIGHT_PX)
        if parent is not None:
            top = parent.mapToGlobal(parent.rect().center())
            self.move(top.x() - WIDTH_PX // 2, parent.mapToGlobal(parent.rect().topLeft()).y() + 60)
        self.typed.setFocus()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Have arrow keys move in the list and Return run, while the field keeps the focus."""
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress:
            if event.key() in _MOVES:
                self.rows.keyPressEvent(event)
                return True
            if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
                self.run()
                return True
        return super().eventFilter(watched, event)

    def run(self) -> None:
        """Close, and run the current row; disabled ones do nothing."""
        place = self.rows.currentIndex().row()
        if 0 <= place < len(self._found) and self._found[place].action.isEnabled():
            action = self._found[place].action
            self.close()
            action.trigger()

    def _show(self, typed: str) -> None:
        self._found = fitting(self._commands, typed)[:MOST_SHOWN]
        self.rows.clear()
        for command in self._found:
            row = QTreeWidgetItem([command.words, command.keys])
            row.setToolTip(0, plain_tip(command.action.toolTip()))
            row.setForeground(1, QColor(tones().muted))
            if not command.action.isEnabled():
                row.setForeground(0, QColor(tones().muted))
            self.rows.addTopLevelItem(row)
        if not self._found:
            nothing = QTreeWidgetItem([NOTHING_FOUND])
            nothing.setDisabled(True)
            self.rows.addTopLevelItem(nothing)
        else:
            self.rows.setCurrentIndex(self.rows.model().index(0, 0))
