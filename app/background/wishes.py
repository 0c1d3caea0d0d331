"""What the interface thread wants of the background thread, and what the latter does: all behind one lock.

There is one slot for an evaluation and one for a scene: a newer wish takes the place of one that waits.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Literal

from riglens.app.background.side_jobs import SideQueue, SideRequest
from riglens.app.evaluation.options import SceneOptions
from riglens.app.evaluation.requests import EvaluationRequest

Work = SceneOptions | SideRequest | Literal["evaluate"]


class Wishes:
    """Asked for and taken up under `lock`. No Qt, no kernels, nothing that takes time."""

    def __init__(self, waits: bool = False) -> None:
        self.lock = threading.Condition()
        self.has_scene = False
        """Whether there is a scene to evaluate rigs on."""
        self.gave_up_last = False
        """Whether the last evaluation was given up."""
        self._wanted: EvaluationRequest | None = None
        self._last: EvaluationRequest | None = None
        self._scene_wanted: SceneOptions | None = None
        self._cancel_load = False
        self._closing = False
        self._waits = waits
        self._is_busy = False
        self._is_loading = False
        self._side = SideQueue()

    # ------------------------------------------------------------------ said by the interface thread
    def begin(self) -> None:
        """Let work begin that waited for this."""
        with self.lock:
            self._waits = False
            self.lock.notify_all()

    def evaluate(self, request: EvaluationRequest) -> None:
        """Want scores."""
        with self.lock:
            self._wanted = request
            self._side.postpone()
            self.lock.notify_all()

    def ask_aside(self, requests: Sequence[SideRequest]) -> None:
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
            self._scene_wanted = request
            self.lock.notify_all()

    def cancel_load(self) -> SceneOptions | None:
        """Want the scene no more; returns it when its load had not begun."""
        with self.lock:
            waiting, self._scene_wanted = self._scene_wanted, None
            self._cancel_load = True
            return None if self._is_loading else waiting

    def close(self) -> None:
        """Want the end of everything."""
        with self.lock:
            self._closing = True
            self.lock.notify_all()

    def wait_until_idle(self, timeout_s: float) -> bool:
        """Block until nothing but side jobs waits or is done; False on timeout."""
        with self.lock:
            return self.lock.wait_for(self._is_idle, timeout_s)

    def _is_idle(self) -> bool:
        waiting = self._scene_wanted is not None or (self._wanted is not None and self.has_scene)
        return not (waiting or self._is_busy)

    # ------------------------------------------------------------------ asked by the background thread
    def next_work(self) -> Work | None:
        """Block until there is something to do, None at the end of everything."""
        with self.lock:
            self.lock.wait_for(lambda: self._closing or not self._waits)
            self._is_busy = self._is_loading = False
            self.lock.notify_all()
            while not (self._closing or not self._is_idle() or self._side_delay_s() == 0.0):
                self.lock.wait(self._side_delay_s())
            if self._closing:
                return None
            side = self._side.first() if self._is_idle() else None
            self._is_busy = side is None
            scene, self._scene_wanted = self._scene_wanted, None
            self._is_loading = scene is not None
            self._cancel_load = False
            return side or scene or "evaluate"

    def _side_delay_s(self) -> float | None:
        """Seconds until a side job is due, None while there is none or no scene to run it on."""
        return self._side.delay_s() if self.has_scene else None

    def take_evaluation(self) -> EvaluationRequest | None:
        """The evaluation that waits, which from now on is the last one."""
        with self.lock:
            request, self._wanted = self._wanted, None
            self._last = request or self._last
            return request

    def take_aside(self, request: SideRequest) -> bool:
        """A side job is done; whether its answer is still wanted."""
        with self.lock:
            is_wanted = self._side.wants(request)
            self._side.done(request)
            return is_wanted

    def repeat_last(self) -> None:
        """There is a new scene: the last evaluation is to be made on it, unless a newer one waits."""
        with self.lock:
            self.has_scene = True
            self._wanted = self._wanted or self._last

    # ------------------------------------------------------------------ whether to give up
    def is_closing(self) -> bool:
        """Whether everything ends."""
        with self.lock:
            return self._closing

    def is_other_scene_wanted(self) -> bool:
        """Whether another load waits."""
        with self.lock:
            return self._scene_wanted is not None

    def is_load_unwanted(self) -> bool:
        """Whether the load under way is to be given up."""
        with self.lock:
            return self._closing or self._cancel_load or self._scene_wanted is not None

    def is_followed(self) -> bool:
        """Whether anything newer waits: it will get a coarse answer at once, so nobody is left without numbers."""
        return self.is_followed_within(0.0)

    def is_followed_within(self, seconds: float) -> bool:
        """Whether anything newer comes within so long."""
        with self.lock:
            return self.lock.wait_for(lambda: self._closing or self._wanted is not None, seconds)

    def is_stale(self) -> bool:
        """Whether to give up: somebody waits for a final answer, and the last request was not given up.

        A preview never drives out a running evaluation, and never are two given up in a row: otherwise
        a fast mouse could keep every number from being finished.
        """
        with self.lock:
            wanted = self._wanted
            return self._closing or (wanted is not None and not wanted.is_preview and not self.gave_up_last)

    def gives_way(self, request: SideRequest) -> bool:
        """Whether a side job has to let something more important go first, or is not wanted any more."""
        with self.lock:
            return self._closing or not self._is_idle() or not self._side.wants(request)
