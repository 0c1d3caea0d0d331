"""Quantities of objects: the meaning of each, and the layout of their tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import further_kinds
from riglens.core.targets.settings import HEIGHT_PX, TargetSettings

if TYPE_CHECKING:  # loads the compiler, which a window that opens does not need
    from riglens.core.targets.scores import ObjectCounts, TargetScores

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]
Unit = Literal["share", "points", "px"]
EVERYBODY = "all"
CLASSES_AND_ALL = (EVERYBODY, *CLASSES)
"""Rows of a table: objects of all classes, then class by class."""
SE_FACTOR = 2.0
"""Standard errors behind ± everywhere: 95 % of samples are nearer to the exact value."""
RESOLVED = 0.01
"""Smaller changes of on target had the sign of the change of mAP in 19 of 29 pairs (docs/study-detection.md), smaller
ones of predicted AP in 6 of 10 that it was not fitted to (docs/study-detection-2.md): neither better nor worse."""


@dataclass(frozen=True)
class Quantity:
    """One number per object. Several objects are averaged, or their median is taken where `is_median`.

    `sign` says whether more is better (1) or worse (-1).
    """

    key: str
    title: str
    tip: str
    unit: Unit
    of: Callable[[ObjectCounts, TargetSettings], Doubles]
    is_median: bool = False
    sign: int = 1


def _by(kind: str) -> Callable[[ObjectCounts, TargetSettings], Doubles]:
    """Return a function that is 1 where sensors of a kind detect an object."""

    def detected(objects: ObjectCounts, settings: TargetSettings) -> Doubles:
        found = objects.detected(settings.min_points).get(kind)
        return np.zeros(len(objects.box)) if found is None else found.astype(np.float64)

    return detected


def _kinds(objects: ObjectCounts, settings: TargetSettings) -> Counts:
    """Return the number of kinds of sensor that detect each object."""
    return np.asarray(np.sum(list(objects.detected(settings.min_points).values()), axis=0))


ON_TARGET = Quantity(
    "on_target", "On target",
    "Mean of 1 - exp(-cells / 5), with the cells of 0.2 m on an object that LiDARs hit. More is better.",
    "share", lambda objects, _: objects.on_target,
)  # fmt: skip
PREDICTED = Quantity(
    "predicted", "Predicted AP",
    "Average precision that a detector would reach on these objects with these LiDAR hits, by a calibration. "
    "More is better.",
    "share", lambda objects, _: objects.predicted,
)  # fmt: skip
"""NaN for objects of which the calibration says nothing; they do not count."""
FOUND = Quantity(
    "found", "Found",
    "Share of these objects that a detector would find with these LiDAR points, by a calibration. More is better.",
    "share", lambda objects, _: objects.found,
)  # fmt: skip
"""NaN as for PREDICTED."""
QUANTITIES = (
    ON_TARGET,
    PREDICTED,
    FOUND,
    Quantity(
        LIDAR.name, "By LiDARs", "Share of objects with at least that many points of LiDARs. More is better.",
        "share", _by(LIDAR.name),
    ),
    Quantity(
        "points", "Median points", "Median number of LiDAR points on an object. More is better.",
        "points", lambda objects, _: objects.all_points.astype(np.float64), is_median=True,
    ),
    Quantity(
        "visible", "Visible to cameras",
        "Mean of the pixels that show an object over those that would without occlusion. More is better.",
        "share", lambda objects, _: objects.visible,
    ),
    Quantity(
        CAMERA.name, "By cameras",
        f"Share of objects that are at least {HEIGHT_PX} px tall in a camera's picture. More is better.",
        "share", _by(CAMERA.name),
    ),
    Quantity(
        "height", "Median height",
        "Median height of objects, each in the picture that shows it tallest. More is better.",
        "px", lambda objects, _: objects.height_px, is_median=True,
    ),
    Quantity(
        "both", "By two kinds", "Share of objects that sensors of two kinds detect. More is better.",
        "share",
        lambda objects, settings: (_kinds(objects, settings) >= 2).astype(np.float64),
    ),
    Quantity(
        "neither", "Missed", "Share of objects that no sensor detects. Less is better.",
        "share",
        lambda objects, settings: (_kinds(objects, settings) == 0).astype(np.float64),
        sign=-1,
    ),
)  # fmt: skip
"""Of every rig; `quantities_of` adds those of the kinds that a rig holds besides LiDARs and cameras."""


def quantities_of(present: Iterable[str]) -> tuple[Quantity, ...]:
    """Return the quantities of rigs with sensors of some kinds, by name."""
    further = (
        Quantity(
            kind.name, f"By {kind.plural}",
            f"Share of objects with at least {kind.hits.threshold:g} {kind.hits.label} of {kind.plural}. "
            "More is better.",
            "share", _by(kind.name),
        )
        for kind in further_kinds(present)
    )  # fmt: skip
    return (*QUANTITIES, *further)


@dataclass(frozen=True)
class ClassFigures:
    """Figures of a rig for all objects of a class: their number, their mean hit coverage, and the share of them with at
    least `min_points` points of LiDARs; NaN where there are none."""

    objects: int
    on_target: float
    detected: float


Figures = Mapping[str, ClassFigures]
"""By class."""


def figures_of(scores: TargetScores) -> dict[str, ClassFigures]:
    """Return the figures of all classes."""
    found = {}
    for name, table in scores.classes.items():
        row = table.total
        some = row.objects > 0
        on_target, detected = (row.on_target.value, row.share_n.value) if some else (math.nan, math.nan)
        found[name] = ClassFigures(row.objects, on_target, detected)
    return found


@dataclass(frozen=True)
class Cells:
    """Numbers of groups of objects in an array of any shape: their count, the number itself (NaN where there are none),
    its standard error where frames were sampled, the change against a baseline and its error.

    Both rigs meet the same objects, so the error of the change is that of the differences, object by object.
    """

    objects: Counts
    value: Doubles
    se: Doubles
    change: Doubles
    change_se: Doubles

    def anchored(self, exact: Cells) -> Cells:
        """Return exact values of the same baseline plus the changes of this sample, whose errors are those of pairs."""
        return replace(self, value=exact.value - exact.change + self.change, se=self.change_se)


@dataclass(frozen=True)
class PredictedCells:
    """Predicted detection in cells (len(CLASSES_AND_ALL),) with the errors of sampled frames alone.

    errors (len(CLASSES_AND_ALL),): of the calibration; region: that of its objects in words; about: the figure and its
    detector in words; outside: why a rig is outside the domain, empty where it is inside; found: the same of recall,
    if any calibration says so.
    """

    cells: Cells
    errors: Doubles
    region: str
    about: str
    outside: str
    found: PredictedCells | None = None

    def anchored(self, exact: PredictedCells) -> PredictedCells:
        """Return the cells anchored, as `Cells.anchored` does."""
        found = self.found and exact.found and self.found.anchored(exact.found)
        return replace(self, cells=self.cells.anchored(exact.cells), found=found)

    @property
    def se(self) -> Doubles:
        """Standard errors of calibration and sample together."""
        return np.hypot(self.cells.se, self.errors)


def of_100(found: Mapping[str, tuple[float, float]], region: str) -> str:
    """Say how many of 100 objects of each class in a region are found, ±, both as shares; empty without a class."""
    said = ", ".join(
        f"{name} {100.0 * value:.0f} ± {max(100.0 * error, 1.0):.0f}"
        for name, (value, error) in found.items()
    )
    return said and f"Found of 100 objects {region}: {said}"


@dataclass(frozen=True)
class Table:
    """`cells` (len(CLASSES_AND_ALL), 1 + rings): the first column holds all distances, the others the rings between
    edges_m."""

    quantity: Quantity
    edges_m: tuple[float, ...]
    cells: Cells


@dataclass(frozen=True)
class Rose:
    """`cells` (rings, SECTORS) of one of `CLASSES_AND_ALL`."""

    quantity: Quantity
    who: str
    edges_m: tuple[float, ...]
    cells: Cells
