"""Where bars of a score stand: one per rig from zero to its figure, all on one scale. Plain geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QRectF

from riglens.widgets.panels.compare_rows import CompareRow, ScoreColumn

WIDEST_PX, FILLED = 64.0, 0.78


@dataclass(frozen=True)
class Bar:
    """One figure as drawn: `area` reaches from zero to the figure, `column` is the chart above and below it."""

    row: CompareRow
    score: ScoreColumn
    figure: float
    area: QRectF
    column: QRectF


@dataclass(frozen=True)
class Chart:
    """The bars of one score; `zero_px` is where figures of nothing end."""

    score: ScoreColumn
    area: QRectF
    zero_px: float
    bars: tuple[Bar, ...]


def side_by_side(area: QRectF, count: int, gap_px: float) -> list[QRectF]:
    """An area cut into charts of one width."""
    wide = max(1.0, (area.width() - (count - 1) * gap_px) / max(1, count))
    return [
        QRectF(area.left() + place * (wide + gap_px), area.top(), wide, area.height())
        for place in range(count)
    ]


def chart_of(
    score: ScoreColumn, rows: Sequence[tuple[CompareRow, float]], area: QRectF, words_px: float
) -> Chart:
    """Bars for rigs with their figures, none where that is NaN; `words_px` stay free beyond the longest ones."""
    known = [figure for _, figure in rows if not math.isnan(figure)]
    low, high = min([0.0, *known]), max([0.0, *known])
    inner = area.adjusted(0.0, words_px * (high > 0.0), 0.0, -words_px * (low < 0.0))
    scale = inner.height() / (high - low) if high > low else 0.0
    zero_px = inner.top() + high * scale
    step = min(area.width() / max(1, len(rows)), WIDEST_PX)
    bars = []
    for place, (row, figure) in enumerate(rows):
        if not math.isnan(figure):
            column = QRectF(area.left() + place * step, area.top(), step, area.height())
            end = zero_px - figure * scale
            wide = FILLED * step
            left = column.center().x() - wide / 2
            bar = QRectF(left, min(zero_px, end), wide, max(1.0, abs(zero_px - end)))
            bars.append(Bar(row, score, figure, bar, column))
    return Chart(score, area, zero_px, tuple(bars))
