"""The application's look: its style sheet in the colours of the theme, its fonts, its tooltips."""

from __future__ import annotations

from html import escape

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont, QFontDatabase, QGuiApplication, QPalette
from PySide6.QtWidgets import QApplication, QWidget

from riglens.assets import asset_path
from riglens.core.shown_text import visible_lines
from riglens.widgets.theme import DARK_TONES, LIGHT_TONES, Tones

_ICONS = ("chevron", "chevron-up", "more", "close", "float")


def style_sheet(t: Tones) -> str:
    """Return the style sheet of a theme."""
    theme = "dark" if t is DARK_TONES else "light"
    icons = {name.replace("-", "_"): asset_path(f"icons/{name}-{theme}.svg").as_posix() for name in _ICONS}
    check = asset_path("icons/check.svg").as_posix()
    return "".join(part.format(t=t, check=check, **icons) for part in _PARTS)


_WINDOW = """
QMainWindow::separator {{ background: {t.border}; width: 1px; height: 1px; }}
QSplitter::handle {{ background: {t.border}; }}
QSplitter::handle:horizontal {{ width: 1px; }}
QSplitter::handle:vertical {{ height: 1px; }}
QMainWindow::separator:hover {{ background: {t.accent}; }}
QToolBar {{ background: {t.panel}; border: 0; border-bottom: 1px solid {t.border};
    padding: 3px 4px; spacing: 1px; }}
QToolBar::separator {{ background: {t.border}; width: 1px; margin: 6px 2px; }}
QToolBar QToolButton {{ border: 1px solid transparent; border-radius: 5px; padding: 3px; color: {t.text}; }}
QToolBar QToolButton:hover {{ background: {t.field}; border-color: {t.border}; }}
QToolBar QToolButton:checked {{ background: {t.chosen}; border-color: {t.accent}; }}
QToolBar QToolButton:disabled {{ color: {t.muted}; }}
QToolBar QToolButton[popupMode="2"] {{ padding: 3px 3px; }}
QToolBar QToolButton::menu-indicator {{ image: none; }}
QToolButton#qt_toolbar_ext_button {{ qproperty-icon: url("{more}"); padding: 0; }}
QMenuBar {{ background: {t.panel}; color: {t.text}; }}
QMenuBar::item {{ padding: 4px 9px; background: transparent; }}
QMenuBar::item:selected {{ background: {t.chosen}; }}
QDockWidget {{ color: {t.text}; font-weight: 600; titlebar-close-icon: url("{close}");
    titlebar-normal-icon: url("{float}"); }}
QDockWidget::title {{ background: {t.window}; padding: 5px 8px; border-bottom: 1px solid {t.border}; }}
QStatusBar {{ background: {t.panel}; color: {t.muted}; border-top: 1px solid {t.border}; }}
QStatusBar::item {{ border: 0; }}
QStatusBar QLabel {{ color: {t.muted}; padding: 0 6px; }}
QStatusBar QLabel#warning {{ color: {t.less}; }}
QToolTip {{ background: {t.field}; color: {t.text}; border: 1px solid {t.border}; padding: 4px; }}
QFrame#messageBar {{ background: {t.error_field}; border: 0; border-bottom: 1px solid {t.error}; }}
QFrame#messageBar QLabel {{ color: {t.text}; }}
QFrame#voxelCard {{ background: {t.panel}; border: 1px solid {t.border}; border-radius: 6px; }}
QFrame#voxelCard QScrollArea, QFrame#voxelCard QLabel {{ background: transparent; }}
QFrame#voxelCard QToolButton {{ border: 0; background: transparent; }}
QFrame#noteBar {{ background: {t.chosen}; border: 0; border-bottom: 1px solid {t.accent}; }}
"""

