"""Arrow keys in the 3D view: which way a key pushes or turns a sensor, as seen by the viewer."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from riglens.core.geometry import Pose
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.gizmo.drag import Space, Vector, gizmo_axes, moved, turned

NudgeKey = Literal["left", "right", "forward", "back", "up", "down"]
STEP_M, STEP_DEG, COARSE = 0.01, 1.0, 10.0
_SIGN = {"left": -1.0, "right": 1.0, "forward": 1.0, "back": -1.0, "up": 1.0, "down": -1.0}
_TURNS = {
    "left": (2, 1.0),
    "right": (2, -1.0),
    "forward": (1, 1.0),
    "back": (1, -1.0),
    "up": (0, 1.0),
    "down": (0, -1.0),
}


def nudged(pose: Pose, key: NudgeKey, space: Space, camera: OrbitCamera, coarse: bool = False) -> Pose:
    """Return the pose 1 cm (coarse: 10 cm) away along the gizmo's axis that looks most like the key's direction."""
    right, forward, up = view_axes(gizmo_axes(pose, space), camera)
    axis = {"left": right, "right": right, "forward": forward, "back": forward}.get(key, up)
    after = moved(pose, axis, _SIGN[key] * STEP_M * (COARSE if coarse else 1.0))
    x, y, z = (_tidy(new, old) for new, old in zip(after.position_m, pose.position_m, strict=True))
    return Pose((x, y, z), pose.rpy_deg)


def nudge_turned(pose: Pose, key: NudgeKey, space: Space, coarse: bool = False) -> Pose:
    """Return the pose turned by 1 degree (coarse: 10): left and right yaw, forward (nose down) and back pitch, else
    roll."""
    axis, sign = _TURNS[key]
    angle_rad = math.radians(sign * STEP_DEG * (COARSE if coarse else 1.0))
    after = turned(pose, gizmo_axes(pose, space)[:, axis].copy(), angle_rad)
    roll, pitch, yaw = (_tidy(new, old) for new, old in zip(after.rpy_deg, pose.rpy_deg, strict=True))
    return Pose(pose.position_m, (roll, pitch, yaw))


def view_axes(axes: Vector, camera: OrbitCamera) -> tuple[Vector, Vector, Vector]:
    """Return axes (3, 3) as right, away from the viewer (or up on the screen, from above) and up, signs included."""
    screen_right, screen_up, into = camera.axes()
    away = (into + screen_up) * [1.0, 1.0, 0.0]
    left_over = [0, 1, 2]
    found = []
    for wanted in (np.array([0.0, 0.0, 1.0]), screen_right, away):
        best = max(left_over, key=lambda axis: abs(float(axes[:, axis] @ wanted)))
        left_over.remove(best)
        found.append(axes[:, best] * (1.0 if float(axes[:, best] @ wanted) >= 0.0 else -1.0))
    up, right, forward = found
    return right, forward, up


def _tidy(new: float, old: float) -> float:
    """Return a number that changed, without the digits that binary fractions add: 1.01, not 1.0100000000000002."""
    return old if new == old else round(new, 9)
