"""Geometry for modelling bodies from data: B-spline lofts, lathes, and decals cut exactly into a surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Corners = NDArray[np.int64]
_BOX_STEP_M = 0.2
_CORNERS = 3


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles (m, 3) over points (n, 3) in metres with normals (n, 3), which later cuts carry along."""

    points: Points
    normals: Points
    triangles: Corners

    def placed(self, points: Points, normals: Points | None = None) -> Surface:
        """Return the same triangles over other points (n, 3), with other normals if any are given."""
        return Surface(points, self.normals if normals is None else normals, self.triangles)

    def turned_inside_out(self) -> Surface:
        """Return the same surface with the corners of its triangles the other way round."""
        return Surface(self.points, self.normals, np.ascontiguousarray(self.triangles[:, ::-1]))


Painted = list[tuple[str, Surface]]
"""Surfaces, each with its material."""
NO_SURFACE = Surface(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), np.int64))


def _spline_matrix(controls: int, samples: int) -> Points:
    """Return the weights (samples, controls) of a clamped uniform cubic B-spline at evenly spaced parameters."""
    from scipy.interpolate import BSpline  # late: a car from the cache does not wait for it

    knots = np.concatenate([np.zeros(3), np.linspace(0.0, 1.0, controls - 2), np.ones(3)])
    return np.asarray(BSpline(knots, np.eye(controls), 3)(np.linspace(0.0, 1.0, samples)))


def loft(net: Points, rows: int, columns: int) -> Surface:
    """Smooth surface over a control net (m, k, 3), sampled (rows, columns), with normals that may face either way.

    The point normals come from the smooth surface, so that later cuts keep the shading.
    """
    first, second = _spline_matrix(net.shape[0], rows), _spline_matrix(net.shape[1], columns)
    points = np.einsum("ia,jb,abc->ijc", first, second, net, optimize=True)
    return grid_surface(points)


def grid_surface(points: Points, normals: Points | None = None) -> Surface:
    """Return two triangles for each cell of a lattice of points (rows, columns, 3); normals are smooth unless given."""
    rows, columns, _ = points.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2)
    normals = _lattice_normals(points) if normals is None else normals
    flat, corners = points.reshape(-1, 3), triangles.reshape(-1, _CORNERS)
    sides = flat[corners] - flat[np.roll(corners, 1, axis=1)]
    return Surface(flat, normals.reshape(-1, 3), corners[(sides != 0.0).any(axis=2).all(axis=1)])


def join(surfaces: Sequence[Surface]) -> Surface:
    """Join all surfaces to one, with their normals."""
    full = [surface for surface in surfaces if len(surface.triangles)]
    if not full:
        return NO_SURFACE
    first = np.cumsum([0, *(len(surface.points) for surface in full[:-1])])
    return Surface(
        np.concatenate([surface.points for surface in full]),
        np.concatenate([surface.normals for surface in full]),
        np.concatenate([s.triangles + start for s, start in zip(full, first, strict=True)]),
    )


def superellipsoid(radii_m: tuple[float, float, float], squareness: float, samples: int = 24) -> Surface:
    """Return a rounded box about the origin: squareness 1 is an ellipsoid, towards 0 a box."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, samples)[:, None]
    longitude = np.linspace(-np.pi, np.pi, 2 * samples)[None, :]
    unit = [np.cos(latitude), np.sin(latitude), np.cos(longitude), np.sin(longitude)]
    flat, up, ahead, left = (np.sign(part) * np.abs(part) ** squareness for part in unit)
    x, y, z = radii_m[0] * flat * ahead, radii_m[1] * flat * left, radii_m[2] * up + 0.0 * ahead
    return grid_surface(np.stack([x, y, z], axis=-1)[:, ::-1])


def rounded_box(low_m: Points, high_m: Points, radius_m: float) -> Surface:
    """Return a box from corner to corner, (3,) each, with edges rounded by `radius_m`; its faces are exactly flat."""
    half = (np.asarray(high_m) - low_m) / 2
    ticks = [_box_ticks(float(length), min(radius_m, float(half.min()))) for length in half]
    faces = [_box_face(half, ticks, axis, side, radius_m) for axis in range(3) for side in (-1.0, 1.0)]
    box = join(faces)
    return box.placed(box.points + (np.asarray(low_m) + high_m) / 2)


def _box_ticks(half_m: float, radius_m: float) -> Points:
    """Return the lines of a face's lattice: even along the flat part, by angle in the round edges."""
    flat_m = half_m - radius_m
    arc = radius_m * np.tan(np.linspace(0.0, np.pi / 4, 4))[1:]
    middle = np.linspace(-flat_m, flat_m, 2 + int(2 * flat_m / _BOX_STEP_M))
    return np.concatenate([-flat_m - arc[::-1], middle, flat_m + arc])


