"""The one background thread: evaluates rigs and loads box data, always for the latest wish.

Every Numba kernel of the window runs here, because parallel kernels must not be called from two threads.
A newer request takes the place of one that waits (wishes.py). Where the exact answer would take longer than a frame,
a coarse one goes ahead, and the exact one is made when the mouse rests. Results return by signals that carry their
request, and the window drops those older than what it shows.
Side jobs (side_jobs.py) fill the time in which nobody edits, and give way at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from riglens.app.background.compiling import OtherKernels
from riglens.app.background.inbox import SYSTEM_CLOCK, Clock, unexpected
from riglens.app.background.side_jobs import (
    AuditAnswer,
    AuditRequest,
    SideAnswer,
    SideRequest,
    ToleranceRequest,
)
from riglens.app.background.wishes import Wishes
from riglens.app.evaluation.options import SceneOptions
from riglens.app.evaluation.requests import FRAME_MS, EvaluationRequest, LoadedScene
from riglens.core.errors import InputError
from riglens.core.scene.boxes import Progress

if TYPE_CHECKING:
    from riglens.app.background.tolerating import Tolerating
    from riglens.app.evaluation.scoring import Scoring

CANCELLED = "Loading was cancelled."
_HERE = "background"
REST_S = 0.05
"""A mouse that asked for nothing new for so long rests: time for the exact answer that a coarse one stood for."""

SceneLoader = Callable[[SceneOptions, Progress], LoadedScene]
"""Turns options into a scene on the background thread; InputError on bad input."""


class _Cancelled(Exception):
    """Raised inside a load that nobody wants any more."""


class Recompute(QObject):
    """Owner of the background thread; every method is called from the interface thread.

    Every request is answered unless a newer one took its place; after a load the last one is answered again.
    `close` must be called before the object goes away. `coarse_above_ms`: exact answers that are expected to
    take longer are preceded by a coarse one. With `waits` nothing is done before `begin`. `clock` is what rests are
    measured by. `others` compiles, after the first answer, what the first rig did not need.
    """

    evaluated = Signal(object)
    """An exact Result."""
    approximated = Signal(object)
    """An Approximation, never the last answer to a request that nothing newer replaces."""
    scene_loaded = Signal(object)
    load_progress = Signal(float)
    load_preparing = Signal()
    load_ended = Signal(str, object)
    """A load is over; the text is empty after success, and after a cancel or an error says which. Then the
    SceneOptions that it was asked for with: a newer load may have been asked for meanwhile."""
    failed = Signal(str)
    side_answered = Signal(object)
    """A SideAnswer."""
    audited = Signal(object)
    """An AuditAnswer."""
    tolerated = Signal(object)
    """A ToleranceAnswer, now and then until it is whole."""

    def __init__(
        self,
        loader: SceneLoader | None = None,
        threads: int | None = None,
        coarse_above_ms: float = FRAME_MS,
        waits: bool = False,
        clock: Clock = SYSTEM_CLOCK,
        others: OtherKernels | None = None,
    ) -> None:
        super().__init__()
        self._loader = loader
        self._threads = threads
        self._coarse_above_ms = coarse_above_ms
        self._wishes = Wishes(waits, clock)
        self._scoring: Scoring | None = None
        self._tolerating: Tolerating | None = None
        self._is_warm = False
        self._others = others
        self._thread = threading.Thread(target=self._run, name="recompute", daemon=True)
        self._thread.start()

    # ------------------------------------------------------------------ called by the interface thread
    @property
    def threads(self) -> int | None:
        """Number of threads of the engines, None for all."""
        return self._threads

    def begin(self) -> None:
        """Do what has been asked for by now; for an owner that waits."""
        self._wishes.begin()

    def evaluate(self, request: EvaluationRequest) -> None:
        """Ask for scores; takes the place of a request that still waits."""
        self._wishes.evaluate(request)

    def ask_aside(self, requests: Sequence[SideRequest]) -> None:
        """Have rigs scored when nobody edits, in this order, each answered by `side_answered`."""
        self._wishes.ask_aside(requests)

    def ask_audit(self, request: AuditRequest) -> None:
        """Have the rays of a rig followed when nobody edits, answered by `audited`."""
        self._wishes.ask_aside([request])

    def ask_tolerance(self, request: ToleranceRequest) -> None:
        """Have a rig measured under drawn errors when nobody edits, answered by `tolerated` step by step."""
        self._wishes.ask_aside([request])

    def forget_aside(self, group: str) -> None:
        """Drop what a group asked for and has no answer yet; an answer may still be on its way."""
        self._wishes.forget_aside(group)

    def load(self, request: SceneOptions) -> None:
        """Ask for other box data; a load under way is given up. The old scene stays until then."""
        self._wishes.load(request)

    def cancel_load(self) -> None:
        """Give up the load under way and the one that waits."""
        dropped = self._wishes.cancel_load()
        if dropped is not None:
            self.load_ended.emit(CANCELLED, dropped)

    def wait_until_idle(self, timeout_s: float = 60.0) -> bool:
        """Block until nothing but side jobs waits or runs; False on timeout. Results may still be queued as
        Qt events."""
        return self._wishes.wait_until_idle(timeout_s)

    def close(self) -> None:
        """Give up all work and end the thread."""
        self._wishes.close()
        if self._others is not None:
            self._others.close()
        self._thread.join()

    # ------------------------------------------------------------------ the thread
    def _run(self) -> None:
        while (work := self._wishes.next_work()) is not None:
            if isinstance(work, SideRequest):
                self._answer_aside(work)
            elif isinstance(work, AuditRequest):
                self._audit(work)
            elif isinstance(work, ToleranceRequest):
                self._tolerate(work)
            elif isinstance(work, SceneOptions):
                self._load(work)
            else:
                self._evaluate(work)
                if self._others is not None:
                    self._others.begin()

    def _load(self, request: SceneOptions) -> None:
        self.load_progress.emit(0.0)
        try:
            # loads the compiler, which the first picture does not need
            from riglens.app.evaluation.scoring import Scoring, load_scene

            self._compile_beside()
            scene = (self._loader or load_scene)(request, self._report_progress)
            self._stop_if_unwanted()
            scoring = Scoring(scene, self._threads, self._coarse_above_ms)
            self._warm_up(scene)
        except _Cancelled:
            outcome = CANCELLED
        except InputError as error:
            outcome = str(error)
        except Exception as error:
            outcome = unexpected(_HERE, error)
        else:
            self.scene_loaded.emit(scene)
            self._scoring = scoring
            self._wishes.repeat_last()
            outcome = ""
        if not self._wishes.is_other_scene_wanted():
            self.load_ended.emit(outcome, request)

    def _compile_beside(self) -> None:
        """Before the first load: have the kernel that takes longest compiled by another process meanwhile."""
        if self._is_warm or self._others is None:
            return
        from riglens.core.engine.warm_up import needs_fans

        wanted = self._wishes.wanted_evaluation()
        if wanted is not None and needs_fans(wanted.rig):
            self._others.begin_beside()

    def _warm_up(self, scene: LoadedScene) -> None:
        """Compile what the open rig needs before the first answer of this program; later scenes find it compiled."""
        if self._is_warm:
            return
        from riglens.core.engine.warm_up import compile_sums, warm_up

        self.load_preparing.emit()
        if self._others is not None and self._others.is_running:
            compile_sums(scene.field)
            self._others.wait_for_fans(self._wishes.is_load_unwanted)
            self._stop_if_unwanted()
        wanted = self._wishes.wanted_evaluation()
        if wanted is None or wanted.rig.vehicle.has_mesh_file:  # a mesh is read with the first answer
            warm_up(scene.field, self._threads)
        else:
            warm_up(scene.field, self._threads, wanted.rig, wanted.settings)
        self._is_warm = True
        self._stop_if_unwanted()

    def _report_progress(self, fraction: float) -> None:
        """Progress of a load: ends it when unwanted, and keeps the old scene's scores following edits."""
        self._stop_if_unwanted()
        self.load_progress.emit(fraction)
        request = self._wishes.take_evaluation()
        if request is not None:
            self._evaluate(request)
            self._wishes.finish_evaluation()

    def _stop_if_unwanted(self) -> None:
        if self._wishes.is_load_unwanted():
            raise _Cancelled

    def _evaluate(self, request: EvaluationRequest) -> None:
        assert self._scoring is not None  # there is no evaluation before there is a scene
        try:
            self._answer(self._scoring, request)
        except InputError as error:
            self.failed.emit(str(error))
        except Exception as error:
            self.failed.emit(unexpected(_HERE, error))

    def _answer(self, scoring: Scoring, request: EvaluationRequest) -> None:
        """The exact answer; where it is slow a coarse one before it, and in a drag it then waits for a rest."""
        wishes = self._wishes
        first = scoring.approximate(request, wishes.is_closing) if scoring.is_slow(request) else None
        if first is None:
            result = scoring.exact(request, wishes.is_stale)
            wishes.gave_up_last = result is None
        else:
            self.approximated.emit(first)
            is_measured = scoring.is_measured(request)
            if is_measured and request.is_preview and wishes.is_followed_within(REST_S):
                return
            result = scoring.exact(request, wishes.is_followed if is_measured else wishes.is_stale)
        if result is not None:
            self.evaluated.emit(result)
            scoring.learn(result, wishes.is_followed if scoring.has_learnt else wishes.is_closing)

    def _answer_aside(self, request: SideRequest) -> None:
        """Answer a side job, or give way and leave it in the queue."""
        assert self._scoring is not None
        scoring = self._scoring
        try:
            found = scoring.aside(request.rig, request.settings, lambda: self._wishes.gives_way(request))
        except Exception as error:
            told = isinstance(error, InputError)
            self.failed.emit(str(error) if told else unexpected(_HERE, error))
            found = None
            self.forget_aside(request.group)
        if found is not None and self._wishes.take_aside(request):
            self.side_answered.emit(SideAnswer(request, scoring.scene, found.scores, found.elapsed_ms))

    def _audit(self, request: AuditRequest) -> None:
        """Follow the rays of a rig; that is not given up half-way, it takes a second or two."""
        from riglens.core.engine.audit import audit

        found = None
        try:
            found = audit(request.scene.field, request.rig, "blocks", request.mesh, self._threads)
        except Exception as error:
            told = isinstance(error, InputError)
            self.failed.emit(str(error) if told else unexpected(_HERE, error))
        if self._wishes.take_aside(request):
            self.audited.emit(AuditAnswer(request, found))

    def _tolerate(self, request: ToleranceRequest) -> None:
        """Measure one rig more, then let other side jobs go first."""
        from riglens.app.background.tolerating import Tolerating, is_told

        self._tolerating = self._tolerating or Tolerating(self._threads)
        try:
            answer = self._tolerating.step(request, lambda: self._wishes.gives_way(request))
        except Exception as error:
            told = isinstance(error, InputError)
            self.failed.emit(str(error) if told else unexpected(_HERE, error))
            self._tolerating.forget()
            self.forget_aside(request.group)
            return
        wishes = self._wishes
        if answer is None or not (wishes.take_aside if answer.is_whole else wishes.put_off_aside)(request):
            return
        if is_told(answer):
            self.tolerated.emit(answer)
