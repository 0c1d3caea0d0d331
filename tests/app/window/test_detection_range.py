"""The detection range follows the rig while its page is visible: grey until current, stopped and computed on demand."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QPointF
from PySide6.QtWidgets import QApplication, QDoubleSpinBox, QPushButton, QSpinBox
from pytestqt.qtbot import QtBot

from riglens.app.background.rig_questions import RigRequest, detection_range
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.features.detection_range import DetectionRangeShown, RangeRequest
from riglens.app.window.settings import Settings
from riglens.core.geometry import Pose
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.targets.detection_range import (
    USUAL_PLAN,
    DetectionRange,
    RangePlan,
    RangeRow,
    Reach,
    around,
)
from riglens.core.targets.detection_range_making import detection_range_of
from riglens.studies.detection_range_chart import range_figure
from riglens.widgets.panels.detection_range.chart import RangeChart, edge_m, ring_step_m
from riglens.widgets.panels.detection_range.table import STOPS, Line, RangeTable, tip_of
from tests.app.window.desk import Desk, FakeWorker
from tests.app.window_bench import RIG
from tests.waiting import TIMEOUT_MS

NEAR = RangePlan(bearings_deg=around(4), to_m=12.0)
RANGES = detection_range_of(RIG, NEAR, threads=1)
BLOCKS = USUAL_PLAN.with_body("blocks")
"""What the window asks for unless told otherwise: the car is solid."""


@pytest.fixture
def maker() -> FakeWorker:
    return FakeWorker()


@pytest.fixture
def desk(followed: Desk) -> Desk:
    return followed


@pytest.fixture
def shown(desk: Desk, maker: FakeWorker, qtbot: QtBot) -> DetectionRangeShown:
    """The feature with its dock in sight, before the first scores."""
    feature = DetectionRangeShown(desk.workbench, maker)
    desk.open_page("detection_range", feature)
    return feature


def answer(request: RangeRequest, feature: DetectionRangeShown) -> None:
    feature._take(request, replace(RANGES, rig=request.rig))


def button(feature: DetectionRangeShown) -> QPushButton:
    found = feature.panel.findChild(QPushButton, "card_button")
    assert found is not None
    return found


def is_grey(feature: DetectionRangeShown) -> bool:
    return 0 in feature.panel.table.figures._grey


def test_a_detection_range_is_made_after_the_first_scores_and_only_while_somebody_looks(
    desk: Desk, maker: FakeWorker, qtbot: QtBot
) -> None:
    feature = DetectionRangeShown(desk.workbench, maker)
    desk.answer()
    assert maker.requests == []
    desk.workbench.window.show()
    desk.act("detection_range")
    qtbot.waitUntil(lambda: len(maker.requests) == 1, timeout=TIMEOUT_MS)
    assert maker.requests[0] == RigRequest(desk.document.rig, BLOCKS) and not feature.is_current


def test_scores_come_first(desk: Desk, maker: FakeWorker, shown: DetectionRangeShown) -> None:
    assert maker.requests == [] and "after the first scores" in shown.panel.note
    desk.answer()
    assert len(maker.requests) == 1
    desk.answer(0.7)
    assert len(maker.requests) == 1


def test_the_detection_range_says_of_which_rig_it_is(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    assert "computing" in shown.panel.note and not shown.panel.export.isEnabled()
    assert shown.panel.table.isHidden()  # an empty one would look like a hole
    answer(maker.requests[-1], shown)
    assert shown.is_current and shown.panel.note.startswith("small, current")
    assert not shown.panel.table.isHidden()
    assert not is_grey(shown) and shown.panel.export.isEnabled() and button(shown).isHidden()
    desk.viewport.press("roof")
    desk.viewport.drag_to("roof", Pose((0.3, 0.0, 2.0)))
    assert len(maker.requests) == 1  # while the mouse moves none is made
    assert shown.panel.note == "Out of date: small before the last change (while a sensor moves)"
    assert is_grey(shown) and not shown.panel.export.isEnabled()
    desk.viewport.release("roof")
    assert maker.requests[-1].rig == desk.document.rig and "computing" in shown.panel.note
    answer(maker.requests[-1], shown)
    assert shown.is_current and not is_grey(shown)


def test_undo_brings_the_detection_range_back_without_making_it(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    answer(maker.requests[-1], shown)
    desk.drag("roof", (0.3, 0.0, 2.0))
    desk.document.undo()
    assert maker.dropped == [maker.requests[-1]] and len(maker.requests) == 2
    assert shown.is_current and not is_grey(shown) and shown.panel.note.startswith("small, current")


def test_an_answer_to_an_earlier_rig_is_shown_as_out_of_date(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    first = maker.requests[-1]
    desk.drag("roof", (0.3, 0.0, 2.0))
    answer(first, shown)
    assert not shown.is_current and is_grey(shown) and shown.panel.note.startswith("Out of date")
    assert button(shown).text() == "Stop"  # the one of the rig as it is now is still on its way


def test_the_detection_range_is_of_what_works(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    answer(maker.requests[-1], shown)
    desk.document.set_failed(("roof",), True)
    assert maker.requests[-1].rig.enabled_lidars() == () and is_grey(shown)
    answer(maker.requests[-1], shown)
    assert shown.panel.note.startswith("small, current, without failed sensors")


def test_the_detection_range_is_of_a_solid_car_whatever_the_scores_are_of(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    desk.session.set_body("ignored")
    answer(maker.requests[-1], shown)
    assert maker.requests[-1].options == USUAL_PLAN and USUAL_PLAN.settings.body == "blocks"
    assert shown.is_current and "body blocks" in shown.panel.note


def test_progress_is_shown_and_work_can_be_stopped_and_asked_for_again(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    maker.progressed.emit(maker.requests[-1], 0.4)
    QApplication.processEvents()
    bar = shown.panel._bar
    assert (bar.isHidden(), bar.value(), button(shown).text()) == (False, 40, "Stop")
    button(shown).click()
    assert maker.dropped == maker.requests and bar.isHidden()
    assert (shown.panel.note, button(shown).text()) == ("No results yet (stopped)", "Update")
    desk.answer(0.7)
    assert len(maker.requests) == 1
    button(shown).click()
    assert len(maker.requests) == 2 and button(shown).text() == "Stop"
    button(shown).click()
    desk.drag("roof", (0.3, 0.0, 2.0))
    assert len(maker.requests) == 3  # another rig has other ranges


def test_a_detection_range_that_cannot_be_made_says_why(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    maker.failed.emit("no room")
    QApplication.processEvents()
    assert shown.panel.note == "No results yet (no room)" and button(shown).text() == "Update"


def test_what_is_enough_makes_another_detection_range_and_braking_does_not(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    desk.answer()
    answer(maker.requests[-1], shown)
    brake = shown.panel.findChild(QDoubleSpinBox, "card_brake")
    points = shown.panel.findChild(QSpinBox, "card_points")
    assert brake is not None and points is not None
    before = shown.panel.table.text_of("Car end on, LiDARs", STOPS)
    brake.setValue(9.0)
    assert len(maker.requests) == 1 and shown.is_current and not is_grey(shown)
    after = shown.panel.table.text_of("Car end on, LiDARs", STOPS)
    assert int(after.split()[0]) > int(before.split()[0])
    assert f"stops in {RangePlan(deceleration_mps2=9.0).stopping_m(30.0):.0f}, " in shown.panel._ways.text()
    points.setValue(9)
    assert maker.requests[-1].options == replace(BLOCKS, min_points=9) and is_grey(shown)


def test_the_plan_is_kept_and_nonsense_is_not_taken_up(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown
) -> None:
    kept = Settings()
    shown._choose(RangePlan(min_points=7, deceleration_mps2=6.5))
    shown.keep(kept)
    shown._choose(USUAL_PLAN)
    shown.restore(kept)
    assert shown._plan == RangePlan(min_points=7, deceleration_mps2=6.5)
    for nonsense in (
        {"min_points": -3},
        {"to_m": "far"},
        {"reaction_s": float("nan")},
        {"min_points": True},
        {"x": 1},
    ):
        kept.write("detection_range/plan", nonsense)
        shown.restore(kept)
        assert shown._plan in (RangePlan(min_points=7, deceleration_mps2=6.5), USUAL_PLAN)


def test_what_is_shown_is_exported(
    desk: Desk, maker: FakeWorker, shown: DetectionRangeShown, tmp_path: Path
) -> None:
    desk.answer()
    answer(maker.requests[-1], shown)
    desk.dialogs.path = tmp_path / "range.csv"
    shown.panel.export.click()
    with open(desk.dialogs.path, encoding="utf-8", newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert desk.dialogs.suggested == Path("range.csv") and len(lines) == 2 * len(RANGES.rows)
    row = next(
        row for row in RANGES.rows if (row.cls, row.heading_deg, row.bearing_deg) == ("car", 90.0, 0.0)
    )
    found = next(
        line
        for line in lines
        if (line["class"], line["heading_deg"], line["bearing_deg"]) == ("car", "90.0", "0.0")
    )
    assert float(found["first_below_min_m"] or "inf") == row.lidar.least_m


# ---------------------------------------------------------------------- panel
def test_the_table_says_what_the_terminal_does(qtbot: QtBot) -> None:
    table = RangeTable()
    qtbot.addWidget(table)
    table.show_range(RANGES)
    row = next(
        row for row in RANGES.rows if (row.cls, row.heading_deg, row.bearing_deg) == ("pedestrian", 0.0, 90.0)
    )
    text = table.text_of("Pedestrian, LiDARs", "left")
    assert text.split("/")[0] == f"{row.lidar.least_m:.0f}"
    assert table.text_of("Pedestrian, cameras", "behind") == "never"
    assert (table.figures.rowCount(), table.figures.columnCount()) == (10, len(NEAR.bearings_deg) + 1)
    assert table.line == Line("car", 0.0, LIDAR)
    table.selectRow(9)
    assert table.line == Line("pedestrian", 0.0, CAMERA)
    nowhere = replace(row, reaches={"camera": Reach(0.0, 0.0, 0.0, 0.0), "lidar": Reach(1.0, 1.0, 1.0, 0.5)})
    tips = [tip_of(RANGES, Line("pedestrian", 0.0, kind), nowhere) for kind in (CAMERA, LIDAR)]
    assert ["never" in tip for tip in tips] == [True, False]


def test_no_distance_is_cut_off_however_narrow_the_table(qtbot: QtBot) -> None:
    """Out of sight behind a scroll bar, yes; 70/102/1…, never."""
    table = RangeTable()
    qtbot.addWidget(table)
    table.resize(500, 200)
    far = Reach(102.0, 104.0, 106.0, 5.0)
    rows = tuple(replace(row, reaches={**row.reaches, "lidar": far}) for row in RANGES.rows)
    table.show_range(replace(RANGES, rows=rows, plan=replace(NEAR, to_m=150.0)))
    table.show()
    assert table.text_of("Car end on, LiDARs", "left") == "102/104/106"
    for column in range(table.figures.columnCount()):
        text = table.figures.cell(0, column).text
        assert table.fontMetrics().horizontalAdvance(text) + 6 <= table.columnWidth(column)


def test_the_chart_has_the_distances_where_they_are(qtbot: QtBot) -> None:
    chart = RangeChart()
    qtbot.addWidget(chart)
    chart.resize(250, 250)
    chart.show_line(RANGES, Line("car", 0.0, LIDAR))
    ahead, left = chart._at(0.0, 12.0) - chart._centre(), chart._at(90.0, 6.0) - chart._centre()
    assert ahead.x() == 0.0 and ahead.y() < 0.0 and left.x() == pytest.approx(ahead.y() / 2.0)
    assert chart._at(180.0, float("inf")) == chart._centre() + QPointF(
        chart._at(180.0, 12.0) - chart._centre()
    )
    assert [ring_step_m(to_m) for to_m in (12.0, 50.0, 51.0, 150.0, 1000.0)] == [
        10.0,
        10.0,
        20.0,
        50.0,
        200.0,
    ]
    reaches = {"lidar": Reach(10.0, 20.0, 50.0, 5.0), "camera": Reach(0.0, 0.0, 0.0, 0.0)}
    row = RangeRow("car", 0.0, 0.0, reaches, -4.6)
    assert edge_m(RANGES) == 12.0 and edge_m(DetectionRange(RIG, USUAL_PLAN, (row,), 1.0)) == pytest.approx(
        54.0
    )
    assert not chart.grab().isNull()


def test_the_chart_to_save_names_its_rig() -> None:
    assert RIG.name and RIG.name in range_figure(RANGES).get_suptitle()


# ---------------------------------------------------------------------- the thread
def test_the_thread_makes_the_detection_range_of_the_command(qtbot: QtBot) -> None:
    maker = BackgroundWorker("detection range", detection_range)
    told: list[float] = []
    maker.progressed.connect(lambda _, share: told.append(share))
    with qtbot.waitSignal(maker.answered, timeout=TIMEOUT_MS) as caught:
        maker.ask(RigRequest(RIG, NEAR))
    assert caught.args[1].rows == RANGES.rows
    qtbot.waitUntil(lambda: bool(told) and told[-1] == 1.0, timeout=TIMEOUT_MS)
    maker.close()
