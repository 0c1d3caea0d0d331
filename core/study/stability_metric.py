"""How the order of the paper's rigs depends on what a user chooses: grid, rays, reading, weight, frames.

Everything is compared with one reference: the study's voxel edge, 352 x 128 rays per camera, 360 azimuths,
reading `covered`, the weight asked for, all frames.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import DEFAULT_LAMBDA, MetricSettings, Reading
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES, BoxSource, Progress
from riglens.core.scene.grid import DEFAULT_VOXEL_M, VoxelGrid
from riglens.core.scene.pog import build_pog
from riglens.core.study.rankings import Ranking, RayLattice, rank
from riglens.core.study.resampled import ResampledFrames, StoredBoxes

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
class Plan:
    """What is varied: voxel edges as multiples of the study's own, lattices, number of resamples."""

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

    plan: Plan
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
    plan: Plan = Plan(),
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


def _on_one_grid(scene: EntropyField, base: Ranking, plan: Plan, steps: _Steps) -> Iterator[Variation]:
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


def _probes(scene: EntropyField, plan: Plan) -> dict[str, Probe]:
    """Rigs that ask the metric a question: nothing, LiDARs alone, a rig, the same with every LiDAR twice."""
    rig = preset("W+T")
    twins = [lidar.replace(name=f"{lidar.name} again") for lidar in rig.lidars()]
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
    assert answer is not None  # nothing abandons it
    return Probe(rig.name, {cls: scores.s_ms for cls, scores in answer.scores.classes.items()})


def _bootstrap(source: BoxSource, grid: VoxelGrid, plan: Plan, steps: _Steps) -> Iterator[Ranking]:
    """Orders on resampled frames, on the reference grid."""
    stored = StoredBoxes.read(source)
    for seed in range(plan.resamples):
        drawn = build_pog(ResampledFrames(stored, seed), grid, steps.part)
        scene = EntropyField.from_pog(drawn)
        yield rank(scene, camera_weight=plan.camera_weight, threads=plan.threads)
        steps.next()
