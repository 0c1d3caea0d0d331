"""All actions with their keys, and mouse gestures, on one sheet: grouped, in columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from PySide6.QtCore import Qt
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from riglens.widgets.panels.controls.building import room_around
from riglens.widgets.panels.controls.style import MARGIN, as_panel, tones

GAP_PX = 18
COLUMN_PX, KEYS_PX = 286, 92
LAST_PX, LAST_KEYS_PX = 292, 136
MOST_COLUMNS = 3
HIGHEST_PX = 740
HEADING_ROWS = 2
"""A heading takes the space of about two rows."""


@dataclass(frozen=True)
class Group:
    """A heading with rows of keys and what they do."""

    title: str
    rows: tuple[tuple[str, str], ...]

    @property
    def height(self) -> int:
        """Rows that it takes, including its heading."""
        return len(self.rows) + HEADING_ROWS


class ShortcutSheet(QDialog):
    """Sheet of shortcuts; Esc closes it."""

    def __init__(self, title: str, groups: Sequence[Group], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        sheet = QWidget()
        as_panel(sheet)
        columns = QHBoxLayout(sheet)
        columns.setContentsMargins(GAP_PX // 2, MARGIN, GAP_PX // 2, MARGIN)
        columns.setSpacing(GAP_PX)
        room = room_around(self)
        beside_last = (room.width() - LAST_PX - 2 * GAP_PX) // (COLUMN_PX + GAP_PX)
        for column in in_columns(groups[:-1], min(max(beside_last, 1), MOST_COLUMNS)):
            columns.addWidget(_column(column, COLUMN_PX, KEYS_PX))
        columns.addWidget(_column(groups[-1:], LAST_PX, LAST_KEYS_PX))
        area = QScrollArea()
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidgetResizable(True)
        area.setWidget(sheet)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.button(QDialogButtonBox.StandardButton.Close).setIcon(QIcon())
        buttons.rejected.connect(self.reject)
        outer = QVBoxLayout(self)
        outer.addWidget(area)
        outer.addWidget(buttons)
        wanted = sheet.sizeHint()
        self.resize(
            min(room.width(), wanted.width() + 40), min(room.height(), HIGHEST_PX, wanted.height() + 70)
        )


def in_columns(groups: Sequence[Group], count: int) -> list[list[Group]]:
    """Return the groups in order, in at most `count` columns, divided so that the tallest is as short as possible."""
    height = max((group.height for group in groups), default=0)
    while len(columns := _filled(groups, height)) > count:
        height += 1
    return columns


def _filled(groups: Sequence[Group], height: int) -> list[list[Group]]:
    """Return columns of at most that height, each filled with as many groups as fit."""
    columns: list[list[Group]] = []
    for group in groups:
        if not columns or sum(other.height for other in columns[-1]) + group.height > height:
            columns.append([])
        columns[-1].append(group)
    return columns


def _column(groups: Sequence[Group], width_px: int, keys_px: int) -> QLabel:
    label = QLabel("".join(_html(group, width_px, keys_px) for group in groups))
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setWordWrap(True)
    label.setFixedWidth(width_px)
    label.setMinimumHeight(label.heightForWidth(width_px))
    label.setAlignment(Qt.AlignmentFlag.AlignTop)
    return label


def _html(group: Group, width_px: int, keys_px: int) -> str:
    rows = "".join(
        f'<tr><td width="{keys_px}"><b>{escape(keys)}</b></td><td>{escape(what)}</td></tr>'
        for keys, what in group.rows
    )
    heading = f'<p style="color: {tones().accent}; margin-bottom: 2px"><b>{escape(group.title)}</b></p>'
    return f'{heading}<table cellpadding="1" width="{width_px}">{rows}</table>'
