"""Tolerance a step at a time, on the engine's thread while nobody edits: each step is one rig with drawn errors."""

from __future__ import annotations

from collections.abc import Callable

from riglens.app.background.side_jobs import ToleranceAnswer, ToleranceRequest
from riglens.core.review.measures import Measures
from riglens.core.review.tolerance import ToleranceRun

FRAMES = 100
"""Road users are counted in so many frames, as `riglens tolerance` does unless told otherwise."""
TOLD_EVERY = 4
"""Answers are told after so many steps, and at the end."""


class Tolerating:
    """The request under way with its engines, which go when it ends. Called by one thread only."""

    def __init__(self, threads: int | None) -> None:
        self._threads = threads
        self._request: ToleranceRequest | None = None
        self._run: ToleranceRun | None = None
        self._measures: Measures | None = None

    def step(self, request: ToleranceRequest, is_stale: Callable[[], bool]) -> ToleranceAnswer | None:
        """Measure once more; None when `is_stale` said so half-way, and then the same is measured again."""
        if request is not self._request:
            self._begin(request)
        run, measures = self._run, self._measures
        assert run is not None and measures is not None
        figures = measures.unless(is_stale, *run.wanted())
        if figures is None:
            return None
        run.take(figures)
        answer = ToleranceAnswer(request, run.done, run.steps, run.result())
        if answer.is_whole:
            self.forget()
        return answer

    def _begin(self, request: ToleranceRequest) -> None:
        self._request = request
        self._run = ToleranceRun(request.rig, request.profile, request.draws)
        self._measures = Measures(
            request.scene.field, request.traffic, request.settings, request.mesh, FRAMES, self._threads,
            request.targets,
        )  # fmt: skip

    def forget(self) -> None:
        """Give back what is held."""
        self._request = self._run = self._measures = None


def is_told(answer: ToleranceAnswer) -> bool:
    """Whether an answer is worth telling: now and then, and the last."""
    return answer.is_whole or answer.done % TOLD_EVERY == 0
