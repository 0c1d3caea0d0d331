"""The background thread: the latest wish wins, nothing is starved, and bad data leave the last good scene."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

import riglens.core.figures.evaluated
from riglens.app.background.compiling import OtherKernels
from riglens.app.background.recompute import CANCELLED, Recompute
from riglens.core.errors import Cancelled, InputError
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.scene.boxes import Progress
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import EvaluationRequest, LoadedScene
from riglens.evaluation.scoring import load_scene
from tests.app.window_bench import RIG, scene_options
from tests.hand_clock import HandClock
from tests.waiting import TIMEOUT_MS, TIMEOUT_S

QUEUED = Qt.ConnectionType.QueuedConnection
LONG = Vehicle(length=5.1)


def request(revision: int, is_preview: bool = False) -> EvaluationRequest:
    moved = RIG.sensors[0].replace(position=(0.1 * revision, 0.0, 2.0))
    rig = RIG.with_sensor("roof", moved)
    return EvaluationRequest(revision, rig, RIG, MetricSettings(), is_preview=is_preview)


class Worker:
    """A Recompute whose signals are written down, and whose loader can be held."""

    def __init__(self, qtbot: QtBot, loader: Callable[[SceneOptions, Progress], LoadedScene]) -> None:
        self._qtbot = qtbot
        self.answered: list[int] = []
        self.scenes: list[LoadedScene] = []
        self.ended: list[str] = []
        self.failures: list[str] = []
        self.recompute = Recompute(loader, threads=1, coarse_above_ms=math.inf, clock=HandClock(leaps=True))
        self.recompute.evaluated.connect(lambda result: self.answered.append(result.request.revision), QUEUED)
        self.recompute.scene_loaded.connect(self.scenes.append, QUEUED)
        self.recompute.load_ended.connect(lambda problem, _: self.ended.append(problem), QUEUED)
        self.recompute.failed.connect(self.failures.append, QUEUED)

    def wait(self, condition: Callable[[], bool]) -> None:
        self._qtbot.waitUntil(condition, timeout=TIMEOUT_MS)

    def finish(self) -> None:
        """Let everything that was asked for come to its end."""
        assert self.recompute.wait_until_idle(TIMEOUT_S)
        QApplication.processEvents()  # what the thread said is heard


StartWorker = Callable[..., Worker]


@pytest.fixture
def start(qtbot: QtBot) -> Iterator[StartWorker]:
    workers: list[Worker] = []

    def start_worker(loader: Callable[[SceneOptions, Progress], LoadedScene] = load_scene) -> Worker:
        workers.append(Worker(qtbot, loader))
        return workers[-1]

    yield start_worker
    for worker in workers:
        worker.recompute.close()


class Gate:
    """A place in the background thread that a test opens when it is ready."""

    def __init__(self) -> None:
        self.reached = threading.Event()
        self._open = threading.Event()

    def open(self) -> None:
        self._open.set()

    def pass_through(self) -> None:
        self.reached.set()
        assert self._open.wait(TIMEOUT_S)


def test_of_many_waiting_requests_only_the_latest_is_answered(start: StartWorker, tmp_path: Path) -> None:
    gate = Gate()

    def held(options: SceneOptions, progress: Progress) -> LoadedScene:
        gate.pass_through()
        return load_scene(options, progress)

    worker = start(held)
    worker.recompute.load(scene_options(tmp_path))
    gate.reached.wait(TIMEOUT_S)
    for revision in range(1, 8):
        worker.recompute.evaluate(request(revision))
    gate.open()
    worker.wait(lambda: bool(worker.answered))
    worker.finish()
    assert worker.answered == [7]


def test_a_thread_that_waits_does_nothing_before_it_is_told_to_begin(qtbot: QtBot) -> None:
    loaded: list[str] = []

    def loader(options: SceneOptions, _: Progress) -> LoadedScene:
        loaded.append(str(options.boxes))
        raise InputError("nothing to load")

    recompute = Recompute(loader, waits=True)
    try:
        for name in ("first", "second"):  # a thread that does not wait may load the first one
            recompute.load(SceneOptions(boxes=Path(name)))
        with qtbot.waitSignal(recompute.load_ended, timeout=TIMEOUT_MS):
            recompute.begin()
        assert loaded == ["second"]
    finally:
        recompute.close()


def test_a_thread_that_was_never_told_to_begin_can_be_closed_and_has_done_nothing(qtbot: QtBot) -> None:
    loaded: list[SceneOptions] = []

    def loader(options: SceneOptions, _: Progress) -> LoadedScene:
        loaded.append(options)
        raise InputError("nothing to load")

    recompute = Recompute(loader, waits=True)
    recompute.load(SceneOptions())
    recompute.close()
    assert not loaded


def test_the_last_request_is_answered_again_on_a_new_scene(start: StartWorker, tmp_path: Path) -> None:
    worker = start()
    worker.recompute.evaluate(request(1))
    worker.recompute.load(scene_options(tmp_path))
    worker.wait(lambda: worker.answered == [1])
    worker.recompute.load(scene_options(tmp_path, voxel_m=1.0))
    worker.wait(lambda: worker.answered == [1, 1])
    assert [scene.field.grid.voxel_m for scene in worker.scenes] == [0.5, 1.0]


def test_only_the_first_scene_waits_for_compiled_code(start: StartWorker, tmp_path: Path) -> None:
    worker = start()
    preparing: list[bool] = []
    worker.recompute.load_preparing.connect(lambda: preparing.append(True), QUEUED)
    for voxel_m in (0.5, 1.0):
        worker.recompute.load(scene_options(tmp_path, voxel_m=voxel_m))
        worker.wait(lambda voxel_m=voxel_m: [s.field.grid.voxel_m for s in worker.scenes][-1:] == [voxel_m])
    assert preparing == [True]


@pytest.mark.parametrize("are_compiled", [False, True])
def test_the_open_rig_is_compiled_first_and_all_else_after_its_answer(
    qapp: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, are_compiled: bool
) -> None:
    done: list[str] = []

    class Others(OtherKernels):
        def is_done(self, step: str) -> bool:
            return are_compiled

        def begin(self) -> None:
            done.append("others")

        def begin_beside(self, half: str) -> None:
            done.append(f"{half} beside")

    def warm_up(
        field: object,
        threads: object,
        rig: Rig | None = None,
        settings: object = None,
        vehicle: Vehicle | None = None,
    ) -> None:
        done.append("warm up" if rig is None else f"warm up {len(rig.sensors)}")
        assert vehicle in (None, LONG)

    monkeypatch.setattr("riglens.core.engine.warm_up.warm_up", warm_up)
    recompute = Recompute(threads=1, coarse_above_ms=math.inf, waits=True, others=Others())
    preparing = list[bool]()
    recompute.load_preparing.connect(lambda: preparing.append(True), Qt.ConnectionType.DirectConnection)
    wanted = request(1)
    wanted = replace(wanted, rig=wanted.rig.model_copy(update={"vehicle": LONG}))
    recompute.evaluate(wanted)
    recompute.load(scene_options(tmp_path))
    recompute.begin()
    assert recompute.wait_until_idle()
    recompute.close()
    # where nothing is left to compile, kernels are loaded without the rig, which its answer evaluates
    one = "warm up" if are_compiled else f"warm up {len(wanted.rig.sensors)}"
    assert (done, bool(preparing)) == (["fans beside", one, "others"], not are_compiled)


@pytest.mark.parametrize("are_compiled", [False, True])
def test_only_boxes_of_the_first_scene_are_named_and_only_where_counting_compiles_nothing(
    qtbot: QtBot, tmp_path: Path, are_compiled: bool
) -> None:
    class Others(OtherKernels):
        def is_done(self, step: str) -> bool:
            return are_compiled

        def begin(self) -> None:
            """Compile nothing."""

        def begin_beside(self, half: str) -> None:
            """Compile nothing."""

    recompute = Recompute(threads=1, coarse_above_ms=math.inf, others=Others())
    told = list[object]()
    recompute.boxes_named.connect(told.append, QUEUED)
    recompute.scene_loaded.connect(told.append, QUEUED)
    first, second = scene_options(tmp_path), scene_options(tmp_path, voxel_m=1.0)
    for options in (first, second):
        recompute.load(options)
        assert recompute.wait_until_idle(TIMEOUT_S)
    QApplication.processEvents()
    recompute.close()
    scenes = [one for one in told if isinstance(one, LoadedScene)]
    assert [one.options for one in scenes] == [first, second]
    assert told == [*([first] if are_compiled else []), *scenes]


class SlowEngine:
    """Waits at a gate in each evaluation, then asks once whether it is stale."""

    gates: list[Gate]

    def __init__(self, field: Any, threads: int | None) -> None:
        self._engine = app_engine(field, threads)

    def evaluate(
        self,
        rig: Any,
        settings: Any,
        with_seen: bool = True,
        stance: Pose = Pose(),
        cancel: Callable[[], bool] = lambda: False,
    ) -> Any:
        if self.gates:
            self.gates.pop(0).pass_through()
        if cancel():
            raise Cancelled
        return self._engine.evaluate(rig, settings)


app_engine = riglens.core.figures.evaluated.Engine


def start_slow(start: StartWorker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, gates: int) -> Any:
    SlowEngine.gates = []
    monkeypatch.setattr(riglens.core.figures.evaluated, "Engine", SlowEngine)
    worker = start()
    worker.recompute.load(scene_options(tmp_path))
    worker.wait(lambda: worker.ended == [""])
    SlowEngine.gates = [Gate() for _ in range(gates)]
    return worker, list(SlowEngine.gates)


def test_an_evaluation_is_given_up_for_a_final_request(
    start: StartWorker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker, (first,) = start_slow(start, tmp_path, monkeypatch, 1)
    worker.recompute.evaluate(request(1, is_preview=True))
    first.reached.wait(TIMEOUT_S)
    worker.recompute.evaluate(request(2))
    first.open()
    worker.finish()
    assert worker.answered == [2]


def test_a_drag_that_outruns_the_evaluation_still_gets_numbers(
    start: StartWorker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker, (first,) = start_slow(start, tmp_path, monkeypatch, 1)
    worker.recompute.evaluate(request(1, is_preview=True))
    first.reached.wait(TIMEOUT_S)
    worker.recompute.evaluate(request(2, is_preview=True))
    first.open()
    worker.finish()
    assert worker.answered == [1, 2]


def test_two_evaluations_in_a_row_are_never_given_up(
    start: StartWorker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worker, (first, second) = start_slow(start, tmp_path, monkeypatch, 2)
    worker.recompute.evaluate(request(1))
    first.reached.wait(TIMEOUT_S)
    worker.recompute.evaluate(request(2))
    first.open()
    second.reached.wait(TIMEOUT_S)
    worker.recompute.evaluate(request(3))
    second.open()
    worker.finish()
    assert worker.answered == [2, 3]


def test_a_failure_is_reported_and_the_next_request_is_answered(
    start: StartWorker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    worker = start()
    worker.recompute.load(scene_options(tmp_path))
    worker.wait(lambda: worker.ended == [""])

    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("no way")

    with monkeypatch.context() as broken:
        broken.setattr(riglens.core.figures.evaluated.Engine, "evaluate", fail)
        worker.recompute.evaluate(request(1))
        worker.wait(lambda: bool(worker.failures))
    assert "ZeroDivisionError: no way" in worker.failures[0]
    assert "Traceback" in capsys.readouterr().err
    worker.recompute.evaluate(request(2))
    worker.wait(lambda: worker.answered == [2])


def test_bad_boxes_leave_the_last_good_scene_in_use(start: StartWorker, tmp_path: Path) -> None:
    worker = start()
    worker.recompute.load(scene_options(tmp_path))
    worker.wait(lambda: worker.ended == [""])
    worker.recompute.load(scene_options(tmp_path, boxes=tmp_path / "missing.csv"))
    worker.wait(lambda: len(worker.ended) == 2)
    assert "missing.csv" in worker.ended[1]
    worker.recompute.evaluate(request(1))
    worker.wait(lambda: worker.answered == [1])
    assert len(worker.scenes) == 1


def test_a_cancelled_load_ends_soon_and_keeps_the_old_scene(start: StartWorker, tmp_path: Path) -> None:
    gate = Gate()
    options = scene_options(tmp_path)

    def slow_second(wanted: SceneOptions, progress: Progress) -> LoadedScene:
        if wanted.voxel_m == 1.0:
            gate.pass_through()
            progress(0.5)
            raise AssertionError("the load went on")
        return load_scene(wanted, progress)

    worker = start(slow_second)
    worker.recompute.load(options)
    worker.wait(lambda: worker.ended == [""])
    worker.recompute.load(scene_options(tmp_path, voxel_m=1.0))
    gate.reached.wait(TIMEOUT_S)
    worker.recompute.cancel_load()
    gate.open()
    worker.wait(lambda: worker.ended == ["", CANCELLED])
    worker.recompute.evaluate(request(1))
    worker.wait(lambda: worker.answered == [1])
    assert len(worker.scenes) == 1


def test_edits_are_scored_on_the_old_scene_while_another_is_loaded(
    start: StartWorker, tmp_path: Path
) -> None:
    gate = Gate()

    def slow_second(wanted: SceneOptions, progress: Progress) -> LoadedScene:
        if wanted.voxel_m == 1.0:
            gate.pass_through()
            progress(0.5)
        return load_scene(wanted, progress)

    worker = start(slow_second)
    worker.recompute.load(scene_options(tmp_path))
    worker.wait(lambda: worker.ended == [""])
    worker.recompute.load(scene_options(tmp_path, voxel_m=1.0))
    gate.reached.wait(TIMEOUT_S)
    worker.recompute.evaluate(request(1))
    gate.open()
    worker.wait(lambda: worker.answered == [1, 1])


def test_a_newer_load_takes_the_place_of_one_under_way(start: StartWorker, tmp_path: Path) -> None:
    gate = Gate()

    def slow_first(wanted: SceneOptions, progress: Progress) -> LoadedScene:
        if wanted.voxel_m == 1.0:
            gate.pass_through()
            progress(0.5)
            raise InputError("the load went on")
        return load_scene(wanted, progress)

    worker = start(slow_first)
    worker.recompute.load(scene_options(tmp_path, voxel_m=1.0))
    gate.reached.wait(TIMEOUT_S)
    worker.recompute.load(scene_options(tmp_path))
    gate.open()
    worker.wait(lambda: bool(worker.ended))
    assert worker.ended == [""]
    assert [scene.field.grid.voxel_m for scene in worker.scenes] == [0.5]


def test_closing_in_the_middle_of_a_load_ends_the_thread(qtbot: QtBot, tmp_path: Path) -> None:
    gate = Gate()

    def endless(wanted: SceneOptions, progress: Progress) -> LoadedScene:
        gate.reached.set()
        while True:
            progress(0.5)

    recompute = Recompute(endless)
    recompute.load(scene_options(tmp_path))
    gate.reached.wait(TIMEOUT_S)
    recompute.close()
    assert not any(thread.name == "recompute" for thread in threading.enumerate())
