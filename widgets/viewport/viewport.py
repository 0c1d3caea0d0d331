"""3D view in a real window. The only file that uses QtInteractor.

Mouse and key events are taken by an event filter before VTK sees them, so there is no interaction style, no
VTK pick and no observer order to get wrong; the same controller serves the offscreen viewport.
"""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget
from vtkmodules.vtkCommonCore import vtkCommand

from riglens.widgets.drawing.label import DPI
from riglens.widgets.drawing.packages import pyside_as_qtpy
from riglens.widgets.drawing.stage import render_window
from riglens.widgets.theme import DARK, Palette
from riglens.widgets.timers import Timers, single_shot
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.viewport_base import ViewportBase

with pyside_as_qtpy():
    from pyvistaqt import QtInteractor


class _OpenGLCanvas(QtInteractor):
    """Canvas that draws nothing before its window is on the screen: Qt also paints when it first sizes the widget."""

    def paintGL(self) -> None:
        window = self.window().windowHandle()
        if window is not None and window.isExposed():
            super().paintGL()  # type: ignore[no-untyped-call]


class Viewport(ViewportBase):
    """The scene on a QtInteractor: needs a platform with OpenGL windows (xcb, Wayland, Windows, macOS)."""

    def __init__(
        self, parent: QWidget | None = None, palette: Palette = DARK, timers: Timers = single_shot
    ) -> None:
        super().__init__(parent, timers)
        self._plotter = _OpenGLCanvas(self, auto_update=False, multi_samples=0, lighting="none")
        self._plotter.setAcceptDrops(False)
        self._plotter.frameSwapped.connect(self.shown, Qt.ConnectionType.QueuedConnection)
        scene = DrawnScene(self._plotter, palette, self.devicePixelRatioF(), awaits_footprints=True)
        self._start(self._plotter, scene)
        window = render_window(self._plotter)
        self._letters = window.AddObserver(vtkCommand.StartEvent, lambda *_: self._count_in_pixels())
        self._before_first: int | None = window.AddObserver(
            vtkCommand.StartEvent, lambda *_: self._prepare_first()
        )

    def _prepare_first(self) -> None:
        """Prepare the next picture, since Qt may paint the canvas before the timer draws."""
        self._forget_first()
        self._redraw.taken_over()
        self._adapt(smooth=False)
        self._scene.prepare()

    def _forget_first(self) -> None:
        if self._before_first is not None:
            render_window(self._plotter).RemoveObserver(self._before_first)
            self._before_first = None

    def _count_in_pixels(self) -> None:
        """Count font sizes in pixels of the screen, since the widget would make VTK enlarge them once more."""
        render_window(self._plotter).SetDPI(DPI)

    def _draw(self) -> None:
        self._scene.prepare()
        self._plotter.update()

    def _release(self) -> None:
        self._forget_first()
        render_window(self._plotter).RemoveObserver(self._letters)
        self._plotter.close()
