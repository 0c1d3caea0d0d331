"""The chart of a card: distance by direction, one panel per class, LiDARs as a band and cameras as a line."""

from __future__ import annotations

import math
from collections.abc import Callable

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible
from riglens.core.targets.card import Card, CardRow
from riglens.core.targets.card_text import HEADINGS

LIDAR, CAMERA, INK = "#1f5fa8", "#a0702a", "#222222"
BAND = "LiDARs, luckiest to unluckiest place between the beams"
LINES = {0.0: "-", 90.0: "--"}


def card_figure(card: Card) -> Figure:
    """Draw the card; ahead is up, left is left."""
    figure = Figure(figsize=(12.0, 5.4), dpi=110)
    FigureCanvasAgg(figure)
    plan = card.plan
    figure.suptitle(
        f"{visible(card.rig.name)}: first distance (m) with fewer than {plan.min_points} points, or less than "
        f"{plan.min_height_px:g} pixels tall",
        color=INK,
        y=0.97,
    )
    figure.subplots_adjust(left=0.05, right=0.95, bottom=0.17, top=0.79, wspace=0.3)
    for place, cls in enumerate(CLASSES, 1):
        axes = figure.add_subplot(1, len(CLASSES), place, projection="polar")
        assert isinstance(axes, PolarAxes)
        _draw_class(axes, card, cls)
    named = {
        label: line
        for axes in figure.axes
        for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    for axes in figure.axes:
        axes.set_ylim(0.0, max(axes.get_ylim()[1] for axes in figure.axes))
    if named:
        figure.legend(list(named.values()), list(named), loc="lower center", ncols=5, frameon=False)
    return figure


def _draw_class(axes: PolarAxes, card: Card, cls: str) -> None:
    axes.set_theta_zero_location("N")
    axes.set_title(cls, color=INK, pad=14)
    for heading in dict.fromkeys(row.heading_deg for row in card.rows if row.cls == cls):
        rows = [row for row in card.rows if (row.cls, row.heading_deg) == (cls, heading)]
        rows.sort(key=lambda row: row.bearing_deg % 360.0)
        rows.append(rows[0])
        angles = [math.radians(row.bearing_deg % 360.0) for row in rows]
        angles[-1] += math.tau

        def at(value: Callable[[CardRow], float], rows: list[CardRow] = rows) -> list[float]:
            return [min(value(row), card.plan.to_m) for row in rows]

        if any(row.lidar.most_m > 0.0 for row in rows):
            band = (at(lambda row: row.lidar.least_m), at(lambda row: row.lidar.most_m))
            axes.fill_between(angles, *band, color=LIDAR, alpha=0.14, linewidth=0, label=BAND)
            median = at(lambda row: row.lidar.median_m)
            axes.plot(angles, median, LINES[heading], color=LIDAR, label=f"LiDARs, {HEADINGS[heading]}")
        if any(row.camera.most_m > 0.0 for row in rows):
            shown = at(lambda row: row.camera.median_m)
            axes.plot(angles, shown, LINES[heading], color=CAMERA, label=f"cameras, {HEADINGS[heading]}")
    axes.set_thetagrids([0, 90, 180, 270], ["ahead", "left", "behind", "right"])
    axes.tick_params(labelsize=8)
