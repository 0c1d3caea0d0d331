"""Count the hits of one sensor on the objects of the first frames, independent of the other sensors."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import IsStale
from riglens.core.in_threads import in_threads
from riglens.core.kernels.objects import counts as kernel
from riglens.core.kernels.objects.box_frames import Beams, FrameBoxes
from riglens.core.kernels.objects.unique_cells import table_mask
from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.sensors.registry import kind_of
from riglens.core.targets.beams import (
    NOT_STOPPED,
    azimuth_step_rad,
    beams_by_sector,
    class_limits_m,
    stops_of,
)
from riglens.core.targets.clearance import Clearance
from riglens.core.targets.draws import mixed, sensor_key, units
from riglens.core.targets.range_law import glass_of, law_of
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.shapes import SHAPES, Shape, kind_numbers, kinds_of
from riglens.core.targets.traffic import Traffic
from riglens.core.targets.truncation import shares_in_picture
from riglens.core.vehicle.solid import Barrier

Ids = NDArray[np.int64]
TURNING_RAYS_AT_ONCE, IMAGES_AT_ONCE = 1 << 21, 128
"""Rays of LiDARs, whose cells take 8 bytes each, and frames of pictures of a chunk, before which `is_stale` is called:
some milliseconds."""


class _Scratch(NamedTuple):
    """Memory of a thread for `cast_frames`."""

    inverse: NDArray[np.float64]
    owner: NDArray[np.int32]
    last: NDArray[np.int32]
    table: Ids


@dataclass(frozen=True, eq=False)
class Contribution:
    """Hits on the m objects that count in the first `frames` frames: found int32 (COLUMNS, m) as in
    `kernels.objects.counts`, of other sensors than LiDARs its rows before CELLS; cells of object o, for LiDARs:
    found[CELLS, o] of them, from cells[cell_starts[o]] on, cell_starts (0,) for others; inside (m,), for cameras: share
    of the silhouette of an object that is hit inside the picture, for others (0,).
    """

    frames: int
    found: NDArray[np.int32]
    cell_starts: Ids
    cells: Ids
    inside: NDArray[np.float64] = dataclasses.field(default_factory=lambda: np.zeros(0))

    def joined(self, more: Contribution) -> Contribution:
        """Return this contribution joined with that of the frames that follow."""
        return Contribution(
            self.frames + more.frames,
            np.concatenate([self.found, more.found], axis=1),
            np.concatenate([self.cell_starts, self.cells.size + more.cell_starts]),
            np.concatenate([self.cells, more.cells]),
            np.concatenate([self.inside, more.inside]),
        )


def phases_rad(sensor: Sensor, settings: TargetSettings, frame: Ids) -> NDArray[np.float64]:
    """Return the shift of a sensor's azimuths in frames (n,) of the data, radians; 0 for cameras."""
    if settings.phase == "0" or not kind_of(sensor).spins:
        return np.zeros(len(frame))
    return azimuth_step_rad(sensor) * units(mixed(sensor_key(settings.seed, sensor.name), frame))


class _Sweep(NamedTuple):
    """Boxes of all frames, and how a sensor meets them, (frames,) each: phases in radians, keys."""

    boxes: FrameBoxes
    phases: NDArray[np.float64]
    keys: NDArray[np.uint64]


def _together(one: Contribution, other: Contribution) -> Contribution:
    """Return the hits of two sets of rays of a sensor that has no cells."""
    mine, its = one.found, other.found
    found = mine + its
    first, last = kernel.FIRST_ROW, kernel.LAST_ROW
    found[first] = np.where(
        np.minimum(mine, its)[first] < 0, np.maximum(mine, its)[first], np.minimum(mine, its)[first]
    )
    found[last] = np.maximum(mine[last], its[last])
    return Contribution(one.frames, found, one.cell_starts, one.cells)


