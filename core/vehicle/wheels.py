"""Wheels, and the dark housings behind them, placed at the axles of a vehicle."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.profile import BodyProfile
from riglens.core.vehicle.surface import Painted, Points, Surface, cut, grid_surface, join, lathe

HOUSING_DEPTH_M = 0.10
"""Difference in depth between housing and wheel."""
OUTER_M = 0.035
"""From the side of the car to the outer face of the wheels."""


def axles_x(profile: BodyProfile, vehicle: Vehicle) -> tuple[float, float]:
    """Return x of the rear and the front axle."""
    wheelbase = (profile.axle_x[1] - profile.axle_x[0]) * vehicle.length / profile.length_m
    return vehicle.rear_axle_x, vehicle.rear_axle_x + wheelbase


def housing_reach_m(profile: BodyProfile, vehicle: Vehicle, front: bool, scale: float) -> float:
    """Return the distance from the car's middle plane to where the wheel housings of an axle begin."""
    return vehicle.width / 2 - OUTER_M - profile.wheel_width_m[front] * scale - HOUSING_DEPTH_M


def axle(profile: BodyProfile, vehicle: Vehicle, front: bool, x: float, scale: float) -> Painted:
    """Return both wheels of an axle and the dark wheel housings behind them."""
    radius, width = profile.wheel_radius_m * scale, profile.wheel_width_m[front] * scale
    outer_y = vehicle.width / 2 - OUTER_M
    painted: Painted = []
    for side in (1.0, -1.0):
        for material, mesh in [*_wheel(radius, width), *_housing(profile.arch_radius_m * scale, width)]:
            mirror = np.array([1.0, side, 1.0])
            wheel = mesh.placed(mesh.points * mirror + [x, side * outer_y, radius], mesh.normals * mirror)
            painted.append((material, wheel if side > 0.0 else wheel.turned_inside_out()))
    return painted


@lru_cache(maxsize=4)
def _wheel(radius: float, width: float) -> tuple[tuple[str, Surface], ...]:
    """Return a left wheel with its outer face at y = 0: tyre, dark bowl, spokes and hub; metres."""
    rim = 0.70 * radius
    tyre = np.array(
        [
            (rim, -width), (0.90 * radius, -width), (0.98 * radius, -0.92 * width), (radius, -0.8 * width),
            (radius, -0.2 * width), (0.985 * radius, -0.08 * width), (0.91 * radius, 0.0),
            (0.80 * radius, 0.006), (rim, -0.004), (0.98 * rim, -0.02),
        ]
    )  # fmt: skip
    bowl = np.array([(0.97 * rim, -0.02), (0.90 * rim, -0.35 * width), (0.0, -0.35 * width)])
    ring = np.array(
        [
            (0.98 * rim, -0.02),
            (0.985 * rim, 0.0),
            (0.94 * rim, 0.004),
            (0.90 * rim, -0.012),
            (0.89 * rim, -0.03),
        ]
    )
    hub = np.array([(0.24 * rim, -0.03), (0.23 * rim, -0.006), (0.17 * rim, 0.0), (0.0, 0.0)])
    parts = [
        ("tyre", lathe(tyre, 48)),
        ("dark", lathe(bowl, 48)),
        ("rim", lathe(ring, 48)),
        ("rim", lathe(hub, 24)),
    ]
    parts += [
        ("rim", _spoke(rim, 2.0 * np.pi * k / 5 + np.pi / 2 + turn))
        for k in range(5)
        for turn in (-0.14, 0.14)
    ]
    return tuple(parts)


def _spoke(rim: float, angle: float) -> Surface:
    """Return a tapered, slightly dished spoke from the hub to the rim ring, in the wheel's plane."""
    radii = np.array([0.12, 0.5, 0.95]) * rim
    half = np.array([0.055, 0.05, 0.068]) * rim
    face_y = np.array([-0.004, -0.014, -0.006])
    across = np.array([(-1.0, -0.03), (-1.0, 0.0), (1.0, 0.0), (1.0, -0.03)])
    radial, tangent = (
        np.array([np.cos(angle), 0.0, np.sin(angle)]),
        np.array([-np.sin(angle), 0.0, np.cos(angle)]),
    )
    points = [
        [r * radial + side * h * tangent + [0.0, y + depth, 0.0] for side, depth in across]
        for r, h, y in zip(radii, half, face_y, strict=True)
    ]
    return _creased(np.array(points))


def _creased(points: Points) -> Surface:
    """Return lengthwise strips over a lattice (rows, columns, 3), each smooth along itself, with edges between them."""
    strips = []
    for column in range(points.shape[1] - 1):
        strip = points[:, column : column + 2]
        a, b, c, d = strip[:-1, 0], strip[1:, 0], strip[1:, 1], strip[:-1, 1]
        flat = np.cross(c - a, d - b)
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        smooth = np.concatenate([flat[:1], flat]) + np.concatenate([flat, flat[-1:]])
        smooth /= np.linalg.norm(smooth, axis=1, keepdims=True)
        strips.append(grid_surface(strip, np.repeat(smooth[:, None], 2, axis=1)))
    return join(strips)


def _housing(arch_m: float, wheel_width: float) -> Painted:
    """Return a dark half-drum behind a wheel, so that the arch does not show an empty body."""
    depth = wheel_width + HOUSING_DEPTH_M
    profile = np.array([(arch_m + 0.012, -0.03), (arch_m + 0.012, -depth), (0.0, -depth)])
    drum = lathe(profile, 40)
    upper, _ = cut(drum, -0.42 * arch_m - drum.points[:, 2])
    return [("dark", upper)]
