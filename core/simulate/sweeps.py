"""Sweeps of a rig: where its LiDARs measure points in a frame, and on what."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects import sweeps as kernel
from riglens.core.kernels.objects.box_frames import Beams, Canvas
from riglens.core.kernels.objects.sweeps import GROUND, STATIC
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Lidar, Rig, Sensor
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.world import World, Worlds, earlier
from riglens.core.targets.beams import NOT_STOPPED, beams_of, stops_of
from riglens.core.targets.contribution import phases_rad
from riglens.core.targets.draws import mixed, sensor_key
from riglens.core.targets.range_law import anchors_of, glass_of, range_for
from riglens.core.targets.shapes import REFLECTIVITY, WIDTH
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Solid

__all__ = ["GROUND", "STATIC", "Simulator", "Sweep"]

STATIC_REFLECTIVITY, ROAD_REFLECTIVITY = 0.2, 0.2
"""Reflectivities of occluders and of the road, besides those of objects; our choice."""
_EARLIER = 1 << 40
"""Between the counters of the draws of two sweeps of a frame."""


@dataclass(frozen=True)
class Sweep:
    """Points of all LiDARs of a rig in a frame, N of them, LiDAR by LiDAR, each beam by beam from below.

    points_m (N, 3) float32 in the vehicle frame; intensity (N,) float32, 0 to 255, which tells nothing of a class; ring
    (N,) int16 the beam as the rig lists it, or the laser of a scan pattern; time_s (N,) float32 in the pattern, 0 for
    beams; sensor (N,) int16 place among `rig.enabled_lidars()`; object (N,) int32
    place among the objects of the frame, GROUND, or STATIC for surroundings. Of each object (n,): rays of all LiDARs
    that reach it, whether or not they come back, and those that would if nothing else stood there.
    """

    points_m: NDArray[np.float32]
    intensity: NDArray[np.float32]
    ring: NDArray[np.int16]
    time_s: NDArray[np.float32]
    sensor: NDArray[np.int16]
    object: NDArray[np.int32]
    reached: NDArray[np.int64]
    alone: NDArray[np.int64]

    def hits(self, objects: int) -> NDArray[np.int64]:
        """Return the number of returns from each object, wherever noise put them."""
        return np.bincount(self.object[self.object >= 0], minlength=objects).astype(np.int64)

    def of(self, sensor: int) -> Sweep:
        """Return the points of one LiDAR."""
        mine = self.sensor == sensor
        columns = ("points_m", "intensity", "ring", "time_s", "sensor", "object")
        return replace(self, **{name: getattr(self, name)[mine] for name in columns})


class _Source(NamedTuple):
    """A LiDAR ready to be cast: its rays, keys of its draws (returns, noise, losses), and the range law, see
    `kernels.objects.sweeps.DrawKeys`."""

    lidar: Lidar
    beams: Beams
    keys: tuple[int, int, int]
    law: NDArray[np.float64]

    def time_s(self, ray: NDArray[np.int32]) -> NDArray[np.float32]:
        """Return when rays (n,) are fired."""
        if self.lidar.rays is None:
            return np.zeros(ray.size, np.float32)
        return self.lidar.rays.ray_rows().time_s[ray].astype(np.float32)


class Simulator:
    """Sweeps of a rig in worlds, which several rigs may share; frames by their number in the data. For one thread,
    which may be any.

    InputError where the car's body blocks and its mesh file has not been read.
    """

    def __init__(self, rig: Rig, worlds: Worlds) -> None:
        self.worlds, self._settings = worlds, worlds.settings
        body = own_solid(rig, self._settings.body)
        self._sources = [_source(lidar, body, self._settings) for lidar in rig.enabled_lidars()]
        rays = max((lidar.ray_count for lidar in rig.enabled_lidars()), default=0)
        self._columns = (
            np.empty((rays, 3), np.float32),
            np.empty(rays, np.float32),
            np.empty(rays, np.int32),
            np.empty(rays, np.int32),
        )
        beams = [source.beams for source in self._sources]
        self._canvases = {(one.row_of.size, one.columns): canvas_for(one) for one in beams}

    def sweep(self, frame: int, ago: int = 0) -> Sweep:
        """Return the LiDAR points of a frame, or those of some sweeps ago as they lie in its vehicle frame: the car's
        motion is compensated, that of objects is not."""
        world = self.worlds.world(frame)
        then = self.worlds.before(frame, ago) if ago else None
        if then is not None:
            world = earlier(world, then)
        users, boxes = world.reflectivity.users, len(world.boxes.centres)
        reached, alone = np.zeros(users, np.int64), np.zeros(boxes, np.int64)
        points, intensity, rays, what = self._columns
        sensor = [np.zeros(0, np.int16)]
        parts = [(points[:0], intensity[:0], np.zeros(0, np.int16), np.zeros(0, np.float32), what[:0])]
        for number, source in enumerate(self._sources):
            count = self._cast(
                source, frame + ago * _EARLIER, world, alone, kernel.Returns(*self._columns, reached)
            )
            ray = rays[:count]
            ring = (ray // source.beams.columns).astype(np.int16)
            kept = (
                points[:count].copy(),
                intensity[:count].copy(),
                ring,
                source.time_s(ray),
                what[:count].copy(),
            )
            parts.append(kept)
            sensor.append(np.full(count, number, np.int16))
        points_m, bright, ring, time_s, on = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        points_m = points_m if then is None else then.to_frame(points_m)
        return Sweep(points_m, bright, ring, time_s, np.concatenate(sensor), on, reached, alone[:users])

    def _cast(
        self, source: _Source, counter: int, world: World, alone: NDArray[np.int64], to: kernel.Returns
    ) -> int:
        settings, now = self._settings, np.array([counter])
        returns, noise, losses = (mixed(key, now)[0] for key in source.keys)
        draws = kernel.DrawKeys(returns, noise, losses, settings.noise_m, settings.dropout, source.law)
        phase = phases_rad(source.lidar, settings.targets(), now)[0]
        beams = source.beams
        canvas = self._canvases[beams.row_of.size, beams.columns]
        return kernel.cast_sweep(
            world.boxes, world.reflectivity, world.surface, beams, phase, draws, canvas, alone, to
        )


def _source(lidar: Lidar, body: Solid | None, settings: SimulationSettings) -> _Source:
    ends_m = stopped_m(lidar, body)
    returns, noise, losses = (
        sensor_key(settings.seed, f"{name} of {lidar.name}") for name in ("returns", "noise", "losses")
    )
    beams = beams_of(lidar, glass=glass_of(lidar, settings.targets()), ends_m=ends_m)
    return _Source(lidar, beams, (returns, noise, losses), _law(lidar, settings))


def own_solid(rig: Rig, said: Body | None) -> Solid | None:
    """Return the body of a rig's car where it blocks, as said or else as the rig says."""
    return car_of(rig) if (said or rig.body) == "blocks" else None


