"""The ego car's body: surfaces lofted from a profile, with glass, lights and shut lines cut in exactly."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pyvista as pv

from core.errors import InputError
from core.rig.model import Vehicle
from widgets.viewport.body_profiles import (
    PROFILES,
    BodyProfile,
    Decal,
    Facing,
    Level,
    Plane,
    ShutLine,
    Station,
)
from widgets.viewport.body_store import stored_surfaces
from widgets.viewport.surface import (
    Painted,
    Points,
    cut,
    cut_convex,
    grid_surface,
    join,
    lathe,
    loft,
    polygon_distance,
    set_normals,
    strip,
    superellipsoid,
)

_FACING_METRES = 0.4
_MIN_FACING = {"+x": 0.30, "-x": 0.30, "|y|": 0.45, "+z": 0.5, "-z": 0.7}


@dataclass(frozen=True)
class BodyPart:
    """All surfaces of one material: paint, glass, trim, gap, lamp, tail, plate, tyre, rim or dark."""

    material: str
    mesh: pv.PolyData


def body_parts(vehicle: Vehicle) -> tuple[BodyPart, ...]:
    """Surfaces of the vehicle in its own frame (metres), one per material, with exactly the vehicle's size.

    Door mirrors stick out beyond `width`, as in a registration document. InputError for an unknown body.
    """
    if vehicle.body not in PROFILES:
        raise InputError(f"vehicle.body: found '{vehicle.body}', accepted is {' or '.join(sorted(PROFILES))}")
    return _parts(vehicle)


@lru_cache(maxsize=4)
def _parts(vehicle: Vehicle) -> tuple[BodyPart, ...]:
    profile = PROFILES[vehicle.body]
    painted = stored_surfaces(vehicle.body, lambda: _shell(profile) + _cabin(profile))
    _fit(painted, vehicle)
    scale = vehicle.height / profile.height_m
    wheelbase = (profile.axle_x[1] - profile.axle_x[0]) * vehicle.length / profile.length_m
    axles_x = (vehicle.rear_axle_x, vehicle.rear_axle_x + wheelbase)
    painted = _open_arches(painted, axles_x, profile.arch_radius_m * scale, profile.wheel_radius_m * scale)
    painted += _mirrors(profile, vehicle)
    for x in axles_x:
        painted += _axle(profile, vehicle, x, scale)
    merged: dict[str, list[pv.PolyData]] = {}
    for material, mesh in painted:
        if mesh.n_cells:
            merged.setdefault(material, []).append(mesh)
    return tuple(BodyPart(material, join(meshes)) for material, meshes in merged.items())


def _shell(profile: BodyProfile) -> Painted:
    """Lower body: cross-sections lofted along x, with its decals."""
    net = np.array([_section(station) for station in profile.stations])
    return _engrave(_paint(loft(net, 80, 113), profile.body_decals), profile.shut_lines)


def _section(station: Station) -> Points:
    """Control points (k, 3) of a cross-section, once round from the top: left side, floor, right side."""
    w, low, high, deck = station.half_width, station.z_bottom, station.z_shoulder, station.z_deck
    waist = low + 0.52 * (high - low)
    half = [
        (0.00, low),
        (0.72 * w, low),
        (0.93 * w, low),
        (0.985 * w, low + 0.10 * (high - low)),
        (0.985 * w, low + 0.28 * (high - low)),
        (1.00 * w, waist),
        (1.012 * w, high - 0.16 * (high - low)),
        (0.985 * w, high - 0.02 * (high - low)),
        (0.93 * w, high + 0.35 * (deck - high)),
        (0.70 * w, deck - 0.25 * (deck - high)),
        (0.35 * w, deck),
        (0.00, deck),
    ]
    left = [(station.x, y, z) for y, z in half]
    right = [(station.x, -y, z) for y, z in reversed(half[1:-1])]
    return np.array([*reversed(left), *reversed(right), left[-1]])


def _cabin(profile: BodyProfile) -> Painted:
    """Greenhouse: horizontal outlines lofted upwards, with its windows."""
    net = np.array([_outline(level) for level in profile.cabin])
    return _paint(loft(net, 36, 113), profile.cabin_decals)


def _outline(level: Level) -> Points:
    """Control points (k, 3) of a cabin outline: a rounded, bowed rectangle, once round from the rear."""
    front, rear, w = level.x_front, level.x_rear, level.half_width
    bow = 0.10 * min(1.0, (front - rear) / 1.0)
    half = [
        (rear, 0.0),
        (rear + 0.15 * bow, 0.45 * w),
        (rear + 0.6 * bow, 0.84 * w),
        (rear + 1.6 * bow, 0.985 * w),
        (rear + 0.28 * (front - rear), 1.0 * w),
        (rear + 0.5 * (front - rear), 1.01 * w),
        (rear + 0.72 * (front - rear), 1.0 * w),
        (front - 2.4 * bow, 0.985 * w),
        (front - 1.1 * bow, 0.84 * w),
        (front - 0.3 * bow, 0.45 * w),
        (front, 0.0),
    ]
    left = [(x, y, level.z) for x, y in half]
    right = [(x, -y, level.z) for x, y in reversed(half[1:-1])]
    return np.array([*left, *right, left[0]])


def _paint(mesh: pv.PolyData, decals: tuple[Decal, ...]) -> Painted:
    """Cut the decals out of a painted surface, in order."""
    painted: Painted = []
    for decal in decals:
        flat, away = _flat(mesh, decal.plane), _away(mesh, decal.facing)
        if decal.round_m:
            distance = np.maximum(polygon_distance(flat, decal.polygon) - decal.round_m, away)
            inside, mesh = cut(mesh, distance)
        else:
            inside, rest = cut_convex(mesh, flat, away, decal.polygon)
            mesh = join(rest)
        painted.append((decal.material, inside))
    return [*painted, ("paint", mesh)]


def _engrave(painted: Painted, lines: tuple[ShutLine, ...]) -> Painted:
    """Cut the gaps between panels into the paint."""
    *decals, (material, mesh) = painted
    gaps: Painted = []
    for line in lines:
        for start, end in itertools.pairwise(line.path):
            polygon = strip(start, end, line.half_width_m)
            gap, rest = cut_convex(mesh, _flat(mesh, line.plane), _away(mesh, line.facing), polygon)
            gaps.append(("gap", gap))
            mesh = join(rest)
    return [*decals, *gaps, (material, mesh)]


def _flat(mesh: pv.PolyData, plane: Plane) -> Points:
    """Coordinates (n, 2) of the points in a plane, with |y| in place of y."""
    points = np.asarray(mesh.points, dtype=np.float64)
    along = {"x": points[:, 0], "y": np.abs(points[:, 1]), "z": points[:, 2]}
    return np.stack([along[axis] for axis in plane], axis=1)


def _away(mesh: pv.PolyData, facing: Facing) -> Points:
    """Positive where the surface does not face along `facing`, in metres for the sake of a smooth cut."""
    normals = np.asarray(mesh.point_data["Normals"])
    share = {
        "+x": normals[:, 0],
        "-x": -normals[:, 0],
        "|y|": np.abs(normals[:, 1]),
        "+z": normals[:, 2],
        "-z": -normals[:, 2],
    }
    return np.asarray((_MIN_FACING[facing] - share[facing]) * _FACING_METRES)


def _fit(painted: Painted, vehicle: Vehicle) -> None:
    """Stretch all parts together to the vehicle's length and width, centred, and its height."""
    points = np.concatenate([mesh.points for _, mesh in painted if mesh.n_points])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = np.array([vehicle.length, vehicle.width, vehicle.height]) / (high - [low[0], low[1], 0.0])
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0.0])
    for _, mesh in painted:
        mesh.points = (mesh.points - middle) * scale


