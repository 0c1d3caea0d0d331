"""What sensors look like: a LiDAR puck with its dark window, a camera body with a lens that looks ahead.

Shapes stand at the sensor's origin in its own frame (x forward, z up), metres, somewhat larger than life so
that they can be seen and grasped on a whole car. Each is one mesh with an `rgb` point array.
"""

from __future__ import annotations

import numpy as np
import pyvista as pv

from core.rig.model import Lidar
from widgets.theme import Palette, mix, rgb
from widgets.viewport.surface import lathe

LIDAR_RADIUS_M = 0.105
PICK_RADIUS_M = 0.12
_DARK = "#14161a"
_LENS = "#2b4a7d"


def sensor_mesh(sensor: object, palette: Palette, lit: bool, enabled: bool = True) -> pv.PolyData:
    """Mesh of a LiDAR or camera with an `rgb` uint8 point array; `lit` is selected or under the mouse."""
    kind = "lidar" if isinstance(sensor, Lidar) else "camera"
    colour = palette.selected if lit else palette.kinds[kind]
    if not enabled:
        colour = mix(colour, "#808890", 0.8)
    return _puck(colour) if kind == "lidar" else _camera(colour)


def _puck(colour: str) -> pv.PolyData:
    """A LiDAR: base, dark window ring, cap and a forward mark; the origin is in the window's middle."""
    r = LIDAR_RADIUS_M
    base = [(0.0, -0.085), (0.94 * r, -0.085), (r, -0.075), (r, -0.040), (0.95 * r, -0.036)]
    window = [(0.95 * r, -0.036), (0.90 * r, 0.036)]
    cap = [(0.93 * r, 0.036), (0.97 * r, 0.042), (0.96 * r, 0.062), (0.85 * r, 0.074), (0.0, 0.080)]
    nose = pv.Cube(center=(r, 0.0, -0.058), x_length=0.03, y_length=0.05, z_length=0.026)
    parts = [
        _tinted(_upright(base), colour), _tinted(_upright(window), _DARK),
        _tinted(_upright(cap), mix(colour, "#ffffff", 0.15)), _tinted(nose, mix(colour, "#000000", 0.25)),
    ]  # fmt: skip
    return _joined(parts)


def _camera(colour: str) -> pv.PolyData:
    """A camera: body behind the origin, lens barrel with dark glass ahead; a small fin marks its top."""
    body = pv.Cube(center=(-0.070, 0.0, 0.0), x_length=0.12, y_length=0.13, z_length=0.10)
    fin = pv.Cube(center=(-0.07, 0.0, 0.058), x_length=0.08, y_length=0.03, z_length=0.018)
    barrel = [(0.052, -0.02), (0.052, 0.035), (0.060, 0.040), (0.060, 0.060), (0.048, 0.060)]
    glass = [(0.048, 0.052), (0.030, 0.058), (0.0, 0.061)]
    parts = [
        _tinted(body, colour), _tinted(fin, mix(colour, "#ffffff", 0.35)),
        _tinted(_forward(barrel), _DARK), _tinted(_forward(glass), _LENS),
    ]  # fmt: skip
    return _joined(parts)


def _upright(profile: list[tuple[float, float]]) -> pv.PolyData:
    """A lathe about z from (radius, z) pairs."""
    return lathe(np.array(profile), 28).rotate_x(90, inplace=False)


def _forward(profile: list[tuple[float, float]]) -> pv.PolyData:
    """A lathe about x from (radius, x) pairs."""
    return lathe(np.array(profile), 24).rotate_z(-90, inplace=False)


def _tinted(mesh: pv.PolyData, colour: str) -> pv.PolyData:
    flat = pv.PolyData(mesh.points, mesh.faces).compute_normals(
        cell_normals=False, split_vertices=True, feature_angle=50, auto_orient_normals=False
    )
    flat["rgb"] = np.tile((np.array(rgb(colour)) * 255).astype(np.uint8), (flat.n_points, 1))
    return flat


def _joined(parts: list[pv.PolyData]) -> pv.PolyData:
    mesh = parts[0]
    for part in parts[1:]:
        mesh = mesh.append_polydata(part)
    return mesh
