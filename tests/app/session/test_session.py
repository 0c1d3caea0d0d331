"""The session says what is asked: each change is told once, by what changed, and the request is what was set."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from riglens.app.session.document import Document
from riglens.app.session.result_store import ResultStore
from riglens.app.session.session import HeatChoice, Session
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import Vehicle
from riglens.core.rig.presets import preset
from riglens.core.scene.grid import VoxelGrid
from tests.app.window.desk import FakeRecompute, loaded, open_desk
from tests.app.window_bench import LIDAR, RIG

pytestmark = pytest.mark.usefixtures("qapp")
SIGNALS = (
    "settings_changed", "heat_changed", "baseline_changed", "voxel_changed", "scene_changed",
    "request_changed",
)  # fmt: skip
OTHER = RIG.replace(name="other")
POSE = Pose((0.1, 0.2, 2.5), LIDAR.rpy_deg)


@pytest.fixture
def session() -> Session:
    return Session(Document(RIG), MetricSettings())


def heard(session: Session) -> list[str]:
    """The names of the session's signals in the order in which they come from now on."""
    told: list[str] = []
    for name in SIGNALS:
        getattr(session, name).connect(lambda *_, name=name: told.append(name))
    return told


@pytest.mark.parametrize(
    ("setter", "value", "expected"),
    [
        ("set_settings", MetricSettings("exact", "residual", 0.5), ["settings_changed", "request_changed"]),
        ("set_heat", HeatChoice("entropy", "bicycle"), ["heat_changed", "request_changed"]),
        ("pin", OTHER, ["baseline_changed", "request_changed"]),
        ("pick", (1, 2, 3), ["voxel_changed", "request_changed"]),
        ("look_at_map", "lidar", ["request_changed"]),
    ],
)
def test_a_change_is_told_once_and_the_same_value_not_at_all(
    session: Session, setter: str, value: Any, expected: list[str]
) -> None:
    told = heard(session)
    getattr(session, setter)(value)
    assert told == expected
    getattr(session, setter)(value)
    assert told == expected


def test_the_first_values_are_no_change(session: Session) -> None:
    told = heard(session)
    session.set_settings(MetricSettings())
    session.set_heat(HeatChoice())
    session.pin(None)
    session.pick(None)
    session.look_at_map(None)
    assert told == []


def test_the_request_is_what_was_set(session: Session) -> None:
    session.set_settings(MetricSettings("exact", "hits", 0.2))
    session.set_heat(HeatChoice("unseen", "pedestrian"))
    session.pin(OTHER)
    session.pick((4, 5, 6))
    session.look_at_map("camera")
    session.document.begin_drag(("roof",))
    session.document.preview({"roof": POSE})
    request = session.request()
    assert request.rig is session.document.rig and request.revision == session.document.revision
    assert request.rig.sensor("roof").pose == POSE and request.is_preview
    assert request.baseline_rig is OTHER
    assert request.settings == MetricSettings("exact", "hits", 0.2, body=None)
    assert (request.heat, request.heat_class) == ("unseen", "pedestrian")
    assert (request.voxel, request.map_by) == ((4, 5, 6), "camera")


def test_blind_zones_are_asked_for_while_they_are_wanted(session: Session) -> None:
    told = heard(session)
    for is_wanted, asked in ((False, 0), (True, 1), (True, 1), (False, 1), (True, 2)):
        session.look_around(is_wanted)
        assert told == ["request_changed"] * asked and session.request().blind is is_wanted


def test_nobody_looks_at_the_map_any_more_asks_for_no_new_answer(session: Session) -> None:
    session.look_at_map("any")
    told = heard(session)
    session.look_at_map(None)
    assert told == [] and session.request().map_by is None


def test_saving_makes_another_baseline_unless_one_is_pinned(session: Session, tmp_path: Path) -> None:
    session.document.set_enabled(("roof",), False)
    told = heard(session)
    session.document.save(tmp_path / "rig.yaml")
    assert told == ["baseline_changed", "request_changed"] and session.baseline is session.document.rig
    session.document.save(tmp_path / "copy.yaml")
    assert told == ["baseline_changed", "request_changed"]
    session.pin(OTHER)
    session.document.set_enabled(("roof",), True)
    told.clear()
    session.document.save(tmp_path / "rig.yaml")
    assert told == [] and session.baseline is OTHER


