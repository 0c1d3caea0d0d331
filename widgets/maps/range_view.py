"""A LiDAR's range image: one row per beam, one column per azimuth, coloured by range or by what was hit."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen
from PySide6.QtWidgets import QWidget

from riglens.core.scene.boxes import CLASSES
from riglens.core.view.hits import BODY, GROUND, NOTHING
from riglens.core.view.range_image import RangeImage
from riglens.widgets.maps.paint import (
    LEGEND_PX,
    RANGE_MAP,
    READOUT_PX,
    ImageView,
    argb,
    colours,
    draw_bar,
    draw_swatches,
    image_of,
)
from riglens.widgets.theme import CLASS_COLOURS, Tones

Colouring = Literal["range", "hit"]
_LEFT_PX, _TOP_PX, _RIGHT_PX = 50.0, 6.0, 10.0
_AXIS_PX, _TICK_PX, _BAR_PX = 16.0, 62.0, 320.0
_GROUND_COLOUR, _BODY_COLOUR = "#8a7f70", "#94a3b8"
_REACH_STEP_M = 10.0
_TICK_STEPS = (0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0)


class RangeView(ImageView):
    """View of a RangeImage over the whole widget: one row per beam, evenly spaced whatever the elevations."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumSize(200, 120)
        self._image: RangeImage | None = None
        self._pixels: QImage | None = None
        self._reach_m = 40.0
        self._colouring: Colouring = "range"

    def set_image(self, image: RangeImage | None, reach_m: float = 40.0) -> None:
        """Show another image; colours end at `reach_m` or at the sensor's own range."""
        self._image, self._pixels = image, None
        if image is not None:
            reach = min(reach_m, image.lidar.range_m[1])
            self._reach_m = max(1.0, math.ceil(reach / _REACH_STEP_M) * _REACH_STEP_M)
        self.update()

    def set_colouring(self, colouring: Colouring) -> None:
        """Set whether to colour by range or by what was hit."""
        self._colouring, self._pixels = colouring, None
        self.update()

    @property
    def image_area(self) -> QRectF:
        """Return the area of the image on the widget."""
        if self._image is None:
            return QRectF()
        below = _AXIS_PX + LEGEND_PX + READOUT_PX
        return QRectF(self.rect()).adjusted(_LEFT_PX, _TOP_PX, -_RIGHT_PX, -below)

    @property
    def readout_area(self) -> QRectF:
        """Two lines at the foot."""
        return QRectF(8.0, self.height() - READOUT_PX, self.width() - 16.0, READOUT_PX)

    def readout(self) -> str:
        """Describe the place under the mouse, or the content of the image."""
        image = self._image
        if image is None:
            return ""
        cell = self._cell_at(self._hover) if self._hover is not None else None
        if cell is None:
            return _summary(image)
        row, column = cell
        beam = f"beam {image.beams[row] + 1} of {len(image.lidar.elevations())} · "
        angles = f"{angle_text(image.elevations_deg[row], 2, 'up', 'down')}, " + angle_text(
            image.azimuth_deg(row, column), 1, "left", "right"
        )
        what = hit_name(image, int(image.what[row, column]))
        range_m = image.range_m[row, column]
        return f"{beam if image.lidar.rays is None else ''}{angles} · {what}" + (
            f", {range_m:.1f} m" if math.isfinite(range_m) else ""
        )

    def _cell_at(self, at: QPointF) -> tuple[int, int] | None:
        area, image = self.image_area, self._image
        if image is None or not area.contains(at):
            return None
        rows, columns = image.range_m.shape
        row = int((at.y() - area.top()) / area.height() * rows)
        column = int((at.x() - area.left()) / area.width() * columns)
        return min(row, rows - 1), min(column, columns - 1)

    # ------------------------------------------------------------------ painting
    def draw(self, painter: QPainter, look: Tones) -> None:
        """Draw the image with its axes, and what its colours mean."""
        if self._image is not None:
            self._draw_pixels(painter, self._image, look)
            self._draw_axes(painter, self._image, look)
            self._draw_legend(painter, look)

    def _draw_pixels(self, painter: QPainter, image: RangeImage, look: Tones) -> None:
        area = self.image_area
        painter.fillRect(area, QColor(look.field))
        shown = nearest_of(image, int(area.width() * self.devicePixelRatioF()))
        if self._pixels is None or self._pixels.width() != len(shown):
            found = range_colours(image, self._reach_m) if self._colouring == "range" else hit_colours(image)
            self._pixels = image_of(np.take_along_axis(found, shown.T, axis=1))
        painter.drawImage(area, self._pixels)
        painter.setPen(QPen(QColor(look.border), 1.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(area)

    def _draw_axes(self, painter: QPainter, image: RangeImage, look: Tones) -> None:
        """Draw elevations of some rows on the left, azimuths below."""
        area, metrics = self.image_area, QFontMetricsF(painter.font())
        painter.setPen(QColor(look.muted))
        rows, columns = image.range_m.shape
        for row in spread(rows, int(area.height() / (metrics.height() + 3.0))):
            middle = area.top() + (row + 0.5) / rows * area.height()
            box = QRectF(0.0, middle - metrics.height() / 2, _LEFT_PX - 5.0, metrics.height())
            painter.drawText(box, _RIGHT, f"{image.elevations_deg[row]:.1f}°".replace("-", "−"))
        for column, text in azimuth_ticks(image.azimuths_deg, int(area.width() / _TICK_PX)):
            width = metrics.horizontalAdvance(text) + 2.0
            middle = area.left() + (column + 0.5) / columns * area.width()
            left = min(max(middle - width / 2, area.left()), area.right() - width)
            box = QRectF(left, area.bottom() + 1.0, width, metrics.height())
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)

    def _draw_legend(self, painter: QPainter, look: Tones) -> None:
        area = self.image_area
        legend = QRectF(area.left(), area.bottom() + _AXIS_PX + 3.0, area.width(), LEGEND_PX)
        if self._colouring == "range":
            marks = [(0.0, "0"), (0.5, f"{self._reach_m / 2:g}"), (1.0, f"≥ {self._reach_m:g} m")]
            legend.setWidth(min(legend.width(), _BAR_PX))
            draw_bar(painter, legend, RANGE_MAP, marks, look)
        else:
            others = {"ground": _GROUND_COLOUR, "own car": _BODY_COLOUR}
            draw_swatches(painter, legend, {**CLASS_COLOURS, **others}, look)

    def sizeHint(self) -> QSize:
        return QSize(420, 200)


_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


def spread(count: int, most: int) -> list[int]:
    """Return at most `most` of `count` rows at even steps, beginning with the first."""
    return list(range(0, count, max(1, -(-count // max(1, most)))))


def nearest_of(image: RangeImage, most: int) -> NDArray[np.int64]:
    """Return the column shown for each beam where there are more columns than pixels, (shown, beams): of each group of
    neighbours the one with the nearest hit, so that nothing thin gets lost."""
    beams, columns = image.range_m.shape
    size = -(-columns // max(1, most))
    starts = np.arange(0, columns, size)
    padded = np.full((beams, len(starts) * size), np.inf)
    padded[:, :columns] = image.range_m
    nearest = padded.reshape(beams, len(starts), size).argmin(axis=2)
    return np.asarray((starts + nearest).T, np.int64)


def azimuth_ticks(azimuths_deg: NDArray[np.float64], most: int) -> list[tuple[int, str]]:
    """Return the columns next to round azimuths with their labels, at most `most`."""
    high, low = float(azimuths_deg.max()), float(azimuths_deg.min())
    step = next((step for step in _TICK_STEPS if (high - low) / step < max(1, most)), _TICK_STEPS[-1])
    wanted = np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1) * step
    return [(int(np.argmin(np.abs(azimuths_deg - angle))), azimuth_text(float(angle))) for angle in wanted]


def azimuth_text(azimuth_deg: float) -> str:
    """Return an azimuth with the side it lies on."""
    if azimuth_deg == 0.0 or abs(azimuth_deg) == 180.0:
        return "ahead" if azimuth_deg == 0.0 else "behind"
    return f"{abs(azimuth_deg):g}° {'left' if azimuth_deg > 0 else 'right'}"


def angle_text(angle_deg: float, digits: int, positive: str, negative: str) -> str:
    """Return an angle without a sign, with the side it points to: "3.33° down"."""
    return f"{abs(angle_deg):.{digits}f}° {positive if angle_deg >= 0.0 else negative}"


def hit_name(image: RangeImage, what: int) -> str:
    """Describe the surface that a ray hit."""
    names = {NOTHING: "no return", GROUND: "ground", BODY: "own car"}
    return names[what] if what < 0 else CLASSES[image.box_classes[what]]


def range_colours(image: RangeImage, reach_m: float) -> NDArray[np.uint32]:
    """Return the pixels 0xAARRGGBB by range, clear where nothing came back."""
    level = np.clip(np.nan_to_num(image.range_m, posinf=0.0) / reach_m * 255.0, 0.0, 255.0).astype(np.uint8)
    return np.asarray(np.where(image.what == NOTHING, np.uint32(0), colours(RANGE_MAP)[level]), np.uint32)


def hit_colours(image: RangeImage) -> NDArray[np.uint32]:
    """Return the pixels 0xAARRGGBB by what was hit, clear where nothing came back."""
    of_class = np.array([argb(CLASS_COLOURS[name]) for name in CLASSES], np.uint32)
    table = np.concatenate(
        [of_class[image.box_classes], [argb(_BODY_COLOUR), argb(_GROUND_COLOUR), 0]]
    ).astype(np.uint32)
    return table[image.what]  # BODY, GROUND and NOTHING count from the end


def _summary(image: RangeImage) -> str:
    if image.lidar.rays is not None:
        thinned = "" if image.thinned[1] == 1 else f" (1 in {image.thinned[1]})"
        size = f"{image.lidar.ray_count:,} rays of a scan pattern{thinned}"
        return f"{size} · {image.returns:,} returns, {image.on_boxes:,} on boxes"
    rows, columns = image.range_m.shape
    thin_beams, thin_azimuths = image.thinned
    thinned = "" if image.thinned == (1, 1) else f" (1 in {thin_beams} beams, 1 in {thin_azimuths} azimuths)"
    size = f"{rows} beams × {columns} azimuths{thinned}"
    return f"{size} · {image.returns:,} returns, {image.on_boxes:,} on boxes"
