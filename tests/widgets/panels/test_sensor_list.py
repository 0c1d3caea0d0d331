"""The list of sensors: what a change of the rig repaints."""

from __future__ import annotations

from itertools import product

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QTreeWidget, QTreeWidgetItem
from pytestqt.qtbot import QtBot

from riglens.core.geometry import Pose
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.widgets.panels.controls.style import tones
from riglens.widgets.panels.sensors import tree as trees
from riglens.widgets.panels.sensors.rows import (
    EYE,
    FAILED,
    LOCK,
    LOSS,
    NAME,
    PROBLEM,
    TYPE,
    RowState,
    set_up_columns,
    short_type,
    show_sensor,
)
from riglens.widgets.panels.sensors.tree import TICK_PX, SensorTree

NOTHING: frozenset[str] = frozenset()


@pytest.fixture
def shown(qtbot: QtBot, monkeypatch: pytest.MonkeyPatch) -> tuple[SensorTree, list[str]]:
    """A list of W+T, and the names of the rows that are painted anew from now on."""
    made, painted = SensorTree(), list[str]()
    qtbot.addWidget(made)
    made.set_rig(preset("W+T"), NOTHING, ())
    paint = trees.show_sensor
    monkeypatch.setattr(
        trees,
        "show_sensor",
        lambda row, sensor, state: (painted.append(sensor.name), paint(row, sensor, state)),
    )
    return made, painted


def moved(rig: Rig, name: str) -> Rig:
    return rig.with_sensor(name, rig.sensor(name).with_pose(Pose((0.5, 0.1, 1.8), (0.0, 2.0, 5.0))))


def test_a_drag_repaints_no_row(shown: tuple[SensorTree, list[str]]) -> None:
    tree, painted = shown
    tree.set_rig(moved(preset("W+T"), "LIDAR_1"), NOTHING, ("LIDAR_1",))
    assert painted == []
    assert tree.chosen == ("LIDAR_1",)


def test_what_changed_is_repainted_and_nothing_else(shown: tuple[SensorTree, list[str]]) -> None:
    tree, painted = shown
    rig = preset("W+T")
    off = rig.with_sensor("LIDAR_2", rig.sensor("LIDAR_2").replace(enabled=False))
    tree.set_rig(off, NOTHING, ())
    tree.set_rig(off, frozenset({"CAM_BACK"}), ())
    tree.set_rig(off, frozenset({"CAM_BACK"}), (), frozenset({"LIDAR_3"}))
    assert painted == ["LIDAR_2", "CAM_BACK", "LIDAR_3"]


def test_sensors_that_change_places_are_all_repainted(shown: tuple[SensorTree, list[str]]) -> None:
    tree, painted = shown
    rig = preset("W+T")
    names = [sensor.name for sensor in rig.sensors]
    tree.set_rig(rig.replace(sensors=rig.sensors[1:]), NOTHING, ())
    assert painted == names[1:]
    tree.set_rig(rig, NOTHING, ())
    assert painted == names[1:] + names
    assert [tree._items[name].text(0) for name in names] == names


def test_a_narrow_list_gives_up_types_locks_and_bars_before_it_cuts_names(qtbot: QtBot) -> None:
    tree, rig = SensorTree(), preset("nuScenes car")
    qtbot.addWidget(tree)
    tree.show()
    longest = max(tree.fontMetrics().horizontalAdvance(sensor.name) for sensor in rig.sensors)
    hidden = []
    for width in (600, longest + 190, longest + 140):
        tree.resize(width, 300)
        tree.set_rig(rig, NOTHING, ())
        assert tree.columnWidth(NAME) >= longest + TICK_PX
        hidden.append([tree.isColumnHidden(column) for column in (TYPE, LOCK, LOSS)])
    assert hidden == [[False] * 3, [True, False, False], [True, True, False]]
    tree.set_rig(rig, NOTHING, (), frozenset({rig.sensors[0].name}))
    assert not tree.isColumnHidden(LOCK)  # one is locked, which must be seen


