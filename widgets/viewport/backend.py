"""Which viewport this program can show: a real one on a display, a drawn picture without."""

from __future__ import annotations

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget

from widgets.theme import DARK, Palette
from widgets.viewport.viewport_base import ViewportBase


def create_viewport(parent: QWidget | None = None, palette: Palette = DARK) -> ViewportBase:
    """A viewport for the platform Qt runs on; both kinds have the same signals and slots."""
    if QGuiApplication.platformName() == "offscreen":
        from widgets.viewport.offscreen import OffscreenViewport

        return OffscreenViewport(parent, palette)
    from widgets.viewport.viewport import Viewport

    return Viewport(parent, palette)
