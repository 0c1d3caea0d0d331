"""Compare time and error of methods to find the voxels that one sensor sees: library sensors, upright and tilted.

All ways do the same work: one sensor stands somewhere else than before, and the scores of all classes are due. The
reference is the exact walk of every ray, one by one; RigLens' own method is one of the others. Errors are
missed and extra voxels as shares of the reference's.
"""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from riglens.core.errors import InputError
from riglens.core.geometry import Pose, Vec3
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import Progress
from riglens.core.study.accuracy_cases import (
    Answer,
    Case,
    LatticeName,
    engine_case,
    moved,
    plain_case,
    timed,
    voxel_case,
    walk_case,
    with_lattice,
)
from riglens.core.study.simple_methods import PlainDda, VoxelTests, unknown_to_rough

MethodName = Literal[
    "walk", "fast", "plain", "plain-single", "bresenham", "sampled", "thinned", "rectangles", "centres"
]
POSES_DEG: dict[str, tuple[float, float]] = {"upright": (0.0, 0.0), "tilted": (2.0, -3.0)}
"""Roll and pitch: as drawn, and as brackets and cars really leave a sensor. The heading is that of the place."""
STEPS_VOXELS: dict[str, float] = {"1": 1.0, "1/2": 0.5, "1/4": 0.25, "1/8": 0.125}
THINNER: tuple[LatticeName, ...] = ("1/2", "1/4", "1/8")
MAX_MODELS = 12
REPETITIONS = 5
QUICK_REPETITIONS = 1


@dataclass(frozen=True)
class SensorPoint:
    """One way and its setting (step in voxels, share of the rays): times, and shares of missed and extra voxels."""

    method: MethodName
    setting: str
    rays: int
    times_ms: tuple[float, ...]
    missed: float
    extra: float

    @property
    def median_ms(self) -> float:
        """Return the median time."""
        return statistics.median(self.times_ms)

    @property
    def error(self) -> float:
        """Missed and extra voxels together."""
        return self.missed + self.extra


@dataclass(frozen=True)
class SensorResult:
    """Sensor in one pose: its place, the number of informative voxels it sees, and every method to find them."""

    model: str
    sensor: Sensor
    pose: str
    voxels: int
    points: tuple[SensorPoint, ...]

    def point(self, method: MethodName, setting: str = "") -> SensorPoint:
        """Return the point of a way."""
        return next(p for p in self.points if (p.method, p.setting) == (method, setting))

    @property
    def is_exact(self) -> bool:
        """Return whether RigLens' method finds exactly the voxels of the exact walk."""
        return self.point("fast").error == 0.0


@dataclass(frozen=True)
class SensorStudy:
    """Requested sensors, each in every pose, on one grid."""

    source: str
    frames: int
    sha256: str
    rig: Rig
    voxel_m: float
    threads: int
    repetitions: int
    results: tuple[SensorResult, ...]


class _Entrant(NamedTuple):
    method: MethodName
    setting: str
    rays: int
    case: Case


def sensors_at(rig: Rig, models: Sequence[str]) -> list[Sensor]:
    """Return the library's sensors, each at the place and with the heading of the rig's first one of its kind.

    Raises InputError when the library has no such model, a model is named twice, there are more than MAX_MODELS, or
    the rig has no sensor of its kind.
    """
    if len(models) > MAX_MODELS:
        raise InputError(f"must name at most {MAX_MODELS} models (got {len(models)})", "sensor")
    if twice := [model for number, model in enumerate(models) if model in models[:number]]:
        raise InputError(f"must name each model once (got {twice[0]} twice)", "sensor")
    found: list[Sensor] = []
    for model in models:
        entry = default_library().entry(model)
        places = [sensor for sensor in rig.sensors if sensor.kind == entry.kind]
        if not places:
            raise InputError(
                f"must fit the rig: {rig.name} has no {entry.kind} whose place {model} could take", "sensor"
            )
        at = Pose(places[0].position, (0.0, 0.0, places[0].rpy_deg[2]))
        found.append(entry.sensor(model, at).replace(enabled=True))
    return found


def in_pose(sensor: Sensor, pose: str) -> Sensor:
    """Return the sensor with roll and pitch of a pose of POSES_DEG."""
    rpy_deg: Vec3 = (*POSES_DEG[pose], sensor.rpy_deg[2])
    return sensor.replace(rpy_deg=rpy_deg)


