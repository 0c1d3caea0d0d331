"""Scores of rigs on one loaded scene: the exact engine, and a coarser one that answers first where it is slow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from riglens.core.blind.zones import BlindEngine, BlindMap, BlindSettings
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.engine.inspect import sees_voxel
from riglens.core.engine.sight import Sight, sight
from riglens.core.figures.heatmaps import NO_WORDS, Heatmaps, Marks, VoxelHeatMap
from riglens.core.figures.registry import voxel_heat_map, voxel_set_named
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.estimate import estimated
from riglens.core.metric.scores import Method, MetricSettings, Scores
from riglens.core.metric.voxel import Voxel, VoxelFacts, voxel_facts
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.columns import Words
from riglens.core.scene.pog import Pog, coarse_pog
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Solid
from riglens.core.view.display import DisplayGrid
from riglens.core.view.outlook import widest_gap
from riglens.core.view.top_view import TopView
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
        self._threads = threads
        self._coarse_above_ms = coarse_above_ms
        self._engine = Engine(scene.field, threads)
        self._top_views = TopViews(scene.field)
        self._costs, self._coarse_costs = EditCosts(), EditCosts()
        self._baseline: _Baseline | None = None
        self._reporter = VoxelReporter(scene.heatmaps.display.pog)
        self._coarse: Engine | None = None
        self._others: Engine | None = None
        self._was_slow = False
        self._known: tuple[MetricSettings, Scores, Scores] | None = None
        self._around: tuple[Vehicle, BlindEngine] | None = None

    # ------------------------------------------------------------------ exact
    def exact(self, request: EvaluationRequest, cancel: Cancel) -> Result:
        """Return the exact result; raise Cancelled when `cancel` returns True half-way."""
        heat = voxel_heat_map(request.heat)
        has_seen = (heat is not None and heat.of_rig) or request.map_by is not None
        settings = with_known_body(request.settings, request.rig)
        evaluation = self._engine.evaluate(request.rig, settings, has_seen, cancel=cancel)
        self._costs.note(request.rig, evaluation.elapsed_ms)
        seen = NO_WORDS if heat is None else heat.sets(self._engine, evaluation)
        top_view = self._top_view(request, evaluation)
        picked = self._picked(request, evaluation)
        # last: the engine may hold its sensors afterwards
        baseline = self._baseline_of(request, evaluation, heat)
        marks = Marks(seen, baseline.seen, baseline.rig.name)
        drawn = None if heat is None else self.scene.heatmaps.drawn(heat, request.heat_class, marks)
        blind = self._blind_map(request.rig) if request.blind else None
        return Result(request, self.scene, evaluation, baseline.scores, drawn, top_view, picked, marks, blind)

    def _top_view(self, request: EvaluationRequest, evaluation: Evaluation) -> TopView | None:
        """Return the map from above of the evaluation just made, if requested."""
        if request.map_by is None:
            return None
        seen = voxel_set_named(request.map_by).of(self._engine, evaluation)
        cls = CLASSES.index(request.heat_class)
        return self._top_views.view(cls, request.heat_class, request.map_by, seen)

    def _picked(self, request: EvaluationRequest, evaluation: Evaluation) -> PickedVoxel | None:
        """Return the picked voxel as the latest evaluation sees it."""
        voxel = request.voxel
        if voxel is None or any(i >= n for i, n in zip(voxel, self.scene.field.grid.shape, strict=True)):
            return None
        blocks = evaluation.settings.body == "blocks"
        solid = car_of(request.rig) if blocks else None
        asked = VoxelRequest(request.settings.method, voxel, solid, request.is_preview)
        return self._reporter.report(self._engine, request.rig, asked)

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
                found = self._engine.evaluate(rig, with_known_body(settings, rig), heat is not None)
                self._costs.note(rig, found.elapsed_ms)
            seen = NO_WORDS if heat is None else heat.sets(self._engine, found)
            known = self._baseline = _Baseline(rig, settings, found.scores, heat, seen)
        return known

    def _blind_map(self, rig: Rig) -> BlindMap:
        """Return the blind zones around the car, which is solid once its mesh has been read; an engine follows edits
        until there is another car."""
        if self._around is None or self._around[0] != rig.vehicle:
            settings = BlindSettings(body=known_body(rig, "blocks"))
            self._around = rig.vehicle, BlindEngine(rig.vehicle, settings, self._threads)
        return self._around[1].evaluate(rig)

    def other(self, rig: Rig, settings: MetricSettings, cancel: Cancel) -> Scores:
        """Return the exact scores of a rig other than the one being edited; raise Cancelled when `cancel` returns True.

        It uses a second engine, so the next edit still casts only what it changes.
        """
        if self._others is None:
            self._others = Engine(self.scene.field, self._threads)
        return self._others.evaluate(rig, with_known_body(settings, rig), False, cancel=cancel).scores

    # ------------------------------------------------------------------ coarse
    def is_slow(self, request: EvaluationRequest) -> bool:
        """Return whether the exact answer is expected to take longer than a frame, and a coarse one clearly less."""
        exact_ms = self._costs.expected_ms(request.rig)
        coarse_ms = self._coarse_costs.expected_ms(request.rig)
        worth = STILL_WORTH if self._was_slow else WORTH
        self._was_slow = exact_ms > self._coarse_above_ms and coarse_ms <= worth * exact_ms
        return self._was_slow

    def is_measured(self, request: EvaluationRequest) -> bool:
        """Return whether the expectation rests on times of the very sensors that have to be cast."""
        return not self._costs.is_guess(request.rig)

    def approximate(self, request: EvaluationRequest, cancel: Cancel) -> Approximation | None:
        """Return a coarse result; None when there is nothing to estimate it from."""
        settings = with_known_body(request.settings, request.rig)
        coarse = self.scene.coarse
        if coarse is None or self._known is None or not _same_sets(self._known[0], settings):
            return None
        found = self._evaluate_coarse(request.rig, request.settings, cancel)
        scores = estimated(found.scores, *self._known[1:], request.settings)
        if scores is None:
            return None
        return Approximation(request, scores, coarse.grid.voxel_m, found.elapsed_ms)

    def learn(self, result: Result, cancel: Cancel) -> None:
        """Base the next coarse estimates on an exact answer.

        Nothing is done where no sensor is slow, so that quick scenes pay nothing.
        """
        request = result.request
        if self.scene.coarse is None or self._costs.slowest_ms(request.rig) <= self._coarse_above_ms:
            return
        found = self._evaluate_coarse(request.rig, request.settings, cancel)
        self._known = (result.evaluation.settings, found.scores, result.evaluation.scores)

    def _evaluate_coarse(self, rig: Rig, settings: MetricSettings, cancel: Cancel) -> Evaluation:
        assert self.scene.coarse is not None
        if self._coarse is None:
            self._coarse = Engine(self.scene.coarse, self._threads)
        # an estimate needs only what is seen
        covered = replace(with_known_body(settings, rig), reading="covered")
        found = self._coarse.evaluate(rig, covered, False, cancel=cancel)
        self._coarse_costs.note(rig, found.elapsed_ms)
        return found

    @property
    def has_learnt(self) -> bool:
        """Return whether there is an exact answer from which coarse ones can be estimated."""
        return self._known is not None


def _same_sets(one: MetricSettings, other: MetricSettings) -> bool:
    """Return whether both settings see the same voxels; reading and weight only add them up in other ways."""
    return (one.method, one.body) == (other.method, other.body)


class VoxelRequest(NamedTuple):
    """Request about a voxel: its place, method and body; a preview leaves out new reasons."""

    method: Method
    voxel: Voxel
    solid: Solid | None
    is_preview: bool


class VoxelReporter:
    """Reporter of one voxel while the rig changes; reasons are kept for sensors that stay."""

    def __init__(self, pog: Pog) -> None:
        self._pog = pog
        self._kept: dict[tuple[Sensor, Voxel, Solid | None], Sight] = {}

    def report(self, engine: Engine, rig: Rig, asked: VoxelRequest) -> PickedVoxel:
        """Return the voxel as the engine's last evaluation, of this rig, sees it."""
        voxel = asked.voxel
        facts = voxel_facts(self._pog, voxel)
        if not facts.is_informative:
            return PickedVoxel(facts, ())
        kept, self._kept = self._kept, {}
        sights = []
        for sensor in rig.sensors:
            sees = sensor.enabled and bool(sees_voxel(engine, sensor, asked.method, voxel))
            found = kept.get((sensor, voxel, asked.solid))
            if found is None or (found.verdict == "sees") != sees:
                found = self._look(sensor, facts, sees, asked)
            if found.verdict != "missed":
                self._kept[sensor, voxel, asked.solid] = found
            sights.append(found)
        return PickedVoxel(facts, tuple(sights))

    def _look(self, sensor: Sensor, facts: VoxelFacts, sees: bool, asked: VoxelRequest) -> Sight:
        if asked.is_preview and sensor.enabled and not sees:
            away = np.array(facts.centre_m) - np.array(sensor.position)
            return Sight(sensor.name, "missed", float(np.linalg.norm(away)))
        barrier = None if asked.solid is None else barrier_of(sensor, asked.solid)
        return sight(sensor, self._pog.grid, facts.voxel, sees, barrier)
