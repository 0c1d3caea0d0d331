"""Chart of the accuracy study: time against error, both logarithmic, one panel per error; PNG and SVG.

The names of points are placed near them, clear of marks, fronts and other names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, NullLocator
from matplotlib.transforms import Bbox

from riglens.core.scene.grid import DEFAULT_VOXEL_M
from riglens.core.shown_text import visible
from riglens.core.study.accuracy import AccuracyStudy, MethodName, Point
from riglens.studies.accuracy_text import caption, edge_text, point_text, verdicts
from riglens.studies.point_labels import Pixel, boxes_of, set_beside

SIZE_IN = (13.0, 7.3)
DPI = 160
INK, GREY = "#222222", "#6b6b6b"
BAND, FRONT = "#e9eef4", "#c2410c"
STYLES: dict[MethodName, tuple[str, str]] = {
    "exact": ("o", "#1f5fa8"),
    "edit-camera": ("s", "#1f5fa8"),
    "edit-lidar": ("D", "#1f5fa8"),
    "plain": ("^", "#3f7d3a"),
    "plain-single": ("v", "#3f7d3a"),
    "bresenham": ("X", "#8a3ffc"),
    "rectangles": ("P", "#a0702a"),
    "centres": ("h", "#b0306a"),
}
PIXELS_PER_POINT = DPI / 72
_TITLE: dict[str, Any] = {"loc": "left", "fontsize": 11, "fontweight": "bold", "color": INK, "pad": 8}
_UNDER: dict[str, Any] = {"color": INK, "labelpad": 0}


def chart(study: AccuracyStudy, source: str) -> Figure:
    """Return the chart; `source` names the data set."""
    grid, finest = edge_text(study.voxel_m), edge_text(study.finest_m)
    # rigs may be called $x$
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "font.size": 9.5, "text.parse_math": False}):
        figure = Figure(figsize=SIZE_IN, dpi=DPI, facecolor="white")
        FigureCanvasAgg(figure)
        voxels, scores = figure.subplots(1, 2, sharey=True)
        figure.subplots_adjust(left=0.07, right=0.985, top=0.80, bottom=0.19, wspace=0.05)
        set_time_axis(voxels, [point.median_ms for point in study.points])
        shown = [(p, p.voxel_error, p.on_voxel_front) for p in study.points if p.voxel_error is not None]
        _draw_panel(voxels, shown, "exact", study)
        voxels.set_title(f"Wrong voxels, on the grid of {grid}", **_TITLE)
        voxels.set_xlabel("missed + extra voxels, % of the exact set of the rig's own rays", **_UNDER)
        _draw_panel(scores, [(p, p.score_error, p.on_score_front) for p in study.points], "reference", study)
        scores.set_title(f"S-MS, against exact on the grid of {finest}", **_TITLE)
        scores.set_xlabel(
            "error of S-MS / H(Ω), %: part of the grid + part of the shortcut, worst class", **_UNDER
        )
        _words(figure, study, source)
    return figure


def _draw_panel(
    axes: Axes, shown: Sequence[tuple[Point, float, bool]], zero_name: str, study: AccuracyStudy
) -> None:
    """Draw points with one of their errors and whether they are on its front."""
    zero = set_error_axis(axes, [error for _, error, _ in shown], zero_name)
    places = [(p, error if error > 0.0 else zero, is_on) for p, error, is_on in shown]
    front = sorted((x, p.median_ms) for p, x, is_on in places if is_on)
    axes.step([x for x, _ in front], [y for _, y in front], where="post", color=FRONT, lw=1.6, zorder=2)
    axes.plot(*zip(*front, strict=True), "o", mfc="none", mec=FRONT, markersize=12, mew=1.3, zorder=3)
    for point, x, _ in places:
        _draw_point(axes, point, x, study)
    place_labels(axes, [(point, x) for point, x, _ in places], front, study)


def _draw_point(axes: Axes, point: Point, x: float, study: AccuracyStudy) -> None:
    marker, colour = STYLES[point.method]
    face = colour if point.from_scratch else "white"
    axes.plot(x, point.median_ms, marker, color=colour, markerfacecolor=face, markersize=8, mew=1.5, zorder=4)
    if point is study.own:
        axes.plot(x, point.median_ms, "o", mfc="none", mec=INK, markersize=16, mew=1.6, zorder=5)


def set_error_axis(axes: Axes, errors: Sequence[float], zero_name: str) -> float:
    """Draw a logarithmic axis in percent with a band for 0 at its left; return where zeros are drawn."""
    positive = [error for error in errors if error > 0.0] or [1.0]
    low, high = math.floor(math.log10(min(positive)) - 0.05), math.ceil(math.log10(max(positive)) + 0.05)
    width = 0.16 * (high - low)
    axes.set_xscale("log")
    axes.set_xlim(10 ** (low - width), 10.0**high)
    axes.axvspan(10 ** (low - width), 10.0**low, color=BAND, lw=0, zorder=0)
    axes.axvline(10.0**low, color=GREY, lw=0.8, ls=(0, (4, 3)), zorder=1)
    steps = (1, 2, 5) if high - low <= 2 else (1,)
    ticks = [s * 10.0**k for k in range(low, high + 1) for s in steps if s * 10.0**k <= 10.0**high]
    zero = 10 ** (low - width / 2)
    axes.xaxis.set_major_locator(FixedLocator([zero, *ticks]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticklabels([f"0\n{zero_name}", *(percent_text(100 * tick) for tick in ticks)])
    axes.grid(True, color="#dddddd", lw=0.6, zorder=0)
    axes.tick_params(colors=INK, length=3)
    axes.spines[["top", "right"]].set_visible(False)
    return float(zero)


def percent_text(percent: float) -> str:
    """Return the label of a tick of the axis of errors; small ones as a power of ten."""
    if percent >= 0.001:
        return f"{percent:g}"
    power = round(math.log10(percent))
    factor = round(percent / 10.0**power)
    raised = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"10{raised}" if factor == 1 else f"{percent:g}"


def set_time_axis(axes: Axes, times_ms: Sequence[float]) -> None:
    """Set a logarithmic axis in milliseconds and seconds that holds all times."""
    low, high = math.log10(min(times_ms)), math.log10(max(times_ms))
    margin = 0.1 * max(high - low, 0.5)
    axes.set_yscale("log")
    axes.set_ylim(10 ** (low - margin), 10 ** (high + margin))
    steps = (1, 2, 5) if high - low < 2.2 else (1, 3)
    ticks = [s * 10.0**k for k in range(math.floor(low) - 1, math.ceil(high) + 1) for s in steps]
    ticks = [t for t in ticks if 10 ** (low - margin) <= t <= 10 ** (high + margin)]
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_yticklabels([f"{t:g} ms" if t < 1000 else f"{t / 1000:g} s" for t in ticks])
    axes.set_ylabel("time of one evaluation (median)", color=INK)


def _words(figure: Figure, study: AccuracyStudy, source: str) -> None:
    """Write title and finding above, legend and source below."""
    head = f"Time against error: ways to score rig {visible(study.rig.name)}"
    figure.text(0.012, 0.965, head, fontsize=15, weight="bold", color=INK, va="top")
    figure.text(0.012, 0.918, "\n".join(verdicts(study)), fontsize=9, color=INK, va="top", linespacing=1.35)
    figure.text(0.012, 0.018, caption(study, source), fontsize=8, color=GREY, va="bottom")
    blue, green, violet = (STYLES[method][1] for method in ("exact", "plain", "bresenham"))
    own = "default setting" if study.voxel_m == DEFAULT_VOXEL_M else "requested setting"
    looks: dict[str, dict[str, Any]] = {
        "Pareto front (whole rig)": {"ls": "-", "lw": 1.6, "color": FRONT, "mfc": "none", "ms": 10},
        own: {"color": INK, "mfc": "none", "ms": 12, "mew": 1.6},
        "exact, whole rig from scratch": {"color": blue},
        "exact, one sensor moved": {"marker": "s", "color": blue, "mfc": "white", "mew": 1.5},
        "plain ray walking": {"marker": "^", "color": green},
        "approximate methods": {"marker": "X", "color": violet},
    }
    usual: dict[str, Any] = {"ls": "", "marker": "o", "ms": 8}
    figure.legend(
        handles=[Line2D([], [], label=name, **(usual | look)) for name, look in looks.items()],
        loc="lower left", bbox_to_anchor=(0.005, 0.045), ncol=6, frameon=False, fontsize=8.5, handletextpad=0.4,
        columnspacing=1.6,
    )  # fmt: skip


# ---------------------------------------------------------------- names of points


def place_labels(
    axes: Axes,
    places: Sequence[tuple[Point, float]],
    front: Sequence[tuple[float, float]],
    study: AccuracyStudy,
) -> None:
    """Write each point's name next to it where it covers neither a mark, nor the front, nor another name."""
    boxes = [_mark_box(axes, point, x, study) for point, x in places]
    for (x0, y0), (x1, y1) in pairwise(_pixels(axes, x, y) for x, y in front):
        boxes.append(Bbox.from_extents(x0, y0 - 2, x1, y0 + 2))
        boxes.append(Bbox.from_extents(x1 - 2, y1, x1 + 2, y0))
    taken, frame = boxes_of(boxes), axes.get_window_extent()
    for point, x in sorted(places, key=lambda place: (place[0] is not study.own, place[0].median_ms)):
        text = axes.annotate(
            point_text(point, study), (x, point.median_ms), xytext=(0, 0), textcoords="offset points", fontsize=9,
            fontweight="bold" if point is study.own else "normal", color=INK, zorder=6,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )  # fmt: skip
        taken = set_beside(axes, text, _pixels(axes, x, point.median_ms), taken, frame)


def _pixels(axes: Axes, x: float, y: float) -> Pixel:
    place = axes.transData.transform((x, y))
    return float(place[0]), float(place[1])


def _mark_box(axes: Axes, point: Point, x: float, study: AccuracyStudy) -> Bbox:
    """Return the box of a mark, in pixels."""
    cx, cy = _pixels(axes, x, point.median_ms)
    half = (9.0 if point is study.own else 6.5) * PIXELS_PER_POINT
    return Bbox.from_extents(cx - half, cy - half, cx + half, cy + half)
