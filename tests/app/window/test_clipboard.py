"""Sensors travel as text: into another window, another program and back; foreign text is refused clearly."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.app.session.document import DUPLICATE_OFFSET_M
from riglens.core.rig.edits import mirrored_pose, partner_of
from riglens.core.rig.yaml.file import loads
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import CAMERA, LIDAR, RIG, Bench


def press(bench: Bench, key: Qt.Key) -> None:
    bench.qtbot.keyClick(bench.workbench.window, key, Qt.KeyboardModifier.ControlModifier)


def test_a_copy_comes_back_under_a_free_name_as_one_step(unscored: Bench) -> None:
    unscored.document.select("roof")
    press(unscored, Qt.Key.Key_C)
    press(unscored, Qt.Key.Key_V)
    x, y, z = LIDAR.position
    beside = LIDAR.replace(name="roof_2", position=(x, y + DUPLICATE_OFFSET_M, z))
    assert unscored.document.rig.sensor("roof_2") == beside
    assert unscored.document.undo_label == "paste roof"
    unscored.act("undo")
    assert unscored.document.rig == RIG


def test_several_sensors_go_into_another_window_in_one_step(
    qtbot: QtBot, tmp_path: Path, bench: FullDesk
) -> None:
    bench.panels.tree.choose(("roof", "front"))
    bench.act("copy")
    with full_desk(qtbot, rig=RIG.replace(sensors=())) as other:
        other.act("paste")
        assert other.document.rig.sensors == (LIDAR, CAMERA)
        assert other.document.undo_label == "paste 2 sensors"


def test_what_is_copied_is_a_rig_file(bench: FullDesk) -> None:
    bench.document.select("front")
    bench.act("copy")
    assert loads(bench.clipboard()).rig == RIG.replace(sensors=(CAMERA,))


def test_cut_copies_and_deletes(bench: FullDesk) -> None:
    bench.document.select("front")
    bench.act("cut")
    assert bench.document.rig.sensors == (LIDAR,)
    bench.act("paste")
    assert bench.document.rig.sensors == (LIDAR, CAMERA)


@pytest.mark.parametrize("head", ["sensors:\n", ""])
def test_part_of_a_rig_file_from_an_editor_is_enough(bench: FullDesk, head: str) -> None:
    bench.document.select("roof")
    bench.act("copy")
    text = bench.clipboard()
    QApplication.clipboard().setText(head + text.partition("sensors:\n")[2])
    bench.act("paste")
    assert bench.document.rig.sensor("roof_2").rpy_deg == LIDAR.rpy_deg


def test_each_further_copy_stands_beside_the_one_before(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.act("copy")
    for _ in range(3):
        bench.act("paste")
    lidars = [s for s in bench.document.rig.sensors if s.kind == "lidar"]
    assert [sensor.position[1] for sensor in lidars] == pytest.approx([0.2, 0.4, 0.6, 0.8])


def test_a_pair_comes_back_as_a_pair_and_a_half_of_one_alone(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.act("mirror")
    for names in (("roof", "roof_right"), ("roof_right",)):
        bench.document.choose(names)
        bench.act("copy")
        bench.act("paste")
    rig = bench.document.rig
    assert partner_of(rig, "roof_2") == "roof_right_2" and partner_of(rig, "roof_right_3") is None
    left, right = rig.sensor("roof_2"), rig.sensor("roof_right_2")
    assert right.pose == mirrored_pose(left.pose)
    assert left.position == pytest.approx((0.1 + DUPLICATE_OFFSET_M, 0.2, 1.9))


def test_foreign_text_is_refused_in_one_line_and_changes_nothing(bench: FullDesk) -> None:
    for text, reason in [
        ("", "no text"),
        ("Dear Sir or Madam,", "clipboard"),
        ("sensors: [{name: a, kind: sonar}]", "clipboard"),
        ("riglens: 1\nname: a\nsensors: []\n", "no sensors"),
        ("- " * 3000, "clipboard"),
    ]:
        bench.workbench.errors.clear()
        QApplication.clipboard().setText(text)
        bench.act("paste")
        message = bench.workbench.errors.message
        assert reason in message and "copy sensors first" in message and "\n" not in message
        assert bench.document.rig == RIG


def test_in_a_text_field_the_keys_copy_text(bench: FullDesk) -> None:
    edit = bench.find("rig_name")
    edit.setFocus()
    bench.qtbot.keyClick(edit, Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    bench.qtbot.keyClick(edit, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    assert bench.clipboard() == RIG.name
