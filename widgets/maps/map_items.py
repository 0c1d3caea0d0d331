"""Draw the items over the cells of the map from above, and map metres to pixels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QBrush, QColor, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF

from riglens.core.rig.model import Sensor, Vehicle
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensors.registry import kind_of
from riglens.core.view.outlook import Gap
from riglens.widgets.maps.paint import BAR_PX, SHARE_MAP, draw_bar, draw_tag
from riglens.widgets.sensors.appearance import appearance_of, colour_of
from riglens.widgets.theme import DARK_TONES, SELECTED_COLOUR, Tones

_MIN_SCALE, _MAX_SCALE = 0.2, 2000.0
_STEPS_M = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)


@dataclass(frozen=True)
class PlaneView:
    """A part of the plane in a rectangle of the widget: what lies in its middle, and pixels per metre."""

    area: QRectF
    centre_m: tuple[float, float] = (0.0, 0.0)
    scale: float = 10.0

    @classmethod
    def fitted(cls, area: QRectF, length_m: float, width_m: float, margin: float = 1.06) -> PlaneView:
        """Return the view that shows `length_m` along x and `width_m` along y about the origin."""
        scale = min(area.height() / (length_m * margin), area.width() / (width_m * margin))
        return cls(area, (0.0, 0.0), max(scale, _MIN_SCALE))

    def to_px(self, x_m: float, y_m: float) -> QPointF:
        """Return the place of a point on the widget."""
        middle = self.area.center()
        return QPointF(
            middle.x() - (y_m - self.centre_m[1]) * self.scale,
            middle.y() - (x_m - self.centre_m[0]) * self.scale,
        )

    def to_m(self, point: QPointF) -> tuple[float, float]:
        """Return the point (x, y) of the plane at a place on the widget."""
        middle = self.area.center()
        return (
            self.centre_m[0] + (middle.y() - point.y()) / self.scale,
            self.centre_m[1] + (middle.x() - point.x()) / self.scale,
        )

    def rectangle(self, x_m: tuple[float, float], y_m: tuple[float, float]) -> QRectF:
        """Return the rectangle between two values of x and two of y."""
        return QRectF(self.to_px(max(x_m), max(y_m)), self.to_px(min(x_m), min(y_m)))

    def zoomed(self, factor: float, about: QPointF) -> PlaneView:
        """Return the view enlarged by a factor; the point `about` stays fixed."""
        scale = min(max(self.scale * factor, _MIN_SCALE), _MAX_SCALE)
        x, y = self.to_m(about)
        moved = replace(self, scale=scale)
        x_after, y_after = moved.to_m(about)
        return replace(moved, centre_m=(self.centre_m[0] + x - x_after, self.centre_m[1] + y - y_after))

    def shifted(self, by: QPointF) -> PlaneView:
        """Return the view shifted by some pixels."""
        x, y = self.centre_m
        return replace(self, centre_m=(x + by.y() / self.scale, y + by.x() / self.scale))

    def ring_step_m(self, least_px: float = 45.0) -> float:
        """Return the distance between range rings, in metres, that keeps them far enough apart on the widget."""
        return next((step for step in _STEPS_M if step * self.scale >= least_px), _STEPS_M[-1])


BLIND_COLOUR = "#f0356b"
NO_BOXES = "hardly any boxes here in the data"
DOT_PX = 4.5
_TICK_PX, _WEDGE_PX = 13.0, 20.0
_FLAT = 0.2
_LABEL_ANGLES_DEG = (0, 30, -30, 180, 20, -20, 45, -45, 60, -60, 90, -90, 150, -150, 120, -120)


def draw_rings(painter: QPainter, view: PlaneView, grid: VoxelGrid, tones: Tones) -> None:
    """Draw circles of equal distance with their metres, out to the corners of the ROI."""
    step_m = view.ring_step_m()
    reach_m = math.hypot(grid.roi_m[0], grid.roi_m[1]) / 2
    ink, paper = QColor(tones.muted), QColor(tones.field)
    ink.setAlphaF(0.75)
    paper.setAlphaF(0.7)
    middle = view.to_px(0.0, 0.0)
    radii_m = [number * step_m for number in range(1, int(reach_m / step_m) + 1)]
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(ink, 1.0, Qt.PenStyle.DotLine))
    for radius_m in radii_m:
        painter.drawEllipse(middle, radius_m * view.scale, radius_m * view.scale)
    texts = {radius_m: f"{radius_m:g} m" for radius_m in radii_m}
    metrics = QFontMetricsF(painter.font())
    size = QSizeF(max(map(metrics.horizontalAdvance, texts.values()), default=0.0), metrics.height())
    for radius_m, at in ring_labels(view, roi_rectangle(view, grid), radii_m, size).items():
        draw_tag(painter, at, texts[radius_m], QColor(tones.text), paper)


def ring_labels(view: PlaneView, roi: QRectF, radii_m: Sequence[float], size: QSizeF) -> dict[float, QPointF]:
    """Return where labels of a size go on their rings: along that line from the car where most of them fit.

    A label is left out where it would be cut by the map's edge or by the limit of the ROI.
    """
    room = view.area.adjusted(3.0, 3.0, -3.0, -3.0)
    inner = roi.adjusted(2.0, 2.0, -2.0, -2.0)
    found: list[dict[float, QPointF]] = []
    for angle_deg in _LABEL_ANGLES_DEG:
        x, y = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
        places = {radius: view.to_px(radius * x, radius * y) for radius in radii_m}
        found.append({})
        for radius, at in places.items():
            box = QRectF(
                at.x() - size.width() / 2 - 4,
                at.y() - size.height() / 2 - 2,
                size.width() + 8,
                size.height() + 4,
            )
            if room.contains(box) and (inner.contains(box) or not roi.intersects(box)):
                found[-1][radius] = at
    return max(found, key=len)


def draw_gap(painter: QPainter, view: PlaneView, grid: VoxelGrid, gap: Gap, tones: Tones) -> None:
    """Hatch the sector of the ROI in which the data hold no boxes, and label it."""
    reach_m = math.hypot(grid.roi_m[0], grid.roi_m[1])
    angles = [math.radians(gap.from_deg + share * (gap.to_deg - gap.from_deg) / 60) for share in range(61)]
    sector = QPolygonF([view.to_px(0.0, 0.0)])
    for angle in angles:
        sector.append(view.to_px(reach_m * math.cos(angle), reach_m * math.sin(angle)))
    outline, roi = QPainterPath(), QPainterPath()
    outline.addPolygon(sector)
    roi.addRect(roi_rectangle(view, grid))
    ink = QColor(tones.muted)
    ink.setAlphaF(0.45)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QBrush(ink, Qt.BrushStyle.BDiagPattern))
    painter.drawPath(outline.intersected(roi))
    middle = angles[len(angles) // 2]
    half_m = min(grid.roi_m[0], grid.roi_m[1]) / 4
    at = view.to_px(half_m * math.cos(middle), half_m * math.sin(middle))
    draw_tag(painter, at, NO_BOXES, QColor(tones.text), QColor(tones.panel))


def draw_roi(painter: QPainter, view: PlaneView, grid: VoxelGrid, tones: Tones) -> None:
    """Draw the limit of the ROI."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(QColor(tones.text), 1.2))
    painter.drawRect(roi_rectangle(view, grid))


