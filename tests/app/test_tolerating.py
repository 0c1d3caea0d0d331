"""Tolerances in the background: the figures of the command, a step at a time, and never in the way of an edit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from riglens.app.background import tolerating
from riglens.app.background.recompute import Recompute
from riglens.app.background.side_jobs import SideQueue, SideRequest, ToleranceAnswer, ToleranceRequest
from riglens.app.background.tolerating import FRAMES, Tolerating
from riglens.app.evaluation.requests import EvaluationRequest, LoadedScene
from riglens.app.evaluation.traffic import load_traffic
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.measures import Measures
from riglens.core.review.tolerance import profile_called, tolerance
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import WITHIN_M
from tests.app.window_bench import RIG, scene_options
from tests.hand_clock import HandClock
from tests.waiting import TIMEOUT_MS

QUEUED = Qt.ConnectionType.QueuedConnection
SETTINGS, SERVICE, DRAWS = MetricSettings(body="blocks"), profile_called("service"), 8


class Worker:
    """A Recompute on a small scene, and what it told of tolerances."""

    def __init__(self, qtbot: QtBot, folder: Path) -> None:
        self.qtbot, self.options = qtbot, scene_options(folder)
        self.answers: list[ToleranceAnswer] = []
        self.edits: list[int] = []
        scenes: list[LoadedScene] = []
        self.recompute = Recompute(threads=1, clock=HandClock(leaps=True))
        self.recompute.tolerated.connect(self.answers.append, QUEUED)
        self.recompute.evaluated.connect(lambda found: self.edits.append(found.request.revision), QUEUED)
        self.recompute.scene_loaded.connect(scenes.append, QUEUED)
        self.recompute.load(self.options)
        qtbot.waitUntil(lambda: bool(scenes), timeout=TIMEOUT_MS)
        self.scene = scenes[0]
        self.traffic = load_traffic(self.options, WITHIN_M, lambda _: None)

    def request(self, **changes) -> ToleranceRequest:
        fields = {"rig": RIG, "profile": SERVICE, "draws": DRAWS, "settings": SETTINGS, "targets": USUAL}
        return ToleranceRequest(**(fields | {"scene": self.scene, "traffic": self.traffic} | changes))


@pytest.fixture
def worker(qtbot: QtBot, tmp_path: Path) -> Iterator[Worker]:
    made = Worker(qtbot, tmp_path)
    yield made
    made.recompute.close()


def test_the_spread_is_that_of_the_command_bit_for_bit_and_fills_in_on_the_way(worker: Worker) -> None:
    request = worker.request()
    worker.recompute.ask_tolerance(request)
    worker.qtbot.waitUntil(lambda: bool(worker.answers) and worker.answers[-1].is_whole, timeout=TIMEOUT_MS)
    measure = Measures(worker.scene.field, worker.traffic, SETTINGS, None, FRAMES, 1)
    assert worker.answers[-1].result == tolerance(RIG, SERVICE, measure, DRAWS, with_sensitivities=False)
    assert [answer.done for answer in worker.answers] == [4, 8, 11]
    assert all(answer.request is request for answer in worker.answers)
    assert all(answer.result is not None for answer in worker.answers)


def test_an_edit_goes_first_the_same_is_measured_again_and_another_rig_takes_its_place(
    worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    gave_up: list[bool] = []
    real = Measures.unless

    def edited_once(self, is_stale, rig, stance):
        if not gave_up:
            worker.recompute.evaluate(EvaluationRequest(1, RIG, RIG, SETTINGS))
        gave_up.append(is_stale())
        return None if gave_up[-1] else real(self, is_stale, rig, stance)

    monkeypatch.setattr(tolerating.Measures, "unless", edited_once)
    worker.recompute.ask_tolerance(worker.request())
    worker.qtbot.waitUntil(lambda: bool(worker.answers) and worker.answers[-1].is_whole, timeout=TIMEOUT_MS)
    assert gave_up == [True] + [False] * 11 and worker.edits == [1]
    worker.answers.clear()
    with worker.recompute._wishes.lock:
        worker.recompute.ask_tolerance(worker.request())
        later = worker.request(draws=4)
        worker.recompute.ask_tolerance(later)
    worker.qtbot.waitUntil(lambda: bool(worker.answers) and worker.answers[-1].is_whole, timeout=TIMEOUT_MS)
    assert {answer.request.draws for answer in worker.answers} == {4}


def test_what_is_under_way_lets_all_others_go_first_and_is_gone_when_forgotten() -> None:
    clock = HandClock()
    queue = SideQueue(clock.now_s)
    first, second = (SideRequest("a", name, RIG, SETTINGS) for name in ("one", "two"))
    queue.ask(first)
    queue.ask(second)
    clock.advance(1.0)
    assert queue.first_due() is first
    queue.put_off(first)
    assert queue.first_due() is second
    queue.forget("a")
    queue.put_off(first)
    assert queue.first_due() is None


def test_engines_are_given_back_at_the_end(worker: Worker) -> None:
    asked, work = worker.request(traffic=None, draws=1), Tolerating(1)
    answers = [work.step(asked, lambda: False) for _ in range(3)]
    assert answers[-1] is not None and answers[-1].is_whole and work._measures is None
    assert answers[-1].result is not None and set(answers[-1].result.spreads) == {
        "seen car", "seen bicycle", "seen pedestrian",
    }  # fmt: skip
