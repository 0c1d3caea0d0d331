"""Several selected sensors in the whole window: every action works on all of them, as one step."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QApplication, QMenu
from pytestqt.qtbot import QtBot

from riglens.app.window.settings import Settings
from riglens.core.geometry import Pose
from riglens.core.rig.edits import linked, mirrored_pose
from riglens.core.vehicle.placing import PlacingRules
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import CAMERA, LIDAR, RIG

BACK = CAMERA.replace(name="back", position=(-2.0, 0.6, 1.0), rpy_deg=(0.0, 0.0, 180.0))
THREE = RIG.replace(sensors=(LIDAR, CAMERA, BACK))


@pytest.fixture
def bench(file_desk: FullDesk) -> FullDesk:
    file_desk.start_over(file_desk.features, THREE)
    file_desk.document.choose_all()
    return file_desk


def heights(bench: FullDesk) -> list[float]:
    return [sensor.position[2] for sensor in bench.document.rig.sensors]


def test_a_box_adds_to_the_selection_or_takes_out_of_it(bench: FullDesk) -> None:
    bench.document.select("front")
    bench.viewport.sensors_boxed.emit(("roof", "back"), False)
    assert bench.document.selection == ("front", "roof", "back")
    assert bench.panels.tree.chosen == ("roof", "front", "back")
    bench.viewport.sensors_boxed.emit(("roof", "front"), True)
    assert bench.document.selection == ("back",)
    bench.viewport.sensors_boxed.emit((), False)
    assert bench.document.selection == ("back",)


def test_a_drag_of_a_group_is_one_step_for_all(bench: FullDesk) -> None:
    names = ("roof", "front", "back")
    bench.viewport.drag_started.emit(names)
    for lift_m in (0.1, 0.2):
        bench.viewport.drag_moved.emit(
            {s.name: Pose((*s.position[:2], s.position[2] + lift_m), s.rpy_deg) for s in THREE.sensors}
        )
    bench.viewport.drag_finished.emit()
    assert heights(bench) == pytest.approx([2.1, 1.6, 1.2])
    assert bench.document.undo_label == "move 3 sensors"
    bench.act("undo")
    assert bench.document.rig == THREE and bench.document.undo_label is None


def test_a_pair_in_a_dragged_group_stays_symmetric(bench: FullDesk) -> None:
    bench.document.apply(linked(THREE, "back", "front"))
    pair = bench.document.rig
    names = ("front", "back")
    bench.viewport.drag_started.emit(names)
    moved = {name: pair.sensor(name).pose for name in names}
    shifted = {
        name: Pose((x + 0.3, y + 0.1, z), pose.rpy_deg)
        for name, pose in moved.items()
        for x, y, z in [pose.position_m]
    }
    bench.viewport.drag_moved.emit(shifted)
    bench.viewport.drag_finished.emit()
    back, front = (bench.document.rig.sensor(name) for name in ("back", "front"))
    assert back.pose == shifted["back"] and front.pose == mirrored_pose(back.pose)
    assert bench.viewport.state.rig == bench.document.rig


def test_one_locked_sensor_holds_the_whole_group_and_says_so(bench: FullDesk) -> None:
    bench.document.set_locked(("front",), True)
    bench.viewport.drag_started.emit(("roof", "front"))
    bench.viewport.drag_moved.emit({"roof": Pose(), "front": Pose()})
    assert bench.document.rig == THREE
    assert "front is locked" in bench.workbench.errors.message
    free, changing = bench.document.chosen, ("align_height", "space", "enable", "delete", "cut")
    assert "front" in free and not any(bench.is_enabled(key) for key in changing)
    bench.viewport.nudged.emit({"roof": Pose(), "front": Pose()})
    assert bench.document.rig == THREE
    bench.document.set_locked(("front",), False)
    assert all(bench.is_enabled(key) for key in changing)


def test_aligning_and_spacing_are_one_step_each(bench: FullDesk) -> None:
    for key in ["align_left", "align_centre", "align_height", "align_front", "space"]:
        bench.act(key)
        assert bench.document.rig != THREE
        assert bench.document.undo_label == f"{'space' if key == 'space' else 'align'} 3 sensors"
        bench.act("undo")
        assert bench.document.rig == THREE


def test_same_height_is_that_of_the_sensor_selected_last(bench: FullDesk) -> None:
    bench.document.choose(("roof", "back", "front"))
    bench.act("align_height")
    assert heights(bench) == [1.4, 1.4, 1.4]


def test_a_pair_that_cannot_be_aligned_is_told_and_nothing_changes(bench: FullDesk) -> None:
    bench.document.apply(linked(THREE, "back", "front"))
    bench.document.choose(("front", "back"))
    before = bench.document.rig
    bench.act("align_left")
    assert bench.document.rig == before and "mirror image" in bench.workbench.errors.message


def test_what_makes_sense_for_one_sensor_only_waits_until_one_is_selected(bench: FullDesk) -> None:
    alone = ("rename", "place")
    assert not any(bench.is_enabled(key) for key in alone)
    assert all(
        bench.is_enabled(key) for key in ("align_left", "space", "delete", "duplicate", "hide", "lock")
    )
    bench.document.select("roof")
    assert all(bench.is_enabled(key) for key in (*alone, "align_centre"))
    assert not any(bench.is_enabled(key) for key in ("align_left", "space"))


def opened_menu() -> QMenu:
    menu = QApplication.activePopupWidget()
    assert isinstance(menu, QMenu)
    return menu


def texts(menu: QMenu) -> list[str]:
    return [action.text() for action in menu.actions() if action.text()]


def test_a_right_click_on_a_sensor_opens_its_menu_for_all_that_is_selected(bench: FullDesk) -> None:
    bench.viewport.menu_wanted.emit("front", QPoint(200, 200))
    assert len(bench.document.selection) == 3
    assert {"Duplicate", "Delete", "Locked"} <= set(texts(opened_menu()))
    opened_menu().close()
    bench.document.select("roof")
    bench.viewport.menu_wanted.emit("front", QPoint(200, 200))
    assert bench.document.selection == ("front",)
    opened_menu().close()


def test_a_right_click_on_nothing_opens_the_menu_of_the_view_and_keeps_the_selection(bench: FullDesk) -> None:
    bench.viewport.menu_wanted.emit(None, QPoint(200, 200))
    menu = opened_menu()
    assert {"Frame all", "Top", "Orthographic", "Save view…", "Select all", "Pick a voxel"} <= set(
        texts(menu)
    )
    assert len(bench.document.selection) == 3
    menu.close()


def test_how_sensors_are_put_on_the_car_is_chosen_and_kept(qtbot: QtBot) -> None:
    kept = Settings()
    with full_desk(qtbot, kept=kept) as bench:
        assert bench.viewport.state.placing == PlacingRules(upright=True)
        bench.act("place_below_rails")
        assert bench.viewport.state.placing == PlacingRules(upright=True, below_rails=True)
        bench.act("place_upright")
        assert bench.viewport.state.placing == PlacingRules(below_rails=True)
        bench.features.placing.keep(kept)
    with full_desk(qtbot, kept=kept) as bench:
        assert bench.viewport.state.placing == PlacingRules(below_rails=True)
