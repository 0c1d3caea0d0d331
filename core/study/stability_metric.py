"""Measure how the order of the paper's rigs depends on the user's choices: grid, rays, reading, weight, frames.

Everything is compared with one reference: the study's voxel edge, 352 x 128 rays per camera, 360 azimuths,
reading `covered`, the requested weight, all frames.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import DEFAULT_LAMBDA, MetricSettings, Reading, s_ms
from riglens.core.rig.model import Camera, LinearAngles, Rig, Sensor
from riglens.core.rig.presets import CAMERA_GROUPS, LIDAR_GROUPS, PAPER_RIGS, preset
from riglens.core.scene.boxes import CLASSES, BoxBatch, BoxSource, DataReport, Progress
from riglens.core.scene.grid import DEFAULT_VOXEL_M, VoxelGrid
from riglens.core.scene.pog import build_pog

LIDARS = {group.letters: group.name for group in LIDAR_GROUPS if group.origin == "paper"}
CAMERAS = {group.letters: group.name for group in CAMERA_GROUPS}
LETTERS = {**LIDARS, **CAMERAS}


@dataclass(frozen=True)
class RayLattice:
    """Rays of every camera (columns, rows) and azimuths of every LiDAR."""

    cast: tuple[int, int] = (352, 128)
    azimuths: int = 360

    def applied(self, rig: Rig) -> Rig:
        """The rig with these rays."""
        changed: Rig = rig.replace(sensors=tuple(self._with_rays(sensor) for sensor in rig.sensors))
        return changed

    def _with_rays(self, sensor: Sensor) -> Sensor:
        turn = LinearAngles(from_=-180.0, to=180.0, count=self.azimuths)
        changes = {"cast": self.cast} if isinstance(sensor, Camera) else {"azimuths_deg": turn}
        changed: Sensor = sensor.replace(**changes)
        return changed


@dataclass(frozen=True)
class Ranking:
    """S-MIG in nat of the paper's groups by letter and class; from these S-MS of the eight rigs."""

    s_mig: Mapping[str, Mapping[str, float]]
    camera_weight: float = DEFAULT_LAMBDA

    @cached_property
    def s_ms(self) -> dict[str, dict[str, float]]:
        """S-MS by rig and class."""
        return {name: self._rig(name) for name in PAPER_RIGS}

    def _rig(self, name: str) -> dict[str, float]:
        cameras, lidars = (self.s_mig[letter] for letter in name.split("+"))
        return {
            cls: s_ms({"camera": cameras[cls], "lidar": lidars[cls]}, self.camera_weight) for cls in CLASSES
        }

    def with_weight(self, camera_weight: float) -> Ranking:
        """The same groups with another lambda."""
        return Ranking(self.s_mig, camera_weight)

    def figures(self, of: str, cls: str) -> dict[str, float]:
        """S-MIG of the groups "lidars" or "cameras", or S-MS of the "rigs", of one class."""
        if of == "rigs":
            return {rig: self.s_ms[rig][cls] for rig in PAPER_RIGS}
        return {letter: self.s_mig[letter][cls] for letter in (LIDARS if of == "lidars" else CAMERAS)}

    def order(self, of: str, cls: str) -> tuple[str, ...]:
        """Names by figure, the lowest first; empty when all are equal."""
        figures = self.figures(of, cls)
        return tuple(sorted(figures, key=figures.__getitem__)) if len(set(figures.values())) > 1 else ()


def rank(
    field: EntropyField,
    lattice: RayLattice = RayLattice(),
    reading: Reading = "covered",
    camera_weight: float = DEFAULT_LAMBDA,
    threads: int | None = None,
) -> Ranking:
    """Score the paper's six groups of sensors on a scene."""
    engine, settings = Engine(field, threads), MetricSettings(reading=reading)
    s_mig: dict[str, dict[str, float]] = {}
    for letter, name in LETTERS.items():
        found = engine.evaluate(lattice.applied(preset(name)), settings)
        kind = "lidar" if letter in LIDARS else "camera"
        s_mig[letter] = {cls: getattr(found.scores.classes[cls], kind).s_mig for cls in CLASSES}
    return Ranking(s_mig, camera_weight)


@dataclass(frozen=True)
class Agreement:
    """Rank correlations of the eight rigs' S-MS with those of a reference; None if one has no order."""

    tau: float | None
    rho: float | None


def agreement(one: Ranking, other: Ranking, cls: str) -> Agreement:
    """Kendall's tau-b and Spearman's rho over the eight rigs."""
    mine, theirs = (list(ranking.figures("rigs", cls).values()) for ranking in (one, other))
    if len(set(mine)) == 1 or len(set(theirs)) == 1:
        return Agreement(None, None)
    from scipy import stats  # here, and not above: slow to load, and few commands need it

    tau, rho = stats.kendalltau(mine, theirs).statistic, stats.spearmanr(mine, theirs).statistic
    return Agreement(float(tau), float(rho))


