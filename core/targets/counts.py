"""Counts of sensors' hits on each object, and what they were counted in."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Rig
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import kind_named
from riglens.core.targets.calibration import Calibration, shipped
from riglens.core.targets.camera_losses import CameraLosses
from riglens.core.targets.groups import Groups
from riglens.core.targets.settings import CELLS_SCALE, HALF, TargetSettings
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]


def _unfailed(names: tuple[str, ...], failed: Collection[str]) -> NDArray[np.bool_]:
    return np.array([name not in failed for name in names], np.bool_)


@dataclass(frozen=True)
class Returns:
    """Rays of the sensors of one kind, by name, that reach k objects first, or rows of pixels that show them: counts
    (k, sensors); is_image: the sensor with most counts, not the sum of all."""

    names: tuple[str, ...]
    counts: Counts
    is_image: bool = False

    def without(self, failed: Collection[str]) -> Counts:
        """Return the counts of all sensors together but those that failed, or of the best of them for images, (k,)."""
        return self._together(self.counts[:, _unfailed(self.names, failed)]) if failed else self.all

    @cached_property
    def all(self) -> Counts:
        """Counts of all sensors together, or of the best of them for images, (k,)."""
        return self._together(self.counts)

    def _together(self, counts: Counts) -> Counts:
        return np.asarray(counts.max(axis=1, initial=0) if self.is_image else counts.sum(axis=1))


@dataclass(frozen=True)
class ObjectCounts:
    """Counts of the k objects that count, in the order of the sampled frames.

    box (k,): their places in the traffic; points (k, lidars) rays that reach them first, pixels (k, cameras) native
    pixels that show them, of the enabled sensors by name; points_alone and pixels_alone (k,): of all of them together
    without occlusion; cells (k,): distinct cells of 0.2 m that LiDARs hit; heights_px (k, cameras): rows of
    native pixels from the first to the last that shows it; shown (k, cameras): share of the silhouette, outside the
    picture too, that a picture shows; returns: of the kinds of sensor beside these two, by name.
    """

    box: Counts
    lidars: tuple[str, ...]
    cameras: tuple[str, ...]
    points: Counts
    pixels: Doubles
    points_alone: Counts
    pixels_alone: Doubles
    cells: Counts
    heights_px: Doubles
    shown: Doubles
    returns: Mapping[str, Returns] = field(default_factory=dict)

    def detected(self, min_points: int, failed: Collection[str] = ()) -> dict[str, NDArray[np.bool_]]:
        """Return by kind of sensor which objects are detected (k,) without some sensors: LiDARs by `min_points` points
        of all, cameras by half of it in one picture, others by the number of returns set by their kind."""
        points, visible = self.all_points, self.visible
        if failed:
            points = self.points[:, _unfailed(self.lidars, failed)].sum(axis=1)
            visible = self.shown[:, _unfailed(self.cameras, failed)].max(axis=1, initial=0.0)
        return {
            LIDAR.name: points >= min_points,
            CAMERA.name: visible >= HALF,
            **{kind: found.without(failed) >= _enough(kind) for kind, found in self.returns.items()},
        }

    def sensors_detecting(self, min_points: int) -> Counts:
        """Return the number of sensors that detect each object on their own, (k,)."""
        flags = [self.points >= min_points, self.shown >= HALF]
        flags += [found.counts >= _enough(kind) for kind, found in self.returns.items()]
        return np.asarray(np.concatenate(flags, axis=1).sum(axis=1))

    def part(self, which: slice) -> ObjectCounts:
        """Return the counts of some objects."""
        columns = {
            one.name: getattr(self, one.name)[which]
            for one in fields(self)
            if one.name not in ("lidars", "cameras", "returns")
        }
        returns = {kind: replace(found, counts=found.counts[which]) for kind, found in self.returns.items()}
        return replace(self, **columns, returns=returns)

    @cached_property
    def height_px(self) -> Doubles:
        """Height in the camera that shows it tallest, (k,)."""
        return np.asarray(self.heights_px.max(axis=1, initial=0.0))

    @cached_property
    def all_points(self) -> Counts:
        """Points of all LiDARs, (k,)."""
        return np.asarray(self.points.sum(axis=1))

    @cached_property
    def all_returns(self) -> Counts:
        """Returns of all sensors of further kinds, (k,)."""
        parts = [found.all for found in self.returns.values()]
        return np.asarray(np.sum([np.zeros(len(self.box), np.int64), *parts], axis=0))

    @cached_property
    def visible(self) -> Doubles:
        """Share of the silhouette, outside pictures too, that the camera shows that shows most of it, (k,)."""
        return np.asarray(self.shown.max(axis=1, initial=0.0))

    @cached_property
    def on_target(self) -> Doubles:
        """1 - exp(-cells / 5), (k,)."""
        return np.asarray(1.0 - np.exp(-self.cells / CELLS_SCALE))


def _enough(kind_name: str) -> float:
    kind = kind_named(kind_name)
    assert kind is not None
    return kind.hits.threshold


@dataclass(frozen=True, eq=False)
class Counted:
    """The objects of some frames of the sampling order with the hits of a rig's enabled sensors on them; losses: what
    hides them from cameras; None unless requested."""

    rig: Rig
    settings: TargetSettings
    groups: Groups
    objects: ObjectCounts
    elapsed_ms: float = 0.0
    losses: CameraLosses | None = None

    def first(self, groups: Groups) -> Counted:
        """Return the counts in the first frames of all of these, whose objects are given: those that an engine would
        count, without losses."""
        objects = self.objects.part(slice(len(groups.every)))
        return replace(self, groups=groups, objects=objects, losses=None)

    @property
    def traffic(self) -> Traffic:
        """The traffic that the objects are part of."""
        return self.groups.traffic

    @property
    def span(self) -> range:
        """The frames of the sampling order in which objects were counted."""
        return self.groups.span

    @property
    def frames(self) -> int:
        """Number of frames of the traffic."""
        return self.traffic.frames

    @property
    def frames_used(self) -> int:
        """Number of frames in which objects were counted."""
        return len(self.span)

    @property
    def is_whole(self) -> bool:
        """Return whether all frames were used."""
        return self.frames_used == self.frames

    @property
    def within_m(self) -> float:
        """Distance from the car within which objects count."""
        return self.traffic.within_m

    @property
    def calibration(self) -> Calibration:
        """The calibration of predicted detection."""
        return self.settings.calibration or shipped()

    def outside(self, calibration: Calibration) -> str:
        """Return why the rig, or the way of counting, is outside a calibration's domain; "" inside."""
        return calibration.outside(self.rig, self.settings.shape, self.settings.range_law)

    def by_lidars(self, calibration: Calibration) -> Doubles:
        """Return the chance that LiDARs alone find each object, (k,), by the curves of a calibration."""
        n = self.objects.cells if calibration.unit == "cells" else self.objects.all_points
        return calibration.by_lidars(self.groups.cls, n)

    def by_cameras(self, calibration: Calibration) -> Doubles:
        """Return the share of the objects that can be found at all that cameras find, of each object, (k,)."""
        if calibration.camera is None:
            return np.zeros(len(self.objects.box))
        return calibration.camera.at(self.objects.visible, self.traffic.distance_m[self.objects.box])
