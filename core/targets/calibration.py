"""Predicted detection: curves of average precision by a rig's hits on objects, and their file.

A curve belongs to one detector, and says nothing outside the domain in which it was fitted.
"""

from __future__ import annotations

import math
import os
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from riglens.assets import asset_path
from riglens.core.plain import Frozen
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.checked import read_checked
from riglens.core.rig.yaml.nodes import value_text
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.shapes import Shape

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]
Unit = Literal["points", "cells"]
Predicts = Literal["AP", "recall"]
Metres = Annotated[float, Field(gt=0.0, le=1000.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Text = Annotated[str, Field(min_length=3, max_length=1000)]

ACCEPTED = "a calibration of predicted detection, which starts with riglens_calibration: 1"
WITHIN_M, MIN_SCORE, MATCH_M = 50.0, 0.3, 2.0
"""Of a calibration of one's own: objects count up to this distance, detections from this score on; they find objects
whose centres are nearer than 2 m on the ground, where nuScenes measures errors of true positives. Our choice."""
MOST = 4096
"""Objects with more points or cells count as having this many."""


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
    this range of LiDAR rays, a number of sweeps, these data."""

    within_m: Metres | None = None
    length_m: Metres | None = None
    width_m: Metres | None = None
    rays: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = None
    sweeps: Annotated[int, Field(ge=1, le=100)] = 1
    data: Text

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
            filter(None, (near, f"in {self.length_m:g} m x {self.width_m:g} m around the car"))
        )


class Calibration(Frozen):
    """The curves of a detector, with its domain; mean_error: as `Curve.error`, of the mean over classes."""

    riglens_calibration: Literal[1] = 1
    name: Text
    predicts: Predicts
    unit: Unit
    detector: Text
    source: Text
    domain: Domain
    classes: Curves
    mean_error: Share

    @property
    def title(self) -> str:
        """The figure in two words."""
        return f"predicted {self.predicts}"

    def of_objects(self, cls: NDArray[np.uint8], inside: NDArray[np.bool_], n: Counts) -> Doubles:
        """Return g of objects (k,) of classes (k,) with n points or cells (k,): NaN outside the region, or for a class
        without a curve."""
        found = np.full(len(n), np.nan)
        near = np.flatnonzero(inside)  # about half of the objects: the others cost nothing
        found[near] = _table(self.classes)[cls[near], np.minimum(n[near], MOST)]
        return found

    def within(self, within_m: float) -> Calibration:
        """Return the same curves for the objects within a distance of the car instead of those of its domain."""
        disc = self.domain.model_copy(update={"within_m": within_m, "length_m": None, "width_m": None})
        return self.model_copy(update={"domain": disc})

    @property
    def errors(self) -> Doubles:
        """Errors on rigs or sequences left out: of the mean over classes, then by class; NaN without a curve."""
        curves = [self.classes.of(name) for name in CLASSES]
        return np.array([self.mean_error, *(math.nan if one is None else one.error for one in curves)])

    def outside(self, rig: Rig, shape: Shape, range_law: bool) -> str:
        """Return why a rig, or the way in which it is counted, is outside the domain; nothing where it is inside."""
        rays, shown = sum(lidar.ray_count for lidar in rig.enabled_lidars()), self.domain.rays
        if not rays:
            return "the rig has no enabled LiDAR, and no camera is calibrated"
        if shown is not None and not shown[0] <= rays <= shown[1]:
            return f"shown for {shown[0]:,} to {shown[1]:,} LiDAR rays, and the rig has {rays:,}"
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
