"""Sweeps of a rig: where its LiDARs measure points in a frame, and on what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels import sweeps as kernel
from riglens.core.kernels.nearest import Beams, Canvas
from riglens.core.kernels.sweeps import GROUND, STATIC
from riglens.core.rig.model import Lidar, Rig
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.simulate.settings import USUAL_SIMULATION, SimulationSettings
from riglens.core.simulate.world import TrueBoxes, World, Worlds
from riglens.core.targets.beams import NOT_STOPPED, beams_of, stops_of
from riglens.core.targets.contribution import phases_rad
from riglens.core.targets.draws import mixed, sensor_key
from riglens.core.targets.range_law import REFLECTIVITY, WIDTH, anchors_of, range_for
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh import BodyMesh
from riglens.core.vehicle.solid import CarBody, Solid

__all__ = ["GROUND", "STATIC", "Simulator", "Sweep", "points_inside"]

STATIC_REFLECTIVITY, ROAD_REFLECTIVITY = 0.2, 0.2
"""Of what stands around and of the road, beside those of road users; our choice."""


@dataclass(frozen=True)
class Sweep:
    """Points of all LiDARs of a rig in a frame, N of them, LiDAR by LiDAR, each beam by beam from below.

    points_m (N, 3) float32 in the vehicle frame; intensity (N,) float32, 0 to 255, which tells nothing of a class; ring
    (N,) int16 the beam as the rig lists it; sensor (N,) int16 place among `rig.lidars()`; object (N,) int32 place among
    the road users of the frame, GROUND, or STATIC for what stands around.
    """

    points_m: NDArray[np.float32]
    intensity: NDArray[np.float32]
    ring: NDArray[np.int16]
    sensor: NDArray[np.int16]
    object: NDArray[np.int32]

    def hits(self, objects: int) -> NDArray[np.int64]:
        """Points that came back from each of so many road users, wherever noise put them."""
        return np.bincount(self.object[self.object >= 0], minlength=objects).astype(np.int64)

    def of(self, sensor: int) -> Sweep:
        """The points of one LiDAR."""
        mine = self.sensor == sensor
        return Sweep(
            self.points_m[mine], self.intensity[mine], self.ring[mine], self.sensor[mine], self.object[mine]
        )


class _Source(NamedTuple):
    """A LiDAR ready to be cast: its rays; by frame the shift of its azimuths in radians (frames,) and the keys (3,
    frames) of the draws: returns, noise, losses; the range law, see `riglens.core.kernels.sweeps.Chances`."""

    beams: Beams
    phases: NDArray[np.float64]
    keys: NDArray[np.uint64]
    law: NDArray[np.float64]


class Simulator:
    """Sweeps of a rig in traffic; frames by their number in the data. For one thread, which may be any.

    `mesh` is that of the vehicle's file, if it has one; without it such a body cannot block: an InputError.
    """

    def __init__(
        self,
        rig: Rig,
        traffic: Traffic | Worlds,
        settings: SimulationSettings = USUAL_SIMULATION,
        mesh: BodyMesh | None = None,
    ) -> None:
        self.worlds = traffic if isinstance(traffic, Worlds) else Worlds(traffic, settings)
        self.settings = self.worlds.settings
        solid = CarBody(rig.vehicle, mesh).solid() if self.settings.body == "blocks" else None
        self._sources = [self._source(lidar, solid) for lidar in rig.lidars()]
        rays = max((lidar.ray_count for lidar in rig.lidars()), default=0)
        self._returns = kernel.Returns(
            np.empty((rays, 3), np.float32),
            np.empty(rays, np.float32),
            np.empty(rays, np.int16),
            np.empty(rays, np.int32),
        )
        self._canvases = {(beams.row_of.size, beams.columns): _canvas(beams) for beams, *_ in self._sources}

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self.worlds.frames

    def truth(self, frame: int) -> TrueBoxes:
        """The road users of a frame."""
        return self.worlds.truth(frame)

    def sweep(self, frame: int) -> Sweep:
        """What the LiDARs measure in a frame."""
        world = self.worlds.world(frame)
        parts = [self._cast(number, frame, world) for number in range(len(self._sources))]
        if not parts:
            none = np.zeros(0, np.int16)
            return Sweep(
                np.zeros((0, 3), np.float32), np.zeros(0, np.float32), none, none, np.zeros(0, np.int32)
            )
        return Sweep(
            np.concatenate([part.points_m for part in parts]),
            np.concatenate([part.intensity for part in parts]),
            np.concatenate([part.ring for part in parts]),
            np.concatenate([part.sensor for part in parts]),
            np.concatenate([part.object for part in parts]),
        )

    def _cast(self, number: int, frame: int, world: World) -> Sweep:
        source, settings, to = self._sources[number], self.settings, self._returns
        returns, noise, losses = source.keys[:, frame]
        draws = kernel.Chances(returns, noise, losses, settings.noise_m, settings.dropout, source.law)
        canvas = self._canvases[source.beams.row_of.size, source.beams.columns]
        count = kernel.cast_sweep(
            world.boxes, world.looks, world.surface, source.beams, source.phases[frame], draws, canvas, to
        )
        return Sweep(
            to.points[:count].copy(),
            to.intensity[:count].copy(),
            to.ring[:count].copy(),
            np.full(count, number, np.int16),
            to.what[:count].copy(),
        )

    def _source(self, lidar: Lidar, solid: Solid | None) -> _Source:
        frames, settings = np.arange(self.worlds.frames), self.settings
        ends_m = NOT_STOPPED if solid is None else stops_of(lidar, barrier_of(lidar, solid))
        names = ("returns", "noise", "losses")
        keys = [mixed(sensor_key(settings.seed, f"{name} of {lidar.name}"), frames) for name in names]
        phases = phases_rad(lidar, settings.targets(), frames)
        return _Source(beams_of(lidar, ends_m=ends_m), phases, np.stack(keys), _law(lidar, settings))


def points_inside(truth: TrueBoxes, points_m: NDArray[np.float32]) -> NDArray[np.int64]:
    """Points (n,) inside of each road user's box, faces included: what nuScenes calls `num_lidar_pts`."""
    counts = np.zeros(len(truth.cls), np.int64)
    kernel.count_inside(points_m, truth.centre_m, truth.size_m / 2.0, truth.rotation, counts)
    return counts


def _canvas(beams: Beams) -> Canvas:
    rows, columns = beams.row_of.size, beams.columns
    return Canvas(
        np.zeros(rows * columns),
        np.full(rows * columns, -1, np.int32),
        np.full(rows * columns, -1, np.int32),
        np.tile(np.array([columns, 0], np.int32), (rows, 1)),
        np.empty(columns),
    )


def _law(lidar: Lidar, settings: SimulationSettings) -> NDArray[np.float64]:
    """R for the three classes, what stands around and the road in metres, and the relative width, (6,); (0,) where all
    rays return."""
    anchors = anchors_of(lidar) if settings.range_law else ()
    if not anchors:
        return np.zeros(0)
    shares = (*REFLECTIVITY, STATIC_REFLECTIVITY, ROAD_REFLECTIVITY)
    return np.array([*(range_for(rho, anchors) for rho in shares), WIDTH])
