"""Side jobs: exact scores of other rigs in the time nobody edits, never in the way of an edit."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from riglens.app.background.background_requests import ScoreRequest
from riglens.app.background.recompute import BACKGROUND_REST_S, Recompute
from riglens.core.engine.engine import Engine
from riglens.core.errors import Cancelled
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.model import Rig
from riglens.evaluation.requests import EvaluationRequest, LoadedScene
from riglens.evaluation.scoring import Cancel, Scoring
from tests.app.window_bench import CAMERA, LIDAR, RIG, scene_options
from tests.hand_clock import HandClock
from tests.waiting import TIMEOUT_MS, TIMEOUT_S

QUEUED = Qt.ConnectionType.QueuedConnection
SETTINGS = MetricSettings()
WITHOUT = {
    "roof": RIG.replace(sensors=(CAMERA,)),
    "front": RIG.replace(sensors=(LIDAR,)),
    "all": RIG.replace(sensors=()),
}


class Desk:
    """A Recompute on a small scene with everything it answered, in order."""

    def __init__(self, qtbot: QtBot, folder: Path) -> None:
        self._qtbot = qtbot
        self.answers: list[tuple[ScoreRequest, Scores]] = []
        self.order: list[str] = []
        self.scenes: list[LoadedScene] = []
        self.clock = HandClock(leaps=True)
        self.recompute = Recompute(threads=1, clock=self.clock)
        self.recompute.answered_in_background.connect(self._note, QUEUED)
        self.recompute.evaluated.connect(lambda _: self.order.append("edit"), QUEUED)
        self.recompute.scene_loaded.connect(self.scenes.append, QUEUED)
        self.recompute.load(scene_options(folder))
        self.wait(lambda: bool(self.scenes))

    def _note(self, request: ScoreRequest, scores: Scores | None) -> None:
        if scores is not None:
            self.answers.append((request, scores))
            self.order.append(request.name)

    def ask(self, *names: str, group: str = "test") -> None:
        scene = self.scenes[0]
        self.recompute.ask_in_background(
            [ScoreRequest(group, name, WITHOUT[name], SETTINGS, scene) for name in names]
        )

    def edit(self, revision: int) -> None:
        self.recompute.evaluate(EvaluationRequest(revision, RIG, RIG, SETTINGS))

    def wait(self, condition: Callable[[], bool]) -> None:
        self._qtbot.waitUntil(condition, timeout=TIMEOUT_MS)


@pytest.fixture
def desk(qtbot: QtBot, tmp_path: Path) -> Iterator[Desk]:
    opened = Desk(qtbot, tmp_path)
    yield opened
    opened.recompute.close()


def test_other_rigs_are_scored_as_a_fresh_engine_scores_them_bit_for_bit(desk: Desk) -> None:
    desk.ask("roof", "front", "all")
    desk.wait(lambda: len(desk.answers) == 3)
    assert desk.order == ["roof", "front", "all"]
    for request, scores in desk.answers:
        assert scores == Engine(desk.scenes[0].field, 1).evaluate(request.rig, SETTINGS).scores


class HeldScoring:
    """Waits inside side jobs until a test lets go, then does as it is told."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.reached, self.go_on = threading.Event(), threading.Event()
        self.gave_way = 0
        real = Scoring.other

        def other(scoring: Scoring, rig: Rig, settings: MetricSettings, cancel: Cancel) -> Scores:
            self.reached.set()
            assert self.go_on.wait(TIMEOUT_S)
            if cancel():
                self.gave_way += 1
                raise Cancelled
            return real(scoring, rig, settings, cancel)

        monkeypatch.setattr(Scoring, "other", other)


def test_an_edit_drives_a_side_job_out_and_the_job_is_done_afterwards(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = HeldScoring(monkeypatch)
    desk.ask("roof")
    assert held.reached.wait(TIMEOUT_S)
    desk.edit(1)
    held.go_on.set()
    desk.wait(lambda: len(desk.order) == 2)
    assert held.gave_way == 1
    assert desk.order == ["edit", "roof"]


def test_closing_in_the_middle_of_a_side_job_ends_the_thread(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = HeldScoring(monkeypatch)
    desk.ask("roof")
    assert held.reached.wait(TIMEOUT_S)
    desk.recompute._queue.close()
    held.go_on.set()
    desk.recompute.close()
    assert held.gave_way == 1
    assert desk.answers == []


def test_a_failure_in_a_side_job_is_reported_and_its_group_given_up(
    desk: Desk, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    problems: list[str] = []
    desk.recompute.failed.connect(problems.append, QUEUED)

    def fail(*_: object) -> None:
        raise ZeroDivisionError("no way")

    with monkeypatch.context() as broken:
        broken.setattr(Scoring, "other", fail)
        desk.ask("roof", "front")
        desk.wait(lambda: bool(problems))
    assert "ZeroDivisionError: no way" in problems[0]
    assert "Traceback" in capsys.readouterr().err
    desk.ask("all")
    desk.wait(lambda: bool(desk.order))
    assert desk.order == ["all"]


def test_side_jobs_wait_until_the_edits_have_rested(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    begun_s: list[float] = []
    real = Scoring.other

    def timed(*arguments: Any) -> Scores:
        begun_s.append(desk.clock.now_s())
        return real(*arguments)

    monkeypatch.setattr(Scoring, "other", timed)
    desk.clock.stand_still()
    desk.edit(1)
    edited_s = desk.clock.now_s()
    desk.ask("roof")
    desk.wait(lambda: desk.order == ["edit"])
    desk.clock.advance(0.9 * BACKGROUND_REST_S)
    desk.edit(2)
    desk.wait(lambda: desk.order == ["edit", "edit"])
    desk.clock.advance(0.9 * BACKGROUND_REST_S)
    assert desk.order == ["edit", "edit"]
    desk.clock.advance(0.2 * BACKGROUND_REST_S)
    desk.wait(lambda: len(desk.order) == 3)
    assert desk.order[2] == "roof"
    assert begun_s == [pytest.approx(edited_s + 2.0 * BACKGROUND_REST_S)]
