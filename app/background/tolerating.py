"""Measure tolerances step by step, on the engine's thread between edits: each step is one rig with random errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from riglens.app.background.background_requests import ToleranceProgress, ToleranceRequest
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.review.measures import Measures
from riglens.core.review.tolerance import SAMPLE_FRAMES, ToleranceRun


class Tolerating:
    """The request under way with its engines, which go when it ends. Called by one thread only."""

    def __init__(self, threads: int | None) -> None:
        self._threads = threads
        self._request: ToleranceRequest | None = None
        self._run: ToleranceRun | None = None
        self._measures: Measures | None = None

    def step(self, request: ToleranceRequest, cancel: Callable[[], bool]) -> ToleranceProgress:
        """Measure once more; after Cancelled, the next call measures the same again."""
        if request is not self._request:
            self._begin(request)
        run, measures = self._run, self._measures
        assert run is not None and measures is not None
        run.take(measures(*run.wanted(), cancel=cancel))
        progress = ToleranceProgress(run.done, run.steps, run.result())
        if progress.is_whole:
            self.forget()
        return progress

    def is_of(self, group: str) -> bool:
        """Return whether the request under way belongs to a group."""
        request = self._request
        return request is not None and request.group == group

    def _begin(self, request: ToleranceRequest) -> None:
        settings = EvaluationSettings(request.settings, replace(request.targets, body=request.settings.body))
        evaluate = Evaluator(request.scene.field, request.traffic, settings, self._threads)
        self._request, self._measures = request, Measures(evaluate, SAMPLE_FRAMES, request.rig)
        frames = self._measures.frames
        self._run = ToleranceRun(request.rig, request.profile, request.draws, frames=frames)

    def forget(self) -> None:
        """Release the held memory."""
        self._request = self._run = self._measures = None