def _box_face(half: Points, ticks: list[Points], axis: int, side: float, radius_m: float) -> Surface:
    """Return one face with its half of the round edges: a cube's face whose rim is pulled onto cylinders and
    spheres."""
    across = [(axis + 1) % 3, (axis + 2) % 3]
    cube = np.empty((len(ticks[across[0]]), len(ticks[across[1]]), 3))
    cube[..., axis] = side * half[axis]
    cube[..., across[0]], cube[..., across[1]] = np.meshgrid(*(ticks[i] for i in across), indexing="ij")
    reach = np.maximum(half - min(radius_m, float(half.min())), 0.0)
    inner = np.clip(cube, -reach, reach)
    normals = cube - inner
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    face = inner + min(radius_m, float(half.min())) * normals
    return grid_surface(face, normals) if side > 0.0 else grid_surface(face[::-1], normals[::-1])


def _lattice_normals(points: Points) -> Points:
    """Return the unit normals of a lattice; where an edge is collapsed to a point the neighbour's normal is taken."""
    normal = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    for row, inner in ((0, 1), (-1, -2)):
        weak = size[row, :, 0] < 1e-6
        if _is_line(points[row]):
            weak = np.ones(len(weak), dtype=bool)
        normal[row][weak], size[row][weak] = normal[inner][weak], size[inner][weak]
    return np.asarray(normal / np.maximum(size, 1e-12))


def _is_line(outline: Points) -> bool:
    """Return whether a closed outline (k, 3) encloses nothing: a surface closes there, and its own normals mean
    little."""
    spokes = outline - outline.mean(axis=0)
    return bool(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0)) < 1e-9)


def lathe(profile: Points, sectors: int) -> Surface:
    """Return the surface of revolution about the y axis: profile (n, 2) of (radius, y), metres."""
    angle = np.linspace(0.0, 2.0 * np.pi, sectors + 1)
    radius, y = profile[:, 0][:, None], profile[:, 1][:, None]
    points = np.stack(
        [radius * np.cos(angle), np.broadcast_to(y, (len(profile), sectors + 1)), radius * np.sin(angle)], -1
    )
    return grid_surface(points)


def polygon_distance(points: Points, polygon: Sequence[tuple[float, float]]) -> Points:
    """Return the signed distance of points (n, 2) to a closed polygon; negative inside."""
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


def cut(surface: Surface, distance: Points) -> tuple[Surface, Surface]:
    """Split a surface exactly along distance (n,) = 0: (inside, outside); normals are carried along."""
    (inside, outside), _ = _cut(surface, distance, np.zeros((len(surface.points), 0)))
    return inside, outside


def cut_convex(
    surface: Surface, flat: Points, away: Points, polygon: Sequence[tuple[float, float]]
) -> tuple[Surface, list[Surface]]:
    """Split off the part in a convex polygon, in the plane where `flat` (n, 2) lies: (inside, rest).

    Points with `away` > 0 never belong to it. Cutting along its straight sides one by one preserves a
    region that is far thinner than the mesh is fine.
    """
    sides = np.stack([_beyond_side(flat, *side) for side in _sides(polygon)], axis=1)
    near = np.maximum(sides.max(axis=1) - 0.15, away) if len(flat) else away
    (inside, rest), (sides, _) = _cut(surface, near, sides)
    parts = [rest]
    for side in range(sides.shape[1]):
        (inside, outside), (sides, _) = _cut(inside, sides[:, side], sides)
        parts.append(outside)
    return inside, [part for part in parts if len(part.triangles)]


