"""Several selected sensors in the inspector: what differs is said, and an edit is one of all of them."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QLineEdit, QToolButton

from riglens.core.rig.edits import linked
from riglens.widgets.panels.fields.quantity import METRES, MILLIMETRES, Change, parse_change
from tests.app.window.desk import FullDesk
from tests.app.window_bench import CAMERA, LIDAR, RIG, type_into

OTHER = LIDAR.replace(name="low", position=(0.5, -0.2, 1.0), elevations_deg=(-10.0, 0.0), range_m=(0.5, 80.0))
BACK = CAMERA.replace(name="back", position=(-2.0, 0.0, 1.4), rpy_deg=(0.0, 0.0, 180.0), enabled=False)
FOUR = RIG.replace(sensors=(LIDAR, OTHER, CAMERA, BACK))


@pytest.fixture
def bench(file_desk: FullDesk) -> FullDesk:
    file_desk.start_over(file_desk.features, FOUR)
    file_desk.document.choose(("front", "back", "low", "roof"))
    return file_desk


def field(bench: FullDesk, name: str) -> QLineEdit:
    found = bench.find(name)
    assert isinstance(found, QLineEdit)
    return found


def values(bench: FullDesk, place: int) -> list[float]:
    return [sensor.position[place] for sensor in bench.document.rig.sensors]


def state(bench: FullDesk) -> str:
    label = bench.panels.inspector.form.findChild(QLabel, "state")
    assert label is not None
    return str(label.text())


def test_values_that_differ_are_shown_as_mixed_and_shared_ones_as_they_are(bench: FullDesk) -> None:
    for name in ("x", "y", "z", "yaw", "range_m.to", "name"):
        assert (field(bench, name).text(), field(bench, name).placeholderText()) == ("", "mixed"), name
    assert field(bench, "pitch").text() == "0"
    assert "1 to 1.9 m" in field(bench, "z").toolTip() and "A number sets all" in field(bench, "z").toolTip()
    enabled = bench.find("enabled")
    assert isinstance(enabled, QCheckBox) and enabled.checkState() == Qt.CheckState.PartiallyChecked
    assert state(bench).startswith("4 selected: a number sets all of them")
    assert "Model and beams apply to the 2 LiDARs among them." in state(bench)
    assert not field(bench, "name").isEnabled()
    bench.document.choose(("roof", "low"))
    assert state(bench).startswith("2 selected") and "among them" not in state(bench)


def test_a_number_sets_all_and_is_one_step(bench: FullDesk) -> None:
    bench.type("z", "2.5")
    assert values(bench, 2) == [2.5] * 4
    assert values(bench, 0) == [sensor.position[0] for sensor in FOUR.sensors]
    bench.act("undo")
    assert bench.document.rig == FOUR and bench.document.undo_label is None


def test_a_change_changes_each_and_tenths_stay_tenths(bench: FullDesk) -> None:
    for text, expected in [
        ("+=0.1", [2.0, 1.1, 1.5, 1.5]),
        ("-= 100 mm", [1.8, 0.9, 1.3, 1.3]),
        ("-=0,1", None),
        ("*=2", [3.8, 2.0, 2.8, 2.8]),
        ("/=2", [0.95, 0.5, 0.7, 0.7]),
    ]:
        bench.type("z", text)
        assert values(bench, 2) == (expected or [1.9, 1.0, 1.4, 1.4])
        assert bool(bench.panels.inspector.form.problem) == (expected is None)
        bench.act("undo")
        assert bench.document.rig == FOUR


def test_a_change_goes_for_a_single_sensor_too(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.type("x", "+=0.2")
    assert bench.document.rig.sensor("roof").position[0] == 0.3


def test_a_plus_that_may_mean_either_is_asked_about(bench: FullDesk) -> None:
    bench.type("z", "+0.1")
    assert bench.document.rig == FOUR
    assert "write +=0.1 to add to each, or 0.1 to set all" in bench.panels.inspector.form.problem
    bench.type("z", "-0.1")
    assert values(bench, 2) == [-0.1] * 4


def test_arrow_keys_step_each_of_several(bench: FullDesk) -> None:
    edit = field(bench, "z")
    edit.setFocus()
    QTest.keyClick(edit, Qt.Key.Key_Up)
    assert values(bench, 2) == [1.95, 1.05, 1.45, 1.45]
    QTest.keyClick(edit, Qt.Key.Key_Down, Qt.KeyboardModifier.ShiftModifier)
    assert values(bench, 2) == [1.45, 0.55, 0.95, 0.95]


def test_an_emptied_field_says_mixed_again_and_changes_nothing(bench: FullDesk) -> None:
    edit = field(bench, "z")
    edit.setFocus()
    QTest.keyClicks(edit, "3")
    QTest.keyClick(edit, Qt.Key.Key_Backspace)
    QTest.keyClick(edit, Qt.Key.Key_Return)
    assert bench.document.rig == FOUR and bench.panels.inspector.form.problem == ""


def test_visiting_every_field_of_several_changes_no_bit(bench: FullDesk) -> None:
    for edit in bench.panels.inspector.form.findChildren(QLineEdit):
        edit.setFocus()
        QTest.keyClick(edit, Qt.Key.Key_End)
        QTest.keyClick(edit, Qt.Key.Key_Return)
    assert bench.document.rig == FOUR


def test_a_click_on_a_half_ticked_box_counts_all_and_the_next_none(bench: FullDesk) -> None:
    enabled = bench.find("enabled")
    for wanted in (True, False, True):
        QTest.mouseClick(enabled, Qt.MouseButton.LeftButton, pos=QPoint(8, enabled.height() // 2))
        assert {sensor.enabled for sensor in bench.document.rig.sensors} == {wanted}


def test_fields_of_one_kind_change_that_kind_only(bench: FullDesk) -> None:
    bench.document.choose(("roof", "front", "back"))
    bench.type("hfov_deg", "120")
    assert [s.hfov_deg for s in bench.document.rig.enabled_cameras()] == [120.0]
    back = bench.document.rig.sensor("back")
    assert back.kind == "camera" and back.hfov_deg == 120.0
    assert bench.document.rig.sensor("roof") == LIDAR


def test_a_model_is_given_to_all_of_the_kind(bench: FullDesk) -> None:
    model = bench.find("model")
    assert isinstance(model, QComboBox) and model.currentText() == "none"
    bench.choose("model", "Velodyne VLP-16 (Puck)")
    assert [s.model for s in bench.document.rig.sensors] == ["velodyne-vlp-16", "velodyne-vlp-16", None, None]
    bench.document.replace_sensor("low", OTHER)
    assert model.currentIndex() == -1 and model.placeholderText() == "mixed"


def test_a_value_that_one_of_them_refuses_changes_none_and_names_it(bench: FullDesk) -> None:
    bench.type("range_m.from", "90")
    assert bench.document.rig == FOUR
    assert bench.panels.inspector.form.problem.startswith("Range from: low: Range must be")


def test_a_list_of_angles_beside_even_ones_is_told(bench: FullDesk) -> None:
    bench.type("elevations_deg.count", "4")
    assert bench.document.rig == FOUR
    assert "low: is specified differently" in bench.panels.inspector.form.problem


def test_levelling_keeps_each_place_and_heading_and_no_pose_is_pasted_on_several(bench: FullDesk) -> None:
    bench.type("roll", "5")
    before = bench.document.rig
    bench.panels.inspector.form.tools._level()
    for old, new in zip(before.sensors, bench.document.rig.sensors, strict=True):
        assert new.pose.position_m == old.pose.position_m
        assert new.rpy_deg == (0.0, 0.0, old.rpy_deg[2])
    paste = bench.panels.inspector.form.findChild(QToolButton, "paste_pose")
    assert paste is not None and not paste.isEnabled()
    bench.document.select("roof")
    assert paste.isEnabled()


def test_one_locked_sensor_makes_all_fields_read_only_and_is_named(bench: FullDesk) -> None:
    bench.document.set_locked(("back",), True)
    assert "back locked" in state(bench) and not field(bench, "z").isEnabled()
    bench.document.choose(("roof", "low"))
    assert field(bench, "z").isEnabled() and "locked" not in state(bench)


def test_a_pair_among_them_stays_a_pair(bench: FullDesk) -> None:
    pair = linked(FOUR, "roof", "low")
    bench.document.apply(pair)
    bench.type("z", "+=0.1")
    assert [bench.document.rig.sensor(name).position[2] for name in ("roof", "low")] == [2.0, 2.0]


def test_typing_into_a_mixed_field_is_kept_while_the_rig_changes(bench: FullDesk) -> None:
    edit = field(bench, "z")
    edit.setFocus()
    QTest.keyClicks(edit, "2.")
    bench.document.set_enabled(("back",), True)
    assert edit.text() == "2."
    type_into(bench.qtbot, edit, "2.2")
    assert values(bench, 2) == [2.2] * 4


@pytest.mark.parametrize(
    ("text", "change"),
    [
        ("+=0.1", Change(plus=0.1)),
        (" -= 10 mm", Change(plus=-0.01)),
        ("*=1.5", Change(times=1.5)),
        ("0.1", None),
        ("+0.1", None),
        ("1+=2", None),
    ],
)
def test_what_a_change_says(text: str, change: Change | None) -> None:
    assert parse_change(text, METRES) == change


def test_a_change_is_in_the_unit_of_the_field() -> None:
    assert parse_change("+=100", MILLIMETRES) == Change(plus=0.1)


@pytest.mark.parametrize("text", ["+=", "/=0", "*=x"])
def test_a_wrong_change_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="must"):
        parse_change(text, METRES)