def roi_rectangle(view: PlaneView, grid: VoxelGrid) -> QRectF:
    """Return where the ROI lies on the widget."""
    x, y = grid.roi_m[0] / 2, grid.roi_m[1] / 2
    return view.rectangle((-x, x), (-y, y))


def draw_car(painter: QPainter, view: PlaneView, vehicle: Vehicle, tones: Tones) -> None:
    """Draw the car's outline with its windscreen, which marks the front."""
    half_l, half_w = vehicle.length / 2, vehicle.width / 2
    fill = QColor(tones.text)
    fill.setAlphaF(0.9)
    painter.setPen(QPen(QColor(tones.field), 1.4))
    painter.setBrush(fill)
    rounding = 0.28 * vehicle.width * view.scale
    painter.drawRoundedRect(view.rectangle((-half_l, half_l), (-half_w, half_w)), rounding, rounding)
    glass = QPainterPath(view.to_px(0.12 * vehicle.length, 0.76 * half_w))
    glass.quadTo(view.to_px(0.24 * vehicle.length, 0.0), view.to_px(0.12 * vehicle.length, -0.76 * half_w))
    glass.lineTo(view.to_px(0.03 * vehicle.length, -0.64 * half_w))
    glass.lineTo(view.to_px(0.03 * vehicle.length, 0.64 * half_w))
    glass.closeSubpath()
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(tones.field))
    painter.drawPath(glass)