@lru_cache(maxsize=32)
def stopped_m(sensor: Sensor, body: Solid | None) -> NDArray[np.float64]:
    """Return the distances of `riglens.core.targets.beams.stops_of`, kept: a native camera takes seconds, and a
    process needs it many times."""
    return NOT_STOPPED if body is None else stops_of(sensor, barrier_of(sensor, body))


def canvas_for(beams: Beams) -> Canvas:
    """Return an empty canvas for the rays of a sensor."""
    rows, columns = beams.row_of.size, beams.columns
    return Canvas(
        np.zeros(rows * columns),
        np.full(rows * columns, -1, np.int32),
        np.full(rows * columns, -1, np.int32),
        np.tile(np.array([columns, 0], np.int32), (rows, 1)),
        np.empty(columns),
        np.array([rows, 0]),
    )


def _law(lidar: Lidar, settings: SimulationSettings) -> NDArray[np.float64]:
    """Return R for the three classes, occluders and the road in metres, and the relative width, (6,); (0,) where all
    rays return."""
    anchors = anchors_of(lidar) if settings.range_law else ()
    if not anchors:
        return np.zeros(0)
    shares = (*REFLECTIVITY, STATIC_REFLECTIVITY, ROAD_REFLECTIVITY)
    return np.array([*(range_for(rho, anchors) for rho in shares), WIDTH])
