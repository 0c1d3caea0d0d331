"""The 3D view without any display (QT_QPA_PLATFORM=offscreen): the same scene, drawn into a picture."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from PySide6.QtCore import QRectF, QSize
from PySide6.QtGui import QImage, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QWidget
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from widgets.theme import DARK, Palette
from widgets.viewport.scene import Scene
from widgets.viewport.stage import render_window
from widgets.viewport.viewport_base import ViewportBase


class _Picture(QWidget):
    """A widget that shows an image."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.image = QImage()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def sizeHint(self) -> QSize:
        """A useful size for a view that stands alone."""
        return QSize(960, 600)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Show the last picture."""
        painter = QPainter(self)
        painter.drawImage(QRectF(self.rect()), self.image)
        painter.end()


class OffscreenViewport(ViewportBase):
    """The scene on an offscreen plotter; mouse events go through the same controller as in a window."""

    def __init__(self, parent: QWidget | None = None, palette: Palette = DARK) -> None:
        super().__init__(parent)
        self._plotter = pv.Plotter(off_screen=True, window_size=[960, 600], lighting="none")
        self._window = render_window(self._plotter)
        self._window.SetMultiSamples(0)
        self._picture = _Picture(self)
        self._start(self._picture, Scene(self._plotter, palette, self.devicePixelRatioF()))

    @property
    def image(self) -> QImage:
        """The last picture drawn."""
        return self._picture.image

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Draw at the new size."""
        super().resizeEvent(event)
        self._follow_size()

    def _follow_size(self) -> None:
        ratio = self._picture.devicePixelRatioF()
        width, height = (max(1, round(length * ratio)) for length in (self.width(), self.height()))
        if not self._closed and (width, height) != self._scene.size:
            self._window.SetSize(width, height)
            self.request_render()

    def _draw(self) -> None:
        self._follow_size()
        self._scene.prepare()
        self._window.Render()
        width, height = self._scene.size
        pixels = vtkUnsignedCharArray()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        rows = vtk_to_numpy(pixels).reshape(height, width, 3)
        upright = np.ascontiguousarray(rows[::-1])
        self._picture.image = QImage(
            upright.data, width, height, 3 * width, QImage.Format.Format_RGB888
        ).copy()
        self._picture.update()
        self.shown.emit()

    def _release(self) -> None:
        del self._window
        self._plotter.close()
