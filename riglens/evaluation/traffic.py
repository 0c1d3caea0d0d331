"""Load the objects on which points and pixels are counted, from options."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.scene.boxes import Progress
from riglens.core.scene.occluders import FrameName, MapPose, Occluders
from riglens.core.scene.readers import bundled_occluders
from riglens.core.targets.traffic import Traffic, read_traffic
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import source_of


def load_traffic(options: SceneOptions, within_m: float, progress: Progress | None = None) -> Traffic:
    """Return all boxes of the requested data set; InputError on bad input."""
    source = source_of(options)
    return read_traffic(source, within_m, progress, occluders=occluders_of(options, source.origin_m))


def car_poses(options: SceneOptions) -> Mapping[FrameName, MapPose]:
    """Return the pose of the vehicle frame in each frame, from the tables of occluders; empty without such tables."""
    if options.boxes is not None and options.occluders is None:
        return {}
    found = occluders_of(replace(options, surroundings=True), source_of(options).origin_m)
    assert found is not None
    return {name: _of_vehicle(pose, found.origin_m) for name, pose in found.poses.items()}


def _of_vehicle(pose: MapPose, origin_m: Vec3) -> MapPose:
    """Return the pose of the vehicle frame from that of the boxes' frame, whose origin is at `origin_m` in the vehicle
    frame."""
    x, y, z = origin_m
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    place = np.array(pose.position_m) - [cos * x - sin * y, sin * x + cos * y, z]
    return replace(pose, position_m=(float(place[0]), float(place[1]), float(place[2])))


def occluders_of(options: SceneOptions, origin_m: Vec3 | None) -> Occluders | None:
    """Return the occluders, if requested; InputError where they are unknown."""
    if options.occluders is not None:
        if options.boxes is None:
            raise InputError("belong to a box data set; specify it with", "occluders", "boxes")
        if not options.surroundings:
            raise InputError("hide nothing when ignored: leave out", "occluders", "surroundings")
        from riglens.core.scene.readers.occluders import open_occluders  # loads pyarrow

        return open_occluders(*options.occluders, origin_m or (0.0, 0.0, 0.0))
    if not options.surroundings:
        return None
    if options.boxes is not None:
        raise InputError(
            "cannot block: occluders are unknown; specify them with", "surroundings", "occluders"
        )
    return bundled_occluders()
