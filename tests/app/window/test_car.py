"""The car and what is put on it, in the window: mirror pairs, placing, drops, nudges, bodies and mesh files."""

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton

from riglens.app.window.features.car import STAND_IN
from riglens.core.geometry import Pose
from riglens.core.rig.edits import mirrored_pose, partner_of
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.rig.yaml.file import load_rig
from riglens.core.vehicle.profile import reference_vehicle
from tests.app.window.desk import FullDesk
from tests.app.window_bench import LIDAR
from tests.waiting import TIMEOUT_MS


@pytest.fixture
def bench(file_desk):
    file_desk.start_over(file_desk.features)
    file_desk.document.select("roof")
    return file_desk


def names(bench: FullDesk) -> list[str]:
    return [sensor.name for sensor in bench.document.rig.sensors]


def pose(bench: FullDesk, name: str) -> Pose:
    return bench.document.rig.sensor(name).pose


def test_unlinked_sensors_move_alone_and_linking_brings_the_nearest_back(bench):
    bench.act("mirror")
    bench.document.select("roof")
    assert bench.workbench.actions["unlink"].isEnabled() and not bench.workbench.actions["mirror"].isEnabled()
    bench.act("unlink")
    bench.drag("roof", (0.5, 0.7, 2.1))
    assert pose(bench, "roof_right") == mirrored_pose(LIDAR.pose)
    bench.act("link")
    assert partner_of(bench.document.rig, "roof") == "roof_right"
    assert pose(bench, "roof_right").position_m == (0.5, -0.7, 2.1)


def test_place_on_body_starts_in_the_view_with_a_hint_and_ends_with_it(bench):
    bench.act("place")
    assert ("place",) in bench.viewport.told
    assert "Click on the car" in bench.workbench.status.currentMessage()
    bench.viewport.placing_changed.emit(False)
    assert not bench.workbench.actions["place"].isChecked() and bench.workbench.status.currentMessage() == ""
    bench.act("hide")
    assert not bench.workbench.actions["place"].isEnabled()
    bench.act("hide")
    assert bench.workbench.actions["place"].isEnabled()
    bench.document.select(None)
    assert not bench.workbench.actions["place"].isEnabled()


def test_a_model_dropped_on_the_car_is_added_there_and_selected(bench):
    bench.viewport.model_dropped.emit("generic-16", Pose((0.1, 0.2, 1.5), (0.0, 1.0, 0.0)))
    added = bench.document.selected_sensor()
    assert (added.model, added.pose) == ("generic-16", Pose((0.1, 0.2, 1.5), (0.0, 1.0, 0.0)))
    bench.act("undo")
    assert names(bench) == ["roof", "front"]


def test_the_body_is_switched_in_the_rig_and_a_mode_for_all_rigs_ends(bench):
    switch = bench.workbench.actions["solid_car"]
    for is_solid in (False, True):
        bench.act("solid_car")
        assert bench.document.rig.self_occlusion == switch.isChecked() == is_solid
    bench.session.set_body("ignored")
    bench.act("solid_car")
    assert bench.session.body_wanted == "blocks" and bench.document.rig.self_occlusion and switch.isChecked()


def test_another_body_brings_its_own_size_but_keeps_what_was_measured(bench):
    bench.document.select(None)
    bench.type("width", "1.8")
    bench.choose("body", "truck")
    expected = reference_vehicle("truck").replace(width=1.8)
    assert bench.document.rig.vehicle == expected
    assert vehicles_shown(bench)[-1] == (expected, None)


TETRAHEDRON = "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def vehicles_shown(bench: FullDesk) -> list[tuple]:
    return [(vehicle, vehicle.body_mesh) for (vehicle,) in bench.viewport.values("vehicle")]


def test_a_mesh_file_chosen_in_the_inspector_becomes_the_body_named_from_the_rigs_folder(bench, tmp_path):
    bench.document.save(tmp_path / "rig.yaml")
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "car.obj").write_text(TETRAHEDRON, encoding="utf-8")
    bench.document.select(None)
    bench.dialogs.path = tmp_path / "meshes" / "car.obj"
    bench.qtbot.mouseClick(bench.find("mesh"), Qt.MouseButton.LeftButton)
    assert bench.document.rig.vehicle.body == "meshes/car.obj"
    bench.qtbot.waitUntil(lambda: vehicles_shown(bench)[-1][1] is not None, timeout=TIMEOUT_MS)
    assert vehicles_shown(bench)[-1][1].triangles.shape == (4, 3)
    bench.type("scale", "0.5")
    vehicle, mesh = vehicles_shown(bench)[-1]
    assert vehicle.mesh.scale == 0.5 and mesh is vehicles_shown(bench)[-2][1]


