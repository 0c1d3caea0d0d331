"""A card over the view about one voxel: where it is, p and h per class, who sees it, and why others do not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from riglens.core.shown_text import visible
from riglens.widgets.panels.controls.building import filled, tool
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.style import MARGIN, SPACING, tones
from riglens.widgets.theme import Tones

_WIDTH_PX, _ROOM_PX, _MARGIN_PX = 356, 120, 10


@dataclass(frozen=True)
class SensorLine:
    """Line about one sensor."""

    name: str
    sees: bool
    text: str


@dataclass(frozen=True)
class VoxelText:
    """Text of the card: a title, rows of class, p and h, a summary, and a line per sensor."""

    title: str
    classes: tuple[tuple[str, str, str], ...]
    summary: str
    sensors: tuple[SensorLine, ...]


class VoxelCard(QFrame):
    """In the upper left corner of its parent; hidden until there is something to show."""

    closed = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("voxelCard")
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.setAutoFillBackground(True)
        self.setFixedWidth(_WIDTH_PX)
        self._text: VoxelText | None = None
        self._is_stale = False
        self._title, self._body = QLabel(), QLabel()
        self._title.setTextFormat(Qt.TextFormat.RichText)
        self._body.setTextFormat(Qt.TextFormat.RichText)
        self._body.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._body.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._body.setMargin(0)
        self._build()
        self.hide()

    def _build(self) -> None:
        close = tool(icon("close"), self.closed, "Clear the voxel. (Esc)", "close_card")
        close.setIconSize(QSize(14, 14))
        close.setAutoRaise(True)
        head = filled(QHBoxLayout(), self._title, 1, close)
        self._area = QScrollArea()
        self._area.setWidget(self._body)
        self._area.setWidgetResizable(True)
        self._area.setFrameShape(QFrame.Shape.NoFrame)
        self._area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        margins = (MARGIN + 2, MARGIN, MARGIN, MARGIN)
        filled(QVBoxLayout(self), head, self._area, margins=margins, spacing=SPACING)

    @property
    def text(self) -> VoxelText | None:
        """Return the text of the card, None while it is hidden."""
        return self._text

    def show_voxel(self, text: VoxelText | None) -> None:
        """Show the details of a voxel; None hides the card."""
        self._text, self._is_stale = text, False
        self._show()

    def show_again(self) -> None:
        """Show the same in the colours of another theme."""
        self._show()

    def set_stale(self) -> None:
        """Grey it: the rig has changed since."""
        if self._text is not None and not self._is_stale:
            self._is_stale = True
            self._show()

    def _show(self) -> None:
        self.setVisible(self._text is not None)
        if self._text is None:
            return
        colours = tones()
        self._title.setText(f"<b>{escape(self._text.title)}</b>")
        self._body.setText(_html(self._text, colours, self._is_stale))
        self.fit()
        self.raise_()

    def fit(self) -> None:
        """Fit the height to the text, within the parent; long lists are scrolled."""
        parent = self.parentWidget()
        wanted = self._body.sizeHint().height()
        room = max(_ROOM_PX, (parent.height() if parent is not None else 600) - _ROOM_PX)
        self._area.setFixedHeight(min(wanted + 2, room))
        self.adjustSize()
        self.move(_MARGIN_PX, _MARGIN_PX)


def _html(text: VoxelText, colours: Tones, is_stale: bool) -> str:
    ink = colours.muted if is_stale else colours.text
    rows = [("", "p", "h (nat)"), *text.classes]
    table = "".join(_class_row(row, colours.muted if place == 0 else ink) for place, row in enumerate(rows))
    parts = [f"<table cellspacing=0 cellpadding=1>{table}</table>"]
    parts.append(f"<p style='margin:6px 0 3px 0; color:{ink}'>{escape(text.summary)}</p>")
    parts.append(_sensors_html(text.sensors, colours, ink, is_stale))
    return "".join(parts)


def _class_row(cells: tuple[str, str, str], ink: str) -> str:
    name, p, h = (escape(cell) for cell in cells)
    right = f"<td align=right width=84 style='color:{ink}'>"
    return f"<tr><td width=110 style='color:{ink}'>{name}</td>{right}{p}</td>{right}{h}</td></tr>"


def _sensors_html(lines: Sequence[SensorLine], colours: Tones, ink: str, is_stale: bool) -> str:
    """Return the rows of the sensors, those that see the voxel first."""
    rows = []
    for line in sorted(lines, key=lambda line: not line.sees):
        colour = ink if is_stale else colours.more if line.sees else colours.muted
        rows.append(
            f"<tr><td style='color:{ink}; padding-right:10px'>{escape(_short(line.name))}</td>"
            f"<td style='color:{colour}'>{escape(line.text)}</td></tr>"
        )
    return f"<table cellspacing=0 cellpadding=1>{''.join(rows)}</table>"


def _short(name: str, most: int = 18) -> str:
    name = visible(name)
    return name if len(name) <= most else name[: most - 1] + "…"
