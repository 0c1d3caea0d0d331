"""Geometry for modelling bodies from data: B-spline lofts, lathes, and decals cut exactly into a surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkFiltersCore import vtkClipPolyData

from riglens.widgets.drawing.actors import numpy_of

Points = NDArray[np.float64]
Painted = list[tuple[str, pv.PolyData]]  # surfaces, each with its material
_BOX_STEP_M = 0.2


def spline_matrix(controls: int, samples: int, degree: int = 3) -> Points:
    """Weights (samples, controls) of a clamped uniform B-spline at evenly spaced parameters.

    De Boor's recursion, bit for bit as in scipy, whose interpolation takes longer to import than to run.
    """
    inner = np.linspace(0.0, 1.0, controls - degree + 1)
    knots = np.concatenate([np.zeros(degree), inner, np.ones(degree)])
    at = np.linspace(0.0, 1.0, samples)
    span = np.clip(np.searchsorted(knots, at, side="right") - 1, degree, controls - 1)
    weights = [np.ones(samples)]
    for order in range(1, degree + 1):
        lower, weights = weights, [np.zeros(samples)]
        for n in range(1, order + 1):
            first, last = knots[span + n - order], knots[span + n]
            slope = lower[n - 1] / (last - first)
            weights[n - 1] = weights[n - 1] + slope * (last - at)
            weights.append(slope * (at - first))
    matrix = np.zeros((samples, controls))
    np.put_along_axis(matrix, span[:, None] + np.arange(-degree, 1), np.stack(weights, axis=1), axis=1)
    return matrix


def loft(net: Points, rows: int, columns: int) -> pv.PolyData:
    """Smooth surface over a control net (m, k, 3), sampled (rows, columns), with normals that may face either way.

    The point normals come from the smooth surface, so that later cuts keep the shading.
    """
    first, second = spline_matrix(net.shape[0], rows), spline_matrix(net.shape[1], columns)
    points = np.einsum("ia,jb,abc->ijc", first, second, net, optimize=True)
    return grid_surface(points)


def grid_surface(points: Points) -> pv.PolyData:
    """Quads over a lattice of points (rows, columns, 3), with smooth point normals."""
    rows, columns, _ = points.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    faces = np.insert(quads, 0, 4, axis=1).ravel()
    mesh = pv.PolyData(points.reshape(-1, 3).astype(np.float32), faces)
    set_normals(mesh, _lattice_normals(points).reshape(-1, 3))
    return mesh


def set_normals(mesh: pv.PolyData, normals: Points) -> None:
    """Give a mesh its point normals; always float32 and under one name, or joining meshes would drop them."""
    mesh.point_data["Normals"] = np.asarray(normals, dtype=np.float32)
    mesh.point_data.active_normals_name = "Normals"


def join(meshes: Sequence[pv.PolyData]) -> pv.PolyData:
    """All meshes as one, with their normals."""
    full = [mesh for mesh in meshes if mesh.n_cells]
    joined = full[0].append_polydata(*full[1:]) if len(full) > 1 else full[0]
    joined.point_data.active_normals_name = "Normals"
    return joined


def superellipsoid(radii_m: tuple[float, float, float], squareness: float, samples: int = 24) -> pv.PolyData:
    """A rounded box about the origin: squareness 1 is an ellipsoid, towards 0 a box."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, samples)[:, None]
    longitude = np.linspace(-np.pi, np.pi, 2 * samples)[None, :]
    unit = [np.cos(latitude), np.sin(latitude), np.cos(longitude), np.sin(longitude)]
    flat, up, ahead, left = (np.sign(part) * np.abs(part) ** squareness for part in unit)
    x, y, z = radii_m[0] * flat * ahead, radii_m[1] * flat * left, radii_m[2] * up + 0.0 * ahead
    return grid_surface(np.stack([x, y, z], axis=-1)[:, ::-1])


def rounded_box(low_m: Points, high_m: Points, radius_m: float) -> pv.PolyData:
    """A box from corner to corner, (3,) each, with edges rounded by `radius_m`; its faces are exactly flat."""
    half = (np.asarray(high_m) - low_m) / 2
    ticks = [_box_ticks(float(length), min(radius_m, float(half.min()))) for length in half]
    faces = [_box_face(half, ticks, axis, side, radius_m) for axis in range(3) for side in (-1.0, 1.0)]
    box = join(faces)
    box.points = np.asarray(box.points) + (np.asarray(low_m) + high_m) / 2
    return box


def _box_ticks(half_m: float, radius_m: float) -> Points:
    """Where the lattice of a face has its lines: even along the flat part, by angle in the round edges."""
    flat_m = half_m - radius_m
    arc = radius_m * np.tan(np.linspace(0.0, np.pi / 4, 4))[1:]
    middle = np.linspace(-flat_m, flat_m, 2 + int(2 * flat_m / _BOX_STEP_M))
    return np.concatenate([-flat_m - arc[::-1], middle, flat_m + arc])


