"""A table cell with a thin bar under its number, to compare the numbers of a column at a glance."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, Qt
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import QStyle, QStyledItemDelegate, QStyleOptionViewItem

from riglens.widgets.panels.style import tones

BAR_SHARE = Qt.ItemDataRole.UserRole.value + 1
"""Length of the bar, 0 to 1 of the cell; None for no bar."""
BAR_COLOUR = Qt.ItemDataRole.UserRole.value + 2
"""Its colour as `#rrggbb`; None for the accent colour."""
_BAR_PX, _MARGIN_PX = 3, 5


class BarDelegate(QStyledItemDelegate):
    """Draws the cell as usual, then a bar from the right, where the numbers end."""

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Draw number and bar."""
        super().paint(painter, option, index)
        share = index.data(BAR_SHARE)
        if not isinstance(share, float) or not share > 0.0:
            return
        rect: QRect = option.rect  # type: ignore[attr-defined]
        state: QStyle.StateFlag = option.state  # type: ignore[attr-defined]
        length = max(1, round((rect.width() - 2 * _MARGIN_PX) * min(share, 1.0)))
        is_selected = bool(state & QStyle.StateFlag.State_Selected)
        colour = QColor("white" if is_selected else index.data(BAR_COLOUR) or tones().accent)
        left = rect.right() - _MARGIN_PX - length
        painter.fillRect(left, rect.bottom() - _BAR_PX, length, _BAR_PX - 1, colour)
