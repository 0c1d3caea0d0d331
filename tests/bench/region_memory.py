"""Run as a process of its own: peak bytes with 20 sensors on a large region of the bundled town. VOXEL_M

The POG is built at twice the edge, which takes an eighth of the memory, and each of its voxels is cut into eight:
building it at the edge itself would take 13.5 bytes per voxel.
"""

from __future__ import annotations

import sys

import numpy as np

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.model import Rig
from riglens.core.scene.columns import VoxelIndex, empty_words, unpack, words_per_column
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, build_pog
from riglens.core.scene.readers.bundled import bundled_source
from tests.bench.peak import peak
from tests.bench.scenes import THREADS, models, moved, tilted, wide_trapezoid

REGION_M = (200.0, 100.0, 8.0)
ROOF = "velodyne-vls-128"


def cut_in_eight(pog: Pog) -> Pog:
    """The same probabilities on voxels of half the edge."""
    grid = VoxelGrid(pog.grid.voxel_m / 2, pog.grid.roi_m)
    nx, ny, nz = pog.grid.shape
    words, depth = empty_words(grid), words_per_column(grid)
    slabs = words.reshape(nx, 2, 2 * ny, depth)
    occupied, parts = unpack(pog.grid, pog.index.words), []
    first = pog.index.first[:: ny * words_per_column(pog.grid)]
    for ix in range(nx):
        fine = np.repeat(np.repeat(occupied[ix], 2, axis=0), 2, axis=1)
        bits = np.zeros((2 * ny, depth * 64), np.bool_)
        bits[:, : 2 * nz] = fine
        slabs[ix, :] = np.packbits(bits, axis=1, bitorder="little").view(np.uint64)
        numbers = np.zeros((ny, nz), np.int64)
        numbers[occupied[ix]] = np.arange(first[ix], first[ix] + occupied[ix].sum())
        chosen = np.repeat(np.repeat(numbers, 2, axis=0), 2, axis=1)[fine]
        parts += [pog.counts[chosen]] * 2
    return Pog.of(grid, pog.data, VoxelIndex.of(grid, words), np.concatenate(parts))


def twenty_sensors() -> Rig:
    """W+T twice, upright and tilted; a dense LiDAR on the roof takes the place of one LiDAR in each half."""
    sensors, roof = [], models().entry(ROOF)
    for half, rig in (("", wide_trapezoid()), (" tilted", wide_trapezoid(tilted))):
        dense = next(sensor for sensor in rig.sensors if sensor.kind == "lidar")
        for sensor in rig.sensors:
            one = roof.sensor(dense.name, dense.pose) if sensor is dense else sensor
            sensors.append(one.model_copy(update={"name": sensor.name + half}))
    return Rig(sensors=tuple(sensors))


def main(voxel_m: float) -> None:
    """Evaluate, move each sensor once, and print the most that the process ever held, POG and program included, and the
    numbers of informative and of all voxels."""
    rig = twenty_sensors()
    field = EntropyField.from_pog(cut_in_eight(build_pog(bundled_source(), VoxelGrid(2 * voxel_m, REGION_M))))
    engine = Engine(field, THREADS)
    engine.evaluate(rig)
    for number, sensor in enumerate(rig.sensors):
        rig = rig.with_sensor(sensor.name, moved(sensor, number + 1))
        engine.evaluate(rig)
    print(peak(), field.index.count, field.grid.voxel_count)


if __name__ == "__main__":
    main(float(sys.argv[1]))
