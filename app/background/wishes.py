"""What the window wants of the engine's thread: one evaluation, one scene, and side jobs when nobody edits.

For an evaluation and for a scene a newer wish takes the place of one that waits.
"""

from __future__ import annotations

from collections.abc import Sequence

from riglens.app.background.inbox import SYSTEM_CLOCK, Clock, Inbox, Latest
from riglens.app.background.side_jobs import SideJob, SideQueue
from riglens.app.evaluation.options import SceneOptions
from riglens.app.evaluation.requests import EvaluationRequest

Work = SceneOptions | EvaluationRequest | SideJob


class Wishes(Inbox[Work]):
    """Asked for by the interface thread, taken by the engine's. No Qt, no kernels, nothing that takes time.

    With `waits` no work is handed out before `begin`.
    """

    def __init__(self, waits: bool = False, clock: Clock = SYSTEM_CLOCK) -> None:
        super().__init__(clock)
        self.has_scene = False
        """Whether there is a scene to evaluate rigs on."""
        self.gave_up_last = False
        """Whether the last evaluation was given up."""
        self._evaluations = Latest[EvaluationRequest]()
        self._scenes = Latest[SceneOptions]()
        self._side = SideQueue(clock.now_s)
        self._last: EvaluationRequest | None = None
        self._cancel_load = False
        self._waits = waits

    # ------------------------------------------------------------------ said by the interface thread
    def begin(self) -> None:
        """Let work begin that waited for this."""
        with self.lock:
            self._waits = False
            self.lock.notify_all()

    def evaluate(self, request: EvaluationRequest) -> None:
        """Want scores."""
        with self.lock:
            self._evaluations.put(request)
            self._side.postpone()
            self.lock.notify_all()

    def ask_aside(self, requests: Sequence[SideJob]) -> None:
        """Want these rigs scored when nobody edits."""
        with self.lock:
            for request in requests:
                self._side.ask(request)
            self.lock.notify_all()

    def forget_aside(self, group: str) -> None:
        """Want nothing more of what a group asked for."""
        with self.lock:
            self._side.forget(group)

    def load(self, request: SceneOptions) -> None:
        """Want another scene."""
        with self.lock:
            self._scenes.put(request)
            self.lock.notify_all()

    def cancel_load(self) -> SceneOptions | None:
        """Want the scene no more; returns it if its load had not begun."""
        with self.lock:
            waiting = self._scenes.withdraw()
            self._cancel_load = True
            return None if self._scenes.current is not None else waiting

    # ------------------------------------------------------------------ what the thread is given
    def _take(self) -> Work | None:
        if self._waits:
            return None
        if (scene := self._scenes.take()) is not None:
            self._cancel_load = False
            return scene
        return self._take_evaluation() or (self._side.first_due() if self.has_scene else None)

    def _take_evaluation(self) -> EvaluationRequest | None:
        request = self._evaluations.take() if self.has_scene else None
        self._last = request or self._last
        return request

    def _finish(self) -> None:
        self._scenes.finish()
        self._evaluations.finish()

    def _is_idle(self) -> bool:
        """Side jobs do not count, nor does an evaluation that has to wait for the first scene."""
        has_evaluated = not self.has_scene or self._evaluations.waiting is None
        return self._scenes.is_idle and self._evaluations.current is None and has_evaluated

    def _due_s(self) -> float | None:
        return self._side.due_s() if self.has_scene and not self._waits else None

    # ------------------------------------------------------------------ told by the thread in the midst of work
    def take_evaluation(self) -> EvaluationRequest | None:
        """Begin, in the midst of a load, with the evaluation that waits; `finish_evaluation` ends it."""
        with self.lock:
            return self._take_evaluation()

    def wanted_evaluation(self) -> EvaluationRequest | None:
        """The evaluation that waits, or else the last one; it goes on waiting."""
        with self.lock:
            return self._evaluations.waiting or self._last

    def finish_evaluation(self) -> None:
        """The evaluation in the midst of a load is done."""
        with self.lock:
            self._evaluations.finish()

    def take_aside(self, request: SideJob) -> bool:
        """A side job is done; whether its answer is still wanted."""
        with self.lock:
            is_wanted = self._side.wants(request)
            self._side.done(request)
            return is_wanted

    def put_off_aside(self, request: SideJob) -> bool:
        """A part of a side job is done, and all others go first; whether the rest is still wanted."""
        with self.lock:
            self._side.put_off(request)
            return self._side.wants(request)

    def repeat_last(self) -> None:
        """There is a new scene: the last evaluation is to be made on it, unless a newer one waits."""
        with self.lock:
            self.has_scene = True
            if self._evaluations.waiting is None and self._last is not None:
                self._evaluations.put(self._last)

    # ------------------------------------------------------------------ whether to give up
    def is_other_scene_wanted(self) -> bool:
        """Whether another load waits."""
        with self.lock:
            return self._scenes.waiting is not None

    def is_load_unwanted(self) -> bool:
        """Whether the load under way is to be given up."""
        with self.lock:
            return self._closing or self._cancel_load or self._scenes.waiting is not None

    def is_followed(self) -> bool:
        """Whether anything newer waits: it will get a coarse answer at once, so nobody is left without numbers."""
        return self.is_followed_within(0.0)

    def is_followed_within(self, seconds: float) -> bool:
        """Whether anything newer comes within so long."""
        with self.lock:
            end_s = self._clock.now_s() + seconds
            while not self._is_followed() and self._clock.now_s() < end_s:
                self._clock.wait(self.lock, end_s)
            return self._is_followed()

    def _is_followed(self) -> bool:
        return self._closing or self._evaluations.waiting is not None

    def is_stale(self) -> bool:
        """Whether to give up: somebody waits for a final answer, and the last request was not given up.

        A preview never drives out a running evaluation, and never are two given up in a row: otherwise
        a fast mouse could keep every number from being finished.
        """
        with self.lock:
            wanted = self._evaluations.waiting
            return self._closing or (wanted is not None and not wanted.is_preview and not self.gave_up_last)

    def gives_way(self, request: SideJob) -> bool:
        """Whether a side job has to let something more important go first, or is not wanted any more."""
        with self.lock:
            return self._closing or not self._is_idle() or not self._side.wants(request)
