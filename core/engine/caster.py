"""Cast one sensor: from its description to the set of informative voxels that its rays traverse.

Several ways lead to the same set. Fans walk all rays of a vertical plane together and serve upright sensors. Cameras
that roll or pitch, or whose lens has distortion, are cast by walking the voxels near them, LiDARs that do by core and
sheets. Everything else is walked ray by ray. Where rays end at the car's body, all leave out the rays that are stopped;
those that meet something informative before they end are walked one by one (see `riglens.core.engine.blocking`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial, singledispatch, singledispatchmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.blocking import blocked
from riglens.core.engine.fans import (
    by_offset,
    farthest,
    is_plain,
    is_upright,
    make_fan,
    make_profile,
    mark_planes,
    may_stride,
    planes_of,
    share_rows,
)
from riglens.core.engine.frustums import make_frustum
from riglens.core.engine.meshes import CameraMesh, make_mesh, outermost_directions
from riglens.core.engine.sheets import FEWEST_RAYS, Sheets, make_sheets
from riglens.core.errors import IsStale, never_stale
from riglens.core.kernels.beams.beam_cones import mark_sheets
from riglens.core.kernels.cameras.frustum import Frustum, mark_frustum
from riglens.core.kernels.cameras.lens_mesh import mark_mesh
from riglens.core.kernels.fans.fan import work_by_row
from riglens.core.kernels.rays import cast
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.rays.strides import STRIP, mark_strides
from riglens.core.kernels.rays.walk import FARTHEST
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Method
from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.scene.columns import Words, words_per_column
from riglens.core.sensing.rational_walk import walk_rational
from riglens.core.sensing.rays import farthest_m, lattice, limits_m, rotate, sensor_rays
from riglens.core.sensors.lattice import Lattice
from riglens.core.vehicle.solid import Barrier

RAYS_PER_CHUNK = 1 << 15
"""Rays that a worker walks between two checks for cancellation."""
PLANES_PER_CHUNK = 512
ROWS_PER_CHUNK = 128
FEW_RAYS = 512
"""So many rays are walked before another thread has begun."""


class Window(NamedTuple):
    """Rows along x, and words of each row, outside of which a sensor marks nothing: first and end of both."""

    first_row: int
    end_row: int
    first_word: int
    end_word: int

    def joined(self, other: Window) -> Window:
        """Return the smallest window that holds both."""
        return Window(
            min(self.first_row, other.first_row),
            max(self.end_row, other.end_row),
            min(self.first_word, other.first_word),
            max(self.end_word, other.end_word),
        )


@singledispatch
def _outermost(sensor: Sensor) -> NDArray[np.float64] | None:
    """Return directions (n, 3) in the vehicle frame between which all rays of a sensor lie; None if unknown.

    All rays of a sensor that looks into sectors, which has few.
    """
    if not limits_m(sensor).size:
        return None
    return rotate(sensor.pose.rotation(), lattice(sensor).directions())


@_outermost.register
def _outermost_of_image(camera: Camera) -> NDArray[np.float64] | None:
    if camera.distortion is not None:
        return outermost_directions(camera)
    columns, rows = camera.resolution
    corners = [row * columns + column for row in (0, rows - 1) for column in (0, columns - 1)]
    return sensor_rays(camera, np.array(corners)).directions


class Caster:
    """Caster of sensors against one entropy field with a number of workers."""

    def __init__(self, field: EntropyField, workers: int = 1) -> None:
        self.workers = workers
        self._field = field
        self._shape = np.array(field.grid.shape, np.int64)
        self._spare = np.zeros((0, field.index.words.size), np.uint64)

    def mark(
        self,
        sensor: Sensor,
        method: Method,
        window: Window,
        marks: Words,
        is_stale: IsStale = never_stale,
        barrier: Barrier | None = None,
    ) -> bool:
        """Set the bits of the voxels traversed, of all informative ones and possibly of others (paper, eq. 10).

        `window` is that of the sensor; marks uint64 (words,); rays end at the barrier. Returns False when abandoned
        half-way; some bits are then set.
        """
        free, *cut = self._casts(sensor, method, barrier)
        done = self._mark_free(sensor, free, method, window, marks, is_stale)
        return done and (not cut or self._mark_each(cut, marks, is_stale))

    def _mark_free(
        self, sensor: Sensor, rays: Cast, method: Method, window: Window, marks: Words, is_stale: IsStale
    ) -> bool:
        """Mark along rays that the car does not stop by the fastest method that applies; ray by ray where they have
        ends."""
        if rays.ends.size:
            return self._mark_rays(rays, marks, is_stale)
        if method == "exact" and is_upright(rays.rotation) and is_plain(rays):
            return self._mark_fan(rays, window, marks, is_stale)
        if method == "exact" and not sensor.blocked:
            done = self._mark_quickly(sensor, rays, window, marks, is_stale)
            if done is not None:
                return done
        return self._mark_rays(rays, marks, is_stale)

    @singledispatchmethod
    def _mark_quickly(
        self, _sensor: Sensor, _rays: Cast, _window: Window, _marks: Words, _is_stale: IsStale
    ) -> bool | None:
        """Cast by a method that only serves some sensors; return None if there is none."""
        return None

    @_mark_quickly.register
    def _mark_beams(
        self, lidar: Lidar, rays: Cast, window: Window, marks: Words, is_stale: IsStale
    ) -> bool | None:
        if lidar.rays is not None:
            return None
        parts = by_offset(lidar, rays) if is_upright(rays.rotation) else []
        if parts:
            return all(self._mark_fan(part, window, marks, is_stale) for part in parts)
        sheets = make_sheets(lidar, rays) if lidar.ray_count >= FEWEST_RAYS else None
        return None if sheets is None else self._mark_sheets(sheets, rays, window, marks, is_stale)

    @_mark_quickly.register
    def _mark_image(
        self, camera: Camera, rays: Cast, window: Window, marks: Words, is_stale: IsStale
    ) -> bool | None:
        frustum = make_frustum(camera, rays)
        if frustum is not None:
            return self._mark_frustum(frustum, rays, window, marks, is_stale)
        mesh = make_mesh(camera, rays)
        return None if mesh is None else self._mark_mesh(mesh, rays, window, marks, is_stale)

    def _mark_frustum(
        self, frustum: Frustum, rays: Cast, window: Window, marks: Words, is_stale: IsStale
    ) -> bool:
        """Mark near voxels by voxel walking, and those beyond its depth limit ray by ray."""
        mark, rest = partial(mark_frustum, frustum), _beyond(rays, frustum.depth_limit)
        return self._mark_near(mark, rays.box, window, rest, marks, is_stale)

    def _mark_mesh(
        self, mesh: CameraMesh, rays: Cast, window: Window, marks: Words, is_stale: IsStale
    ) -> bool:
        """Mark near voxels by their place in the mesh of rays; those beyond, and rays outside of the mesh, ray by
        ray."""
        mark, rest = partial(mark_mesh, mesh.view, mesh.bins), _beyond(rays, mesh.view.limit)
        loose = [_some(rays, mesh.loose)] if mesh.loose.size else []
        return self._mark_near(mark, rays.box, window, loose + rest, marks, is_stale)

    def _mark_sheets(
        self, sheets: Sheets, rays: Cast, window: Window, marks: Words, is_stale: IsStale
    ) -> bool:
        """Mark near tiles by core and sheets; steep beams, and voxels beyond the tiles, ray by ray."""
        mark = partial(mark_sheets, sheets.spinner, sheets.beams, sheets.shells, sheets.radius)
        return self._mark_near(mark, rays.box, window, sheets.rest, marks, is_stale)

    def _mark_near(
        self,
        mark: Callable[..., None],
        box: NDArray[np.int64],
        window: Window,
        rest: list[Cast],
        marks: Words,
        is_stale: IsStale,
    ) -> bool:
        """Mark voxels by a kernel that takes rows of the grid, in a box of cells and a window, and the rest ray by
        ray."""
        first, last = max(int(box[0]), window.first_row), min(int(box[1]), window.end_row)
        step = ROWS_PER_CHUNK * self.workers
        for start in range(first, last, step):
            if is_stale():
                return False
            mark(start, min(start + step, last), self._field.index.words, self.workers, marks)
        return not rest or self._mark_each(rest, marks, is_stale)

    @property
    def field(self) -> EntropyField:
        """Return the entropy field that sensors are cast against."""
        return self._field

    def window(self, sensor: Sensor) -> Window:
        """Return where a sensor can mark: within its range, and only ahead of it along the axes on which all its rays
        point the same way: all corner rays of a pinhole, all rays where a lens has distortion or rows have limits."""
        nx, ny, _ = self._field.grid.shape
        sides, cells = [0, nx, 0, ny], min(farthest_m(sensor) / self._field.grid.voxel_m, FARTHEST)
        places = self._field.grid.to_grid(sensor.position)[:2]
        for axis, (place, most) in enumerate(zip(places, (nx, ny), strict=True)):
            sides[2 * axis] = min(max(math.floor(place - cells) - 1, 0), most - 1)
            sides[2 * axis + 1] = min(max(math.ceil(place + cells) + 1, 1), most)
        directions = _outermost(sensor)
        if directions is not None:
            for axis, (place, most) in enumerate(zip(places, (nx, ny), strict=True)):
                cell = min(max(math.floor(place), 0), most - 1)
                if (directions[:, axis] > 0.0).all():
                    sides[2 * axis] = max(cell - 1, sides[2 * axis])
                elif (directions[:, axis] < 0.0).all():
                    sides[2 * axis + 1] = min(cell + 2, sides[2 * axis + 1])
        depth = words_per_column(self._field.grid)
        return Window(sides[0], sides[1], sides[2] * depth, sides[3] * depth)

    def _mark_fan(self, rays: Cast, window: Window, marks: Words, is_stale: IsStale) -> bool:
        near_is_empty = rays.is_stopped.size > 0 and self._is_empty_near(rays)
        fan = make_fan(rays, near_is_empty)
        profile = make_profile(fan, rays)
        if profile is None:
            return self._mark_rays(rays, marks, is_stale)
        slabs = share_rows(work_by_row(fan, rays, profile), window.first_row, window.end_row, self.workers)
        planes = len(rays.planes)
        for start in range(0, planes, PLANES_PER_CHUNK):
            if is_stale():
                return False
            end = min(start + PLANES_PER_CHUNK, planes)
            mark_planes(fan, rays, profile, start, end, slabs, marks)
        return True

    def _is_empty_near(self, rays: Cast) -> bool:
        """Return whether no voxel is informative in any column in which a ray may not have begun."""
        room = rays.reach[0] + 1e-3
        low = np.maximum(np.floor(rays.origin[:2] - room), 0.0).astype(np.int64)
        high = np.minimum(np.ceil(rays.origin[:2] + room), self._shape[:2]).astype(np.int64)
        words = self._field.index.words.reshape(*self._shape[:2], -1)
        return not words[low[0] : max(high[0], 0), low[1] : max(high[1], 0)].any()

    def _mark_rays(self, rays: Cast, marks: Words, is_stale: IsStale) -> bool:
        return self._mark_each([rays], marks, is_stale)

    def _mark_each(self, casts: list[Cast], marks: Words, is_stale: IsStale) -> bool:
        """Mark ray by ray; every worker but the first marks a set of its own, and these are added at the end."""
        if len(self._spare) < self.workers - 1:
            self._spare = np.zeros((self.workers - 1, marks.size), np.uint64)
        spare = self._spare[: self.workers - 1]
        try:
            return all(self._mark_all(rays, marks, spare, is_stale) for rays in casts)
        finally:
            if len(spare):
                cast.add_marks(spare, marks, self.workers)

    def _mark_all(self, rays: Cast, marks: Words, spare: NDArray[np.uint64], is_stale: IsStale) -> bool:
        """Mark in strides where possible, and the rest one by one."""
        left = np.ones(len(rays.rows) * len(rays.planes), np.bool_)
        if not left.size:
            return True
        if may_stride(rays):
            planes = planes_of(rays)
            for start, end in _chunks_of_planes(planes, left.size // planes, self.workers):
                if is_stale():
                    return False
                mark_strides(rays, planes, start, end, marks, spare, left)
        count = np.count_nonzero(left)
        if count > FEW_RAYS:
            for _, start, end in _chunks_of([rays], self.workers):
                if is_stale():
                    return False
                cast.mark_rays(rays, start, end, marks, spare, left[start:end])
        elif count > 0:
            jit.use_threads(1)  # others would take longer to come
            cast.mark_rays(rays, 0, left.size, marks, spare[:0], left)
            jit.use_threads(self.workers)
        for word, bit in self.walk_irregular(rays, np.flatnonzero(left)):
            marks[word] |= bit
        return True

    def hits(
        self,
        sensor: Sensor,
        method: Method,
        is_stale: IsStale = never_stale,
        barrier: Barrier | None = None,
    ) -> tuple[int, ...] | None:
        """Return the sum of h over the voxels of all rays, in fixed point, per class; None when cancelled."""
        entropies, totals = self._field.entropies, [0, 0, 0]
        for rays, start, end in _chunks_of(self._casts(sensor, method, barrier)):
            if is_stale():
                return None
            irregular = np.zeros(end - start, np.bool_)
            sums = cast.sum_hits(rays, start, end, self.workers, entropies, irregular)
            totals = [total + int(part) for total, part in zip(totals, sums, strict=True)]
            for word, bit in self.walk_irregular(rays, start + np.flatnonzero(irregular)):
                totals = [t + h for t, h in zip(totals, self._entropy_at(word, bit), strict=True)]
        return tuple(totals)

    def _entropy_at(self, word: int, bit: np.uint64) -> list[int]:
        index = self._field.index
        keep = int(index.words[word])
        if not keep & int(bit):
            return [0, 0, 0]
        runs, upto = self._field.runs, int(bit) | (int(bit) - 1)
        run = int(runs.first[word]) + (int(runs.starts[word]) & upto).bit_count() - 1
        return [int(h) for h in self._field.entropies_q[runs.codes[run], :3]]

    def _casts(self, sensor: Sensor, method: Method, barrier: Barrier | None) -> list[Cast]:
        """Return the rays of a sensor: those that no barrier stops and, if there are any, those that end at one."""
        rays = self.rays(sensor, method)
        if barrier is None:
            return [rays]
        free, cut = blocked(rays, self._field, sensor, method, barrier, self.workers)
        return [free, cut] if cut.ends.size else [free]

    def rays(self, sensor: Sensor, method: Method) -> Cast:
        """Return all rays of a sensor in grid units, as if there were no car."""
        grid, table = self._field.grid, lattice(sensor)
        reach = np.array([min(limit / grid.voxel_m, FARTHEST) for limit in sensor.range_m])
        box = self._field.index.bounds
        if (
            method == "bresenham"
        ):  # its lines depend on their ends: the whole ROI, not only what is informative
            box = np.array([0, grid.shape[0], 0, grid.shape[1], 0, grid.shape[2]], np.int64)
        origin, rotation = np.array(grid.to_grid(sensor.position)), sensor.pose.rotation()
        return Cast(
            table.kind,
            table.rows,
            table.planes,
            origin,
            rotation,
            reach,
            box,
            self._shape,
            method == "bresenham",
            table.limits_m / grid.voxel_m,
            in_row=sensor.resolution[0],
        )

    def walk_irregular(self, rays: Cast, numbers: NDArray[np.int64]) -> Iterator[tuple[int, np.uint64]]:
        """Yield word and bit of every voxel of the rays that the kernels left out."""
        grid = self._field.grid
        depth = words_per_column(grid)
        origin = (float(rays.origin[0]), float(rays.origin[1]), float(rays.origin[2]))
        near, reach = float(rays.reach[0]), float(rays.reach[1])
        directions = Lattice(rays.kind, rays.rows, rays.planes).directions(numbers)
        for ray, (x, y, z) in zip(numbers, directions, strict=True):
            far = min(reach, float(rays.ends[ray])) if rays.ends.size else reach
            dx, dy, dz = (float((row[0] * x + row[1] * y) + row[2] * z) for row in rays.rotation)
            for ix, iy, iz in walk_rational(origin, (dx, dy, dz), near, far, [int(b) for b in rays.box]):
                yield (ix * grid.shape[1] + iy) * depth + iz // 64, np.uint64(1 << (iz % 64))


def _chunks_of_planes(planes: int, rows: int, workers: int) -> Iterator[tuple[int, int]]:
    """Yield first and end plane of a lattice of `planes` planes and `rows` rows, a chunk at a time."""
    step = max(RAYS_PER_CHUNK // rows, STRIP) * workers
    for start in range(0, planes, step):
        yield start, min(start + step, planes)


def _beyond(rays: Cast, limit: float) -> list[Cast]:
    """Return the parts of rays that go on beyond a limit near to the sensor."""
    return [] if limit > farthest(rays) else [rays._replace(reach=np.array([limit - 1.0, FARTHEST]))]


def _some(rays: Cast, numbers: NDArray[np.int64]) -> Cast:
    """Return some of a sensor's listed rays."""
    is_stopped = rays.is_stopped[numbers] if rays.is_stopped.size else rays.is_stopped
    return rays._replace(rows=rays.rows[numbers], is_stopped=is_stopped)


def _chunks_of(casts: list[Cast], workers: int = 1) -> Iterator[tuple[Cast, int, int]]:
    """Yield rays with first and end number, a chunk at a time."""
    for rays in casts:
        count = len(rays.rows) * len(rays.planes)
        for start in range(0, count, RAYS_PER_CHUNK * workers):
            yield rays, start, min(start + RAYS_PER_CHUNK * workers, count)
