"""Sweep this field: an entry where it makes sense, a curve that follows the latest field, a value by a click."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QWidget

from riglens.app.background.field_sweep import Curve
from riglens.app.window.features.sweep_field import ENTRY, SweepField
from riglens.core.scene.boxes import CLASSES
from riglens.core.sweep.curve import CurvePoint
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.fields.quantity import METRES
from riglens.widgets.panels.inspector.field_curve import FieldCurve
from tests.app.window.desk import FakeWorker


@pytest.fixture
def desk(followed):
    return followed


@pytest.fixture
def targets():
    """A feature that has counted."""
    return SimpleNamespace(answer_on_scene=SimpleNamespace(traffic=SimpleNamespace(frames=2500)))


@pytest.fixture
def feature(desk, targets):
    desk.workbench.window.show()
    return SweepField(desk.workbench, targets, FakeWorker())


def field(desk, name) -> NumberEdit:
    """A number field of the sensor that is selected."""
    found = desk.workbench.panels.inspector.form.findChild(NumberEdit, name)
    assert found is not None
    return found


def entry(feature, edit):
    (found,) = (action for action in feature.menu_of(edit).actions() if action.text() == ENTRY)
    return found


def points(*values):
    return tuple(
        CurvePoint(v, {name: (0.01 * v * (n + 1), 0.002) for n, name in enumerate(CLASSES)}) for v in values
    )


def test_a_click_on_a_point_sets_the_value_in_one_step(desk, feature):
    document = desk.session.document
    name = document.rig.sensors[0].name
    document.select(name)
    edit = field(desk, "z")
    entry(feature, edit).trigger()
    (request,) = feature.maker.requests
    assert request.field.sensor == name and request.field.path == ("position", 2)
    assert feature.curve.isVisible()
    known = points(1.0, 1.5, 2.0)
    feature._take(request, Curve(known[:2]))
    feature._take(request, Curve(known, True))
    before = document.rig
    QTest.mouseClick(feature.curve, Qt.MouseButton.LeftButton, pos=feature.curve.place_of(1).toPoint())
    assert document.rig.sensor(name).position[2] == 1.5 and not feature.curve.isVisible()
    assert len(feature.maker.dropped) == 1
    document.undo()
    assert document.rig == before


def test_only_the_latest_field_is_shown(desk, feature):
    document = desk.session.document
    document.select(document.rig.sensors[0].name)
    feature.sweep(field(desk, "z"))
    feature.sweep(field(desk, "yaw"))
    first, second = feature.maker.requests
    feature._take(first, Curve(points(1.0, 2.0)))
    assert feature.curve.note == "computing"
    feature._take(second, Curve(points(1.0, 2.0)))
    assert "on target" in feature.curve.note and second.field.path == ("rpy_deg", 2)


def test_there_is_no_sweep_without_a_value_or_objects(desk, feature, targets):
    document = desk.session.document
    names = [sensor.name for sensor in document.rig.sensors]
    document.select(names[0])
    edit = field(desk, "z")
    assert entry(feature, edit).isEnabled()
    known, targets.answer_on_scene = targets.answer_on_scene, None
    assert not entry(feature, edit).isEnabled()
    targets.answer_on_scene = known
    edit.setEnabled(False)  # as of a sensor that is locked
    assert not entry(feature, edit).isEnabled()
    edit.setEnabled(True)
    document.choose(tuple(names[:2]))
    assert not entry(feature, field(desk, "z")).isEnabled()
    document.select(names[0])
    inspector = desk.workbench.panels.inspector
    hidden = [one for one in inspector.findChildren(NumberEdit) if not one.isVisibleTo(inspector)]
    assert hidden and not any(entry(feature, one).isEnabled() for one in hidden)


def test_the_keys_move_along_the_curve(qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    parent.show()
    curve, chosen = FieldCurve(parent), []
    curve.chosen.connect(chosen.append)
    parent.setGeometry(40, 60, 100, 20)
    curve.open_at(parent, "top: z", 1.5, METRES)
    assert curve.x() == parent.x() and 0 <= curve.y() - parent.geometry().bottom() < 10, "under the field"
    curve.show_points(points(1.0, 1.5, 2.0), "done")
    QTest.keyClick(curve, Qt.Key.Key_Right)
    assert curve.note.startswith("2") and "car +2.0" in curve.note
    QTest.keyClick(curve, Qt.Key.Key_Return)
    assert chosen == [2.0] and not curve.isVisible()
    curve.open_at(parent, "top: z", 1.5, METRES)
    QTest.keyClick(curve, Qt.Key.Key_Escape)
    assert not curve.isVisible() and chosen == [2.0]
