"""Join the hits of all sensors per object, from one edit to the next; unchanged results are kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects import unique_cells
from riglens.core.kernels.objects.counts import ALONE, CELLS, FIRST_ROW, LAST_ROW, RAYS
from riglens.core.rig.model import Camera, Rig
from riglens.core.sensors.registry import further_kinds
from riglens.core.targets.contribution import Contribution
from riglens.core.targets.scores import ObjectCounts, Returns

Counts = NDArray[np.int64]
Doubles = NDArray[np.float64]
Lidars = tuple[Contribution, ...]
T = TypeVar("T")


class Gatherer:
    """Collector of the sensors' hits on the same objects, over successive calls."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._lidars = _Kept[tuple[Counts, Counts, Counts]]()
        self._cameras = _Kept[tuple[Doubles, Doubles, Doubles]]()

    def objects(self, box: Counts, rig: Rig, by_sensor: Mapping[str, Contribution]) -> ObjectCounts:
        """Return the hits of a rig's enabled sensors on objects at positions box (k,) of the traffic."""
        lidars, cameras, count = rig.enabled_lidars(), rig.enabled_cameras(), len(box)
        of_lidars, of_cameras = (
            tuple(by_sensor[sensor.name] for sensor in sensors) for sensors in (lidars, cameras)
        )
        native = np.array([_native(camera) for camera in cameras]).reshape(-1, 2)
        points, alone, cells = self._lidars.of(
            (of_lidars, count), lambda: _by_lidars(of_lidars, count, self._workers)
        )
        pixels, pixels_alone, heights_px = self._cameras.of(
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
            _returns(rig, by_sensor, count),
        )


def _returns(rig: Rig, by_sensor: Mapping[str, Contribution], objects: int) -> dict[str, Returns]:
    """Return the returns, or rows of pixels, of the kinds beside LiDARs and cameras, by kind."""
    found, enabled = {}, [sensor for sensor in rig.sensors if sensor.enabled]
    for kind in further_kinds(sensor.kind for sensor in enabled):
        names = tuple(sensor.name for sensor in enabled if sensor.kind == kind.name)
        parts, is_image = tuple(by_sensor[name] for name in names), kind.hits.measure == "pixels"
        counts = _rows(parts, objects) if is_image else _column(parts, RAYS, objects)
        found[kind.name] = Returns(names, counts, is_image)
    return found


def _rows(images: tuple[Contribution, ...], objects: int) -> Counts:
    """Return the rows of the lattice from the first to the last that meets an object, (objects, images)."""
    first, last = (_column(images, column, objects) for column in (FIRST_ROW, LAST_ROW))
    return np.where(first >= 0, last - first + 1, 0)


def _native(camera: Camera) -> tuple[float, float]:
    """Return native pixels per ray of the lattice, across and down."""
    (width, height), (columns, rows) = camera.image, camera.resolution
    return width / columns, height / rows


def heights_px(camera: Camera, found: NDArray[np.int32]) -> Doubles:
    """Return the heights of objects in the picture of a camera, native pixels (objects,), from what it found on them,
    (rows of results, objects)."""
    first, last = found[FIRST_ROW], found[LAST_ROW]
    return np.where(first >= 0, last - first + 1, 0) * _native(camera)[1]


def _by_lidars(lidars: Lidars, objects: int, workers: int) -> tuple[Counts, Counts, Counts]:
    """Return points (objects, lidars), points of all LiDARs without occlusion, and unique cells, both (objects,)."""
    alone = _column(lidars, ALONE, objects).sum(axis=1)
    return _column(lidars, RAYS, objects), alone, joined_cells(lidars, objects, workers)


def _by_cameras(
    cameras: tuple[Contribution, ...], objects: int, native: Doubles
) -> tuple[Doubles, Doubles, Doubles]:
    """Return pixels (objects, cameras), pixels of all cameras without occlusion (objects,), and heights (objects,
    cameras) in pixels."""
    area = native.prod(axis=1)
    alone = (_column(cameras, ALONE, objects) * area).sum(axis=1)
    return _column(cameras, RAYS, objects) * area, alone, _rows(cameras, objects) * native[:, 1]


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


def joined_cells(lidars: Lidars, objects: int, workers: int) -> Counts:
    """Count the distinct cells of all LiDARs together on each of the first objects, (objects,); with one worker in any
    thread."""
    lidars = tuple(dict.fromkeys(lidars))  # twins share theirs
    if len(lidars) < 2:
        return lidars[0].found[CELLS, :objects].astype(np.int64) if lidars else np.zeros(objects, np.int64)
    begins = np.cumsum([0, *(one.cells.size for one in lidars)])
    lists = unique_cells.Lists(
        np.stack([one.cell_starts[:objects] + begin for one, begin in zip(lidars, begins, strict=False)]),
        np.stack([one.found[CELLS, :objects] for one in lidars]),
        np.concatenate([one.cells for one in lidars]),
    )
    found, most = np.empty(objects, np.int64), int(lists.counts.sum(axis=0).max(initial=0))
    count = unique_cells.count_cells_serial if workers == 1 else unique_cells.count_cells
    count(lists, most, workers, found)
    return found