def draw_sensor(painter: QPainter, view: PlaneView, sensor: Sensor, selected: bool, tones: Tones) -> None:
    """Draw a sensor with its heading: a dot with a tick, or with its field of view where that has corners."""
    colour = QColor(colour_of(sensor.kind))
    at = view.to_px(sensor.position[0], sensor.position[1])
    edge = QColor(tones.field if tones is DARK_TONES else tones.text)
    painter.setPen(QPen(colour, 1.6, c=Qt.PenCapStyle.RoundCap))
    if appearance_of(sensor.kind).has_corners:
        _draw_wedge(painter, at, sensor, colour)
    else:
        tick = _on_screen(sensor, np.array([1.0, 0.0, 0.0]), _TICK_PX)
        if tick is not None:
            painter.drawLine(at, at + tick)
    if selected:
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(edge, 4.0))
        painter.drawEllipse(at, DOT_PX + 3.0, DOT_PX + 3.0)
        painter.setPen(QPen(QColor(SELECTED_COLOUR), 2.2))
        painter.drawEllipse(at, DOT_PX + 3.0, DOT_PX + 3.0)
    painter.setPen(QPen(edge if sensor.enabled else colour, 1.2))
    painter.setBrush(colour if sensor.enabled else QColor(tones.field))
    painter.drawEllipse(at, DOT_PX, DOT_PX)


def draw_outside(painter: QPainter, view: PlaneView, sensor: Sensor) -> None:
    """Draw an arrow at the edge of the map towards a sensor beyond it."""
    at = outside_mark(view, sensor)
    if at is None:
        return
    towards = view.to_px(sensor.position[0], sensor.position[1]) - view.area.center()
    painter.save()
    painter.translate(at)
    painter.rotate(math.degrees(math.atan2(towards.y(), towards.x())))
    arrow = QPainterPath(QPointF(DOT_PX + 2.0, 0.0))
    arrow.lineTo(-DOT_PX, DOT_PX)
    arrow.lineTo(-DOT_PX, -DOT_PX)
    arrow.closeSubpath()
    painter.setPen(QPen(QColor("#000000"), 1.0))
    painter.setBrush(QColor(colour_of(sensor.kind)))
    painter.drawPath(arrow)
    painter.restore()


def outside_mark(view: PlaneView, sensor: Sensor) -> QPointF | None:
    """Return where on the edge a sensor beyond the map is marked, None for one on the map."""
    at, area = view.to_px(sensor.position[0], sensor.position[1]), view.area
    if area.contains(at):
        return None
    inner = area.adjusted(8.0, 8.0, -8.0, -8.0)
    return QPointF(
        min(max(at.x(), inner.left()), inner.right()), min(max(at.y(), inner.top()), inner.bottom())
    )


def _draw_wedge(painter: QPainter, at: QPointF, sensor: Sensor, colour: QColor) -> None:
    """Draw the field of view between the ends of the middle row of rays; ahead is its third corner, beyond 180°."""
    columns, rows = sensor.resolution
    ends = rows // 2 * columns + np.array([0, columns // 2, columns - 1])
    wedge = QPainterPath(at)
    for ray in kind_of(sensor).directions(sensor, ends):
        corner = _on_screen(sensor, ray, _WEDGE_PX)
        if corner is not None:
            wedge.lineTo(at + corner)
    wedge.closeSubpath()
    fill = QColor(colour)
    fill.setAlphaF(0.22 if sensor.enabled else 0.0)
    painter.setBrush(fill)
    painter.setPen(QPen(colour, 1.0))
    painter.drawPath(wedge)


def _on_screen(sensor: Sensor, ray: NDArray[np.float64], length_px: float) -> QPointF | None:
    """Return a ray of the sensor frame on the map, of a length in pixels; None if it is nearly vertical."""
    x, y, z = sensor.pose.rotation() @ ray
    flat = math.hypot(x, y)
    if not flat >= _FLAT * math.hypot(flat, z):  # no ray at all is NaN
        return None
    return QPointF(-y / flat * length_px, -x / flat * length_px)


def draw_legend(painter: QPainter, area: QRectF, tones: Tones) -> None:
    """Draw the colour bar of the seen share, and the key of blind areas."""
    metrics = QFontMetricsF(painter.font())
    text = "nothing seen"
    wide = metrics.horizontalAdvance(text) + BAR_PX + 6.0
    bar = QRectF(area.left(), area.top(), max(40.0, area.width() - wide - 14.0), area.height())
    draw_bar(painter, bar, SHARE_MAP, [(0.0, "> 0"), (0.5, "50"), (1.0, "100 %")], tones)
    left = area.right() - wide
    painter.fillRect(QRectF(left, area.top(), BAR_PX, BAR_PX), QColor(BLIND_COLOUR))
    painter.setPen(QColor(tones.text))
    painter.drawText(QPointF(left + BAR_PX + 5.0, area.top() + BAR_PX), text)
