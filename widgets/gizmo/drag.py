"""From a view ray to a pose: the maths of dragging a handle. Pure numpy, no Qt, no VTK.

A drag always returns the start pose plus the whole movement, never with a sum of small steps, and
components that the movement does not touch stay bit-identical. A drag that snaps ends on round numbers: where it
changes one number of the pose that number is round, elsewhere (along tilted axes) the movement is.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Pose, Vec3, rpy_deg_near
from riglens.widgets.drawing.camera import ViewRay

Vector = NDArray[np.float64]
Space = Literal["local", "world"]
"""Axes of the handles: the sensor's own, or the car's."""
GizmoMode = Literal["move", "rotate", "both"]
"""Handles that are shown."""
Motion = Callable[[Pose, Vector, float], Pose]
"""A pose moved along, or turned about, a unit axis by metres or radians."""
_MIN_SINE = 0.02
_EDGE_ON = 0.12
SNAP_M, SNAP_DEG = 0.05, 5.0


@dataclass(frozen=True)
class Handle:
    """An arrow along, a plane across or a ring about axis 0, 1 or 2 (x, y, z): "move", "plane" or "rotate"."""

    kind: Literal["move", "plane", "rotate"]
    axis: int


MOVE_HANDLES = tuple(Handle("move", axis) for axis in range(3))
PLANE_HANDLES = tuple(Handle("plane", axis) for axis in range(3))
ROTATE_HANDLES = tuple(Handle("rotate", axis) for axis in range(3))


def gizmo_axes(pose: Pose, space: Space) -> Vector:
    """Return the unit axes of the handles as columns, (3, 3), vehicle frame."""
    return pose.rotation() if space == "local" else np.eye(3)


def along_axis_m(origin_m: Vector, axis: Vector, ray: ViewRay) -> float | None:
    """Return the metres along a line (origin, unit axis) to the point nearest to a view ray.

    None when the line is seen end on or its nearest point lies behind the viewer: neither defines a place on it.
    """
    between = ray.origin_m - origin_m
    cosine = float(axis @ ray.direction)
    sine_squared = 1.0 - cosine * cosine
    if sine_squared < _MIN_SINE**2:
        return None
    on_axis, on_ray = float(axis @ between), float(ray.direction @ between)
    if cosine * on_axis - on_ray <= 0.0:
        return None
    return (on_axis - cosine * on_ray) / sine_squared


def on_plane_m(origin_m: Vector, normal: Vector, ray: ViewRay) -> Vector | None:
    """Return where a view ray meets a plane, relative to `origin_m`, (3,) metres; None when edge on or behind."""
    slope = float(normal @ ray.direction)
    if abs(slope) < _MIN_SINE:
        return None
    distance = float(normal @ (origin_m - ray.origin_m)) / slope
    if distance <= 0.0:
        return None
    return np.asarray(ray.origin_m + distance * ray.direction - origin_m)


def signed_angle_rad(start: Vector, end: Vector, axis: Vector) -> float:
    """Return the angle from one vector to another, positive by the right-hand rule about `axis`."""
    return math.atan2(float(axis @ np.cross(start, end)), float(start @ end))


def rotation_about(axis: Vector, angle_rad: float) -> Vector:
    """Return the rotation matrix (3, 3) about a unit axis (Rodrigues); exact zeros and ones about x, y and z."""
    x, y, z = (float(value) for value in axis)
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return cos * np.eye(3) + sin * cross + (1.0 - cos) * np.outer(axis, axis)


def moved(start: Pose, axis: Vector, distance_m: float) -> Pose:
    """Return the pose pushed along a unit axis; angles, and coordinates it does not touch, stay bit-identical."""
    x, y, z = (
        p + distance_m * float(a) if a != 0.0 else p for p, a in zip(start.position_m, axis, strict=True)
    )
    return Pose((x, y, z), start.rpy_deg)


def turned(start: Pose, axis: Vector, angle_rad: float) -> Pose:
    """Return the pose turned about a unit axis through its position; angles that do not change stay bit-identical."""
    if angle_rad == 0.0:
        return start
    rotation = rotation_about(axis, angle_rad) @ start.rotation()
    return Pose(start.position_m, rpy_deg_near(rotation, start.rpy_deg))


def moved_by_steps(start: Pose, axis: Vector, distance_m: float) -> Pose:
    """Return the pose of `moved`, by a multiple of SNAP_M."""
    return moved(start, axis, _round_to(distance_m, SNAP_M))


def turned_by_steps(start: Pose, axis: Vector, angle_rad: float) -> Pose:
    """Return the pose of `turned`, by a multiple of SNAP_DEG."""
    return turned(start, axis, math.radians(_round_to(math.degrees(angle_rad), SNAP_DEG)))


def moved_snapped(start: Pose, axis: Vector, distance_m: float) -> Pose:
    """Return the pose of `moved`, to a multiple of SNAP_M: of the coordinate along an axis of the car, else of the
    distance."""
    along = np.flatnonzero(axis)
    if len(along) != 1:
        return moved_by_steps(start, axis, distance_m)
    position = list(start.position_m)
    position[along[0]] = _round_to(position[along[0]] + distance_m * float(axis[along[0]]), SNAP_M)
    return Pose((position[0], position[1], position[2]), start.rpy_deg)


def turned_snapped(start: Pose, axis: Vector, angle_rad: float) -> Pose:
    """Return the pose of `turned`, to a multiple of SNAP_DEG: of the one angle that changes, else of the angle
    turned by."""
    free = turned(start, axis, angle_rad).rpy_deg
    changed = [place for place in range(3) if free[place] != start.rpy_deg[place]]
    if len(changed) != 1:
        return turned_by_steps(start, axis, angle_rad)
    angles = list(start.rpy_deg)
    angles[changed[0]] = _round_to(free[changed[0]], SNAP_DEG)
    return Pose(start.position_m, (angles[0], angles[1], angles[2]))


def _round_to(value: float, step: float) -> float:
    """Return the nearest multiple of a step, as the short decimal that a person would write."""
    return round(round(value / step) * step, 9) + 0.0


@dataclass(frozen=True)
class Drag:
    """Drag in progress: the start pose of the sensor and the grasped point of the handle.

    `axes` (3, 3) are the gizmo's. `line` is the unit direction read off in metres from `line_origin_m`; rings
    seen edge on are read off along their tangent too, with `radius_m` turning metres into radians. With `by_steps`
    what snaps is how far it goes, not where it ends: the middle of a group is at no round place.
    """

    handle: Handle
    start: Pose
    axes: Vector
    radius_m: float
    line_origin_m: Vector
    line: Vector | None
    grasp_m: float
    grasp: Vector
    by_steps: bool = False

    @property
    def axis(self) -> Vector:
        """Direction of an arrow, normal of a plane, axis of a ring, (3,)."""
        return np.ascontiguousarray(self.axes[:, self.handle.axis])

    def amount(self, ray: ViewRay) -> float | None:
        """Return metres moved along an arrow or radians turned since the start; None when the view ray is
        degenerate."""
        if self.line is None:
            end = on_plane_m(np.array(self.start.position_m), self.axis, ray)
            return None if end is None or not end.any() else signed_angle_rad(self.grasp, end, self.axis)
        end_m = along_axis_m(self.line_origin_m, self.line, ray)
        if end_m is None:
            return None
        return end_m - self.grasp_m if self.handle.kind == "move" else (end_m - self.grasp_m) / self.radius_m

    def pose(self, ray: ViewRay, snap: bool = False) -> Pose | None:
        """Return the pose for a view ray, on round numbers with `snap`; None when the ray is degenerate."""
        move, turn = self._motions(snap)
        if self.handle.kind == "plane":
            end = on_plane_m(np.array(self.start.position_m), self.axis, ray)
            if end is None:
                return None
            first, second = (self.axes[:, (self.handle.axis + step) % 3] for step in (1, 2))
            offset = end - self.grasp
            return move(move(self.start, first, float(first @ offset)), second, float(second @ offset))
        amount = self.amount(ray)
        if amount is None:
            return None
        return (move if self.handle.kind == "move" else turn)(self.start, self.axis, amount)

    def pose_after(self, amount: float) -> Pose:
        """Return the pose after metres along an arrow, or degrees about a ring."""
        if self.handle.kind == "move":
            return moved(self.start, self.axis, amount)
        return turned(self.start, self.axis, math.radians(amount))

    def _motions(self, snap: bool) -> tuple[Motion, Motion]:
        """Return how to move and how to turn: freely, onto round numbers, or by round numbers."""
        if not snap:
            return moved, turned
        return (moved_by_steps, turned_by_steps) if self.by_steps else (moved_snapped, turned_snapped)


def begin_drag(handle: Handle, space: Space, start: Pose, ray: ViewRay, radius_m: float) -> Drag | None:
    """Grasp a handle of the gizmo at `start` with a view ray; `radius_m` is the ring's radius in metres.

    None when the handle cannot be dragged from this view (an arrow seen end on, a plane seen edge on).
    """
    origin = np.array(start.position_m)
    axes = gizmo_axes(start, space)
    axis = axes[:, handle.axis].copy()
    if handle.kind == "move":
        return _line_drag(handle, start, axes, radius_m, origin, axis, ray)
    grasp = on_plane_m(origin, axis, ray)
    if abs(float(axis @ ray.direction)) >= _EDGE_ON and grasp is not None and grasp.any():
        return Drag(handle, start, axes, radius_m, origin, None, 0.0, grasp)
    if handle.kind == "plane":
        return None
    towards = -ray.direction - float(axis @ -ray.direction) * axis
    towards /= np.linalg.norm(towards)
    return _line_drag(
        handle, start, axes, radius_m, origin + radius_m * towards, np.cross(axis, towards), ray
    )


def _line_drag(
    handle: Handle, start: Pose, axes: Vector, radius_m: float, origin_m: Vector, line: Vector, ray: ViewRay
) -> Drag | None:
    grasp_m = along_axis_m(origin_m, line, ray)
    if grasp_m is None:
        return None
    return Drag(handle, start, axes, radius_m, origin_m, line, grasp_m, np.zeros(3))


def pose_matrix(position_m: Vec3, axes: Vector, scale: float) -> Vector:
    """Return the homogeneous matrix (4, 4) that puts a unit gizmo at a position with axes (3, 3) and size in metres."""
    matrix = np.eye(4)
    matrix[:3, :3] = axes * scale
    matrix[:3, 3] = position_m
    return matrix
