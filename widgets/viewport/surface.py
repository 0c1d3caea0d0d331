"""Geometry for modelling bodies from data: B-spline lofts, lathes, and decals cut exactly into a surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from scipy.interpolate import BSpline

Points = NDArray[np.float64]


def spline_matrix(controls: int, samples: int, degree: int = 3) -> Points:
    """Weights (samples, controls) of a clamped uniform B-spline at evenly spaced parameters."""
    inner = np.linspace(0.0, 1.0, controls - degree + 1)
    knots = np.concatenate([np.zeros(degree), inner, np.ones(degree)])
    return np.asarray(BSpline(knots, np.eye(controls), degree)(np.linspace(0.0, 1.0, samples)))


def loft(net: Points, rows: int, columns: int) -> pv.PolyData:
    """Smooth surface over a control net (m, k, 3), sampled (rows, columns), with outward-agnostic normals.

    The point normals come from the smooth surface, so that later cuts keep the shading.
    """
    first, second = spline_matrix(net.shape[0], rows), spline_matrix(net.shape[1], columns)
    points = np.einsum("ia,jb,abc->ijc", first, second, net)
    return grid_surface(points)


def grid_surface(points: Points) -> pv.PolyData:
    """Quads over a lattice of points (rows, columns, 3), with smooth point normals."""
    rows, columns, _ = points.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    faces = np.insert(quads, 0, 4, axis=1).ravel()
    mesh = pv.PolyData(points.reshape(-1, 3), faces)
    mesh.point_data.active_normals = _lattice_normals(points).reshape(-1, 3)
    return mesh


def _lattice_normals(points: Points) -> Points:
    """Unit normals of a lattice; where an edge is collapsed to a point the neighbour's normal is taken."""
    normal = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    for row, inner in ((0, 1), (-1, -2)):
        weak = size[row, :, 0] < 1e-6
        normal[row][weak], size[row][weak] = normal[inner][weak], size[inner][weak]
    return np.asarray(normal / np.maximum(size, 1e-12))


def lathe(profile: Points, sectors: int) -> pv.PolyData:
    """Surface of revolution about the y axis: profile (n, 2) of (radius, y), metres."""
    angle = np.linspace(0.0, 2.0 * np.pi, sectors + 1)
    radius, y = profile[:, 0][:, None], profile[:, 1][:, None]
    points = np.stack(
        [radius * np.cos(angle), np.broadcast_to(y, (len(profile), sectors + 1)), radius * np.sin(angle)], -1
    )
    return grid_surface(points)


def polygon_distance(points: Points, polygon: Sequence[tuple[float, float]]) -> Points:
    """Signed distance of points (n, 2) to a closed polygon; negative inside."""
    corners = np.asarray(polygon, dtype=np.float64)
    distance = np.full(len(points), np.inf)
    inside = np.zeros(len(points), dtype=bool)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        edge, offset = end - start, points - start
        along = np.clip(offset @ edge / (edge @ edge), 0.0, 1.0)
        distance = np.minimum(distance, np.linalg.norm(offset - along[:, None] * edge, axis=1))
        crosses = (start[1] <= points[:, 1]) != (end[1] <= points[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            x_cross = start[0] + (points[:, 1] - start[1]) / edge[1] * edge[0]
        inside ^= crosses & (points[:, 0] < x_cross)
    return np.where(inside, -distance, distance)


def cut(mesh: pv.PolyData, distance: Points) -> tuple[pv.PolyData, pv.PolyData]:
    """Split a surface exactly along distance = 0: (inside, outside); normals are carried along."""
    mesh = mesh.copy()
    mesh["distance"] = distance
    inside, outside = mesh.clip_scalar(scalars="distance", invert=True, value=0.0, both=True)
    for part in (inside, outside):
        part.point_data.remove("distance")
    return inside, outside