def study_sensors(
    field: EntropyField,
    rig: Rig,
    models: Sequence[str],
    threads: int = 1,
    repetitions: int = REPETITIONS,
    progress: Progress | None = None,
) -> SensorStudy:
    """Measure every way for sensors of the library in every pose of POSES_DEG, at places of `rig`.

    `threads` are those of the ways that can use several. Raises InputError as `sensors_at`, or when memory is short.
    """
    sensors, shared = sensors_at(rig, models), Shared(field, jit.use_threads(threads))
    stages = [(sensor, pose) for sensor in sensors for pose in POSES_DEG]
    results = []
    for number, (sensor, pose) in enumerate(stages):

        def part(share: float, done: int = number) -> None:
            if progress is not None:
                progress((done + share) / len(stages))

        results.append(_measured(shared, sensor.name, in_pose(sensor, pose), pose, repetitions, part))
    data = field.data
    return SensorStudy(
        data.source, data.frames, data.sha256, rig, field.grid.voxel_m, shared.threads, repetitions, tuple(results)
    )  # fmt: skip


class Shared:
    """State shared by the methods compared: the field, dense grids and lists of its voxels, the number of threads."""

    def __init__(self, field: EntropyField, threads: int) -> None:
        self.field, self.threads = field, threads
        self.dda, self.tests = PlainDda(field), VoxelTests(field, threads)


def _measured(
    shared: Shared, model: str, sensor: Sensor, pose: str, repetitions: int, progress: Progress
) -> SensorResult:
    """Measure all methods for a sensor in a pose, against the first of them."""
    entrants = _entrants(shared, sensor)
    answers, times = timed([entrant.case for entrant in entrants], repetitions, progress)
    points = [
        SensorPoint(
            entrant.method, entrant.setting, entrant.rays, tuple(ms), *wrong_shares(answers[0], answer)
        )
        for entrant, answer, ms in zip(entrants, answers, times, strict=True)
    ]
    return SensorResult(model, sensor, pose, int((answers[0].seen != 0).sum()), tuple(points))


def wrong_shares(exact: Answer, found: Answer) -> tuple[float, float]:
    """Return missed and extra voxels as shares of the exact ones; 0 where there are none."""
    right, mine = exact.seen != 0, found.seen != 0
    all_right = max(int(right.sum()), 1)
    return int((right & ~mine).sum()) / all_right, int((mine & ~right).sum()) / all_right


def _entrants(shared: Shared, sensor: Sensor) -> list[_Entrant]:
    """Return the exact walk first, then every other way with its settings."""
    field, threads, weight = shared.field, shared.threads, PAPER_SETTINGS.camera_weight
    rig, rays = Rig(name="alone", sensors=(sensor,)), sensor.ray_count

    def edit(rig: Rig, settings: MetricSettings = PAPER_SETTINGS) -> Case:
        return engine_case(field, rig, settings, threads, moved(rig, rig.sensors[0]))

    def dense(real: type[np.float32] | type[np.float64], step_voxels: float | None = None) -> Case:
        return plain_case(field, rig, weight, real, shared.dda, step_voxels)

    found = [
        _Entrant("walk", "", rays, walk_case(field, sensor, PAPER_SETTINGS, threads)),
        _Entrant("fast", "", rays, edit(rig)),
        _Entrant("plain", "", rays, dense(np.float64)),
        _Entrant("plain-single", "", rays, dense(np.float32)),
        _Entrant("bresenham", "", rays, edit(rig, MetricSettings(method="bresenham"))),
    ]
    found += [_Entrant("sampled", name, rays, dense(np.float64, step)) for name, step in STEPS_VOXELS.items()]
    for share in THINNER:
        thinner = with_lattice(rig, share)
        found.append(_Entrant("thinned", share, thinner.sensors[0].ray_count, edit(thinner)))
    if not unknown_to_rough(rig):
        found.append(_Entrant("rectangles", "", rays, voxel_case(shared.tests, rig, weight, "rectangles")))
        found.append(_Entrant("centres", "", rays, voxel_case(shared.tests, rig, weight, "centres")))
    return found
