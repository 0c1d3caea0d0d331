"""The chart of the accuracy study: time against error, both logarithmic, one panel per error; PNG and SVG."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullLocator

from riglens.app.studies.chart_labels import DPI, GREY, INK, place_labels
from riglens.core.scene.grid import DEFAULT_VOXEL_M
from riglens.core.study.accuracy_points import MethodName, Point, Study
from riglens.core.study.accuracy_text import caption, edge_text, verdicts

PictureFormat = Literal["png", "svg"]
SIZE_IN = (13.0, 7.3)
PICTURES: tuple[PictureFormat, ...] = ("png", "svg")
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


@dataclass(frozen=True)
class _Panel:
    """One error: title, axis, what 0 is called, error of a point (None: not shown), who is on the front."""

    title: str
    axis: str
    zero: str
    error: Callable[[Point], float | None]
    on_front: Callable[[Point], bool]


def chart(study: Study, source: str) -> Figure:
    """The chart; `source` names the data set."""
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "font.size": 9.5}):
        figure = Figure(figsize=SIZE_IN, dpi=DPI, facecolor="white")
        FigureCanvasAgg(figure)
        axes = figure.subplots(1, 2, sharey=True)
        figure.subplots_adjust(left=0.07, right=0.985, top=0.80, bottom=0.19, wspace=0.05)
        _set_time_axis(axes[0], [point.median_ms for point in study.points])
        for one, panel in zip(axes, _panels(study), strict=True):
            _draw_panel(one, panel, study)
        _words(figure, study, source)
    return figure


def picture(figure: Figure, file_format: PictureFormat) -> bytes:
    """The bytes of a picture file; the same chart gives the same bytes."""
    stream = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "riglens"}):
        figure.savefig(stream, format=file_format, metadata={"Date": None} if file_format == "svg" else None)
    return stream.getvalue()


def _panels(study: Study) -> tuple[_Panel, _Panel]:
    grid, finest = edge_text(study.voxel_m), edge_text(study.finest_m)
    return (
        _Panel(
            f"Wrong voxels, on the grid of {grid}",
            "missed + extra voxels, % of the exact set of the rig's own rays",
            "exact",
            lambda p: p.voxel_error,
            lambda p: p.on_voxel_front,
        ),
        _Panel(
            f"S-MS, against exact on the grid of {finest}",
            "error of S-MS / H(Ω), %: part of the grid + part of the shortcut, worst class",
            "reference",
            lambda p: p.score_error,
            lambda p: p.on_score_front,
        ),
    )


def _draw_panel(axes: Axes, panel: _Panel, study: Study) -> None:
    shown = [(p, e) for p in study.points if (e := panel.error(p)) is not None]
    zero = _set_error_axis(axes, [error for _, error in shown], panel.zero)
    places = [(p, error if error > 0.0 else zero) for p, error in shown]
    front = sorted((x, p.median_ms) for p, x in places if panel.on_front(p))
    _draw_front(axes, front)
    for point, x in places:
        _draw_point(axes, point, x, study)
    axes.set_title(panel.title, loc="left", fontsize=11, fontweight="bold", color=INK, pad=8)
    axes.set_xlabel(panel.axis, color=INK, labelpad=0)
    place_labels(axes, places, front, study)


def _draw_point(axes: Axes, point: Point, x: float, study: Study) -> None:
    marker, colour = STYLES[point.method]
    face = colour if point.from_scratch else "white"
    axes.plot(x, point.median_ms, marker, color=colour, markerfacecolor=face, markersize=8, mew=1.5, zorder=4)
    if point is study.own:
        axes.plot(x, point.median_ms, "o", mfc="none", mec=INK, markersize=16, mew=1.6, zorder=5)


def _draw_front(axes: Axes, places: Sequence[tuple[float, float]]) -> None:
    """The staircase of what can be had: nothing measured lies below and left of it."""
    axes.step([x for x, _ in places], [y for _, y in places], where="post", color=FRONT, lw=1.6, zorder=2)
    axes.plot(*zip(*places, strict=True), "o", mfc="none", mec=FRONT, markersize=12, mew=1.3, zorder=3)


def _set_error_axis(axes: Axes, errors: Sequence[float], zero_name: str) -> float:
    """A logarithmic axis in percent with a band for 0 at its left; returns where zeros are drawn."""
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
    axes.set_xticklabels([f"0\n{zero_name}", *(f"{100 * tick:g}" for tick in ticks)])
    axes.grid(True, color="#dddddd", lw=0.6, zorder=0)
    axes.tick_params(colors=INK, length=3)
    axes.spines[["top", "right"]].set_visible(False)
    return float(zero)


def _set_time_axis(axes: Axes, times_ms: Sequence[float]) -> None:
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


def _words(figure: Figure, study: Study, source: str) -> None:
    """Title and finding above, legend and source below."""
    figure.text(
        0.012,
        0.965,
        f"Time against error: ways to score rig {study.rig.name}",
        fontsize=15,
        weight="bold",
        color=INK,
        va="top",
    )
    figure.text(0.012, 0.918, "\n".join(verdicts(study)), fontsize=9, color=INK, va="top", linespacing=1.35)
    figure.text(0.012, 0.018, caption(study, source), fontsize=8, color=GREY, va="bottom")
    blue = STYLES["exact"][1]
    handles = [
        Line2D(
            [],
            [],
            color=FRONT,
            lw=1.6,
            marker="o",
            mfc="none",
            mec=FRONT,
            ms=10,
            label="Pareto front (whole rig)",
        ),
        Line2D(
            [],
            [],
            ls="",
            marker="o",
            mfc="none",
            mec=INK,
            ms=12,
            mew=1.6,
            label="default setting" if study.voxel_m == DEFAULT_VOXEL_M else "setting asked for",
        ),
        Line2D([], [], ls="", marker="o", color=blue, ms=8, label="exact, whole rig from scratch"),
        Line2D(
            [], [], ls="", marker="s", mfc="white", mec=blue, mew=1.5, ms=8, label="exact, one sensor moved"
        ),
        Line2D([], [], ls="", marker="^", color=STYLES["plain"][1], ms=8, label="plain ray walking"),
        Line2D([], [], ls="", marker="X", color=STYLES["bresenham"][1], ms=8, label="approximate methods"),
    ]
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.005, 0.045),
        ncol=6,
        frameon=False,
        fontsize=8.5,
        handletextpad=0.4,
        columnspacing=1.6,
    )
