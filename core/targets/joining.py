"""Join the hits of all sensors per object, from one edit to the next; unchanged results are kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from riglens.core.in_threads import in_threads
from riglens.core.kernels.objects import unique_cells
from riglens.core.kernels.objects.counts import ALONE, CELLS, FIRST_CELL, FIRST_ROW, LAST_CELL, LAST_ROW, RAYS
from riglens.core.rig.model import Camera, Rig
from riglens.core.sensors.registry import further_kinds
from riglens.core.targets.contribution import Contribution
from riglens.core.targets.counts import ObjectCounts, Returns

Counts = NDArray[np.int64]
Doubles = NDArray[np.float64]
Lidars = tuple[Contribution, ...]
T = TypeVar("T")
WORDS, WORDS_PER_CELL = 1 << 20, 8
"""Marks may take that many words of 8 bytes, and as many more for each cell; real traffic takes one for five cells."""


class Gatherer:
    """Collector of the sensors' hits on the same objects, over successive calls."""

    def __init__(self, workers: int) -> None:
        self._cells = JoinedCells(workers)
        self._lidars = _Kept[tuple[Counts, Counts, Counts]]()
        self._cameras = _Kept[tuple[Doubles, Doubles, Doubles, Doubles]]()

    def objects(self, box: Counts, rig: Rig, by_sensor: Mapping[str, Contribution]) -> ObjectCounts:
        """Return the hits of a rig's enabled sensors on objects at positions box (k,) of the traffic."""
        lidars, cameras, count = rig.enabled_lidars(), rig.enabled_cameras(), len(box)
        of_lidars, of_cameras = (
            tuple(by_sensor[sensor.name] for sensor in sensors) for sensors in (lidars, cameras)
        )
        native = np.array([_native(camera) for camera in cameras]).reshape(-1, 2)
        points, alone, cells = self._lidars.of(
            (of_lidars, count), lambda: _by_lidars(of_lidars, count, self._cells)
        )
        pixels, pixels_alone, heights_px, shown = self._cameras.of(
            (of_cameras, count, native.tolist()), lambda: _by_cameras(of_cameras, count, native)
        )
        return ObjectCounts(
            box,
            tuple(sensor.name for sensor in lidars),
            tuple(sensor.name for sensor in cameras),
            points,
            pixels,
            alone,
            pixels_alone,
            cells,
            heights_px,
            shown,
            _returns(rig, by_sensor, count),
        )


def _returns(rig: Rig, by_sensor: Mapping[str, Contribution], objects: int) -> dict[str, Returns]:
    """Return the returns, or rows of pixels, of the kinds beside LiDARs and cameras, by kind."""
    found, enabled = {}, [sensor for sensor in rig.sensors if sensor.enabled]
    for kind in further_kinds(sensor.kind for sensor in enabled):
        names = tuple(sensor.name for sensor in enabled if sensor.kind == kind.name)
        parts, is_image = tuple(by_sensor[name] for name in names), kind.hits.measure == "pixels"
        counts = _column(parts, RAYS, objects)
        if is_image:
            counts = np.array([_rows_of(one.found[:, :objects]) for one in parts], np.int64).T
        found[kind.name] = Returns(names, counts, is_image)
    return found


