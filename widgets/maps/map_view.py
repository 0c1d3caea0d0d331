"""The map from above: the share of the uncertain space over each spot that the sensors see."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.grid import VoxelGrid
from riglens.core.shown_text import visible
from riglens.core.view.outlook import Gap
from riglens.core.view.top_view import BLIND, EMPTY, LEAST, MOST, TopView
from riglens.widgets.maps.ground_items import draw_ground_legend, ground_colours, ground_text, summary_of
from riglens.widgets.maps.lowest_items import (
    Lowest,
    draw_lowest_legend,
    lowest_colours,
    lowest_summary,
    lowest_text,
)
from riglens.widgets.maps.map_items import (
    BLIND_COLOUR,
    NO_BOXES,
    PlaneView,
    draw_car,
    draw_gap,
    draw_legend,
    draw_outside,
    draw_rings,
    draw_roi,
    draw_sensor,
    outside_mark,
    roi_rectangle,
)
from riglens.widgets.maps.paint import SHARE_MAP, argb, colours, draw_message, image_of
from riglens.widgets.panels.controls.style import small_font, tones

if TYPE_CHECKING:  # made by the thread that counts, which loads the compiler
    from riglens.core.figures.heatmaps import OverGround

_WORDS_PX = 30.0
_LEGEND_PX = 30.0 + _WORDS_PX
_PICK_PX = 10.0
AXES = "↑ x  ← y"
MANY = {"car": "cars", "bicycle": "bicycles", "pedestrian": "pedestrians"}


class MapPicture(QWidget):
    """Drawing of a TopView with car, sensors and rings; describes the place under the mouse."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumSize(160, 120)
        self._rig = Rig()
        self._hidden: frozenset[str] = frozenset()
        self._selected: frozenset[str] = frozenset()
        self._grid = VoxelGrid()
        self._top: TopView | None = None
        self._image: QImage | None = None
        self._ground: OverGround | None = None
        self._lowest: Lowest | None = None
        self._message = ""
        self._gap: Gap | None = None
        self._view: PlaneView | None = None
        self._hover: QPointF | None = None

    # ------------------------------------------------------------------ what is shown
    def set_rig(self, rig: Rig, hidden: frozenset[str], selected: frozenset[str]) -> None:
        """Show car and sensors; hidden ones are left out."""
        self._rig, self._hidden, self._selected = rig, hidden, selected
        self.update()

    def set_grid(self, grid: VoxelGrid) -> None:
        """Show the whole of another region of interest; the old cells are removed."""
        self._grid, self._top, self._image, self._view = grid, None, None, None
        self._ground = self._lowest = None
        self.update()

    def set_gap(self, gap: Gap | None) -> None:
        """Show the sector in which the data hold no boxes, if there is one."""
        self._gap = gap
        self.update()

    def set_top_view(self, top: TopView | None) -> None:
        """Show other cells, or none."""
        self._top, self._image = top, None
        self.update()

    def set_ground(self, ground: OverGround | None) -> None:
        """Show objects over the ground instead of coverage, None for coverage."""
        self._ground, self._image = ground, None
        self.update()

    def set_lowest(self, lowest: Lowest | None) -> None:
        """Show lowest visible heights in place of all else, None for no more; all of them, if all was shown before."""
        before, self._lowest, self._image = self._lowest, lowest, None
        if (before is None) != (lowest is None):
            self._view = None
        self.update()

    def set_message(self, text: str) -> None:
        """Show a sentence over the map, none when it is empty."""
        if text != self._message:
            self._message = text
            self.update()

    @property
    def message(self) -> str:
        """The sentence over the map."""
        return self._message

    @property
    def plane(self) -> PlaneView:
        """Return the mapping from the ground to the widget."""
        area = QRectF(0.0, 0.0, self.width(), max(1.0, self.height() - _LEGEND_PX))
        if self._view is None or self._view.area != area:
            before = self._view
            fitted = PlaneView.fitted(area, *self._size_m)
            self._view = fitted if before is None else PlaneView(area, before.centre_m, before.scale)
        return self._view

    @property
    def _size_m(self) -> tuple[float, float]:
        """Length and width of all that can be shown."""
        return self._grid.roi_m[:2] if self._lowest is None else self._lowest.size_m

    def fit(self) -> None:
        """Show the whole ROI, or all ground with lowest heights."""
        self._view = None
        self.update()

    def readout(self) -> str:
        """Describe the place under the mouse."""
        if self._hover is None or not self.plane.area.contains(self._hover):
            return self._summary()
        sensor = self._sensor_at(self._hover)
        x, y = self.plane.to_m(self._hover)
        place = f"x {x:.1f}  y {y:.1f} m"
        if sensor is not None:
            return " · ".join([visible(sensor.name), *self._state_of(sensor), place])
        if self._lowest is not None:
            return f"{place} · {lowest_text(self._lowest, (x, y))}"
        if self._ground is not None:
            return f"{place} · {ground_text(self._ground, (x, y))}"
        cell = self._top.cell_at(x, y) if self._top is not None else None
        if self._top is None or cell is None:
            return f"{place} · outside the ROI" if self._top is not None else place
        if self._top.levels[cell] == EMPTY:
            is_in_gap = self._gap is not None and self._gap.holds(np.degrees(np.arctan2([y], [x])))[0]
            return f"{place} · {NO_BOXES if is_in_gap else f'no {MANY[self._top.class_name]} here'}"
        return f"{place} · {100 * self._top.seen[cell]:.0f} % seen of {self._top.entropy_nat[cell]:.3g} nat"

    def _summary(self) -> str:
        said = []
        if self._lowest is not None:
            said.append(lowest_summary(self._lowest))
        elif self._ground is not None:
            said.append(summary_of(self._ground))
        elif self._top is not None and not self._top.is_empty:
            share = 100 * self._top.blind_share()
            said.append(f"{share:.1f} % of the area with {MANY[self._top.class_name]} is blind")
        outside = [visible(sensor.name) for sensor in self._shown() if self._is_outside(sensor)]
        if outside:
            said.append(f"outside the ROI: {', '.join(outside)}")
        return " · ".join(said)

    def _state_of(self, sensor: Sensor) -> list[str]:
        """Return the unusual states of a sensor."""
        said = {"outside the ROI": self._is_outside(sensor), "disabled": not sensor.enabled}
        return [text for text, is_so in said.items() if is_so]

    def _is_outside(self, sensor: Sensor) -> bool:
        low, roi = self._grid.origin_m, self._grid.roi_m
        return not all(a <= p < a + b for a, b, p in zip(low, roi, sensor.position, strict=True))

    # ------------------------------------------------------------------ painting
    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        look, view = tones(), self.plane
        painter.fillRect(self.rect(), QColor(look.field))
        painter.setFont(small_font(painter.font()))
        painter.save()
        painter.setClipRect(view.area)
        self._draw_cells(painter, view)
        if self._gap is not None:
            draw_gap(painter, view, self._grid, self._gap, look)
        draw_rings(painter, view, self._grid, look)
        draw_roi(painter, view, self._grid, look)
        draw_car(painter, view, self._rig.vehicle, look)
        for sensor in sorted(self._shown(), key=lambda sensor: sensor.name in self._selected):
            draw_sensor(painter, view, sensor, sensor.name in self._selected, look)
            draw_outside(painter, view, sensor)
        if self._message:
            draw_message(painter, view.area, self._message, look)
        painter.restore()
        self._draw_footer(painter)
        painter.end()

    def _draw_cells(self, painter: QPainter, view: PlaneView) -> None:
        shown = self._lowest or (self._top if self._ground is None else self._ground.ground)
        if shown is None:
            return
        if self._image is None:
            self._image = image_of(self._colours()[::-1, ::-1])
        ny, nx = self._image.width(), self._image.height()
        x, y = shown.origin_m
        target = view.rectangle((x, x + nx * shown.cell_m), (y, y + ny * shown.cell_m))
        shrinks = shown.cell_m * view.scale * self.devicePixelRatioF() < 1.0
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, shrinks)
        if self._lowest is None:
            painter.setClipRect(roi_rectangle(view, self._grid), Qt.ClipOperation.IntersectClip)
        painter.drawImage(target, self._image)
        painter.setClipRect(view.area)

    def _colours(self) -> NDArray[np.uint32]:
        """Return the colour of each cell (nx, ny), 0xAARRGGBB."""
        if self._lowest is not None:
            return lowest_colours(self._lowest)
        if self._ground is not None:
            return ground_colours(self._ground)
        assert self._top is not None
        return np.asarray(_cell_colours()[self._top.levels])

    def _draw_footer(self, painter: QPainter) -> None:
        look, top = tones(), self.height() - _LEGEND_PX
        painter.fillRect(QRectF(0.0, top, self.width(), _LEGEND_PX), QColor(look.panel))
        painter.setPen(QColor(look.border))
        painter.drawLine(QPointF(0.0, top), QPointF(self.width(), top))
        room = QRectF(8.0, top + 5.0, self.width() - 16.0, 22.0)
        if self._lowest is not None:
            draw_lowest_legend(painter, room, self._lowest, look)
        elif self._ground is None:
            draw_legend(painter, room, look)
        else:
            draw_ground_legend(painter, room, self._ground, look)
        box = QRectF(8.0, top + 28.0, self.width() - 16.0, _WORDS_PX)
        painter.setPen(QColor(look.muted))
        painter.drawText(box, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop, AXES)
        box.setWidth(box.width() - painter.fontMetrics().horizontalAdvance(AXES) - 10.0)
        painter.setPen(QColor(look.text))
        painter.drawText(box, int(Qt.AlignmentFlag.AlignLeft | Qt.TextFlag.TextWordWrap), self.readout())

    def resizeEvent(self, event: QResizeEvent) -> None:
        old = event.oldSize()
        if self._view is not None and old.isValid():
            fitted = PlaneView.fitted(self._view.area, *self._size_m)
            if fitted == self._view:
                self._view = None  # it showed everything, and continues to

    def sizeHint(self) -> QSize:
        return QSize(300, 420)

    # ------------------------------------------------------------------ what is where
    def _shown(self) -> list[Sensor]:
        return [sensor for sensor in self._rig.sensors if sensor.name not in self._hidden]

    def _sensor_at(self, at: QPointF) -> Sensor | None:
        """Return the sensor nearest to a place, within reach of the mouse; the highest of those at the same spot."""
        found: list[tuple[float, float, Sensor]] = []
        for sensor in self._shown():
            mark = outside_mark(self.plane, sensor)
            offset = (mark or self.plane.to_px(sensor.position[0], sensor.position[1])) - at
            distance = math.hypot(offset.x(), offset.y())
            if distance <= _PICK_PX:
                found.append((round(distance), -sensor.position[2], sensor))
        return min(found, key=lambda entry: entry[:2])[2] if found else None


