"""Count hits of rigs on objects; only the sensors that changed since the previous rig are cast.

What a sensor gets does not depend on the other sensors, so each one's contribution is kept, and an edit casts the moved
sensor alone. All counts are integers and frames share nothing: any order of edits and any number of threads gives the
bits of an evaluation from scratch. Call it from one thread only.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.geometry import Pose
from riglens.core.kernels.objects.counts import ALONE, RAYS
from riglens.core.kernels.runtime import jit
from riglens.core.rig.model import Camera, Lidar, Rig, Sensor, rays_of
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.sensing.body_ends import Obstacle, obstacle_of
from riglens.core.sensors.registry import kind_of
from riglens.core.targets.camera_losses import CameraLosses
from riglens.core.targets.contribution import Contribution, TargetCaster
from riglens.core.targets.counts import Counted
from riglens.core.targets.groups import Groups
from riglens.core.targets.joining import Gatherer
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.targets.traffic import Traffic, traffic_of
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Solid

_Shape = tuple[Sensor, TargetSettings, Obstacle | None]
"""Key of a contribution: rays, settings, and what stops the rays."""


class TargetEngine:
    """Incremental counting for rigs in one set of traffic, with a number of threads (all processors by default)."""

    def __init__(self, traffic: Traffic, threads: int | None = None) -> None:
        self._traffic = traffic
        self._workers = jit.thread_count(threads)
        self._caster = TargetCaster(traffic, self._workers)
        self._found = WeakValueDictionary[_Shape, Contribution]()
        self._held: dict[_Shape, Contribution] = {}
        self._shown: set[_Shape] = set()
        self._groups: Groups | None = None
        self._grouped = WeakValueDictionary[range, Groups]()
        self._gatherer = Gatherer(self._workers)

    def beside(self, threads: int | None = None) -> TargetEngine:
        """Return an engine for other rigs, by default with as many threads, called while this one rests; each uses what
        the other holds of a sensor."""
        other = copy.copy(self)
        if threads == 1:
            other._workers, other._caster = 1, self._caster.with_workers(1)
        other.forget()
        return other

    def rest(self) -> None:
        """Release what the next edit makes anew, of engines beside this one, too; what was counted stays."""
        self._caster.rest()
        self._gatherer = Gatherer(self._workers)

    def forget(self) -> None:
        """Release what is held of sensors; an engine beside this one keeps its own."""
        self._held, self._shown, self._groups = {}, set(), None
        self._gatherer = Gatherer(self._workers)

    @property
    def traffic(self) -> Traffic:
        """Return the traffic that rigs are evaluated in."""
        return self._traffic

    def evaluate(
        self,
        rig: Rig,
        settings: TargetSettings = USUAL,
        frames: int | range | None = None,
        stance: Pose = Pose(),
        cancel: IsStale = never_stale,
        with_losses: bool = False,
    ) -> Counted:
        """Count for a rig in all frames, in the first N of the sampling order, or in a range of it; `with_losses`: also
        what hides each object from cameras.

        `stance`: how the car's body stands on the ground; the sensors are where the rig says. InputError where the body
        blocks and its mesh file has not been read.
        Raise Cancelled as soon as `cancel`, which is called every few milliseconds, returns True; what was cast until
        then is kept where it is whole, so the next evaluation is as good as any.
        """
        started = time.perf_counter()
        settings = replace(settings, body=settings.body or rig.body)
        span = self._span(frames)
        solid = car_of(rig, stance) if settings.body == "blocks" else None
        wanted = {sensor.name: _shape_of(sensor, settings, solid) for sensor in rig.sensors if sensor.enabled}
        cameras = rig.enabled_cameras() if with_losses else ()
        unblocked = {one.name: _shape_of(one, settings, None) for one in cameras}
        asked = dict.fromkeys([*wanted.values(), *unblocked.values()])
        shown = self._shown | asked.keys()
        self._held = {shape: held for shape, held in self._held.items() if shape in shown}
        # from the last on: voxels, often evaluated meanwhile, begin with the first, so neither waits for shadows
        for shape in reversed(asked):
            if not self._extend(shape, span.stop, cancel):
                raise Cancelled
        self._shown = set(asked)
        self._held = {shape: self._held[shape] for shape in self._shown}
        by_sensor = {name: self._held[shape] for name, shape in wanted.items()}
        if self._groups is None or self._groups.span != span:
            self._groups = self._grouped.get(span) or Groups(self._traffic, span)
            self._grouped[span] = self._groups
        groups = self._groups
        objects = self._gatherer.objects(groups.every, rig, by_sensor)
        if groups.before:
            objects = objects.part(slice(groups.before, None))
        losses = None
        if with_losses:
            pairs = [(by_sensor[name], self._held[shape]) for name, shape in unblocked.items()]
            losses = self._losses(cameras, pairs, settings, groups)
        return Counted(rig, settings, groups, objects, (time.perf_counter() - started) * 1e3, losses)

    def _losses(
        self,
        cameras: Sequence[Camera],
        pairs: Sequence[tuple[Contribution, Contribution]],
        settings: TargetSettings,
        groups: Groups,
    ) -> CameraLosses:
        """Return what hides objects from cameras, of each with the car's body and without."""
        mine = slice(groups.before, len(groups.every))

        def columns(values: Sequence[NDArray[Any]]) -> NDArray[Any]:
            return np.array(values).reshape(len(cameras), -1)[:, mine].T

        if not cameras:
            none = np.zeros((mine.stop - mine.start, 0))
            return CameraLosses.of(none, *[none.astype(np.int64)] * 3)
        many = len(groups.every)
        inside = [
            self._caster.inside_of(camera, settings, free.found[ALONE, :many])
            for camera, (_, free) in zip(cameras, pairs, strict=True)
        ]
        seen, unblocked = ([pair[place].found[RAYS, :many] for pair in pairs] for place in (0, 1))
        alone = [free.found[ALONE, :many] for _, free in pairs]
        return CameraLosses.of(columns(inside), columns(alone), columns(unblocked), columns(seen))

    def _span(self, frames: int | range | None) -> range:
        most = self._traffic.frames
        if not isinstance(frames, range):
            return range(most if frames is None else max(0, min(frames, most)))
        if frames.step != 1 or not 0 <= frames.start <= frames.stop <= most:
            raise InputError(f"must be a range of step 1 within 0 to {most} (got {frames})", "frames")
        return frames

    def _extend(self, shape: _Shape, frames: int, is_stale: IsStale) -> bool:
        """Cast a sensor in the frames that it lacks of the first `frames`; False when abandoned."""
        held = self._found.get(shape)
        if held is None or held.frames < frames:
            sensor, settings, stop = shape
            barrier = None if stop is None else stop.barrier
            first = 0 if held is None else held.frames
            more = self._caster.cast(sensor, settings, barrier, (first, frames), is_stale)
            if more is None:
                return False
            held = held.joined(more) if held is not None and first else more
            self._found[shape] = held
        self._held[shape] = held
        return True


