"""Several rigs side by side in the window: scored exactly in the background, sorted, opened, restored, exported."""

import csv
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QComboBox, QPushButton, QScrollArea
from pytestqt.qtbot import QtBot

from riglens.app.window.features.compare import Compare
from riglens.app.window.settings import Settings
from riglens.core.figures.coverage import S_MS, SEEN
from riglens.core.figures.registry import figures, leading_figures
from riglens.core.figures.text import change_text, value_text
from riglens.core.rig.presets import PAPER_RIGS, preset
from riglens.core.rig.yaml.file import new_rig_file
from riglens.widgets.panels.compare.chart import CompareChart
from riglens.widgets.panels.compare.model import ALL_CLASSES, FIRST_FIGURE, CompareRow
from riglens.widgets.panels.compare.panel import ComparePanel
from tests.app.window.desk import full_desk, scores
from tests.app.window_bench import RIG, Bench, choose_item, open_bench
from tests.core.review.scenes import BOX_FILE, box_mesh
from tests.waiting import TIMEOUT_MS


@pytest.fixture
def bench(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(qtbot, tmp_path) as opened:
        yield opened


def compare(bench: Bench) -> Compare:
    return bench.features.compare


def wait_for_scores(bench: Bench) -> None:
    bench.settle()
    bench.qtbot.waitUntil(lambda: all(row.scores for row in compare(bench).rows), timeout=TIMEOUT_MS)


def choose(bench: Bench, name: str, text: str) -> None:
    combo = compare(bench).panel.findChild(QComboBox, name)
    assert combo is not None
    choose_item(combo, text)


def row_place(bench: Bench, name: str) -> QPoint:
    panel = compare(bench).panel
    table = panel.table
    return table.visualRect(
        table.model().index([row.name for row in panel.table.shown_rows()].index(name), 0)
    ).center()


def double_click(bench: Bench, name: str) -> None:
    table = compare(bench).panel.table
    place = row_place(bench, name)
    for press in (bench.qtbot.mouseClick, bench.qtbot.mouseDClick):
        press(table.viewport(), Qt.MouseButton.LeftButton, pos=place)


def test_every_rig_has_the_scores_of_a_fresh_evaluation(bench: Bench) -> None:
    compare(bench).add_presets(PAPER_RIGS[:2])
    bench.document.set_enabled(("front",), False)
    wait_for_scores(bench)
    for row in compare(bench).rows:
        assert row.scores == bench.fresh_scores(row.rig)
    name = PAPER_RIGS[0]
    fresh = bench.fresh_scores(preset(name)).classes["car"]
    assert compare(bench).panel.table.text_of(name, "car S-MS") == value_text(S_MS, fresh.s_ms)


def test_the_rig_being_edited_is_the_first_row_and_follows_the_edits(bench: Bench) -> None:
    bench.document.set_enabled(("roof",), False)
    bench.settle()
    first = compare(bench).rows[0]
    assert (first.origin, first.rig) == ("current", bench.document.rig)
    choose(bench, "compare_class", "car")
    assert compare(bench).panel.table.text_of("small", "LiDARs S-MIG") == "0.00"


def test_names_get_the_room_that_they_need_until_somebody_gives_them_another(bench: Bench) -> None:
    table = compare(bench).panel.table
    header = table.horizontalHeader()
    bench.document.apply(RIG.replace(name="a car with a rather long name"), "rename")
    bench.settle()
    assert table.sizeHintForColumn(0) > 132
    assert header.sectionSize(0) == min(table.sizeHintForColumn(0), 240)
    header.resizeSection(0, 150)
    bench.document.apply(RIG.replace(name="a car with a much longer name than that"), "rename")
    bench.settle()
    assert header.sectionSize(0) == 150


def test_a_snapshot_is_restored_by_a_double_click_as_one_step(bench: Bench) -> None:
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_T, Qt.KeyboardModifier.ControlModifier)
    bench.document.delete(("roof",))
    wait_for_scores(bench)
    double_click(bench, "small #1")
    assert bench.document.rig == RIG
    assert bench.document.undo_label == "restore small #1"
    bench.act("undo")
    assert [sensor.name for sensor in bench.document.rig.sensors] == ["front"]


