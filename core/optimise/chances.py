"""Say by what chance objects are found, for the figures that LiDARs and other sensors make together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.figures.figure import Figure
from riglens.core.figures.hits import ENOUGH_POINTS, MISSED, SEEN_BY_CAMERAS, SHARE_1, SHARE_5
from riglens.core.figures.predicted import FOUND, PREDICTED
from riglens.core.rig.model import Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.registry import AnyKind, further_kinds, kind_of, kinds
from riglens.core.targets.calibration import MIN_RECALL, MOST, Calibration, Domain, shipped
from riglens.core.targets.settings import HALF, TargetSettings
from riglens.core.targets.traffic import Traffic

if TYPE_CHECKING:  # the compiler
    from riglens.core.targets.contribution import Contribution

Doubles = NDArray[np.float64]
Flags = NDArray[np.bool_]
OfOthers: TypeAlias = "Callable[[Sensor, Contribution, Doubles], Doubles]"
"""Chance that a sensor other than a LiDAR finds each object by itself, (k,), by its hits and their distance (k,)."""
_NO_LIDARS = np.zeros((len(CLASSES), 2))


@dataclass(frozen=True)
class Chances:
    """An object is found with the chance 1 - (1 - L)(1 - C): L by the points or cells of all LiDARs together, from a
    curve by class (classes, most + 1), C the largest of the chances of the other sensors by themselves.

    The figure is offset + sign * the mean of the chances times the scale of their class, (classes,), where it is
    known: NaN is not. domain: where objects count, None for everywhere.
    """

    curve: Doubles
    of_others: OfOthers
    unit: Literal["points", "cells"] = "points"
    scale: Doubles = field(default_factory=lambda: np.ones(len(CLASSES)))
    offset: float = 0.0
    sign: float = 1.0
    domain: Domain | None = None

    @classmethod
    def of(cls, figure: Figure, settings: TargetSettings) -> Chances:
        """Return the chances of a figure that has them."""
        return _makers(settings)[figure.key]()

    def counts(self, traffic: Traffic, box: NDArray[np.int64]) -> Flags:
        """Return which objects count, of those at some places of the traffic, (k,)."""
        known = ~np.isnan(self.scale)[traffic.cls[box]]
        return known if self.domain is None else known & self.domain.holds(traffic.centre_m[box])

    def shown(self, share: float) -> float:
        """Return the figure by the mean chance."""
        return self.offset + self.sign * share


def made_of_chances() -> frozenset[str]:
    """Return the keys of the figures that are made of chances."""
    return frozenset(_makers(TargetSettings()))


def _makers(settings: TargetSettings) -> dict[str, Callable[[], Chances]]:
    """Return what makes the chances of figures, by key; calibrations are read when they are asked for."""
    alone = [kind for kind in further_kinds(kind.name for kind in kinds()) if _detects_alone(kind)]
    missed = partial(Chances, _from(settings.min_points), _detected, offset=1.0, sign=-1.0)
    found: dict[str, Callable[[], Chances]] = {
        PREDICTED.key: lambda: _predicted(settings.calibration or shipped()),
        FOUND.key: lambda: _found(settings.recall),
        SEEN_BY_CAMERAS.key: lambda: Chances(_NO_LIDARS, _shown),
        SHARE_1.key: lambda: Chances(_from(1), _by_none),
        SHARE_5.key: lambda: Chances(_from(5), _by_none),
        ENOUGH_POINTS.key: lambda: Chances(_from(settings.min_points), _by_none),
        **{kind.name: lambda: Chances(_NO_LIDARS, _detected) for kind in alone},
    }
    if all(map(_detects_alone, further_kinds(kind.name for kind in kinds()))):
        found[MISSED.key] = missed
    return found


def _detects_alone(kind: AnyKind) -> bool:
    """Return whether hits of several sensors of a kind are worth no more than those of the best of them."""
    return kind.hits.measure == "pixels" or kind.hits.threshold <= 1


def _predicted(calibration: Calibration) -> Chances:
    return _calibrated(calibration, _by_cameras(calibration))


def _found(recall: Calibration | None) -> Chances:
    if recall is None:
        raise InputError("must be one of recall for the objective found (got one of AP)", "calibration")
    return _calibrated(recall, _by_none, recall.domain)


def _calibrated(calibration: Calibration, of_others: OfOthers, domain: Domain | None = None) -> Chances:
    numbers = np.arange(MOST + 1)
    each = [np.full(MOST + 1, number, np.uint8) for number in range(len(CLASSES))]
    by_lidars = np.array([calibration.by_lidars(cls, numbers) for cls in each])
    own = (calibration.classes.of(name) for name in CLASSES)
    most = np.array([np.nan if curve is None else curve.a for curve in own])
    is_ap = calibration.predicts == "AP"
    scale, offset = (most / (1.0 - MIN_RECALL), -MIN_RECALL / (1.0 - MIN_RECALL)) if is_ap else (most, 0.0)
    curve = np.nan_to_num(by_lidars / most[:, None])
    return Chances(curve, of_others, calibration.unit, scale, offset, domain=domain)


def _from(least: int) -> Doubles:
    """Return the chance by points of objects that are found from some number of them on."""
    return np.tile((np.arange(least + 1) >= least).astype(np.float64), (len(CLASSES), 1))


def _by_none(sensor: Sensor, one: Contribution, distance_m: Doubles) -> Doubles:
    return np.zeros(len(distance_m))


def _shown(sensor: Sensor, one: Contribution, distance_m: Doubles) -> Doubles:
    """Return the share of the silhouette that a camera shows, 0 of other sensors."""
    if kind_of(sensor) is not CAMERA:
        return np.zeros(len(distance_m))
    from riglens.core.kernels.objects.counts import ALONE, RAYS  # the compiler

    count = len(distance_m)
    return one.inside[:count] * one.found[RAYS, :count] / np.maximum(one.found[ALONE, :count], 1)


def _by_cameras(calibration: Calibration) -> OfOthers:
    def chance(sensor: Sensor, one: Contribution, distance_m: Doubles) -> Doubles:
        if calibration.camera is None:
            return np.zeros(len(distance_m))
        return calibration.camera.at(_shown(sensor, one, distance_m), distance_m)

    return chance


def _detected(sensor: Sensor, one: Contribution, distance_m: Doubles) -> Doubles:
    """Return 1 where a sensor other than a LiDAR detects an object by itself."""
    from riglens.core.kernels.objects.counts import FIRST_ROW, LAST_ROW, RAYS  # the compiler

    kind, count = kind_of(sensor), len(distance_m)
    if kind is CAMERA:
        return np.asarray(_shown(sensor, one, distance_m) >= HALF, np.float64)
    hits = one.found[RAYS, :count]
    if kind.hits.measure == "pixels":
        first, last = one.found[FIRST_ROW, :count], one.found[LAST_ROW, :count]
        hits = np.where(first >= 0, last - first + 1, 0)
    return np.asarray(hits >= kind.hits.threshold, np.float64)
