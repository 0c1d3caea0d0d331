"""How panels and window look: the colours of the theme as a Qt palette and a style sheet."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont, QFontDatabase, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication, QWidget

from riglens.widgets.panels.sheet import style_sheet
from riglens.widgets.theme import DARK_TONES, LIGHT_TONES, Tones

SPACING = 6
MARGIN = 8


def is_dark() -> bool:
    """Whether the system asks for a dark window."""
    return QGuiApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark


def shows_dark() -> bool:
    """Whether the application is dark now, by the system's wish or by a choice."""
    return QApplication.palette().color(QPalette.ColorRole.Window).lightness() < 128


def tones() -> Tones:
    """The colours of the theme that the application shows now."""
    return DARK_TONES if shows_dark() else LIGHT_TONES


def numbers_font(base: QFont) -> QFont:
    """`base` with tabular figures, so that digits of different rows stand under each other."""
    font = QFont(base)
    font.setFeature(QFont.Tag("tnum"), 1)
    return font


def as_panel(widget: QWidget) -> None:
    """Give a widget the background of a panel."""
    widget.setObjectName("panel")
    widget.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)  # Qt paints none for classes made in Python


def apply_style(app: QApplication, dark: bool | None = None) -> None:
    """Give the whole application one calm look; `dark` None follows the system."""
    chosen = DARK_TONES if (is_dark() if dark is None else dark) else LIGHT_TONES
    app.setStyle("Fusion")
    app.setPalette(_qt_palette(chosen))
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    font.setPointSizeF(min(max(font.pointSizeF(), 9.0), 11.0))
    app.setFont(font)
    app.setStyleSheet(style_sheet(chosen))


def _qt_palette(tones: Tones) -> QPalette:
    role = QPalette.ColorRole
    colours = {
        role.Window: tones.window,
        role.WindowText: tones.text,
        role.Base: tones.field,
        role.AlternateBase: tones.panel,
        role.Text: tones.text,
        role.PlaceholderText: tones.muted,
        role.Button: tones.panel,
        role.ButtonText: tones.text,
        role.Highlight: tones.selection,
        role.HighlightedText: "#ffffff",
        role.ToolTipBase: tones.field,
        role.ToolTipText: tones.text,
        role.Link: tones.accent,
        role.Light: tones.border,
        role.Midlight: tones.border,
        role.Mid: tones.border,
        role.Dark: tones.border,
    }
    palette = QPalette()
    for which, colour in colours.items():
        palette.setColor(which, QColor(colour))
    for which in (role.WindowText, role.Text, role.ButtonText):
        palette.setColor(QPalette.ColorGroup.Disabled, which, QColor(tones.muted))
    return palette