def _open_arches(painted: Painted, axles_x: tuple[float, float], arch_m: float, wheel_m: float) -> Painted:
    """Cut the wheel arches out of everything near the sides and edge them with a dark lip."""
    opened: Painted = []
    for material, mesh in painted:
        for x in axles_x:
            if not mesh.n_cells:
                continue
            from_axle = np.hypot(mesh.points[:, 0] - x, mesh.points[:, 2] - wheel_m)
            inner = 0.45 * np.abs(mesh.points[:, 1]).max() - np.abs(mesh.points[:, 1])
            lip, mesh = cut(mesh, np.maximum(from_axle - arch_m - 0.022, inner))
            if lip.n_cells:
                _, lip = cut(lip, np.hypot(lip.points[:, 0] - x, lip.points[:, 2] - wheel_m) - arch_m)
                opened.append(("trim", lip))
        opened.append((material, mesh))
    return opened


def _axle(profile: BodyProfile, vehicle: Vehicle, x: float, scale: float) -> Painted:
    """Both wheels of an axle and the dark wheel housings behind them."""
    radius, width = profile.wheel_radius_m * scale, profile.wheel_width_m * scale
    outer_y = vehicle.width / 2 - 0.035
    painted: Painted = []
    for side in (1.0, -1.0):
        for material, mesh in [*_wheel(radius, width), *_housing(profile.arch_radius_m * scale, width)]:
            mesh = mesh.copy()
            mesh.points = np.array(mesh.points) * [1.0, side, 1.0] + [x, side * outer_y, radius]
            set_normals(mesh, np.array(mesh.point_data["Normals"]) * [1.0, side, 1.0])
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
    mesh = grid_surface(np.array(points)).compute_normals(
        split_vertices=True, feature_angle=40, cell_normals=False
    )
    return mesh


def _housing(arch_m: float, wheel_width: float) -> Painted:
    """Dark half-drum behind a wheel, so that nobody looks through the arch into an empty body."""
    depth = wheel_width + 0.10
    profile = np.array([(arch_m + 0.012, -0.03), (arch_m + 0.012, -depth), (0.0, -depth)])
    drum = lathe(profile, 40).clip("z", origin=(0.0, 0.0, -0.42 * arch_m), invert=False)
    return [("dark", drum)]


def _mirrors(profile: BodyProfile, vehicle: Vehicle) -> Painted:
    """Two door mirrors: rounded housings beside the foot of the windscreen."""
    scale = np.array([vehicle.length, vehicle.width, vehicle.height])
    scale = scale / [profile.length_m, profile.width_m, profile.height_m]
    painted: Painted = []
    for side in (1.0, -1.0):
        housing = superellipsoid((0.075, 0.125, 0.075), 0.6)
        housing.points = (housing.points + np.array(profile.mirror_m) * [1.0, side, 1.0]) * scale
        painted.append(("paint", housing))
    return painted
