"""The rays of a sensor in the order in which the kernels look for the few that can meet a box."""

from __future__ import annotations

import math
from functools import lru_cache, singledispatch

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects.box_frames import Beams
from riglens.core.kernels.objects.windows import TURN
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Sensor, rays_of
from riglens.core.sensing.body_ends import barrier_ends
from riglens.core.sensing.rays import is_listed, lattice, local_directions
from riglens.core.vehicle.solid import Barrier

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
Words = NDArray[np.uint64]
_BLOCK_RAYS = 16
_CLOSEST_M = 1e-3
"""What comes nearer to a camera than this and stands partly behind it may be cut."""
_NOWHERE = {"position": (0.0, 0.0, 0.0), "rpy_deg": (0.0, 0.0, 0.0)}
_NOTHING, _NO_BLOCKS, _NO_WORDS = np.zeros(0), np.zeros((0, 7)), np.zeros(0, np.uint64)
NOT_STOPPED = _NOTHING
"""Ends of rays that nothing of the car stops."""


def beams_of(sensor: Sensor, law: Doubles = _NOTHING, ends_m: Doubles = _NOTHING) -> Beams:
    """The rays of a sensor for the kernels; law as in `kernels.objects.box_frames.Beams`; ends_m (rays,): where the
    car's own body stops each of them, inf: nowhere. Without them all rays return, and nothing stops them.

    Rays are numbered row * columns + column over the whole lattice, missing ones of a lens included.
    """
    table = _tables(rays_of(sensor).model_copy(update=_NOWHERE))
    return table._replace(
        origin=np.array(sensor.position, np.float64),
        rotation=sensor.pose.rotation(),
        law=law,
        ends=ends_m,
        stops=_stop_bits(table, ends_m),
    )


def _stop_bits(table: Beams, ends_m: Doubles) -> Words:
    """Which rays of a camera with straight rows and columns are stopped, as in `kernels.objects.box_frames.Beams`."""
    if table.turns or table.stride or not ends_m.size:
        return _NO_WORDS
    columns = table.columns
    is_stopped = np.isfinite(ends_m).reshape(-1, columns)[table.row_of][:, table.column_of]
    bits = np.zeros((len(table.row_of), (columns + 63) // 64 * 64), np.bool_)
    bits[:, :columns] = is_stopped
    return np.packbits(bits, bitorder="little").view(np.uint64)


def stops_of(sensor: Sensor, barrier: Barrier, workers: int = 1) -> Doubles:
    """Where the car's own body stops each ray of the whole lattice (rays,), metres, inf: nowhere; (0,) if none is.

    Azimuths as they are listed: a ray that is turned by a spin phase, by less than an azimuth step, ends where its
    listed one does.
    """
    found = barrier_ends(sensor, barrier, workers)
    if not np.isfinite(found).any():
        return NOT_STOPPED
    if len(found) == sensor.ray_count:
        return found
    every = np.full(sensor.ray_count, np.inf)
    every[~np.isnan(local_directions(sensor, np.arange(sensor.ray_count))[:, 0])] = found
    return every


@singledispatch
def azimuth_step_rad(_: Sensor) -> float:
    """The step between azimuths: the median one of listed azimuths, 0 where there is a single one or none."""
    return 0.0


@azimuth_step_rad.register
def _azimuth_step_rad(lidar: Lidar) -> float:
    if isinstance(lidar.azimuths_deg, EvenAngles):
        turn = lidar.azimuths_deg
        return math.radians((turn.to - turn.from_) / turn.count)
    steps = np.diff(np.unique(lidar.azimuths()))
    return math.radians(float(np.median(steps))) if steps.size else 0.0


@lru_cache(maxsize=16)
def _tables(sensor: Sensor) -> Beams:
    """The beams of a sensor that stands nowhere: the same through a whole drag."""
    return _made(sensor)


@singledispatch
def _made(sensor: Sensor) -> Beams:
    return _listed(sensor)


@_made.register
def _camera(camera: Camera) -> Beams:
    sees_all = camera.range_m == (0.0, math.inf)
    return _pinhole(camera) if sees_all and not is_listed(camera) else _listed(camera)


@_made.register
def _lidar(lidar: Lidar) -> Beams:
    azimuth_at, elevation = np.radians(lidar.azimuths()) % TURN, np.radians(lidar.elevations())
    row_of, column_of = np.argsort(elevation, kind="stable"), np.argsort(azimuth_at, kind="stable")
    beams = _beams(lidar, np.tan(elevation[row_of]), row_of, azimuth_at[column_of], column_of)
    beams = beams._replace(turns=True)
    if lidar.azimuth_offsets_deg is not None:
        beams = beams._replace(shift=np.radians(lidar.azimuth_offsets_deg)[row_of] % TURN)
        rays = row_of[:, None] * column_of.size + column_of
        return _with_listed(beams, local_directions(lidar, rays.ravel()))
    table = lattice(lidar)
    x, y = table.planes[column_of].T
    return beams._replace(
        x=x.copy(), y=y.copy(), z=np.ones_like(x), scale=np.ascontiguousarray(table.rows[row_of])
    )


def _pinhole(camera: Camera) -> Beams:
    """Directions with x = 1: their lengths decide nothing while the range has no ends."""
    table = lattice(camera)
    z, y = table.rows[:, 0], table.planes[:, 0]
    row_of, column_of = np.argsort(z, kind="stable"), np.argsort(y, kind="stable")
    beams = _beams(camera, z[row_of], row_of, y[column_of], column_of)
    one = np.ones_like(y)
    scale = np.stack([np.ones_like(z), z[row_of]], axis=1)
    longest = math.sqrt(1.0 + np.abs(z).max() ** 2 + np.abs(y).max() ** 2)
    cos = 1.0 / longest * (1.0 - 1e-12)
    field = np.array([cos, math.sqrt(1.0 - cos * cos)])
    return beams._replace(
        x=one, y=y[column_of], z=one, scale=scale, field=field, least=0.5 * _CLOSEST_M / longest
    )


def _listed(sensor: Sensor) -> Beams:
    """Any rays, looked for in short runs along their rows."""
    columns, rows = sensor.resolution
    beams = _beams(sensor, np.zeros(0), np.arange(rows), np.zeros(0), np.arange(columns))
    directions = local_directions(sensor, np.arange(sensor.ray_count))
    known = directions[~np.isnan(directions[:, 0])]
    cos = float(known[:, 0].min()) - 1e-12 if len(known) else 1.0
    field = np.array([cos, math.sqrt(max(0.0, 1.0 - cos * cos))])
    return _with_listed(beams, directions)._replace(blocks=_blocks(directions, columns), field=field)


def _with_listed(beams: Beams, directions: Doubles) -> Beams:
    """Beams whose directions (slots, 3) are listed one by one; what the lens has not becomes zero."""
    x, y, z = np.nan_to_num(directions).T
    scale = np.ones((len(beams.row_of), 2))
    return beams._replace(stride=beams.columns, x=x.copy(), y=y.copy(), z=z.copy(), scale=scale)


def _beams(sensor: Sensor, row_at: Doubles, row_of: Ids, column_at: Doubles, column_of: Ids) -> Beams:
    """Beams without directions yet, in no place."""
    none = np.zeros(0)
    return Beams(
        False, column_of.size, 0, none, none, none, np.ones((0, 2)), np.zeros(3), np.eye(3),
        np.array(sensor.range_m, np.float64), row_at, row_of, column_at, column_of,
        none, none, none, _NO_BLOCKS, np.array([-1.0, 0.0]), 0.0, _NO_WORDS,
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