def test_a_voxel_is_forgotten_with_its_grid_only(session: Session) -> None:
    first, same, other = loaded(), loaded(), loaded(VoxelGrid(1.0, (20.0, 20.0, 4.0)))
    session.show_scene(first)
    session.pick((1, 1, 1))
    told = heard(session)
    session.show_scene(same)
    assert session.voxel == (1, 1, 1) and told == ["scene_changed"]
    session.show_scene(other)
    assert session.voxel is None and session.scene is other
    assert told[1:] == ["voxel_changed", "request_changed", "scene_changed"]


# ---------------------------------------------------------------------- what was answered
def test_the_same_is_not_asked_twice_and_nothing_before_the_first_time(session: Session) -> None:
    recompute = FakeRecompute()
    answers = ResultStore(session, recompute)
    session.pick((1, 1, 1))
    assert recompute.requests == []
    answers.ask()
    answers.ask()
    session.pick((2, 2, 2))
    assert [request.voxel for request in recompute.requests] == [(1, 1, 1), (2, 2, 2)]


def test_an_answer_is_current_until_something_else_is_asked_or_other_traffic_is_there(
    qtbot: QtBot,
) -> None:
    desk = open_desk(qtbot)
    answers = desk.workbench.answers
    desk.load()
    answers.ask()
    assert not answers.is_current
    desk.answer()
    assert answers.is_current
    desk.session.set_heat(HeatChoice("entropy"))
    assert not answers.is_current
    desk.answer()
    assert answers.is_current
    desk.load()
    assert not answers.is_current


def test_an_answer_older_than_the_one_shown_is_dropped(qtbot: QtBot) -> None:
    desk = open_desk(qtbot)
    answers, told = desk.workbench.answers, []
    answers.answered.connect(told.append)
    desk.load()
    answers.ask()
    old = desk.result()
    desk.document.set_enabled(("roof",), False)
    new = desk.answer()
    answers.take(old)
    assert told == [new] and answers.result is new


def test_the_session_imports_no_widgets() -> None:
    folder = Path(__file__).resolve().parents[3] / "app" / "session"
    files = sorted(folder.glob("*.py"))
    assert any(path.name == "session.py" for path in files)
    imported = {
        node.module
        for path in files
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom)
    }
    assert "PySide6.QtCore" in imported
    assert not {"PySide6.QtWidgets", "PySide6.QtGui"} & imported


def test_the_body_is_that_of_the_rig_unless_another_is_said_for_all() -> None:
    session = Session(Document(preset("W+T")), MetricSettings())
    told: list[str] = []
    session.settings_changed.connect(lambda: told.append(session.body))
    assert session.body == "ignored" and session.settings.body is None
    session.document.apply(session.document.rig.replace(name="edited"))
    assert session.body == "ignored", "an edit does not switch what is counted"
    session.set_body("blocks")
    assert session.request().settings.body == "blocks"
    session.set_settings(MetricSettings("exact", "hits", 0.2))
    assert session.settings == MetricSettings("exact", "hits", 0.2, "blocks")
    session.set_body(None)
    assert told == ["blocks", "blocks", "ignored"]
    session.document.apply(session.document.rig.replace(self_occlusion=True))
    session.document.undo()
    assert told[3:] == ["blocks", "ignored"]
    assert Session(Document(RIG), MetricSettings()).body == "blocks"


def test_a_body_in_a_file_is_ignored_until_its_mesh_has_been_read() -> None:
    session = Session(Document(RIG.replace(vehicle=Vehicle(body="car.glb"))), MetricSettings())
    assert (session.body_wanted, session.body) == ("blocks", "ignored")
    points = np.zeros((3, 3), np.float32)
    mesh = BodyMesh(points, points, np.array([[0, 1, 2]], np.int32))
    asked = list[str]()
    session.request_changed.connect(lambda: asked.append(session.body))
    session.take_mesh("other.glb", mesh)
    assert session.body == "ignored" and session.request().rig.vehicle.lacks_mesh and asked == []
    session.take_mesh("car.glb", mesh)
    assert session.body == "blocks" and session.request().rig.vehicle.body_mesh is mesh
    assert asked == ["blocks"], "and the rig is scored with it"