_TABS = """
QTabBar {{ background: {t.window}; qproperty-drawBase: 0; }}
QTabBar::tab {{ background: {t.window}; color: {t.muted}; border: 0; border-bottom: 2px solid transparent;
    padding: 6px 11px 5px 11px; }}
QTabBar::tab:hover {{ color: {t.text}; }}
QTabBar::tab:selected {{ background: {t.panel}; color: {t.text}; border-bottom-color: {t.accent}; }}
QTabBar::tab:selected:focus {{ color: {t.accent}; }}
QScrollBar {{ background: transparent; border: 0; }}
QScrollBar:vertical {{ width: 11px; }}
QScrollBar:horizontal {{ height: 11px; }}
QScrollBar::handle {{ background: {t.border}; border-radius: 3px; }}
QScrollBar::handle:vertical {{ min-height: 28px; margin: 2px 2px 2px 3px; }}
QScrollBar::handle:horizontal {{ min-width: 28px; margin: 3px 2px 2px 2px; }}
QScrollBar::handle:hover, QScrollBar::handle:pressed {{ background: {t.muted}; }}
QScrollBar::add-line, QScrollBar::sub-line {{ width: 0; height: 0; }}
QScrollBar::add-page, QScrollBar::sub-page {{ background: transparent; }}
"""

_FIELDS = """
QTreeView, QTableView, QListView {{ background: {t.field}; border: 0; alternate-background-color: {t.panel}; }}
QTreeView::item {{ padding: 3px 0; }}
QListView::item {{ padding: 3px 6px; }}
QTableView::item {{ padding: 0 3px; }}
QHeaderView, QTableCornerButton::section {{ background: {t.panel}; border: 0; }}
QHeaderView::section {{ background: {t.panel}; color: {t.muted}; border: 0;
    border-bottom: 1px solid {t.border}; padding: 3px 6px; font-weight: 500; }}
QTreeView QHeaderView::section {{ padding: 3px 4px; }}
QLineEdit, QComboBox, QAbstractSpinBox {{ background: {t.field}; border: 1px solid {t.border};
    border-radius: 4px; padding: 1px 5px; min-height: 18px;
    selection-background-color: {t.selection}; selection-color: white; }}
QLineEdit:focus, QComboBox:focus, QAbstractSpinBox:focus {{ border-color: {t.accent}; }}
QLineEdit:disabled, QComboBox:disabled, QAbstractSpinBox:disabled {{ color: {t.muted}; background: {t.panel}; }}
QLineEdit[invalid="true"] {{ border-color: {t.error}; background: {t.error_field}; color: {t.error}; }}
QComboBox QLineEdit, QAbstractSpinBox QLineEdit {{ border: 0; padding: 0; }}
QAbstractSpinBox QLineEdit {{ padding-left: 4px; }}
QComboBox::drop-down {{ border: 0; width: 18px; }}
QComboBox::down-arrow {{ image: url("{chevron}"); width: 12px; height: 12px; }}
QAbstractSpinBox::up-button, QAbstractSpinBox::down-button {{ border: 0; width: 16px; }}
QAbstractSpinBox::up-arrow {{ image: url("{chevron_up}"); width: 10px; height: 10px; }}
QAbstractSpinBox::down-arrow {{ image: url("{chevron}"); width: 10px; height: 10px; }}
QCheckBox::indicator, QTreeView::indicator {{ width: 12px; height: 12px; border: 1px solid {t.muted};
    border-radius: 3px; background: {t.field}; }}
QCheckBox::indicator:checked, QTreeView::indicator:checked {{ background: {t.accent};
    border-color: {t.accent}; image: url("{check}"); }}
QCheckBox::indicator:focus {{ border-color: {t.text}; }}
QTreeView::indicator:checked:selected {{ border-color: white; }}
QScrollArea {{ border: 0; background: {t.panel}; }}
QWidget#panel {{ background: {t.panel}; }}
QLabel#heading {{ color: {t.muted}; font-weight: 600; padding-top: 6px; }}
QLabel#hint {{ color: {t.muted}; }}
QLabel#problem {{ color: {t.error}; }}
QLabel#warning {{ color: {t.less}; }}
"""

