"""Measure how the order of the paper's rigs depends on the user's choices: grid, rays, reading, weight, frames.

Everything is compared with one reference: the study's voxel edge, 352 x 128 rays per camera, 360 azimuths,
reading `covered`, the requested weight, all frames.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import DEFAULT_LAMBDA, MetricSettings, Reading, s_ms
from riglens.core.rig.model import Camera, LinearAngles, Rig
from riglens.core.rig.presets import CAMERA_GROUPS, LIDAR_GROUPS, PAPER_RIGS, preset
from riglens.core.scene.boxes import CLASSES, BoxBatch, BoxSource, DataReport, Progress
from riglens.core.scene.grid import DEFAULT_VOXEL_M
from riglens.core.scene.pog import build_pog
from riglens.core.study.table1 import tau_and_rho

LIDARS = {group.letters: group.name for group in LIDAR_GROUPS if group.origin == "paper"}
CAMERAS = {group.letters: group.name for group in CAMERA_GROUPS}
LETTERS = {**LIDARS, **CAMERAS}


@dataclass(frozen=True)
class RayLattice:
    """Rays of every camera (columns, rows) and azimuths of every LiDAR."""

    cast: tuple[int, int] = (352, 128)
    azimuths: int = 360

    def applied(self, rig: Rig) -> Rig:
        """Return the rig with these rays."""
        turn = LinearAngles(from_=-180.0, to=180.0, count=self.azimuths)
        changed: Rig = rig.replace(
            sensors=tuple(
                one.replace(cast=self.cast) if isinstance(one, Camera) else one.replace(azimuths_deg=turn)
                for one in rig.sensors
            )
        )
        return changed


@dataclass(frozen=True)
class Ranking:
    """S-MIG in nat of the paper's groups by letter and class; from these S-MS of the eight rigs."""

    s_mig: Mapping[str, Mapping[str, float]]
    camera_weight: float = DEFAULT_LAMBDA

    @cached_property
    def s_ms(self) -> dict[str, dict[str, float]]:
        """S-MS by rig and class."""
        found: dict[str, dict[str, float]] = {}
        for name in PAPER_RIGS:
            cameras, lidars = (self.s_mig[letter] for letter in name.split("+"))
            found[name] = {
                cls: s_ms({"camera": cameras[cls], "lidar": lidars[cls]}, self.camera_weight)
                for cls in CLASSES
            }
        return found

    def figures(self, of: str, cls: str) -> dict[str, float]:
        """Return S-MIG of the groups "lidars" or "cameras", or S-MS of the "rigs", of one class."""
        if of == "rigs":
            return {rig: self.s_ms[rig][cls] for rig in PAPER_RIGS}
        return {letter: self.s_mig[letter][cls] for letter in (LIDARS if of == "lidars" else CAMERAS)}

    def order(self, of: str, cls: str) -> tuple[str, ...]:
        """Return the names by figure, the lowest first; empty when all are equal."""
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


class RankCorrelations(NamedTuple):
    """Rank correlations of the eight rigs' S-MS with those of a reference; None if one has no order."""

    tau: float | None
    rho: float | None


def agreement(one: Ranking, other: Ranking, cls: str) -> RankCorrelations:
    """Return Kendall's tau-b and Spearman's rho over the eight rigs."""
    mine, theirs = (list(ranking.figures("rigs", cls).values()) for ranking in (one, other))
    return RankCorrelations(*tau_and_rho(mine, theirs))


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
    """Sample of as many frames as the data set has, drawn with replacement; frames without boxes are drawn too."""

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
        """Return the data set's report with the boxes of the draw."""
        totals = np.zeros(len(CLASSES), np.int64)
        for batch in self._stored.boxes:
            totals += np.bincount(batch.cls, weights=self.times[batch.frame], minlength=len(CLASSES)).astype(
                int
            )
        boxes = dict(zip(CLASSES, totals.tolist(), strict=True))
        return replace(self._stored.data, boxes=boxes, sha256=self.content_hash)


# ---------------------------------------------------------------- the study

Axis = Literal["default", "rays", "reading", "λ", "δ", "frames"]
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


