"""Voxels that each method finds for the sensors of a case, and the verdict on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from riglens.core.engine.engine import Engine
from riglens.core.kernels.rays import plain
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Method, MetricSettings
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, pack, unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.study.reference import Mask, exact_cover
from riglens.core.study.simple_methods import grid_rays
from riglens.core.study.stability_cases import RayCase

MethodName = Literal["fast", "plain", "bresenham"]
METHODS: tuple[MethodName, ...] = ("fast", "plain", "bresenham")
Verdict = Literal["ok", "fails", "n.a."]


@dataclass(frozen=True)
class Outcome:
    """Outcome of a method: in words, the verdict, and voxels found, missed and extra if counted."""

    verdict: Verdict
    text: str
    voxels: int | None = None
    missed: int | None = None
    extra: int | None = None


NOT_APPLICABLE = Outcome("n.a.", "n.a.")


@dataclass(frozen=True)
class MethodRow:
    """Case: why it breaks simple methods, the right answer, the results of the methods, rays cast."""

    case: str
    why: str
    exact: str
    outcomes: dict[MethodName, Outcome]
    rays: int | None = None


def rig_of(sensors: tuple[Sensor, ...], name: str = "study") -> Rig:
    """A rig of sensors, numbered so that their names are unique."""
    return Rig(
        name=name,
        sensors=tuple(sensor.replace(name=f"{n} {sensor.kind}") for n, sensor in enumerate(sensors, 1)),
    )


def full_field(grid: VoxelGrid) -> EntropyField:
    """A field in which every voxel counts, with h = ln 2 for all classes."""
    index = VoxelIndex.of(grid, pack(grid, np.ones(grid.shape, np.bool_)))
    data = DataReport("every voxel", 2, dict.fromkeys(CLASSES, 1))
    return EntropyField.from_pog(Pog(grid, data, index, np.ones((index.count, len(CLASSES)), np.uint16)))


def engine_cover(field: EntropyField, rig: Rig, method: Method = "exact", threads: int | None = None) -> Mask:
    """Return the voxels (nx, ny, nz) that the engine finds for a rig."""
    found = Engine(field, threads).evaluate(rig, MetricSettings(method=method))
    return unpack(field.grid, found.seen_by_any())


def plain_cover(grid: VoxelGrid, sensors: tuple[Sensor, ...]) -> Mask:
    """Return the voxels (nx, ny, nz) that plain DDA finds."""
    seen = np.zeros(grid.shape, np.uint8)
    for sensor in sensors:
        rays = grid_rays(sensor, grid)
        plain.walk_dense(rays.origin, rays.directions, rays.near, rays.far, 1, seen)
    found: Mask = seen != 0
    return found


def compared(found: Mask, exact: Mask) -> Outcome:
    """Return the verdict on a set of voxels."""
    missed, extra = int((exact & ~found).sum()), int((found & ~exact).sum())
    parts = [f"{missed:,} missed"] * (missed > 0) + [f"{extra:,} extra"] * (extra > 0)
    verdict: Verdict = "fails" if parts else "ok"
    return Outcome(verdict, ", ".join(parts) or "ok", int(found.sum()), missed, extra)


def judged(case: RayCase, threads: int | None = None, progress: Progress | None = None) -> MethodRow:
    """All methods on one case, against the voxels that rational arithmetic finds."""
    exact = exact_cover(case.grid, case.sensors, progress)
    field, rig = full_field(case.grid), rig_of(case.sensors)
    outcomes: dict[MethodName, Outcome] = {
        "fast": compared(engine_cover(field, rig, "exact", threads), exact),
        "plain": compared(plain_cover(case.grid, case.sensors), exact),
        "bresenham": compared(engine_cover(field, rig, "bresenham", threads), exact),
    }
    rays = sum(sensor.ray_count for sensor in case.sensors)
    return MethodRow(case.name, case.why, f"{int(exact.sum()):,} voxels", outcomes, rays)
