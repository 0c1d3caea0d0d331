"""Define the figures of hits on objects: LiDAR points and cells, pixels, and what several kinds detect."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from riglens.core.figures.objects import ObjectFigure
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import AnyKind
from riglens.core.targets.settings import HEIGHT_PX

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.targets.counts import Counted

Doubles = NDArray[np.float64]
RESOLVED = 0.01
"""Smaller changes of on target had the sign of the change of mAP in 19 of 29 pairs (docs/study-detection.md), smaller
ones of predicted AP in 6 of 10 that it was not fitted to (docs/study-detection-2.md): neither better nor worse. The
same for the other leading shares is our choice."""
LIDARS, CAMERAS = (LIDAR.name,), (CAMERA.name,)


def _detected(counted: Counted, kind: str) -> Doubles:
    """Return 1 where sensors of a kind detect an object, (k,)."""
    found = counted.objects.detected(counted.settings.min_points).get(kind)
    return np.zeros(len(counted.objects.box)) if found is None else found.astype(np.float64)


def _kinds(counted: Counted) -> NDArray[np.int64]:
    """Return the number of kinds of sensor that detect each object, (k,)."""
    return np.asarray(np.sum(list(counted.objects.detected(counted.settings.min_points).values()), axis=0))


def _points(least: int, leads: bool = False) -> ObjectFigure:
    return ObjectFigure(
        key=f"share_{least}",
        title=f"At least {least} point{'s' * (least > 1)}",
        short=f"≥ {least} pt{'s' * (least > 1)}",
        question=f"Share of objects with at least {least} LiDAR point{'s' * (least > 1)}.",
        resolved=RESOLVED if leads else 0.0,
        leads=leads,
        of_classes=leads,
        kinds=LIDARS,
        values=lambda counted: (counted.objects.all_points >= least).astype(np.float64),
        place=f"lidar.share_{least}",
    )


ON_TARGET = ObjectFigure(
    key="on_target",
    title="On target",
    question="Mean of 1 - exp(-cells / 5), with the cells of 0.2 m on an object that LiDARs hit.",
    resolved=RESOLVED,
    is_spread=True,
    kinds=LIDARS,
    values=lambda counted: counted.objects.on_target,
    place="lidar.on_target",
)
SHARE_1, SHARE_5 = _points(1), _points(5, leads=True)
ENOUGH_POINTS = ObjectFigure(
    key="share_min_points",
    title="Enough points",
    question="Share of objects with at least the number of LiDAR points that counts as a detection.",
    kinds=LIDARS,
    values=lambda counted: _detected(counted, LIDAR.name),
    place="lidar.share_min_points",
)
POINTS = ObjectFigure(
    key="median_points",
    title="Median points",
    unit="points",
    question="Median number of LiDAR points on an object.",
    kinds=LIDARS,
    values=lambda counted: counted.objects.all_points.astype(np.float64),
    is_median=True,
    place="lidar.median_points",
)
SEEN_BY_CAMERAS = ObjectFigure(
    key="seen_by_cameras",
    title="Seen by cameras",
    short="Seen, cam.",
    question="Mean share of an object's silhouette that the picture which shows most of it shows; 0 outside every "
    "picture.",
    resolved=RESOLVED,
    leads=True,
    of_classes=True,
    kinds=CAMERAS,
    values=lambda counted: counted.objects.visible,
    place="camera.visible",
)
TALL = ObjectFigure(
    key="share_25px",
    title=f"At least {HEIGHT_PX} px tall",
    short=f"≥ {HEIGHT_PX} px",
    question=f"Share of objects that are at least {HEIGHT_PX} px tall in a camera's picture.",
    kinds=CAMERAS,
    values=lambda counted: (counted.objects.height_px >= HEIGHT_PX).astype(np.float64),
    place="camera.share_25px",
)
HEIGHT = ObjectFigure(
    key="median_height_px",
    title="Median height",
    unit="px",
    question="Median height of objects, each in the picture that shows it tallest.",
    kinds=CAMERAS,
    values=lambda counted: counted.objects.height_px,
    is_median=True,
    place="camera.median_height_px",
)
BOTH = ObjectFigure(
    key="both",
    title="By two kinds",
    short="Both",
    question="Share of objects that sensors of two kinds detect.",
    least_kinds=2,
    values=lambda counted: (_kinds(counted) >= 2).astype(np.float64),
)
MISSED = ObjectFigure(
    key="missed",
    title="Missed",
    question="Share of objects that no sensor detects: too few LiDAR points, less than half of it in any picture, no "
    "return of a sensor of another kind.",
    better="less",
    resolved=RESOLVED,
    leads=True,
    of_classes=True,
    values=lambda counted: (_kinds(counted) == 0).astype(np.float64),
    place="neither",
)


@cache
def by_kind(kind: AnyKind) -> ObjectFigure:
    """Return the share of objects that sensors of a further kind detect."""
    return ObjectFigure(
        key=kind.name,
        title=f"By {kind.plural}",
        short=kind.plural,
        question=f"Share of objects with at least {kind.hits.threshold:g} {kind.hits.label} of {kind.plural}.",
        kinds=(kind.name,),
        values=lambda counted: _detected(counted, kind.name),
        place=f"{kind.name}.share",
    )
