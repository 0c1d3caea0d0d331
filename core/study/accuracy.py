"""Compare time and error of methods to score a rig: methods on one grid, other voxel edges, other ray lattices.

Two errors. Wrong voxels: missed and extra against the exact set of the rig's own rays on the same grid, as a
share of that set, cameras and LiDARs counted apart. S-MS: the share of the scene's entropy in S-MS, S-MS / H(Omega),
against the exact one on the finest grid; the part of the error that the grid makes and
the part that the shortcut makes are added, so that no shortcut is praised for hiding the error of its grid.
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from riglens.core.errors import InputError
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import DEFAULT_LAMBDA, MetricSettings
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.study.accuracy_cases import (
    Answer,
    Case,
    LatticeName,
    engine_case,
    has_all_pixels,
    moved,
    plain_case,
    ray_count,
    timed,
    voxel_case,
    with_lattice,
)
from riglens.core.study.simple_methods import FLAGS, KINDS, PlainDda, VoxelTests, unknown_to_rough

MethodName = Literal[
    "exact", "edit-camera", "edit-lidar", "plain", "plain-single", "bresenham", "rectangles", "centres"
]
REPETITIONS = 5
LATTICES: tuple[LatticeName, ...] = ("1/2", "1/4", "1/8", "all pixels")
ROUNDING = 1e-12
"""Relative differences below this are the rounding of doubles, not an error."""


@dataclass(frozen=True)
class AccuracyPlan:
    """Plan of the measurements: repetitions of each case, threads (all by default), lattices."""

    repetitions: int = REPETITIONS
    threads: int | None = None
    camera_weight: float = DEFAULT_LAMBDA
    lattices: tuple[LatticeName, ...] = LATTICES


class Wrong(NamedTuple):
    """Missed and extra voxels as shares of the exact set, per kind of sensor and together."""

    missed_camera: float
    missed_lidar: float
    missed: float
    extra_camera: float
    extra_lidar: float
    extra: float


class ScoreError(NamedTuple):
    """Errors of a class, None if H(Omega) or the reference is 0: -S-MS / H(Omega), the errors of grid and shortcut as
    parts of the reference's share, and the raw |S-MS - reference| / |reference| in nats."""

    share: float | None
    grid_error: float | None
    shortcut_error: float | None
    raw_error: float | None

    @property
    def both(self) -> float | None:
        """Errors of grid and shortcut together."""
        known = self.grid_error is not None and self.shortcut_error is not None
        return (self.grid_error or 0.0) + (self.shortcut_error or 0.0) if known else None


@dataclass(frozen=True)
class Point:
    """Point of a (method, voxel edge, ray lattice): its times and its errors.

    wrong: None on other grids than the study's own, where it is 0 by definition; errors: of S-MS per class.
    """

    method: MethodName
    voxel_m: float
    lattice: LatticeName
    rays: int
    threads: int
    times_ms: tuple[float, ...]
    s_ms: dict[str, float]
    wrong: Wrong | None
    errors: dict[str, ScoreError]
    on_voxel_front: bool = False
    on_score_front: bool = False

    @property
    def median_ms(self) -> float:
        """Median time."""
        return statistics.median(self.times_ms)

    @property
    def from_scratch(self) -> bool:
        """Return whether the time covers the whole rig; for edits it does not, so they stay off the fronts."""
        return not self.method.startswith("edit")

    @property
    def voxel_error(self) -> float | None:
        """Missed and extra voxels together."""
        return None if self.wrong is None else self.wrong.missed + self.wrong.extra

    @property
    def score_error(self) -> float:
        """Error of S-MS / H(Omega) of the worst class, grid and shortcut added."""
        sums = (error.both for error in self.errors.values())
        return max((both for both in sums if both is not None), default=0.0)

    @property
    def is_own(self) -> bool:
        """Return whether this is the exact engine with the rig's own rays."""
        return self.method == "exact" and self.lattice == "own"


@dataclass(frozen=True)
class AccuracyStudy:
    """All points; shortcuts are compared on the grid `voxel_m`, scores are held to the grid `finest_m`."""

    rig: Rig
    source: str
    frames: int
    voxel_m: float
    finest_m: float
    plan: AccuracyPlan
    points: tuple[Point, ...]

    @property
    def own(self) -> Point:
        """Return the point of the exact engine on the study's own grid, with the rig's own rays."""
        return next(p for p in self.points if p.is_own and p.voxel_m == self.voxel_m)

    @property
    def finest(self) -> Point:
        """The reference of the scores."""
        return next(p for p in self.points if p.is_own and p.voxel_m == self.finest_m)


