"""The list of sensors: what a change of the rig repaints."""

from __future__ import annotations

import pytest
from pytestqt.qtbot import QtBot

from riglens.core.geometry import Pose
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.widgets.panels.sensors import tree as trees
from riglens.widgets.panels.sensors.rows import LOCK, LOSS, NAME, TYPE
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
