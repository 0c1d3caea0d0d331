"""The one background thread: evaluates rigs and loads box data, always for the latest wish.

Every Numba kernel of the window runs here, because parallel kernels must not be called from two threads.
There is one pending slot and no timer: a newer request takes the place of a waiting one. Results return by
signals that carry their request, and the window drops those older than what it shows.
"""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace

from PySide6.QtCore import QObject, Signal

from app.heatmap import Heatmaps, HeatMode
from app.options import SceneOptions
from app.scenario import load_field
from core.engine.engine import Engine, Evaluation
from core.errors import InputError
from core.metric.entropy import EntropyField
from core.metric.scores import MetricSettings, Scores
from core.rig.model import Rig
from core.scene.boxes import CLASSES, Progress
from core.scene.display import DisplayGrid
from widgets.viewport.heatmap_layer import HeatmapData

CANCELLED = "Loading was cancelled."


@dataclass(frozen=True)
class LoadedScene:
    """Box data ready for use: the entropy of every informative voxel, and a coarser grid to draw."""

    options: SceneOptions
    field: EntropyField
    heatmaps: Heatmaps


def load_scene(options: SceneOptions, progress: Progress) -> LoadedScene:
    """Read the boxes or the stored POG; InputError on bad input."""
    pog, field = load_field(options, progress)
    return LoadedScene(options, field, Heatmaps(DisplayGrid.build(pog, field)))


SceneLoader = Callable[[SceneOptions, Progress], LoadedScene]
"""Turns options into a scene on the background thread; InputError on bad input."""


@dataclass(frozen=True)
class EvaluationRequest:
    """Everything one evaluation depends on; `saved_rig` is what the changes are counted from."""

    revision: int
    rig: Rig
    saved_rig: Rig
    settings: MetricSettings
    heat: HeatMode = "off"
    heat_class: str = CLASSES[0]
    is_preview: bool = False

    def asks_same(self, other: EvaluationRequest) -> bool:
        """Whether the answer to both is the same, whatever revision they belong to."""
        return replace(self, revision=other.revision, is_preview=other.is_preview) == other


@dataclass(frozen=True)
class Result:
    """The answer to one request: scores now and of the saved rig, and the heatmap to draw."""

    request: EvaluationRequest
    scene: LoadedScene
    evaluation: Evaluation
    saved_scores: Scores
    heatmap: HeatmapData | None


class _Cancelled(Exception):
    """Raised inside a load that nobody wants any more."""


class Recompute(QObject):
    """Owner of the background thread; every method is called from the interface thread.

    Every request is answered unless a newer one took its place; after a load the last one is answered again.
    `close` must be called before the object goes away.
    """

    evaluated = Signal(object)
    scene_loaded = Signal(object)
    load_progress = Signal(float)
    load_ended = Signal(str)
    """A load is over; the text is empty after success, and after a cancel or an error says which."""
    failed = Signal(str)

    def __init__(self, loader: SceneLoader = load_scene, threads: int | None = None) -> None:
        super().__init__()
        self._loader = loader
        self._threads = threads
        self._condition = threading.Condition()
        self._wanted: EvaluationRequest | None = None
        self._last: EvaluationRequest | None = None
        self._scene_wanted: SceneOptions | None = None
        self._cancel_load = False
        self._closing = False
        self._is_busy = False
        self._is_loading = False
        self._gave_up_last = False
        self._scene: LoadedScene | None = None
        self._engine: Engine | None = None
        self._saved: tuple[Rig, MetricSettings, Scores] | None = None
        self._thread = threading.Thread(target=self._run, name="recompute", daemon=True)
        self._thread.start()

    # ------------------------------------------------------------------ called by the interface thread
    def evaluate(self, request: EvaluationRequest) -> None:
        """Ask for scores; takes the place of a request that still waits."""
        with self._condition:
            self._wanted = request
            self._condition.notify_all()

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
        """Block until nothing waits or runs; False on timeout. Results may still be queued as Qt events."""
        with self._condition:
            return self._condition.wait_for(self._is_idle, timeout_s)

    def close(self) -> None:
        """Give up all work and end the thread."""
        with self._condition:
            self._closing = True
            self._condition.notify_all()
        self._thread.join()

    def _is_idle(self) -> bool:
        waiting = self._scene_wanted is not None or (self._wanted is not None and self._engine is not None)
        return not (waiting or self._is_busy)

    # ------------------------------------------------------------------ the thread
    def _run(self) -> None:
        while True:
            with self._condition:
                self._is_busy = self._is_loading = False
                self._condition.notify_all()
                self._condition.wait_for(lambda: self._closing or not self._is_idle())
                if self._closing:
                    return
                self._is_busy = True
                scene_wanted, self._scene_wanted = self._scene_wanted, None
                self._is_loading = scene_wanted is not None
                self._cancel_load = False
            if scene_wanted is not None:
                self._load(scene_wanted)
            else:
                self._evaluate_wanted()

    def _load(self, request: SceneOptions) -> None:
        self.load_progress.emit(0.0)
        try:
            scene = self._loader(request, self._report_progress)
            self._stop_if_unwanted()
            engine = Engine(scene.field, self._threads)
        except _Cancelled:
            outcome = CANCELLED
        except InputError as error:
            outcome = str(error)
        except Exception as error:
            outcome = _unexpected(error)
        else:
            self.scene_loaded.emit(scene)
            with self._condition:
                self._scene, self._engine, self._saved = scene, engine, None
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
        if self._engine is None or self._scene is None:
            return
        with self._condition:
            request, self._wanted = self._wanted, None
            self._last = request or self._last
        if request is None:
            return
        try:
            result = self._evaluate(self._engine, self._scene, request)
        except Exception as error:
            self.failed.emit(_unexpected(error))
        else:
            self._gave_up_last = result is None
            if result is not None:
                self.evaluated.emit(result)

    def _evaluate(self, engine: Engine, scene: LoadedScene, request: EvaluationRequest) -> Result | None:
        evaluation = engine.evaluate(request.rig, request.settings, self._is_stale)
        if evaluation is None:
            return None
        saved_scores = self._scores_of_saved(engine, request, evaluation)
        heatmap = scene.heatmaps.heatmap(request.heat, request.heat_class, evaluation)
        return Result(request, scene, evaluation, saved_scores, heatmap)

    def _is_stale(self) -> bool:
        """Whether to give up: somebody waits for a final answer, and the last request was not given up.

        A preview never drives out a running evaluation, and never are two given up in a row: otherwise
        a fast mouse could keep every number from being finished.
        """
        with self._condition:
            wanted = self._wanted
            return self._closing or (wanted is not None and not wanted.is_preview and not self._gave_up_last)

    def _scores_of_saved(self, engine: Engine, request: EvaluationRequest, evaluation: Evaluation) -> Scores:
        """Scores of the saved rig under the same settings; computed once per save, settings and scene."""
        if request.rig == request.saved_rig:
            self._saved = (request.saved_rig, request.settings, evaluation.scores)
        elif self._saved is None or self._saved[:2] != (request.saved_rig, request.settings):
            saved = engine.evaluate(request.saved_rig, request.settings)
            assert saved is not None
            self._saved = (request.saved_rig, request.settings, saved.scores)
        assert self._saved is not None
        return self._saved[2]


def _unexpected(error: Exception) -> str:
    """One line for the user; the traceback goes to standard error for the person who mends it."""
    traceback.print_exception(error, file=sys.stderr)
    return f"Unexpected failure in the background: {type(error).__name__}: {error}"
