"""Evaluate a rig in a scene, once, for every figure."""

from __future__ import annotations

import copy
import dataclasses
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from riglens.core.blind.zones import BlindEngine, BlindMap, BlindSettings
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.errors import IsStale, never_stale
from riglens.core.geometry import Pose
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.targets.traffic import Traffic

Need = Literal["voxels", "objects", "ground"]
"""Parts of an evaluation that a figure may read."""
BLIND_M = 0.3
"""Height of the object that must be seen around the car, where none is given: a crawling child."""


@dataclass(frozen=True)
class EvaluationSettings:
    """Settings of voxels, of objects and of the ground, with the height of the object whose blind area is measured."""

    metric: MetricSettings = PAPER_SETTINGS
    targets: TargetSettings = USUAL
    blind: BlindSettings = dataclasses.field(default_factory=BlindSettings)
    blind_m: float = BLIND_M


@dataclass(frozen=True, eq=False)
class Evaluated:
    """All that is known of a rig in a scene: the voxels that its sensors see, its hits on objects, and the ground that
    it sees around the car; None for what was not evaluated."""

    rig: Rig
    settings: EvaluationSettings
    field: EntropyField | None = None
    voxels: Evaluation | None = None
    objects: Counted | None = None
    ground: BlindMap | None = None

    @property
    def voxels_region(self) -> str:
        """The voxels that count, in words."""
        if self.field is None:
            return "no voxels"
        length, width, height = self.field.grid.roi_m
        return f"voxels of {length:g} m × {width:g} m × {height:g} m around the car"

    @property
    def objects_region(self) -> str:
        """The objects that count, in words."""
        return "no objects" if self.objects is None else f"objects within {self.objects.within_m:g} m"

    @property
    def ground_region(self) -> str:
        """The ground that counts, in words."""
        return f"ground within {self.settings.blind.within_m:g} m of the car's outline"


class _Engines:
    """The engines of a scene, each made when it is first needed; with `first`, those of other rigs beside its own,
    which count objects in any one thread."""

    def __init__(self, evaluator: Evaluator, first: _Engines | None = None) -> None:
        self._field, self._traffic = evaluator.field, evaluator.traffic
        self._threads, self._first = evaluator.threads, first
        self._around: tuple[Vehicle, BlindSettings, BlindEngine] | None = None

    @cached_property
    def voxels(self) -> Engine:
        """The engine of voxels."""
        assert self._field is not None
        return Engine(self._field, self._threads) if self._first is None else self._first.voxels

    @cached_property
    def voxels_anew(self) -> Engine:
        """An engine of voxels that holds no sensor on its own."""
        assert self._field is not None
        return Engine(self._field, self._threads, for_edits=False)

    @cached_property
    def objects(self) -> TargetEngine:
        """The engine of objects."""
        assert self._traffic is not None
        if self._first is not None:
            return self._first.objects.beside(threads=1)
        return TargetEngine(self._traffic, self._threads)

    def ground_of(self, rig: Rig, settings: BlindSettings) -> BlindEngine:
        """Return the engine of the ground around a rig's car; it stays until there is another car."""
        key = (rig.vehicle, settings)
        if self._around is None or self._around[:2] != key:
            self._around = (*key, BlindEngine(*key, self._threads))
        return self._around[2]


@dataclass
class Evaluator:
    """Evaluates one rig after another in one scene: only what an edit changes is cast again.

    field: for figures of voxels, traffic: for those of objects, None without. For one thread, that of the parallel
    kernels unless `threads` is 1.
    """

    field: EntropyField | None = None
    traffic: Traffic | None = None
    settings: EvaluationSettings = EvaluationSettings()
    threads: int | None = None
    _engines: _Engines = dataclasses.field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._engines = _Engines(self)

    def __call__(
        self,
        rig: Rig,
        needs: tuple[Need, ...] = ("voxels", "objects"),
        frames: int | range | None = None,
        stance: Pose = Pose(),
        cancel: IsStale = never_stale,
        settings: EvaluationSettings | None = None,
        with_seen: bool = False,
        anew: bool = False,
    ) -> Evaluated:
        """Evaluate a rig for figures with these needs, as far as the scene has what they take.

        frames: of the sampling order in which objects are counted, all by default; stance: of the car, for a rig whose
        poses are those of a car that stands otherwise than on level ground; settings: other ones than the evaluator's;
        with_seen: keep the voxels that the sensors of each kind see; anew: evaluate voxels from scratch, which is
        faster when every sensor has moved, and keep what is held of the previous rig.
        Raise Cancelled as soon as `cancel` returns True.
        """
        how = settings or self.settings
        found = Evaluated(rig, how, self.field)
        if "voxels" in needs and self.field is not None:
            engine = self._engines.voxels_anew if anew else self.voxels
            voxels = engine.evaluate(rig, how.metric, with_seen, stance, cancel)
            found = replace(found, voxels=voxels)
        if "objects" in needs and self.traffic is not None:
            objects = self._engines.objects.evaluate(rig, how.targets, frames, stance, cancel)
            found = replace(found, objects=objects)
        if "ground" in needs:
            found = replace(found, ground=self.ground_of(rig, how.blind).evaluate(rig, (), stance))
        return found

    def by(self, settings: EvaluationSettings) -> Evaluator:
        """Return this evaluator by other settings: its engines serve both, called from the same thread."""
        other = copy.copy(self)
        other.settings = settings
        return other

    def beside(self) -> Evaluator:
        """Return an evaluator of other rigs: the objects that this one has counted for a sensor stay, and are used by
        both. Call it from the same thread; objects alone from any, while that one evaluates voxels."""
        other = copy.copy(self)
        other._engines = _Engines(self, self._engines)
        return other

    @property
    def voxels(self) -> Engine:
        """The engine of voxels."""
        return self._engines.voxels

    def ground_of(self, rig: Rig, settings: BlindSettings) -> BlindEngine:
        """Return the engine of the ground around a rig's car."""
        return self._engines.ground_of(rig, settings)