def test_control_characters_of_a_name_are_written_out(
    shown: tuple[SensorTree, list[str]], qtbot: QtBot
) -> None:
    tree, rig = shown[0], preset("W+T")
    name = "\f\x1b[31m\u202e"
    tree.set_rig(rig.with_sensor("LIDAR_1", rig.sensor("LIDAR_1").replace(name=name)), NOTHING, ())
    item, asked = tree._items[name], list[tuple[str, str]]()
    tree.renamed.connect(lambda *names: asked.append(names))
    assert item.text(NAME) == "\\x0c\\x1b[31m\\u202e"
    item.setText(NAME, f"{item.text(NAME)} ")  # as an editor that changed nothing but a blank
    assert item.text(NAME) == "\\x0c\\x1b[31m\\u202e" and not asked
    item.setText(NAME, "roof")
    assert asked == [(name, "roof")]


def test_the_heading_of_the_losses_is_whole_in_a_narrow_list(qtbot: QtBot) -> None:
    tree, rig = SensorTree(), preset("nuScenes car")
    qtbot.addWidget(tree)
    tree.show()
    tree.resize(150, 300)
    tree.set_rig(rig, NOTHING, ())
    heading = tree.headerItem().text(LOSS)
    assert tree.columnWidth(LOSS) > tree.header().fontMetrics().horizontalAdvance(heading)


@pytest.mark.parametrize("is_enabled", [True, False])
@pytest.mark.parametrize("is_failed", [True, False])
@pytest.mark.parametrize("is_hidden", [True, False])
@pytest.mark.parametrize("is_locked", [True, False])
def test_a_row_shows_every_state_of_a_sensor_whatever_it_showed_before(
    qtbot: QtBot, is_enabled: bool, is_failed: bool, is_hidden: bool, is_locked: bool
) -> None:
    tree, row = QTreeWidget(), QTreeWidgetItem()
    qtbot.addWidget(tree)
    set_up_columns(tree)
    tree.addTopLevelItem(row)
    sensor = preset("W+T").sensor("LIDAR_1")
    others = product((True, False), repeat=3)
    for was_hidden, was_locked, was_failed in others:
        before = RowState(was_hidden, was_locked, "LIDAR_2", "inside the car", was_failed)
        show_sensor(row, sensor.replace(enabled=not is_enabled), before)
        assert "LIDAR_2" in row.toolTip(NAME) and "Inside the car" in row.toolTip(NAME)
        assert row.data(NAME, PROBLEM) and not row.icon(NAME).isNull()
        show_sensor(
            row, sensor.replace(enabled=is_enabled), RowState(is_hidden, is_locked, None, "", is_failed)
        )
        assert bool(row.flags() & Qt.ItemFlag.ItemIsEditable) == (not is_locked)
        assert bool(row.flags() & Qt.ItemFlag.ItemIsUserCheckable) == (not is_locked)
        assert row.checkState(NAME) == (Qt.CheckState.Checked if is_enabled else Qt.CheckState.Unchecked)
        is_bright = is_enabled and not is_hidden and not is_failed
        colour = tones().text if is_bright else tones().muted
        assert row.foreground(NAME).color() == QColor(colour)
        assert row.font(NAME).strikeOut() == is_failed
        assert ("Locked:" in row.toolTip(LOCK)) == is_locked
        assert ("Hidden in the view" in row.toolTip(EYE)) == is_hidden
        assert row.icon(NAME).isNull() and not row.data(NAME, PROBLEM)
        assert "LIDAR_2" not in row.toolTip(NAME) and "nside the car" not in row.toolTip(NAME)
        assert row.text(LOSS) == (FAILED if is_failed and is_enabled else "")


def test_locks_eyes_and_changed_models_look_different(qtbot: QtBot) -> None:
    row, sensor = QTreeWidgetItem(), sensor_from_model("velodyne-vlp-16", "roof", Pose())
    for column, states in (
        (LOCK, (RowState(), RowState(is_locked=True))),
        (EYE, (RowState(), RowState(is_hidden=True))),
    ):
        pictures = []
        for state in states:
            show_sensor(row, sensor, state)
            pictures.append(row.icon(column).pixmap(16, 16).toImage())
        assert pictures[0] != pictures[1] and row.text(TYPE) == short_type(sensor)
    changed = sensor.replace(range_m=(1.0, 50.0))
    show_sensor(row, changed, RowState())
    assert row.text(TYPE) == f"{short_type(sensor)}*" and "range differ" in row.toolTip(TYPE).replace(
        "&nbsp;", " "
    )
