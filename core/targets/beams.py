"""The rays of a sensor in the order in which the kernels look for the few that can meet a box."""

from __future__ import annotations

import math
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.body.stops import set_stops
from riglens.core.kernels.objects.box_frames import Beams
from riglens.core.kernels.objects.windows import TURN
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Sensor, rays_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.body_ends import NO_EMPTY_BOX, barrier_shadow
from riglens.core.sensing.kept import RAYS
from riglens.core.sensing.ray_tiles import IMAGE_COLUMNS, NO_TILES, tiled, tiles_of
from riglens.core.sensing.rays import is_listed, lattice, local_directions
from riglens.core.sensors.kind import Echo
from riglens.core.sensors.registry import kind_of
from riglens.core.sensors.sectors import Sectored
from riglens.core.sensors.sectors import directions as even_directions
from riglens.core.targets.detection_range import SIZES_M
from riglens.core.vehicle.solid import Barrier

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
Words = NDArray[np.uint64]
_CLOSEST_M = 1e-3
"""Objects that come nearer to a camera than this and are partly behind it may be cut."""
_WIDEST_DEG = 89.0
"""Azimuths, to either side, up to which sectors are seen on an image plane: tangents grow without bound."""
_WIDER = 1.0 + 1e-9
_NOWHERE = {"position": (0.0, 0.0, 0.0), "rpy_deg": (0.0, 0.0, 0.0)}
_NOTHING, _NO_WORDS = np.zeros(0), np.zeros((0, 0), np.uint64)
OPAQUE = np.array([0.0, 1.0])
"""Glass that stops all rays of LiDARs, and from which none returns."""
NOT_STOPPED = _NOTHING
"""Ends of rays that nothing of the car stops."""


def beams_of(
    sensor: Sensor, law: Doubles = _NOTHING, glass: Doubles = OPAQUE, ends_m: Doubles = _NOTHING
) -> Beams:
    """Return the rays of a sensor for the kernels; law and glass as in `kernels.objects.box_frames.Beams`; ends_m
    (rays,): distance at which the car's own body stops each of them, inf: never. Without them all rays return, but for
    those that meet glass, and the car stops none.

    Rays are numbered row * columns + column over the whole lattice, missing ones of a lens included.
    """
    return _placed(_tables(rays_of(sensor).model_copy(update=_NOWHERE)), sensor, law, glass, ends_m)


def beams_by_sector(
    sensor: Sensor, law: Doubles = _NOTHING, glass: Doubles = OPAQUE, ends_m: Doubles = _NOTHING
) -> tuple[Beams, ...]:
    """Return the rays of a sensor as `beams_of`, those of each of its sectors apart where rows and columns of these are
    even: each ray is in one of them."""
    tables = _sector_tables(rays_of(sensor).model_copy(update=_NOWHERE))
    return tuple(_placed(table, sensor, law, glass, ends_m) for table in tables)


def _placed(table: Beams, sensor: Sensor, law: Doubles, glass: Doubles, ends_m: Doubles) -> Beams:
    stops, last_ends = _stop_bits(table, ends_m)
    return table._replace(
        origin=np.array(sensor.position, np.float64),
        rotation=sensor.pose.rotation(),
        law=law,
        glass=glass,
        ends=ends_m,
        stops=stops,
        last_ends=last_ends,
    )