def _cell_colours() -> np.ndarray:
    """Return the colour per level of a top view, 0xAARRGGBB: nothing, blind, and the shares."""
    table = np.zeros(256, np.uint32)
    table[BLIND] = argb(BLIND_COLOUR)
    shares = np.linspace(0.0, 255.0, MOST - LEAST + 1).round().astype(int)
    table[LEAST : MOST + 1] = colours(SHARE_MAP)[shares]
    table[EMPTY] = 0
    return table


_CLICK_PX = 4.0
_WHEEL = 1.2
HINT = "Wheel: zoom · drag: pan · click: select, or aim the view · double-click: fit"


class MapView(MapPicture):
    """A MapPicture that can be moved, and signals what was clicked."""

    sensor_clicked = Signal(str)
    place_clicked = Signal(float, float)
    """x and y in metres of a spot without a sensor."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self.setToolTip(HINT)
        self._pressed: QPointF | None = None
        self._last: QPointF | None = None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._pressed = self._last = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        at = event.position()
        if self._last is not None and event.buttons() and self._is_drag(at):
            self._view = self.plane.shifted(at - self._last)
            self._last, self._pressed = at, None
        self._hover = at
        self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        pressed, self._pressed, self._last = self._pressed, None, None
        if pressed is None or event.button() != Qt.MouseButton.LeftButton:
            return
        sensor = self._sensor_at(event.position())
        if sensor is not None:
            self.sensor_clicked.emit(sensor.name)
        elif self.plane.area.contains(event.position()):
            self.place_clicked.emit(*self.plane.to_m(event.position()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self._pressed = self._last = None
        if self._sensor_at(event.position()) is None:
            self.fit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        factor = _WHEEL ** (event.angleDelta().y() / 120.0)
        self._view = self.plane.zoomed(factor, event.position())
        event.accept()
        self.update()

    def leaveEvent(self, event: QEvent) -> None:
        self._hover = None
        self.update()

    def _is_drag(self, at: QPointF) -> bool:
        if self._pressed is None:
            return True
        moved = at - self._pressed
        return math.hypot(moved.x(), moved.y()) > _CLICK_PX
