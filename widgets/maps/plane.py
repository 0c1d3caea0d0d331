"""Where the ground plane lies on a widget: x forward up, y left, as in RViz seen from above."""

from __future__ import annotations

from dataclasses import dataclass, replace

from PySide6.QtCore import QPointF, QRectF

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
        """The view that shows `length_m` along x and `width_m` along y about the origin."""
        scale = min(area.height() / (length_m * margin), area.width() / (width_m * margin))
        return cls(area, (0.0, 0.0), max(scale, _MIN_SCALE))

    def to_px(self, x_m: float, y_m: float) -> QPointF:
        """The place of a point on the widget."""
        middle = self.area.center()
        return QPointF(
            middle.x() - (y_m - self.centre_m[1]) * self.scale,
            middle.y() - (x_m - self.centre_m[0]) * self.scale,
        )

    def to_m(self, point: QPointF) -> tuple[float, float]:
        """The point (x, y) of the plane at a place on the widget."""
        middle = self.area.center()
        return (
            self.centre_m[0] + (middle.y() - point.y()) / self.scale,
            self.centre_m[1] + (middle.x() - point.x()) / self.scale,
        )

    def rectangle(self, x_m: tuple[float, float], y_m: tuple[float, float]) -> QRectF:
        """The rectangle between two values of x and two of y."""
        return QRectF(self.to_px(max(x_m), max(y_m)), self.to_px(min(x_m), min(y_m)))

    def zoomed(self, factor: float, about: QPointF) -> PlaneView:
        """Larger by a factor; what is under `about` stays there."""
        scale = min(max(self.scale * factor, _MIN_SCALE), _MAX_SCALE)
        x, y = self.to_m(about)
        moved = replace(self, scale=scale)
        x_after, y_after = moved.to_m(about)
        return replace(moved, centre_m=(self.centre_m[0] + x - x_after, self.centre_m[1] + y - y_after))

    def shifted(self, by: QPointF) -> PlaneView:
        """Pushed along by some pixels."""
        x, y = self.centre_m
        return replace(self, centre_m=(x + by.y() / self.scale, y + by.x() / self.scale))

    def ring_step_m(self, least_px: float = 45.0) -> float:
        """Distance between range rings that keeps them at least so far apart."""
        return next((step for step in _STEPS_M if step * self.scale >= least_px), _STEPS_M[-1])
