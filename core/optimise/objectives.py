"""Define the problem of a search, and the figures that it may maximise: what sensors cover for each, its worth, and
what the guard compares."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindSettings, called
from riglens.core.engine.caster import Caster
from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.figures.hits import ON_TARGET, TALL
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import PREDICTED
from riglens.core.metric.entropy import EntropyField
from riglens.core.optimise.mounts import NO_ADDITIONS, Additions, Move
from riglens.core.optimise.tables import (
    MOST_CELLS,
    UNIT,
    Cells,
    CoverTable,
    GroundTableMaker,
    HitTableMaker,
    Ids,
    ObjectTableMaker,
    TableMaker,
    hit_shares,
)
from riglens.core.optimise.weights import EVEN, Weights
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Camera, Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import empty_words
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.targets.calibration import Calibration, shipped
from riglens.core.targets.contribution import Contribution
from riglens.core.targets.joining import heights_px
from riglens.core.targets.settings import HEIGHT_PX, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import Solid

BLIND_M = 0.3
"""Height of the object of the objective `blind` where none is given."""


class CameraTableMaker(ObjectTableMaker):
    """Table maker that finds the objects that are 25 px tall or more in a camera's picture, each worth its share."""

    def _numbers(self) -> int:
        return len(self._objects[1])

    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        return np.flatnonzero(heights_px(cast(Camera, sensor), one.found) >= HEIGHT_PX).astype(np.int32)


class SeenTableMaker(TableMaker):
    """Table maker that finds the voxels that LiDARs traverse, each worth its share of the entropy of its classes.

    Shares are averaged over classes, by their weights; for S-MS, entropies of all classes are added up.
    """

    def __init__(
        self,
        field: EntropyField,
        solid: Solid | None,
        workers: int,
        weights: Weights,
        are_added: bool = False,
    ) -> None:
        self._solid, self._caster = solid, Caster(field, workers)
        self._keep = np.flatnonzero(_bits(field.index.words))
        total = np.array(field.totals_q, np.float64)
        by_class = np.where(total > 0.0, total if are_added else weights.by_class, 0.0)
        each = by_class / np.where(total > 0.0, total, 1.0) / (by_class.sum() or 1.0)
        value = np.round(field.entropies_q[:, : len(CLASSES)] @ each * UNIT).astype(np.int64)
        super().__init__(len(self._keep), field.codes(), np.stack([0 * value, value], axis=1), workers)

    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> Cells:
        """Return the numbers of informative voxels."""
        marks = empty_words(self._caster.field.grid)
        for sensor in sensors:
            barrier = None if self._solid is None else barrier_of(sensor, self._solid)
            if not self._caster.mark(sensor, "exact", self._caster.window(sensor), marks, is_stale, barrier):
                raise Cancelled
        return np.flatnonzero(_bits(marks)[self._keep]).astype(np.int32)


def _bits(words: NDArray[np.uint64]) -> NDArray[np.bool_]:
    return np.unpackbits(words.view(np.uint8), bitorder="little").astype(np.bool_)


