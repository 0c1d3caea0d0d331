"""The picture of the selected camera in a corner of the view: the same scene through its lens, drawn on change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QColor, QFont, QFontMetrics, QImage, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkRenderingCore import vtkRenderWindow

from riglens.core.rig.model import Camera
from riglens.core.sensors.camera import field_of_view_deg
from riglens.core.shown_text import visible
from riglens.widgets.drawing.actors import numpy_of
from riglens.widgets.drawing.camera import through
from riglens.widgets.drawing.label import Box
from riglens.widgets.drawing.lens import bend_of
from riglens.widgets.drawing.stage import render_window
from riglens.widgets.timers import Timers, single_shot
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState

PAUSE_MS = 120
"""Least time between pictures during a drag: each takes about as long as a frame of the view."""
_SHARE, _MOST_PX, _LEAST_PX = 0.27, 384, 150
"""Width as a share of the view's, and its limits; a view that has no room for it shows none."""
_MARGIN_PX, _LINE_PX, _RIM_PX, _GAP_PX = 12, 22, 2, 8


class CameraInset(QWidget):
    """A frame with the picture, name, pixels and field of view of a camera; hidden without one. Mouse events go
    through to the view."""

    def __init__(self, view: QWidget, timers: Timers = single_shot) -> None:
        super().__init__(view)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()
        self._is_wanted = True
        self._state: SceneState | None = None
        self._seen: SceneState | None = None
        self._plotter: pv.Plotter | None = None
        self._scene: DrawnScene | None = None
        self._image = QImage()
        self._soon = timers(self, PAUSE_MS, self._draw)

    @property
    def box(self) -> Box | None:
        """Return the pixels that it covers in the view, None while it is hidden."""
        view = self.parentWidget()
        if self.isHidden() or view is None:
            return None
        ratio, place = view.devicePixelRatioF(), self.geometry()
        low = view.height() - place.y() - place.height()
        return Box(place.x() * ratio, low * ratio, place.width() * ratio, place.height() * ratio)

    def set_wanted(self, is_wanted: bool) -> None:
        """Show pictures of cameras, or none."""
        self._is_wanted = is_wanted
        if self._state is not None:
            self.follow(self._state)

    def follow(self, state: SceneState) -> None:
        """Show the picture of the state's selected camera, soon; none for another sensor and a lens too wide."""
        self._state = state
        seen = _seen(state) if self._is_wanted else None
        if seen is None or not self._place(seen):
            self._seen = None
            self._soon.stop()
            self.hide()
        elif seen != self._seen:
            self._seen = seen
            if not self._soon.isActive():
                self._soon.start()
            self.show()

    def update_footprints(self) -> None:
        """Show footprints that have been found meanwhile, soon."""
        if self._scene is not None and self._scene.update_footprints() and not self._soon.isActive():
            self._soon.start()

    def _place(self, seen: SceneState) -> bool:
        """Take the upper left corner of the view; return whether there is room."""
        view, camera = self.parentWidget(), seen.selected_sensor
        if view is None or not isinstance(camera, Camera):
            return False
        width = min(_MOST_PX, round(_SHARE * view.width()))
        height = round((width - 2 * _RIM_PX) * camera.image[1] / camera.image[0]) + 2 * _RIM_PX + _LINE_PX
        if width < _LEAST_PX or height > view.height() / 2:
            return False
        self.setGeometry(QRect(_MARGIN_PX, _MARGIN_PX, width, height))
        return True

    def _draw(self) -> None:
        """Draw the picture at the size at which it is shown."""
        seen = self._seen
        camera = None if seen is None else seen.selected_sensor
        if seen is None or not isinstance(camera, Camera):
            return
        ratio = self.devicePixelRatioF()
        size = (
            max(1, round((self.width() - 2 * _RIM_PX) * ratio)),
            max(1, round((self.height() - 2 * _RIM_PX - _LINE_PX) * ratio)),
        )
        bend = bend_of(camera, size)
        if bend is None:
            return
        if self._plotter is None or self._scene is None:
            self._plotter = pv.Plotter(off_screen=True, window_size=list(bend.size), lighting="none")
            render_window(self._plotter).SetMultiSamples(0)
            self._scene = DrawnScene(self._plotter, seen.palette, ratio, awaits_footprints=True)
        window = render_window(self._plotter)
        window.SetSize(*bend.size)
        self._scene.set_pixel_ratio(ratio)
        self._scene.show(replace(seen, camera=bend.view))
        self._scene.set_smooth(True)
        self._scene.prepare()
        window.Render()
        self._image = image_of(bend.of(pixels_of(window)))
        self.update()

    def release(self) -> None:
        """Release the graphics."""
        self._soon.stop()
        if self._plotter is not None:
            self._plotter.close()
        self._plotter = self._scene = None

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw rim, picture and caption."""
        seen = self._seen
        camera = None if seen is None else seen.selected_sensor
        if seen is None or not isinstance(camera, Camera):
            return
        palette = seen.palette
        painter, inside = (
            QPainter(self),
            self.rect().adjusted(_RIM_PX, _RIM_PX, -_RIM_PX, -_LINE_PX - _RIM_PX),
        )
        painter.fillRect(self.rect(), QColor(palette.background))
        painter.fillRect(inside.adjusted(-_RIM_PX, -_RIM_PX, _RIM_PX, _RIM_PX), QColor(palette.selected))
        painter.fillRect(inside, QColor(palette.ground))
        if not self._image.isNull():
            painter.drawImage(inside, self._image)
        line = self.rect().adjusted(6, inside.bottom() + _RIM_PX, -6, 0)
        painter.setPen(QColor(palette.text))
        _write(painter, camera, line)
        painter.end()


def _write(painter: QPainter, camera: Camera, line: QRect) -> None:
    """Write the name of a camera, and beside it pixels and field of view as far as they have room."""
    font, centre = painter.font(), Qt.AlignmentFlag.AlignVCenter
    font.setPointSizeF(font.pointSizeF() * 0.86)
    bold = QFont(font)
    bold.setBold(True)
    name = visible(camera.name)
    left_px = line.width() - QFontMetrics(bold).horizontalAdvance(name) - _GAP_PX
    (width, height), wide = camera.image, f"{field_of_view_deg(camera)[0]:.0f}°"
    texts = (f"{width} × {height} px · {wide}", wide, "")
    about = next(text for text in texts if QFontMetrics(font).horizontalAdvance(text) <= max(left_px, 0))
    painter.setFont(font)
    painter.drawText(line, centre | Qt.AlignmentFlag.AlignRight, about)
    painter.setFont(bold)
    name = QFontMetrics(bold).elidedText(name, Qt.TextElideMode.ElideRight, line.width())
    painter.drawText(line, centre | Qt.AlignmentFlag.AlignLeft, name)


def _seen(state: SceneState) -> SceneState | None:
    """Return the scene through the selected camera's lens, or None if no camera is selected or its view is too wide."""
    camera = state.selected_sensor
    view = through(camera) if isinstance(camera, Camera) and state.show_selection else None
    if camera is None or view is None:
        return None
    return state.seen_by(camera.name, view)


def pixels_of(window: vtkRenderWindow) -> NDArray[np.uint8]:
    """Return the pixels (h, w, 4) of a window that was drawn, from the top row."""
    width, height = window.GetSize()
    pixels = vtkUnsignedCharArray()
    window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
    return np.asarray(numpy_of(pixels).reshape(height, width, 4)[::-1])


def image_of(pixels: NDArray[np.uint8]) -> QImage:
    """Return pixels (h, w, 4) as an opaque picture."""
    height, width = pixels.shape[:2]
    rows = np.ascontiguousarray(pixels)
    return QImage(rows.data, width, height, 4 * width, QImage.Format.Format_RGBX8888).copy()
