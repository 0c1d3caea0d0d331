"""Every sensor has a row for blocked sectors: none at first, and the left half when one is added."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Camera, Rig, Sensor
from riglens.core.sensors.base import HALVES
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.inspector.panel import Inspector


def test_sectors_are_added_edited_and_removed(qtbot: QtBot) -> None:
    inspector = Inspector()
    qtbot.addWidget(inspector)
    camera = Camera(name="c", position=(2.0, 0.0, 0.5), hfov_deg=90.0)
    inspector.set_rig(Rig(sensors=(camera,)), ("c",))
    edited = list[dict[str, Sensor]]()
    inspector.sensors_edited.connect(edited.append)
    box = inspector.form.findChild(QComboBox, "blocked.count")
    assert box is not None and box.currentText() == "none"
    box.activated.emit(1)
    dirty = edited[-1]["c"]
    assert dirty.blocked == (HALVES["left"],)
    inspector.set_rig(Rig(sensors=(dirty,)), ("c",))
    shown = [edit for edit in inspector.form.findChildren(NumberEdit) if edit.text() == "180"]
    (end,) = [edit for edit in shown if edit.isVisibleTo(inspector.form)]
    end.setText("40")
    end.textEdited.emit("40")
    end.setModified(True)
    qtbot.keyClick(end, Qt.Key.Key_Return)
    assert edited[-1]["c"].blocked[0].azimuth_deg == (0.0, 40.0)
    box.activated.emit(0)
    assert edited[-1]["c"].blocked == ()
