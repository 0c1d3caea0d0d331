"""The Targets panel: numbers with error and change, a rose by direction, and what both say in words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.quantities import (
    CLASSES_AND_ALL,
    FOUND,
    ON_TARGET,
    PREDICTED,
    QUANTITIES,
    RESOLVED,
    Quantity,
)
from riglens.core.targets.scores import TargetScores
from riglens.core.targets.settings import USUAL
from riglens.core.targets.tables import predicted_of, table_of, totals_of
from riglens.widgets.panels.figures.table import Figure
from riglens.widgets.panels.scores.panel import ScoresPanel
from riglens.widgets.panels.scores.table import ScoreTable
from riglens.widgets.panels.scores.text import SCORE_FIGURES, sampled_change_text, sampled_text
from riglens.widgets.panels.targets.panel import TargetsPanel
from riglens.widgets.panels.targets.text import change_text, error_text, value_text
from tests.core.builders import rig_of, spinning
from tests.core.targets.cases import random_traffic

TRAFFIC = random_traffic(np.random.default_rng(3), 30)
NOW, BEFORE = rig_of(spinning((0.0, 0.0, 1.9))), rig_of(spinning((0.0, 0.0, 0.6)))
MEDIAN, MISSED = next(one for one in QUANTITIES if one.is_median), QUANTITIES[-1]


def counts(rig: Rig, frames: int | None = None) -> TargetScores:
    return TargetEngine(TRAFFIC, threads=1).evaluate(rig, USUAL, frames)


@pytest.fixture
def panel(qtbot: QtBot) -> TargetsPanel:
    made = TargetsPanel(USUAL)
    qtbot.addWidget(made)
    made.resize(1000, 230)
    made.show()
    return made


def show(panel: TargetsPanel, frames: int | None = None) -> None:
    panel.show_counts(TRAFFIC, counts(NOW, frames), counts(BEFORE, frames), "low")


def item(panel: TargetsPanel, who: str, column: int) -> Figure:
    return panel.table.figures.cell(CLASSES_AND_ALL.index(who), column)


def test_a_panel_out_of_sight_makes_its_table_when_it_is_looked_at(panel: TargetsPanel) -> None:
    panel.hide()
    show(panel)
    assert panel.table.figures.row_titles == ()
    panel.show()
    assert item(panel, "car", 0).text


def test_the_region_of_the_prediction_makes_all_figures_of_the_same_objects(panel: TargetsPanel) -> None:
    def objects() -> list[int]:
        return [int(line.split("\t")[4]) for line in panel.table.as_text().splitlines()[1:]]

    show(panel)
    everywhere, note = objects(), panel._note.text()
    panel.choose(PREDICTED.key)
    predicted, total = objects(), sum(objects()[1:])
    panel.choose(ON_TARGET.key)
    panel._region.setCurrentIndex(1)
    assert objects() == predicted and sum(predicted) < sum(everywhere)
    now = counts(NOW)
    domain = now.calibration.domain
    inside = domain.holds(TRAFFIC.centre_m[now.objects.box])
    on_target = now.objects.on_target[inside & (TRAFFIC.cls[now.objects.box] == 0)].mean()
    assert item(panel, "car", 0).text == value_text(ON_TARGET, float(on_target))
    assert domain.region in panel._note.text() != note and f"{total:,} objects" in panel._note.text()
    panel._region.setCurrentIndex(0)
    assert objects() == everywhere and panel._note.text() == note


def test_a_cell_shows_value_error_and_change(panel: TargetsPanel) -> None:
    show(panel, 12)
    cells = table_of(TRAFFIC, counts(NOW, 12), counts(BEFORE, 12), ON_TARGET).cells
    shown = item(panel, "car", 0)
    assert shown.text == value_text(ON_TARGET, float(cells.value[1, 0]))
    assert shown.error == error_text(ON_TARGET, float(cells.se[1, 0])) != ""
    assert shown.change == change_text(ON_TARGET, float(cells.change[1, 0])) != ""
    assert "low" in shown.tip and "±" in shown.tip


def test_all_frames_have_no_error(panel: TargetsPanel) -> None:
    show(panel)
    assert item(panel, "car", 0).error == ""
    assert "all 30 frames" in panel._note.text()


def test_a_ring_without_objects_has_no_error_of_the_calibration(panel: TargetsPanel) -> None:
    panel.choose(FOUND.key)
    show(panel)
    last = len(table_of(TRAFFIC, counts(NOW), counts(NOW), FOUND).edges_m) - 1
    assert item(panel, "car", 0).error.startswith("±")
    assert (item(panel, "car", last).text, item(panel, "car", last).error) == ("–", "")


def test_a_sample_says_so(panel: TargetsPanel) -> None:
    show(panel, 12)
    assert "sample of 12 of 30 frames" in panel._note.text()


def test_kinds_that_a_rig_holds_have_a_figure(panel: TargetsPanel) -> None:
    def keys() -> list[object]:
        return [panel._quantity.itemData(place) for place in range(panel._quantity.count())]

    show(panel)
    assert keys() == [one.key for one in QUANTITIES]
    radar = rig_of(sensor_from_model("continental-ars408-21", "front", Pose((2.0, 0.0, 0.5))))
    panel.show_counts(TRAFFIC, counts(radar), counts(NOW), "low")
    assert keys() == [*(one.key for one in QUANTITIES), "radar"]
    panel.choose("radar")
    share = counts(radar).classes["car"].total.by_kind["radar"].value
    assert item(panel, "car", 0).text == f"{100.0 * share:.1f} %" != "0.0 %"
    show(panel)
    assert panel.quantity.key == "radar" and item(panel, "car", 0).text == "0.0 %"


def test_fewer_missed_is_better(panel: TargetsPanel) -> None:
    panel.choose("neither")
    show(panel)
    for who in CLASSES_AND_ALL:
        shown = item(panel, who, 0)
        if shown.change.startswith("−"):
            assert shown.change_tone == "more"
        elif shown.change.startswith("+"):
            assert shown.change_tone == "less"


@pytest.mark.parametrize("quantity", [ON_TARGET, PREDICTED, FOUND])
def test_a_change_too_small_to_tell_rigs_apart_is_neither_better_nor_worse(
    panel: TargetsPanel, quantity: Quantity
) -> None:
    nearly = rig_of(spinning((0.0, 0.0, 1.8)))
    panel.choose(quantity.key)
    panel.show_counts(TRAFFIC, counts(NOW), counts(nearly), "nearly")
    change = float(table_of(TRAFFIC, counts(NOW), counts(nearly), quantity).cells.change[0, 0])
    assert 0.0 < abs(change) < RESOLVED
    assert item(panel, CLASSES_AND_ALL[0], 0).change_tone == "text"
    show(panel)
    assert item(panel, CLASSES_AND_ALL[0], 0).change_tone in ("more", "less")


def test_numbers_out_of_date_are_grey(panel: TargetsPanel) -> None:
    show(panel)
    panel.set_stale()
    assert 0 in panel.table.figures._grey


def test_another_number_of_points_is_wanted_once(panel: TargetsPanel, qtbot: QtBot) -> None:
    with qtbot.waitSignal(panel.settings_wanted) as told:
        panel._points.setValue(9)
    assert told.args[0].min_points == 9


def test_a_problem_stands_in_the_place_of_the_note(panel: TargetsPanel) -> None:
    panel.show_problem("No boxes")
    assert panel._note.text() == "No boxes"
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
    show(panel)
    lines = [line.split("\t") for line in panel.table.as_text().splitlines()]
    assert len(lines) == 1 + len(CLASSES_AND_ALL) and len(set(map(len, lines))) == 1
    cells = table_of(TRAFFIC, counts(NOW), counts(BEFORE), ON_TARGET).cells
    assert float(lines[1][1]) == cells.value[0, 0] and int(lines[1][4]) == cells.objects[0, 0]


@pytest.mark.parametrize(
    ("quantity", "value", "text"),
    [(ON_TARGET, 0.5, "50.0 %"), (ON_TARGET, float("nan"), "–"), (MEDIAN, 12.0, "12 pts")],
)
def test_values_have_units(quantity, value: float, text: str) -> None:
    assert value_text(quantity, value) == text


@pytest.mark.parametrize(
    ("change", "text"),
    [(0.0, ""), (0.0001, "+<0.1 pp"), (-0.0001, "−<0.1 pp"), (0.123, "+12.3 pp"), (-0.123, "−12.3 pp")],
)
def test_changes_have_sign_and_unit(change: float, text: str) -> None:
    assert change_text(MISSED, change) == text
    assert change_text(MEDIAN, -3.0) == "−3.0 pts"


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


def test_every_quantity_says_which_way_is_better() -> None:
    for quantity in QUANTITIES:
        assert quantity.tip.endswith("Less is better." if quantity.sign < 0 else "More is better.")


def test_every_choice_can_be_made(panel: TargetsPanel) -> None:
    show(panel)
    for number, quantity in enumerate(QUANTITIES):
        assert panel._quantity.itemData(number, Qt.ItemDataRole.ToolTipRole) == quantity.tip
        panel.choose(quantity.key)
        assert panel.quantity is quantity and panel.table.as_text().startswith(f"class\t{quantity.title}")


@pytest.fixture
def scores(qtbot: QtBot) -> ScoresPanel:
    made = ScoresPanel(MetricSettings())
    qtbot.addWidget(made)
    made.resize(1400, 230)
    made.show()
    return made


def show_counted(scores: ScoresPanel, now: TargetScores, before: TargetScores) -> None:
    scores.table.show_counted(totals_of(TRAFFIC, now, before, ON_TARGET), predicted_of(TRAFFIC, now, before))


def test_the_score_table_shows_predicted_detection_with_the_error_of_its_calibration(
    scores: ScoresPanel,
) -> None:
    now, before, row = counts(NOW), counts(BEFORE), CLASSES_AND_ALL.index("car")
    show_counted(scores, now, before)
    found = now.classes["car"].total.predicted
    assert found is not None and found.se == now.calibration.classes.car.error  # type: ignore[union-attr]
    assert scores.table.cell("car", "predicted").text == sampled_text(found.value, found.se)
    change = float(totals_of(TRAFFIC, now, before, PREDICTED).change[row])
    assert scores.table.cell("car", "predicted change").text == sampled_change_text(change, 0.0)


def test_the_domain_stands_with_the_share_found_and_goes_with_it(scores: ScoresPanel) -> None:
    now = counts(NOW)
    recall, found = now.settings.recall, now.classes["car"].total.found
    assert recall is not None and found is not None and scores.found == ""
    cells, predicted = totals_of(TRAFFIC, now, now, ON_TARGET), predicted_of(TRAFFIC, now, now)
    assert predicted.found is not None
    for outside in ("", "too many rays"):
        inside = replace(predicted, found=replace(predicted.found, outside=outside))
        scores.show_counted(cells, inside)
        for said in (scores.found, scores.table.cell("car", "predicted").tip):
            assert f"car {100 * found.value:.0f} ± {200 * found.se:.0f}" in said
            assert recall.domain.region in said and outside in said
        assert scores._found.isEnabled() == (not outside)
        assert scores._found.isVisible() and scores.minimumSizeHint().width() < 700
        QApplication.processEvents()
        assert scores._found.width() >= min(scores._found.sizeHint().width(), 300)
    assert predicted.region in scores.table.cell("car", "predicted").tip
    scores.show_counted(cells, predicted)
    scores.grey_counted()
    assert not scores._found.isEnabled()
    scores.show_counted(cells, replace(predicted, found=None))
    assert scores.found == "", "a calibration of AP alone"
    scores.show_counted(cells, predicted)
    scores.forget_counted("no boxes")
    assert scores.found == ""


def test_predicted_detection_is_grey_outside_its_domain_and_says_why(scores: ScoresPanel) -> None:
    table = scores.findChild(ScoreTable)
    assert table is not None
    now = counts(NOW)
    cells, predicted = totals_of(TRAFFIC, now, now, ON_TARGET), predicted_of(TRAFFIC, now, now)
    for outside, tone in (("", "text"), ("too many rays", "muted")):
        scores.table.show_counted(cells, replace(predicted, outside=outside))
        cell = table.cell("car", "predicted")
        assert cell.tone == tone and outside in cell.tip and now.calibration.detector in cell.tip


@pytest.mark.parametrize(
    ("change", "tone"), [(0.02, "more"), (-0.02, "less"), (0.009, "text"), (-0.009, "text")]
)
def test_a_difference_that_is_not_resolved_is_neither_better_nor_worse(
    scores: ScoresPanel, change: float, tone: str
) -> None:
    table, now = scores.findChild(ScoreTable), counts(NOW)
    assert table is not None
    cells, predicted = totals_of(TRAFFIC, now, now, ON_TARGET), predicted_of(TRAFFIC, now, now)
    moved = replace(cells, change=np.full(len(CLASSES_AND_ALL), change))
    same_way = replace(
        predicted,
        outside="",
        cells=replace(predicted.cells, change=np.full(len(CLASSES_AND_ALL), 2.0 * change)),
    )
    scores.table.show_counted(moved, same_way)
    for column in ("on_target change", "predicted change"):
        assert table.cell("car", column).tone == tone
    assert ("better" in table.cell("car", "on_target").tip) == (tone == "more")


def test_the_score_table_shows_on_target_with_error_and_change(scores: ScoresPanel) -> None:
    cells = totals_of(TRAFFIC, counts(NOW, 12), counts(BEFORE, 12), ON_TARGET)
    show_counted(scores, counts(NOW, 12), counts(BEFORE, 12))
    row = CLASSES_AND_ALL.index("car")
    assert scores.table.cell("car", "on_target").text == sampled_text(cells.value[row], cells.se[row])
    assert (
        "±" in scores.table.cell("car", "on_target").text
        and "±" in scores.table.cell("car", "on_target change").text
    )
    show_counted(scores, counts(NOW), counts(NOW))
    assert (
        "±" not in scores.table.cell("car", "on_target").text
        and scores.table.cell("car", "on_target change").text == "–"
    )


def test_totals_are_the_first_column_of_the_table() -> None:
    now, before = counts(NOW, 12), counts(BEFORE, 12)
    totals = totals_of(TRAFFIC, now, before, ON_TARGET)
    whole = table_of(TRAFFIC, now, before, ON_TARGET).cells
    assert np.array_equal(totals.value, whole.value[:, 0]) and np.array_equal(totals.se, whole.se[:, 0])
    assert np.array_equal(totals.change, whole.change[:, 0])


def test_three_figures_are_always_shown_and_s_mig_by_kind_on_request(scores: ScoresPanel) -> None:
    table = scores.findChild(ScoreTable)
    assert table is not None
    assert [table.place_of(key) for key in ("predicted", "on_target", "seen", "s_ms")] == [0, 2, 4, 6]
    for width, details in ((1400, False), (700, True), (700, False)):
        scores.resize(width, 230)
        scores.set_details(details)
        assert [table.isColumnHidden(place) for place in range(8)] == [False] * 8
        assert [table.isColumnHidden(place) for place in range(8, 12)] == [not details] * 4


def test_scores_and_road_users_are_greyed_apart(scores: ScoresPanel) -> None:
    show_counted(scores, counts(NOW), counts(BEFORE))
    table = scores.findChild(ScoreTable)
    assert table is not None
    place = table.place_of("on_target")
    table.grey()
    assert place not in table.figures._grey
    scores.table.grey_counted()
    assert place in table.figures._grey


def test_without_road_users_there_is_no_number_and_nothing_to_copy(scores: ScoresPanel) -> None:
    show_counted(scores, counts(NOW), counts(BEFORE))
    assert scores.table.as_text().splitlines()[1].split("\t")[1:4] != [""] * 3
    scores.table.forget_counted("no boxes")
    assert scores.table.cell("car", "on_target").text == "–"
    assert scores.table.as_text().splitlines()[1].split("\t")[1:4] == [""] * 3


@pytest.mark.parametrize("page", ["README.md", "docs/metric.md"])
def test_the_pages_say_the_same_of_the_four_figures_as_the_panel(page: str) -> None:
    found = " ".join((Path(__file__).parents[3] / page).read_text("utf-8").split())
    for name, said in SCORE_FIGURES:
        assert f"**{name}** {said}" in found
