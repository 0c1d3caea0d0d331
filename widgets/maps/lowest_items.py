"""Draw the lowest visible height around the car, or the number of sensors, on the map from above: colours, legend and
labels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen

from riglens.widgets.maps.paint import BAR_PX, argb
from riglens.widgets.theme import BLIND_COLOURS, OVERLAP_COLOURS, Tones

if TYPE_CHECKING:  # made by the thread of the engine, which loads the compiler
    from riglens.core.blind.zones import BlindMap, By

_INK = np.uint32(0xFF000000)


@dataclass(frozen=True)
class Lowest:
    """The lowest visible height L_k (k = 1, 2) by any sensor or by those of a kind; with k = 0 the number of sensors
    that see an object of OVERLAP_HEIGHT_M."""

    found: BlindMap
    by: By
    k: int

    @property
    def cell_m(self) -> float:
        """Edge of a column."""
        return self.found.grid.voxel_m

    @property
    def origin_m(self) -> tuple[float, float]:
        """The lower corner of the first column."""
        return self.found.grid.origin_m[0], self.found.grid.origin_m[1]

    @property
    def size_m(self) -> tuple[float, float]:
        """Return length and width of the evaluated ground."""
        return self.found.grid.roi_m[0], self.found.grid.roi_m[1]

    @property
    def steps(self) -> NDArray[np.uint8]:
        """Return the index into `colours` of each column (nx, ny)."""
        from riglens.core.blind.zones import overlap  # the compiler, loaded by now

        return self.found.steps(self.by, self.k) if self.k else overlap(self.found)

    @property
    def colours(self) -> tuple[str, ...]:
        """The colours of the steps."""
        return BLIND_COLOURS if self.k else OVERLAP_COLOURS

    @property
    def words(self) -> tuple[str, ...]:
        """Return the labels of the boundaries between steps, or with k = 0 of the steps themselves."""
        return tuple(f"{height_m:.2f} m" for height_m in self.heights_m) if self.k else ("0", "1", "2", "3+")

    @property
    def heights_m(self) -> tuple[float, ...]:
        """The heights at which colours change."""
        from riglens.core.blind.zones import HEIGHTS_M  # the compiler, loaded by now

        return HEIGHTS_M


def lowest_colours(shown: Lowest) -> NDArray[np.uint32]:
    """Return the colour of each column (nx, ny), 0xAARRGGBB, darker along contours; 0 off the ground that counts."""
    counts = shown.found.ground.counts
    steps = shown.steps
    table = np.array([argb(colour) for colour in shown.colours], np.uint32)
    found = table[steps]
    line = _contours(steps, counts)
    found[line] = (found[line] >> 1 & np.uint32(0x7F7F7F)) | _INK
    return np.asarray(np.where(counts, found, 0), np.uint32)


def _contours(steps: NDArray[np.uint8], counts: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the columns that count and are higher than a neighbour across a side that counts."""
    line = np.zeros(steps.shape, np.bool_)
    for one, other in (
        (np.s_[1:, :], np.s_[:-1, :]), (np.s_[:-1, :], np.s_[1:, :]),
        (np.s_[:, 1:], np.s_[:, :-1]), (np.s_[:, :-1], np.s_[:, 1:]),
    ):  # fmt: skip
        line[one] |= (steps[one] > steps[other]) & counts[other]
    return np.asarray(line & counts)


def draw_lowest_legend(painter: QPainter, area: QRectF, shown: Lowest, tones: Tones) -> None:
    """Draw a bar of all steps, with the heights between them in metres, or with numbers below them."""
    metrics, count = QFontMetricsF(painter.font()), len(shown.colours)
    wide = area.width() / count
    for number, colour in enumerate(shown.colours):
        painter.fillRect(QRectF(area.left() + number * wide, area.top(), wide + 0.5, BAR_PX), QColor(colour))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(QColor(tones.border), 1.0))
    painter.drawRect(QRectF(area.left(), area.top(), area.width(), BAR_PX))
    painter.setPen(QColor(tones.text))
    for number, text in enumerate(shown.words, 1):
        width = metrics.horizontalAdvance(text) + 2.0
        middle = area.left() + (number if shown.k else number - 0.5) * wide
        box = QRectF(middle - width / 2, area.top() + BAR_PX + 1.0, width, metrics.height())
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def lowest_text(shown: Lowest, place_m: tuple[float, float]) -> str:
    """Describe a place of the ground: the height from which an object there is seen."""
    from riglens.core.blind.zones import OVERLAP_HEIGHT_M, seen_by, unseen_by

    found, (x, y) = shown.found, place_m
    column = tuple(int((at - low) // shown.cell_m) for at, low in zip((x, y), shown.origin_m, strict=True))
    inside = all(0 <= i < n for i, n in zip(column, found.ground.counts.shape, strict=True))
    if not inside or not found.ground.counts[column]:
        is_near = inside and found.ground.distance_m[column] <= 1e-9
        return "the car itself" if is_near else f"more than {found.settings.within_m:g} m from the car"
    if not shown.k:
        return f"{shown.words[shown.steps[column]]} sensors see an object {OVERLAP_HEIGHT_M:.2f} m tall"
    height_m = found.lowest_m(shown.by, shown.k)[column]
    if not np.isfinite(height_m):
        return f"{unseen_by(shown.by, shown.k)} up to {found.grid.roi_m[2]:g} m"
    return f"seen by {seen_by(shown.by, shown.k)} from {height_m:.2f} m up"


def lowest_summary(shown: Lowest) -> str:
    """Describe the map: the area of ground on which objects of some heights are unseen."""
    from riglens.core.blind.zones import OVERLAP_HEIGHT_M, unseen_by

    if not shown.k:
        return f"sensors that see an object {OVERLAP_HEIGHT_M:.2f} m tall, more is better"
    found, heights_m = shown.found, [shown.heights_m[number] for number in (1, 2, 4)]
    areas = [np.count_nonzero(found.unseen(height_m, shown.by, shown.k)) for height_m in heights_m]
    told = ", ".join(f"{found.column_m2 * area:.1f}" for area in areas)
    at = ", ".join(f"{height_m:.1f}" for height_m in heights_m)
    text = f"{unseen_by(shown.by, shown.k)}: {told} m² at {at} m, less is better"
    return text[0].upper() + text[1:]