def _rows_of(found: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the rows of the lattice from the first to the last that meets an object, (objects,), from what a sensor
    found on them."""
    first, last = found[FIRST_ROW], found[LAST_ROW]
    return np.where(first >= 0, last - first + 1, np.int32(0))


def _native(camera: Camera) -> tuple[float, float]:
    """Return native pixels per ray of the lattice, across and down."""
    (width, height), (columns, rows) = camera.image, camera.resolution
    return width / columns, height / rows


def heights_px(camera: Camera, found: NDArray[np.int32]) -> Doubles:
    """Return the heights of objects in the picture of a camera, native pixels (objects,), from what it found on them,
    (rows of results, objects)."""
    return np.asarray(_rows_of(found) * _native(camera)[1])


def _by_lidars(lidars: Lidars, objects: int, cells: JoinedCells) -> tuple[Counts, Counts, Counts]:
    """Return points (objects, lidars), points of all LiDARs without occlusion, and unique cells, both (objects,)."""
    alone = _column(lidars, ALONE, objects).sum(axis=1)
    return _column(lidars, RAYS, objects), alone, cells.of(lidars, objects)


def _by_cameras(
    cameras: tuple[Contribution, ...], objects: int, native: Doubles
) -> tuple[Doubles, Doubles, Doubles, Doubles]:
    """Return pixels (objects, cameras), pixels of all cameras without occlusion (objects,), heights (objects, cameras)
    in pixels, and the share of the whole silhouette that each camera shows (objects, cameras)."""
    pixels, heights, shown = np.empty((3, len(cameras), objects))
    every = np.zeros(objects)
    for place, (one, (across, down)) in enumerate(zip(cameras, native.tolist(), strict=True)):
        seen, alone = one.found[RAYS, :objects], one.found[ALONE, :objects]
        np.multiply(seen, across * down, out=pixels[place])
        every += alone * (across * down)
        heights[place] = _rows_of(one.found[:, :objects]) * down
        np.divide(one.inside[:objects] * seen, np.maximum(alone, 1), out=shown[place])
    return pixels.T, every, heights.T, shown.T


def _column(contributions: tuple[Contribution, ...], column: int, objects: int) -> Counts:
    """Return a column of the sensors' figures for the first objects, (objects, sensors)."""
    found = np.empty((len(contributions), objects), np.int64)
    for place, one in enumerate(contributions):
        found[place] = one.found[column, :objects]
    return found.T


class _Kept(Generic[T]):
    """Last result, of these very contributions: only the same ones are equal."""

    def __init__(self) -> None:
        self._last: tuple[tuple[object, ...], T] | None = None

    def of(self, key: tuple[object, ...], make: Callable[[], T]) -> T:
        """Return what `make` makes, or has made for an equal key."""
        if self._last is None or self._last[0] != key:
            self._last = key, make()
        return self._last[1]


class JoinedCells:
    """Counter of the distinct cells of all LiDARs together, over successive calls; with one worker in any thread.

    Marks of all cells but those of the LiDAR that was moved last are kept: a drag looks up its cells alone.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._last: Lidars = ()
        self._others = _Kept[tuple[unique_cells.Marks, Counts] | None]()

    def of(self, lidars: Lidars, objects: int) -> Counts:
        """Count the distinct cells on each of the first objects, (objects,)."""
        lidars = tuple(dict.fromkeys(lidars))  # twins share theirs
        moved = [one for one in lidars if one not in self._last] or lidars[-1:]
        self._last = lidars
        if len(lidars) < 2:
            self._others = _Kept()
            return np.asarray(_column(lidars, CELLS, objects).sum(axis=1))
        others = tuple(one for one in lidars if one is not moved[0])
        marked = self._others.of((others, objects), lambda: self._marked(others, objects))
        if marked is None:
            return sorted_cells(lidars, objects)
        marks, found = marked[0], marked[1].copy()
        self._count(marks, moved[0], False, found)
        return found

    def _marked(self, lidars: Lidars, objects: int) -> tuple[unique_cells.Marks, Counts] | None:
        """Return marks of the cells of all these LiDARs, and their number on each object; None if the marks need far
        more memory than the cells."""
        first, last = (
            reduce(extreme, (one.found[row : row + 3, :objects] for one in lidars)).astype(np.int64)
            for extreme, row in ((np.minimum, FIRST_CELL), (np.maximum, LAST_CELL))
        )
        sides = np.maximum(last - first + 1, 0)
        words = (sides.prod(axis=0) + 63) // 64
        if words.sum() > WORDS + WORDS_PER_CELL * sum(one.cells.size for one in lidars):
            return None
        begins, found = np.cumsum(words) - words, np.zeros(objects, np.int64)
        marks = unique_cells.Marks(first, sides, begins, np.zeros(int(words.sum()), np.int64))
        for one in lidars:
            self._count(marks, one, True, found)
        return marks, found

    def _count(self, marks: unique_cells.Marks, lidar: Contribution, marks_them: bool, found: Counts) -> None:
        counts, starts = lidar.found[CELLS, : found.size], lidar.cell_starts[: found.size]
        how = marks, starts, counts, lidar.cells, marks_them

        def count(share: int) -> None:
            first, end = (found.size * one // self._workers for one in (share, share + 1))
            unique_cells.count_unmarked(*how, first, end, found)

        in_threads(self._workers, count)


def sorted_cells(lidars: Lidars, objects: int) -> Counts:
    """Count the distinct cells of all LiDARs on each of the first objects by sorting them, (objects,): slow, and in
    memory that grows with the cells alone, however far apart they are."""
    every = list[Counts]()
    for one in lidars:
        counts = one.found[CELLS, :objects].astype(np.int64)
        shift = one.cell_starts[:objects] - np.cumsum(counts) + counts
        place = np.arange(counts.sum()) + np.repeat(shift, counts)
        every.append(np.stack([np.repeat(np.arange(objects), counts), one.cells[place]]))
    owner, _ = np.unique(np.concatenate(every, axis=1), axis=1)
    return np.bincount(owner, minlength=objects)
