"""Scores of rigs on one loaded scene: the exact engine, and a coarser one that answers first where it is slow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from riglens.core.blind.zones import BlindMap, BlindSettings
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.engine.inspect import sees_voxel
from riglens.core.engine.sight import Sight, sight
from riglens.core.errors import never_stale
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator, Need
from riglens.core.figures.heatmaps import NO_WORDS, Heatmaps, Marks, VoxelHeatMap
from riglens.core.figures.registry import voxel_heat_map, voxel_set_named
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.estimate import estimated
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.metric.voxel import Voxel, voxel_facts
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.columns import Words
from riglens.core.scene.pog import Pog, coarse_pog
from riglens.core.sensing.body_ends import Obstacle
from riglens.core.view.display import DisplayGrid
from riglens.core.view.outlook import widest_gap
from riglens.core.view.top_views import TopViews
from riglens.evaluation.edit_costs import EditCosts
from riglens.evaluation.known_body import known_body, with_known_body
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import (
    FRAME_MS,
    Approximation,
    EvaluationRequest,
    LoadedScene,
    PickedVoxel,
    Result,
)
from riglens.evaluation.scenario import load_scenario

WORTH, STILL_WORTH = 0.5, 1.0
"""Coarse answers begin where they take at most this part of the time of exact ones, and then go on up to that
part, so that noise in the times does not have the two take turns within a drag."""
Cancel = Callable[[], bool]
"""Called every few milliseconds: whether to give up."""


def load_scene(options: SceneOptions, progress: Progress) -> LoadedScene:
    """Read the boxes or the stored POG; InputError on bad input."""
    found = load_scenario(options, progress)
    heatmaps = Heatmaps(DisplayGrid.build(found.pog, found.field))
    thinned = coarse_pog(found.pog)
    coarse = EntropyField.from_pog(thinned) if thinned is not None else None
    gap = widest_gap(heatmaps.display)
    return LoadedScene(options, found.field, heatmaps, coarse, found.choice, gap)


@dataclass(frozen=True)
class _Baseline:
    """Baseline of changes; `seen` are the voxels that `heat`, a heatmap against the baseline, takes; empty without."""

    rig: Rig
    settings: MetricSettings
    scores: Scores
    heat: VoxelHeatMap | None
    seen: Words


class Scoring:
    """Both engines on one scene. Called by one thread only."""

    def __init__(self, scene: LoadedScene, threads: int | None, coarse_above_ms: float = FRAME_MS) -> None:
        self.scene = scene
        self._coarse_above_ms = coarse_above_ms
        self._evaluate = Evaluator(scene.field, threads=threads)
        self._others = Evaluator(scene.field, threads=threads)
        self._coarse = Evaluator(scene.coarse, threads=threads)
        self._top_views = TopViews(scene.field)
        self._costs, self._coarse_costs = EditCosts(), EditCosts()
        self._baseline: _Baseline | None = None
        self._reporter = VoxelReporter(scene.heatmaps.display.pog)
        self._was_slow = False
        self._known: tuple[MetricSettings, Scores, Scores] | None = None

    # ------------------------------------------------------------------ exact
    def exact(self, request: EvaluationRequest, cancel: Cancel) -> Result:
        """Return the exact result; raise Cancelled when `cancel` returns True half-way.

        The rig is evaluated first; heatmap, map and picked voxel are views of that.
        """
        heat, top_view = voxel_heat_map(request.heat), None
        found, ground = self._evaluated(request, request.rig, heat, cancel)
        engine = self._evaluate.voxels
        seen = NO_WORDS if heat is None else heat.sets(engine, found)
        if request.map_by is not None:
            on_map, cls = voxel_set_named(request.map_by).of(engine, found), CLASSES.index(request.heat_class)
            top_view = self._top_views.view(cls, request.heat_class, request.map_by, on_map)
        picked = self._reporter.report(engine, found, request.voxel, request.is_preview)
        # last: the engine may hold its sensors afterwards
        baseline = self._baseline_of(request, found, heat)
        marks = Marks(seen, baseline.seen, baseline.rig.name)
        drawn = None if heat is None else self.scene.heatmaps.drawn(heat, request.heat_class, marks)
        return Result(request, self.scene, found, baseline.scores, drawn, top_view, picked, marks, ground)

    def _evaluated(
        self,
        request: EvaluationRequest,
        rig: Rig,
        heat: VoxelHeatMap | None,
        cancel: Cancel = never_stale,
    ) -> tuple[Evaluation, BlindMap | None]:
        """Return the voxels of a rig, those seen too where a view takes them, and its blind zones if requested: around
        the car, which is solid once its mesh has been read."""
        settings = EvaluationSettings(
            with_known_body(request.settings, rig), blind=BlindSettings(body=known_body(rig, "blocks"))
        )
        has_seen = (heat is not None and heat.of_rig) or request.map_by is not None
        needs: tuple[Need, ...] = ("voxels", "ground") if request.blind else ("voxels",)
        found = self._evaluate(rig, needs, cancel=cancel, settings=settings, with_seen=has_seen)
        assert found.voxels is not None
        self._costs.note(rig, found.voxels.elapsed_ms)
        return found.voxels, found.ground

    def _baseline_of(
        self, request: EvaluationRequest, evaluation: Evaluation, heat: VoxelHeatMap | None
    ) -> _Baseline:
        """Return the baseline's scores with its own body; computed once per baseline, settings, scene and heatmap that
        compares with it."""
        rig, settings, known = request.baseline_rig, request.settings, self._baseline
        heat = heat if heat is not None and heat.is_against_baseline else None
        is_known = known is not None and (known.rig, known.settings) == (rig, settings)
        if known is None or not is_known or (heat is not None and heat != known.heat):
            found = evaluation
            if request.rig != rig:
                found, _ = self._evaluated(replace(request, map_by=None, blind=False), rig, heat)
            seen = NO_WORDS if heat is None else heat.sets(self._evaluate.voxels, found)
            known = self._baseline = _Baseline(rig, settings, found.scores, heat, seen)
        return known

    def other(self, rig: Rig, settings: MetricSettings, cancel: Cancel) -> Scores:
        """Return the exact scores of a rig other than the one being edited; raise Cancelled when `cancel` returns True.

        With some sensors of that one switched off nothing is cast. For any other rig a second engine is used, so that
        the next edit still casts only what it changes.
        """
        settings = with_known_body(settings, rig)
        found = self._evaluate.voxels.scores_without(rig, settings)
        return found or self._others.voxels.evaluate(rig, settings, False, cancel=cancel).scores

    def rest(self) -> None:
        """Release what only a series of other rigs uses again; from any thread, where one in use ends as it began."""
        self._others = Evaluator(self.scene.field, threads=self._others.threads)

    # ------------------------------------------------------------------ coarse
    def approximate(self, request: EvaluationRequest, cancel: Cancel) -> Approximation | None:
        """Return a coarse result; None when the exact one is expected within a frame or not clearly later, and when
        there is nothing to estimate it from."""
        exact_ms, coarse_ms = (costs.expected_ms(request.rig) for costs in (self._costs, self._coarse_costs))
        worth = STILL_WORTH if self._was_slow else WORTH
        self._was_slow = exact_ms > self._coarse_above_ms and coarse_ms <= worth * exact_ms
        coarse = self.scene.coarse
        if not self._was_slow or coarse is None or self._known is None:
            return None
        settings, known = with_known_body(request.settings, request.rig), self._known[0]
        # reading and weight only add up the same voxels in other ways
        if (known.method, known.body) != (settings.method, settings.body):
            return None
        found = self._evaluate_coarse(request.rig, settings, cancel)
        scores = estimated(found.scores, *self._known[1:], request.settings)
        if scores is None:
            return None
        is_measured = not self._costs.is_guess(request.rig)
        return Approximation(request, scores, coarse.grid.voxel_m, found.elapsed_ms, is_measured)

    def is_slow(self, rig: Rig) -> bool:
        """Return whether an edit of a sensor takes so long that coarse answers should have a base: quick scenes pay
        nothing."""
        return self.scene.coarse is not None and self._costs.slowest_ms(rig) > self._coarse_above_ms

    def learn(self, result: Result, cancel: Cancel) -> None:
        """Base the next coarse estimates on an exact answer."""
        exact = result.evaluation
        found = self._evaluate_coarse(exact.rig, exact.settings, cancel)
        self._known = (exact.settings, found.scores, exact.scores)

    def _evaluate_coarse(self, rig: Rig, settings: MetricSettings, cancel: Cancel) -> Evaluation:
        # an estimate needs only what is seen
        found = self._coarse.voxels.evaluate(rig, replace(settings, reading="covered"), False, cancel=cancel)
        self._coarse_costs.note(rig, found.elapsed_ms)
        return found

    @property
    def has_learnt(self) -> bool:
        """Return whether there is an exact answer from which coarse ones can be estimated."""
        return self._known is not None


class VoxelReporter:
    """Reporter of one voxel while the rig changes; reasons are kept for sensors that stay."""

    def __init__(self, pog: Pog) -> None:
        self._pog = pog
        self._kept: dict[tuple[Sensor, Voxel, Obstacle | None], Sight] = {}

    def report(
        self, engine: Engine, evaluation: Evaluation, voxel: Voxel | None, is_preview: bool
    ) -> PickedVoxel | None:
        """Return a voxel as the evaluation that the engine has just made sees it, None outside the grid; a preview
        leaves out new reasons."""
        if voxel is None or any(i >= n for i, n in zip(voxel, self._pog.grid.shape, strict=True)):
            return None
        facts, method = voxel_facts(self._pog, voxel), evaluation.settings.method
        if not facts.is_informative:
            return PickedVoxel(facts, ())
        kept, self._kept = self._kept, {}
        sights = []
        for sensor in evaluation.rig.sensors:
            sees = sensor.enabled and bool(sees_voxel(engine, sensor, method, voxel))
            stop = engine.stop_of(sensor, method) if sensor.enabled else None
            found = kept.get((sensor, voxel, stop))
            if found is None or (found.verdict == "sees") != sees:
                if is_preview and sensor.enabled and not sees:
                    away = np.array(facts.centre_m) - np.array(sensor.position)
                    found = Sight(sensor.name, "missed", float(np.linalg.norm(away)))
                else:
                    barrier = None if stop is None else stop.barrier
                    found = sight(sensor, self._pog.grid, voxel, sees, barrier)
            if found.verdict != "missed":
                self._kept[sensor, voxel, stop] = found
            sights.append(found)
        return PickedVoxel(facts, tuple(sights))
