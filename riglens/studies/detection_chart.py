"""Charts of the detection study: precision over figures known beforehand, as in the paper's Fig. 5; and all pairs."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from riglens.core.shown_text import visible
from riglens.core.simulate.painting import Quality
from riglens.core.study.detection.protocol import WORDING
from riglens.core.study.detection.result import Result
from riglens.core.study.detection.statistics import COLUMNS, MEAN
from riglens.core.study.ranks import RankCorrelation
from riglens.studies.pictures import picture
from riglens.studies.point_labels import set_beside

Doubles = NDArray[np.float64]
Named = tuple[Axes, Doubles, Doubles, Doubles]
"""A panel, and its points x, y (n,) with the lengths of their bars (2, n), down and up."""
SHOWN = {"s_ms": "S-MS, nats", "seen": "seen", "on_target": "on target"}
INK, SAME, OTHER = "#222222", "#c2410c", "#1f5fa8"
DPI, MARK_PT = 130, 4.5
MOST_NAMES, MOST_CELLS_WITH_NUMBERS = 12, 16


def chart(result: Result) -> bytes:
    """Average precision over S-MS, seen and on target, one row per class, with 95 % intervals."""
    return picture(chart_figure(result))


def chart_figure(result: Result) -> Figure:
    """Return the chart as a figure; names of rigs are kept apart where there are few."""
    rows = [column for column in COLUMNS if np.isfinite(result.every.value[:, COLUMNS.index(column)]).all()]
    figure = Figure(figsize=(11.0, 0.9 + 2.7 * max(1, len(rows))), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    groups = result.groups()
    same = set(groups.get("equal ray count", []))
    panels: list[Named] = []
    for grid, column in zip(
        figure.subplots(max(1, len(rows)), len(SHOWN), squeeze=False), rows, strict=False
    ):
        for axes, (name, title) in zip(grid, SHOWN.items(), strict=True):
            panels.append(_panel(axes, result, name, column, same))
            axes.set_xlabel(title)
        grid[0].set_ylabel("mAP, %" if column == MEAN else f"AP {column}, %")
    if same:
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=2, frameon=False)
    figure.suptitle(f"{_seeds(result)}; bars: 95 % intervals\n{WORDING}", fontsize=9.5, x=0.01, ha="left")
    if len(result.every.rigs) <= MOST_NAMES:
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # from here on everything stays where it is
        for axes, x, y, bars in panels:
            _name_points(axes, result.every.rigs, x, y, bars)
    return figure


def _panel(axes: Axes, result: Result, name: str, column: str, same: set[int]) -> Named:
    """Draw a panel; returns where its points and the ends of their bars are."""
    x, at = result.surrogates.of(name, column), COLUMNS.index(column)
    y = result.every.value[:, at]
    found = [result.every.estimate(place, column) for place in range(len(y))]
    bars = np.array([[one.value - one.low, one.high - one.value] for one in found]).T
    for chosen, colour, label in (
        ([p for p in range(len(y)) if p not in same], OTHER, "other rigs"),
        (sorted(same), SAME, "23,040 rays per frame"),
    ):
        if chosen:
            axes.errorbar(
                x[chosen], y[chosen], yerr=np.maximum(bars[:, chosen], 0.0), fmt="o", ms=MARK_PT, lw=0, elinewidth=1.0,
                capsize=2, color=colour, label=label,
            )  # fmt: skip
    axes.set_title(_rank_text(result, name, column), fontsize=8.5, loc="left")
    axes.margins(x=0.14, y=0.1)
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.grid(color="#e5e7eb", lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return axes, x, y, np.maximum(bars, 0.0)


def _name_points(axes: Axes, rigs: tuple[str, ...], x: Doubles, y: Doubles, bars: Doubles) -> None:
    """Name the points (n,) where no name covers a mark, an error bar (2, n) or another name; the layout is fixed."""
    low, at, high = (
        axes.transData.transform(np.stack([x, ends], 1)) for ends in (y - bars[0], y, y + bars[1])
    )
    half_px = MARK_PT * DPI / 144.0
    taken = np.concatenate([np.minimum(low, at - half_px), np.maximum(high, at + half_px)], axis=1)
    taken[:, [0, 2]] = at[:, :1] + [-half_px, half_px]
    frame = axes.get_window_extent()
    for place in np.argsort(-y, kind="stable").tolist():
        text = axes.annotate(
            visible(rigs[place])[:24], (x[place], y[place]), (0, 0), textcoords="offset points", fontsize=7
        )
        taken = set_beside(axes, text, (float(at[place, 0]), float(at[place, 1])), taken, frame)


def _rank_text(result: Result, name: str, column: str) -> str:
    words = []
    for group in ("all rigs", "equal ray count"):
        sought = (group, name, column, "spearman")
        found = next(
            (one.found for one in result.ranks if (one.among, one.surrogate, one.column, one.kind) == sought),
            None,
        )
        if found is not None:
            words.append(f"Spearman, {group} {correlation(found)}")
    return "\n".join(words)


def correlation(found: RankCorrelation) -> str:
    """Return a correlation with its interval, as a reader sees it."""
    return f"{found.value:.2f} [{found.low:.2f}, {found.high:.2f}]".replace("-", "−")


def pair_chart(result: Result, column: str = MEAN) -> bytes:
    """Return a chart of the differences of all pairs, the best rig first; unresolved differences are grey."""
    order = np.argsort(-result.every.value[:, COLUMNS.index(column)], kind="stable").tolist()
    count = len(order)
    values = np.full((count, count), np.nan)
    for row, one in enumerate(order):
        for place, other in enumerate(order):
            if one != other and result.every.verdict(one, other, column) != "not resolved":
                values[row, place] = result.every.difference(one, other, column).value
    side = 3.2 + 0.28 * count
    figure = Figure(figsize=(side + 1.0, side), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    most = float(np.nanmax(np.abs(values), initial=1.0))
    axes.set_facecolor("#e2e4e8")
    image = axes.imshow(values, cmap="RdBu", norm=TwoSlopeNorm(0.0, -most, most))
    names = [visible(result.every.rigs[place])[:32] for place in order]
    axes.set_xticks(range(count), names, rotation=90, fontsize=8)
    axes.set_yticks(range(count), names, fontsize=8)
    if count <= MOST_CELLS_WITH_NUMBERS:
        for row, place in np.argwhere(np.isfinite(values)).tolist():
            dark = abs(values[row, place]) > 0.6 * most
            text = f"{values[row, place]:+.1f}".replace("-", "−")
            axes.text(place, row, text, ha="center", va="center", fontsize=7, color="white" if dark else INK)
    what = "mAP" if column == MEAN else f"AP {column}"
    axes.set_title(f"{what}: row minus column, points; grey: not resolved\n{_seeds(result)}", fontsize=10)
    figure.colorbar(image, ax=axes, shrink=0.7, label="percentage points")
    return picture(figure, dpi=130)


def _seeds(result: Result) -> str:
    every, cameras = result.every, result.study.protocol.cameras
    seeds = f"{every.seeds} seed{'s' * (every.seeds > 1)}, {every.sequences} test sequences"
    return seeds if cameras is None else f"{seeds}; {painted_words(cameras)}"


def painted_words(quality: Quality) -> str:
    """Describe how cameras take part."""
    return f"points have the classes that cameras show, segmentation {quality}"
