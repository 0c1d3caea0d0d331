"""The window shows what its session holds, whatever was there before, and every change reaches those who show it."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PySide6.QtCore import QAbstractItemModel, QAbstractListModel, QModelIndex, Qt
from PySide6.QtGui import QBrush
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QApplication,
    QComboBox,
    QLabel,
    QLineEdit,
    QProgressBar,
    QWidget,
)
from pytestqt.qtbot import QtBot

from riglens.app.session.session import HeatChoice
from riglens.app.window.features.car import READING
from riglens.core.figures.coverage import S_MS
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.rig.edits import with_enabled
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.lens import KannalaBrandt
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.widgets.panels.fields.edits import ValueEdit
from riglens.widgets.panels.sensors.rows import LOSS
from riglens.widgets.panels.sensors.tree import SensorTree
from tests.app.window.desk import full_desk, heatmap
from tests.app.window_bench import CAMERA, LIDAR, RIG, Bench, Hands, open_bench
from tests.waiting import TIMEOUT_MS

ROLES = (
    Qt.ItemDataRole.DisplayRole,
    Qt.ItemDataRole.CheckStateRole,
    Qt.ItemDataRole.ToolTipRole,
    Qt.ItemDataRole.ForegroundRole,
)


@dataclass(frozen=True)
class State:
    """Contents of a session."""

    rig: Rig = RIG
    selection: tuple[str, ...] = ()
    hidden: frozenset[str] = frozenset()
    locked: frozenset[str] = frozenset()
    failed: frozenset[str] = frozenset()
    settings: MetricSettings = PAPER_SETTINGS
    heat: HeatChoice = field(default_factory=HeatChoice)
    pinned: Rig | None = None
    voxel: tuple[int, int, int] | None = None

    def put(self, bench: Bench) -> None:
        """Bring the window there from wherever it is."""
        document, session = bench.document, bench.session
        document.set_locked(tuple(document.locked), False)
        document.apply(self.rig)
        everyone = {sensor.name for sensor in self.rig.sensors}
        for put, chosen in ((document.set_hidden, self.hidden), (document.set_failed, self.failed)):
            put(tuple(everyone - chosen), False)
            put(tuple(chosen), True)
        document.choose(self.selection)
        document.set_locked(tuple(self.locked), True)
        session.set_settings(self.settings)
        session.set_heat(self.heat)
        session.pin(self.pinned)
        session.pick(self.voxel)
        bench.settle()
        features, names = bench.features, {one.name for one in document.working_rig.sensors if one.enabled}
        bench.qtbot.waitUntil(lambda: set(features.marginals.losses) == names, timeout=TIMEOUT_MS)
        shown = bench.panels.inspector
        bench.qtbot.waitUntil(
            lambda: shown.findChild(QLabel, "mesh_size").text() != READING, timeout=TIMEOUT_MS
        )
        assert features.standing.worker.wait_until_idle()
        QApplication.processEvents()


def looks(bench: Hands) -> dict[str, Any]:
    """Everything that can be read in the docks, which actions can be chosen, and what the view shows.

    Objects are never counted here: when their page says that it waits is a matter of time.
    """
    found: dict[str, Any] = {}
    for dock in bench.workbench.docks:
        inside = dock.widget()
        if dock.objectName() == "Targets":
            continue
        for widget in inside.findChildren(QWidget):
            if widget.isVisibleTo(inside) and not widget.objectName().startswith("qt_"):
                found.setdefault(dock.objectName(), []).append(look_of(widget))
    for key, value in list(found.items()):
        found[key] = sorted(map(repr, value))
    for action in bench.workbench.actions:
        if action.objectName() not in ("undo", "redo"):
            found[f"action {action.objectName()}"] = (action.isEnabled(), action.isChecked())
    state = bench.viewport.state
    return found | {f"view {one.name}": plain(getattr(state, one.name)) for one in fields(state)}


def plain(value: Any) -> Any:
    """Something that can be compared: numbers of arrays, colours of brushes."""
    match value:
        case QBrush():
            return value.color().name()
        case np.ndarray():
            return value.tolist()
        case _ if is_dataclass(value) and not isinstance(value, type):
            return [plain(getattr(value, one.name)) for one in fields(value)]
        case dict():
            return {key: plain(one) for key, one in value.items()}
        case tuple() | list():
            return [plain(one) for one in value]
    return value


def look_of(widget: QWidget) -> tuple[Any, ...]:
    said: Any = None
    match widget:
        case QLabel() | QLineEdit():
            said = widget.text()
        case QAbstractButton():
            said = widget.text(), widget.isChecked()
        case QComboBox():
            said = widget.currentText()
        case QAbstractSlider() | QProgressBar():
            said = widget.value()
        case QAbstractItemView():
            said = cells(widget.model(), QModelIndex())
    return type(widget).__name__, widget.objectName(), widget.isEnabled(), widget.toolTip(), said


def cells(model: QAbstractItemModel, parent: QModelIndex) -> list[Any]:
    found: list[Any] = []
    columns = 1 if isinstance(model, QAbstractListModel) else model.columnCount(parent)
    for row in range(model.rowCount(parent)):
        for column in range(columns):
            index = model.index(row, column, parent)
            text, *others = [plain(index.data(role)) or "" for role in ROLES]
            found.append((text, others if text else others[:-1], index.flags().value))
        found.append(cells(model, model.index(row, 0, parent)))
    return found


MOVED = RIG.with_sensor("roof", LIDAR.replace(position=(0.5, 0.2, 1.7), rpy_deg=(1, 2, 3)))
SCAN = RadarScan(azimuth_deg=(-60.0, 60.0), elevation_deg=(-5.0, 5.0), range_m=100.0)
ALL_KINDS = RIG.replace(
    sensors=(
        LIDAR.replace(name="swung", range_m=(1, 50), rpy_deg=(0, 0, 90)),
        CAMERA.replace(
            name="eye", hfov_deg=None, fx=60, fy=60, cx=70, cy=45, distortion=KannalaBrandt(k1=0.01)
        ),
        Radar(name="radar", position=(2.3, 0, 0.5), scans=(SCAN,)),
        Ultrasonic(name="sonar", position=(2.3, 0.5, 0.5), wall_range_m=5.0),
    )
)
PAIR = RIG.replace(
    sensors=(
        CAMERA.replace(name="left", position=(1, 0.5, 1.4)),
        CAMERA.replace(name="right", position=(1, -0.5, 1.4), mirror_of="left"),
    )
)
ROOF = frozenset({"roof"})


def words(text: str) -> set[str]:
    return set(text.split())


CAR = words("body height housings length mesh rear_axle_x rig_name width")
ANGLES, PLACE = ({f"{name}.{n}" for n in range(3)} for name in ("rpy_deg", "position"))
SENSOR = (
    {"Field of view", "Rays"}
    | ANGLES
    | PLACE
    | words(
        "blocked.count copy_pose enabled model name paste_pose range_m.0 range_m.1 reset_pose unit_angle unit_length"
    )
)
LIDAR_ROWS = {"Azimuth offsets", "Resolution", "azimuth_offsets_deg.list", "rays.way"} | {
    f"{name}_deg.{part}" for name in ("azimuths", "elevations") for part in ("count", "from", "to", "way")
}
LENS = {
    "Car",
    "Distortion",
    "Focal length",
    "Lens",
    "Overlap",
    "Pedestrian",
    "Pixels tall at",
    "Resolution",
} | words("cast.0 cast.1 cast.way distortion.way image.0 image.1 lens.way")
SECTOR = {f"{name}_deg.{end}" for name in ("azimuth", "elevation") for end in range(2)} | {"step_deg"}
STRENGTHS = {f"cross_sections_dbsm.{n}" for n in range(len(CLASSES))} | {"reference_dbsm"}
RADAR_ROWS = (
    SECTOR | STRENGTHS | {"Longest range", "range_m", "resolution_deg", "resolution_m", "scans.count"}
)
FISHEYE = {f"distortion.KannalaBrandt.k{n}" for n in range(1, 5)} | {"cx", "cy", "fx", "fy"}
MESH = {f"offset.{n}" for n in range(3)} | {"mesh_fit", "mesh_size", "scale"} | ANGLES
READ = {"copy_pose", "unit_angle", "unit_length", "Azimuth offsets", "Field of view", "Rays", "Resolution"}
ONE = words("align_centre copy cut delete duplicate enable fail hide lock mirror place rename")
FREE = words("align_centre cut delete enable place rename")
ALIGNED = {f"align_{way}" for way in ("front", "height", "left", "rear", "right")}
SCORED = {"Compare", "Inspector", "Scores", "Sensors", "view heatmap", "view rig"}


class Row(NamedTuple):
    """A state, and what is other than where a rig was opened and nothing was chosen."""

    state: State
    changed: Set[str] = frozenset()
    """Some docks and fields of the view."""
    actions: Set[str] = frozenset()
    """All that can be chosen, or else cannot; ticked ones of a set."""
    rows: Set[str] = frozenset()
    """All inputs and figures of the inspector that came, or went."""
    disabled: Set[str] = frozenset()
    """Those that cannot be used."""


KINDS = SCORED - {"view heatmap"} | {"view masts", "view selected"}
STATES = {
    "moved": Row(State(rig=MOVED), SCORED | {"view masts"}),
    "LiDAR": Row(
        State(selection=("roof",)), {"Inspector", "view selected"}, ONE | {"improve"}, CAR | SENSOR | LIDAR_ROWS
    ),
    "camera": Row(
        State(selection=("front",)), {"Inspector", "view selected"}, ONE, CAR | SENSOR | LENS | {"hfov_deg"}
    ),
    "both": Row(
        State(selection=("roof", "front")), {"Inspector", "view also_selected"},
        ONE - {"place", "rename"} | ALIGNED, CAR | SENSOR | LENS | {"hfov_deg", "state"}, {"name", "paste_pose"},
    ),
    "hidden": Row(
        State(selection=("roof",), hidden=ROOF), {"Sensors", "view hidden"}, ONE - {"place"} | {"improve"},
        CAR | SENSOR | LIDAR_ROWS,
    ),
    "locked": Row(
        State(selection=("roof",), locked=ROOF), {"Sensors", "Inspector", "view fixed"}, ONE - FREE,
        CAR | SENSOR | LIDAR_ROWS | {"state"}, (SENSOR | LIDAR_ROWS) - READ,
    ),
    "failed": Row(
        State(selection=("roof",), failed=ROOF), SCORED - {"view rig"} | {"view failed"},
        ONE | {"improve", "restore_failed"}, CAR | SENSOR | LIDAR_ROWS,
    ),
    "disabled": Row(State(with_enabled(RIG, ("front",), False)), SCORED),
    "empty": Row(State(Rig(name="small")), SCORED | {"view masts"}, {"select_all"}, {"warning"}),
    "glass car": Row(State(RIG.replace(self_occlusion=False)), {"view rig", "view solid_body"}, {"solid_car"}),
    "long car": Row(State(RIG.replace(vehicle=Vehicle(length=5.2))), {"Inspector", "view vehicle", "view masts"}),
    "lost mesh": Row(
        State(RIG.replace(vehicle=Vehicle(body="no.ply"))), {"Sensors", "view vehicle", "view masts"},
        rows=MESH | {"warning"}, disabled={"mesh_fit"},
    ),
    "fisheye": Row(State(ALL_KINDS, ("eye",)), KINDS, ONE, CAR | SENSOR | LENS | FISHEYE),
    "radar": Row(State(ALL_KINDS, ("radar",)), KINDS, ONE, CAR | SENSOR | RADAR_ROWS),
    "ultrasonic": Row(
        State(ALL_KINDS, ("sonar",)), KINDS, ONE, CAR | SENSOR | SECTOR | {"Range", "pole_range_m", "wall_range_m"}
    ),
    "mirrored": Row(
        State(PAIR, ("right",)), KINDS, ONE - {"mirror"} | {"unlink"},
        CAR | SENSOR | LENS | {"hfov_deg", "unlink_pair"},
    ),
    "settings": Row(State(settings=MetricSettings(reading="residual", camera_weight=0.3)), {"Compare", "Scores"}),
    "heat": Row(
        State(heat=HeatChoice("seen", "bicycle")), {"Map", "view heatmap"},
        {"class_bicycle", "class_car", "heat_seen", "heat_unseen"},
    ),
    "no heat": Row(State(heat=HeatChoice("off")), {"view heatmap"}, {"heat_off", "heat_unseen"}),
    "pinned": Row(State(pinned=MOVED), {"Scores"}, {"unpin"}),
    "voxel": Row(State(voxel=(20, 20, 2)), {"view marker"}),
}  # fmt: skip


def rows_of(bench: Bench) -> dict[str, bool]:
    """The named inputs and figures that the inspector shows, and whether they can be used."""
    inspector = bench.panels.inspector
    shown = [
        one for one in inspector.findChildren(QWidget) if one.isVisibleTo(inspector) and one.objectName()
    ]
    return {key_of(one): one.isEnabled() for one in shown if not one.objectName().startswith("qt_")}


def key_of(widget: QWidget) -> str:
    """Return a key that identifies an input without its caption: items of a field by their index."""
    match widget:
        case ValueEdit(path=(*_, str(name), int(place))):
            return f"{name}.{place}"
    return widget.objectName()


def test_a_state_looks_the_same_whatever_came_before_and_reaches_all_that_shows_it(whole: Bench) -> None:
    found, rows = dict[str, dict[str, Any]](), dict[str, dict[str, bool]]()
    for name in ("opened", *STATES, *reversed(STATES), "opened"):
        (STATES[name].state if name in STATES else State()).put(whole)
        now = looks(whole)
        first = found.setdefault(name, now)
        rows[name] = rows_of(whole)
        assert wrong_values(whole) == {}, name
        assert other(first, now) == set(), name
    for name, row in STATES.items():
        changed = other(found["opened"], found[name])
        assert row.changed - changed == set(), name
        actions = {one.removeprefix("action ") for one in changed if one.startswith("action ")}
        assert actions == row.actions, name
        assert set(rows[name]) ^ set(rows["opened"]) == row.rows, name
        assert {key for key, is_usable in rows[name].items() if not is_usable} == row.disabled, name


def wrong_values(bench: Bench) -> dict[str, Any]:
    """The inputs of the inspector that show another value than that of the sensor or the car, with that value."""
    document, found = bench.document, {}
    subject = document.selected_sensor() or document.rig
    for edit in bench.panels.inspector.findChildren(ValueEdit):
        if edit.path is None or not edit.isVisibleTo(bench.panels.inspector) or len(document.selection) > 1:
            continue
        value: Any = subject
        for part in edit.path:
            value = value[part] if isinstance(part, int) else getattr(value, part)
        if edit.value != value:
            found[edit.objectName()] = (edit.value, value)
    return found


def other(one: Mapping[str, Any], another: Mapping[str, Any]) -> set[str]:
    return {key for key in one | another if one.get(key) != another.get(key)}


def test_another_rig_or_other_traffic_leaves_nothing_of_the_ones_before(qtbot: QtBot) -> None:
    """A desk that was used looks like a new one when another rig is scored, and shows no figure before."""
    with full_desk(qtbot) as used, full_desk(qtbot) as new:
        used.load()
        used.answer(0.9, heatmap=heatmap("of before"))
        used.session.pick((20, 20, 2))
        used.document.select("roof")
        used.document.set_failed(("front",), True)
        used.document.set_hidden(("roof",), True)
        used.document.set_locked(("front",), True)
        used.document.apply(MOVED)
        used.answer(0.8)
        scene = new.load()
        used.session.show_scene(scene)
        new.answer()
        for desk in (used, new):
            desk.session.pick(None)
            desk.document.show(PAIR)
        table = used.panels.scores.table
        assert not any(char.isdigit() for char in repr([table.cell(name, S_MS.key).text for name in CLASSES]))
        for desk in (used, new):
            desk.answer()
        assert other(looks(used), looks(new)) == set()


def test_another_rig_shows_no_figure_of_the_one_before_although_names_are_the_same(
    qtbot: QtBot, tmp_path: Path
) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.features.marginals.choose(S_MS.key)
        State(selection=("roof",)).put(bench)
        assert bench.viewport.state.masts and losses_in(bench.panels.tree) != {""}
        bench.document.show(MOVED)
        assert not bench.viewport.state.masts and losses_in(bench.panels.tree) == {""}


def losses_in(tree: SensorTree) -> set[str]:
    return {tree._items[name].text(LOSS) for name in ("roof", "front")}
