"""The chart of the accuracy study of sensors: time against wrong voxels, a row per sensor and a column per pose."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from riglens.core.shown_text import visible
from riglens.core.study.sensor_methods import POSES_DEG, MethodName, SensorPoint, SensorResult, SensorStudy
from riglens.studies.accuracy_chart import DPI, GREY, INK, set_error_axis, set_time_axis

WIDTH_IN, ROW_IN, HEAD_IN, FOOT_IN = 11.0, 2.9, 0.75, 1.25


class _Style(NamedTuple):
    """Style of a mark: shape, colour, filled or not, and its name in the key."""

    mark: str
    colour: str
    filled: bool
    name: str


STYLES: dict[MethodName, _Style] = {
    "fast": _Style("o", "#1f5fa8", True, "RigLens"),
    "walk": _Style("s", "#1f5fa8", False, "exact walk, ray by ray"),
    "thinned": _Style("o", "#6fa3d8", True, "RigLens, 1/2, 1/4, 1/8 of the rays"),
    "plain": _Style("^", "#3f7d3a", True, "plain DDA"),
    "plain-single": _Style("v", "#3f7d3a", False, "plain DDA, single precision"),
    "sampled": _Style("D", "#c2410c", True, "points on rays, every 1 to 1/8 voxel"),
    "bresenham": _Style("X", "#8a3ffc", True, "Bresenham"),
    "rectangles": _Style("P", "#a0702a", True, "bounding rectangles"),
    "centres": _Style("h", "#b0306a", True, "voxel centres in view"),
}


def chart(study: SensorStudy, caption: str) -> Figure:
    """Return the chart; `caption` is below it."""
    rows = len(study.results) // len(POSES_DEG)
    height_in = HEAD_IN + rows * ROW_IN + FOOT_IN
    # users' models may be called $x$
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "font.size": 9.0, "text.parse_math": False}):
        figure = Figure(figsize=(WIDTH_IN, height_in), dpi=DPI, facecolor="white")
        FigureCanvasAgg(figure)
        panels = figure.subplots(rows, len(POSES_DEG), squeeze=False, sharex=True, sharey="row")
        figure.subplots_adjust(
            left=0.085, right=0.985, top=1 - HEAD_IN / height_in, bottom=FOOT_IN / height_in, wspace=0.04, hspace=0.28
        )  # fmt: skip
        errors = [point.error for result in study.results for point in result.points]
        for row, axes in enumerate(panels):
            results = study.results[row * len(POSES_DEG) : (row + 1) * len(POSES_DEG)]
            set_time_axis(axes[0], [point.median_ms for result in results for point in result.points])
            for one, result in zip(axes, results, strict=True):
                zero = set_error_axis(one, errors, "exact")
                _draw(one, result, zero)
            axes[0].set_ylabel("time of an edit")
        for one in panels[-1]:
            one.set_xlabel("missed + extra voxels, % of those of the exact walk", color=INK)
        _words(figure, study, caption, height_in)
    return figure


def _draw(axes: Axes, result: SensorResult, zero: float) -> None:
    """Draw one sensor in one pose: the settings of each method joined by a line and labelled."""
    axes.set_title(_title(result), loc="left", fontsize=9.5, fontweight="bold", color=INK, pad=5)
    for method, style in STYLES.items():
        points = [point for point in result.points if point.method == method]
        places = [(point.error if point.error > 0.0 else zero, point.median_ms) for point in points]
        if not places:
            continue
        size = 9.0 if method == "fast" else 6.5
        axes.plot(
            *zip(*places, strict=True), style.mark, ls="-" if len(places) > 1 else "", lw=1.0, color=style.colour,
            mfc=style.colour if style.filled else "white", mew=1.4, ms=size, zorder=5 if method == "fast" else 4,
        )  # fmt: skip
        for point, place in zip(points, places, strict=True):
            _name_setting(axes, point, place)


def _name_setting(axes: Axes, point: SensorPoint, place: tuple[float, float]) -> None:
    """Write 1/4 next to a mark of a method with settings."""
    if not point.setting:
        return
    above = point.method == "sampled"
    axes.annotate(
        point.setting, place, xytext=(0, 6 if above else -6), textcoords="offset points", ha="center",
        va="bottom" if above else "top", fontsize=7, color=STYLES[point.method].colour, zorder=6,
        path_effects=[withStroke(linewidth=2, foreground="white")],
    )  # fmt: skip


def _title(result: SensorResult) -> str:
    roll_deg, pitch_deg = POSES_DEG[result.pose]
    turned = f"tilted by {roll_deg:g}° and {pitch_deg:g}°".replace("-", "−") if roll_deg else result.pose
    return f"{visible(result.model)}, {result.sensor.ray_count:,} rays, {turned}"


def _words(figure: Figure, study: SensorStudy, caption: str, height_in: float) -> None:
    """Write the title above, key and source below."""
    head = "Time against error: methods to find the voxels that a sensor sees"
    figure.text(0.012, 1 - 0.12 / height_in, head, fontsize=13, weight="bold", color=INK, va="top")
    figure.text(0.012, 0.08 / height_in, caption, fontsize=7.5, color=GREY, va="bottom")
    figure.legend(
        handles=[*_key(study)], loc="lower left", bbox_to_anchor=(0.005, 0.22 / height_in), ncol=5, frameon=False,
        fontsize=8, handletextpad=0.4, columnspacing=1.5,
    )  # fmt: skip


def _key(study: SensorStudy) -> Iterator[Line2D]:
    """Return a mark for each way that is in the chart."""
    shown = {point.method for result in study.results for point in result.points}
    for method, style in STYLES.items():
        if method in shown:
            face = style.colour if style.filled else "white"
            line = "-" if method in ("sampled", "thinned") else ""
            yield Line2D(
                [], [], ls=line, lw=1.0, marker=style.mark, color=style.colour, mfc=face, mew=1.4, ms=7,
                label=style.name,
            )  # fmt: skip