def test_a_snapshot_of_what_is_scored_already_costs_no_evaluation(bench: Bench) -> None:
    bench.act("snapshot")
    bench.act("snapshot")
    assert [row.name for row in compare(bench).rows] == ["small", "small #1", "small #2"]
    assert all(row.scores == bench.fresh_scores(RIG) for row in compare(bench).rows)


def test_a_rig_is_scored_again_once_the_mesh_of_its_car_has_been_read(qtbot: QtBot) -> None:
    with full_desk(qtbot) as desk:
        desk.load()
        desk.answer()
        rigs = desk.features.compare._rigs
        rigs.add("on a box", "snapshot", RIG.replace(vehicle=BOX_FILE))
        (asked,) = [one for one in desk.recompute.others if one.group == "compare"]
        assert asked.rig.vehicle.lacks_mesh
        desk.session.take_mesh(BOX_FILE.body, mesh := box_mesh())
        desk.answer()
        (*_, asked) = [one for one in desk.recompute.others if one.group == "compare"]
        assert asked.rig.vehicle.body_mesh is mesh
        desk.recompute.answered_in_background.emit(asked, scores(0.25))
        qtbot.waitUntil(lambda: rigs[asked.name].scores == scores(0.25), timeout=TIMEOUT_MS)


def test_a_preset_and_a_file_are_opened_from_the_table(bench: Bench, tmp_path: Path) -> None:
    path = tmp_path / "mast.yaml"
    new_rig_file(RIG.replace(name="mast")).save(path)
    bench.dialogs.path = path
    bench.act("compare_file")
    compare(bench).add_presets(("W+T",))
    wait_for_scores(bench)
    double_click(bench, "W+T")
    assert bench.document.rig == preset("W+T")
    double_click(bench, "mast.yaml")
    assert (bench.document.path, bench.document.rig.name) == (path, "mast")


def test_a_file_that_is_no_rig_is_reported_and_not_listed(bench: Bench, tmp_path: Path) -> None:
    bench.dialogs.path = tmp_path / "bad.yaml"
    bench.dialogs.path.write_text("riglens: 1\nsensors: 7\n", encoding="utf-8")
    bench.act("compare_file")
    assert "bad.yaml" in bench.workbench.errors.message
    assert len(compare(bench).rows) == 1


def test_differences_count_from_the_first_rig_or_from_the_baseline(bench: Bench) -> None:
    empty = RIG.replace(sensors=(), name="bare")
    bench.session.pin(empty)
    compare(bench).add_presets(("W+T",))
    wait_for_scores(bench)
    here, other, bare = (bench.fresh_scores(rig).classes["car"] for rig in (RIG, preset("W+T"), empty))
    panel = compare(bench).panel
    choose(bench, "compare_shown", "difference to the first")
    assert panel.table.text_of("W+T", "car S-MS") == change_text(S_MS, other.s_ms - here.s_ms)
    assert panel.table.text_of("small", "car S-MS") == "—"
    choose(bench, "compare_shown", "difference to the baseline")
    assert panel.table.text_of("W+T", "car S-MS") == change_text(S_MS, other.s_ms - bare.s_ms)