class ComparedMethod(NamedTuple):
    """Method to compare: its grid, its ray lattice, and the case that runs it."""

    method: MethodName
    lattice: LatticeName
    rays: int
    threads: int
    field: EntropyField
    case: Case


# ---------------------------------------------------------------- measuring


def study_accuracy(
    fields: Mapping[float, EntropyField],
    voxel_m: float,
    rig: Rig,
    plan: AccuracyPlan = AccuracyPlan(),
    progress: Progress | None = None,
) -> AccuracyStudy:
    """Measure every method on the grid `voxel_m` and the exact engine on the other grids of `fields`.

    Repetitions alternate between the methods after one warm-up round; one that takes longer than SLOW_MS runs
    once. InputError when the rig has no sensor that is switched on, or when memory is short.
    """
    require_sensors(rig)
    methods = list(_compared_methods(fields, voxel_m, rig, plan))
    answers, times = timed([one.case for one in methods], plan.repetitions, progress)
    points = points_of(methods, answers, times, voxel_m, min(fields))
    data = fields[voxel_m].data
    return AccuracyStudy(rig, data.source, data.frames, voxel_m, min(fields), plan, with_fronts(points))


def require_sensors(rig: Rig) -> None:
    """Raise InputError when no sensor of the rig is switched on."""
    if not any(sensor.enabled for sensor in rig.sensors):
        raise InputError(f"rig {rig.name}: no sensor is enabled, so there is nothing to measure")
    if others := [sensor.name for sensor in rig.sensors if sensor.enabled and sensor.kind not in KINDS]:
        raise InputError(f"rig {rig.name}: methods are compared on LiDARs and cameras only (got {others[0]})")


def _compared_methods(
    fields: Mapping[float, EntropyField], voxel_m: float, rig: Rig, plan: AccuracyPlan
) -> list[ComparedMethod]:
    """Return the rig's own exact score first, then methods, lattices and other grids."""
    field, workers = fields[voxel_m], jit.use_threads(plan.threads)
    settings = MetricSettings(camera_weight=plan.camera_weight)

    def one(method: MethodName, case: Case, threads: int = workers) -> ComparedMethod:
        return ComparedMethod(method, "own", ray_count(rig), threads, field, case)

    dda = PlainDda(field)
    found = [
        one("exact", engine_case(field, rig, settings, plan.threads)),
        *(one(method, case) for method, case in _edits(field, rig, settings, plan)),
        one("plain", plain_case(field, rig, plan.camera_weight, np.float64, dda), 1),
        one("plain-single", plain_case(field, rig, plan.camera_weight, np.float32, dda), 1),
        one("bresenham", engine_case(field, rig, replace(settings, method="bresenham"), plan.threads)),
    ]
    if not unknown_to_rough(rig):
        tests = VoxelTests(field, plan.threads)
        found += [
            one("rectangles", voxel_case(tests, rig, plan.camera_weight, "rectangles")),
            one("centres", voxel_case(tests, rig, plan.camera_weight, "centres")),
        ]
    for lattice in plan.lattices:
        if lattice != "all pixels" or not has_all_pixels(rig):
            other = with_lattice(rig, lattice)
            case = engine_case(field, other, settings, plan.threads)
            found.append(ComparedMethod("exact", lattice, ray_count(other), workers, field, case))
    for edge_m in sorted(set(fields) - {voxel_m}):
        case = engine_case(fields[edge_m], rig, settings, plan.threads)
        found.append(ComparedMethod("exact", "own", ray_count(rig), workers, fields[edge_m], case))
    return found


def _edits(
    field: EntropyField, rig: Rig, settings: MetricSettings, plan: AccuracyPlan
) -> list[tuple[MethodName, Case]]:
    """Return the exact engine after a move of the first camera, and of the first LiDAR."""
    firsts: tuple[tuple[MethodName, Sequence[Sensor]], ...] = (
        ("edit-camera", rig.enabled_cameras()[:1]),
        ("edit-lidar", rig.enabled_lidars()[:1]),
    )
    return [
        (method, engine_case(field, rig, settings, plan.threads, moved(rig, sensor)))
        for method, sensors in firsts
        for sensor in sensors
    ]


