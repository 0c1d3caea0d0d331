"""Text next to the cursor during a drag: the sensor's displacement and its position, and a number being typed."""

from __future__ import annotations

import math

import numpy as np

from riglens.core.geometry import Pose, Vec3

_COORDINATES = ("x", "y", "z")
_ANGLES = ("roll", "pitch", "yaw")


def drag_echo(start: Pose, now: Pose, count: int = 1) -> str:
    """Return two lines: the change since the start and the new values, of the numbers that changed.

    A sensor that was both moved and turned shows its new position and angles. Several sensors show their centre, named
    in a third line, without angles.
    """
    if count > 1:
        told = _turn_echo(start, now) if now.rpy_deg != start.rpy_deg else _move_echo(start, now)
        lines = told.splitlines()
        return "\n".join(
            [*(lines if now.rpy_deg == start.rpy_deg else lines[:1]), f"centre of {count} sensors"]
        )
    if now.rpy_deg != start.rpy_deg and now.position_m != start.position_m:
        (x, y, z), (roll, pitch, yaw) = now.position_m, now.rpy_deg
        return f"x {x:.3f}   y {y:.3f}   z {z:.3f} m\nroll {roll:.1f}°   pitch {pitch:.1f}°   yaw {yaw:.1f}°"
    return _turn_echo(start, now) if now.rpy_deg != start.rpy_deg else _move_echo(start, now)


def amount_of(typed: str) -> float | None:
    """Return the number that keys have spelled so far, None while they spell none."""
    try:
        return float(typed)
    except ValueError:
        return None


def typed_echo(typed: str, is_turn: bool) -> str:
    """Return the line for a number that is being typed."""
    return f"{typed}▏{'°' if is_turn else ' m'} · Enter"


def _move_echo(start: Pose, now: Pose) -> str:
    changed = _changed(start.position_m, now.position_m, 5e-7) or [0, 1, 2]
    moves = [(_COORDINATES[i], now.position_m[i] - start.position_m[i]) for i in changed]
    first = "   ".join(f"Δ{name} {_signed(metres, 3)}" for name, metres in moves)
    second = "   ".join(f"{_COORDINATES[i]} {now.position_m[i]:.3f}" for i in changed)
    return f"{first} m\n{second} m"


def _turn_echo(start: Pose, now: Pose) -> str:
    changed = _changed(start.rpy_deg, now.rpy_deg, 5e-7) or [0, 1, 2]
    first = f"turned {_angle_between_deg(start, now):.1f}°"
    if len(changed) == 1:
        turned_deg = math.remainder(now.rpy_deg[changed[0]] - start.rpy_deg[changed[0]], 360.0)
        first = f"Δ{_ANGLES[changed[0]]} {_signed(turned_deg, 1)}°"
    second = "   ".join(f"{_ANGLES[i]} {now.rpy_deg[i]:.1f}°" for i in changed)
    return f"{first}\n{second}"


def _changed(before: Vec3, after: Vec3, least: float) -> list[int]:
    return [i for i in range(3) if abs(after[i] - before[i]) >= least]


def _angle_between_deg(start: Pose, now: Pose) -> float:
    """Return the angle of the one turn that leads from a pose to another, 0 to 180 degrees."""
    cosine = (float(np.trace(start.rotation().T @ now.rotation())) - 1.0) / 2.0
    return math.degrees(math.acos(min(1.0, max(-1.0, cosine))))


def _signed(value: float, digits: int) -> str:
    """Return a number with its sign, and no minus before a zero."""
    return f"{round(value, digits) + 0.0:+.{digits}f}"