class Setting(NamedTuple):
    """A setting and the order that it gives; of "frames" the number of the resample, from 1."""

    axis: Axis
    value: float | RayLattice | Reading
    ranking: Ranking


@dataclass(frozen=True)
class MetricStudy:
    """The reference order and all others; entropy of the scene by voxel edge and class; S-MS in nat by class of rigs
    that ask the metric a question, by the name of the question."""

    plan: StabilityPlan
    source: str
    frames: int
    reference: Ranking
    others: tuple[Setting, ...]
    h_total: dict[float, dict[str, float]]
    probes: dict[str, dict[str, float]] = field(default_factory=dict)

    def along(self, axis: Axis) -> list[Setting]:
        """Return the settings of one axis."""
        return [other for other in self.others if other.axis == axis]


def study_metric(
    reference: EntropyField,
    field_at: FieldAt,
    source: BoxSource | None,
    plan: StabilityPlan = StabilityPlan(),
    progress: Progress | None = None,
) -> MetricStudy:
    """Rank the paper's rigs under every setting of the plan; without a `source` no frame is resampled."""
    ranked = partial(rank, camera_weight=plan.camera_weight, threads=plan.threads)
    weights = [weight for weight in WEIGHTS if weight != plan.camera_weight]
    resamples = plan.resamples if source is not None else 0
    steps = 1 + sum(map(len, (plan.lattices, READINGS, weights, plan.edge_factors))) + resamples
    done, others = 0, list[Setting]()

    def part(fraction: float) -> None:
        if progress is not None:
            progress((done + fraction) / steps)

    def add(axis: Axis, value: float | RayLattice | Reading, ranking: Ranking) -> None:
        others.append(Setting(axis, value, ranking))
        end()

    def end() -> None:
        nonlocal done
        done += 1
        part(0.0)

    base = ranked(reference)
    end()
    for lattice in plan.lattices:
        add("rays", lattice, ranked(reference, lattice))
    for reading in READINGS:
        add("reading", reading, ranked(reference, reading=reading))
    for weight in weights:
        add("λ", weight, Ranking(base.s_mig, weight))
    h_total = {plan.voxel_m: _entropies(reference)}
    for edge_m in (factor * plan.voxel_m for factor in plan.edge_factors):
        other = field_at(edge_m, part)
        if other is None:
            end()
        else:
            h_total[edge_m] = _entropies(other)
            add("δ", edge_m, ranked(other))
        del other
    if source is not None and resamples:
        stored = StoredBoxes.read(source)
        for seed in range(resamples):
            drawn = build_pog(ResampledFrames(stored, seed), reference.grid, part)
            add("frames", seed + 1, ranked(EntropyField.from_pog(drawn)))
    data = reference.data
    return MetricStudy(plan, data.source, data.frames, base, tuple(others), h_total, _probes(reference, plan))


def _entropies(scene: EntropyField) -> dict[str, float]:
    return {cls: scene.h_total_nat(number) for number, cls in enumerate(CLASSES)}


def _probes(scene: EntropyField, plan: StabilityPlan) -> dict[str, dict[str, float]]:
    """Score rigs that ask the metric a question: nothing, LiDARs alone, a rig, the same with every LiDAR twice."""
    rig = preset("W+T")
    twins = [lidar.replace(name=f"{lidar.name} again") for lidar in rig.enabled_lidars()]
    rigs = {
        "empty": Rig(name="no sensors"),
        "lidars": preset("Trapezoid"),
        "rig": rig,
        "twins": rig.replace(sensors=(*rig.sensors, *twins)),
    }
    engine = Engine(scene, plan.threads)
    readings: dict[str, Reading] = {"": "covered", ", hits": "hits"}
    found: dict[str, dict[str, float]] = {}
    for name, asked in rigs.items():
        for suffix, reading in readings.items():
            settings = MetricSettings(reading=reading, camera_weight=plan.camera_weight)
            classes = engine.evaluate(asked, settings).scores.classes
            found[name + suffix] = {cls: scores.s_ms for cls, scores in classes.items()}
    return found
