"""Charts paint what their data say, where their scales have it, in the colours that their legends name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QWidget
from pytestqt.qtbot import QtBot

from riglens.core.figures.coverage import S_MS
from riglens.core.figures.figure import Estimate
from riglens.core.figures.hits import ON_TARGET, POINTS
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.values import FigureCells
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sweep.curve import CurvePoint
from riglens.core.targets.detection_range import DetectionRange, RangePlan, RangeRow, Reach, around
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from riglens.widgets.panels.checks.tolerance import BAR_PX, ROW_PX, Range, RangeBar
from riglens.widgets.panels.compare.chart import Chart, CompareChart, chart_of, side_by_side
from riglens.widgets.panels.compare.model import CompareModel, CompareRow, FigureColumn
from riglens.widgets.panels.controls.style import tones
from riglens.widgets.panels.detection_range.chart import RangeChart
from riglens.widgets.panels.detection_range.table import Line as RangeLine
from riglens.widgets.panels.fields.quantity import METRES
from riglens.widgets.panels.inspector.field_curve import FieldCurve
from riglens.widgets.panels.propose.chart import Dot, Line, Plot, Plots
from riglens.widgets.panels.targets.rose import MARGIN_PX, RoseView
from riglens.widgets.sensors.appearance import colour_of
from riglens.widgets.theme import CLASS_COLOURS, RIG_COLOURS
from tests.core.builders import rig_of, spinning
from tests.core.targets.cases import random_traffic
from tests.widgets.marks import Mark, colour, marks, texts

# ---------------------------------------------------------------------- detection range
PLAN = RangePlan(bearings_deg=around(4), to_m=100.0)
REACHES = {
    0.0: (20.0, 40.0, 60.0),
    90.0: (5.0, 10.0, 30.0),
    180.0: (10.0, 20.0, 60.0),
    270.0: (0.0, 8.0, 9.0),
}
BUMPER_M = -2.5
SIDE_PX = 214


def range_chart(
    qtbot: QtBot, reaches: dict[float, tuple[float, float, float]], plan: RangePlan = PLAN
) -> RangeChart:
    rows = tuple(
        RangeRow(
            "car", 0.0, bearing % 360.0,
            {"lidar": Reach(*reaches[bearing % 360.0], 5.0), "camera": Reach(0.0, 0.0, 0.0, 0.0)}, BUMPER_M,
        )
        for bearing in plan.bearings_deg
    )  # fmt: skip
    chart = RangeChart()
    qtbot.addWidget(chart)
    chart.resize(SIDE_PX, SIDE_PX)
    chart.show_line(DetectionRange(preset("W+T"), plan, rows, 1.0), RangeLine("car", 0.0, LIDAR))
    return chart


def from_centre(points: np.ndarray) -> np.ndarray:
    """Radii of points around the middle of a square chart, pixels."""
    return np.hypot(*(points - SIDE_PX / 2.0).T)


def px_per_m(chart: list[Mark]) -> float:
    """Scale of a chart, from its spokes."""
    ahead = next(mark for mark in chart if mark.shape == "line")
    assert ahead.points[0] == pytest.approx([SIDE_PX / 2.0] * 2)
    return float(from_centre(ahead.points[1:])[0]) / (60.0 * 1.08)


def test_a_range_chart_has_rings_spokes_a_band_and_the_median_of_each_kind(qtbot: QtBot) -> None:
    painted = marks(range_chart(qtbot, REACHES))
    scale = px_per_m(painted)
    rings = [mark for mark in painted if mark.shape == "circle"]
    assert [mark.points[1, 0] / scale for mark in rings] == pytest.approx([20.0, 40.0, 60.0], abs=0.01)
    assert all(mark.at == (SIDE_PX / 2.0, SIDE_PX / 2.0) for mark in rings)
    assert "20 m" in " ".join(texts(painted))
    (median,) = (mark for mark in painted if mark.shape == "polygon")
    ahead, left, behind, right = median.points[:4] - SIDE_PX / 2.0
    by_side = [(0.0, -40.0), (-10.0, 0.0), (0.0, 20.0), (8.0, 0.0)]
    for found, (x, y) in zip((ahead, left, behind, right), by_side, strict=True):
        assert found / scale == pytest.approx([x, y], abs=0.01)
    (band,) = (mark for mark in painted if mark.shape == "path" and mark.fill != "none")
    radii = from_centre(band.points) / scale
    assert radii == pytest.approx([60.0, 30.0, 60.0, 9.0, 60.0, 20.0, 5.0, 10.0, 0.0, 20.0], abs=0.01)
    assert 0.0 < band.opacity < 0.5
    assert median.line == band.fill == colour(colour_of("lidar"))
    camera_words = next(mark for mark in painted if mark.text == CAMERA.plural)
    assert camera_words.fill == colour(colour_of("camera")), "named, though it never sees anything"
    named = next(mark for mark in painted if mark.text == LIDAR.plural)
    assert named.at[1] < SIDE_PX / 4.0 < 3.0 * SIDE_PX / 4.0 < camera_words.at[1]


def test_arcs_ahead_stand_where_the_car_can_just_stop_and_numbers_do_not_touch(qtbot: QtBot) -> None:
    plan = replace(PLAN, speeds_kmh=(20.0, 20.5, 40.0, 60.0, 120.0))
    painted = marks(range_chart(qtbot, REACHES, plan))
    scale = px_per_m(painted)
    arcs = [mark for mark in painted if mark.shape == "path" and mark.fill == "none"]
    within = [speed for speed in plan.speeds_kmh if plan.stopping_m(speed) - BUMPER_M <= 60.0 * 1.08]
    assert within == [20.0, 20.5, 40.0, 60.0], "and the fastest stops beyond the chart"
    for arc, speed in zip(arcs, reversed(within), strict=True):
        ends = arc.points[[0, -1]] - SIDE_PX / 2.0
        bearings = np.degrees(np.arctan2(-ends[:, 0], -ends[:, 1]))
        assert from_centre(arc.points[[0, -1]]) / scale == pytest.approx(
            plan.stopping_m(speed) - BUMPER_M, abs=0.05
        )
        assert np.sort(bearings) == pytest.approx([-10.0, 10.0], abs=0.1)
    speeds = [mark for mark in painted if mark.text in {f"{speed:g}" for speed in plan.speeds_kmh}]
    assert [mark.text for mark in speeds] == ["60", "40", "20.5"], "no number stands on another"
    assert all(
        0.0 < mark.at[0] - arc.points[:, 0].max() < 8.0 for mark, arc in zip(speeds, arcs, strict=False)
    )


def test_a_range_chart_out_of_date_is_grey_and_a_sure_range_has_no_band(qtbot: QtBot) -> None:
    chart = range_chart(qtbot, dict.fromkeys(REACHES, (30.0, 30.0, 30.0)))
    chart.grey()
    painted = marks(chart)
    assert not [mark for mark in painted if mark.shape == "path" and mark.fill != "none"]
    assert {mark.line for mark in painted if mark.shape == "polygon"} == {colour(tones().muted)}
    chart = range_chart(qtbot, {bearing: (0.0, 0.0, 30.0 * (bearing == 0.0)) for bearing in REACHES})
    painted = marks(chart)
    assert [mark.shape for mark in painted if mark.fill == colour(colour_of("lidar"))] == ["path", "text"]
    assert not [mark for mark in painted if mark.shape == "polygon"], "the median is nothing"
    assert marks(RangeChart())[1:] == [], "nothing before there are ranges"


# ---------------------------------------------------------------------- the curve of a field
CURVE = tuple(
    CurvePoint(value, {name: (change * (1 + place), 0.01) for place, name in enumerate(CLASSES)})
    for value, change in ((1.0, -0.02), (1.5, 0.0), (3.0, 0.05))
)


@pytest.fixture
def curve(qtbot: QtBot) -> Iterator[FieldCurve]:
    parent = QWidget()
    qtbot.addWidget(parent)
    made = FieldCurve(parent)
    made.open_at(parent, "top: z", 1.5, METRES)
    made.show_points(CURVE, "done")
    yield made


def test_a_curve_has_each_class_in_its_colour_with_a_band_of_its_noise(curve: FieldCurve) -> None:
    painted = marks(curve)
    for place, name in enumerate(CLASSES):
        line_colour = colour(CLASS_COLOURS[name])
        (line,) = (
            mark
            for mark in painted
            if mark.shape == "line" and mark.line == line_colour and len(mark.points) == 3
        )
        (band,) = (mark for mark in painted if mark.shape == "polygon" and mark.fill == line_colour)
        x, y = line.points.T
        assert (x[1] - x[0]) / (x[2] - x[0]) == pytest.approx(0.25, abs=1e-3), "as far apart as the values"
        change = np.array([-0.02, 0.0, 0.05]) * (1 + place)
        low, high = -0.02 * 3 - 0.01, 0.05 * 3 + 0.01
        room = curve.height() - 54.0 - 22.0
        assert y == pytest.approx(54.0 + room * (high - change) / (high - low), abs=0.01)
        noise_px = room * 0.01 / (high - low)
        assert band.points[:, 0] == pytest.approx([*x, *x[::-1]], abs=0.01)
        assert band.points[:, 1] == pytest.approx([*(y - noise_px), *(y + noise_px)[::-1]], abs=0.01)
        assert 0.0 < band.opacity < 0.5
        dots = [mark for mark in painted if mark.shape == "circle" and mark.fill == line_colour]
        assert [mark.at for mark in dots] == [
            pytest.approx(point, abs=0.01) for point in line.points.tolist()
        ]
        assert any(mark.fill == line_colour and mark.text == name for mark in painted)
    assert curve.place_of(2).y() == pytest.approx(
        next(mark for mark in painted if mark.line == colour(CLASS_COLOURS[CLASSES[0]])).points[2, 1],
        abs=0.01,
    )


def test_a_curve_marks_zero_the_value_of_now_and_the_point_that_is_looked_at(curve: FieldCurve) -> None:
    def rules() -> tuple[list[float], list[float]]:
        lines = [mark.points for mark in marks(curve) if mark.shape == "line" and len(mark.points) == 2]
        level = [float(points[0, 1]) for points in lines if points[0, 1] == points[1, 1]]
        upright = [float(points[0, 0]) for points in lines if points[0, 0] == points[1, 0]]
        return level, upright

    level, upright = rules()
    assert level == pytest.approx([curve.place_of(1).y()], abs=0.01), "no change at the value of now"
    assert upright == pytest.approx([curve.place_of(1).x()], abs=0.01)
    QTest.keyClick(curve, Qt.Key.Key_Right)
    _, upright = rules()
    assert upright == pytest.approx([curve.place_of(1).x(), curve.place_of(2).x()], abs=0.01)
    dots = [mark for mark in marks(curve) if mark.shape == "circle"]
    sizes = [
        [dot.points[1, 0] for dot in dots if dot.fill == colour(CLASS_COLOURS[name])] for name in CLASSES
    ]
    assert all(few[2] > 1.5 * few[0] == 1.5 * few[1] for few in sizes), "the point is larger"
    words = {mark.text: mark.at for mark in marks(curve) if mark.shape == "text"}
    assert {"top: z", curve.note, "1 m", "3 m", "−7.0", "+16.0"} <= set(words)
    assert words["1 m"][0] < words["3 m"][0] and words["+16.0"][1] < words["−7.0"][1]
    curve.open_at(curve.parentWidget(), "top: z", 9.0, METRES)
    assert [mark for mark in marks(curve) if mark.shape in ("line", "circle")] == [], "no axes without points"
    curve.show_points(CURVE, "done")
    assert rules()[1] == [], "now is not on the chart"


# ---------------------------------------------------------------------- the tolerance of a class
def test_a_range_bar_has_draws_floor_median_and_worst_on_its_scale(qtbot: QtBot) -> None:
    bar = RangeBar()
    qtbot.addWidget(bar)
    assert [mark.shape for mark in marks(bar) if mark.shape != "rect"] == ["line", "line"], "only the axes"
    bar.show_range(Range(-2.0, 1.0, -0.5, -3.0, -0.25, 0.75), 4.0)
    painted = marks(bar)
    middle, half = BAR_PX / 2.0, BAR_PX / 2.0 - 4.0
    by_fill = {mark.fill: mark.points.ravel().tolist() for mark in painted if mark.shape == "rect"}
    for fill, low, high in ((tones().accent, -2.0, 1.0), (tones().text, -0.25, 0.75)):
        left, top, wide, tall = by_fill[colour(fill)]
        assert (left, wide) == pytest.approx((middle + half * low / 4.0, half * (high - low) / 4.0), abs=0.01)
        assert top + tall / 2.0 == ROW_PX / 2.0, "in the middle of the row"
    assert by_fill[colour(tones().text)][3] < by_fill[colour(tones().accent)][3], "the floor is thinner"
    (worst,) = (mark for mark in painted if mark.shape == "circle")
    assert worst.at == pytest.approx((middle + half * -3.0 / 4.0, ROW_PX / 2.0)) and worst.fill == colour(
        tones().less
    )
    upright = [
        mark.at[0] for mark in painted if mark.shape == "line" and mark.points[0, 0] == mark.points[1, 0]
    ]
    assert upright == [round(middle + half * -0.5 / 4.0), round(middle)], (
        "the median, and the rig as designed"
    )
    bar.show_range(Range(-9.0, 9.0, 0.0, -9.0, 0.0, 0.0), 4.0)
    widest = max(mark.points[1, 0] for mark in marks(bar) if mark.fill == colour(tones().accent))
    assert widest == pytest.approx(2.0 * half), "it ends with the bar"
    bar.grey()
    assert colour(tones().accent) not in {mark.fill for mark in marks(bar)}


# ---------------------------------------------------------------------- rigs as bars
class Known(CompareModel):
    """A model of one column whose figures a test gives."""

    def __init__(self, values: dict[str, float | None]) -> None:
        super().__init__()
        self._known = {key: None if value is None else Estimate(value) for key, value in values.items()}
        self._listed = tuple(CompareRow(key, f"rig {key}", "file", preset("W+T")) for key in values)

    @property
    def rows(self) -> tuple[CompareRow, ...]:
        return self._listed

    @property
    def columns(self) -> tuple[FigureColumn, ...]:
        return (FigureColumn("car", S_MS, "car S-MS", "S-MS"),)

    def estimate(self, row: CompareRow, column: FigureColumn) -> Estimate | None:
        return self._known[row.key]


def compared(
    qtbot: QtBot, values: dict[str, float | None], wide_px: int = 640
) -> tuple[CompareChart, tuple[CompareRow, ...]]:
    model = Known(values)
    chart = CompareChart(model)
    qtbot.addWidget(chart)
    chart.resize(wide_px, 200)
    chart.show_rows(model.rows, ())
    return chart, model.rows


def fills(painted: list[Mark]) -> list[Mark]:
    """Bars and swatches, without the ground."""
    return [
        mark for mark in painted if mark.shape == "rect" and mark.fill.upper() in map(str.upper, RIG_COLOURS)
    ]


def test_the_legend_names_each_rig_beside_its_colour(qtbot: QtBot) -> None:
    chart, rows = compared(qtbot, {"a": 2.0, "b": -1.0, "c": None})
    painted = marks(chart)
    swatches, bars = fills(painted)[:3], fills(painted)[3:]
    assert [mark.fill for mark in swatches] == [colour(name) for name in RIG_COLOURS[:3]]
    assert [mark.fill for mark in bars] == [colour(name) for name in RIG_COLOURS[:2]], "none without a figure"
    for swatch, row, (place, key, name) in zip(swatches, rows, chart.legend(), strict=True):
        (words,) = (mark for mark in painted if mark.text == name)
        corner, size = swatch.points
        assert key == row.key and name == row.title
        assert 0.0 < words.at[0] - (corner[0] + size[0]) < 10.0, "the name follows the swatch"
        assert place.left() == pytest.approx(corner[0], abs=0.01) and size[0] == size[1]
        assert corner[1] + size[1] / 2.0 == pytest.approx(place.center().y(), abs=0.01)
        assert corner[1] < words.at[1] < corner[1] + 2.0 * size[1]
    (zero_px,) = {chart.zero_px for chart in chart.charts()}
    up, down = (mark.points for mark in bars)
    assert [up[0, 1] + up[1, 1], down[0, 1]] == pytest.approx([zero_px] * 2, abs=0.01)
    assert up[1, 1] == pytest.approx(2.0 * down[1, 1], abs=0.1)


def test_of_selected_rigs_the_others_are_faint_and_their_names_plain(qtbot: QtBot) -> None:
    chart, rows = compared(qtbot, {"a": 2.0, "b": 1.0})
    assert {mark.opacity for mark in fills(marks(chart))} == {1.0}
    chart.show_rows(rows, ("b",))
    painted = marks(chart)
    for mark in fills(painted):
        assert (mark.opacity < 0.5) == (mark.fill == colour(RIG_COLOURS[0]))
    named = {mark.text: mark.fill for mark in painted if mark.text.startswith("rig ")}
    assert named == {"rig a": colour(tones().text), "rig b": colour(tones().accent)}


@pytest.mark.parametrize("wide_px", [640, 260])
def test_the_legend_fills_two_lines_at_most_and_stays_inside(qtbot: QtBot, wide_px: int) -> None:
    chart, rows = compared(qtbot, {f"{place} of many": 1.0 for place in range(30)}, wide_px)
    places = [place for place, _, _ in chart.legend()]
    lines = sorted({place.top() for place in places})
    assert len(lines) == 2 and 2 <= len(places) < len(rows)
    assert all(place.right() <= wide_px - 10.0 or place.left() == 10.0 for place in places)
    for line in lines:
        row = [place for place in places if place.top() == line]
        assert row[0].left() == 10.0
        assert all(a.right() < b.left() for a, b in pairwise(row))
    assert min(shown.area.top() for shown in chart.charts()) > max(place.bottom() for place in places)
    alone, _ = compared(qtbot, {}, wide_px)
    assert alone.legend() == [] and alone.charts()[0].area.top() < chart.charts()[0].area.top()


@pytest.mark.parametrize(
    ("values", "zero"),
    [((4.0, 2.0), 1.0), ((-4.0, -2.0), 0.0), ((3.0, -1.0), 0.75), ((0.0, 0.0), None), ((None, 2.0), 1.0)],
)
def test_bars_begin_at_zero_and_share_a_scale(values: tuple[float | None, ...], zero: float | None) -> None:
    area, words_px = QRectF(20.0, 30.0, 90.0, 116.0), 16.0
    estimates = [None if value is None else Estimate(value) for value in values]
    rows = [(CompareRow(str(place), "", "file", preset("W+T")), one) for place, one in enumerate(estimates)]
    made: Chart = chart_of(FigureColumn("car", S_MS, "", ""), rows, area, words_px)
    known = [(place, value) for place, value in enumerate(values) if value is not None]
    above, below = any(value > 0.0 for _, value in known), any(value < 0.0 for _, value in known)
    top, bottom = area.top() + words_px * above, area.bottom() - words_px * below
    assert made.zero_px == pytest.approx(top if zero is None else top + zero * (bottom - top))
    span = max(0.0, *(value for _, value in known)) - min(0.0, *(value for _, value in known))
    for bar, (place, value) in zip(made.bars, known, strict=True):
        step = min(area.width() / len(values), 64.0)
        assert bar.row.key == str(place) and bar.value.value == value
        assert (bar.column.left(), bar.column.width()) == (area.left() + place * step, step)
        assert (bar.column.top(), bar.column.height()) == (area.top(), area.height())
        assert bar.area.center().x() == pytest.approx(bar.column.center().x())
        assert 0.5 * step < bar.area.width() < step
        long_px = (bottom - top) * abs(value) / span if span else 1.0
        assert bar.area.height() == pytest.approx(max(1.0, long_px))
        ends = bar.area.bottom() if value > 0.0 else bar.area.top()
        assert ends == pytest.approx(made.zero_px)
    wide = side_by_side(area, 3, 12.0)
    assert [place.width() for place in wide] == [pytest.approx(22.0)] * 3
    assert wide[-1].right() == pytest.approx(area.right()) and wide[0].left() == area.left()
    assert wide[1].left() - wide[0].right() == pytest.approx(12.0)


# ---------------------------------------------------------------------- charts of proposed rigs
def test_lines_of_plots_have_smooth_edges(qtbot: QtBot) -> None:
    plots = Plots()
    qtbot.addWidget(plots)
    plots.resize(520, 170)
    ends = (Dot(0.0, 10.0, "first"), Dot(4.0, 30.0, "second"))
    plots.show_plots([Plot("Search", "rigs", (Line(((0.0, 10.0), (4.0, 30.0)), "less"),), ends)])
    image, middle = plots.grab().toImage(), (plots.place_of(0, 0) + plots.place_of(0, 1)) / 2.0
    place = (range(-12, 13), range(-12, 13))
    pixels = {image.pixelColor(int(middle.x()) + x, int(middle.y()) + y).name() for x, y in product(*place)}
    assert colour(tones().less) in pixels
    assert len(pixels - {colour(getattr(tones(), tone)) for tone in ("less", "field", "border")}) > 3


def test_plots_draw_dots_lines_and_round_values_where_their_axes_have_them(qtbot: QtBot) -> None:
    plots = Plots()
    qtbot.addWidget(plots)
    plots.resize(520, 170)
    dots = (Dot(0.0, 10.0, "first", "one"), Dot(4.0, 30.0, "second"), Dot(2.0, 20.0, "third", "three"))
    lines = (Line(((0.0, 10.0), (4.0, 30.0)), "less"),)
    plots.show_plots([Plot("Search", "rigs", lines, dots), Plot("Nothing", "x", empty="none yet")])
    painted = marks(plots)
    circles = [mark for mark in painted if mark.shape == "circle"]
    a, b, c = (mark.points[0] for mark in circles)
    assert a[0] < c[0] < b[0] and a[1] > c[1] > b[1], "to the right and up"
    assert (a + b) / 2.0 == pytest.approx(c, abs=0.01), "evenly"
    assert [plots.place_of(0, n).toTuple() for n in range(3)] == [
        pytest.approx(p, abs=0.01) for p in (a, b, c)
    ]
    assert [mark.fill for mark in circles] == [
        colour(tones().accent),
        colour(tones().muted),
        colour(tones().accent),
    ]
    (line,) = (mark for mark in painted if mark.line == colour(tones().less))
    assert line.points == pytest.approx(np.array([a, b]), abs=0.01)
    rules = [mark.points for mark in painted if mark.line == colour(tones().border)]
    numbers = [mark for mark in painted if re.fullmatch(r"[\d.]+", mark.text)]
    beside = [
        mark for mark in numbers if mark.at[0] < rules[0][0, 0] and mark.at[1] < rules[0][:, 1].max() + 9.0
    ]
    for rule, number in zip(rules, beside, strict=True):
        assert rule[0, 1] == rule[1, 1] and abs(number.at[1] - 4.0 - rule[0, 1]) < 4.0
        assert float(number.text) == pytest.approx(
            10.0 + 20.0 * (a[1] - rule[0, 1]) / (a[1] - b[1]), abs=0.01
        )
    for number in numbers[len(rules) :]:
        wide = plots.fontMetrics().horizontalAdvance(number.text)
        across = 4.0 * (number.at[0] + wide / 2.0 - a[0]) / (b[0] - a[0])
        assert float(number.text) == pytest.approx(across, abs=0.15)
    assert len(numbers) - len(rules) >= 2
    assert len(rules) >= 2 and "none" in " ".join(texts(painted))
    plots.highlight("three")
    sizes = [mark.points[1, 0] for mark in marks(plots) if mark.shape == "circle"]
    assert sizes[2] == pytest.approx(1.5 * sizes[0]) and sizes[0] == sizes[1]
    assert plots.dot_at(QPointF(*(c + 6.0))) == dots[2] and plots.dot_at(QPointF(*(c + 8.0))) is None
    assert plots.dot_at(QPointF(500.0, 80.0)) is None, "beside an empty chart"


# ---------------------------------------------------------------------- the rose
@pytest.mark.parametrize("figure", [ON_TARGET, POINTS], ids=lambda figure: figure.key)
def test_a_wedge_is_the_stronger_the_larger_its_figure(qtbot: QtBot, figure: ObjectFigure) -> None:
    rose, rig = RoseView(), rig_of(spinning((0.0, 0.0, 1.9)))
    qtbot.addWidget(rose)
    rose.resize(rose.width(), rose.width())
    assert marks(rose)[1:] == [], "nothing before there are figures"
    counted = TargetEngine(random_traffic(np.random.default_rng(3), 30), threads=1).evaluate(rig, USUAL, None)
    cells, edges_m = FigureCells.of(figure, counted, counted, "ring and sector"), counted.groups.edges_m
    rose.show_figure(cells, "car", edges_m.tolist(), "")
    painted = marks(rose)
    wedges = [mark for mark in painted if mark.shape == "path" and mark.line == colour(tones().border)]
    values = [cells.at("car", part)[0] for part in range((len(edges_m) - 1) * len(SECTORS))]
    largest = max(one.value for one in values if one.exists)
    side_px = rose.width()
    radius_px = side_px / 2.0 - MARGIN_PX
    for part, (wedge, one) in enumerate(zip(wedges, values, strict=True)):
        ring, sector = divmod(part, len(SECTORS))
        away = wedge.points - [side_px / 2.0, side_px / 2.0 + 2.0]
        ends_m = np.hypot(*away.T) * edges_m[-1] / radius_px
        assert (ends_m.min(), ends_m.max()) == pytest.approx(
            (edges_m[ring], edges_m[ring + 1]), rel=0.05, abs=0.5
        )
        middle = away[np.abs(ends_m - ends_m.max()) < 0.05 * ends_m.max()].mean(axis=0)
        assert sector_of(-middle[1], -middle[0]) == sector
        assert (wedge.fill == "none") == (not one.exists)
        if one.exists:
            share = one.value if figure.unit == "share" else np.log1p(one.value) / np.log1p(largest)
            assert wedge.fill == colour(tones().accent)
            assert wedge.opacity == pytest.approx(0.06 + 0.84 * share, abs=0.01)
    assert len({wedge.opacity for wedge in wedges}) > 2
    words = {mark.text: mark.at for mark in painted if mark.shape == "text"}
    assert words["front"][1] < side_px / 4.0 and words[f"{edges_m[-1]:g} m"][1] > 3.0 * side_px / 4.0
    (car,) = (mark for mark in painted if mark.fill == colour(tones().text) and mark.shape != "text")
    assert np.ptp(car.points[:, 1]) > np.ptp(car.points[:, 0]), "it heads to the front"
    rose.grey()
    assert {wedge.fill for wedge in marks(rose) if wedge.opacity < 0.95} == {colour(tones().muted)}
