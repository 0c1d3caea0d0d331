"""From counts per sensor to counts per road user, and to tables per class and ring of distance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels import targets as kernel
from riglens.core.rig.model import Camera, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.contribution import Contribution
from riglens.core.targets.settings import CELLS_SCALE, HEIGHT_PX, RING_M, RINGS_TO_M, TargetSettings
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True)
class ObjectCounts:
    """Of k road users that count, in the order of the sampled frames.

    box (k,): their places in the traffic; points (k, lidars) rays that reach them first, pixels (k, cameras) native
    pixels that show them, of the enabled sensors by name; points_alone and pixels_alone (k,): of all of them together
    if nothing stood before; cells (k,): distinct cells of 0.2 m that LiDARs hit; height_px (k,): rows of native pixels
    from the first to the last that shows it, of the camera that shows it tallest.
    """

    box: Counts
    lidars: tuple[str, ...]
    cameras: tuple[str, ...]
    points: Counts
    pixels: Doubles
    points_alone: Counts
    pixels_alone: Doubles
    cells: Counts
    height_px: Doubles

    @cached_property
    def all_points(self) -> Counts:
        """Points of all LiDARs, (k,)."""
        return np.asarray(self.points.sum(axis=1))

    @cached_property
    def visible(self) -> Doubles:
        """Pixels seen over pixels without anything before it, of all cameras, (k,); 0 where no camera could see it."""
        alone = np.where(self.pixels_alone > 0.0, self.pixels_alone, 1.0)
        return np.asarray(self.pixels.sum(axis=1) / alone)

    @cached_property
    def on_target(self) -> Doubles:
        """1 - exp(-cells / 5), (k,)."""
        return np.asarray(1.0 - np.exp(-self.cells / CELLS_SCALE))


@dataclass(frozen=True)
class Estimate:
    """A mean over objects, and its standard error as an estimate of that over all frames: 0 where all were used."""

    value: float = 0.0
    se: float = 0.0


@dataclass(frozen=True)
class Row:
    """Road users of one class, in one ring or in all: how many, and what the rig gets onto them.

    LiDARs: on_target, shares with at least 1, 5 and `min_points` points, median points. Cameras: mean visible share,
    share at least 25 pixels tall, median height. By both: `min_points` points and 25 pixels; by neither: none of them.
    """

    from_m: float
    to_m: float
    objects: int
    on_target: Estimate
    share_1: Estimate
    share_5: Estimate
    share_n: Estimate
    median_points: float
    visible: Estimate
    share_25px: Estimate
    median_height_px: float
    both: Estimate
    neither: Estimate


@dataclass(frozen=True)
class ClassTargets:
    """The table of a class: all of its objects, and ring by ring."""

    total: Row
    rings: tuple[Row, ...]


@dataclass(frozen=True)
class TargetScores:
    """What a rig gets onto the road users of `frames_used` of the `frames` frames."""

    rig: Rig
    settings: TargetSettings
    frames: int
    frames_used: int
    within_m: float
    objects: ObjectCounts
    classes: Mapping[str, ClassTargets]
    elapsed_ms: float = 0.0


def scores_of(
    traffic: Traffic,
    rig: Rig,
    settings: TargetSettings,
    by_sensor: Mapping[str, Contribution],
    frames: int,
    workers: int = 1,
) -> TargetScores:
    """Put together what the enabled sensors get in the first `frames` frames."""
    objects = _objects(traffic, rig, by_sensor, frames, workers)
    classes = {
        name: _class_targets(traffic, objects, settings, number, frames)
        for number, name in enumerate(CLASSES)
    }
    return TargetScores(rig, settings, traffic.frames, frames, traffic.within_m, objects, classes)


def _objects(
    traffic: Traffic, rig: Rig, by_sensor: Mapping[str, Contribution], frames: int, workers: int
) -> ObjectCounts:
    end = int(traffic.starts[frames])
    box = np.flatnonzero(traffic.counts[:end])
    lidars, cameras = rig.lidars(), rig.cameras()
    of_lidars = [by_sensor[sensor.name] for sensor in lidars]
    of_cameras = [by_sensor[sensor.name] for sensor in cameras]
    scale = np.array([_native(camera) for camera in cameras]).reshape(-1, 2)
    area = scale.prod(axis=1)
    seen = _column(of_cameras, kernel.LAST_ROW, box) - _column(of_cameras, kernel.FIRST_ROW, box) + 1
    shown = _column(of_cameras, kernel.FIRST_ROW, box) >= 0
    heights = np.where(shown, seen * scale[:, 1], 0.0)
    return ObjectCounts(
        box,
        tuple(sensor.name for sensor in lidars),
        tuple(sensor.name for sensor in cameras),
        _column(of_lidars, kernel.RAYS, box),
        _column(of_cameras, kernel.RAYS, box) * area,
        _column(of_lidars, kernel.ALONE, box).sum(axis=1),
        (_column(of_cameras, kernel.ALONE, box) * area).sum(axis=1),
        _cells(of_lidars, end, workers)[box],
        heights.max(axis=1, initial=0.0),
    )


def _native(camera: Camera) -> tuple[float, float]:
    """Native pixels per ray of the lattice, across and down."""
    return camera.image[0] / camera.cast[0], camera.image[1] / camera.cast[1]


def _column(contributions: list[Contribution], column: int, box: Counts) -> Counts:
    """A column of what sensors found on boxes (k,), (k, sensors)."""
    parts = [one.found[box, column].astype(np.int64) for one in contributions]
    return np.stack(parts, axis=1) if parts else np.zeros((len(box), 0), np.int64)


def _cells(lidars: list[Contribution], objects: int, workers: int) -> Counts:
    """Distinct cells on each of the first objects, (objects,), of all LiDARs together."""
    if not lidars or not objects:
        return np.zeros(objects, np.int64)
    if len(lidars) == 1:
        return lidars[0].found[:objects, kernel.CELLS].astype(np.int64)
    ends = [int(one.cell_starts[objects]) for one in lidars]
    begins = np.concatenate([[0], np.cumsum(ends)])
    starts = np.stack(
        [one.cell_starts[: objects + 1] + begin for one, begin in zip(lidars, begins, strict=False)]
    )
    cells = np.concatenate([one.cells[:end] for one, end in zip(lidars, ends, strict=True)])
    found = np.zeros(objects, np.int64)
    kernel.joined_cells(starts, cells, int(np.diff(starts, axis=1).sum(axis=0).max()), workers, found)
    return found


def _class_targets(
    traffic: Traffic, objects: ObjectCounts, settings: TargetSettings, number: int, frames: int
) -> ClassTargets:
    mine = traffic.cls[objects.box] == number
    distance_m = traffic.distance_m[objects.box]
    edges = np.append(np.arange(0.0, min(traffic.within_m, RINGS_TO_M + 1e-9), RING_M), traffic.within_m)
    rings = []
    for low, high in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        # the last ring ends with what counts: its end belongs to it
        inside = (distance_m >= low) & ((distance_m < high) | (high == traffic.within_m))
        rings.append(_row(traffic, objects, settings, mine & inside, frames, (low, high)))
    return ClassTargets(_row(traffic, objects, settings, mine, frames, (0.0, traffic.within_m)), tuple(rings))


def _row(
    traffic: Traffic,
    objects: ObjectCounts,
    settings: TargetSettings,
    chosen: NDArray[np.bool_],
    frames: int,
    ring_m: tuple[float, float],
) -> Row:
    frame = traffic.frame_of_box[objects.box[chosen]]
    points, height_px = objects.all_points[chosen], objects.height_px[chosen]

    def mean(values: NDArray[np.generic]) -> Estimate:
        return _mean(values.astype(np.float64), frame, frames, traffic.frames)

    by_lidar, by_camera = points >= settings.min_points, height_px >= HEIGHT_PX
    return Row(
        *ring_m,
        int(np.count_nonzero(chosen)),
        mean(objects.on_target[chosen]),
        mean(points >= 1),
        mean(points >= 5),
        mean(by_lidar),
        float(np.median(points)) if points.size else 0.0,
        mean(objects.visible[chosen]),
        mean(by_camera),
        float(np.median(height_px)) if height_px.size else 0.0,
        mean(by_lidar & by_camera),
        mean(~by_lidar & ~by_camera),
    )


def _mean(values: Doubles, frame: Counts, used: int, frames: int) -> Estimate:
    """Mean of values (k,) of objects in frames (k,) < used, and its standard error.

    Objects of a frame are not independent, so frames are what was drawn: a ratio of two totals over frames, linearised
    (Cochran, Sampling Techniques, 1977, chapter 6), with the correction for a finite number of frames.
    """
    if not values.size:
        return Estimate()
    mean = float(values.sum() / values.size)
    if used == frames or used < 2:
        return Estimate(mean, 0.0)
    misses = np.bincount(frame, values - mean, used)
    spread = float(misses @ misses) / (used - 1)
    return Estimate(mean, float(np.sqrt(spread * (1.0 - used / frames) * used)) / values.size)
