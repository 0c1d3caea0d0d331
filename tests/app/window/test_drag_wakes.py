"""One move of a drag wakes what it changes and nothing else: the slots are named here, one by one."""

from __future__ import annotations

from pathlib import Path

from pytestqt.qtbot import QtBot

from riglens.core.geometry import Pose
from tests.app.slots import woken
from tests.app.window_bench import LIDAR, open_bench

ALWAYS = {
    "OpenRig.preview": "the rig moves",
    "Session._emit_body": "the rig may have another body",
    "ResultStore._ask_again": "scores are asked for",
    "ScoresShown._show_waiting": "those shown are greyed",
    "Follow._follow": "view, list and inspector show the pose",
    "Marginals._on_rig": "losses of the rig before are void",
    "Targets._ask": "points on road users are asked for",
    "Standing._ask": "how high sensors float is asked for",
}
"""What a move of the mouse wakes, and why."""
PAINTED = "FigureTable.dataChanged"
"""Told by each table whose cells look different, which paints them."""
IN_SIGHT = {"Map._follow_rig", "SensorView._ask"}
"""What it wakes besides while the map and the sensor view are in sight."""


def move(bench, z_m: float) -> set[str]:
    """The slots that one more move of the drag wakes; each once."""
    with woken() as found:
        bench.viewport.drag_to("roof", Pose((0.1, 0.2, z_m), LIDAR.rpy_deg))
    slots = {name: times for name, times in found.slots.items() if name != PAINTED}
    assert set(slots.values()) == {1}, slots
    return set(slots)


def test_a_drag_wakes_what_it_changes_and_nothing_else(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.document.select("roof")
        bench.viewport.press("roof")
        first = move(bench, 2.0)
        assert first - set(ALWAYS) == {"Edits._update", "Files._update_title", "Autosave._on_change"}
        assert move(bench, 2.1) == set(ALWAYS)
        bench.settle()
        assert move(bench, 2.2) == set(ALWAYS)
        for title in ("Map", "Sensor view"):
            bench.workbench.docks[title].setFloating(True)
            bench.workbench.docks[title].show()
        qtbot.waitUntil(
            lambda: bool(bench.features.map.in_sight) and bool(bench.features.sensor_view.in_sight)
        )
        assert move(bench, 2.3) == set(ALWAYS) | IN_SIGHT
        bench.viewport.release("roof")
        bench.settle()
