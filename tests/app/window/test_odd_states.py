"""Odd states of the window: each says in words what is the matter, and shows no empty or wrong figure."""

import threading
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QWidget
from pytestqt.qtbot import QtBot

import riglens.evaluation.scoring
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.view.top_view import BLIND
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import Scenario
from tests.app.window.desk import FullDesk
from tests.app.window_bench import CAMERA, LIDAR, RIG, Bench, open_bench, scene_options
from tests.waiting import TIMEOUT_MS
from tests.widgets.mouse import hover

CARS = """seq,frame,cls,x,y,z,length,width,height,yaw
s,0,car,6,0,0.8,4.5,1.9,1.6,0.3
s,1,car,-6,3,0.8,4.5,1.9,1.6,0
"""


def raise_dock(bench: Bench, name: str) -> None:
    bench.workbench.docks[name].show()
    bench.workbench.docks[name].raise_()
    bench.qtbot.waitUntil(lambda: bench.workbench.docks[name].widget().isVisible(), timeout=TIMEOUT_MS)


def map_message(bench: Bench) -> str:
    """What the map says once it is up to date."""
    raise_dock(bench, "Map")
    bench.settle()
    return bench.features.map.panel.map.message


def sensor_text(bench: Bench) -> str:
    """What the sensor view says in place of a picture."""
    raise_dock(bench, "Sensor view")
    panel = bench.features.sensor_view.panel
    assert panel.page is panel.text
    return panel.text.text()


def test_without_sensors_all_is_blind_and_the_sensor_view_says_what_to_do(
    qtbot: QtBot, tmp_path: Path
) -> None:
    with open_bench(qtbot, tmp_path, rig=Rig(name="empty")) as bench:
        assert map_message(bench) == "No sensor is enabled: everything is blind"
        top = bench.features.map.panel.map._top
        assert top is not None and set(top.levels[top.levels > 0]) == {BLIND}
        assert sensor_text(bench) == "The rig has no sensors: add one to see its view here"
        assert bench.fresh_scores(bench.document.rig).classes["car"].any_seen == 0.0