def swapped(one: Ranking, other: Ranking, of: str, cls: str) -> list[tuple[str, str]]:
    """Return the pairs (lower first in `other`) with another order in `one`."""
    mine, theirs = one.figures(of, cls), other.figures(of, cls)
    ordered = other.order(of, cls)
    return [(a, b) for a, b in combinations(ordered, 2) if theirs[a] < theirs[b] and mine[a] >= mine[b]]


# ---------------------------------------------------------------- frames drawn again: the bootstrap


@dataclass(frozen=True)
class StoredBoxes:
    """All boxes of a data set in memory, so that it is read once for many resamples."""

    boxes: tuple[BoxBatch, ...]
    data: DataReport

    @classmethod
    def read(cls, source: BoxSource, progress: Progress | None = None) -> StoredBoxes:
        """Read a data set once; InputError on bad input."""
        boxes = tuple(source.batches(progress))
        return cls(boxes, source.report())


class ResampledFrames:
    """As many frames as the data set has, drawn with replacement; frames without boxes are drawn too."""

    def __init__(self, stored: StoredBoxes, seed: int) -> None:
        self._stored, self._seed = stored, seed
        frames = stored.data.frames
        drawn = np.random.default_rng(seed).integers(0, max(frames, 1), frames)
        self.times = np.bincount(drawn, minlength=frames)
        """Number of times each frame was drawn, (frames,)."""
        self._first = np.concatenate([[0], np.cumsum(self.times)])

    @property
    def name(self) -> str:
        """Name of the data set that was drawn from."""
        return self._stored.data.source

    @property
    def content_hash(self) -> str:
        """Hash of the data set's own and of the draw."""
        return hashlib.sha256(f"{self._stored.data.sha256} {self._seed}".encode()).hexdigest()

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """Yield the boxes of the frames drawn, each copy of a frame as a separate frame."""
        for done, batch in enumerate(self._stored.boxes, 1):
            rows, frame = self._copies(batch.frame)
            yield BoxBatch(
                frame, batch.cls[rows], batch.centre_m[rows], batch.size_m[rows], batch.rotation[rows]
            )
            if progress is not None:
                progress(done / len(self._stored.boxes))

    def _copies(self, frame: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
        """Return the rows to take, as often as their frames were drawn, and the new numbers of their frames."""
        times = self.times[frame]
        rows = np.repeat(np.arange(frame.size), times)
        copy = np.arange(rows.size) - np.repeat(np.cumsum(times) - times, times)
        numbers = self._first[frame[rows]] + copy
        order = np.argsort(numbers, kind="stable")
        return rows[order], numbers[order]

    def report(self) -> DataReport:
        """The data set's report with the boxes of the draw."""
        totals = np.zeros(len(CLASSES), np.int64)
        for batch in self._stored.boxes:
            totals += np.bincount(batch.cls, weights=self.times[batch.frame], minlength=len(CLASSES)).astype(
                int
            )
        boxes = dict(zip(CLASSES, totals.tolist(), strict=True))
        return replace(self._stored.data, boxes=boxes, sha256=self.content_hash)


# ---------------------------------------------------------------- the study

Axis = Literal["δ", "rays", "reading", "λ"]
DEFAULT_LATTICE = RayLattice()
NATIVE = RayLattice((1600, 900))
LATTICES = (
    RayLattice((176, 64)),
    RayLattice((704, 256)),
    NATIVE,
    RayLattice(azimuths=180),
    RayLattice(azimuths=720),
    RayLattice((176, 64), 180),
    RayLattice((704, 256), 720),
)
READINGS: tuple[Reading, ...] = ("residual", "hits")
WEIGHTS = (0.0, 0.05, 0.2, 0.5, 1.0)
FieldAt = Callable[[float, Progress], EntropyField | None]
"""The scene on a grid of that edge; None when it cannot be had (the edge does not fit, memory is short)."""


@dataclass(frozen=True)
class StabilityPlan:
    """Plan of the variations: voxel edges as multiples of the study's own, lattices, number of resamples."""

    voxel_m: float = DEFAULT_VOXEL_M
    edge_factors: tuple[float, ...] = (4.0, 2.0, 0.5)
    lattices: tuple[RayLattice, ...] = LATTICES
    resamples: int = 20
    camera_weight: float = DEFAULT_LAMBDA
    threads: int | None = None


@dataclass(frozen=True)
class Variation:
    """One setting other than the reference's, and the order that it gives."""

    axis: Axis
    value: float | RayLattice | Reading
    ranking: Ranking


@dataclass(frozen=True)
class Probe:
    """S-MS in nat by class of one rig, for a question about the metric."""

    rig: str
    s_ms: dict[str, float]


@dataclass(frozen=True)
class MetricStudy:
    """The reference order and all others; entropy of the scene by voxel edge and class; probes by name."""

    plan: StabilityPlan
    source: str
    frames: int
    reference: Ranking
    variations: tuple[Variation, ...]
    resamples: tuple[Ranking, ...]
    h_total: dict[float, dict[str, float]]
    probes: dict[str, Probe] = field(default_factory=dict)

    def along(self, axis: Axis) -> list[Variation]:
        """The variations of one axis."""
        return [variation for variation in self.variations if variation.axis == axis]


class _Steps:
    """Progress over steps of equal size."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._total, self._done, self._progress = total, 0, progress

    def part(self, fraction: float) -> None:
        """A fraction of the present step is done."""
        if self._progress is not None:
            self._progress(min(1.0, (self._done + fraction) / self._total))

    def next(self) -> None:
        """The present step is done."""
        self._done += 1
        self.part(0.0)


def study_metric(
    reference: EntropyField,
    field_at: FieldAt,
    source: BoxSource | None,
    plan: StabilityPlan = StabilityPlan(),
    progress: Progress | None = None,
) -> MetricStudy:
    """Rank the paper's rigs under every setting of the plan; without a `source` no frame is resampled."""
    resamples = plan.resamples if source is not None else 0
    steps = _Steps(1 + len(plan.edge_factors) + len(plan.lattices) + len(READINGS) + resamples, progress)
    base = rank(reference, camera_weight=plan.camera_weight, threads=plan.threads)
    probes = _probes(reference, plan)
    steps.next()
    h_total = {plan.voxel_m: _entropies(reference)}
    variations = [*_on_one_grid(reference, base, plan, steps)]
    for factor in plan.edge_factors:
        other = field_at(factor * plan.voxel_m, steps.part)
        if other is not None:
            h_total[factor * plan.voxel_m] = _entropies(other)
            ranking = rank(other, camera_weight=plan.camera_weight, threads=plan.threads)
            variations.append(Variation("δ", factor * plan.voxel_m, ranking))
        del other
        steps.next()
    drawn = tuple(_bootstrap(source, reference.grid, plan, steps)) if source is not None and resamples else ()
    data = reference.data
    return MetricStudy(plan, data.source, data.frames, base, tuple(variations), drawn, h_total, probes)


def _entropies(scene: EntropyField) -> dict[str, float]:
    return {cls: scene.h_total_nat(number) for number, cls in enumerate(CLASSES)}


def _on_one_grid(
    scene: EntropyField, base: Ranking, plan: StabilityPlan, steps: _Steps
) -> Iterator[Variation]:
    """Other lattices, readings and weights on the reference grid."""
    for lattice in plan.lattices:
        ranking = rank(scene, lattice, camera_weight=plan.camera_weight, threads=plan.threads)
        yield Variation("rays", lattice, ranking)
        steps.next()
    for reading in READINGS:
        ranking = rank(scene, DEFAULT_LATTICE, reading, plan.camera_weight, plan.threads)
        yield Variation("reading", reading, ranking)
        steps.next()
    for weight in WEIGHTS:
        if weight != plan.camera_weight:
            yield Variation("λ", weight, base.with_weight(weight))


def _probes(scene: EntropyField, plan: StabilityPlan) -> dict[str, Probe]:
    """Rigs that ask the metric a question: nothing, LiDARs alone, a rig, the same with every LiDAR twice."""
    rig = preset("W+T")
    twins = [lidar.replace(name=f"{lidar.name} again") for lidar in rig.enabled_lidars()]
    rigs = {
        "empty": Rig(name="no sensors"),
        "lidars": preset("Trapezoid"),
        "rig": rig,
        "twins": rig.replace(sensors=(*rig.sensors, *twins)),
    }
    engine = Engine(scene, plan.threads)
    found: dict[str, Probe] = {}
    for name, asked in rigs.items():
        found[name] = _probe(engine, asked, MetricSettings(camera_weight=plan.camera_weight))
        hits = MetricSettings(reading="hits", camera_weight=plan.camera_weight)
        found[f"{name}, hits"] = _probe(engine, asked, hits)
    return found


def _probe(engine: Engine, rig: Rig, settings: MetricSettings) -> Probe:
    answer = engine.evaluate(rig, settings)
    return Probe(rig.name, {cls: scores.s_ms for cls, scores in answer.scores.classes.items()})


def _bootstrap(source: BoxSource, grid: VoxelGrid, plan: StabilityPlan, steps: _Steps) -> Iterator[Ranking]:
    """Orders on resampled frames, on the reference grid."""
    stored = StoredBoxes.read(source)
    for seed in range(plan.resamples):
        drawn = build_pog(ResampledFrames(stored, seed), grid, steps.part)
        scene = EntropyField.from_pog(drawn)
        yield rank(scene, camera_weight=plan.camera_weight, threads=plan.threads)
        steps.next()
