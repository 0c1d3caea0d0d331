"""The Targets panel: numbers with error and change, a rose by direction, and what both say in words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Estimate
from riglens.core.figures.hits import MISSED, ON_TARGET, POINTS, RESOLVED, SEEN_BY_CAMERAS, SHARE_5
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import FOUND, PREDICTED
from riglens.core.figures.registry import figures, leading_figures, object_figures
from riglens.core.figures.text import (
    change_estimate_text,
    change_text,
    error_text,
    estimate_text,
    parts_text,
    value_text,
)
from riglens.core.figures.values import FigureCells
from riglens.core.figures.weakest import Weakest, weakest_text
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.calibration import shipped
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from riglens.widgets.panels.figures.table import Cell
from riglens.widgets.panels.scores.panel import ScoresPanel
from riglens.widgets.panels.scores.table import ROW_PX, TWO_LINES_PX
from riglens.widgets.panels.scores.text import SCORE_FIGURES
from riglens.widgets.panels.targets.panel import TargetsPanel
from tests.core.builders import camera, lidar, rig_of, spinning
from tests.core.targets.cases import random_traffic

TRAFFIC = random_traffic(np.random.default_rng(3), 30)
NOW, BEFORE = rig_of(spinning((0.0, 0.0, 1.9))), rig_of(spinning((0.0, 0.0, 0.6)))


def counts(rig: Rig, frames: int | None = None) -> Counted:
    return TargetEngine(TRAFFIC, threads=1).evaluate(rig, USUAL, frames)


@pytest.fixture
def panel(qtbot: QtBot) -> TargetsPanel:
    made = TargetsPanel(USUAL)
    qtbot.addWidget(made)
    made.resize(1000, 230)
    made.show()
    return made


def show(panel: TargetsPanel, frames: int | None = None) -> None:
    panel.show_counts(counts(NOW, frames), counts(BEFORE, frames), "low")


def item(panel: TargetsPanel, who: str, column: int) -> Cell:
    return panel.table.figures.cell(CLASSES_AND_ALL.index(who), column)


def test_a_panel_out_of_sight_makes_its_table_when_it_is_looked_at(panel: TargetsPanel) -> None:
    panel.hide()
    show(panel)
    assert panel.table.figures.row_titles == ()
    panel.show()
    assert item(panel, "car", 0).text


def test_a_cell_shows_value_error_and_change(panel: TargetsPanel) -> None:
    show(panel, 12)
    panel.choose(ON_TARGET.key)
    cells = ON_TARGET.cells(counts(NOW, 12), counts(BEFORE, 12))
    shown = item(panel, "car", 0)
    assert shown.text == value_text(ON_TARGET, float(cells.value[1, 0]), decimals=1)
    assert shown.error == error_text(ON_TARGET, float(cells.se[1, 0])) != ""
    assert shown.change == change_text(ON_TARGET, float(cells.change[1, 0]), decimals=1) != ""
    assert "low" in shown.tip and "±" in shown.tip


def test_all_frames_have_no_error(panel: TargetsPanel) -> None:
    panel.choose(ON_TARGET.key)
    show(panel)
    assert item(panel, "car", 0).error == ""
    assert "all 30 frames" in panel._note.text()


def test_a_ring_without_objects_has_no_error_of_the_calibration(panel: TargetsPanel) -> None:
    panel.choose(FOUND.key)
    show(panel)
    last = len(counts(NOW).groups.edges_m) - 1
    assert item(panel, "car", 0).error.startswith("±")
    assert (item(panel, "car", last).text, item(panel, "car", last).error) == ("—", "")


def test_a_sample_says_so(panel: TargetsPanel) -> None:
    show(panel, 12)
    assert "sample of 12 of 30 frames" in panel._note.text()


def test_kinds_that_a_rig_holds_have_a_figure(panel: TargetsPanel) -> None:
    def keys() -> list[object]:
        return [panel._choice.itemData(place) for place in range(panel._choice.count())]

    def of(*kinds: str) -> list[object]:
        return [one.key for one in object_figures(kinds)]

    show(panel)
    assert keys() == of()
    radar = rig_of(sensor_from_model("continental-ars408-21", "front", Pose((2.0, 0.0, 0.5))))
    panel.show_counts(counts(radar), counts(NOW), "low")
    assert keys() == of("radar") != of()
    panel.choose("radar")
    (share,) = panel.figure.estimates(counts(radar), "all")["car"]
    assert item(panel, "car", 0).text == value_text(panel.figure, share.value, decimals=1) != "0.0 %"
    show(panel)
    assert panel.figure.key == "radar" and item(panel, "car", 0).text == "—"
    assert "radar" in item(panel, "car", 0).tip


def test_a_rig_without_the_sensors_of_a_figure_has_none_and_says_why(panel: TargetsPanel) -> None:
    radar = rig_of(sensor_from_model("continental-ars408-21", "front", Pose((2.0, 0.0, 0.5))))
    panel.choose(ON_TARGET.key)
    panel.show_counts(counts(radar), counts(radar), "low")
    assert item(panel, "car", 0).text == "—" and "LiDAR" in item(panel, "car", 0).tip
    assert panel.rose.text_at(panel.rose._centre()).endswith(item(panel, "car", 0).tip.split(": ")[1])


def test_fewer_missed_is_better(panel: TargetsPanel) -> None:
    panel.choose(MISSED.key)
    show(panel)
    for who in CLASSES_AND_ALL:
        shown = item(panel, who, 0)
        wrong = {"−": "less", "+": "more"}
        assert shown.change_tone != wrong.get(shown.change[:1])
    blind, seeing = (
        counts(rig_of(lidar((0.0, 0.0, 1.9)))),
        counts(rig_of(spinning((0.0, 0.0, 1.9), beams=64, count=720))),
    )
    panel.show_counts(seeing, blind, "blind")
    assert item(panel, CLASSES_AND_ALL[0], 0).change_tone == "more"
    panel.show_counts(blind, seeing, "seeing")
    assert item(panel, CLASSES_AND_ALL[0], 0).change_tone == "less"


def test_a_change_too_small_to_tell_rigs_apart_is_neither_better_nor_worse(panel: TargetsPanel) -> None:
    figure = ON_TARGET
    nearly = rig_of(spinning((0.0, 0.0, 1.8)))
    panel.choose(figure.key)
    panel.show_counts(counts(NOW), counts(nearly), "nearly")
    change = float(figure.cells(counts(NOW), counts(nearly)).change[0, 0])
    assert 0.0 < abs(change) < RESOLVED
    assert item(panel, CLASSES_AND_ALL[0], 0).change_tone == "text"
    panel.show_counts(counts(NOW), counts(rig_of()), "blind")
    assert item(panel, CLASSES_AND_ALL[0], 0).change_tone == "more"


def test_numbers_out_of_date_are_grey(panel: TargetsPanel) -> None:
    show(panel)
    panel.set_stale()
    assert 0 in panel.table.figures._grey


def test_another_number_of_points_is_wanted_once(panel: TargetsPanel, qtbot: QtBot) -> None:
    with qtbot.waitSignal(panel.settings_wanted) as told:
        panel._points.setValue(9)
    assert told.args[0].min_points == 9


def test_a_problem_stands_in_the_place_of_the_note(panel: TargetsPanel) -> None:
    show(panel)
    ahead = panel.rose._centre() - QPointF(0.0, panel.rose._radius(3) - 1.0)
    assert panel.rose.text_at(ahead)
    panel.show_problem("No boxes")
    assert panel._note.text() == "No boxes" and panel.rose.text_at(ahead) == ""
    panel.say("Counting")
    assert panel._note.text() == "Counting" and "Counting" in panel._note.toolTip()


def test_the_rose_follows_the_row_and_tells_where_a_wedge_is(panel: TargetsPanel) -> None:
    show(panel)
    panel.table.selectRow(CLASSES_AND_ALL.index("pedestrian"))
    rose = panel.rose
    ahead = rose._centre() - QPointF(0.0, rose._radius(3) - 1.0)
    left = rose._centre() - QPointF(rose._radius(3) - 1.0, 0.0)
    assert rose.text_at(ahead).startswith("Pedestrians, front, 20–30 m")
    assert rose.text_at(left).startswith("Pedestrians, left, 20–30 m")
    assert rose.text_at(QPointF(1.0, 1.0)) == ""


def test_the_rose_is_drawn_and_greyed(panel: TargetsPanel) -> None:
    show(panel)
    before = panel.rose.grab().toImage()
    panel.rose.grey()
    assert panel.rose.grab().toImage() != before


def test_the_text_for_the_clipboard_holds_every_digit(panel: TargetsPanel) -> None:
    panel.choose(ON_TARGET.key)
    show(panel)
    lines = [line.split("\t") for line in panel.table.as_text().splitlines()]
    assert len(lines) == 1 + len(CLASSES_AND_ALL) and len(set(map(len, lines))) == 1
    cells = ON_TARGET.cells(counts(NOW), counts(BEFORE))
    assert float(lines[1][1]) == cells.value[0, 0] and int(lines[1][4]) == cells.objects[0, 0]


@pytest.mark.parametrize(("figure", "value", "text"), [(ON_TARGET, 0.5, "50.0 %"), (POINTS, 12.0, "12 pts")])
def test_values_have_units(figure: ObjectFigure, value: float, text: str) -> None:
    assert value_text(figure, value, decimals=1) == text
    assert estimate_text(figure, Estimate.none("nothing")) == "—"


@pytest.mark.parametrize(
    ("change", "text"),
    [(0.0, "—"), (0.0001, "<0.1 pp"), (-0.0001, "<0.1 pp"), (0.123, "+12.3 pp"), (-0.123, "−12.3 pp")],
)
def test_changes_have_sign_and_unit(change: float, text: str) -> None:
    assert change_text(MISSED, change, decimals=1) == text
    assert change_text(POINTS, -3.0) == "−3.0 pts"


@pytest.mark.parametrize(("height_px", "row_px"), [(150, 30), (230, None), (500, 38)])
def test_all_classes_are_in_sight_where_there_is_room(
    panel: TargetsPanel, height_px: int, row_px: int | None
) -> None:
    show(panel)
    panel.resize(1000, height_px)
    table = panel.table
    rows_px = [table.rowHeight(row) for row in range(table.figures.rowCount())]
    assert len(set(rows_px)) == 1 and 30 <= rows_px[0] <= 38
    assert rows_px[0] == (row_px or rows_px[0])
    assert height_px < 230 or sum(rows_px) <= table.viewport().height()


def test_every_choice_can_be_made(panel: TargetsPanel) -> None:
    show(panel)
    for number, figure in enumerate(object_figures(())):
        assert panel._choice.itemData(number, Qt.ItemDataRole.ToolTipRole) == figure.tip
        panel.choose(figure.key)
        assert panel.figure is figure and panel.table.as_text().startswith(f"class\t{figure.title}")


@pytest.fixture
def scores(qtbot: QtBot) -> ScoresPanel:
    made = ScoresPanel(MetricSettings())
    qtbot.addWidget(made)
    made.resize(1400, 230)
    made.show()
    return made


def cells_of(now: Counted, before: Counted) -> dict[str, FigureCells]:
    return {one.key: FigureCells.of(one, now, before) for one in object_figures()}


def show_counted(scores: ScoresPanel, cells: dict[str, FigureCells]) -> None:
    scores.show_figures("objects", {key: found.compared() for key, found in cells.items()})
    scores.show_found(cells[FOUND.key])


def test_the_score_table_shows_predicted_detection_with_the_error_of_its_calibration(
    scores: ScoresPanel,
) -> None:
    now, before = counts(NOW), counts(BEFORE)
    show_counted(scores, cells_of(now, before))
    (found,) = PREDICTED.estimates(now, "all")["car"]
    assert found.se == now.calibration.classes.car.error  # type: ignore[union-attr]
    assert scores.table.cell("car", "predicted").text == estimate_text(PREDICTED, found)
    change = FigureCells.of(PREDICTED, now, before).at("car")[1]
    assert scores.table.cell("car", "predicted change").text == change_estimate_text(PREDICTED, change)
    assert now.calibration.detector in scores.table.cell("car", "predicted").tip
    assert f"within {now.within_m:g} m" in scores.table.cell("car", "predicted").tip


def test_the_domain_stands_with_the_share_found_and_goes_with_it(scores: ScoresPanel) -> None:
    now = counts(NOW)
    recall, (known,) = now.settings.recall, FOUND.estimates(now, "all")["car"]
    assert recall is not None and scores.found == ""
    found = FigureCells.of(FOUND, now, now)
    for outside in ("", "too many rays"):
        scores.show_found(replace(found, outside=outside))
        assert f"car {100 * known.value:.0f} ±{200 * known.se:.0f}" in scores.found
        assert recall.domain.region in scores.found and outside in scores.found
        assert scores._found.isEnabled() == (not outside)
        assert scores._found.isVisible() and scores.minimumSizeHint().width() < 700
        QApplication.processEvents()
        assert scores._found.width() >= min(scores._found.sizeHint().width(), 300)
    scores.show_found(found)
    scores.grey_counted()
    assert not scores._found.isEnabled()
    alone = replace(now, settings=replace(now.settings, calibration=shipped()))
    scores.show_found(FigureCells.of(FOUND, alone, alone))
    assert scores.found == "", "a calibration of AP alone"
    scores.show_found(found)
    scores.forget_counted("no boxes")
    assert scores.found == ""


def test_a_figure_is_grey_outside_its_domain_and_says_why(scores: ScoresPanel) -> None:
    now = counts(NOW)
    found = FigureCells.of(PREDICTED, now, now)
    for outside, tone in (("", "text"), ("too many rays", "muted")):
        inside = replace(found, outside=outside)
        scores.show_figures("objects", {PREDICTED.key: inside.compared()})
        cell = scores.table.cell("car", "predicted")
        assert cell.tone == tone and outside in cell.tip and now.calibration.detector in cell.tip


def test_a_rig_of_cameras_has_no_figure_of_lidars_and_says_why(scores: ScoresPanel) -> None:
    eye = counts(rig_of(camera((0.0, 0.0, 1.6))))
    show_counted(scores, cells_of(eye, counts(NOW)))
    for key in (SHARE_5.key,):
        cell, change = scores.table.cell("car", key), scores.table.cell("car", f"{key} change")
        assert (cell.text, cell.tone, change.text, change.tone) == ("—", "muted", "—", "muted")
        assert "LiDAR" in cell.tip and set(cell.values) == {None}


@pytest.mark.parametrize(
    ("change", "se", "tone"),
    [(0.02, 0.0, "more"), (-0.02, 0.0, "less"), (0.009, 0.0, "text"), (0.02, 0.02, "text")],
)
@pytest.mark.parametrize("figure", [PREDICTED, SHARE_5])
def test_a_difference_that_is_not_resolved_is_neither_better_nor_worse(
    scores: ScoresPanel, figure: ObjectFigure, change: float, se: float, tone: str
) -> None:
    found = FigureCells.of(figure, counts(NOW), counts(NOW))
    shape = found.cells.change.shape
    cells = replace(found.cells, change=np.full(shape, change), traffic_se=np.full(shape, se))
    moved = replace(found, outside="", cells=cells)
    scores.show_figures("objects", {figure.key: moved.compared()})
    assert scores.table.cell("car", f"{figure.key} change").tone == tone
    assert ("better" in scores.table.cell("car", figure.key).tip) == (tone == "more")


def test_the_score_table_shows_a_figure_with_error_and_change(scores: ScoresPanel) -> None:
    dense = rig_of(spinning((0.0, 0.0, 1.9), beams=64, count=720))
    cells = cells_of(counts(dense, 12), counts(BEFORE, 12))
    show_counted(scores, cells)
    key = SHARE_5.key
    value, change = cells[key].at("car")
    shown, changed = scores.table.cell("car", key), scores.table.cell("car", f"{key} change")
    assert shown.text == estimate_text(SHARE_5, value) and "±" in shown.text
    assert changed.text == change_estimate_text(SHARE_5, change) and "±" in changed.text
    show_counted(scores, cells_of(counts(NOW), counts(NOW)))
    assert scores.table.cell("car", f"{key} change").text == "—"


def test_the_first_row_is_the_mean_of_the_classes_with_its_error_and_parts(scores: ScoresPanel) -> None:
    now, before = counts(NOW), counts(BEFORE)
    cells = cells_of(now, before)
    show_counted(scores, cells)
    scores.show_pending()
    (mean,) = PREDICTED.estimates(now, "all")[ALL]
    shown = scores.table.cell(ALL, "predicted")
    assert shown.text == estimate_text(PREDICTED, mean) and mean.se == now.calibration.mean_error
    assert shown.error.split(" · ")[0] == parts_text(PREDICTED, mean) != ""
    assert scores.table.cell(ALL, "s_ms").text == "", "entropies have no mean"
    weak = Weakest(("bicycle", 0.2), ("rear", 0.1), 30.0)
    found = replace(cells[SHARE_5.key].compared(), weakest={ALL: weak, "car": Weakest(sector=("left", 0.3))})
    scores.show_figures("objects", {SHARE_5.key: found})
    value = scores.table.cell(ALL, SHARE_5.key)
    assert "bicycle, rear" in value.error and "30 m" in value.error
    assert (
        weakest_text(SHARE_5, weak) in value.tip
        and "left 30.0 %" in scores.table.cell("car", SHARE_5.key).tip
    )


@pytest.mark.parametrize(
    ("height_px", "lines"),
    [
        (4 * ROW_PX, [ROW_PX, ROW_PX]),
        (TWO_LINES_PX + 3 * ROW_PX, [TWO_LINES_PX, ROW_PX]),
        (4 * TWO_LINES_PX, [TWO_LINES_PX, TWO_LINES_PX]),
    ],
)
def test_a_second_line_needs_room_in_the_first_row_then_in_all(
    scores: ScoresPanel, height_px: int, lines: list[int]
) -> None:
    size = QSize(900, height_px)
    scores.table.resizeEvent(QResizeEvent(size, size))
    assert [scores.table.verticalHeader().sectionSize(row) for row in (0, 1)] == lines


def test_an_exact_value_moved_by_a_sample_has_the_errors_of_calibration_and_change() -> None:
    exact = FigureCells.of(PREDICTED, counts(BEFORE), counts(BEFORE))
    sample = FigureCells.of(PREDICTED, counts(NOW, 12), counts(BEFORE, 12))
    value, change = sample.anchored(exact).at("car")
    known, _ = exact.at("car")
    assert value.value == known.value + change.value and change == sample.at("car")[1]
    of_sample = float(sample.cells.change_se[CLASSES_AND_ALL.index("car"), 0])
    assert value.se == float(np.hypot(known.se, of_sample)) > known.se > 0.0


def test_the_leading_figures_are_always_shown_and_details_of_the_paper_on_request(
    scores: ScoresPanel,
) -> None:
    table = scores.table
    details = [one.key for one in figures() if one.of_paper and not one.leads]
    leading = [one.key for one in leading_figures()]
    assert [one.key for one in table.shown] == leading + details and details
    for width, has_details in ((1400, False), (700, True), (700, False)):
        scores.resize(width, 230)
        scores.set_details(has_details)
        for key in leading + details:
            for column in (key, f"{key} change"):
                hidden = key in details and not has_details
                assert table.isColumnHidden(table.place_of(column)) == hidden


def test_scores_and_road_users_are_greyed_apart(scores: ScoresPanel) -> None:
    show_counted(scores, cells_of(counts(NOW), counts(BEFORE)))
    table = scores.table
    place = table.place_of("share_5")
    table.grey("voxels")
    assert place not in table.figures._grey
    scores.grey_counted()
    assert place in table.figures._grey


def test_without_road_users_there_is_no_number_and_nothing_to_copy(scores: ScoresPanel) -> None:
    show_counted(scores, cells_of(counts(NOW), counts(BEFORE)))
    columns = [
        column
        for figure in scores.table.shown
        if figure.needs == "objects" and figure is not SEEN_BY_CAMERAS  # the rig has no camera
        for column in (figure.key, f"{figure.key} change")
    ]
    copied = scores.table.as_text()
    assert not any(None in scores.table.cell(name, one).values for name in CLASSES for one in columns)
    scores.forget_counted("no boxes")
    assert scores.table.as_text() != copied
    for name in CLASSES:
        for cell in (scores.table.cell(name, one) for one in columns):
            assert cell.text == "—" and set(cell.values) <= {None} and "no boxes" in cell.tip


@pytest.mark.parametrize("page", ["README.md", "docs/metric.md"])
def test_the_pages_say_the_same_of_the_four_figures_as_the_panel(page: str) -> None:
    found = " ".join((Path(__file__).parents[3] / page).read_text("utf-8").split())
    for name, said in SCORE_FIGURES:
        assert f"**{name}** {said}" in found
