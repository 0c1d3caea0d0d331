"""Model static occluders around the car: walls, houses, poles; no objects of the traffic.

Occluders are placed in a map; a pose per frame gives the vehicle frame in it. Scores and POGs do not know them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.scene.boxes import rotations_from_yaw

Doubles = NDArray[np.float64]
FrameName = tuple[str, int]
"""Sequence and number of a frame in it, as the box data call it."""


@dataclass(frozen=True)
class StandingBoxes:
    """Upright boxes in one frame: row (n,) their place in the table; centre_m, size_m (n, 3) length, width, height;
    rotation (n, 3, 3) box to that frame."""

    row: NDArray[np.int64]
    centre_m: Doubles
    size_m: Doubles
    rotation: NDArray[np.float64]


@dataclass(frozen=True)
class Map:
    """The occluders of one map, sorted by x: row (n,) place in the table; centre_m, size_m (n, 3); yaw_rad (n,)."""

    row: NDArray[np.int64]
    centre_m: Doubles
    size_m: Doubles
    yaw_rad: Doubles

    @classmethod
    def of(cls, row: NDArray[np.int64], centre_m: Doubles, size_m: Doubles, yaw_rad: Doubles) -> Map:
        """Sort boxes by x; those with the same x keep their order."""
        order = np.argsort(centre_m[:, 0], kind="stable")
        return cls(row[order], centre_m[order], size_m[order], yaw_rad[order])

    @cached_property
    def radius_m(self) -> Doubles:
        """Half the diagonal of each footprint, (n,)."""
        return np.hypot(self.size_m[:, 0], self.size_m[:, 1]) / 2

    @cached_property
    def largest_radius_m(self) -> float:
        """Half the longest diagonal."""
        return float(self.radius_m.max(initial=0.0))

    def around(self, pose: MapPose, reach_m: float) -> StandingBoxes:
        """Return the occluders that may be partly within reach of a pose along the ground, in its frame and in table
        order."""
        x = self.centre_m[:, 0]
        wide_m = reach_m + self.largest_radius_m
        first, end = np.searchsorted(x, [pose.position_m[0] - wide_m, pose.position_m[0] + wide_m])
        offset_m = self.centre_m[first:end] - np.asarray(pose.position_m)
        apart_m = np.hypot(offset_m[:, 0], offset_m[:, 1]) - self.radius_m[first:end]
        near = np.flatnonzero(apart_m <= reach_m)
        near = near[np.argsort(self.row[first + near])]
        turn = rotations_from_yaw(np.array([pose.yaw_rad]))[0]
        return StandingBoxes(
            self.row[first + near],
            offset_m[near] @ turn,  # R^T of each offset
            self.size_m[first + near],
            rotations_from_yaw(self.yaw_rad[first + near] - pose.yaw_rad),
        )


@dataclass(frozen=True)
class MapPose:
    """Pose of the boxes' frame: name of the map, position in it in metres, yaw in radians, positive to the left."""

    map: str
    position_m: tuple[float, float, float]
    yaw_rad: float


@dataclass(frozen=True)
class Occluders:
    """Static occluders, map by map, and the pose of the vehicle frame in each frame.

    source: what the tables are called in messages; cls: the name of each occluder in the order of the table; sha256:
    of the tables. A pose is that of the frame in which the boxes are given; origin_m: where its origin is in the
    vehicle frame, metres, as for the boxes.
    """

    source: str
    cls: Sequence[str]
    maps: Mapping[str, Map]
    poses: Mapping[FrameName, MapPose]
    origin_m: Vec3 = (0.0, 0.0, 0.0)
    sha256: str = ""

    def around(self, frame: FrameName, reach_m: float) -> StandingBoxes:
        """Return the occluders of a frame within reach of its pose, in the vehicle frame; InputError where there is no
        pose."""
        pose = self.poses.get(frame)
        if pose is None:
            seq, number = frame
            raise InputError(f"{self.source}: frame {number} of sequence {seq!r} has boxes, but no pose")
        near = self.maps.get(pose.map, _NO_MAP).around(pose, reach_m)
        return replace(near, centre_m=near.centre_m + np.asarray(self.origin_m))


_NO_MAP = Map(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