def _stop_bits(table: Beams, ends_m: Doubles) -> tuple[Words, Doubles]:
    """Return which rays of images are stopped, and where the last one of each word ends that something may be before,
    as in `kernels.objects.box_frames.Beams`."""
    if table.turns or not ends_m.size:
        return _NO_WORDS, _NOTHING
    words = len(table.row_of) * ((table.columns + 63) // 64)
    bits, last_ends = np.zeros((2, words), np.uint64), np.zeros(words)
    set_stops(ends_m, table.row_of, table.column_of, table.steps, bits, last_ends)
    return bits, last_ends


def stops_of(
    sensor: Sensor, barrier: Barrier, workers: int = 1, empty_box: Doubles = NO_EMPTY_BOX
) -> Doubles:
    """Return the distance at which the car's own body stops each ray of the whole lattice (rays,), metres, inf: never,
    0: somewhere in the empty box, which holds the sensor and no object; (0,) if it stops none.

    Azimuths as they are listed: a ray that is turned by a spin phase, by less than an azimuth step, ends where its
    listed one does.
    """
    shadow = barrier_shadow(sensor, barrier, empty_box, workers)
    if not shadow.is_stopped.any():
        return NOT_STOPPED
    found = np.where(shadow.is_stopped, 0.0, np.inf)
    found[shadow.cut] = shadow.cut_m
    if len(found) == sensor.ray_count:
        return found
    every = np.full(sensor.ray_count, np.inf)
    every[lattice(sensor).exists] = found
    return every


@singledispatch
def azimuth_step_rad(_: Sensor) -> float:
    """Return the step between azimuths: the median one of listed azimuths, 0 where there is a single one or none,
    and for scan patterns, which do not turn."""
    return 0.0


@azimuth_step_rad.register
def _azimuth_step_rad(lidar: Lidar) -> float:
    if lidar.rays is not None:
        return 0.0
    if isinstance(lidar.azimuths_deg, LinearAngles):
        turn = lidar.azimuths_deg
        return math.radians((turn.to - turn.from_) / turn.count)
    steps = np.diff(np.unique(lidar.azimuths()))
    return math.radians(float(np.median(steps))) if steps.size else 0.0


@RAYS.of
def _tables(sensor: Sensor) -> Beams:
    """Return the beams of a sensor without a place: the same throughout a drag."""
    return _made(sensor)


@RAYS.of
def _sector_tables(sensor: Sensor) -> tuple[Beams, ...]:
    """Return the beams of a sensor without a place sector by sector, or all together."""
    parts: list[Beams | None] = [None]
    if isinstance(sensor, Sectored) and not sensor.blocked and kind_of(sensor).directions is even_directions:
        parts = [_sector(sensor, number) for number in range(len(sensor.sectors))]
    found = tuple(part for part in parts if part is not None)
    return found if len(found) == len(parts) else (_tables(sensor),)


@singledispatch
def _made(sensor: Sensor) -> Beams:
    return _listed(sensor)


@_made.register
def _camera(camera: Camera) -> Beams:
    sees_all = camera.range_m == (0.0, math.inf)
    return _pinhole(camera) if sees_all and not is_listed(camera) else _listed(camera)


@_made.register
def _lidar(lidar: Lidar) -> Beams:
    if lidar.rays is not None or lidar.blocked:
        return _listed(lidar)._replace(turns=True)
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
    """Return directions with x = 1: their lengths decide nothing while the range has no ends."""
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


def _sector(sensor: Sectored, number: int) -> Beams | None:
    """Return the rays of a sector, azimuth by azimuth; None where these are not in front of the sensor, or its rows
    reach differently far."""
    columns, rows = sensor.resolution[0], sensor.rows_of_sector()
    first, limits = number * rows, class_limits_m(sensor)
    limits = limits[:, first : first + rows]
    if np.abs(sensor.sectors[number].azimuth_deg).max() > _WIDEST_DEG or (limits != limits[:, :1]).any():
        return None
    rays = np.arange(columns)[:, None] + (first + np.arange(rows)) * columns
    directions = local_directions(sensor, rays.ravel())
    beams = _beams(sensor, _NOTHING, np.arange(columns), _NOTHING, first + np.arange(rows))
    far_m = min(sensor.range_m[1], float(limits.max(initial=0.0)) * _WIDER if limits.size else math.inf)
    return _with_listed(beams, directions)._replace(
        steps=np.array([1, columns]),
        is_upright=True,
        reach=np.array([sensor.range_m[0], far_m]),
        tiles=tiles_of(directions, rows, IMAGE_COLUMNS),
        field=_field(directions),
        limits=limits[:, :1],
    )


def _listed(sensor: Sensor) -> Beams:
    """Return any rays, searched tile by tile."""
    columns, rows = sensor.resolution
    beams = _beams(sensor, np.zeros(0), np.arange(rows), np.zeros(0), np.arange(columns))
    table = lattice(sensor)
    known = directions = table.directions()
    if table.exists is not None:
        directions = np.full((sensor.ray_count, 3), np.nan)
        directions[table.exists] = known
    return _with_listed(beams, directions)._replace(tiles=tiled(sensor).tiles, field=_field(known))


def _field(directions: Doubles) -> Doubles:
    """Return cosine and sine of the half angle of a cone around x that holds directions (n, 3)."""
    cos = float(directions[:, 0].min()) - 1e-12 if len(directions) else 1.0
    return np.array([cos, math.sqrt(max(0.0, 1.0 - cos * cos))])


def _with_listed(beams: Beams, directions: Doubles) -> Beams:
    """Return beams whose directions (slots, 3) are listed one by one; missing ones of the lens become zero."""
    x, y, z = np.nan_to_num(directions).T
    scale = np.ones((len(beams.row_of), 2))
    return beams._replace(stride=beams.columns, x=x.copy(), y=y.copy(), z=z.copy(), scale=scale)


def _beams(sensor: Sensor, row_at: Doubles, row_of: Ids, column_at: Doubles, column_of: Ids) -> Beams:
    """Return beams that have no directions and no position yet."""
    none = np.zeros(0)
    return Beams(
        False, column_of.size, 0, none, none, none, np.ones((0, 2)), np.zeros(3), np.eye(3),
        np.array(sensor.range_m, np.float64), row_at, row_of, column_at, column_of,
        np.array([column_of.size, 1]),
        none, False, none, none, OPAQUE, NO_TILES, np.array([-1.0, 0.0]), 0.0, _NO_WORDS, _NOTHING,
        class_limits_m(sensor),
    )  # fmt: skip


def class_limits_m(sensor: Sensor) -> Doubles:
    """Return the range of each row to an object of each class, (3, rows); (0, 0) where nothing limits rays."""
    echoes = (Echo(cls, min(SIZES_M[cls][:2])) for cls in CLASSES)
    found = [kind_of(sensor).limits_m(sensor, echo) for echo in echoes]
    return np.zeros((0, 0)) if found[0] is None else np.array(found, np.float64)