def test_a_rig_saved_elsewhere_goes_on_finding_its_mesh(bench, tmp_path):
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
    (tmp_path / "here" / "car.obj").write_text(TETRAHEDRON, encoding="utf-8")
    bench.document.save(tmp_path / "here" / "rig.yaml")
    bench.features.car.take_mesh(tmp_path / "here" / "car.obj")
    assert bench.document.rig.vehicle.body == "car.obj"
    bench.dialogs.path = tmp_path / "here" / "copy.yaml"
    bench.act("save_as")
    assert bench.document.rig.vehicle.body == "car.obj"
    bench.dialogs.path = tmp_path / "there" / "rig.yaml"
    bench.act("save_as")
    assert load_rig(bench.dialogs.path).rig.vehicle.body == (tmp_path / "here" / "car.obj").as_posix()
    bench.qtbot.waitUntil(lambda: not bench.workbench.tasks._running, timeout=TIMEOUT_MS)
    QApplication.processEvents()
    assert bench.workbench.errors.isHidden()


def test_a_mesh_that_cannot_be_read_is_reported_and_a_box_stands_in_for_it(bench, tmp_path):
    bad = tmp_path / "bad.glb"
    bad.write_bytes(b"glTF" + bytes(40))
    rig = bench.document.rig
    bench.document.apply(rig.replace(vehicle=rig.vehicle.replace(body=str(bad))))
    bench.qtbot.waitUntil(lambda: "bad.glb" in bench.workbench.errors.message, timeout=TIMEOUT_MS)
    QApplication.processEvents()
    vehicle, mesh = vehicles_shown(bench)[-1]
    assert (vehicle.body, mesh) == (str(bad), None)
    bench.document.select(None)
    bench.qtbot.waitUntil(lambda: bench.find("mesh_size").text() == STAND_IN, timeout=TIMEOUT_MS)
    assert not bench.find("mesh_fit").isEnabled()
    bench.type("length", "5")
    assert vehicles_shown(bench)[-1][0].length == 5.0
    bench.act("undo")
    bench.act("undo")
    assert vehicles_shown(bench)[-1] == (rig.vehicle, None)


def test_the_car_of_the_rig_before_is_gone_at_once_when_a_mesh_is_read_or_missing(bench, tmp_path):
    (tmp_path / "good.obj").write_text(TETRAHEDRON, encoding="utf-8")
    bench.features.car.take_mesh(tmp_path / "good.obj")
    bench.qtbot.waitUntil(lambda: vehicles_shown(bench)[-1][1] is not None, timeout=TIMEOUT_MS)
    other = Rig(name="other", vehicle=Vehicle(body=str(tmp_path / "none.glb"), length=5.2))
    bench.document.show(other, None)
    assert vehicles_shown(bench)[-1] == (other.vehicle, None)
    bench.qtbot.waitUntil(lambda: "no such file" in bench.workbench.errors.message, timeout=TIMEOUT_MS)
    assert vehicles_shown(bench)[-1] == (other.vehicle, None)


def mesh_in_millimetres(bench: FullDesk, tmp_path: Path) -> None:
    """Choose a mesh of 2 × 1 × 1 m whose file says 2000 for its length."""
    (tmp_path / "car.obj").write_text(TETRAHEDRON.replace("v 2 0 0", "v 2000 0 0"), encoding="utf-8")
    bench.features.car.take_mesh(tmp_path / "car.obj")
    bench.qtbot.waitUntil(lambda: "Which unit" in bench.workbench.notes.message, timeout=TIMEOUT_MS)
    bench.document.select(None)


def test_the_unit_is_asked_for_when_the_car_would_be_a_giant(bench, tmp_path):
    mesh_in_millimetres(bench, tmp_path)
    assert "2,000.00 × 1.00 × " in bench.workbench.notes.message
    bench.qtbot.mouseClick(
        bench.workbench.notes.findChild(QPushButton, "Millimetres: 2.00 m"), Qt.MouseButton.LeftButton
    )
    assert bench.document.rig.vehicle.mesh.scale == 0.001
    assert bench.find("mesh_size").text().startswith("2.00 × ")
    assert bench.workbench.notes.isHidden()
    bench.act("undo")
    assert bench.document.rig.vehicle.mesh.scale == 1.0


def test_a_mesh_is_fitted_to_the_length_of_the_vehicle(bench, tmp_path):
    mesh_in_millimetres(bench, tmp_path)
    bench.qtbot.mouseClick(bench.find("mesh_fit"), Qt.MouseButton.LeftButton)
    assert bench.document.rig.vehicle.mesh.scale == pytest.approx(4.6 / 2000)
    assert bench.find("mesh_size").text().startswith("4.60 × ")
    assert bench.workbench.notes.isHidden()


def test_the_question_goes_with_the_mesh_that_it_is_about(bench, tmp_path):
    mesh_in_millimetres(bench, tmp_path)
    bench.act("undo")
    assert not bench.document.rig.vehicle.has_mesh_file and bench.workbench.notes.isHidden()


def test_a_body_that_is_no_file_is_reported_with_what_is_accepted(bench, tmp_path: Path):
    rig = bench.document.rig
    bench.document.apply(rig.replace(vehicle=rig.vehicle.replace(body="hovercraft")))
    bench.qtbot.waitUntil(lambda: "sedan, suv" in bench.workbench.errors.message, timeout=TIMEOUT_MS)
