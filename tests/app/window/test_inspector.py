"""Every field of the inspector changes what it says, keeps what was not changed, and refuses nonsense."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QLabel, QLineEdit
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import KannalaBrandt, LinearAngles, Rig
from riglens.core.sensors.lidar import LIDAR as LIDAR_KIND
from riglens.widgets.panels.fields.form import ChoiceBox
from riglens.widgets.panels.inspector.sensor_forms import SensorForm
from riglens.widgets.panels.sensors.rows import TYPE
from tests.app.window.desk import FullDesk
from tests.app.window_bench import CAMERA, LIDAR, RIG, Bench, choose_item

ODD = 0.1 + 0.2  # 0.30000000000000004: no short decimal gives it back


def even(**changes: float) -> LinearAngles:
    angles = LIDAR.elevations_deg
    assert isinstance(angles, LinearAngles)
    changed: LinearAngles = angles.replace(**changes)
    return changed


SHARED: list[tuple[str, str, dict[str, Callable[[Any], Any]]]] = [
    ("name", "other", {"name": lambda _: "other"}),
    ("x", "0.30000000000000004", {"position": lambda p: (ODD, p[1], p[2])}),
    ("y", "-1.5", {"position": lambda p: (p[0], -1.5, p[2])}),
    ("z", "2", {"position": lambda p: (p[0], p[1], 2.0)}),
    ("roll", "1e-3", {"rpy_deg": lambda p: (0.001, p[1], p[2])}),
    ("pitch", "-12.5", {"rpy_deg": lambda p: (p[0], -12.5, p[2])}),
    ("yaw", "179.9", {"rpy_deg": lambda p: (p[0], p[1], 179.9)}),
    ("range_m.from", "0.5", {"range_m": lambda r: (0.5, r[1])}),
    ("range_m.to", "120", {"range_m": lambda r: (r[0], 120.0)}),
]
LIDAR_FIELDS = [
    ("elevations_deg.from", "-24.8", {"elevations_deg": lambda _: even(from_=-24.8)}),
    ("elevations_deg.to", "15", {"elevations_deg": lambda _: even(to=15.0)}),
    ("elevations_deg.count", "32", {"elevations_deg": lambda _: even(count=32)}),
    ("azimuths_deg.count", "90", {"azimuths_deg": lambda a: a.replace(count=90)}),
]
CAMERA_FIELDS = [
    ("image.width", "200", {"image": lambda i: (200, i[1])}),
    ("image.height", "100", {"image": lambda i: (i[0], 100)}),
    ("hfov_deg", "70.5", {"hfov_deg": lambda _: 70.5}),
    ("cast.columns", "16", {"cast": lambda c: (16, c[1])}),
    ("cast.rows", "9", {"cast": lambda c: (c[0], 9)}),
]
CASES = [("roof", *case) for case in SHARED + LIDAR_FIELDS] + [
    ("front", *case) for case in SHARED + CAMERA_FIELDS
]


def test_a_field_changes_its_value_and_nothing_else(bench: FullDesk) -> None:
    for sensor, field, text, change in CASES:
        bench.document.select(sensor)
        before = bench.document.rig.sensor(sensor)
        bench.type(field, text)
        (attribute, new_value), *_ = change.items()
        expected = before.replace(**{attribute: new_value(getattr(before, attribute))})
        place = 0 if sensor == "roof" else 1
        assert bench.document.rig.sensors[place] == expected
        bench.act("undo")
        assert bench.document.rig == RIG


def test_visiting_every_field_without_typing_changes_no_bit(bench: FullDesk) -> None:
    odd = LIDAR.replace(
        position=(ODD, 1 / 3, 2e-17), rpy_deg=(math.pi, -1 / 7, 1e-9), range_m=(1 / 3, 99.0 + ODD)
    )
    bench.document.apply(Rig(name="odd", sensors=(odd, CAMERA)))
    bench.document.select("roof")
    for edit in bench.panels.inspector.form.findChildren(QLineEdit):
        edit.setFocus()
        bench.qtbot.keyClick(edit, Qt.Key.Key_End)
        bench.qtbot.keyClick(edit, Qt.Key.Key_Return)
    bench.panels.tree.setFocus()
    assert bench.document.rig.sensors == (odd, CAMERA)


def test_pose_tools_of_a_form_that_shows_no_sensor_change_nothing(qtbot: QtBot) -> None:
    form, edits = SensorForm(LIDAR_KIND), list[object]()
    qtbot.addWidget(form)
    form.edited.connect(edits.append)
    QApplication.clipboard().setText("1 2 3 0 0 90")
    form.tools.paste()
    form.tools._level()
    assert form.subject is None and edits == []


def test_typing_what_is_already_shown_keeps_the_hidden_digits(bench: FullDesk) -> None:
    odd = LIDAR.replace(position=(ODD, 0.2, 1.9))
    bench.document.replace_sensor("roof", odd)
    bench.document.select("roof")
    bench.type("x", "0.3")
    assert bench.document.rig.sensor("roof").position[0] == ODD


REFUSED = [
    ("roof", "x", "left", "number"),
    ("roof", "x", "nan", "number"),
    ("roof", "x", "inf", "finite"),
    ("roof", "name", "front", "used by another sensor"),
    ("roof", "name", "", "must not be empty"),
    ("roof", "elevations_deg.from", "20", "must not be below"),
    ("roof", "elevations_deg.from", "-91", "[-90, 90]"),
    ("roof", "elevations_deg.count", "0", "greater than or equal to 1"),
    ("roof", "elevations_deg.count", "2.5", "integer"),
    ("roof", "range_m.to", "0", "greater than 0"),
    ("roof", "range_m.from", "inf", "Range must be"),
    ("front", "hfov_deg", "180", "less than or equal to 179.9"),
    ("front", "hfov_deg", "-5", "greater than or equal to 0.001"),
    ("front", "cast.columns", "161", "must not exceed the image"),
]


def test_nonsense_is_refused_in_red_with_the_reason(bench: FullDesk) -> None:
    for sensor, field, text, reason in REFUSED:
        bench.document.select(sensor)
        bench.type(field, text)
        edit = bench.find(field)
        assert bench.document.rig == RIG
        assert edit.property("invalid")
        assert reason in edit.toolTip()
        assert reason in bench.panels.inspector.form.problem
        bench.qtbot.keyClick(edit, Qt.Key.Key_Escape)
        assert not edit.property("invalid")


def test_a_good_value_after_a_bad_one_takes_the_mark_away(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.type("x", "left")
    bench.type("x", "0.75")
    assert bench.document.rig.sensor("roof").position[0] == 0.75
    assert not bench.find("x").property("invalid")
    assert bench.panels.inspector.form.problem == ""


def test_the_reason_goes_when_the_wrong_text_does(bench: FullDesk) -> None:
    for how in ["escape", "old text", "other text", "edited elsewhere", "step"]:
        bench.document.select(None)
        bench.document.apply(RIG)
        bench.document.select("roof")
        bench.type("yaw", "10")
        bench.type("x", "left")
        bench.type("roll", "round")
        edit, form = bench.find("x"), bench.panels.inspector.form
        assert form.problem.splitlines()[0].startswith("x") and "'left'" in form.problem
        if how == "escape":
            bench.qtbot.keyClick(edit, Qt.Key.Key_Escape)
        elif how == "old text":
            bench.type("x", "0.1")
        elif how == "other text":
            bench.qtbot.keyClick(edit, Qt.Key.Key_5)
        elif how == "edited elsewhere":
            bench.document.replace_sensor("roof", LIDAR.replace(position=(3.0, 0.2, 1.9)))
        else:
            bench.qtbot.keyClick(edit, Qt.Key.Key_Up)
        assert not edit.property("invalid")
        assert form.problem.startswith("roll") and "'round'" in form.problem and "\n" not in form.problem


def test_the_reason_stands_under_the_field_and_stays_beside_another_problem(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.type("azimuths_deg.to", "200")
    edit, form = bench.find("azimuths_deg.to"), bench.panels.inspector.form
    label = edit.parentWidget().findChild(QLabel, "problem")
    assert label is not None and not label.isHidden()
    assert label.text() == "Azimuths to: Azimuths must span at most 360 degrees (got 380.0)"
    form.show_problem("the clipboard holds no pose")
    assert not label.isHidden() and form.problem.splitlines() == [label.text(), "the clipboard holds no pose"]
    bench.type("azimuths_deg.to", "170")
    assert label.isHidden() and form.problem == ""


def test_a_choice_that_is_refused_goes_back_and_says_why(bench: FullDesk) -> None:
    bench.document.select("roof")
    form, before = bench.panels.inspector.form, bench.document.rig
    form.bind_choice(combo := ChoiceBox(), lambda _: "now", refuse_every_value, "refused")
    combo.addItem("now", "now")
    combo.addItem("other", "other")
    choose_item(combo, "other")
    assert (combo.currentText(), form.problem) == ("now", "Range is what it is")
    assert bench.document.rig == before


def refuse_every_value(subject: Any, value: Any) -> Any:
    raise ValueError("range_m is what it is")


def test_another_selection_forgets_what_was_refused(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.type("x", "left")
    bench.document.select(None)
    bench.document.select("roof")
    edit = bench.find("x")
    assert isinstance(edit, QLineEdit)
    assert edit.text() == "0.1"
    assert bench.panels.inspector.form.problem == ""


def test_infinity_is_shown_and_can_be_typed(bench: FullDesk) -> None:
    bench.document.select("roof")
    edit = bench.find("range_m.to")
    assert isinstance(edit, QLineEdit)
    assert edit.text() == "∞"
    bench.type("range_m.to", "50")
    bench.type("range_m.to", "inf")
    assert bench.document.rig.sensor("roof").range_m == (0.0, math.inf)


def test_arrow_keys_step_a_number(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.qtbot.keyClick(bench.find("x"), Qt.Key.Key_Up)
    bench.qtbot.keyClick(bench.find("yaw"), Qt.Key.Key_Down, Qt.KeyboardModifier.ShiftModifier)
    assert bench.document.rig.sensor("roof").position[0] == 0.15
    assert bench.document.rig.sensor("roof").rpy_deg[2] == -10.0


def test_beams_can_be_a_list_and_evenly_spaced_again(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.choose("elevations_deg.way", "list")
    listed = bench.document.rig.sensor("roof")
    assert listed.elevations_deg == tuple(float(angle) for angle in LIDAR.elevations())
    bench.type("elevations_deg.list", "-10, -2.5; 0 7")
    assert bench.document.rig.sensor("roof").elevations_deg == (-10.0, -2.5, 0.0, 7.0)
    bench.choose("elevations_deg.way", "evenly spaced")
    assert bench.document.rig.sensor("roof").elevations_deg == LinearAngles(
        **{"from": -10.0, "to": 7.0, "count": 4}
    )


def test_a_lens_can_be_given_by_focal_lengths_and_by_angle_again(bench: FullDesk) -> None:
    bench.document.select("front")
    bench.choose("lens.way", "focal lengths")
    camera = bench.document.rig.sensor("front")
    assert (camera.hfov_deg, camera.fx, camera.cx) == (None, CAMERA.intrinsics_px()[0], 80.0)
    bench.type("cy", "44.25")
    assert bench.document.rig.sensor("front").cy == 44.25
    bench.choose("lens.way", "field of view")
    assert bench.document.rig.sensor("front").hfov_deg == pytest.approx(90.0)


def test_a_camera_becomes_a_fisheye_whose_coefficients_are_edited(bench: FullDesk) -> None:
    bench.document.select("front")
    bench.choose("distortion.way", "fisheye (Kannala-Brandt)")
    fisheye = bench.document.rig.sensor("front")
    assert fisheye.distortion == KannalaBrandt() and fisheye.intrinsics_px() == CAMERA.intrinsics_px()
    bench.type("distortion.KannalaBrandt.k2", "-0.015")
    assert bench.document.rig.sensor("front").distortion == KannalaBrandt(k2=-0.015)
    assert bench.find("distortion.KannalaBrandt.k2").isVisibleTo(bench.panels.inspector.form)
    bench.choose("distortion.way", "none")
    assert bench.document.rig.sensor("front").distortion is None
    bench.choose("distortion.way", "Brown-Conrady")
    bench.choose("lens.way", "field of view")
    assert "distortion needs the lens as fx" in bench.panels.inspector.form.problem
    bench.act("undo")
    bench.act("undo")
    bench.act("undo")
    assert bench.document.rig.sensor("front") == fisheye.replace(distortion=KannalaBrandt())


def test_azimuth_offsets_are_a_list_that_may_be_empty(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.type("azimuth_offsets_deg.list", "1 2 3 4 5 6 7 8")
    assert bench.document.rig.sensor("roof").azimuth_offsets_deg == tuple(map(float, range(1, 9)))
    bench.type("azimuth_offsets_deg.list", "1, 2")
    assert "one offset per beam" in bench.panels.inspector.form.problem
    bench.type("azimuth_offsets_deg.list", "")
    assert bench.document.rig == RIG


def test_a_model_fills_in_its_fields_and_keeps_name_and_pose(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.choose("model", "Velodyne VLP-16 (Puck)")
    sensor = bench.document.rig.sensor("roof")
    assert (sensor.model, sensor.position, sensor.range_m) == (
        "velodyne-vlp-16",
        LIDAR.position,
        (0.0, 100.0),
    )
    assert len(sensor.elevations()) == 16


def test_the_switch_takes_a_sensor_out_of_the_scores(bench: FullDesk) -> None:
    bench.document.select("front")
    check = bench.find("enabled")
    assert isinstance(check, QCheckBox)
    check.click()
    assert not bench.document.rig.sensor("front").enabled


def test_the_vehicle_is_edited_when_nothing_is_selected(bench: FullDesk) -> None:
    for field, text, expected in [
        ("length", "5.1", 5.1),
        ("width", "2", 2.0),
        ("height", "1.6", 1.6),
        ("rear_axle_x", "-1.5", -1.5),
    ]:
        bench.type(field, text)
        assert getattr(bench.document.rig.vehicle, field) == expected
        assert bench.viewport.state.vehicle == bench.document.rig.vehicle


def test_the_rig_is_renamed_when_nothing_is_selected(bench: FullDesk) -> None:
    bench.type("rig_name", "roof rack 2")
    assert bench.document.rig.name == "roof rack 2"
    assert "roof rack 2" in bench.workbench.window.windowTitle()


def test_undo_by_key_reaches_the_document_from_inside_a_field(unscored: Bench) -> None:
    unscored.document.select("roof")
    unscored.type("x", "0.75")
    unscored.qtbot.keyClick(unscored.find("x"), Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert unscored.document.rig == RIG


def test_a_model_whose_beams_differ_from_the_library_is_marked_as_modified(bench: FullDesk) -> None:
    bench.document.select("roof")
    bench.choose("model", "Velodyne VLP-16 (Puck)")
    model = bench.find("model")
    assert isinstance(model, QComboBox)
    row = bench.panels.tree._items["roof"]
    assert (model.currentText(), row.text(TYPE)) == ("Velodyne VLP-16 (Puck)", "16 ch")
    bench.type("elevations_deg.list", "-1, 0, 1")
    assert model.currentText() == "Velodyne VLP-16 (Puck), modified"
    assert (row.text(TYPE), "elevations differ from the library" in row.toolTip(TYPE)) == ("3 ch*", True)
    bench.act("undo")
    assert (model.currentText(), row.text(TYPE)) == ("Velodyne VLP-16 (Puck)", "16 ch")


LONG = "A_sensor_name_without_a_blank_as_some_tool_made_it_0123456789_0123456789"


def test_long_names_paths_and_reasons_do_not_make_the_inspector_wider_than_its_dock(bench: FullDesk) -> None:
    inspector = bench.panels.inspector
    bench.document.choose(("front", "roof"))
    room_px = inspector.minimumSizeHint().width()
    bench.document.rename("roof", LONG)
    bench.document.choose(("front", LONG))
    assert inspector.form.minimumSizeHint().width() <= room_px
    bench.document.select("front")
    lens = {"model": "kannala_brandt", "k1": -0.0123456789, "k2": 1e-7, "k3": -1e-9, "k4": 1e-11}
    camera = bench.document.rig.sensor("front").replace(
        hfov_deg=None, fx=80.0, fy=80.0, cx=80.0, cy=45.0, distortion=lens
    )
    bench.document.replace_sensor("front", camera)
    bench.type("name", LONG)
    assert LONG in inspector.form.problem
    assert inspector.form.minimumSizeHint().width() <= room_px
    bench.document.select(None)
    vehicle = bench.document.rig.vehicle.replace(body=f"/nowhere/{LONG}/{LONG}.glb")
    bench.document.apply(bench.document.rig.replace(vehicle=vehicle))
    assert inspector.form.minimumSizeHint().width() <= room_px
