"""From options to a calibration of predicted detection: boxes and detections of one's own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.core.scene.readers import parse_class_map
from riglens.core.study.calibrating import (
    Rules,
    frames_of,
    points_of,
    read_detections,
    recall,
    with_cameras,
)
from riglens.core.targets.calibration import Calibration
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import EVERYWHERE_M, Traffic
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import source_of


def calibrated(
    detections: Path,
    scene: SceneOptions,
    traffic: Traffic,
    rules: Rules,
    name: str | None = None,
    rig: Rig | None = None,
    cameras: Path | None = None,
) -> Calibration:
    """Return recall by points and class of a detector in the scene's boxes, by true points or those of a rig; traffic:
    these boxes; cameras: results of a detector of the rig's pictures alone.

    Raise InputError on bad input.
    """
    if scene.boxes is None:
        raise InputError("is needed: the box data set of the detections", "boxes")
    if cameras is not None and rig is None:
        raise InputError("is needed: the rig whose cameras gave the results", "rig")
    overrides = parse_class_map(scene.classes)
    frames = frames_of(scene.boxes, traffic, source_of(scene).origin_m or (0.0, 0.0, 0.0))
    found = read_detections(detections, frames, overrides)
    if rig is None:
        points = points_of(scene.boxes, overrides)
    else:
        counted = (
            TargetEngine(traffic.within(EVERYWHERE_M)).evaluate(rig, replace(USUAL, body=rig.body)).objects
        )
        points = counted.all_points[traffic.row[counted.box].argsort()]
    if len(points) != len(traffic.row):
        raise InputError(
            f"{scene.boxes}: must have a number of points for each of {len(traffic.row)} boxes (got {len(points)})"
        )
    calibration = recall(traffic, points, found, rules, name or detections.stem, detections.name)
    if rig is None or cameras is None:
        return calibration
    pictures = read_detections(cameras, frames, overrides)
    visible = TargetEngine(traffic).evaluate(rig, replace(USUAL, body=rig.body)).objects.visible
    return with_cameras(calibration, traffic, visible, pictures, rules, cameras.name)
