"""The 3D view in a real window. The only file that knows QtInteractor.

Mouse and key events are taken by an event filter before VTK sees them, so there is no interaction style, no
VTK pick and no observer order to get wrong; the same controller serves the offscreen viewport.
"""

from __future__ import annotations

from PySide6.QtWidgets import QWidget
from pyvistaqt import QtInteractor

from widgets.theme import DARK, Palette
from widgets.viewport.scene import Scene
from widgets.viewport.viewport_base import ViewportBase


class Viewport(ViewportBase):
    """The scene on a QtInteractor: needs a platform with OpenGL windows (xcb, Wayland, Windows, macOS)."""

    def __init__(self, parent: QWidget | None = None, palette: Palette = DARK) -> None:
        super().__init__(parent)
        self._plotter = QtInteractor(self, auto_update=False, multi_samples=0, lighting="none")
        self._plotter.setAcceptDrops(False)
        self._plotter.frameSwapped.connect(self.shown)
        scene = Scene(self._plotter, palette, self.devicePixelRatioF())
        self._start(self._plotter, scene)

    def _draw(self) -> None:
        self._scene.prepare()
        self._plotter.update()

    def _release(self) -> None:
        self._plotter.close()