def test_without_a_selection_the_sensor_view_asks_for_one(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        assert sensor_text(bench) == "Select a sensor to see its view"
        bench.document.select("front")
        panel = bench.features.sensor_view.panel
        qtbot.waitUntil(lambda: panel.page is panel.camera, timeout=TIMEOUT_MS)
        bench.document.delete("front")
        assert sensor_text(bench) == "Select a sensor to see its view"


def test_without_box_data_nothing_pretends_to_be_on_its_way(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, wait=False, boxes=tmp_path / "nowhere.csv") as bench:
        qtbot.waitUntil(lambda: not bench.workbench.errors.isHidden(), timeout=TIMEOUT_MS)
        raise_dock(bench, "Map")
        assert bench.features.map.panel.map.message.startswith("No box data are loaded")
        bench.document.select("front")
        assert sensor_text(bench).startswith("No box data are loaded")
        assert bench.workbench.status.state.text() == "no box data, no scores"
        bench.drag("front", (0.5, 0.0, 1.5))
        assert bench.workbench.status.state.text() == "no box data, no scores"
        assert bench.shown("car", "seen") == "—"
        (tmp_path / "nowhere.csv").write_text(CARS, encoding="utf-8")
        load = bench.panels.scene.findChild(QPushButton, "load")
        assert load is not None and load.isEnabled()
        load.click()
        bench.settle()
        assert bench.workbench.status.state.text() == "exact"


def test_while_the_first_data_are_loaded_the_docks_say_so(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate, load = threading.Event(), riglens.evaluation.scoring.load_scenario

    def load_later(options: SceneOptions, progress: Progress) -> Scenario:
        gate.wait()
        return load(options, progress)

    monkeypatch.setattr(riglens.evaluation.scoring, "load_scenario", load_later)
    with open_bench(qtbot, tmp_path, wait=False) as bench:
        bench.document.select("front")
        try:
            assert sensor_text(bench) == "Loading box data"
            assert bench.features.map.panel.map.message == "Loading box data"
        finally:
            gate.set()
        assert map_message(bench) == ""


def test_a_sensor_outside_the_roi_is_marked_at_the_edge_of_the_map(qtbot: QtBot, tmp_path: Path) -> None:
    away = LIDAR.replace(position=(40.0, 0.0, 2.0))
    with open_bench(qtbot, tmp_path, rig=RIG.replace(sensors=(away, CAMERA))) as bench:
        assert map_message(bench) == ""
        view = bench.features.map.panel.map
        assert view.readout().endswith("outside the ROI: roof")
        mark = QPoint(round(view.plane.area.center().x()), round(view.plane.area.top() + 8))
        hover(view, mark)
        assert view.readout().startswith("roof · outside the ROI")
        QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=mark)
        assert bench.document.selected == "roof"
        raise_dock(bench, "Sensor view")
        panel = bench.features.sensor_view.panel
        qtbot.waitUntil(lambda: panel.page is panel.ranges, timeout=TIMEOUT_MS)


def test_a_class_without_boxes_has_nothing_to_see_or_to_miss(qtbot: QtBot, tmp_path: Path) -> None:
    boxes = tmp_path / "cars.csv"
    boxes.write_text(CARS, encoding="utf-8")
    with open_bench(qtbot, tmp_path, boxes=boxes) as bench:
        bench.features.heat.set_class("pedestrian")
        assert map_message(bench) == "This data set has no pedestrians: nothing to see or to miss"
        assert bench.features.map.panel.map.readout() == ""
        bench.features.heat.set_class("car")
        assert map_message(bench) == ""


def test_with_every_sensor_switched_off_all_is_blind(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.document.set_enabled("roof", False)
        bench.document.set_enabled("front", False)
        assert map_message(bench) == "No sensor is enabled: everything is blind"
        bench.document.set_enabled("front", True)
        panel = bench.features.map.panel
        panel.choice.setCurrentIndex(1)
        panel.choice.activated.emit(1)
        assert map_message(bench) == "No LiDAR is enabled: everything is blind"


def test_sixty_sensors_are_all_on_map_and_list(qtbot: QtBot, tmp_path: Path) -> None:
    many = tuple(
        LIDAR.replace(name=f"s{n}", position=(-8.0 + 1.6 * (n % 10), -4.0 + 1.6 * (n // 10), 1.9))
        for n in range(60)
    )
    with open_bench(qtbot, tmp_path, rig=RIG.replace(sensors=many)) as bench:
        assert map_message(bench) == ""
        view = bench.features.map.panel.map
        for name in ("s0", "s37", "s59"):
            x, y, _ = bench.document.rig.sensor(name).position
            QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=view.plane.to_px(x, y).toPoint())
            assert bench.document.selected == name


@pytest.mark.parametrize("size", [(900, 600), (3840, 2160)])
def test_the_window_fits_small_and_large_screens(qtbot: QtBot, tmp_path: Path, size: tuple[int, int]) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.document.select("front")
        for dock in ("Map", "Sensor view", "Inspector"):
            raise_dock(bench, dock)
            bench.window.resize(*size)
            QApplication.processEvents()
            assert (bench.window.width(), bench.window.height()) == size, bench.window.minimumSizeHint()
            assert bench.viewport.width() >= 240, dock


def test_the_same_data_can_be_loaded_again_with_rigs_in_comparison(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.act("snapshot")
        bench.features.scene_data.load(scene_options(tmp_path))
        qtbot.waitUntil(lambda: len(bench.scenes) == 2, timeout=TIMEOUT_MS)
        bench.settle()
        rows = bench.features.compare
        qtbot.waitUntil(lambda: all(row.scores is not None for row in rows.rows), timeout=TIMEOUT_MS)


def test_no_text_of_the_window_holds_a_control_character_of_a_name(desk: FullDesk) -> None:
    name = "\fa\x1b[31m\u202e"
    desk.document.apply(RIG.replace(name="\x07rig").with_sensor(LIDAR.name, LIDAR.replace(name=name)))
    desk.document.select(name)
    desk.document.set_failed((name,), True)
    desk.document.delete(name)
    desk.document.undo()
    window = desk.workbench.window
    actions = window.findChildren(QAction)
    shown = [found.text() for found in (*window.findChildren(QLabel), *actions)]
    shown += [found.toolTip() for found in (*window.findChildren(QWidget), *actions)]
    shown.append(window.windowTitle())
    assert any("\\x0c" in text for text in shown)
    assert not [text for text in shown if any(sign in text for sign in "\f\x07\x1b\u202e")]
