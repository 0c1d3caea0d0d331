"""Tolerances in the background: the figures of the command, a step at a time, and never in the way of an edit."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from riglens.app.background import tolerating
from riglens.app.background.background_requests import ToleranceProgress, ToleranceRequest
from riglens.app.background.recompute import Recompute
from riglens.app.background.tolerating import Tolerating
from riglens.core.errors import Cancelled
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.measures import Measures
from riglens.core.review.tolerance import SAMPLE_FRAMES, profile_called, tolerance
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.requests import EvaluationRequest, LoadedScene
from riglens.evaluation.traffic import load_traffic
from tests.app.window_bench import RIG, scene_options
from tests.hand_clock import HandClock
from tests.waiting import TIMEOUT_MS

QUEUED = Qt.ConnectionType.QueuedConnection
SETTINGS, SERVICE, DRAWS = MetricSettings(body="blocks"), profile_called("service"), 8


class Worker:
    """A Recompute on a small scene, and what it told of tolerances."""

    def __init__(self, qtbot: QtBot, folder: Path) -> None:
        self.qtbot, self.options = qtbot, scene_options(folder)
        self.answers: list[ToleranceProgress] = []
        self.asked: list[ToleranceRequest] = []
        self.edits: list[int] = []
        scenes: list[LoadedScene] = []
        self.recompute = Recompute(threads=1, clock=HandClock(leaps=True))
        self.recompute.answered_in_background.connect(self._note, QUEUED)
        self.recompute.evaluated.connect(lambda found: self.edits.append(found.request.revision), QUEUED)
        self.recompute.scene_loaded.connect(scenes.append, QUEUED)
        self.recompute.load(self.options)
        qtbot.waitUntil(lambda: bool(scenes), timeout=TIMEOUT_MS)
        self.scene = scenes[0]
        self.traffic = load_traffic(self.options, WITHIN_M, lambda _: None)

    def _note(self, request: ToleranceRequest, answer: ToleranceProgress) -> None:
        self.asked.append(request)
        self.answers.append(answer)

    def request(self, **changes) -> ToleranceRequest:
        fields = {
            "group": "test", "name": "", "rig": RIG, "profile": SERVICE, "draws": DRAWS, "settings": SETTINGS,
            "targets": USUAL,
        }  # fmt: skip
        return ToleranceRequest(**(fields | {"scene": self.scene, "traffic": self.traffic} | changes))


@pytest.fixture
def worker(qtbot: QtBot, tmp_path: Path) -> Iterator[Worker]:
    made = Worker(qtbot, tmp_path)
    yield made
    made.recompute.close()


def test_the_spread_is_that_of_the_command_bit_for_bit_and_fills_in_on_the_way(worker: Worker) -> None:
    request = worker.request()
    worker.recompute.ask_in_background([request])
    worker.qtbot.waitUntil(lambda: bool(worker.answers) and worker.answers[-1].is_whole, timeout=TIMEOUT_MS)
    settings = EvaluationSettings(SETTINGS, replace(USUAL, body=SETTINGS.body))
    evaluate = Evaluator(worker.scene.field, worker.traffic, settings, 1)
    measure = Measures(evaluate, SAMPLE_FRAMES, designed=RIG)
    assert worker.answers[-1].result == tolerance(
        RIG, SERVICE, measure, DRAWS, with_sensitivities=False, frames=measure.frames
    )
    assert [answer.done for answer in worker.answers] == [4, 8, 11]
    assert all(asked is request for asked in worker.asked)
    assert all(answer.result is not None for answer in worker.answers)


def test_an_edit_goes_first_the_same_is_measured_again_and_another_rig_takes_its_place(
    worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    gave_up: list[bool] = []
    real = Measures.__call__

    def edited_once(self, rig, stance, cancel):
        if not gave_up:
            worker.recompute.evaluate(EvaluationRequest(1, RIG, RIG, SETTINGS))
        gave_up.append(cancel())
        if gave_up[-1]:
            raise Cancelled
        return real(self, rig, stance, cancel)

    monkeypatch.setattr(tolerating.Measures, "__call__", edited_once)
    worker.recompute.ask_in_background([worker.request()])
    worker.qtbot.waitUntil(lambda: bool(worker.answers) and worker.answers[-1].is_whole, timeout=TIMEOUT_MS)
    assert gave_up == [True] + [False] * 11 and worker.edits == [1]
    worker.answers.clear()
    worker.asked.clear()
    with worker.recompute._queue.lock:
        worker.recompute.ask_in_background([worker.request()])
        later = worker.request(draws=4)
        worker.recompute.ask_in_background([later])
    worker.qtbot.waitUntil(lambda: bool(worker.answers) and worker.answers[-1].is_whole, timeout=TIMEOUT_MS)
    assert {asked.draws for asked in worker.asked} == {4}


def test_engines_are_given_back_at_the_end(worker: Worker) -> None:
    asked, work = worker.request(traffic=None, draws=1), Tolerating(1)
    answers = [work.step(asked, lambda: False) for _ in range(3)]
    assert answers[-1].is_whole and work._measures is None
    assert answers[-1].result is not None and set(answers[-1].result.spreads) == {
        "seen car", "seen bicycle", "seen pedestrian",
    }  # fmt: skip


def test_engines_of_a_tolerance_that_is_dropped_half_way_are_released(worker: Worker) -> None:
    worker.recompute.ask_in_background([worker.request(draws=4096)])
    worker.qtbot.waitUntil(lambda: bool(worker.answers), timeout=TIMEOUT_MS)
    held = weakref.ref(worker.recompute._tolerating)
    worker.recompute.drop_group("another")
    assert held() is not None
    worker.recompute.drop_group("test")
    worker.qtbot.waitUntil(lambda: held() is None, timeout=TIMEOUT_MS)
