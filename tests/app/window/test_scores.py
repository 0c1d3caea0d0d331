"""Scores in the window follow a drag, end exact to the last bit, and show the change since the last save."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QPushButton

from riglens.app.background.recompute import CANCELLED
from riglens.core.figures.figure import ALL
from riglens.core.figures.predicted import PREDICTED
from riglens.core.figures.text import estimate_text
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.evaluation.options import SceneOptions
from tests.app.window.counts import count
from tests.app.window.desk import FullDesk, heatmap
from tests.app.window_bench import RIG, Bench, choose_item, scene_options, type_into
from tests.waiting import TIMEOUT_MS


@pytest.fixture
def bench(whole: Bench) -> Bench:
    return whole


def test_the_scores_follow_the_drag_while_the_mouse_is_down(bench: Bench) -> None:
    seen: list[str] = []
    bench.workbench.recompute.evaluated.connect(
        lambda _: seen.append(bench.panels.scores.table.as_text()), Qt.ConnectionType.QueuedConnection
    )
    bench.viewport.press("roof")
    for step in range(1, 4):
        bench.viewport.drag_to("roof", Pose((step * 1.5, 0.2, 1.0)))
        bench.settle()
    assert bench.document.is_dragging
    assert len(set(seen)) == 3
    bench.viewport.release("roof")


def test_after_a_drag_the_scores_are_those_of_a_fresh_evaluation_bit_for_bit(bench: Bench) -> None:
    bench.drag("roof", (3.0, 0.0, 1.0), (-4.0, 1.0, 2.0), (1 / 3, 0.1 + 0.2, 1.7))
    bench.drag("front", (2.0, 0.4, 1.2), (1.1, -0.3, 1.3))
    bench.act("undo")
    bench.act("redo")
    bench.settle()
    assert bench.exact_numbers() == bench.fresh_numbers()


def test_a_number_that_is_out_of_date_is_greyed_until_the_new_one_is_there(bench: Bench) -> None:
    assert not bench.panels.scores.is_stale
    before = bench.shown("car", "s_ms")
    bench.document.set_enabled(("roof",), False)
    assert bench.panels.scores.is_stale
    assert bench.shown("car", "s_ms") == before
    assert bench.workbench.status.state.text() == "updating…"
    bench.settle()
    assert not bench.panels.scores.is_stale
    assert bench.workbench.status.state.text() == "exact"


def test_the_change_counts_from_the_rig_that_was_opened_and_then_from_the_saved_one(
    bench: Bench, tmp_path: Path
) -> None:
    assert bench.shown("car", "s_ms change") == "—"
    bench.document.set_enabled(("roof",), False)
    bench.settle()
    assert bench.shown("car", "s_ms change").startswith("+")
    assert bench.shown("car", "seen change").startswith("−")
    bench.dialogs.path = tmp_path / "rig.yaml"
    bench.act("save")
    bench.settle()
    assert bench.shown("car", "s_ms change") == "—"
    bench.act("undo")
    bench.settle()
    assert bench.shown("car", "s_ms change").startswith("−")
    assert bench.exact_numbers() == bench.fresh_numbers()


def test_changes_are_recounted_when_lambda_or_reading_change(bench: Bench) -> None:
    bench.drag("front", (2.0, 0.4, 1.2))
    bench.settle()
    weight = bench.panels.scores.findChild(QLineEdit, "camera_weight")
    reading = bench.panels.scores.findChild(QComboBox, "reading")
    assert weight is not None
    assert reading is not None
    type_into(bench.qtbot, weight, "0.75")
    choose_item(reading, "residual")
    bench.settle()
    assert bench.session.settings == MetricSettings("exact", "residual", 0.75, body=None)
    assert bench.exact_numbers() == bench.fresh_numbers()


def test_a_lambda_that_is_no_weight_is_refused(bench: Bench) -> None:
    for text in ["-1", "nan", "many"]:
        weight = bench.panels.scores.findChild(QLineEdit, "camera_weight")
        assert weight is not None
        type_into(bench.qtbot, weight, text)
        assert weight.property("invalid")
        assert bench.session.settings.camera_weight == 0.1
        type_into(bench.qtbot, weight, "0.1")
        assert not weight.property("invalid")


def test_the_heatmap_follows_mode_class_and_rig(bench: Bench) -> None:
    assert bench.viewport.state.heatmap.title == "Unseen traffic, car", "an edit changes it"
    bench.features.heat.set_mode("seen")
    bench.features.heat.set_class("bicycle")
    bench.settle()
    before = bench.viewport.state.heatmap
    assert before.title == "Seen traffic, bicycle"
    bench.document.apply(RIG.replace(sensors=()))
    bench.settle()
    after = bench.viewport.state.heatmap
    assert after.centres_m is before.centres_m
    assert before.values.sum() > 0
    assert after.values.sum() == 0
    bench.features.heat.set_mode("off")
    bench.settle()
    assert bench.viewport.state.heatmap is None


def test_the_status_bar_says_what_the_scores_are_computed_on(bench: Bench) -> None:
    status = bench.workbench.status
    text = status.scene.toolTip()
    for part in ("δ 0.5 m", "informative voxels", "boxes.csv", "T = 3 frames"):
        assert part in text
    assert "boxes.csv" in status.scene.text() and " ms, " in status.state.toolTip()


def load_button(bench: Bench) -> QPushButton:
    button = bench.panels.scene.findChild(QPushButton, "load")
    assert button is not None
    return button


def test_another_voxel_edge_is_loaded_and_scored(bench: Bench) -> None:
    panel = bench.panels.scene
    voxel = panel.findChild(QComboBox, "voxel_m")
    assert voxel is not None
    line = voxel.lineEdit()
    assert line is not None
    assert not load_button(bench).isEnabled()
    type_into(bench.qtbot, line, "0.25")
    load_button(bench).click()
    bench.qtbot.waitUntil(lambda: len(bench.scenes) == 2, timeout=TIMEOUT_MS)
    bench.settle()
    assert bench.scenes[1].field.grid.voxel_m == 0.25
    assert bench.exact_numbers() == bench.fresh_numbers()
    assert "δ 0.25 m" in bench.workbench.status.scene.toolTip()


def test_a_voxel_edge_that_does_not_divide_the_region_is_refused(bench: Bench) -> None:
    voxel = bench.panels.scene.findChild(QComboBox, "voxel_m")
    assert voxel is not None
    line = voxel.lineEdit()
    assert line is not None
    type_into(bench.qtbot, line, "0.3")
    assert "Voxel: L must be a multiple" in bench.panels.scene.problem
    assert bench.panels.scene.choice.voxel_m == 0.5


def test_boxes_that_cannot_be_read_are_reported_and_the_old_ones_stay(bench: Bench, tmp_path: Path) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("seq,frame,cls,x,y\ns,0,car,1,2\n", encoding="utf-8")
    before = bench.panels.scores.table.as_text()
    bench.dialogs.path = bad
    bench.act("boxes_file")
    load_button(bench).click()
    bench.qtbot.waitUntil(lambda: "bad.csv" in bench.workbench.errors.message, timeout=TIMEOUT_MS)
    bench.settle()
    assert bench.panels.scores.table.as_text() == before
    assert "boxes.csv" in bench.workbench.status.scene.text()


def endless_load(_: SceneOptions, progress: Callable[[float], None]) -> NoReturn:
    """A load that only Cancel ends, however slow the machine is."""
    while True:
        progress(0.0)
        time.sleep(0.002)


def test_cancel_ends_a_load_and_keeps_the_old_boxes(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench.workbench.recompute, "_loader", endless_load)
    bench.features.scene_data.load(scene_options(tmp_path, voxel_m=0.25))
    cancel = bench.workbench.status.findChild(QPushButton, "cancel_load")
    assert cancel is not None
    cancel.click()
    bench.qtbot.waitUntil(lambda: not bench.features.scene_data.is_loading, timeout=TIMEOUT_MS)
    bench.settle()
    assert bench.workbench.errors.message == CANCELLED
    assert "δ 0.5 m" in bench.workbench.status.scene.toolTip()


def test_scores_of_the_boxes_before_are_not_called_exact(bench: Bench, tmp_path: Path) -> None:
    """The load is over, its answer is on its way: the numbers shown are still of the old boxes."""
    called_exact: list[bool] = []
    bench.workbench.recompute.load_ended.connect(
        lambda *_: called_exact.append(bench.window.is_exact), Qt.ConnectionType.QueuedConnection
    )
    bench.features.scene_data.load(scene_options(tmp_path, voxel_m=1.0))
    bench.qtbot.waitUntil(lambda: bool(called_exact), timeout=TIMEOUT_MS)
    assert called_exact == [False]
    bench.settle()
    assert "δ 1 m" in bench.workbench.status.scene.toolTip()


def test_the_end_of_a_load_that_nobody_wants_any_more_ends_nothing(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench.workbench.recompute, "_loader", endless_load)
    before, data = scene_options(tmp_path, voxel_m=0.25), bench.features.scene_data
    data.load(scene_options(tmp_path, voxel_m=1.0))
    bench.workbench.recompute.load_ended.emit("boxes.csv: broken", before)
    QApplication.processEvents()
    assert data.is_loading and not bench.window.is_exact
    assert bench.workbench.errors.isHidden()
    bench.workbench.recompute.cancel_load()
    bench.qtbot.waitUntil(lambda: not data.is_loading, timeout=TIMEOUT_MS)


def test_another_rig_opens_without_figures_of_the_one_before(desk: FullDesk) -> None:
    desk.load()
    late = desk.answer(0.7, heatmap=heatmap("unseen"))
    count(desk)
    table, targets = desk.panels.scores.table, desk.features.targets
    found = targets.answer.figures["predicted"][ALL]  # type: ignore[union-attr]
    in_status = desk.workbench.status.figure
    assert estimate_text(PREDICTED, found) in in_status.text()
    values = [(table.cell("car", key), desk.viewport.state.heatmap) for key in ("s_ms", "missed")]
    assert all(cell.values[0] is not None and drawn is not None for cell, drawn in values)
    desk.features.files.open_preset("W+T")
    assert [table.cell("car", key).values for key in ("s_ms", "missed")] == [(None,), ()]
    assert desk.viewport.state.heatmap is None and targets.answer is None and in_status.text() == ""
    desk.workbench.answers.take(late)  # computed for the rig before
    assert table.cell("car", "s_ms").values == (None,) and desk.viewport.state.heatmap is None
    desk.answer(0.6, heatmap=heatmap("unseen"))
    count(desk)
    assert table.cell("car", "s_ms").values[0] is not None and targets.is_current
    desk.features.files.open_preset("W+T")  # the same figures: they stay
    assert table.cell("car", "s_ms").values[0] is not None and targets.is_current
