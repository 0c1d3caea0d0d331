"""All keys and mouse gestures on one sheet: grouped, in two columns."""

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

from widgets.panels.style import MARGIN, as_panel, tones

GAP_PX = 36
COLUMN_PX, KEYS_PX = 530, 190
HIGHEST_PX = 740
HEADING_ROWS = 2
"""A heading takes the room of about two rows."""


@dataclass(frozen=True)
class Group:
    """A heading with rows of keys and what they do."""

    title: str
    rows: tuple[tuple[str, str], ...]

    @property
    def height(self) -> int:
        """Rows that it takes, its heading counted in."""
        return len(self.rows) + HEADING_ROWS


class ShortcutSheet(QDialog):
    """A sheet to read beside the work; Esc closes it."""

    def __init__(self, title: str, groups: Sequence[Group], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        sheet = QWidget()
        as_panel(sheet)
        columns = QHBoxLayout(sheet)
        columns.setContentsMargins(GAP_PX // 2, MARGIN, GAP_PX // 2, MARGIN)
        columns.setSpacing(GAP_PX)
        for column in in_two(groups):
            columns.addWidget(_column(column))
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
        self.resize(wanted.width() + 40, min(HIGHEST_PX, wanted.height() + 70))


def in_two(groups: Sequence[Group]) -> tuple[list[Group], list[Group]]:
    """The groups in their order, cut where both columns are most alike in height."""
    heights = [group.height for group in groups]
    cut = min(range(len(groups) + 1), key=lambda place: max(sum(heights[:place]), sum(heights[place:])))
    return list(groups[:cut]), list(groups[cut:])


def _column(groups: Sequence[Group]) -> QLabel:
    label = QLabel("".join(_html(group) for group in groups))
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setWordWrap(True)
    label.setFixedWidth(COLUMN_PX)
    label.setMinimumHeight(label.heightForWidth(COLUMN_PX))
    label.setAlignment(Qt.AlignmentFlag.AlignTop)
    return label


def _html(group: Group) -> str:
    rows = "".join(
        f'<tr><td width="{KEYS_PX}"><b>{escape(keys)}</b></td><td>{escape(what)}</td></tr>'
        for keys, what in group.rows
    )
    heading = f'<p style="color: {tones().accent}; margin-bottom: 2px"><b>{escape(group.title)}</b></p>'
    return f'{heading}<table cellpadding="1" width="{COLUMN_PX}">{rows}</table>'