class TargetCaster:
    """Caster of sensors into one set of traffic with a number of workers; any threads may call it at a time."""

    def __init__(self, traffic: Traffic, workers: int = 1) -> None:
        self._traffic, self._workers = traffic, workers
        self._spare: list[_Scratch] = []
        self._boxes: dict[Shape, FrameBoxes] = {}
        self._clearance = Clearance(traffic)
        self._objects = np.flatnonzero(traffic.counts)
        before = np.concatenate([[0], np.cumsum(traffic.counts)])
        self._ranks, self._objects_before = np.where(traffic.counts, before[:-1], -1), before[traffic.starts]

    def with_workers(self, workers: int) -> TargetCaster:
        """Return a caster with another number of workers that shares the boxes of this one."""
        other = copy.copy(self)
        other._workers = workers
        return other

    def rest(self) -> None:
        """Release the memory of the workers, 16 bytes for each ray of the last sensor, until the next one is cast."""
        self._spare.clear()

    def _boxes_of(self, shape: Shape) -> FrameBoxes:
        """Return the boxes for the kernels."""
        if shape not in self._boxes:
            traffic = self._traffic
            self._boxes[shape] = FrameBoxes(
                traffic.starts, traffic.centre_m, traffic.half_m, traffic.rotation, traffic.counts, traffic.cls,
                kind_numbers(shape, traffic.cls, traffic.size_m), *kinds_of(SHAPES),
            )  # fmt: skip
        return self._boxes[shape]

    def cast(
        self,
        sensor: Sensor,
        settings: TargetSettings,
        barrier: Barrier | None,
        frames: tuple[int, int],
        is_stale: IsStale,
    ) -> Contribution | None:
        """Return the hits of a sensor in frames first..end-1, less the rays that the car stops; None as soon as
        `is_stale` is true."""
        traffic, ends_m = self._traffic, NOT_STOPPED
        if barrier is not None and len(barrier.stops):
            place = np.array(sensor.position, np.float64)
            empty_box = self._clearance.empty_box(barrier.tree.bounds[0], place, frames)
            ends_m = stops_of(sensor, barrier, self._workers, empty_box)
        law, glass = law_of(sensor, settings), glass_of(sensor, settings)
        keys = mixed(sensor_key(settings.seed, f"returns of {sensor.name}"), traffic.frame)
        objects = slice(*(int(self._objects_before[frame]) for frame in frames))
        sweep = _Sweep(self._boxes_of(settings.shape), phases_rad(sensor, settings, traffic.frame), keys)
        parts = []
        for beams in beams_by_sector(sensor, law, glass, ends_m):
            part = self._cast_beams(beams, sweep, frames, is_stale)
            if part is None:
                return None
            parts.append(part)
        found = reduce(_together, parts)
        self._count_cells_once(sensor, objects, found.found[kernel.RAYS])
        if not isinstance(sensor, Lidar):
            counted = found.found[: kernel.CELLS].copy()
            found = dataclasses.replace(found, found=counted, cell_starts=found.cell_starts[:0].copy())
        if not isinstance(sensor, Camera):
            return found
        inside, met = np.zeros(found.found.shape[1]), np.flatnonzero(found.found[kernel.RAYS])
        inside[met] = shares_in_picture(
            sensor, sweep.boxes, beams, self._objects[objects][met], self._workers
        )
        return dataclasses.replace(found, inside=inside)

    def inside_of(
        self, camera: Camera, settings: TargetSettings, alone: NDArray[np.int32]
    ) -> NDArray[np.float64]:
        """Return the share of the silhouette inside the picture of each of the first objects (m,), 0 where no ray
        meets one, by the rays that would meet each `alone` (m,)."""
        (beams,) = beams_by_sector(camera, law_of(camera, settings), glass_of(camera, settings), NOT_STOPPED)
        inside, met = np.zeros(len(alone)), np.flatnonzero(alone)
        boxes = self._boxes_of(settings.shape)
        inside[met] = shares_in_picture(camera, boxes, beams, self._objects[: len(alone)][met], self._workers)
        return inside

    def _cast_beams(
        self, beams: Beams, sweep: _Sweep, frames: tuple[int, int], is_stale: IsStale
    ) -> Contribution | None:
        """Return the hits of some rays in frames first..end-1; None as soon as `is_stale` is true."""
        (first, end), rays = frames, beams.row_of.size * beams.columns
        most = int(np.diff(self._traffic.starts).max(initial=1))
        objects = slice(*(int(self._objects_before[frame]) for frame in frames))
        found = np.zeros((kernel.COLUMNS, objects.stop - objects.start), np.int32)
        found[kernel.FIRST_ROW : kernel.LAST_ROW + 1] = -1
        found[kernel.FIRST_CELL : kernel.LAST_CELL] = np.iinfo(np.int32).max
        at, ranks = np.zeros(found.shape[1], np.int64), self._ranks - objects.start
        at_once = max(1, TURNING_RAYS_AT_ONCE // rays if beams.turns else IMAGES_AT_ONCE)
        chunks = max(-(-(end - first) // at_once), min(self._workers, end - first))
        bounds = [first + (end - first) * chunk // chunks for chunk in range(chunks + 1)] if chunks else []
        room = max(np.diff(bounds), default=0) * rays if beams.turns else 0
        cells, ahead = dict[int, Ids](), iter(range(chunks))

        def cast(_: int) -> None:
            """Cast chunk by chunk, each taken by the thread that comes first."""
            scratch, entered = self._scratch(rays), np.empty(room, np.int64)
            for chunk in ahead:
                if is_stale():
                    break
                number = kernel.cast_frames(
                    sweep.boxes, beams, bounds[chunk], bounds[chunk + 1], sweep.phases, sweep.keys, ranks, most,
                    *scratch, found, at, entered,
                )  # fmt: skip
                cells[chunk] = entered[:number].copy()
            self._spare.append(scratch)

        in_threads(self._workers, cast)
        if len(cells) < chunks:
            return None
        held = 0
        for chunk in range(chunks if beams.turns else 0):
            at[slice(*(self._objects_before[bounds[chunk : chunk + 2]] - objects.start))] += held
            held += cells[chunk].size
        in_order = [cells[chunk] for chunk in range(chunks)]
        return Contribution(end - first, found, at, np.concatenate([np.zeros(0, np.int64), *in_order]))

    def _scratch(self, rays: int) -> _Scratch:
        """Return memory for a number of rays that no thread uses; it is left as it was made: a drag keeps it."""
        with contextlib.suppress(IndexError):  # another thread took the last one
            kept = self._spare.pop()
            if kept.inverse.size == rays:
                return kept
            self._spare.clear()
        owner, last = np.full((2, rays), -1, np.int32)
        return _Scratch(np.zeros(rays), owner, last, np.empty(table_mask(rays) + 1, np.int64))

    def _count_cells_once(self, sensor: Sensor, objects: slice, rays: NDArray[np.int32]) -> None:
        """Leave one object in each resolution cell of a frame: what is detected from farthest, or by most rays."""
        cells_of, met = kind_of(sensor).cells, np.flatnonzero(rays)
        if cells_of is None or not met.size:
            return
        traffic = self._traffic
        box = self._objects[objects][met]
        local_m = (traffic.centre_m[box] - np.array(sensor.position)) @ sensor.pose.rotation()
        cell = np.column_stack([traffic.frame_of_box[box], cells_of(sensor, local_m)])
        limits = class_limits_m(sensor)
        reach = limits.max(axis=1)[traffic.cls[box]] if limits.size else np.zeros(len(box))
        best = np.lexsort((-rays[met], -reach))
        _, first = np.unique(cell[best], axis=0, return_index=True)
        weaker = np.ones(len(met), np.bool_)
        weaker[best[first]] = False
        rays[met[weaker]] = 0
