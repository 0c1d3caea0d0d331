"""Mirror pairs in the window: seen in list and inspector, made, linked, copied, and told when they cannot be."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QPushButton

from riglens.core.rig.edits import mirrored_pose, partner_of
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.sensors.rows import NAME
from tests.app.window.desk import FullDesk
from tests.app.window_bench import CAMERA, LIDAR, RIG

LEFT = CAMERA.replace(name="CAM_FL", position=(1.0, 0.6, 1.4), rpy_deg=(0.0, 0.0, 40.0))
SIDE = CAMERA.replace(name="side", position=(0.0, -0.7, 1.2), rpy_deg=(0.0, 0.0, -90.0))
START = RIG.replace(sensors=(LIDAR, CAMERA, LEFT, SIDE))


@pytest.fixture
def bench(file_desk: FullDesk) -> FullDesk:
    file_desk.start_over(file_desk.features, START)
    return file_desk


def has_mark(bench: FullDesk, name: str) -> bool:
    return not bench.panels.tree._items[name].icon(NAME).isNull()


def unlink_button(bench: FullDesk) -> QPushButton:
    button = bench.panels.inspector.form.findChild(QPushButton, "unlink_pair")
    assert button is not None
    return button


def test_a_pair_is_marked_in_the_list_and_its_tooltip_names_the_other(bench: FullDesk) -> None:
    assert not any(has_mark(bench, sensor.name) for sensor in START.sensors)
    bench.document.select("CAM_FL")
    bench.act("mirror")
    assert bench.document.selected == "CAM_FR"
    assert [s.name for s in bench.document.rig.sensors if has_mark(bench, s.name)] == ["CAM_FL", "CAM_FR"]
    for name, other in (("CAM_FL", "CAM_FR"), ("CAM_FR", "CAM_FL")):
        assert f"Mirror pair with {other}" in bench.panels.tree._items[name].toolTip(NAME)
    bench.act("unlink")
    assert not has_mark(bench, "CAM_FL") and "Mirror pair" not in bench.panels.tree._items["CAM_FL"].toolTip(
        NAME
    )


def test_the_inspector_names_the_other_and_unlinks_by_a_button(bench: FullDesk) -> None:
    bench.workbench.window.show()
    bench.document.select("CAM_FL")
    assert unlink_button(bench).isHidden() or not unlink_button(bench).isVisible()
    window = bench.workbench.window
    edit = next(e for e in window.findChildren(NumberEdit) if e.accessibleName() == "x" and e.isVisible())
    QApplication.processEvents()
    before = edit.mapTo(window, QPoint(0, 0))
    bench.act("mirror")
    assert unlink_button(bench).isVisible()
    QApplication.processEvents()
    assert edit.mapTo(window, QPoint(0, 0)) == before, "no field moves under the mouse"
    QTest.mouseClick(unlink_button(bench), Qt.MouseButton.LeftButton)
    assert partner_of(bench.document.rig, "CAM_FR") is None
    assert not unlink_button(bench).isVisible()
    assert bench.document.undo_label == "unlink CAM_FR"


def test_several_are_mirrored_in_one_step_and_their_names_follow_the_side(bench: FullDesk) -> None:
    bench.document.choose(("CAM_FL", "roof", "side"))
    bench.act("mirror")
    assert set(bench.document.selection) == {"CAM_FR", "roof_right", "side_left"}
    for name, image in (("CAM_FL", "CAM_FR"), ("roof", "roof_right"), ("side", "side_left")):
        rig = bench.document.rig
        assert partner_of(rig, name) == image
        assert rig.sensor(image).pose == mirrored_pose(START.sensor(name).pose)
    bench.act("undo")
    assert bench.document.rig == START and bench.document.undo_label is None


def test_two_selected_sensors_are_linked_and_the_first_stays(bench: FullDesk) -> None:
    bench.document.choose(("CAM_FL", "front"))
    bench.act("link")
    assert partner_of(bench.document.rig, "front") == "CAM_FL"
    assert bench.document.rig.sensor("CAM_FL").pose == LEFT.pose
    assert bench.document.rig.sensor("front").pose == mirrored_pose(LEFT.pose)
    bench.document.choose(("CAM_FL", "side", "front"))
    bench.act("unlink")
    assert partner_of(bench.document.rig, "front") is None
    bench.document.choose(("CAM_FL", "roof"))
    assert not bench.is_enabled("link")


def test_a_copied_pair_is_linked_stands_in_place_and_says_so(bench: FullDesk) -> None:
    bench.document.select("CAM_FL")
    bench.act("mirror")
    bench.document.choose(("CAM_FL", "CAM_FR"))
    bench.act("duplicate")
    rig = bench.document.rig
    assert bench.document.selection == ("CAM_FL_2", "CAM_FR_2")
    assert partner_of(rig, "CAM_FL_2") == "CAM_FR_2"
    assert rig.sensor("CAM_FL_2").pose == LEFT.pose
    assert "drag them away" in bench.workbench.status.currentMessage()


MIDDLE = "front is on the middle plane of the car"


def refuse(bench: FullDesk) -> None:
    bench.document.select("front")
    bench.act("mirror")
    assert bench.workbench.errors.message.startswith(MIDDLE) and bench.document.rig == START


def test_the_notice_of_the_middle_plane_goes_when_the_sensor_has_left_it(bench: FullDesk) -> None:
    refuse(bench)
    bench.type("z", "1.5")
    assert bench.workbench.errors.message.startswith(MIDDLE)
    bench.type("y", "0.3")
    assert bench.workbench.errors.message == ""


def test_the_notice_goes_with_the_selection_and_with_the_sensor(bench: FullDesk) -> None:
    refuse(bench)
    bench.document.select("roof")
    assert bench.workbench.errors.message == ""
    refuse(bench)
    bench.act("delete")
    assert bench.workbench.errors.message == ""


def test_another_message_that_came_after_the_notice_stays(bench: FullDesk) -> None:
    refuse(bench)
    bench.workbench.report_error("The disk is full.")
    bench.type("y", "0.3")
    assert bench.workbench.errors.message == "The disk is full."


def test_the_notice_of_a_lock_goes_when_it_is_unlocked(bench: FullDesk) -> None:
    bench.document.set_locked(("roof",), True)
    bench.viewport.press("roof")
    assert "roof is locked" in bench.workbench.errors.message
    bench.document.set_locked(("roof",), False)
    assert bench.workbench.errors.message == ""
