"""Run the one background thread with parallel kernels: it evaluates rigs and loads box data, always the latest request.

Every Numba kernel of the window runs here, because parallel kernels must not be called from two threads.
A newer request replaces one that waits (queue.py). Where the exact answer would take longer than a frame, a coarse
one goes ahead, and the exact one is made when the mouse rests. Results return by signals that carry their request,
and the window drops those older than what it shows. Background requests (background_requests.py) fill the time
between edits, and yield at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from riglens.app.background.background_requests import (
    LEARN,
    AuditRequest,
    ScoreRequest,
    ToleranceProgress,
    ToleranceRequest,
)
from riglens.app.background.compiling import OtherKernels
from riglens.app.background.queue import SYSTEM_CLOCK, BackgroundRequest, Clock, Job, Priority, RequestQueue
from riglens.app.background.worker import WorkerThread, group_of, problem_line
from riglens.core.errors import Cancelled
from riglens.core.rig.model import Vehicle
from riglens.core.scene.boxes import Progress
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import FRAME_MS, EvaluationRequest, LoadedScene, Result

if TYPE_CHECKING:
    from riglens.app.background.tolerating import Tolerating
    from riglens.evaluation.scoring import Scoring

CANCELLED = "Loading was cancelled."
_HERE = "background"
REST_S = 0.05
"""Pause of the mouse after which the exact result replaces a coarse one."""
BACKGROUND_REST_S = 0.25
"""Background requests begin when nothing was edited for so long, so that none runs between two moves of a drag."""
Request = SceneOptions | EvaluationRequest | BackgroundRequest

SceneLoader = Callable[[SceneOptions, Progress], LoadedScene]
"""Turns options into a scene on the background thread; InputError on bad input."""


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
    boxes_named = Signal(object)
    """The SceneOptions of a load before the first scene, if the kernels that count its objects are on disk: they can
    be counted meanwhile."""
    scene_loaded = Signal(object)
    load_progress = Signal(float)
    load_preparing = Signal()
    load_ended = Signal(str, object)
    """A load has ended; the text is empty after success, and names the reason after a cancel or an error. The
    SceneOptions of that load follow: a newer load may have been requested meanwhile."""
    failed = Signal(str)
    answered_in_background = Signal(object, object)
    """A background request and its answer (see background_requests.py), None if there is none."""

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
        self._queue = RequestQueue[Request](clock, BACKGROUND_REST_S)
        self._queue.hold(Priority.EDIT, Priority.BACKGROUND)  # until there is a scene
        if waits:
            self._queue.hold(Priority.LOAD)
        self._last: EvaluationRequest | None = None
        self._gave_up_last = False
        self._scoring: Scoring | None = None
        self._learns_at_rest = False
        self._unlearnt: Result | None = None
        self._tolerating: Tolerating | None = None
        self._is_warm = False
        self._others = others
        self._thread = WorkerThread("recompute", self._queue, self._work)
        self._thread.start()

    # ------------------------------------------------------------------ called by the interface thread
    @property
    def threads(self) -> int | None:
        """Number of threads of the engines, None for all."""
        return self._threads

    def compiling(self) -> tuple[int, int] | None:
        """Return how many steps of compiling are ready and of how many, None while none is under way."""
        return None if self._others is None else self._others.progress()

    def begin(self) -> None:
        """Start the requests made so far; for an owner that waits."""
        self._queue.release(Priority.LOAD)

    def evaluate(self, request: EvaluationRequest) -> None:
        """Ask for scores; replaces a request that waits."""
        self._last = request
        self._queue.put(request)

    def ask_in_background(self, requests: Sequence[BackgroundRequest]) -> None:
        """Answer requests between edits, in this order, each by `answered_in_background`."""
        for request in requests:
            self._queue.put(request, Priority.BACKGROUND)

    def drop_group(self, group: str) -> None:
        """Cancel a group's background requests; an answer may still arrive."""
        self._queue.drop(Priority.BACKGROUND, lambda request: group_of(request) == group)
        held = self._tolerating
        if held is not None and held.is_of(group):
            self._tolerating = None  # with its engines

    def load(self, request: SceneOptions) -> None:
        """Ask for other box data; a load under way is given up. The old scene stays until then."""
        self._queue.put(request, Priority.LOAD)

    def cancel_load(self) -> None:
        """Cancel the current load and the waiting one."""
        with self._queue.lock:
            is_loading = self._queue.is_running(Priority.LOAD)
            dropped = self._queue.drop(Priority.LOAD)
        if dropped and not is_loading:
            self.load_ended.emit(CANCELLED, dropped[0])

    def rest(self) -> None:
        """Release what only a series of other rigs uses again."""
        if self._scoring is not None:
            self._scoring.rest()

    def wait_until_idle(self, timeout_s: float = 60.0, down_to: Priority = Priority.EDIT) -> bool:
        """Block until nothing as urgent as `down_to` waits or runs, usually all but background requests; False on
        timeout. Results may still be queued as Qt events."""
        return self._queue.wait_until_idle(timeout_s, down_to)

    def close(self) -> None:
        """Cancel all work and end the thread."""
        self._queue.close()
        if self._others is not None:
            self._others.close()
        self._thread.close()

    # ------------------------------------------------------------------ the thread
    def _work(self, job: Job[Request]) -> None:
        if isinstance(job.request, SceneOptions):
            self._load(job.request, job)
        elif isinstance(job.request, EvaluationRequest):
            self._evaluate(job.request)
            if self._others is not None:
                self._others.begin()
        else:
            self._answer_in_background(job.request, job)

    # ---- scenes

    def _load(self, request: SceneOptions, job: Job[Request]) -> None:
        self.load_progress.emit(0.0)
        try:
            scoring = self._loaded(request, job)
        except Cancelled:
            outcome = CANCELLED
        except Exception as error:
            outcome = problem_line(_HERE, error)
        else:
            self.scene_loaded.emit(scoring.scene)
            self._scoring, self._unlearnt = scoring, None
            self._evaluate_last_again()
            outcome = ""
        if self._queue.waiting(Priority.LOAD) is None:
            self.load_ended.emit(outcome, request)

    def _loaded(self, request: SceneOptions, job: Job[Request]) -> Scoring:
        from riglens.evaluation.scoring import Scoring, load_scene  # loads the compiler

        half = self._compile_beside()
        if self._scoring is None and self._others is not None and self._others.is_done("points"):
            self.boxes_named.emit(request)
        scene = (self._loader or load_scene)(request, partial(self._report_progress, job))
        self._stop_if_stale(job)
        scoring = Scoring(scene, self._threads, self._coarse_above_ms)
        self._warm_up(scene, half, job)
        return scoring

    def _evaluate_last_again(self) -> None:
        """Evaluate on a new scene what was asked last, unless a newer request waits."""
        with self._queue.lock:
            self._queue.release(Priority.EDIT, Priority.BACKGROUND)
            if self._last is not None and self._queue.waiting(Priority.EDIT) is None:
                self._queue.put(self._last)

    def _compile_beside(self) -> str | None:
        """Let another process compile half of what the open rig needs during the first load; return which."""
        if self._is_warm or self._others is None or self._last is None:
            return None
        from riglens.core.engine.warm_up import halves_of

        half = halves_of(self._last.rig)
        if half is not None:
            self._others.begin_beside(half)
        return half

    def _warm_up(self, scene: LoadedScene, half: str | None, job: Job[Request]) -> None:
        """Compile the kernels of the open rig before the first result of this process; later scenes reuse them."""
        if self._is_warm:
            return
        from riglens.core.engine.warm_up import HALVES, warm_up
        from riglens.evaluation.kernel_steps import STEPS

        others, last = self._others, self._last
        if others is not None and all(others.is_done(step) for step in STEPS):
            # all are on disk: the rig is evaluated once, and its car is the only one that is made
            car = Vehicle() if last is None or last.rig.vehicle.lacks_mesh else last.rig.vehicle
            warm_up(scene.field, self._threads, vehicle=car)
        else:
            self.load_preparing.emit()
            if half is not None and others is not None and others.is_running:
                HALVES[half].here(scene.field)
                others.wait_for(half, lambda: self._queue.is_stale(job))
                self._stop_if_stale(job)
            if last is None or last.rig.vehicle.has_mesh_file:  # a mesh is read with the first answer
                warm_up(scene.field, self._threads)
            else:
                warm_up(scene.field, self._threads, last.rig, last.settings)
        self._is_warm = True
        self._stop_if_stale(job)

    def _report_progress(self, job: Job[Request], fraction: float) -> None:
        """Emit the progress of a load, cancel it when it is stale, and answer edits on the old scene meanwhile."""
        self._stop_if_stale(job)
        self.load_progress.emit(fraction)
        edit = self._queue.take(Priority.EDIT)
        if edit is not None:
            assert isinstance(edit.request, EvaluationRequest)
            with suppress(Cancelled):
                self._evaluate(edit.request)
            self._queue.finish()

    def _stop_if_stale(self, job: Job[Request]) -> None:
        if self._queue.is_stale(job):
            raise Cancelled

    # ---- edits

    def _evaluate(self, request: EvaluationRequest) -> None:
        assert self._scoring is not None  # edits are held until there is a scene
        try:
            self._answer(self._scoring, request)
        except Cancelled:
            raise
        except Exception as error:
            self.failed.emit(problem_line(_HERE, error))

    def _answer(self, scoring: Scoring, request: EvaluationRequest) -> None:
        """Emit the exact result; if it is slow, emit a coarse one first and, during a drag, wait for a pause."""
        queue = self._queue
        is_followed = partial(queue.is_followed, Priority.EDIT)
        first = scoring.approximate(request, lambda: queue.is_closing)
        if first is None:
            result = self._exact(scoring, request)
        else:
            self.approximated.emit(first)
            if first.is_measured and request.is_preview and is_followed(REST_S):
                return
            result = scoring.exact(request, is_followed if first.is_measured else self._is_overtaken)
        self.evaluated.emit(result)
        self._learn(scoring, result)

    def _learn(self, scoring: Scoring, result: Result) -> None:
        """Base coarse answers on an exact one of a slow rig; at rest the first base waits for LEARN, so that the
        processors are left to the objects of the first rig."""
        queue, is_first = self._queue, not scoring.has_learnt
        if self._unlearnt is None and not scoring.is_slow(result.evaluation.rig):
            return
        if is_first and not (self._learns_at_rest or result.request.is_preview):
            self._unlearnt = result
            return
        scoring.learn(
            result, (lambda: queue.is_closing) if is_first else partial(queue.is_followed, Priority.EDIT)
        )
        self._unlearnt = None

    def _exact(self, scoring: Scoring, request: EvaluationRequest) -> Result:
        try:
            result = scoring.exact(request, self._is_overtaken)
        except Cancelled:
            self._gave_up_last = True
            raise
        self._gave_up_last = False
        return result

    def _is_overtaken(self) -> bool:
        """Return whether to give up: a final request waits, and the last one was not given up.

        A preview never drives out a running evaluation, and never are two given up in a row: otherwise
        a fast mouse could keep every number from being finished.
        """
        newer = self._queue.waiting(Priority.EDIT)
        is_final = isinstance(newer, EvaluationRequest) and not newer.is_preview
        return self._queue.is_closing or (is_final and not self._gave_up_last)

    # ---- in the background

    def _answer_in_background(self, request: BackgroundRequest, job: Job[Request]) -> None:
        """Answer, or raise Cancelled for anything more urgent; after an error the group is given up."""
        try:
            answer = self._found(request, partial(self._queue.is_stale, job))
        except Cancelled:
            raise
        except Exception as error:
            self._tolerating = None
            self.failed.emit(problem_line(_HERE, error))
            self.drop_group(request.group)
            self.answered_in_background.emit(request, None)
            return
        if isinstance(answer, ToleranceProgress):
            if not answer.is_whole:
                self._queue.put_back(job, last=True)
            if not answer.is_due:
                return
        if not job.is_dropped:
            self.answered_in_background.emit(request, answer)

    def _found(self, request: BackgroundRequest, cancel: Callable[[], bool]) -> object:
        if isinstance(request, AuditRequest):
            from riglens.core.engine.audit import audit  # takes a second or two, and cannot be given up
            from riglens.core.engine.engine import Engine

            return audit(Engine(request.scene.field, self._threads), request.rig)
        if request is LEARN:
            self._learns_at_rest = True
            if self._scoring is not None and self._unlearnt is not None:
                self._scoring.learn(self._unlearnt, cancel)
                self._unlearnt = None
            return None
        if isinstance(request, ToleranceRequest):
            from riglens.app.background.tolerating import Tolerating

            self._tolerating = self._tolerating or Tolerating(self._threads)
            return self._tolerating.step(request, cancel)
        assert isinstance(request, ScoreRequest) and self._scoring is not None
        if request.scene is not self._scoring.scene:
            return None
        return self._scoring.other(request.rig, request.settings, cancel)
