"""A camera's image: boxes of a frame by class, ground, horizon, ROI and the car's own body, through its lens."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QWidget

from riglens.core.scene.boxes import CLASSES
from riglens.core.view.camera_picture import CameraPicture, Face
from riglens.core.view.projection import Points
from riglens.widgets.maps.paint import LEGEND_PX, READOUT_PX, ImageView, argb, draw_swatches, image_of
from riglens.widgets.theme import CLASS_COLOURS, DARK_TONES, Tones, mix

_MARGIN_PX, _MOST_ABOVE_PX = 6.0, 24.0
_SKY = {True: "#2a3442", False: "#dbe6f2"}
_GROUND = {True: "#1d2127", False: "#c9cfd6"}
_LINE = {True: "#4b5563", False: "#97a2af"}
_ROI = "#eab308"
_BODY = {True: "#8d98a6", False: "#5d6b7b"}
_RAY_PX = 5.0


class CameraView(ImageView):
    """View of a CameraPicture as large as fits; the border is that of the native image."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMinimumSize(160, 100)
        self._picture: CameraPicture | None = None
        self._body: QImage | None = None
        self._shows_rays = False

    def set_picture(self, picture: CameraPicture | None) -> None:
        """Show another picture, or none."""
        self._picture, self._body = picture, None
        self.update()

    def set_rays(self, shown: bool) -> None:
        """Draw where the rays of the metric pass the image, or not."""
        self._shows_rays = shown
        self.update()

    @property
    def image_area(self) -> QRectF:
        """Return the area of the image on the widget."""
        below = READOUT_PX + LEGEND_PX
        room = QRectF(self.rect()).adjusted(_MARGIN_PX, _MARGIN_PX, -_MARGIN_PX, -below)
        if self._picture is None or room.width() <= 0.0 or room.height() <= 0.0:
            return QRectF()
        width, height = self._picture.camera.image
        scale = min(room.width() / width, room.height() / height)
        area = QRectF(0.0, 0.0, width * scale, height * scale)
        area.moveCenter(room.center())
        area.moveTop(min(area.top(), room.top() + _MOST_ABOVE_PX))
        return area

    @property
    def readout_area(self) -> QRectF:
        """Two lines right below the image."""
        return QRectF(8.0, self.image_area.bottom() + 4.0, self.width() - 16.0, READOUT_PX)

    def readout(self) -> str:
        """Describe the place under the mouse, or the content of the image."""
        picture = self._picture
        if picture is None:
            return ""
        if self._hover is None or not self.image_area.contains(self._hover):
            return self._summary(picture)
        x, y = self._to_pixel(self._hover, picture)
        place = f"pixel {x:.0f}, {y:.0f}"
        if _mask_at(picture, x, y):
            return f"{place} · own car"
        face = picture.face_at(x, y)
        return place if face is None else f"{place} · {CLASSES[face.cls]}, {face.range_m:.1f} m away"

    def _summary(self, picture: CameraPicture) -> str:
        counts = [f"{name} {count}" for name, count in picture.boxes_seen.items() if count]
        width, height = picture.camera.image
        body = f" · own car {100 * picture.body_share:.0f} %" if picture.body_share > 0.005 else ""
        return f"{width} × {height} px · sees {', '.join(counts) or 'no boxes'}{body}"

    def _to_pixel(self, at: QPointF, picture: CameraPicture) -> tuple[float, float]:
        area = self.image_area
        width, height = picture.camera.image
        return (at.x() - area.left()) / area.width() * width, (at.y() - area.top()) / area.height() * height

    # ------------------------------------------------------------------ painting
    def draw(self, painter: QPainter, look: Tones) -> None:
        """Draw the image, a line around it, and what its colours mean."""
        if self._picture is None:
            return
        is_dark = look is DARK_TONES
        painter.save()
        self._draw_image(painter, self._picture, is_dark)
        painter.restore()
        painter.setPen(QPen(QColor(look.muted), 1.0))
        painter.drawRect(self.image_area)
        words = self.readout_area
        legend = QRectF(words.left(), words.bottom(), words.width(), LEGEND_PX)
        draw_swatches(painter, legend, {**CLASS_COLOURS, "own car": _BODY[is_dark], "region": _ROI}, look)

    def _draw_image(self, painter: QPainter, picture: CameraPicture, dark: bool) -> None:
        area = self.image_area
        width, height = picture.camera.image
        painter.setClipRect(area)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(area, QColor(_SKY[dark]))
        to_widget = QTransform.fromTranslate(area.left(), area.top())
        to_widget.scale(area.width() / width, area.height() / height)
        painter.setTransform(to_widget, True)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(_GROUND[dark]))
        if len(picture.ground_px):
            painter.drawPolygon(polygon(picture.ground_px))
        _draw_lines(painter, picture.grid_px, QColor(_LINE[dark]), 1.0)
        _draw_lines(painter, picture.horizon_px, QColor(_LINE[dark]), 1.0)
        _draw_lines(painter, picture.roi_px, QColor(_ROI), 1.2, Qt.PenStyle.DashLine)
        for face in picture.faces:
            _draw_face(painter, face)
        self._draw_body(painter, picture, dark)
        if self._shows_rays:
            _draw_rays(painter, picture, area.width() / width)

    def _draw_body(self, painter: QPainter, picture: CameraPicture, dark: bool) -> None:
        if not picture.body.any():
            return
        if self._body is None:
            self._body = image_of(_body_colours(dark)[picture.body])
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawImage(QRectF(0.0, 0.0, *picture.camera.image), self._body)

    def changeEvent(self, event: QEvent) -> None:
        self._body = None  # drawn anew in the colours of the theme
        super().changeEvent(event)

    def sizeHint(self) -> QSize:
        return QSize(360, 230)