_BUTTONS = """
QPushButton, QWidget#panel QToolButton {{ background: {t.field}; color: {t.text}; border: 1px solid {t.border};
    border-radius: 4px; min-height: 18px; }}
QPushButton {{ padding: 1px 12px; }}
QWidget#panel QToolButton {{ padding: 1px 5px; }}
QWidget#panel QToolButton[popupMode="1"], QWidget#panel QToolButton[popupMode="2"] {{ padding-right: 17px; }}
QWidget#panel QToolButton::menu-button {{ border: 0; width: 15px; }}
QWidget#panel QToolButton::menu-arrow, QWidget#panel QToolButton::menu-indicator {{ image: url("{chevron}");
    width: 10px; height: 10px; }}
QWidget#panel QToolButton::menu-indicator {{ subcontrol-position: right center; right: 4px; }}
QWidget#panel QLineEdit QToolButton {{ border: 0; background: transparent; padding: 0; min-height: 0; }}
QPushButton:hover, QWidget#panel QToolButton:hover {{ border-color: {t.muted}; }}
QPushButton:focus, QWidget#panel QToolButton:focus {{ border-color: {t.accent}; }}
QPushButton:pressed, QPushButton:checked, QWidget#panel QToolButton:pressed,
QWidget#panel QToolButton:checked {{ background: {t.chosen}; border-color: {t.accent}; }}
QPushButton:disabled, QWidget#panel QToolButton:disabled {{ background: {t.panel}; color: {t.muted}; }}
QDialogButtonBox {{ dialogbuttonbox-buttons-have-icons: 0; }}
QDialog QPushButton {{ min-height: 22px; min-width: 54px; }}
QPushButton:default {{ background: {t.selection}; color: white; border-color: {t.selection}; }}
QPushButton:default:disabled {{ background: {t.panel}; color: {t.muted}; border-color: {t.border}; }}
QSlider::groove:horizontal {{ height: 4px; border-radius: 2px; background: {t.border}; }}
QSlider::sub-page:horizontal {{ border-radius: 2px; background: {t.accent}; }}
QSlider::sub-page:horizontal:disabled {{ background: {t.border}; }}
QSlider::handle:horizontal {{ width: 12px; margin: -5px 0; border-radius: 7px; background: {t.field};
    border: 1px solid {t.muted}; }}
QSlider::handle:horizontal:hover, QSlider::handle:horizontal:focus {{ border-color: {t.accent}; }}
QSlider::handle:horizontal:disabled {{ border-color: {t.border}; background: {t.panel}; }}
QProgressBar {{ background: {t.border}; color: {t.text}; border: 0; border-radius: 4px; min-height: 16px;
    max-height: 16px; text-align: center; }}
QProgressBar#thin {{ background: transparent; min-height: 3px; max-height: 3px; border-radius: 1px; }}
QProgressBar#thin::chunk {{ background: {t.accent}; border-radius: 1px; }}
QProgressBar::chunk {{ background: {t.chosen}; border-radius: 4px; }}
"""

_PARTS = (_WINDOW, _TABS, _FIELDS, _BUTTONS)


SPACING = 6
MARGIN = 8


def is_dark() -> bool:
    """Return whether the system uses a dark theme."""
    return QGuiApplication.styleHints().colorScheme() == Qt.ColorScheme.Dark


def shows_dark() -> bool:
    """Return whether the application is dark now, following the system or a choice."""
    return QApplication.palette().color(QPalette.ColorRole.Window).lightness() < 128


def tones() -> Tones:
    """Return the colours of the theme that the application shows now."""
    return DARK_TONES if shows_dark() else LIGHT_TONES


def numbers_font(base: QFont) -> QFont:
    """Return `base` with tabular figures, so that digits of different rows line up."""
    font = QFont(base)
    font.setFeature(QFont.Tag("tnum"), 1)
    return font


def small_font(base: QFont) -> QFont:
    """Return `base` a little smaller, with tabular figures: for charts and maps."""
    font = numbers_font(base)
    font.setPointSizeF(max(7.0, font.pointSizeF() - 1.0))
    font.setBold(False)
    return font


def as_panel(widget: QWidget) -> None:
    """Give a widget the background of a panel."""
    widget.setObjectName("panel")
    widget.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)  # Qt paints none for classes made in Python


def apply_style(app: QApplication, dark: bool | None = None) -> None:
    """Apply the application's style, font and theme; `dark` None follows the system."""
    app.setStyle("Fusion")
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    font.setPointSizeF(min(max(font.pointSizeF(), 9.0), 11.0))
    app.setFont(font)
    apply_theme(app, is_dark() if dark is None else dark)


def apply_theme(app: QApplication, dark: bool) -> None:
    """Apply the colours of a theme. Style and font stay: each would lay out every widget again."""
    chosen = DARK_TONES if dark else LIGHT_TONES
    app.setPalette(_qt_palette(chosen))
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


def plain_tip(text: str) -> str:
    """Return a tooltip that shows this text with its line ends."""
    return f"<p style='white-space: pre-wrap'>{escape(visible_lines(text), quote=False)}</p>" if text else ""
