"""Time against error of ways to score a rig: methods on one grid, other voxel edges, other ray lattices.

Two errors. Wrong voxels: missed and extra against the exact set of the rig's own rays on the same grid, as a
share of that set, cameras and LiDARs counted apart. S-MS: the share of the scene's entropy that S-MS stands
for, S-MS / H(Omega), against the exact one on the finest grid; the part of the error that the grid makes and
the part that the shortcut makes are added, so that no shortcut is praised for hiding the error of its grid.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from riglens.core.errors import InputError
from riglens.core.kernels import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.sensing.rays import is_listed
from riglens.core.study.accuracy_errors import Contestant, points_of, with_fronts
from riglens.core.study.accuracy_points import MethodName, Plan, Study
from riglens.core.study.approximations import VoxelTests
from riglens.core.study.cases import (
    Answer,
    Case,
    EngineCase,
    PlainCase,
    VoxelCase,
    has_all_pixels,
    moved,
    ray_count,
    with_lattice,
)

SLOW_MS = 3000.0


def study_accuracy(
    fields: Mapping[float, EntropyField],
    voxel_m: float,
    rig: Rig,
    plan: Plan = Plan(),
    progress: Progress | None = None,
) -> Study:
    """Measure every contestant on the grid `voxel_m` and the exact engine on the other grids of `fields`.

    Repetitions alternate between the contestants after one warm-up round; who takes longer than SLOW_MS runs
    once. InputError when the rig has no sensor that is switched on, or when memory is short.
    """
    require_sensors(rig)
    entrants = list(_contestants(fields, voxel_m, rig, plan))
    answers, times = _timed(entrants, plan.repetitions, progress)
    points = points_of(entrants, answers, times, voxel_m, min(fields))
    data = fields[voxel_m].data
    return Study(rig, data.source, data.frames, voxel_m, min(fields), plan, with_fronts(points))


def require_sensors(rig: Rig) -> None:
    """Raise InputError when no sensor of the rig is switched on, or one is too odd for the rough methods."""
    if not any(sensor.enabled for sensor in rig.sensors):
        raise InputError(f"rig {rig.name}: no sensor is switched on, so there is nothing to measure")
    for sensor in rig.sensors:
        if sensor.enabled and is_listed(sensor):
            raise InputError(
                f"rig {rig.name}: sensor {sensor.name} has lens distortion or azimuth offsets, which the rough methods "
                "of this study do not know; accepted are cameras and LiDARs without"
            )


def _contestants(
    fields: Mapping[float, EntropyField], voxel_m: float, rig: Rig, plan: Plan
) -> list[Contestant]:
    """The rig's own exact score first, then methods, lattices and other grids."""
    field, workers = fields[voxel_m], jit.use_threads(plan.threads)
    settings = MetricSettings(camera_weight=plan.camera_weight)

    def entrant(method: MethodName, case: Case, threads: int = workers) -> Contestant:
        return Contestant(method, "own", ray_count(rig), threads, field, case)

    tests = VoxelTests(field, plan.threads)
    found = [
        entrant("exact", EngineCase(field, rig, settings, plan.threads)),
        *(entrant(method, case) for method, case in _edits(field, rig, settings, plan)),
        entrant("plain", PlainCase(field, rig, plan.camera_weight, np.float64), 1),
        entrant("plain-single", PlainCase(field, rig, plan.camera_weight, np.float32), 1),
        entrant("bresenham", EngineCase(field, rig, replace(settings, method="bresenham"), plan.threads)),
        entrant("rectangles", VoxelCase(tests, rig, plan.camera_weight, "rectangles")),
        entrant("centres", VoxelCase(tests, rig, plan.camera_weight, "centres")),
    ]
    for lattice in plan.lattices:
        if lattice != "all pixels" or not has_all_pixels(rig):
            other = with_lattice(rig, lattice)
            case = EngineCase(field, other, settings, plan.threads)
            found.append(Contestant("exact", lattice, ray_count(other), workers, field, case))
    for edge_m in sorted(set(fields) - {voxel_m}):
        case = EngineCase(fields[edge_m], rig, settings, plan.threads)
        found.append(Contestant("exact", "own", ray_count(rig), workers, fields[edge_m], case))
    return found


def _edits(
    field: EntropyField, rig: Rig, settings: MetricSettings, plan: Plan
) -> list[tuple[MethodName, Case]]:
    """The exact engine after a move of the first camera, and of the first LiDAR."""
    edits: list[tuple[MethodName, Case]] = []
    names: tuple[tuple[MethodName, Sequence[object]], ...] = (
        ("edit-camera", rig.cameras()),
        ("edit-lidar", rig.lidars()),
    )
    for method, sensors in names:
        for sensor in rig.sensors:
            if sensor in sensors[:1]:
                edits.append((method, EngineCase(field, rig, settings, plan.threads, moved(rig, sensor))))
    return edits


def _timed(
    entrants: Sequence[Contestant], repetitions: int, progress: Progress | None
) -> tuple[list[Answer], list[list[float]]]:
    """Answers of a warm-up round, then the times in ms of alternating repetitions."""
    answers: list[Answer] = []
    times: list[list[float]] = [[] for _ in entrants]
    for repetition in range(repetitions + 1):
        for number, entrant in enumerate(entrants):
            if repetition > 1 and times[number][0] > SLOW_MS:
                continue
            entrant.case.prepare()
            started = time.perf_counter()
            entrant.case.run()
            elapsed_ms = (time.perf_counter() - started) * 1e3
            if repetition == 0:
                answers.append(entrant.case.answer())
            else:
                times[number].append(elapsed_ms)
            if progress is not None:
                progress((repetition * len(entrants) + number + 1) / ((repetitions + 1) * len(entrants)))
    return answers, times