def _shape_of(sensor: Sensor, settings: TargetSettings, solid: Solid | None) -> _Shape:
    """Return the key of a contribution: the rays, and the name of a LiDAR whose draws depend on it; thresholds do not
    count."""
    stop = None if solid is None else obstacle_of(sensor, solid)
    kind = kind_of(sensor)
    rays = rays_of(sensor.finest() if kind.hits.measure == "returns" else sensor)
    if (kind.spins and settings.phase == "random") or (kind.has_range_law and settings.range_law):
        rays = rays.model_copy(update={"name": sensor.name, "model": sensor.model})
    return rays, replace(settings, min_points=1, calibration=None), stop


def warm_up(threads: int | None = None) -> None:
    """Compile the kernels, or load them from disk, so that no answer's time includes it."""
    data = DataReport("warm up", 1, dict.fromkeys(CLASSES, 0))
    box = np.array([[5.0, 0.0, 1.0]]), np.ones((1, 3)), np.eye(3)[None]
    TargetEngine(traffic_of(data, np.zeros(1, np.int64), np.zeros(1, np.uint8), *box), threads).evaluate(
        WARM_UP
    )


WARM_UP = Rig(
    sensors=(
        Lidar(name="one", position=(0.0, 0.0, 1.0), elevations_deg=(0.0,), azimuths_deg=(0.0,)),
        Lidar(name="other", position=(0.0, 0.1, 1.0), elevations_deg=(0.0,), azimuths_deg=(0.0,)),
        Camera(name="camera", position=(0.0, 0.0, 1.0), hfov_deg=90.0, cast=(2, 2)),
    )
)
"""Few rays that make the engine compile every kernel."""