def _cut(
    surface: Surface, distance: Points, more: Points
) -> tuple[tuple[Surface, Surface], tuple[Points, Points]]:
    """Return inside and outside of a surface, and values (n, k) at its points, for the points of both."""
    if not len(surface.triangles) or distance.min() >= 0.0:
        return (NO_SURFACE, surface), (more[:0], more)
    if distance.max() <= 0.0:
        return (surface, NO_SURFACE), (more, more[:0])
    values = np.concatenate([surface.points, surface.normals, more], axis=1)
    inside = distance <= 0.0
    count = inside[surface.triangles].sum(axis=1)
    alone, others, values = _cut_triangles(surface.triangles[(count == 1) | (count == 2)], distance, values)
    is_in = count[(count == 1) | (count == 2)] == 1
    both = np.concatenate([is_in, is_in])
    kept = [
        np.concatenate([surface.triangles[count == _CORNERS], alone[is_in], others[~both]]),
        np.concatenate([surface.triangles[count == 0], alone[~is_in], others[both]]),
    ]
    (one, one_more), (other, other_more) = (_compact(values, triangles) for triangles in kept)
    return (one, other), (one_more, other_more)


def _cut_triangles(mixed: Corners, distance: Points, values: Points) -> tuple[Corners, Corners, Points]:
    """Return the piece (m, 3) of each triangle with one corner on its side, the two pieces (2 m, 3) of the other, and
    values (n + k, a) with new points where edges are cut.

    An edge is cut at the same point whichever triangle it belongs to, so a closed surface stays closed.
    """
    inside = distance[mixed] <= 0.0
    lone = np.argmax(inside == (inside.sum(axis=1) == 1)[:, None], axis=1)
    a, b, c = (np.take_along_axis(mixed, ((lone + k) % 3)[:, None], axis=1)[:, 0] for k in range(3))
    edges, number = np.unique(
        np.sort(np.concatenate([np.stack([a, b], axis=1), np.stack([a, c], axis=1)]), axis=1),
        axis=0,
        return_inverse=True,
    )
    low, high = edges.T
    share = (distance[low] / (distance[low] - distance[high]))[:, None]
    points = len(values) + np.arange(len(edges))
    points = np.where(share[:, 0] == 0.0, low, np.where(share[:, 0] == 1.0, high, points))
    ab, ac = np.split(points[number.reshape(-1)], 2)
    alone = np.stack([a, ab, ac], axis=1)
    others = np.concatenate([np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)])
    return alone, others, np.concatenate([values, values[low] + share * (values[high] - values[low])])


def _compact(values: Points, triangles: Corners) -> tuple[Surface, Points]:
    """Return a surface of the points that its triangles use, those without a side left out, and the other values
    there."""
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    used = np.zeros(len(values), dtype=bool)
    used[triangles] = True
    values = values[used]
    return Surface(values[:, :3], values[:, 3:6], (np.cumsum(used) - 1)[triangles]), values[:, 6:]


def _sides(polygon: Sequence[tuple[float, float]]) -> list[tuple[Points, Points]]:
    """Return the sides (start, end) of a polygon, once round to the left."""
    corners = np.asarray(polygon, dtype=np.float64)
    after = np.roll(corners, -1, axis=0)
    if float((corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]).sum()) < 0.0:
        corners, after = after, corners
    return list(zip(corners, after, strict=True))


def _beyond_side(flat: Points, start: Points, end: Points) -> Points:
    """Return the distance of points to the right of a side, (n,); the inside of the polygon is negative."""
    along = (end - start) / np.linalg.norm(end - start)
    return np.asarray((flat - start) @ np.array([along[1], -along[0]]))


def strip(
    start: tuple[float, float], end: tuple[float, float], half_width_m: float
) -> list[tuple[float, float]]:
    """Return a thin rectangle along a line, slightly longer than it, so that joined strips leave no gap."""
    (x0, y0), (x1, y1) = start, end
    scale = half_width_m / float(np.hypot(x1 - x0, y1 - y0))
    dx, dy = (x1 - x0) * scale, (y1 - y0) * scale
    x0, y0, x1, y1 = x0 - 0.5 * dx, y0 - 0.5 * dy, x1 + 0.5 * dx, y1 + 0.5 * dy
    return [(x0 + dy, y0 - dx), (x1 + dy, y1 - dx), (x1 - dy, y1 + dx), (x0 - dy, y0 + dx)]
