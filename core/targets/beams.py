"""The rays of a sensor in the order in which the kernels look for the few that can meet a box."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels import codes
from riglens.core.kernels.targets import Beams
from riglens.core.kernels.windows import TURN
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Sensor, rays_of
from riglens.core.sensing.rays import Lattice, is_listed, lattice, local_directions

Doubles = NDArray[np.float64]
_BLOCK_RAYS = 16
_CLOSEST_M = 1e-3
"""What comes nearer to a camera than this and stands partly behind it may be cut."""
_NOWHERE = {"position": (0.0, 0.0, 0.0), "rpy_deg": (0.0, 0.0, 0.0), "range_m": (0.0, math.inf)}
_NO_ENDS = np.zeros(0)


def beams_of(sensor: Sensor, ends_m: Doubles | None = None) -> Beams:
    """The rays of a sensor for the kernels; ends_m (rays,): where the car's own body stops each of them, inf: nowhere.

    Rays are numbered row * columns + column over the whole lattice, missing ones of a lens included.
    """
    table = _tables(rays_of(sensor).model_copy(update=_NOWHERE))
    return table._replace(
        origin=np.array(sensor.position, np.float64),
        rotation=sensor.pose.rotation(),
        reach=np.array(sensor.range_m, np.float64),
        ends=_NO_ENDS if ends_m is None else ends_m,
    )


def azimuth_step_rad(lidar: Lidar) -> float:
    """The step between azimuths: the median one of listed azimuths, 0 where there is a single one."""
    if isinstance(lidar.azimuths_deg, EvenAngles):
        turn = lidar.azimuths_deg
        return math.radians((turn.to - turn.from_) / turn.count)
    steps = np.diff(np.unique(lidar.azimuths()))
    return math.radians(float(np.median(steps))) if steps.size else 0.0


@lru_cache(maxsize=16)
def _tables(sensor: Sensor) -> Beams:
    """The beams of a sensor that stands nowhere: the same through a whole drag."""
    return _lidar(sensor) if isinstance(sensor, Lidar) else _camera(sensor)


def _lidar(lidar: Lidar) -> Beams:
    columns = lidar.azimuths().size
    shift = np.radians(lidar.azimuth_offsets_deg or np.zeros(lidar.beam_count))
    return _beams(
        _table(lidar),
        columns,
        np.radians(lidar.elevations()),
        np.radians(lidar.azimuths()) % TURN,
        shift,
        True,
    )


def _camera(camera: Camera) -> Beams:
    table, (columns, rows) = _table(camera), camera.cast
    if table.kind == codes.LISTED:
        beams = _beams(table, columns, np.zeros(0), np.zeros(0), np.zeros(0), False)
        return beams._replace(blocks=_blocks(table.rows, columns))
    beams = _beams(table, columns, table.rows[:, 0], table.planes[:, 0], np.zeros(rows), False)
    steepest = math.sqrt(1.0 + np.abs(table.rows[:, 0]).max() ** 2 + np.abs(table.planes[:, 0]).max() ** 2)
    return beams._replace(least=0.5 * _CLOSEST_M / steepest)


def _table(sensor: Sensor) -> Lattice:
    if not is_listed(sensor):
        return lattice(sensor)
    every = local_directions(sensor, np.arange(sensor.ray_count))
    return Lattice(codes.LISTED, np.ascontiguousarray(every), np.zeros((1, 2)))


def _beams(
    table: Lattice, columns: int, row_at: Doubles, column_at: Doubles, shift: Doubles, turns: bool
) -> Beams:
    row_of, column_of = np.argsort(row_at, kind="stable"), np.argsort(column_at, kind="stable")
    return Beams(
        table.kind, turns, table.rows, table.planes, columns, np.zeros(3), np.eye(3), np.zeros(2),
        row_at[row_of], row_of, column_at[column_of], column_of, shift, _NO_ENDS, np.zeros((0, 7)), 0.0,
    )  # fmt: skip


def _blocks(directions: Doubles, columns: int) -> Doubles:
    """Cones around short runs of rays along the rows of a listed lattice, (b, 7); runs without any ray are left out."""
    cones = []
    for row in range(0, len(directions), columns):
        for start in range(row, row + columns, _BLOCK_RAYS):
            count = min(_BLOCK_RAYS, row + columns - start)
            there = directions[start : start + count]
            there = there[~np.isnan(there[:, 0])]
            if len(there):
                cones.append([*_cone(there), start, count])
    return np.array(cones, np.float64).reshape(-1, 7)


def _cone(directions: Doubles) -> list[float]:
    """Axis, cosine and sine of the half angle of a cone around unit directions (k, 3)."""
    axis = directions.mean(axis=0)
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        return [1.0, 0.0, 0.0, -1.0, 0.0]
    axis /= length
    cos = min(1.0, max(-1.0, float((directions @ axis).min()) - 1e-12))
    return [*axis.tolist(), cos, math.sqrt(1.0 - cos * cos)]
