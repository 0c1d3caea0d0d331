"""Choose the viewport of the window: OpenGL where a graphics card draws, otherwise a picture."""

from __future__ import annotations

from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext
from PySide6.QtWidgets import QWidget

from riglens.widgets.theme import DARK, Palette
from riglens.widgets.viewport.viewport_base import ViewportBase

_GL_RENDERER = 0x1F01
_WITHOUT_CARD = (
    "llvmpipe",
    "softpipe",
    "swrast",
    "software",
    "swiftshader",
    "gdi generic",
    "microsoft basic render",
)
"""Words in the names of drivers that draw on the processor."""


def create_viewport(parent: QWidget | None = None, palette: Palette = DARK) -> ViewportBase:
    """Make a viewport for this computer and Qt's platform; both kinds are a `View`."""
    if QGuiApplication.platformName() == "offscreen" or draws_without_card(driver_name()):
        from riglens.widgets.viewport.offscreen import OffscreenViewport

        return OffscreenViewport(parent, palette)
    from riglens.widgets.viewport.viewport import Viewport

    return Viewport(parent, palette)


def driver_name() -> str:
    """Return the name of the OpenGL driver that Qt draws with; empty if it has none."""
    context, surface = QOpenGLContext(), QOffscreenSurface()
    surface.create()
    if not (context.create() and context.makeCurrent(surface)):
        return ""
    name = context.functions().glGetString(_GL_RENDERER)
    context.doneCurrent()
    return str(name or "")


def draws_without_card(driver: str) -> bool:
    """Return whether the processor does the work of a graphics card, judged by the driver's name."""
    return not driver or any(word in driver.lower() for word in _WITHOUT_CARD)
