"""Predicted detection: the chance that a detector finds an object, by a rig's hits and pixels, and its file.

A curve belongs to one detector, and says nothing outside the domain in which it was fitted.
"""

from __future__ import annotations

import math
import os
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from riglens.assets import asset_path
from riglens.core.plain import Frozen
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.checked import read_checked
from riglens.core.rig.yaml.nodes import value_text
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.targets.shapes import Shape

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]
Unit = Literal["points", "cells"]
Predicts = Literal["AP", "recall"]
Metres = Annotated[float, Field(gt=0.0, le=1000.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Text = Annotated[str, Field(min_length=3, max_length=1000)]

VERSION: Literal[2] = 2
ACCEPTED = f"a calibration of predicted detection, which starts with riglens_calibration: {VERSION}"
WITHIN_M, MIN_SCORE, MATCH_M = 50.0, 0.3, 2.0
"""Of a calibration of one's own: objects count up to this distance, detections from this score on; they find objects
whose centres are nearer than 2 m on the ground, where nuScenes measures errors of true positives. Our choice."""
MOST = 4096
"""Objects with more points or cells count as having this many."""
MIN_RECALL = 0.1
"""Average precision leaves out recall up to here (nuScenes devkit 1.2.0, detection_cvpr_2019), so a detector that finds
a share g of the objects has (g - 0.1) / 0.9 of it, at best."""


class Curve(Frozen):
    """g(n) = a (1 - exp(-(n / b)^c)) of n points or cells on an object.

    error: root mean square error of the mean of g over objects, of rigs or sequences left out of the fit; objects:
    number of objects in the fit.
    """

    a: Annotated[float, Field(gt=0.0, le=1.0)]
    b: Annotated[float, Field(gt=0.0, le=10_000.0)]
    c: Annotated[float, Field(gt=0.0, le=20.0)]
    error: Share
    objects: Annotated[int, Field(ge=1)]

    def at(self, n: Doubles) -> Doubles:
        """Return g of numbers of points or cells (...)."""
        return np.asarray(-self.a * np.expm1(-((n / self.b) ** self.c)))


class CameraCurve(Frozen):
    """Chance s v / (1 + (d / d0)^2), at most 1, that cameras find an object at distance d of which they show the share
    v."""

    s: Annotated[float, Field(gt=0.0, le=1000.0)]
    d0_m: Metres

    def at(self, visible: Doubles, distance_m: Doubles) -> Doubles:
        """Return the chance of objects (k,), of which cameras show a share, at a distance along the ground."""
        return np.minimum(1.0, self.s * visible / (1.0 + (distance_m / self.d0_m) ** 2))


class Curves(Frozen):
    """The curve of each class; none for a class that was not calibrated."""

    car: Curve | None = None
    bicycle: Curve | None = None
    pedestrian: Curve | None = None

    @model_validator(mode="after")
    def _some(self) -> Curves:
        if self.car is None and self.bicycle is None and self.pedestrian is None:
            raise ValueError(f"must hold a curve of {', '.join(CLASSES[:-1])} or {CLASSES[-1]}")
        return self

    def of(self, class_name: str) -> Curve | None:
        """Return the curve of a class."""
        found: Curve | None = getattr(self, class_name)
        return found


class Domain(Frozen):
    """Domain in which a calibration holds: objects within a distance and a rectangle around the car, rigs with
    this range of LiDAR rays, a number of sweeps, these data. In words: beyond, what is known of rigs with other numbers
    of rays; cameras_alone, why rigs without LiDARs are outside, if they are."""

    within_m: Metres | None = None
    length_m: Metres | None = None
    width_m: Metres | None = None
    rays: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = None
    sweeps: Annotated[int, Field(ge=1, le=100)] = 1
    data: Text
    beyond: Text | None = None
    cameras_alone: Text | None = None

    @model_validator(mode="after")
    def _bounded(self) -> Domain:
        if (self.length_m is None) != (self.width_m is None):
            raise ValueError("length_m and width_m belong together")
        if self.length_m is None and self.within_m is None:
            raise ValueError("must hold within_m, or length_m and width_m")
        if self.rays is not None and self.rays[0] > self.rays[1]:
            raise ValueError(f"rays must be [from, to] with from ≤ to (got {list(self.rays)})")
        return self

    def holds(self, centre_m: Doubles) -> NDArray[np.bool_]:
        """Return which objects with centres (k, 3) lie in the region, lower ends of the rectangle included."""
        inside = np.ones(len(centre_m), np.bool_)
        if self.within_m is not None:
            inside &= np.hypot(centre_m[:, 0], centre_m[:, 1]) <= self.within_m
        if self.length_m is not None and self.width_m is not None:
            half = np.array([self.length_m, self.width_m]) / 2.0
            inside &= ((centre_m[:, :2] >= -half) & (centre_m[:, :2] < half)).all(axis=1)
        return inside

    @property
    def region(self) -> str:
        """The region in words."""
        near = "" if self.within_m is None else f"within {self.within_m:g} m"
        if self.length_m is None:
            return near
        return " and ".join(
            filter(None, (near, f"in {self.length_m:g} m × {self.width_m:g} m around the car"))
        )


class Calibration(Frozen):
    """The curves of a detector, with its domain; camera: what cameras add, None where they were not calibrated;
    mean_error: as `Curve.error`, of the mean over classes."""

    riglens_calibration: Literal[2] = VERSION
    name: Text
    predicts: Predicts
    unit: Unit
    detector: Text
    source: Text
    domain: Domain
    camera: CameraCurve | None = None
    classes: Curves
    mean_error: Share

    @field_validator("riglens_calibration", mode="before")
    @classmethod
    def _current(cls, version: object) -> object:
        if version == 1:
            raise ValueError(f"must be {VERSION} (got 1): run `riglens calibrate` again")
        return version

    @property
    def title(self) -> str:
        """The figure in two words."""
        return f"predicted {self.predicts}"

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of sensors that it reads."""
        return (LIDAR.name,) if self.camera is None else (LIDAR.name, CAMERA.name)

    def by_lidars(self, cls: NDArray[np.uint8], n: Counts) -> Doubles:
        """Return the chance that objects (k,) of classes (k,) with n points or cells (k,) are found by LiDARs alone;
        NaN for a class without a curve."""
        return np.asarray(_table(self.classes)[cls, np.minimum(n, MOST)])

    def by_all(self, cls: NDArray[np.uint8], by_lidars: Doubles, by_cameras: Doubles) -> Doubles:
        """Return the chance that objects (k,) of classes (k,) are found: a (1 - (1 - q_L) (1 - q_C)), with by_lidars =
        a q_L and by_cameras = q_C; the two fail independently among what can be found at all."""
        most = np.array([math.nan if one is None else one.a for one in self._curves])[cls]
        return by_lidars + (most - by_lidars) * by_cameras

    def predicted(self, chance: Doubles) -> Doubles:
        """Return what a mean of chances says: recall as it is, or average precision, below 0 where there is none."""
        return chance if self.predicts == "recall" else (chance - MIN_RECALL) / (1.0 - MIN_RECALL)

    @property
    def _curves(self) -> list[Curve | None]:
        return [self.classes.of(name) for name in CLASSES]

    @property
    def errors(self) -> Doubles:
        """Errors on rigs or sequences left out: of the mean over classes, then by class; NaN without a curve."""
        own = (math.nan if one is None else one.error for one in self._curves)
        return np.array([self.mean_error, *own])

    def outside(self, rig: Rig, shape: Shape, range_law: bool) -> str:
        """Return why a rig, or the way in which it is counted, is outside the domain; nothing where it is inside."""
        rays, shown = sum(lidar.ray_count for lidar in rig.enabled_lidars()), self.domain.rays
        if rays and shown is not None and not shown[0] <= rays <= shown[1]:
            known = f": {self.domain.beyond}" if self.domain.beyond else ""
            return f"shown for {shown[0]:,} to {shown[1]:,} LiDAR rays, and the rig has {rays:,}{known}"
        if not rays and self.domain.cameras_alone:
            return f"shown for rigs with LiDARs, and the rig has none: {self.domain.cameras_alone}"
        if shape != "class" or not range_law:
            return "shown for class shapes with the range law"
        return ""

    def text(self) -> str:
        """Return the calibration as YAML, which reads back to the same bits."""
        plain = self.model_dump(exclude_none=True)
        curves = "".join(f"  {name}: {value_text(curve)}\n" for name, curve in plain["classes"].items())
        lines = [f"{name}: {value_text(value)}\n" for name, value in plain.items() if name != "classes"]
        return f"{''.join(lines)}classes:\n{curves}"


@lru_cache(maxsize=8)
def _table(curves: Curves) -> Doubles:
    """Return g of 0 to MOST by class, (classes, MOST + 1)."""
    numbers = np.arange(MOST + 1, dtype=np.float64)
    rows = [curves.of(name) for name in CLASSES]
    return np.array([np.full(MOST + 1, np.nan) if one is None else one.at(numbers) for one in rows])


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """Read a file that `riglens calibrate` wrote; InputError with file, line and field when something is wrong."""
    return read_checked(path, Calibration, ACCEPTED)


@lru_cache(maxsize=1)
def shipped() -> Calibration:
    """Return the bundled calibration of AP, of the detector of docs/study-detection.md."""
    return read_calibration(asset_path("calibrations", "study.yaml"))


@lru_cache(maxsize=1)
def shipped_recall() -> Calibration:
    """Return the bundled calibration of recall, of the detector of docs/study-detection-2.md, one sweep."""
    return read_calibration(asset_path("calibrations", "recall.yaml"))
