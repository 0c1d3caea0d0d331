"""Define the figures of a calibration: the average precision, and the recall, that a detector would reach."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from riglens.core.figures.hits import CAMERAS, LIDARS, RESOLVED, Doubles
from riglens.core.figures.objects import ObjectFigure, parts_by_class
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.targets.counts import Counted


def _by_lidars(counted: Counted) -> Doubles:
    calibration = counted.calibration
    return calibration.predicted(counted.by_lidars(calibration))


def _by_cameras(counted: Counted) -> Doubles:
    calibration, cls = counted.calibration, counted.groups.cls
    nothing = calibration.by_lidars(cls, np.zeros(len(cls), np.int64))
    return calibration.predicted(calibration.by_all(cls, nothing, counted.by_cameras(calibration)))


def _by_all(counted: Counted) -> Doubles:
    calibration = counted.calibration
    by_lidars, by_cameras = counted.by_lidars(calibration), counted.by_cameras(calibration)
    return calibration.predicted(calibration.by_all(counted.groups.cls, by_lidars, by_cameras))


def _found(counted: Counted) -> Doubles:
    """Return the chance that LiDARs alone find each object, NaN outside the region of the calibration."""
    recall = counted.settings.recall
    if recall is None:
        return np.full(len(counted.objects.box), np.nan)
    return np.where(counted.groups.inside(recall.domain), counted.by_lidars(recall), np.nan)


_PREDICTED = ObjectFigure(
    key="predicted",
    title="Predicted AP",
    short="Pred. AP",
    question="Average precision that a detector of LiDAR points and pictures would reach on these objects, by a "
    "calibration: compare rigs by it, do not quote it.",
    resolved=RESOLVED,
    leads=True,
    kinds=(*LIDARS, *CAMERAS),
    values=_by_all,
    calibration=lambda counted: counted.calibration,
    of_classes=True,
    least=0.0,
)
PREDICTED = replace(
    _PREDICTED,
    parts={
        LIDAR.name: replace(_PREDICTED, values=_by_lidars),
        CAMERA.name: replace(_PREDICTED, values=_by_cameras),
    },
)
FOUND = ObjectFigure(
    key="found",
    title="Found",
    question="Share of these objects that a detector would find with these LiDAR points, by a calibration.",
    resolved=RESOLVED,
    kinds=LIDARS,
    values=_found,
    calibration=lambda counted: counted.settings.recall,
    in_domain=True,
)


def found_text(counted: Counted, factor: float) -> str:
    """Say how many of 100 objects of each class are found, ± that many standard errors; empty where no calibration
    says so."""
    if counted.settings.recall is None:
        return ""
    classes = parts_by_class(counted, [FOUND])
    known = {name: one.total["found"] for name, one in classes.items() if one.total["found"].exists}
    shares = {name: (one.value, factor * one.se) for name, one in known.items()}
    return of_100(shares, counted.settings.recall.domain.region)


def of_100(found: Mapping[str, tuple[float, float]], region: str) -> str:
    """Say how many of 100 objects of each class in a region are found, ±, both as shares; empty without a class."""
    text = ", ".join(
        f"{name} {100.0 * value:.0f} ±{max(100.0 * error, 1.0):.0f}" for name, (value, error) in found.items()
    )
    return text and f"Objects found per 100 {region}: {text}"
