"""The 3D view without Qt's OpenGL: the same scene, drawn offscreen and shown as a picture.

For platforms without OpenGL windows, and for computers without a graphics card: there Qt composes a window that
holds a QOpenGLWidget from textures at every change in it, which takes longer than drawing a small change.
"""

from __future__ import annotations

from collections.abc import Generator
from time import perf_counter

import pyvista as pv
from PySide6.QtCore import QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QImage, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from riglens.widgets.drawing.stage import render_window
from riglens.widgets.theme import DARK, Palette
from riglens.widgets.timers import Timers, single_shot
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.inset import image_of, pixels_of
from riglens.widgets.viewport.redraw import Parts
from riglens.widgets.viewport.viewport_base import ViewportBase

_TURN_S = 0.015
"""Drawing time after which the event loop gets a turn."""


class _ImageCanvas(QWidget):
    """A widget that shows an image; `needed` when it has none yet, `painted` when a new one is on the screen."""

    needed = Signal()
    painted = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.image = QImage()
        self._is_new = False
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)

    def show_image(self, image: QImage) -> None:
        """Show another image."""
        self.image, self._is_new = image, True
        self.update()

    def sizeHint(self) -> QSize:
        """Return a useful size for a view by itself."""
        return QSize(960, 600)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Show the last picture."""
        if self.image.isNull():
            self.needed.emit()
        painter = QPainter(self)
        painter.drawImage(QRectF(self.rect()), self.image)
        painter.end()
        if self._is_new:
            self._is_new = False
            QTimer.singleShot(0, self, self.painted.emit)


class OffscreenViewport(ViewportBase):
    """The scene on an offscreen plotter; mouse events go through the same controller as in a window."""

    def __init__(
        self, parent: QWidget | None = None, palette: Palette = DARK, timers: Timers = single_shot
    ) -> None:
        super().__init__(parent, timers)
        self._plotter = pv.Plotter(off_screen=True, window_size=[960, 600], lighting="none")
        self._window = render_window(self._plotter)
        self._window.SetMultiSamples(0)
        self._picture = _ImageCanvas(self)
        self._picture.needed.connect(self._redraw.now)
        self._picture.painted.connect(self.shown)
        self._haze: Generator[None, None, bool] | None = None
        self._gives_way = False
        self._haze_soon = timers(self, 0, self._draw_haze)
        scene = DrawnScene(self._plotter, palette, self.devicePixelRatioF(), awaits_footprints=True)
        self._start(self._picture, scene)

    @property
    def image(self) -> QImage:
        """The last picture drawn."""
        return self._picture.image

    def _in_parts(self) -> bool:
        return not (self._scene.is_quick or self._picture.image.isNull())

    def _follow_size(self) -> None:
        ratio = self._picture.devicePixelRatioF()
        width, height = (max(1, round(length * ratio)) for length in (self.width(), self.height()))
        if (width, height) != self._scene.size:
            self._window.SetSize(width, height)

    def _adapt(self, smooth: bool) -> None:
        self._follow_size()
        super()._adapt(smooth)

    def _draw(self) -> None:
        self._scene.prepare()
        if self._scene.is_quick:
            self._scene.draw_moving()
        else:
            self._window.Render()
        self._show_pixels()
        self._follow_haze()

    def _follow_haze(self) -> None:
        """Schedule the drawing of a new heatmap between the frames of a drag, unless one is being drawn."""
        if self._haze is None and self._scene.haze_is_due:
            self._haze = self._scene.draw_haze()
        if self._haze is not None:
            self._haze_soon.start()  # not in the turn of this frame

    def _draw_haze(self) -> None:
        """Draw a part of the picture under the next frames; a frame shows it when it is complete."""
        if self._haze is None:
            return
        self._gives_way = self._redraw.is_due and not self._gives_way
        if self._gives_way:  # a frame goes first, but not again and again: neither waits for long
            self._haze_soon.start()
            return
        self._redraw.next_turn()
        try:
            next(self._haze)
            self._haze_soon.start()
        except StopIteration as end:
            self._haze = None
            if end.value:
                self.request_render()

    def _draw_whole(self) -> Parts:
        yield  # rebuilding the rays that motion left out has taken a turn
        self._scene.prepare()
        yield
        began = perf_counter()
        for _ in self._scene.draw_in_parts():
            if perf_counter() - began > _TURN_S:
                yield
                began = perf_counter()
        self._show_pixels()

    def _show_pixels(self) -> None:
        self._picture.show_image(image_of(pixels_of(self._window)))

    @property
    def is_at_rest(self) -> bool:
        """Return whether the picture is in full quality and nothing waits to be drawn."""
        return super().is_at_rest and self._haze is None

    def _held_still(self) -> None:
        self._follow_haze()  # the last heatmap may have come too soon after the one before

    def _release(self) -> None:
        self._haze_soon.stop()
        self._haze = None
        del self._window
        self._plotter.close()
