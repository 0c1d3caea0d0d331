"""The form of a radar: as many scans as it has, each with the fields of its own."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.inspector.panel import Inspector

FAR = RadarScan(azimuth_deg=(-9.0, 9.0), elevation_deg=(-7.0, 7.0), range_m=200.0)
NEAR = RadarScan(azimuth_deg=(-60.0, 60.0), elevation_deg=(-10.0, 10.0), range_m=50.0)


@pytest.fixture
def inspector(qtbot: QtBot) -> Inspector:
    inspector = Inspector()
    qtbot.addWidget(inspector)
    inspector.set_rig(Rig(sensors=(Radar(name="r", position=(2.0, 0.0, 0.5), scans=(FAR, NEAR)),)), ("r",))
    return inspector


def shown_ranges(inspector: Inspector) -> list[str]:
    edits = inspector.form.findChildren(NumberEdit, "range_m")
    return [edit.text() for edit in edits if edit.isVisibleTo(inspector.form) and edit.text()]


def test_every_scan_has_its_rows(inspector: Inspector) -> None:
    assert shown_ranges(inspector) == ["200", "50"]


def test_the_number_of_scans_is_chosen(inspector: Inspector, qtbot: QtBot) -> None:
    edited = list[dict[str, Sensor]]()
    inspector.sensors_edited.connect(edited.append)
    box = inspector.form.findChild(QComboBox, "scans.count")
    assert box is not None and box.currentText() == "2"
    box.activated.emit(2)
    box.activated.emit(0)
    more, fewer = (one["r"] for one in edited)
    assert isinstance(more, Radar) and more.scans == (FAR, NEAR, NEAR)
    assert isinstance(fewer, Radar) and fewer.scans == (FAR,)


def test_a_field_of_one_scan_is_edited_alone(inspector: Inspector, qtbot: QtBot) -> None:
    edited = list[dict[str, Sensor]]()
    inspector.sensors_edited.connect(edited.append)
    (near,) = (edit for edit in inspector.form.findChildren(NumberEdit, "range_m") if edit.text() == "50")
    near.setText("60")
    near.textEdited.emit("60")
    near.setModified(True)
    qtbot.keyClick(near, Qt.Key.Key_Return)
    changed = edited[0]["r"]
    assert isinstance(changed, Radar) and changed.scans == (FAR, NEAR.replace(range_m=60.0))
