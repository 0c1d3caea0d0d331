"""Share behaviour of lists and tables: context menus, keys of their own, bars under numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QEvent, QModelIndex, QObject, QPersistentModelIndex, QPoint, QRect, Qt
from PySide6.QtGui import QColor, QKeyEvent, QKeySequence, QPainter
from PySide6.QtWidgets import (
    QAbstractItemView,
    QMenu,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from riglens.widgets.panels.controls.style import tones


def give_context_menu(view: QAbstractItemView, make: Callable[[], QMenu]) -> None:
    """Let a right click or the menu key open the menu that `make` builds; it is deleted when closed."""

    def open_menu(position: QPoint) -> None:
        menu = make()
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(view.viewport().mapToGlobal(position))

    view.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
    view.customContextMenuRequested.connect(open_menu)


StandardKey = QKeySequence.StandardKey


class OwnKeys(QObject):
    """Event filter with a function per key. A QShortcut of the panel would conflict with an action of the window."""

    def __init__(self, panel: QWidget, slots: Mapping[StandardKey, Callable[[], object]]) -> None:
        super().__init__(panel)
        self._slots = dict(slots)
        panel.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Claim the keys first, then act on them."""
        if isinstance(event, QKeyEvent) and event.type() in (
            QEvent.Type.ShortcutOverride,
            QEvent.Type.KeyPress,
        ):
            for key, slot in self._slots.items():
                if event.matches(key):
                    event.accept()
                    if event.type() == QEvent.Type.KeyPress:
                        slot()
                    return True
        return False


BAR_SHARE = Qt.ItemDataRole.UserRole.value + 1
"""Length of the bar, 0 to 1 of the cell; None for no bar."""
BAR_COLOUR = Qt.ItemDataRole.UserRole.value + 2
"""Its colour as `#rrggbb`; None for the accent colour."""
_BAR_PX, _MARGIN_PX = 3, 5


class BarDelegate(QStyledItemDelegate):
    """Delegate that draws the cell as usual, then a bar from the right, where the numbers end."""

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
        rect: QRect = option.rect
        state: QStyle.StateFlag = option.state
        length = max(1, round((rect.width() - 2 * _MARGIN_PX) * min(share, 1.0)))
        is_selected = bool(state & QStyle.StateFlag.State_Selected)
        colour = QColor("white" if is_selected else index.data(BAR_COLOUR) or tones().accent)
        left = rect.right() - _MARGIN_PX - length
        painter.fillRect(left, rect.bottom() - _BAR_PX, length, _BAR_PX - 1, colour)
