"""Count points and pixels on objects in a separate thread: first in a sample of frames, at rest in all of them.

Its kernels are serial, so that it can run in parallel with the thread that computes the scores. At rest helpers take
some of the frames; during a drag the processors are left to scores and drawing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

from PySide6.QtCore import QObject

from riglens.app.background.queue import BackgroundRequest
from riglens.app.background.worker import CLOSE_S, BackgroundWorker, Context
from riglens.core.errors import InputError
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import FOUND
from riglens.core.figures.registry import object_figures
from riglens.core.figures.values import FigureCells, Values, values_of_objects
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.settings import TargetSettings
from riglens.evaluation.known_body import with_known_body
from riglens.evaluation.options import SceneOptions

if TYPE_CHECKING:  # made by the thread, which loads the compiler
    from riglens.core.targets.counts import Counted
    from riglens.core.targets.engine import TargetEngine
    from riglens.core.targets.ground import GroundView
    from riglens.core.targets.groups import Groups
    from riglens.core.targets.traffic import Traffic

NO_BOXES = "A stored POG holds no objects: load the box data set to count hits on them."
BUDGET_MS = 16.0
"""Approximate time of a sample counted while the mouse moves."""
FEWEST_FRAMES, FIRST_FRAMES, GROWTH = 16, 32, 16
"""Frames of the smallest and of the first sample; the growth of samples at rest until all frames are used."""


@dataclass(frozen=True)
class CountRequest:
    """Request to count the objects of a data set, which may be loaded for the scores meanwhile; `baseline_rig` is the
    reference of changes; with_losses: also what hides objects from cameras, once all frames are counted. Equal
    requests about the same load have the same answer."""

    revision: int = field(compare=False)
    rig: Rig
    baseline_rig: Rig
    settings: TargetSettings
    options: SceneOptions
    is_preview: bool = field(default=False, compare=False)
    with_losses: bool = False

    def is_as(self, other: CountRequest) -> bool:
        """Return whether the answer to both is the same, and is given in the same way."""
        return (self, self.is_preview) == (other, other.is_preview) and self.options is other.options


def figures_beside_scores() -> tuple[ObjectFigure, ...]:
    """Return the figures of objects that are shown with the scores: those that lead, and what is found."""
    return tuple(figure for figure in object_figures() if figure.leads or figure is FOUND)


@dataclass(frozen=True)
class CountAnswer:
    """Answer to one request, from `counted.frames_used` frames; more may follow. Both rigs use the same frames.

    `cells` are the figures next to the scores by key, over all distances. Once all frames were used: `figures` all of
    the rig, `baseline_figures` all of the baseline, `ground` the objects over the ground by class.
    """

    request: CountRequest
    counted: Counted
    baseline: Counted
    cells: Mapping[str, FigureCells]
    figures: Values = field(default_factory=dict)
    baseline_figures: Values = field(default_factory=dict)
    ground: tuple[GroundView, ...] = ()

    @classmethod
    def of(cls, request: CountRequest, counted: Counted, baseline: Counted) -> Self:
        """Make an answer of a rig's and the baseline's counts."""
        from riglens.core.targets.ground import ground_view  # the thread has loaded the compiler

        cells = {one.key: FigureCells.of(one, counted, baseline) for one in figures_beside_scores()}
        found = cls(request, counted, baseline, cells)
        if not found.is_whole:
            return found
        figures = values_of_objects(counted)
        return replace(
            found,
            figures=figures,
            baseline_figures=figures if baseline is counted else values_of_objects(baseline),
            ground=tuple(ground_view(counted, name) for name in CLASSES),
        )

    @property
    def traffic(self) -> Traffic:
        """The traffic whose objects were counted."""
        return self.counted.traffic

    @property
    def is_whole(self) -> bool:
        """Return whether all frames were used."""
        return self.counted.is_whole


@dataclass(frozen=True)
class OtherCount(BackgroundRequest):
    """One more rig to count, in all frames, while no CountRequest waits; answered by its figures of objects, or by None
    if they cannot be counted."""

    rig: Rig
    settings: TargetSettings
    options: SceneOptions


Request = CountRequest | OtherCount
Answer = CountAnswer | Values | None
Counter = BackgroundWorker[Request, Answer]
"""Answers a CountRequest with one CountAnswer after another, an OtherCount in the background."""


def make_counter(
    parent: QObject | None = None,
    budget_ms: float = BUDGET_MS,
    close_s: float = CLOSE_S,
    threads: int | None = None,
) -> Counter:
    """Return a worker that counts."""
    counting = Counting(budget_ms, threads)
    return Counter("counting of objects", counting, parent, close_s, rest=counting.rest)


@dataclass
class _Data:
    """Objects of one data set, with an engine for the rig, one for it during a drag and one for other rigs; compared:
    the baseline counted last in all frames, from which its counts in fewer follow."""

    options: SceneOptions
    traffic: Traffic
    engine: TargetEngine
    dragged: TargetEngine
    others: TargetEngine
    compared: Counted | None = None

    def baseline_of(
        self, rig: Rig, settings: TargetSettings, groups: Groups, cancel: Callable[[], bool]
    ) -> Counted:
        """Return the counts of the baseline on the objects of the first frames."""
        known, any_points = self.compared, replace(settings, min_points=1, calibration=None)
        if (
            known is None
            or known.rig != rig
            or replace(known.settings, min_points=1, calibration=None) != any_points
        ):
            known = self.others.evaluate(rig, settings, groups.span, cancel=cancel)
            self.keep(known)
        return replace(known.first(groups), settings=settings)

    def keep(self, baseline: Counted) -> None:
        """Keep the counts of the baseline, if they are those in all frames."""
        if baseline.is_whole:
            self.compared = replace(baseline, losses=None)


class Counting:
    """Counter of objects in samples of frames; called by one thread."""

    def __init__(self, budget_ms: float, threads: int | None = None) -> None:
        self._budget_ms, self._threads = budget_ms, threads
        self._data: _Data | None = None
        self._frames = FIRST_FRAMES

    def __call__(self, request: Request, context: Context[Answer]) -> Answer:
        """Count a sample at once; when the mouse rests, growing samples until all frames are in."""
        if request.options.pog is not None:
            raise InputError(NO_BOXES)
        data = self._data_of(request.options, context)
        if isinstance(request, OtherCount):
            settings = with_known_body(request.settings, request.rig)
            return values_of_objects(data.others.evaluate(request.rig, settings, cancel=context.is_stale))
        # the first sample is never given up, so that a drag shows numbers
        frames = min(self._frames, data.traffic.frames)
        answer = _counted(data, request, frames, context.is_closing)
        if request.is_preview:
            self._adapt(answer.counted.elapsed_ms, data.traffic.frames)
            return answer
        while frames < data.traffic.frames:
            context.publish(answer)
            frames = min(GROWTH * frames, data.traffic.frames)
            answer = _counted(data, request, frames, context.is_stale)
        for one in (data.dragged, data.others):  # the latter were compared with an earlier rig
            one.forget()
        for one in (data.engine, data.dragged):
            one.rest()
        return answer

    def rest(self) -> None:
        """Release what only a series of other rigs uses again; from any thread, where one in use ends as it began."""
        data = self._data
        if data is not None:
            data.others = data.engine.beside()

    def _adapt(self, elapsed_ms: float, frames: int) -> None:
        """Choose the next sample so that it takes about the budget."""
        if elapsed_ms > self._budget_ms:
            self._frames = max(self._frames // 2, FEWEST_FRAMES)
        elif elapsed_ms < self._budget_ms / 4.0:
            self._frames = min(2 * self._frames, frames)

    def _data_of(self, options: SceneOptions, context: Context[Answer]) -> _Data:
        """Return the objects of a data set, read once; an automatic voxel edge does not affect them."""
        if self._data is None or self._data.options is not options:
            # loads the compiler: not while the window opens
            from riglens.core.targets.engine import TargetEngine
            from riglens.core.targets.traffic import WITHIN_M
            from riglens.evaluation.traffic import load_traffic

            self._data = None
            traffic = load_traffic(options, WITHIN_M, context.stop_if_closing)
            engine = TargetEngine(traffic, self._threads)
            self._data = _Data(options, traffic, engine, engine.beside(threads=1), engine.beside())
        return self._data


def _counted(data: _Data, request: CountRequest, frames: int, cancel: Callable[[], bool]) -> CountAnswer:
    """Count the rig and the baseline in the same frames."""
    settings = with_known_body(request.settings, request.rig)
    with_losses = request.with_losses and frames == data.traffic.frames
    engine = data.dragged if request.is_preview else data.engine
    counted = engine.evaluate(request.rig, settings, frames, cancel=cancel, with_losses=with_losses)
    if request.baseline_rig == request.rig:
        data.keep(counted)
        return CountAnswer.of(request, counted, counted)
    settings = with_known_body(request.settings, request.baseline_rig)
    return CountAnswer.of(
        request, counted, data.baseline_of(request.baseline_rig, settings, counted.groups, cancel)
    )