@pytest.mark.parametrize("class_name", [ALL_CLASSES, "pedestrian"])
def test_rigs_are_sorted_by_the_column_that_is_clicked(bench: Bench, class_name: str) -> None:
    compare(bench).add_presets(("W+T", "N+C", "Center"))
    wait_for_scores(bench)
    choose(bench, "compare_class", class_name)
    panel = compare(bench).panel
    header = panel.table.horizontalHeader()
    figure = S_MS if class_name == ALL_CLASSES else SEEN
    section = FIRST_FIGURE + [column.figure for column in panel.model.columns].index(figure)
    panel.table.scrollTo(panel.table.model().index(0, section))
    place = QPoint(header.sectionViewportPosition(section) + 20, header.height() // 2)
    bench.qtbot.mouseClick(header.viewport(), Qt.MouseButton.LeftButton, pos=place)
    scored = "car" if class_name == ALL_CLASSES else class_name
    rows = sorted(compare(bench).rows, key=lambda row: figure.of_scores(row.scores, scored).value)  # type: ignore[arg-type]
    assert [row.name for row in panel.table.shown_rows()] == [row.name for row in rows]


def test_other_settings_void_the_scores_and_compute_them_again(bench: Bench) -> None:
    compare(bench).add_presets(("W+T",))
    wait_for_scores(bench)
    reading = bench.panels.scores.findChild(QComboBox, "reading")
    assert reading is not None
    choose_item(reading, "residual")
    bench.settle()
    wait_for_scores(bench)
    for row in compare(bench).rows:
        assert row.scores == bench.fresh_scores(row.rig)


def test_scoring_is_cancelled_and_taken_up_again(bench: Bench) -> None:
    bench.clock.stand_still()
    compare(bench).add_presets(PAPER_RIGS)
    button = compare(bench).panel.findChild(QPushButton, "compare_cancel")
    assert button is not None
    assert button.isVisible()
    button.click()
    bench.clock.leap()
    assert button.text() == "Score"
    assert any(row.scores is None for row in compare(bench).rows)
    button.click()
    wait_for_scores(bench)
    assert not button.isVisible()


def test_rigs_are_removed_by_key_but_never_the_one_being_edited(bench: Bench) -> None:
    compare(bench).add_presets(("W+T", "N+C"))
    table = compare(bench).panel.table
    table.setFocus()
    bench.qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=row_place(bench, "W+T"))
    bench.qtbot.keyClick(table, Qt.Key.Key_Delete)
    assert [row.name for row in compare(bench).panel.table.shown_rows()] == ["small", "N+C"]
    bench.qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=row_place(bench, "small"))
    bench.qtbot.keyClick(table, Qt.Key.Key_Delete)
    assert [row.name for row in compare(bench).panel.table.shown_rows()] == ["small", "N+C"]
    assert bench.document.rig == RIG


def test_the_table_is_saved_and_copied_with_every_digit(bench: Bench, tmp_path: Path) -> None:
    compare(bench).add_presets(("W+T",))
    wait_for_scores(bench)
    bench.dialogs.path = tmp_path / "rigs.csv"
    export = compare(bench).panel.findChild(QPushButton, "compare_export")
    assert export is not None
    export.click()
    with bench.dialogs.path.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["rig"] for row in rows] == ["small", "W+T"]
    fresh = bench.fresh_scores(preset("W+T")).classes["pedestrian"]
    assert float(rows[1]["pedestrian S-MS (nat)"]) == fresh.s_ms
    compare(bench).panel.copy()
    assert QGuiApplication.clipboard().text().splitlines()[0].startswith("rig\torigin\t")


def test_a_snapshot_gets_another_name(bench: Bench) -> None:
    bench.act("snapshot")
    key = compare(bench).rows[1].key
    model = compare(bench).panel.model
    assert not model.flags(model.index(0, 0)) & Qt.ItemFlag.ItemIsEditable
    assert model.setData(model.index(1, 0), "before the mirror")
    assert compare(bench).rows[1].name == "before the mirror"
    compare(bench).panel.table.pin_wanted.emit(key)
    assert bench.session.baseline == RIG


# ---------------------------------------------------------------------- bars
def show_bars(bench: Bench) -> CompareChart:
    """Toggle the bars by their button, and wait until they are drawn."""
    panel = compare(bench).panel
    bench.qtbot.mouseClick(panel.bars, Qt.MouseButton.LeftButton)
    bench.qtbot.waitUntil(panel.chart.isVisible, timeout=TIMEOUT_MS)
    return panel.chart


def test_bars_are_as_long_as_the_figures_of_the_table(bench: Bench) -> None:
    compare(bench).add_presets(("W+T", "N+C"))
    wait_for_scores(bench)
    charts = show_bars(bench).charts()
    assert [chart.shown.figure.key for chart in charts] == 3 * [one.key for one in leading_figures()]
    for chart in charts:
        assert bool(chart.bars) == (chart.shown.figure.needs == "voxels")  # nobody counts here
    charts = [chart for chart in charts if chart.bars]
    assert [chart.shown.title for chart in charts][:2] == ["car S-MS", "bicycle S-MS"]
    assert all([bar.row.name for bar in chart.bars] == ["small", "W+T", "N+C"] for chart in charts)
    for bar in charts[0].bars:
        assert bar.row.scores is not None
        assert bar.value.value == bar.row.scores.classes["car"].s_ms <= 0.0
        assert bar.area.top() == charts[0].zero_px  # what is below zero hangs down
    lengths = [bar.area.height() / bar.value.value for bar in charts[0].bars]
    assert lengths == pytest.approx([lengths[0]] * 3, rel=0.05)


