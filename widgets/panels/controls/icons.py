"""Line icons drawn from SVG paths in the colour of the surrounding text, so they work light and dark."""

from __future__ import annotations

from PySide6.QtCore import QByteArray, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QIconEngine, QPainter, QPalette, QPixmap
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QApplication

from riglens.core.sensors.registry import kind_named
from riglens.widgets.sensors.appearance import appearance_of

_SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24" fill="none" stroke="{colour}" '
    'stroke-width="1.7" stroke-linecap="round" stroke-linejoin="round" opacity="{opacity}">{body}</svg>'
)

_BODIES = {
    "open": '<path d="M3 19V6h6l2 2h8v3"/><path d="M3 19l3-8h16l-3 8z"/>',
    "save": '<path d="M4 4h13l3 3v13H4z"/><path d="M8 4v5h7V4M8 20v-7h8v7"/>',
    "undo": '<path d="M8 5L4 9l4 4"/><path d="M4 9h10a5 5 0 0 1 0 10H9"/>',
    "redo": '<path d="M16 5l4 4-4 4"/><path d="M20 9H10a5 5 0 0 0 0 10h5"/>',
    "move": '<path d="M12 3v18M3 12h18M9.5 5.5L12 3l2.5 2.5M9.5 18.5L12 21l2.5-2.5M5.5 9.5L3 12l2.5 2.5'
    'M18.5 9.5L21 12l-2.5 2.5"/>',
    "rotate": '<path d="M20 12a8 8 0 1 1-2.5-5.8"/><path d="M20 3v4h-4"/>',
    "both": '<path d="M12 8v8M8 12h8"/><path d="M20.5 12a8.5 8.5 0 1 1-2.6-6.1"/><path d="M20.5 3v4h-4"/>',
    "axes": '<path d="M6 18V4M6 18h14M6 18l7-7"/><path d="M4 6l2-2 2 2M18 16l2 2-2 2M10.5 11H13v2.5"/>',
    "duplicate": '<rect x="8" y="8" width="12" height="12" rx="1.5"/><path d="M16 8V4H4v12h4"/>',
    "delete": '<path d="M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13M10 11v5M14 11v5"/>',
    "eye": '<path d="M2 12c2.5-4.5 6-6.5 10-6.5s7.5 2 10 6.5c-2.5 4.5-6 6.5-10 6.5S4.5 16.5 2 12z"/>'
    '<circle cx="12" cy="12" r="3"/>',
    "eye-off": '<path d="M3 10c2.3 3.5 5.3 5 9 5s6.7-1.5 9-5M5 16l1.5-2M12 18.5V15M19 16l-1.5-2"/>',
    "screenshot": '<path d="M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4"/><circle cx="12" cy="12" r="3.5"/>',
    "frame": '<path d="M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4"/><path d="M9 9h6v6H9z"/>',
    "copy": '<rect x="8" y="8" width="12" height="12" rx="1.5"/><path d="M4 15V4h11"/>',
    "paste": '<path d="M9 5H5v16h14V5h-4"/><rect x="9" y="3" width="6" height="4" rx="1"/>'
    '<path d="M8.5 12h7M8.5 16h5"/>',
    "reset": '<path d="M4 12a8 8 0 1 0 2.5-5.8"/><path d="M4 3v4h4"/>',
    "lock": '<rect x="5" y="11" width="14" height="9" rx="1.5"/><path d="M8 11V8a4 4 0 0 1 8 0v3"/>',
    "unlock": '<rect x="5" y="11" width="14" height="9" rx="1.5"/><path d="M8 11V8a4 4 0 0 1 7.6-1.7"/>',
    "pin": '<path d="M9 3h6l-1 6 4 4H6l4-4z"/><path d="M12 13v8"/>',
    "search": '<circle cx="10.5" cy="10.5" r="6"/><path d="M15 15l5.5 5.5"/>',
    "snapshot": '<rect x="4" y="4" width="16" height="16" rx="2"/><path d="M12 8v8M8 12h8"/>',
    "sliders": '<path d="M4 7h9M17 7h3M4 17h3M11 17h9"/><circle cx="15" cy="7" r="2"/><circle cx="9" cy="17" r="2"/>',
    "pick": '<path d="M12 3v5M12 16v5M3 12h5M16 12h5"/><path d="M10 10h4v4h-4z"/>',
    "measure": '<path d="M3 16.5L16.5 3 21 7.5 7.5 21z"/><path d="M6.5 13l2 2M9.5 10l3 3M12.5 7l2 2"/>',
    "mirror": '<path d="M12 3v18" stroke-dasharray="2 3"/><path d="M9 7v10H3zM15 7v10h6z"/>',
    "link": '<path d="M10 14a4.2 4.2 0 0 0 6 0l3-3a4.2 4.2 0 0 0-6-6l-1.2 1.2"/>'
    '<path d="M14 10a4.2 4.2 0 0 0-6 0l-3 3a4.2 4.2 0 0 0 6 6l1.2-1.2"/>',
    "alert": '<path d="M12 4L2.8 20h18.4z"/><path d="M12 10v5M12 17.6v0.1"/>',
    "place": '<path d="M3 19c4-4 14-4 18 0"/><path d="M12 3v9M9 9.5l3 3 3-3"/><circle cx="12" cy="15.7" r="0.6"/>',
    "snap": '<path d="M6 4v8a6 6 0 0 0 12 0V4h-4v8a2 2 0 0 1-4 0V4zM6 8h4M14 8h4"/>',
    "car": '<path d="M3 16v-3l2.5-1L8 7.5h7L18.5 12l2.5 1v3h-2M8 16h7M3 16h2"/><circle cx="6.5" cy="16.5" r="1.6"/>'
    '<circle cx="17" cy="16.5" r="1.6"/>',
    "bars": '<path d="M4 20h16M6.5 17v-6M12 17V5M17.5 17V9"/>',
    "export": '<path d="M4 13v7h16v-7"/><path d="M12 15V4M8 8l4-4 4 4"/>',
    "play": '<path d="M7 5l12 7-12 7z"/>',
    "pause": '<path d="M8 5v14M16 5v14"/>',
    "close": '<path d="M6 6l12 12M18 6L6 18"/>',
}