# ---------------------------------------------------------------- errors and Pareto fronts


def points_of(
    methods: Sequence[ComparedMethod],
    answers: Sequence[Answer],
    times: Sequence[Sequence[float]],
    voxel_m: float,
    finest_m: float,
) -> list[Point]:
    """Return a point per method: its times, and its errors against the exact results among them."""
    exact = {
        one.field.grid.voxel_m: (one.field, answer)
        for one, answer in zip(methods, answers, strict=True)
        if one.method == "exact" and one.lattice == "own"
    }
    own, reference = exact[voxel_m][1], exact[finest_m]
    points = []
    for one, answer, ms in zip(methods, answers, times, strict=True):
        edge_m = one.field.grid.voxel_m
        scored = (one.field, answer)
        errors = (_score_error(scored, exact[edge_m], reference, c) for c in range(len(CLASSES)))
        points.append(
            Point(
                method=one.method,
                voxel_m=edge_m,
                lattice=one.lattice,
                rays=one.rays,
                threads=one.threads,
                times_ms=tuple(ms),
                s_ms=dict(zip(CLASSES, answer.s_ms, strict=True)),
                wrong=wrong_voxels(own.seen, answer.seen) if edge_m == voxel_m else None,
                errors=dict(zip(CLASSES, errors, strict=True)),
            )
        )
    return points


_Scored = tuple[EntropyField, Answer]


def _score_error(mine: _Scored, exact: _Scored, reference: _Scored, cls: int) -> ScoreError:
    share, exact_share, finest_share = (_share(scored, cls) for scored in (mine, exact, reference))
    if share is None or exact_share is None or not finest_share:
        return ScoreError(share, None, None, None)
    in_nats = reference[1].s_ms[cls]
    raw = abs(mine[1].s_ms[cls] - in_nats) / abs(in_nats)
    parts = (abs(exact_share - finest_share) / finest_share, abs(share - exact_share) / finest_share)
    grid, shortcut = (error if error > ROUNDING else 0.0 for error in parts)
    return ScoreError(share, grid, shortcut, raw)


def _share(scored: _Scored, cls: int) -> float | None:
    """Return -S-MS / H(Omega); None without any entropy."""
    field, answer = scored
    total = field.h_total_nat(cls)
    return -answer.s_ms[cls] / total if total else None


def wrong_voxels(exact: np.ndarray, found: np.ndarray) -> Wrong:
    """Return missed and extra voxels of a cover (n,), bits as in FLAGS; shares of the exact ones (0 without any)."""
    counts = []
    for flag in FLAGS.values():
        right, mine = (exact & flag) != 0, (found & flag) != 0
        counts.append((int((right & ~mine).sum()), int((mine & ~right).sum()), int(right.sum())))
    (missed_c, extra_c, all_c), (missed_l, extra_l, all_l) = counts
    both = max(all_c + all_l, 1)
    missed = missed_c / max(all_c, 1), missed_l / max(all_l, 1), (missed_c + missed_l) / both
    return Wrong(*missed, extra_c / max(all_c, 1), extra_l / max(all_l, 1), (extra_c + extra_l) / both)


def pareto_front(costs: Sequence[tuple[float, float]]) -> list[bool]:
    """Return for each pair whether no other is at most as large in both and smaller in one."""
    return [
        not any(other[0] <= mine[0] and other[1] <= mine[1] and other != mine for other in costs)
        for mine in costs
    ]


def with_fronts(points: Sequence[Point]) -> tuple[Point, ...]:
    """Return the points with the Pareto fronts marked, among those that cast the whole rig."""
    voxel = [p for p in points if p.from_scratch and p.voxel_error is not None]
    score = [p for p in points if p.from_scratch]
    on_voxel = pareto_front([(p.median_ms, p.voxel_error or 0.0) for p in voxel])
    on_score = pareto_front([(p.median_ms, p.score_error) for p in score])
    voxel_front = {id(p) for p, on in zip(voxel, on_voxel, strict=True) if on}
    score_front = {id(p) for p, on in zip(score, on_score, strict=True) if on}
    return tuple(
        replace(p, on_voxel_front=id(p) in voxel_front, on_score_front=id(p) in score_front) for p in points
    )