def test_bars_follow_the_order_the_class_and_the_differences_of_the_table(bench: Bench) -> None:
    compare(bench).add_presets(("W+T",))
    wait_for_scores(bench)
    chart = show_bars(bench)
    choose(bench, "compare_class", "pedestrian")
    choose(bench, "compare_shown", "difference to the first")
    panel = compare(bench).panel
    panel.table.sortByColumn(0, Qt.SortOrder.AscendingOrder)
    charts = {found.shown.figure.key: found for found in chart.charts()}
    assert list(charts) == [one.key for one in figures(("lidar", "camera")) if one.per_class]
    bars = charts["s_ms"].bars
    assert (
        [bar.row.name for bar in bars] == [row.name for row in panel.table.shown_rows()] == ["W+T", "small"]
    )
    here, other = (bench.fresh_scores(rig).classes["pedestrian"].s_ms for rig in (RIG, preset("W+T")))
    assert [bar.value.value for bar in bars] == [other - here, 0.0]


def test_ctrl_a_in_the_table_selects_rigs_and_no_sensors(bench: Bench) -> None:
    compare(bench).add_presets(("W+T", "N+C"))
    wait_for_scores(bench)
    bench.document.select("roof")
    table = compare(bench).panel.table
    bench.workbench.docks["Compare"].raise_()
    table.setFocus()
    bench.qtbot.keyClick(table, Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    assert len(table.chosen) == len(compare(bench).rows) == 3
    assert bench.document.selection == ("roof",)


def test_a_click_on_a_bar_selects_its_rig_and_a_double_click_opens_it(bench: Bench) -> None:
    compare(bench).add_presets(("W+T",))
    wait_for_scores(bench)
    chart = show_bars(bench)
    seen = next(one for one in chart.charts() if one.shown.figure is S_MS)
    place = seen.bars[1].area.center().toPoint()
    bench.qtbot.mouseClick(chart, Qt.MouseButton.LeftButton, pos=place)
    assert compare(bench).panel.table.chosen == (compare(bench).rows[1].key,)
    bench.qtbot.mouseDClick(chart, Qt.MouseButton.LeftButton, pos=place)
    assert bench.document.rig == preset("W+T")


def test_table_and_bars_share_a_large_panel_and_take_turns_in_a_small_one(bench: Bench) -> None:
    panel = compare(bench).panel
    compare(bench).add_presets(("W+T",))
    chart = show_bars(bench)
    assert not panel.table.isVisible()
    area = compare(bench).dock.widget()
    assert isinstance(area, QScrollArea) and area.takeWidget() is panel
    panel.show()
    for size, orientation in (
        ((1600, 200), Qt.Orientation.Horizontal),
        ((900, 600), Qt.Orientation.Vertical),
    ):
        panel.resize(*size)
        bench.qtbot.waitUntil(panel.table.isVisible, timeout=TIMEOUT_MS)
        assert chart.isVisible() and panel._halves.orientation() == orientation


@pytest.mark.parametrize("height_px", [150, 178])
def test_no_text_of_the_table_is_cut(qtbot: QtBot, height_px: int) -> None:
    panel = ComparePanel()
    qtbot.addWidget(panel)
    panel.model.set_rows([CompareRow(str(n), f"rig {n}", "snapshot", RIG) for n in range(30)])
    panel.resize(900, height_px)
    with qtbot.waitExposed(panel, timeout=TIMEOUT_MS):
        panel.show()
    table, high = panel.table, panel.table.viewport().height()
    last = table.rowAt(high - 1)
    top = table.rowViewportPosition(last)
    is_whole = top + table.rowHeight(last) <= high
    assert last > 0 and (is_whole or high - top < 6)  # or so little of it that no text is


def test_bars_are_there_again_the_next_time(qtbot: QtBot, tmp_path: Path) -> None:
    kept = Settings(tmp_path / "window.ini")
    with open_bench(qtbot, tmp_path, kept=kept, wait=False) as opened:
        compare(opened).panel.set_bars(True)
    with open_bench(qtbot, tmp_path, kept=kept, wait=False) as opened:
        assert compare(opened).panel.bars.isChecked()
