"""Chart of a detection range: distance by direction, one panel per class; lines are medians, bands worst to best."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kinds
from riglens.core.shown_text import visible
from riglens.core.targets.detection_range import DetectionRange
from riglens.core.targets.detection_range_text import HEADINGS
from riglens.widgets.sensors.appearance import ray_colour
from riglens.widgets.theme import LIGHT

INK = "#222222"
BAND = "worst to best place between the beams"
LINES = {0.0: "-", 90.0: "--"}


def range_figure(ranges: DetectionRange) -> Figure:
    """Draw the detection range; ahead is up, left is left."""
    figure = Figure(figsize=(12.0, 5.4), dpi=110)
    FigureCanvasAgg(figure)
    plan = ranges.plan
    figure.suptitle(
        f"{visible(ranges.rig.name)}: first distance (m) with fewer than {plan.min_points} points, or less than "
        f"{plan.min_height_px:g} pixels tall",
        color=INK,
        y=0.97,
    )
    figure.subplots_adjust(left=0.05, right=0.95, bottom=0.17, top=0.79, wspace=0.3)
    for place, cls in enumerate(CLASSES, 1):
        axes = figure.add_subplot(1, len(CLASSES), place, projection="polar")
        assert isinstance(axes, PolarAxes)
        _draw_class(axes, ranges, cls)
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


def _draw_class(axes: PolarAxes, ranges: DetectionRange, cls: str) -> None:
    axes.set_theta_zero_location("N")
    axes.set_title(cls, color=INK, pad=14)
    for heading in dict.fromkeys(row.heading_deg for row in ranges.rows if row.cls == cls):
        rows = [row for row in ranges.rows if (row.cls, row.heading_deg) == (cls, heading)]
        rows.sort(key=lambda row: row.bearing_deg % 360.0)
        rows.append(rows[0])
        angles = [math.radians(row.bearing_deg % 360.0) for row in rows]
        angles[-1] += math.tau
        for kind in kinds():
            reaches = [row.reaches[kind.name] for row in rows if kind.name in row.reaches]
            if any(reach.most_m > 0.0 for reach in reaches):
                colour = ray_colour(kind.name, LIGHT)
                shown = np.minimum([reach[:3] for reach in reaches], ranges.plan.to_m)
                least, median, most = shown.T
                if not np.array_equal(least, most):
                    axes.fill_between(angles, least, most, color=colour, alpha=0.14, linewidth=0, label=BAND)
                label = f"{kind.plural}, {HEADINGS[heading]}"
                axes.plot(angles, median, LINES[heading], color=colour, label=label)
    axes.set_thetagrids([0, 90, 180, 270], ["ahead", "left", "behind", "right"])
    axes.tick_params(labelsize=8)
