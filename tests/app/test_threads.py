"""Threads of the window: parallel kernels run on one of them only, and none holds up the end."""

from __future__ import annotations

import importlib
import pkgutil
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.registry import CPUDispatcher
from pytestqt.qtbot import QtBot

import riglens.app.background.pictures
import riglens.core.kernels
from riglens.app.background.counting import make_counter
from riglens.app.background.pictures import PictureRequest, SensorPicture, make_pictures
from riglens.app.background.tasks import Tasks
from riglens.core.figures.registry import voxel_heat_maps
from riglens.core.in_threads import HELPER
from riglens.core.rig.model import Vehicle
from riglens.core.targets.detection_range import RangePlan
from riglens.core.vehicle.solid import Solid
from riglens.evaluation.scoring import LoadedScene, load_scene
from tests.app.window_bench import CAMERA, open_bench, scene_options
from tests.waiting import TIMEOUT_MS, TIMEOUT_S

MODES = tuple(heat.key for heat in voxel_heat_maps())


def all_kernels() -> dict[tuple[str, str], CPUDispatcher]:
    """Compiled functions by the module that names them and by their name, of all modules that may call some."""
    for found in pkgutil.walk_packages(riglens.core.kernels.__path__, "riglens.core.kernels."):
        importlib.import_module(found.name)
    importlib.import_module("riglens.evaluation.scoring")
    return {
        (module_name, name): value
        for module_name, module in list(sys.modules.items())
        if module_name.startswith("riglens.core.")
        for name, value in vars(module).items()
        if isinstance(value, CPUDispatcher)
    }


def is_parallel(function: CPUDispatcher) -> bool:
    return bool(function.targetoptions.get("parallel"))


@pytest.fixture
def callers(monkeypatch: pytest.MonkeyPatch) -> dict[str, set[str]]:
    """Which threads have called kernels since: "parallel" and "serial" ones."""
    found: dict[str, set[str]] = {"parallel": set(), "serial": set()}

    def noted(function: CPUDispatcher) -> Callable[..., Any]:
        kind = "parallel" if is_parallel(function) else "serial"

        def call(*arguments: Any) -> Any:
            found[kind].add(threading.current_thread().name.split("_")[0])
            return function(*arguments)

        return call

    for (module, name), kernel in all_kernels().items():
        is_for_pictures = (
            module in ("riglens.core.kernels.body.hits", "riglens.core.kernels.rays.clip") and name[0] != "_"
        ) or (module, name) == ("riglens.core.kernels.body.solid", "meet_listed")
        is_for_counting = module.endswith(".objects.counts") and name == "cast_frames"
        if is_parallel(kernel) or is_for_pictures or is_for_counting:
            monkeypatch.setattr(sys.modules[module], name, noted(kernel))
    return found


def test_everything_in_the_window_calls_parallel_kernels_on_one_thread(
    qtbot: QtBot, tmp_path: Path, callers: dict[str, set[str]]
) -> None:
    with open_bench(qtbot, tmp_path, counter=make_counter(close_s=TIMEOUT_S)) as bench:
        bench.features.detection_range._choose(RangePlan(bearings_deg=(0.0,), to_m=12.0))
        bench.act("detection_range")
        for dock in ("Map", "Sensor view", "Checks"):
            bench.workbench.docks[dock].setFloating(True)  # all in sight at once
            bench.workbench.docks[dock].show()
        qtbot.waitUntil(lambda: bool(bench.features.map.in_sight), timeout=TIMEOUT_MS)
        bench.features.compare.add_presets(("Center",))
        bench.act("pin")
        for mode in MODES:
            bench.features.heat.set_mode(mode)
            bench.settle()
        for name in ("front", "roof"):
            bench.document.select(name)
            bench.drag(name, (0.2, 0.1, 2.1), (0.4, 0.1, 2.2))
            bench.session.pick((20, 20, 2))
            bench.settle()
            qtbot.waitUntil(lambda: bench.features.sensor_view.is_current, timeout=TIMEOUT_MS)
            qtbot.waitUntil(lambda: bench.features.targets.is_current, timeout=TIMEOUT_MS)
            qtbot.waitUntil(lambda: bench.features.detection_range.is_current, timeout=TIMEOUT_MS)
        rows = bench.features.compare
        qtbot.waitUntil(lambda: all(row.scores for row in rows.rows), timeout=TIMEOUT_MS)
        assert bench.features.map._top is not None
        assert bench.features.sensor_view.pictures._thread.is_started
    # a helper helps only where it begins before the caller is done; footprints may be known from another test
    callers["serial"] -= {HELPER, "footprints"}
    assert callers == {
        "parallel": {"recompute"},
        "serial": {"sensor view", "counting of objects", "places of sensors", "detection range"},
    }


# ---------------------------------------------------------------------- the end
def request_for(folder: Path) -> PictureRequest:
    scene: LoadedScene = load_scene(scene_options(folder), lambda _: None)
    return PictureRequest(CAMERA, 0, scene, Vehicle())


def test_closing_ends_a_picture_of_a_very_fine_car_early(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = threading.Event()
    pictures = make_pictures(close_s=TIMEOUT_S)

    def slow_solid(vehicle: Vehicle) -> Solid:
        begun.set()
        with pictures._queue.lock:
            assert pictures._queue.lock.wait_for(lambda: pictures._queue.is_closing, TIMEOUT_S)
        return Solid.of(np.zeros((0, 3, 3)))

    monkeypatch.setattr(riglens.app.background.pictures, "solid_of", slow_solid)
    drawn = list[object]()
    monkeypatch.setattr(riglens.app.background.pictures, "camera_picture", lambda *seen: drawn.append(seen))
    pictures.ask(request_for(tmp_path))
    assert begun.wait(TIMEOUT_S)
    pictures.close()
    assert pictures._thread.is_started and not pictures._thread._thread.is_alive()
    assert not drawn  # given up before the picture itself was begun


def test_closing_does_not_wait_for_a_picture_that_cannot_be_given_up(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, may_end = threading.Event(), threading.Event()

    def endless(*_: object) -> None:
        begun.set()
        may_end.wait()

    monkeypatch.setattr(riglens.app.background.pictures, "camera_picture", endless)
    pictures, made = make_pictures(close_s=0.01), list[SensorPicture]()
    pictures.answered.connect(lambda _, picture: made.append(picture))
    pictures.ask(request_for(tmp_path))
    assert begun.wait(TIMEOUT_S)
    pictures.close()
    assert pictures._thread._thread.is_alive()
    may_end.set()
    pictures._thread.close(TIMEOUT_S)
    assert not pictures._thread._thread.is_alive()
    assert not made


def test_closing_does_not_wait_for_work_without_progress(qtbot: QtBot) -> None:
    begun, may_end = threading.Event(), threading.Event()

    def endless(_: object) -> None:
        begun.set()
        may_end.wait()

    tasks, done = Tasks(close_s=0.01), list[object]()
    task = tasks.run("Reading", endless, done.append)
    assert begun.wait(TIMEOUT_S)
    tasks.close()
    assert task._thread.is_alive() and not tasks._running
    may_end.set()
    task.join()
    assert not done