class _LineIcon(QIconEngine):
    """Icon of one body at any size; disabled icons are faint, icons on a selection take its text colour."""

    def __init__(self, body: str, colour: str | None) -> None:
        super().__init__()
        self._body, self._colour = body, colour

    def clone(self) -> QIconEngine:
        return _LineIcon(self._body, self._colour)

    def paint(self, painter: QPainter, rect: QRect, mode: QIcon.Mode, state: QIcon.State) -> None:
        role = (
            QPalette.ColorRole.HighlightedText
            if mode == QIcon.Mode.Selected
            else QPalette.ColorRole.WindowText
        )
        text = QApplication.palette().color(QPalette.ColorGroup.Active, role).name()
        colour = text if self._colour is None or mode == QIcon.Mode.Selected else self._colour
        opacity = 0.32 if mode == QIcon.Mode.Disabled else 1.0
        svg = _SVG.format(colour=colour, opacity=opacity, body=self._body)
        QSvgRenderer(QByteArray(svg.encode())).render(painter, QRectF(rect))

    def pixmap(self, size: QSize, mode: QIcon.Mode, state: QIcon.State) -> QPixmap:
        picture = QPixmap(size)
        picture.fill(Qt.GlobalColor.transparent)
        painter = QPainter(picture)
        self.paint(painter, picture.rect(), mode, state)
        painter.end()
        return picture


def icon(name: str, colour: str | None = None) -> QIcon:
    """Return the icon of that name, or of that kind of sensor, in the text's colour or in its own.

    Raise KeyError when there is none.
    """
    body = _BODIES[name] if kind_named(name) is None else appearance_of(name).icon
    return QIcon(_LineIcon(body, colour))


def swatch(colour: str) -> QIcon:
    """Return a small filled circle, as in a legend."""
    picture = QPixmap(24, 24)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(colour))
    painter.drawEllipse(5, 5, 14, 14)
    painter.end()
    return QIcon(picture)
