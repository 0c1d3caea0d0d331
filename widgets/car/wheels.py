"""Wheels, and the dark housings behind them, placed at the axles of a vehicle."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pyvista as pv

from riglens.core.rig.model import Vehicle
from riglens.widgets.car.profile import BodyProfile
from riglens.widgets.drawing.surface import Painted, grid_surface, lathe, set_normals


def axle(profile: BodyProfile, vehicle: Vehicle, front: bool, x: float, scale: float) -> Painted:
    """Both wheels of an axle and the dark wheel housings behind them."""
    radius, width = profile.wheel_radius_m * scale, profile.wheel_width_m[front] * scale
    outer_y = vehicle.width / 2 - 0.035
    painted: Painted = []
    for side in (1.0, -1.0):
        for material, mesh in [*_wheel(radius, width), *_housing(profile.arch_radius_m * scale, width)]:
            mesh = mesh.copy()
            mesh.points = np.array(mesh.points) * [1.0, side, 1.0] + [x, side * outer_y, radius]
            set_normals(mesh, np.array(mesh.point_data["Normals"]) * [1.0, side, 1.0])
            if side < 0.0:
                mesh.flip_faces(
                    inplace=True
                )  # mirroring turns faces inside out, but light falls on their outside
            painted.append((material, mesh))
    return painted


@lru_cache(maxsize=4)
def _wheel(radius: float, width: float) -> tuple[tuple[str, pv.PolyData], ...]:
    """A left wheel with its outer face at y = 0: tyre, dark bowl, spokes and hub; metres."""
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


def _spoke(rim: float, angle: float) -> pv.PolyData:
    """A tapered, slightly dished spoke from the hub to the rim ring, in the wheel's plane."""
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
    mesh: pv.PolyData = grid_surface(np.array(points)).compute_normals(
        split_vertices=True, feature_angle=40, cell_normals=False
    )
    return mesh


def _housing(arch_m: float, wheel_width: float) -> Painted:
    """Dark half-drum behind a wheel, so that nobody can look through the arch into an empty body."""
    depth = wheel_width + 0.10
    profile = np.array([(arch_m + 0.012, -0.03), (arch_m + 0.012, -depth), (0.0, -depth)])
    drum = lathe(profile, 40).clip("z", origin=(0.0, 0.0, -0.42 * arch_m), invert=False)
    return [("dark", drum)]
