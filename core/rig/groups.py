"""Several sensors treated as one: what fails with what, their centre, moves and turns, alignment, even spacing."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Literal

import numpy as np

from riglens.core.errors import InputError
from riglens.core.geometry import Pose, Vec3, rpy_deg_near
from riglens.core.rig.edits import in_step, list_text
from riglens.core.rig.model import Rig, Sensor

Poses = dict[str, Pose]
"""Poses by the names of the sensors."""
Alignment = Literal["front", "rear", "left", "right", "centre", "height"]
_DECIMALS = 9
_SAME_M = 1e-12
_AXES = "xyz"
_AXIS: dict[Alignment, int] = {"front": 0, "rear": 0, "left": 1, "right": 1, "centre": 1, "height": 2}


def groups_of(sensors: Iterable[Sensor]) -> dict[str, tuple[str, ...]]:
    """Return names of common causes of failure, and the sensors of each, in the order of the rig."""
    groups: dict[str, list[str]] = {}
    for sensor in sensors:
        for name in dict.fromkeys(sensor.fails_with or ()):
            groups.setdefault(name, []).append(sensor.name)
    return {name: tuple(members) for name, members in groups.items()}


def centre_m(places_m: Iterable[Vec3]) -> Vec3:
    """Return the mean of some points, metres: the one place that stays where it is when all turn about it."""
    x, y, z = (sum(values) / len(values) for values in zip(*places_m, strict=True))
    return x, y, z


def carried(poses: Mapping[str, Pose], before: Pose, after: Pose) -> Poses:
    """Return the poses after the frame that holds them moved from one pose to another, as one rigid body.

    Coordinates and angles that the motion does not touch keep every bit, others are rounded to 1e-9 m and degrees. A
    sensor at the frame itself takes its new pose unchanged.
    """
    return {name: after if pose == before else _carried(pose, before, after) for name, pose in poses.items()}


def _carried(pose: Pose, before: Pose, after: Pose) -> Pose:
    if before.rpy_deg == after.rpy_deg:
        steps_m = (new - old for old, new in zip(before.position_m, after.position_m, strict=True))
        x, y, z = (
            p if step == 0.0 else round(p + step, _DECIMALS)
            for p, step in zip(pose.position_m, steps_m, strict=True)
        )
        return Pose((x, y, z), pose.rpy_deg)
    turn = after.rotation() @ before.rotation().T
    moved_m = turn @ np.subtract(pose.position_m, before.position_m) + after.position_m
    x, y, z = (
        old if abs(new - old) < _SAME_M else round(float(new), _DECIMALS) + 0.0
        for old, new in zip(pose.position_m, moved_m, strict=True)
    )
    roll, pitch, yaw = (
        old if new == old else round(new, _DECIMALS) + 0.0
        for old, new in zip(pose.rpy_deg, rpy_deg_near(turn @ pose.rotation(), pose.rpy_deg), strict=True)
    )
    return Pose((x, y, z), (roll, pitch, yaw))


def posed(rig: Rig, poses: Mapping[str, Pose]) -> Rig:
    """Return the rig with these sensors at other poses, mirror pairs in step."""
    changed = rig
    for name, pose in poses.items():
        changed = changed.with_sensor(name, changed.sensor(name).with_pose(pose))
    return in_step(rig, changed)


def aligned(rig: Rig, names: Collection[str], how: Alignment, current: str) -> Rig:
    """Return the rig with these sensors in line along one axis; the other coordinates and all angles stay.

    "front", "rear", "left" and "right" take the x or y of the outermost of them, "centre" the car's middle plane
    y = 0, "height" the z of the `current` one. Raise InputError when a mirror pair cannot be in line.
    """
    axis = _AXIS[how]
    values = [rig.sensor(name).position[axis] for name in names]
    if how == "centre":
        value = 0.0
    elif how == "height":
        value = rig.sensor(current).position[axis]
    else:
        value = max(values) if how in ("front", "left") else min(values)
    return _with_coordinates(rig, axis, dict.fromkeys(names, value))


def spacing_axis(rig: Rig, names: Collection[str]) -> int:
    """Return the axis (0 to 2 for x, y, z) along which sensors are furthest apart."""
    places_m = np.array([rig.sensor(name).position for name in names])
    return int(np.argmax(np.ptp(places_m, axis=0)))


def spaced(rig: Rig, names: Collection[str]) -> Rig:
    """Return the rig with sensors evenly spaced along the axis on which they are furthest apart.

    The outermost two stay, and so do the other coordinates. Raise InputError for fewer than three sensors, and when
    a mirror pair cannot be spaced so.
    """
    if len(names) < 3:
        raise InputError("even spacing needs three or more selected sensors")
    axis = spacing_axis(rig, names)
    ordered = sorted(names, key=lambda name: rig.sensor(name).position[axis])
    first, last = (rig.sensor(name).position[axis] for name in (ordered[0], ordered[-1]))
    step_m = (last - first) / (len(ordered) - 1)
    inner = {name: round(first + place * step_m, _DECIMALS) for place, name in enumerate(ordered)}
    return _with_coordinates(rig, axis, inner | {ordered[0]: first, ordered[-1]: last})


def _with_coordinates(rig: Rig, axis: int, values: Mapping[str, float]) -> Rig:
    """Return the rig with one coordinate of some sensors set; InputError where a mirror pair prevents it."""
    poses = {}
    for name, value in values.items():
        pose = rig.sensor(name).pose
        position = list(pose.position_m)
        position[axis] = value
        poses[name] = Pose((position[0], position[1], position[2]), pose.rpy_deg)
    changed = posed(rig, poses)
    against = [name for name, pose in poses.items() if changed.sensor(name).position[axis] != values[name]]
    if against:
        raise InputError(
            f"{list_text(against)}: its mirror image moves the other way, so they cannot both have that {_AXES[axis]}; "
            "unlink them, or select one of them"
        )
    return changed