def _box_face(half: Points, ticks: list[Points], axis: int, side: float, radius_m: float) -> pv.PolyData:
    """One face with its half of the round edges: a cube's face whose rim is pulled onto cylinders and spheres."""
    across = [(axis + 1) % 3, (axis + 2) % 3]
    cube = np.empty((len(ticks[across[0]]), len(ticks[across[1]]), 3))
    cube[..., axis] = side * half[axis]
    cube[..., across[0]], cube[..., across[1]] = np.meshgrid(*(ticks[i] for i in across), indexing="ij")
    reach = np.maximum(half - min(radius_m, float(half.min())), 0.0)
    inner = np.clip(cube, -reach, reach)
    normals = cube - inner
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    face = inner + min(radius_m, float(half.min())) * normals
    mesh = grid_surface(face if side > 0.0 else face[::-1])
    set_normals(mesh, (normals if side > 0.0 else normals[::-1]).reshape(-1, 3))
    return mesh


def _lattice_normals(points: Points) -> Points:
    """Unit normals of a lattice; where an edge is collapsed to a point the neighbour's normal is taken."""
    normal = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    for row, inner in ((0, 1), (-1, -2)):
        weak = size[row, :, 0] < 1e-6
        if _is_line(points[row]):
            weak = np.ones(len(weak), dtype=bool)
        normal[row][weak], size[row][weak] = normal[inner][weak], size[inner][weak]
    return np.asarray(normal / np.maximum(size, 1e-12))


def _is_line(outline: Points) -> bool:
    """Whether a closed outline (k, 3) encloses nothing: a surface closes there, and its own normals mean little."""
    spokes = outline - outline.mean(axis=0)
    return bool(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0)) < 1e-9)


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
    if not mesh.n_cells or distance.min() >= 0.0:
        return pv.PolyData(), mesh
    if distance.max() <= 0.0:
        return mesh, pv.PolyData()
    mesh = mesh.copy(deep=False)
    mesh["distance"] = distance
    mesh.set_active_scalars("distance")
    clipper = vtkClipPolyData()
    clipper.SetInputData(mesh)
    clipper.SetValue(0.0)
    clipper.InsideOutOn()
    clipper.GenerateClippedOutputOn()
    clipper.Update()
    return _compact(pv.wrap(clipper.GetOutput(0))), _compact(pv.wrap(clipper.GetOutput(1)))


def _compact(mesh: pv.PolyData) -> pv.PolyData:
    """The mesh without the points that no face uses: the clip filter keeps them all."""
    polygons = mesh.GetPolys()
    corners = numpy_of(polygons.GetConnectivityArray())
    offsets = numpy_of(polygons.GetOffsetsArray())
    used = np.zeros(mesh.n_points, dtype=bool)
    used[corners] = True
    faces = np.insert((np.cumsum(used) - 1)[corners], offsets[:-1], np.diff(offsets))
    compact = pv.PolyData(mesh.points[used], faces)
    for name in set(mesh.point_data.keys()) - {"distance"}:
        compact.point_data[name] = np.asarray(mesh.point_data[name])[used]
    compact.point_data.active_normals_name = "Normals"
    return compact


def cut_convex(
    mesh: pv.PolyData, flat: Points, away: Points, polygon: Sequence[tuple[float, float]]
) -> tuple[pv.PolyData, list[pv.PolyData]]:
    """Split off what lies in a convex polygon, in the plane where `flat` (n, 2) lies: (inside, what is left).

    Points with `away` > 0 never belong to it. Cutting along its straight sides one by one preserves a
    region that is far thinner than the mesh is fine.
    """
    sides = np.array([_beyond_side(flat, *side) for side in _sides(polygon)])
    mesh = mesh.copy(deep=False)
    for number, beyond in enumerate(sides):
        mesh[f"side{number}"] = beyond
    inside, rest = cut(mesh, np.maximum(sides.max(axis=0) - 0.15, away))
    parts = [rest]
    for number in range(len(sides)):
        if inside.n_cells:
            inside, outside = cut(inside, np.asarray(inside[f"side{number}"]))
            parts.append(outside)
    parts = [part for part in parts if part.n_cells]
    for part in (inside, *parts):
        for number in range(len(sides) if part.n_cells else 0):
            part.point_data.remove(f"side{number}")
    return inside, parts


def _sides(polygon: Sequence[tuple[float, float]]) -> list[tuple[Points, Points]]:
    """Sides (start, end) of a polygon, once round to the left."""
    corners = np.asarray(polygon, dtype=np.float64)
    after = np.roll(corners, -1, axis=0)
    if float((corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]).sum()) < 0.0:
        corners, after = after, corners
    return list(zip(corners, after, strict=True))


def _beyond_side(flat: Points, start: Points, end: Points) -> Points:
    """Distance of points to the right of a side, (n,); the inside of the polygon is negative."""
    along = (end - start) / np.linalg.norm(end - start)
    return np.asarray((flat - start) @ np.array([along[1], -along[0]]))


def strip(
    start: tuple[float, float], end: tuple[float, float], half_width_m: float
) -> list[tuple[float, float]]:
    """A thin rectangle along a line, slightly longer than it, so that joined strips leave no gap."""
    (x0, y0), (x1, y1) = start, end
    scale = half_width_m / float(np.hypot(x1 - x0, y1 - y0))
    dx, dy = (x1 - x0) * scale, (y1 - y0) * scale
    x0, y0, x1, y1 = x0 - 0.5 * dx, y0 - 0.5 * dy, x1 + 0.5 * dx, y1 + 0.5 * dy
    return [(x0 + dy, y0 - dx), (x1 + dy, y1 - dx), (x1 - dy, y1 + dx), (x0 - dy, y0 + dx)]
