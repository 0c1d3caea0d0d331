"""How panels and window look: the colours of the theme as a Qt palette and a style sheet."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont, QFontDatabase, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication

from assets import asset_path
from widgets.theme import DARK_TONES, LIGHT_TONES, Tones

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


def apply_style(app: QApplication, dark: bool | None = None) -> None:
    """Give the whole application one calm look; `dark` None follows the system."""
    chosen = DARK_TONES if (is_dark() if dark is None else dark) else LIGHT_TONES
    app.setStyle("Fusion")
    app.setPalette(_qt_palette(chosen))
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    font.setPointSizeF(min(max(font.pointSizeF(), 9.0), 11.0))
    app.setFont(font)
    app.setStyleSheet(_sheet(chosen))


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


def _sheet(t: Tones) -> str:
    theme = "dark" if t is DARK_TONES else "light"
    icons = {
        name: asset_path(f"icons/{name}-{theme}.svg").as_posix()
        for name in ("chevron", "more", "close", "float")
    }
    check = asset_path("icons/check.svg").as_posix()
    return (_WINDOW_SHEET + _FIELD_SHEET).format(t=t, check=check, **icons)


_WINDOW_SHEET = """
QMainWindow::separator {{ background: {t.border}; width: 1px; height: 1px; }}
QMainWindow::separator:hover {{ background: {t.accent}; }}
QToolBar {{ background: {t.panel}; border: 0; border-bottom: 1px solid {t.border};
    padding: 3px 6px; spacing: 1px; }}
QToolBar::separator {{ background: {t.border}; width: 1px; margin: 6px 4px; }}
QToolBar QToolButton {{ border: 1px solid transparent; border-radius: 5px; padding: 3px; color: {t.text}; }}
QToolBar QToolButton:hover {{ background: {t.field}; border-color: {t.border}; }}
QToolBar QToolButton:checked {{ background: {t.chosen}; border-color: {t.accent}; }}
QToolBar QToolButton:disabled {{ color: {t.muted}; }}
QToolBar QToolButton[popupMode="2"] {{ padding: 3px 5px; }}
QToolBar QToolButton::menu-indicator {{ image: none; }}
QToolButton#qt_toolbar_ext_button {{ qproperty-icon: url("{more}"); padding: 0; min-width: 16px; }}
QMenuBar {{ background: {t.panel}; color: {t.text}; }}
QMenuBar::item {{ padding: 4px 9px; background: transparent; }}
QMenuBar::item:selected {{ background: {t.chosen}; }}
QDockWidget {{ color: {t.text}; font-weight: 600; titlebar-close-icon: url("{close}");
    titlebar-normal-icon: url("{float}"); }}
QDockWidget::title {{ background: {t.window}; padding: 5px 8px; border-bottom: 1px solid {t.border}; }}
QStatusBar {{ background: {t.panel}; color: {t.muted}; border-top: 1px solid {t.border}; }}
QStatusBar::item {{ border: 0; }}
QStatusBar QLabel {{ color: {t.muted}; padding: 0 6px; }}
QToolTip {{ background: {t.field}; color: {t.text}; border: 1px solid {t.border}; padding: 4px; }}
QFrame#messageBar {{ background: {t.error_field}; border: 0; border-bottom: 1px solid {t.error}; }}
QFrame#messageBar QLabel {{ color: {t.text}; }}
QFrame#noteBar {{ background: {t.chosen}; border: 0; border-bottom: 1px solid {t.accent}; }}
"""

_FIELD_SHEET = """
QTreeView, QTableView {{ background: {t.field}; border: 0; alternate-background-color: {t.panel}; }}
QTreeView::item {{ padding: 3px 0; }}
QTableView::item {{ padding: 0 8px; }}
QHeaderView {{ background: {t.panel}; }}
QHeaderView::section {{ background: {t.panel}; color: {t.muted}; border: 0;
    border-bottom: 1px solid {t.border}; padding: 3px 10px; font-weight: 500; }}
QLineEdit, QComboBox {{ background: {t.field}; border: 1px solid {t.border}; border-radius: 4px;
    padding: 1px 5px; min-height: 18px; selection-background-color: {t.selection}; selection-color: white; }}
QLineEdit:focus, QComboBox:focus {{ border-color: {t.accent}; }}
QLineEdit:disabled, QComboBox:disabled {{ color: {t.muted}; background: {t.panel}; }}
QLineEdit[invalid="true"] {{ border-color: {t.error}; background: {t.error_field}; color: {t.error}; }}
QComboBox QLineEdit {{ border: 0; padding: 0; }}
QComboBox::drop-down {{ border: 0; width: 18px; }}
QComboBox::down-arrow {{ image: url("{chevron}"); width: 12px; height: 12px; }}
QCheckBox::indicator, QTreeView::indicator {{ width: 12px; height: 12px; border: 1px solid {t.muted};
    border-radius: 3px; background: {t.field}; }}
QCheckBox::indicator:checked, QTreeView::indicator:checked {{ background: {t.accent};
    border-color: {t.accent}; image: url("{check}"); }}
QTreeView::indicator:checked:selected {{ border-color: white; }}
QScrollArea {{ border: 0; background: {t.panel}; }}
QWidget#panel {{ background: {t.panel}; }}
QLabel#heading {{ color: {t.muted}; font-weight: 600; padding-top: 6px; }}
QLabel#hint {{ color: {t.muted}; }}
QLabel#problem {{ color: {t.error}; }}
"""
