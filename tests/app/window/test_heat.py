"""The heatmap in the window: sliders change how it is drawn, a picked voxel is explained and follows the rig."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QToolButton, QWidget
from pytestqt.qtbot import QtBot

from riglens.app.window.features.heat import look_of
from riglens.app.window.features.pick import Pick
from riglens.app.window.settings import Settings
from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import sees_voxel
from riglens.core.figures.heatmaps import OFF
from riglens.core.figures.registry import voxel_heat_maps
from riglens.core.geometry import Pose
from riglens.core.scene.columns import unpack
from riglens.widgets.drawing.camera import ViewRay
from riglens.widgets.heatmap.pick import PickedCell
from riglens.widgets.heatmap.scale import USUAL_LOOK, HeatLook
from riglens.widgets.viewport.offscreen import OffscreenViewport
from tests.app.window_bench import Bench, open_bench
from tests.waiting import TIMEOUT_MS, wait_for


@pytest.fixture
def bench(whole: Bench) -> Bench:
    return whole


def pick(bench: Bench, row: int = 0) -> Pick:
    """Click at a cell of the heatmap that is shown; the view answers in place of a mouse."""
    data = bench.viewport.state.heatmap
    centre = data.centres_m[row].astype(float)
    down = ViewRay(centre + np.array([0.0, 0.0, 9.0]), np.array([0.0, 0.0, -1.0]))
    bench.viewport.cell_picked.emit(PickedCell(row, centre, data.cell_m, down))
    found = bench.features.pick
    bench.qtbot.waitUntil(lambda: found.card.text is not None, timeout=TIMEOUT_MS)
    bench.settle()
    return found


def test_every_mode_can_be_chosen_says_what_it_is_and_a_click_finds_the_voxel(bench: Bench) -> None:
    heat, grid = bench.features.heat, bench.scenes[-1].field.grid
    for shown in voxel_heat_maps():
        heat.set_mode(shown.key)
        bench.settle()
        data = bench.viewport.state.heatmap
        assert data.title == f"{shown.title}, car"
        row = int(np.abs(data.values).argmax())
        if not data.values[row]:
            continue
        pick(bench, row)
        at = [grid.centres_m(axis)[place] for axis, place in enumerate(bench.session.voxel)]
        assert np.abs(at - data.centres_m[row]).max() <= data.cell_m / 2.0
    heat.set_mode(OFF)
    bench.settle()
    assert bench.viewport.state.heatmap is None
    bench.session.pick(None)
    bench.viewport.cell_picked.emit(
        PickedCell(0, np.array(at), data.cell_m, ViewRay(np.array(at) + 9.0, -np.ones(3) / 3.0**0.5))
    )
    assert bench.session.voxel is not None  # of a click that the view saw before the map was off


def test_changes_are_counted_from_the_baseline_of_the_scores(bench: Bench) -> None:
    bench.features.heat.set_mode("change")
    bench.settle()
    assert not bench.viewport.state.heatmap.values.any()
    bench.document.set_enabled("roof", False)
    bench.settle()
    shown = bench.viewport.state.heatmap
    now, before = (
        Engine(bench.scenes[-1].field).evaluate(rig) for rig in (bench.document.rig, bench.session.baseline)
    )
    assert now is not None and before is not None
    seen_now, seen_before = (found.seen_by_any() for found in (now, before))
    field = bench.scenes[-1].field
    places = np.floor((shown.centres_m - np.array(field.grid.origin_m)) / field.grid.voxel_m).astype(int)
    gained = unpack(field.grid, seen_now & ~seen_before)[tuple(places.T)]
    lost = unpack(field.grid, seen_before & ~seen_now)[tuple(places.T)]
    assert np.array_equal(shown.values > 0, gained) and np.array_equal(shown.values < 0, lost)
    assert lost.any() and not gained.any()


def test_sliders_tell_the_view_at_once_and_ask_for_no_scores(bench: Bench) -> None:
    panel, asked = bench.features.heat.panel, []
    bench.workbench.recompute.evaluated.connect(asked.append, Qt.ConnectionType.QueuedConnection)
    panel.threshold.setValue(100)
    panel.log.setChecked(True)
    panel.opacity.setValue(160)
    assert bench.viewport.state.heat_look == HeatLook(0.5, True, 0.8, draped=True)
    panel.sliced.setChecked(True)
    panel.bottom.setValue(2)
    assert bench.viewport.state.heat_look.slice_m == (1.0, 1.5)
    panel.thickness.setValue(3)
    assert bench.viewport.state.heat_look.slice_m == (1.0, 2.5)
    bench.settle()
    assert asked == []
    reset = panel.findChild(QWidget, "reset_look")
    assert reset is not None
    QTest.mouseClick(reset, Qt.MouseButton.LeftButton)
    assert bench.viewport.state.heat_look == USUAL_LOOK


def test_the_threshold_is_said_in_the_unit_of_the_heatmap(bench: Bench) -> None:
    heat = bench.features.heat
    heat.set_mode("entropy")
    bench.settle()
    heat.panel.threshold.setValue(100)
    label = heat.panel.findChild(QLabel, "Show from value")
    assert label is not None and label.text() == f"{bench.viewport.state.heatmap.vmax / 2:.2g} nat"


def test_the_sliders_open_under_a_button_of_the_toolbar(bench: Bench) -> None:
    button = bench.window.findChild(QToolButton, "heat_look")
    assert button is not None and not bench.features.heat.panel.isVisible()
    menu = button.menu()
    menu.popup(QPoint(0, 0))
    assert bench.features.heat.panel.isVisible()
    menu.close()


@pytest.mark.parametrize("kept", [{}, {"threshold": "x", "opacity": 0.5}, {"threshold": 2.0, "opacity": 0.5}])
def test_a_look_that_was_not_kept_well_is_forgotten(kept: dict) -> None:
    assert look_of(kept) is None
    assert look_of({"threshold": 0.3, "opacity": 0.7, "log": True}) == HeatLook(0.3, True, 0.7)


def test_who_sees_a_picked_voxel_is_what_the_engine_marks(bench: Bench) -> None:
    found = pick(bench)
    assert bench.session.voxel is not None and found.card.text is not None
    engine = Engine(bench.scenes[-1].field)
    engine.evaluate(bench.document.rig)
    for sensor, line in zip(bench.document.rig.sensors, found.card.text.sensors, strict=True):
        assert line.name == sensor.name
        assert line.sees == sees_voxel(engine, sensor, "exact", bench.session.voxel)
    assert bench.viewport.state.marker.edge_m == 0.5
    assert found.card.isVisible()


def test_the_card_follows_the_rig(bench: Bench) -> None:
    found = pick(bench)
    bench.document.set_enabled("roof", False)
    bench.settle()
    assert found.card.text is not None
    assert {line.name: line.text for line in found.card.text.sensors}["roof"] == "disabled"
    bench.viewport.press("roof")
    bench.viewport.drag_to("roof", Pose((0.5, 0.0, 2.0), (0.0, 0.0, 0.0)))
    bench.viewport.release("roof")
    bench.document.set_enabled("roof", True)
    bench.settle()
    engine = Engine(bench.scenes[-1].field)
    engine.evaluate(bench.document.rig)
    assert bench.session.voxel is not None
    sees = sees_voxel(engine, bench.document.rig.sensor("roof"), "exact", bench.session.voxel)
    assert {line.name: line.sees for line in found.card.text.sensors}["roof"] == sees


def test_escape_forgets_the_voxel_and_then_puts_the_tool_away(bench: Bench) -> None:
    bench.act("pick")
    assert bench.viewport.told[-1] == ("pick", True)
    found = pick(bench)
    bench.viewport.escaped.emit()
    assert bench.session.voxel is None and not found.card.isVisible() and bench.viewport.state.marker is None
    assert bench.workbench.actions["pick"].isChecked()
    bench.viewport.escaped.emit()
    assert bench.viewport.told[-1] == ("pick", False)


def test_escape_closes_the_card_wherever_the_focus_is(bench: Bench) -> None:
    for place in ["tree", "field", "window"]:
        bench.document.select("roof")
        found = pick(bench)
        target = {"tree": bench.panels.tree, "field": bench.find("x"), "window": bench.window}[place]
        target.setFocus()
        QTest.keyClick(target, Qt.Key.Key_Escape)
        assert bench.session.voxel is None and not found.card.isVisible()


def test_escape_in_a_field_takes_back_what_was_typed_before_it_closes_the_card(bench: Bench) -> None:
    bench.document.select("roof")
    pick(bench)
    edit = bench.find("x")
    edit.setFocus()
    QTest.keyClicks(edit, "7")
    QTest.keyClick(edit, Qt.Key.Key_Escape)
    assert edit.property("text") == "0.1" and bench.session.voxel is not None
    QTest.keyClick(edit, Qt.Key.Key_Escape)
    assert bench.session.voxel is None


def test_a_click_beside_the_heatmap_forgets_the_voxel(bench: Bench) -> None:
    found = pick(bench)
    bench.viewport.cell_picked.emit(None)
    assert bench.session.voxel is None and found.card.text is None


def test_alt_click_picks_without_touching_selection_or_camera(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, viewport=OffscreenViewport()) as bench:
        bench.document.select("roof")
        bench.act("heat_space")
        bench.features.heat.set_mode("entropy")
        bench.settle()
        wait_for(lambda: bench.viewport.is_at_rest)
        canvas, state = bench.viewport.findChild(QWidget), bench.viewport.state
        size = (canvas.width(), canvas.height())
        spots = state.camera.project(state.heatmap.centres_m.astype(float), size)
        inside = ((spots[:, :2] > 20) & (spots[:, :2] < np.array(size) - 20)).all(axis=1)
        far = inside & (np.abs(state.heatmap.centres_m[:, 0]) > 3.5)
        spot = QPoint(*(round(float(place)) for place in spots[np.flatnonzero(far)[-1], :2]))
        alt, left = Qt.KeyboardModifier.AltModifier, Qt.MouseButton.LeftButton
        QTest.mouseClick(canvas, left, alt, spot)
        found = bench.features.pick
        qtbot.waitUntil(lambda: found.card.text is not None, timeout=TIMEOUT_MS)
        assert bench.document.selected == "roof"
        assert bench.viewport.state.camera == state.camera
        marker = bench.viewport.state.marker
        assert marker is not None and bench.session.voxel is not None
        QTest.keyClick(canvas, Qt.Key.Key_Escape)
        assert bench.session.voxel is None and bench.viewport.state.marker is None


def test_the_paper_s_rigs_open_with_cells_in_space_until_a_shape_is_chosen(
    qtbot: QtBot, tmp_path: Path
) -> None:
    file = tmp_path / "window.ini"
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        document, look = bench.document, lambda: bench.viewport.state.heat_look.draped
        assert look() == document.rig.self_occlusion
        document.show(document.rig.replace(self_occlusion=not document.rig.self_occlusion))
        assert look() == document.rig.self_occlusion
        before = look()
        bench.act("heat_space")
        assert look() != before and bench.workbench.actions["heat_space"].isChecked() == before
        document.show(document.rig.replace(self_occlusion=not document.rig.self_occlusion))
        assert look() != before, "a choice stays"
    with open_bench(qtbot, tmp_path, kept=Settings(file), data=False) as bench:
        assert bench.viewport.state.heat_look.draped != before, "also in the next session"
