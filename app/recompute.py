"""The one background thread: evaluates rigs and loads box data, always for the latest wish.

Every Numba kernel of the window runs here, because parallel kernels must not be called from two threads.
There is one pending slot and no timer: a newer request takes the place of a waiting one. Where the exact answer
would take longer than a frame, a coarse one goes ahead, and the exact one is made when the mouse rests. Results
return by signals that carry their request, and the window drops those older than what it shows.
Side jobs (app/side_jobs.py) fill the time in which nobody edits, and give way at once.
"""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from app.options import SceneOptions
from app.requests import FRAME_MS, EvaluationRequest, LoadedScene
from app.side_jobs import SideAnswer, SideQueue, SideRequest
from core.errors import InputError
from core.scene.boxes import Progress

if TYPE_CHECKING:
    from app.scoring import Scoring

CANCELLED = "Loading was cancelled."
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
    take longer are preceded by a coarse one. With `waits` nothing is done before `begin`.
    """

    evaluated = Signal(object)
    """An exact Result."""
    approximated = Signal(object)
    """An Approximation, never the last answer to a request that nothing newer replaces."""
    scene_loaded = Signal(object)
    load_progress = Signal(float)
    load_ended = Signal(str)
    """A load is over; the text is empty after success, and after a cancel or an error says which."""
    failed = Signal(str)
    side_answered = Signal(object)
    """A SideAnswer."""

    def __init__(
        self,
        loader: SceneLoader | None = None,
        threads: int | None = None,
        coarse_above_ms: float = FRAME_MS,
        waits: bool = False,
    ) -> None:
        super().__init__()
        self._loader = loader
        self._threads = threads
        self._coarse_above_ms = coarse_above_ms
        self._condition = threading.Condition()
        self._wanted: EvaluationRequest | None = None
        self._last: EvaluationRequest | None = None
        self._scene_wanted: SceneOptions | None = None
        self._cancel_load = False
        self._closing = False
        self._waits = waits
        self._is_busy = False
        self._is_loading = False
        self._gave_up_last = False
        self._side = SideQueue()
        self._scoring: Scoring | None = None
        self._thread = threading.Thread(target=self._run, name="recompute", daemon=True)
        self._thread.start()

    # ------------------------------------------------------------------ called by the interface thread
    @property
    def threads(self) -> int | None:
        """Number of threads of the engines, None for all."""
        return self._threads

    def begin(self) -> None:
        """Do what has been asked for by now; for an owner that waits."""
        with self._condition:
            self._waits = False
            self._condition.notify_all()

    def evaluate(self, request: EvaluationRequest) -> None:
        """Ask for scores; takes the place of a request that still waits."""
        with self._condition:
            self._wanted = request
            self._side.postpone()
            self._condition.notify_all()

    def ask_aside(self, requests: Sequence[SideRequest]) -> None:
        """Have rigs scored when nobody edits, in this order, each answered by `side_answered`."""
        with self._condition:
            for request in requests:
                self._side.ask(request)
            self._condition.notify_all()

    def forget_aside(self, group: str) -> None:
        """Drop what a group asked for and has no answer yet; an answer may still be on its way."""
        with self._condition:
            self._side.forget(group)

    def load(self, request: SceneOptions) -> None:
        """Ask for other box data; a load under way is given up. The old scene stays until then."""
        with self._condition:
            self._scene_wanted = request
            self._condition.notify_all()

    def cancel_load(self) -> None:
        """Give up the load under way and the one that waits."""
        with self._condition:
            only_waited = self._scene_wanted is not None and not self._is_loading
            self._scene_wanted = None
            self._cancel_load = True
        if only_waited:
            self.load_ended.emit(CANCELLED)

    def wait_until_idle(self, timeout_s: float = 60.0) -> bool:
        """Block until nothing but side jobs waits or runs; False on timeout. Results may still be queued as
        Qt events."""
        with self._condition:
            return self._condition.wait_for(self._is_idle, timeout_s)

    def close(self) -> None:
        """Give up all work and end the thread."""
        with self._condition:
            self._closing = True
            self._condition.notify_all()
        self._thread.join()

    def _is_idle(self) -> bool:
        waiting = self._scene_wanted is not None or (self._wanted is not None and self._scoring is not None)
        return not (waiting or self._is_busy)

    # ------------------------------------------------------------------ the thread
    def _run(self) -> None:
        with self._condition:
            self._condition.wait_for(lambda: self._closing or not self._waits)
        while True:
            with self._condition:
                self._is_busy = self._is_loading = False
                self._condition.notify_all()
                while not (self._closing or not self._is_idle() or self._side_delay_s() == 0.0):
                    self._condition.wait(self._side_delay_s())
                if self._closing:
                    return
                side = self._side.first() if self._is_idle() else None
                self._is_busy = side is None
                scene_wanted, self._scene_wanted = self._scene_wanted, None
                self._is_loading = scene_wanted is not None
                self._cancel_load = False
            if side is not None:
                self._answer_aside(side)
            elif scene_wanted is not None:
                self._load(scene_wanted)
            else:
                self._evaluate_wanted()

    def _load(self, request: SceneOptions) -> None:
        self.load_progress.emit(0.0)
        try:
            from app.scoring import (  # loads the compiler, which the first picture needs not
                Scoring,
                load_scene,
            )

            scene = (self._loader or load_scene)(request, self._report_progress)
            self._stop_if_unwanted()
            scoring = Scoring(scene, self._threads, self._coarse_above_ms)
        except _Cancelled:
            outcome = CANCELLED
        except InputError as error:
            outcome = str(error)
        except Exception as error:
            outcome = _unexpected(error)
        else:
            self.scene_loaded.emit(scene)
            with self._condition:
                self._scoring = scoring
                self._wanted = self._wanted or self._last
            outcome = ""
        with self._condition:
            superseded = self._scene_wanted is not None
        if not superseded:
            self.load_ended.emit(outcome)

    def _report_progress(self, fraction: float) -> None:
        """Progress of a load: ends it when unwanted, and keeps the old scene's scores following edits."""
        self._stop_if_unwanted()
        self.load_progress.emit(fraction)
        self._evaluate_wanted()

    def _stop_if_unwanted(self) -> None:
        with self._condition:
            if self._closing or self._cancel_load or self._scene_wanted is not None:
                raise _Cancelled

    def _evaluate_wanted(self) -> None:
        if self._scoring is None:
            return
        with self._condition:
            request, self._wanted = self._wanted, None
            self._last = request or self._last
        if request is None:
            return
        try:
            self._answer(self._scoring, request)
        except Exception as error:
            self.failed.emit(_unexpected(error))

    def _answer(self, scoring: Scoring, request: EvaluationRequest) -> None:
        """The exact answer; where it is slow a coarse one before it, and in a drag it then waits for a rest."""
        first = scoring.approximate(request, self._is_closing) if scoring.is_slow(request) else None
        if first is None:
            result = scoring.exact(request, self._is_stale)
            self._gave_up_last = result is None
        else:
            self.approximated.emit(first)
            is_measured = scoring.is_measured(request)
            if is_measured and request.is_preview and self._is_followed_within(REST_S):
                return
            result = scoring.exact(request, self._is_followed if is_measured else self._is_stale)
        if result is not None:
            self.evaluated.emit(result)
            scoring.learn(result, self._is_followed if scoring.has_learnt else self._is_closing)

    # ------------------------------------------------------------------ side jobs
    def _side_delay_s(self) -> float | None:
        """Seconds until a side job is due, None while there is none or no scene to run it on."""
        return self._side.delay_s() if self._scoring is not None else None

    def _answer_aside(self, request: SideRequest) -> None:
        """Answer a side job, or give way and leave it in the queue."""
        assert self._scoring is not None
        scoring = self._scoring
        try:
            found = scoring.aside(request.rig, request.settings, lambda: self._gives_way(request))
        except Exception as error:
            self.failed.emit(_unexpected(error))
            found = None
            self.forget_aside(request.group)
        if found is None:
            return
        with self._condition:
            is_wanted = self._side.wants(request)
            self._side.done(request)
        if is_wanted:
            self.side_answered.emit(SideAnswer(request, scoring.scene, found.scores, found.elapsed_ms))

    def _gives_way(self, request: SideRequest) -> bool:
        with self._condition:
            return self._closing or not self._is_idle() or not self._side.wants(request)

    # ------------------------------------------------------------------ giving up
    def _is_closing(self) -> bool:
        with self._condition:
            return self._closing

    def _is_followed(self) -> bool:
        """Whether anything newer waits: it will get a coarse answer at once, so nobody is left without numbers."""
        return self._is_followed_within(0.0)

    def _is_followed_within(self, seconds: float) -> bool:
        with self._condition:
            return self._condition.wait_for(lambda: self._closing or self._wanted is not None, seconds)

    def _is_stale(self) -> bool:
        """Whether to give up: somebody waits for a final answer, and the last request was not given up.

        A preview never drives out a running evaluation, and never are two given up in a row: otherwise
        a fast mouse could keep every number from being finished.
        """
        with self._condition:
            wanted = self._wanted
            return self._closing or (wanted is not None and not wanted.is_preview and not self._gave_up_last)


def _unexpected(error: Exception) -> str:
    """One line for the user; the traceback goes to standard error for the person who mends it."""
    traceback.print_exception(error, file=sys.stderr)
    return f"Unexpected failure in the background: {type(error).__name__}: {error}"
