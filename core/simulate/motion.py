"""Motion between frames: where the car and the objects were a moment before a frame.

Objects have no identity in box data; in a sequence, two boxes of the same class and exactly the same size are one
object. It is assumed to move in a straight line at the speed between two frames.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.scene.occluders import FrameName, MapPose
from riglens.core.targets.traffic import NO_CLASS, Traffic

Doubles = NDArray[np.float64]
SWEEP_S = 0.1
"""Time between two sweeps: 10 turns a second."""


@dataclass(frozen=True)
class Motion:
    """Velocities over ground in frames of traffic, T of them with n boxes, in the vehicle frame of each: car_m_s (T, 2)
    and turn_rad_s (T,) of the car, boxes_m_s (n, 2); 0 for occluders and for objects in one frame alone."""

    car_m_s: Doubles
    turn_rad_s: Doubles
    boxes_m_s: Doubles

    @cached_property
    def sha256(self) -> str:
        """Hash of all velocities."""
        parts = (self.car_m_s, self.turn_rad_s, self.boxes_m_s)
        return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


@dataclass(frozen=True)
class Before:
    """Pose of the car a moment before a frame, in the vehicle frame of the frame: place_m (3,), rotation (3, 3); and
    how far the boxes of the frame still had to go, moved_m (n, 2)."""

    place_m: Doubles
    rotation: Doubles
    moved_m: Doubles

    def to_frame(self, points_m: NDArray[np.float32]) -> NDArray[np.float32]:
        """Convert points (k, 3) measured then to the vehicle frame of the frame."""
        return (points_m @ self.rotation.T + self.place_m).astype(np.float32)


def before(motion: Motion, place: int, boxes: slice, ago_s: float) -> Before:
    """Return where the car was some seconds before the frame at a place in the traffic, whose boxes are `boxes`."""
    at_m = np.append(-ago_s * motion.car_m_s[place], 0.0)
    turn = rotations_from_yaw(np.array([-ago_s * motion.turn_rad_s[place]]))[0]
    return Before(at_m, turn, ago_s * motion.boxes_m_s[boxes])


def motion_of(traffic: Traffic, poses: Mapping[FrameName, MapPose], period_s: float) -> Motion:
    """Return the motion between frames that are `period_s` apart: since the frame before, else until the next one.

    poses: of the vehicle frame; InputError where one is missing.
    """
    labels = traffic.data.labels
    if labels is None:
        raise InputError(f"{traffic.data.source}: needs named sequences for several sweeps")
    named = len(labels.sequence)  # frames without boxes behind the last one have no name
    held = {labels.of(number): place for place, number in enumerate(traffic.frame.tolist()) if number < named}
    frames = {name: _Frame.of(traffic, place, poses.get(name)) for name, place in held.items()}
    car, turn = np.zeros((traffic.frames, 2)), np.zeros(traffic.frames)
    boxes = np.zeros((len(traffic.cls), 2))
    for (sequence, number), place in held.items():
        now = frames[sequence, number]
        for step in (1, -1):  # the frame before overrides the one after
            other = frames.get((sequence, number + step))
            if other is None:
                continue
            car[place] = now.rotated(step * (other.origin_m - now.origin_m)) / period_s
            turn[place] = np.angle(np.exp(1j * step * (other.yaw_rad - now.yaw_rad))) / period_s
            for key, box in now.keys.items():
                if key in other.keys:
                    apart_m = other.at_m[other.keys[key] - other.first] - now.at_m[box - now.first]
                    boxes[box] = now.rotated(step * apart_m) / period_s
    return Motion(car, turn, boxes)


@dataclass(frozen=True)
class _Frame:
    """Frame in the map: origin_m (2,) and yaw of the vehicle frame; at_m (n, 2) of its boxes, numbered from `first`;
    keys: the boxes by class and size, where no other has the same."""

    origin_m: Doubles
    yaw_rad: float
    first: int
    at_m: Doubles
    keys: Mapping[tuple[float, ...], int]

    @classmethod
    def of(cls, traffic: Traffic, place: int, pose: MapPose | None) -> _Frame:
        first, end = int(traffic.starts[place]), int(traffic.starts[place + 1])
        if pose is None:
            raise InputError(f"{traffic.data.source}: several sweeps need the pose of the car in every frame")
        origin_m = np.array(pose.position_m[:2])
        turn = rotations_from_yaw(np.array([pose.yaw_rad]))[0, :2, :2]
        count: dict[tuple[float, ...], list[int]] = {}
        for box in range(first, end):
            if traffic.cls[box] != NO_CLASS:
                key = (float(traffic.cls[box]), *traffic.size_m[box].tolist())
                count.setdefault(key, []).append(box)
        keys = {key: boxes[0] for key, boxes in count.items() if len(boxes) == 1}
        return cls(origin_m, pose.yaw_rad, first, traffic.centre_m[first:end, :2] @ turn.T + origin_m, keys)

    def rotated(self, offset_m: Doubles) -> Doubles:
        """Return an offset in the map (2,) in the vehicle frame."""
        turn = rotations_from_yaw(np.array([self.yaw_rad]))[0, :2, :2]
        return np.asarray(offset_m @ turn)
