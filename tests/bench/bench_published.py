"""Edit against the published algorithm: lists and scipy's entropy voxel by voxel, scaled from some rays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import clip_to_roi, sensor_rays
from tests.bench.race import Goal, Race
from tests.bench.scenes import Scenes, moved, names_of, wide_trapezoid
from tests.bench.yardsticks import Voxel, published_entropy, published_points

GOAL = 10_000.0
SAMPLE = 24
ROUNDS = 7


@dataclass(frozen=True)
class _Case:
    rig: Rig
    start: Voxel
    ends: set[str]


@pytest.mark.parametrize("kind", ["lidar", "camera"])
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_edit(race: Race, scenes: Scenes, voxel_m: float, kind: str) -> None:
    scene = scenes.at(voxel_m)
    rig = wide_trapezoid()
    name = names_of(rig, kind)[0]
    rays = rig.sensor(name).ray_count
    engine = scene.engine()
    engine.evaluate(rig)
    probability = [
        _dense_probability(scene.pog.index.ijk(), scene.pog.probability(c), scene.pog.grid) for c in range(3)
    ]

    def published(case: _Case) -> None:
        for cls in range(len(CLASSES)):  # its program casts all rays again for each class
            published_entropy(published_points(case.start, case.ends), probability[cls])

    goal = Goal(
        "edit, published",
        f"one {kind} of W+T moved, {scene.edge}; yardstick: {SAMPLE} of {rays:,} rays, scaled, without its "
        "loop over the whole grid",
        GOAL,
    )
    cases = _cases(rig, name, scene.field.grid)
    race.run(
        goal,
        cases,
        lambda case: engine.evaluate(case.rig, with_seen=False),
        published,
        scale=rays / SAMPLE,
        rounds=ROUNDS,
    )


def _dense_probability(
    ijk: NDArray[np.int32], values: NDArray[np.float64], grid: VoxelGrid
) -> NDArray[np.float32]:
    dense = np.zeros(grid.shape, np.float32)
    dense[tuple(ijk.T)] = values
    return dense


def _cases(rig: Rig, name: str, grid: VoxelGrid) -> Iterator[_Case]:
    """The rig with one sensor moved, and where a random sample of its rays ends, without end."""
    generator = np.random.default_rng(1)
    number = 0
    while True:
        number += 1
        sensor = moved(rig.sensor(name), number)
        rows = generator.choice(sensor.ray_count, SAMPLE, replace=False)
        yield _Case(
            rig.with_sensor(name, sensor), _voxel(grid.to_grid(sensor.position)), _ends(sensor, grid, rows)
        )


def _ends(sensor: Sensor, grid: VoxelGrid, rows: NDArray[np.int64]) -> set[str]:
    """Last voxel of each ray as text."""
    rays = sensor_rays(sensor, rows)
    _, t1_m = clip_to_roi(grid, rays)
    ends_m = np.array(rays.origin_m) + rays.directions * t1_m[:, None]
    inside = np.clip((ends_m - np.array(grid.origin_m)) / grid.voxel_m, 0, np.array(grid.shape) - 1)
    return {";".join(map(str, _voxel(end))) for end in inside}


def _voxel(place: NDArray[np.float64] | tuple[float, float, float]) -> Voxel:
    x, y, z = (int(coordinate) for coordinate in place)
    return x, y, z