class WorstFailure:
    """Value of a set with the one sensor failed that it misses most. It is not submodular: greedy choice and bounds of
    such functions do not hold for it.

    table: of candidates, then of each of their sensors by itself, then of the rig's own; alone: places of a
    candidate's sensors; own: those of the rig's.
    """

    def __init__(self, table: CoverTable, alone: Sequence[Sequence[int]], own: Sequence[int]) -> None:
        self._table, self._alone, self._own, self.size = table, alone, list(own), len(alone)

    def _left(self, chosen: Sequence[int]) -> list[list[int]]:
        """Return what is left by each failure."""
        every = [*self._own, *chosen]
        left = [[one for one in every if one != own] for own in self._own]
        for one in chosen:
            others = [*self._own, *(other for other in chosen if other != one)]
            left += [[*others, *(s for s in self._alone[one] if s != lost)] for lost in self._alone[one]]
        return left

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""
        return min((self._table.value(left) for left in self._left(chosen)), default=0)

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set."""
        every = [*self._own, *chosen]
        worst = np.full(len(ids), np.iinfo(np.int64).max)
        for left in self._left(chosen):
            worst = np.minimum(worst, self._table.value(left) + self._table.gains(left, ids))
        value = self._table.value(every)
        for place in range(2):  # one of the sensors that join fails
            others = [[s for s in self._alone[one] if s != self._alone[one][-1 - place :][0]] for one in ids]
            has = np.array([bool(some) for some in others], np.bool_)
            found = np.full(len(ids), value, np.int64)
            if has.any():
                joins = np.array([some[0] for some in others if some], np.int64)
                found[has] += self._table.gains(every, joins)
            worst = np.minimum(worst, found)
        return worst - self.value(chosen)


Doubles = NDArray[np.float64]
Maker = Callable[["Problem", Solid | None, int], TableMaker]


@dataclass(frozen=True)
class Objective:
    """A figure that a search maximises: its words, the maker of its table, the kind of sensors that make it, and the
    same figure of single objects; None for a figure of voxels or of the ground."""

    name: str
    title: str
    maker: Maker
    kind: str = LIDAR.name
    figure: ObjectFigure | None = ON_TARGET

    @property
    def is_guarded(self) -> bool:
        """Return whether the guard compares this figure, not hit coverage in its place."""
        return self.figure is not None


def _hits(problem: Problem, solid: Solid | None, workers: int) -> TableMaker:
    return _by_objects(HitTableMaker, problem, solid, workers, hit_shares())


def _pictures(problem: Problem, solid: Solid | None, workers: int) -> TableMaker:
    return _by_objects(CameraTableMaker, problem, solid, workers, np.tile([0.0, 1.0], (len(CLASSES), 1)))


def _by_objects(
    maker: type[ObjectTableMaker],
    problem: Problem,
    solid: Solid | None,
    workers: int,
    shares: Doubles,
    which: NDArray[np.bool_] | None = None,
) -> TableMaker:
    return maker(
        problem.traffic, problem.frames, problem.settings, solid, workers, problem.weights, shares, which
    )


def _predicted(problem: Problem, solid: Solid | None, workers: int) -> TableMaker:
    calibration, traffic = problem.calibration or shipped(), problem.traffic
    if calibration.unit != "cells":
        raise InputError("must be a calibration by cells, not by points", "calibration")
    box = np.flatnonzero(traffic.counts[: traffic.starts[problem.frames]])
    cells = np.arange(MOST_CELLS + 1)
    every = np.ones(len(cells), np.bool_)
    shares = np.array(
        [
            calibration.of_objects(np.full(len(cells), cls, np.uint8), every, cells)
            for cls in range(len(CLASSES))
        ]
    )
    has = ~np.isnan(shares[:, 0])
    inside = calibration.domain.holds(traffic.centre_m[box]) & has[traffic.cls[box]]
    return _by_objects(HitTableMaker, problem, solid, workers, np.nan_to_num(shares), inside)


def _seen(are_added: bool) -> Maker:
    def make(problem: Problem, solid: Solid | None, workers: int) -> TableMaker:
        assert problem.voxels is not None
        return SeenTableMaker(problem.voxels, solid, workers, problem.weights, are_added)

    return make


def _ground(problem: Problem, solid: Solid | None, workers: int) -> TableMaker:
    engine = BlindEngine(problem.rig.vehicle, BlindSettings(), workers)
    return GroundTableMaker(problem.rig, engine, problem.blind_m or BLIND_M, workers, is_share=True)


WORST = "worst_failure"
OF_VOXELS = ("seen", "s_ms")
"""Objectives of a scene of voxels."""
HIT_COVERAGE = Objective("on_target", "on target", _hits)
OBJECTIVES = {
    one.name: one
    for one in (
        HIT_COVERAGE,
        Objective("predicted", "predicted AP", _predicted, figure=PREDICTED),
        Objective(WORST, "on target with any one LiDAR failed", _hits),
        Objective("seen", "entropy seen by LiDARs", _seen(False), figure=None),
        Objective("s_ms", "S-MS, as a share of all entropy,", _seen(True), figure=None),
        Objective("blind", "share of the ground where a low object is seen", _ground, "any", None),
        Objective("cameras", "share of objects of 25 px or more", _pictures, CAMERA.name, TALL),
    )
}  # fmt: skip


def sensors_for(objective: Objective, rig: Rig) -> tuple[Sensor, ...]:
    """Return the enabled sensors of a rig that make a figure."""
    kinds = (objective.kind,) if objective.kind != "any" else {sensor.kind for sensor in rig.sensors}
    return tuple(sensor for sensor in rig.sensors if sensor.enabled and sensor.kind in kinds)


@dataclass(frozen=True)
class Problem:
    """Problem of a search: a rig, the sensors that may be added, traffic, and the frames to choose by and to check in.

    Every sensor of the rig stays as it is unless it is among the moves. reference: the rig that gains refer to; without
    it the best of some mounts that a person would choose, or the rig itself where nothing is added. blind_m: height of
    the object whose blind area is the second goal of the front; without it there is none. floors: least values of the
    objective by class. voxels: of the objectives of them; calibration: of predicted detection, by default the one that
    ships; checks: other traffic for the guard, by the name of the case; unmet: returns the requirements that a rig does
    not meet. at_least: value that the set is to reach at the least cost, before it is the best at that cost.
    """

    rig: Rig
    traffic: Traffic
    additions: Additions = NO_ADDITIONS
    objective: str = "on_target"
    frames: int = 100
    held_out: int = 1000
    seed: int = 0
    reference: Rig | None = None
    blind_m: float | None = None
    moves: tuple[Move, ...] = ()
    weights: Weights = EVEN
    floors: Mapping[str, float] = field(default_factory=dict)
    voxels: EntropyField | None = None
    calibration: Calibration | None = None
    checks: Mapping[str, Traffic] = field(default_factory=dict)
    unmet: Callable[[Rig], tuple[str, ...]] | None = None
    at_least: float | None = None

    def __post_init__(self) -> None:
        if self.objective not in OBJECTIVES:
            known = ", ".join(one for one in OBJECTIVES if one != "s_ms")
            raise InputError(f"must be one of {known} (got '{self.objective}')", "objective")
        self._check_sensors()
        self._check_figures()
        if not 2 <= self.frames <= 1000:
            raise InputError(f"must be between 2 and 1000 (got {self.frames})", "frames")
        if self.held_out < 2:
            raise InputError(f"must be at least 2 (got {self.held_out})", "held_out")
        if not 0 <= self.seed < 1 << 62:
            raise InputError(f"must be between 0 and 2^62 - 1 (got {self.seed})", "seed")
        if self.frames + 2 > self.traffic.frames:
            most = self.traffic.frames - 2
            raise InputError(
                f"must be at most {most}, to leave frames for checking (got {self.frames})", "frames"
            )
        if self.at_least is not None and not 0.0 < self.at_least <= 1.0:
            raise InputError(f"must be above 0 and at most 1 (got {self.at_least:g})", "at_least")
        if self.blind_m is not None and not 0.05 <= self.blind_m <= 2.0:
            raise InputError(f"must be between 0.05 and 2 m (got {self.blind_m:g})", "blind_m")

    @property
    def goal(self) -> Objective:
        """Return the objective."""
        return OBJECTIVES[self.objective]

    def _check_figures(self) -> None:
        """Raise InputError for floors that the objective does not have, and for a missing scene."""
        for name, floor in self.floors.items():
            if name not in CLASSES:
                raise InputError(f"must name one of {', '.join(CLASSES)} (got '{name}')", "floor")
            if not 0.0 <= floor <= 1.0:
                raise InputError(f"{name} must be between 0 and 1 (got {floor:g})", "floor")
        if self.floors and (not self.goal.is_guarded or self.objective == WORST):
            raise InputError(f"must be left out: {self.objective} is not a figure by class", "floor")
        if self.objective in OF_VOXELS and self.voxels is None:
            raise InputError(f"needs a scene of voxels for {self.objective}", "objective")

    def _check_sensors(self) -> None:
        """Raise InputError unless the search adds or moves sensors that the objective measures, each once."""
        models = self.additions.models
        if not models and not self.moves:
            raise InputError("must name at least one sensor model, or a sensor to move", "add")
        exchanged = [model for move in self.moves for model in move.models]
        for model in (*models, *exchanged):
            entry = default_library().entry(model)
            if self.goal.kind not in ("any", entry.kind):
                wanted = called(self.goal.kind)
                raise InputError(f"{model} must be a {wanted} (got a {entry.kind})", "add")
        for model in self.additions.costs:
            if model not in (*models, *exchanged):
                known = ", ".join((*models, *exchanged))
                raise InputError(f"{model} must be one of the models to add: {known}", "cost")
        moved = set[str]()
        there = [sensor.name for sensor in sensors_for(self.goal, self.rig)]
        for move in self.moves:
            if move.sensor not in there:
                known, wanted = ", ".join(there) or "none", called(self.goal.kind)
                raise InputError(
                    f"must name an enabled {wanted} of the rig: {known} (got '{move.sensor}')", "move"
                )
            names = {sensor.name for sensor in move.sensors_of(self.rig)}
            if names & moved:
                raise InputError(f"must name each sensor or mirror pair once (got '{move.sensor}')", "move")
            moved |= names

    @property
    def count(self) -> int:
        """Return how many candidates may be added, at most."""
        return self.additions.count if self.additions.models else 0

    @property
    def last(self) -> int:
        """Return the end of the held-out frames."""
        return min(self.frames + self.held_out, self.traffic.frames)

    @property
    def settings(self) -> TargetSettings:
        """Settings of the counting, in which a candidate keeps its draws."""
        return TargetSettings(seed=self.seed, body=self.rig.body, calibration=self.calibration)
