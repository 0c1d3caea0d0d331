"""A card over the view with tips for the first steps, one at a time; closed for good by its button."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton, QVBoxLayout, QWidget

from riglens.widgets.panels.controls.building import button, filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN

_WIDTH_PX, _MARGIN_PX = 330, 10
ROOM_PX = 660
"""In a narrower view the card would cover the legend, so it is shown on request only."""


class TipsCard(QFrame):
    """In the lower left corner of its parent, hidden until `begin`."""

    closed = Signal()
    """The user closed the tips for good."""

    def __init__(self, tips: Sequence[str], parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("tipsCard")
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.setAutoFillBackground(True)
        self.setFixedWidth(_WIDTH_PX)
        self._tips, self._place, self._waits = tuple(tips), 0, False
        self.title, self.text = plain_label(style="heading"), plain_label(wraps=True)
        self.back = button(QPushButton("Back"), lambda: self._go(-1))
        self.next = button(QPushButton("Next"), lambda: self._go(1))
        tip = "Show them again by Help > Tips."
        self.close_button = button(QPushButton("No more tips"), self.closed, tip)
        row = filled(QHBoxLayout(), self.close_button, None, self.back, self.next)
        filled(QVBoxLayout(self), self.title, self.text, row, margins=(MARGIN,) * 4)
        parent.installEventFilter(self)
        self.hide()

    def begin(self, in_any_room: bool = True) -> None:
        """Show the first tip; in a narrow view only `in_any_room`."""
        self._place = 0
        self._waits = not in_any_room
        self._show_if_room()
        self._show_tip()

    def end(self) -> None:
        """Put the card away."""
        self._waits = False
        self.hide()

    def _show_if_room(self) -> None:
        parent = self.parentWidget()
        self.setVisible(not self._waits or (parent is not None and parent.width() >= ROOM_PX))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Stay in the corner when the view gets another size."""
        if event.type() == QEvent.Type.Resize:
            if self._waits:
                self._show_if_room()
            self._stay_in_corner()
        return False

    def _go(self, steps: int) -> None:
        self._place = min(max(self._place + steps, 0), len(self._tips) - 1)
        self._show_tip()

    def _show_tip(self) -> None:
        self.title.setText(f"Tip {self._place + 1} of {len(self._tips)}")
        self.text.setText(self._tips[self._place])
        self.back.setEnabled(self._place > 0)
        self.next.setEnabled(self._place < len(self._tips) - 1)
        self.adjustSize()
        self._stay_in_corner()
        self.raise_()

    def _stay_in_corner(self) -> None:
        parent = self.parentWidget()
        if parent is not None:
            self.move(_MARGIN_PX, max(_MARGIN_PX, parent.height() - self.height() - _MARGIN_PX))