def polygon(corners_px: Points) -> QPolygonF:
    """Return corners (n, 2) as a Qt polygon."""
    return QPolygonF([QPointF(x, y) for x, y in corners_px.tolist()])


def _draw_lines(
    painter: QPainter,
    lines: list[Points],
    colour: QColor,
    width: float,
    style: Qt.PenStyle = Qt.PenStyle.SolidLine,
) -> None:
    pen = QPen(colour, width, style)
    pen.setCosmetic(True)
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for line in lines:
        painter.drawPolyline(polygon(line))


def _draw_face(painter: QPainter, face: Face) -> None:
    base = CLASS_COLOURS[CLASSES[face.cls]]
    pen = QPen(QColor(mix(base, "#000000", 0.55)), 1.0)
    pen.setCosmetic(True)
    painter.setPen(pen)
    painter.setBrush(QColor(mix("#000000", base, 0.45 + 0.55 * min(1.0, face.light / 0.82))))
    painter.drawPolygon(polygon(face.corners_px))


def _draw_rays(painter: QPainter, picture: CameraPicture, scale: float) -> None:
    """Draw where rays of the metric pass through the image: all, or few enough to tell them apart."""
    width, height = picture.camera.image
    columns, rows = picture.camera.resolution
    step_x = max(1, round(_RAY_PX * columns / (width * scale)))
    step_y = max(1, round(_RAY_PX * rows / (height * scale)))
    x = (np.arange(columns)[step_x // 2 :: step_x] + 0.5) * width / columns
    y = (np.arange(rows)[step_y // 2 :: step_y] + 0.5) * height / rows
    pen = QPen(QColor("#ffffff"), 1.4)
    pen.setCosmetic(True)
    painter.setPen(pen)
    painter.drawPoints(polygon(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)))


def _body_colours(dark: bool) -> np.ndarray:
    """Return the colour per value of the body mask, 0xAARRGGBB: nothing, then darker to lighter."""
    table = np.array(
        [argb(mix("#000000", _BODY[dark], 0.35 + 0.65 * value / 255.0)) for value in range(256)], np.uint32
    )
    table[0] = 0
    return table


def _mask_at(picture: CameraPicture, x_px: float, y_px: float) -> bool:
    rows, columns = picture.body.shape
    width, height = picture.camera.image
    row, column = int(y_px / height * rows), int(x_px / width * columns)
    return 0 <= row < rows and 0 <= column < columns and bool(picture.body[row, column])
