"""The ego car's body: surfaces lofted from a profile, with glass, lights and shut lines cut in exactly."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np

from riglens.core.errors import InputError
from riglens.core.rig.model import PARAMETRIC_BODIES, Vehicle
from riglens.core.vehicle.profile import (
    BodyProfile,
    CabinOutline,
    Decal,
    Facing,
    Plane,
    RoundedBlock,
    ShutLine,
    Station,
    profile_of,
)
from riglens.core.vehicle.store import stored_surfaces
from riglens.core.vehicle.surface import (
    Painted,
    Points,
    Surface,
    cut,
    cut_convex,
    join,
    loft,
    polygon_distance,
    rounded_box,
    strip,
    superellipsoid,
)
from riglens.core.vehicle.wheels import OUTER_M, axle, axles_x, housing_reach_m

Axles = list[tuple[float, float]]
"""For each axle its x, and the distance of its wheel housings from the car's middle plane, metres."""
_WALLS = "arch walls"
_ON_EDGE_M, _INTO_HOUSING_M = 5e-3, 0.05
_OVERLAP_M = 0.02
_FACING_METRES = 0.4
_MIN_FACING = {"+x": 0.30, "-x": 0.30, "|y|": 0.45, "+z": 0.5, "-z": 0.7}


def body_parts(vehicle: Vehicle) -> tuple[tuple[str, Surface], ...]:
    """Return surfaces of the vehicle in its own frame (metres), one per material, with exactly the vehicle's size.

    Materials are paint, glass, trim, gap, lamp, tail, plate, tyre, rim and dark. Door mirrors stick out beyond `width`,
    as in a registration document. InputError for an unknown body. The car drawn last is kept on disk, because the next
    start is likely to show it again.
    """
    return tuple((material, mesh) for material, mesh in _kept(vehicle) if material != _WALLS)


def arch_walls(vehicle: Vehicle) -> tuple[Surface, ...]:
    """Return walls from the edges of the wheel arches into the housings, for pictures.

    The skin is drawn from outside alone: without them a look past a wheel goes through the car.
    """
    return tuple(mesh for material, mesh in _kept(vehicle) if material == _WALLS)


@lru_cache(maxsize=4)
def _kept(vehicle: Vehicle) -> Painted:
    if vehicle.body not in PARAMETRIC_BODIES:
        known = " or ".join(sorted(PARAMETRIC_BODIES))
        raise InputError(f"vehicle.body must be {known} (got '{vehicle.body}')")
    return stored_surfaces("finished", lambda: _finished(vehicle), of=vehicle)


def _finished(vehicle: Vehicle) -> Painted:
    """Return the profile's surfaces in the size of a vehicle, with mirrors and wheels, one mesh per material, and the
    walls of the wheel arches."""
    profile = profile_of(vehicle.body)
    painted = stored_surfaces(
        vehicle.body, lambda: _shell(profile) + _cabin(profile) + _blocks(profile.blocks)
    )
    painted = _fit(painted, vehicle)
    scale = vehicle.height / profile.height_m
    both_x = axles_x(profile, vehicle)
    axles = [
        (x, housing_reach_m(profile, vehicle, front, scale))
        for front, x in zip((False, True), both_x, strict=True)
    ]
    painted = _open_arches(painted, axles, profile, scale)
    painted += _mirrors(profile, vehicle)
    for front, x in enumerate(both_x):
        painted += axle(profile, vehicle, bool(front), x, scale)
    merged: dict[str, list[Surface]] = {}
    for material, mesh in painted:
        if len(mesh.triangles):
            merged.setdefault(material, []).append(mesh)
    finished = [(material, join(meshes)) for material, meshes in merged.items()]
    return [*finished, (_WALLS, _arch_walls(dict(finished)["trim"], profile, both_x, vehicle))]


def _arch_walls(
    trim: Surface, profile: BodyProfile, both_x: tuple[float, float], vehicle: Vehicle
) -> Surface:
    """Return walls from the edges of arches, which are among those of the trim, to the housings."""
    scale = vehicle.height / profile.height_m
    edges = trim.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    x, z = trim.points[:, 0], trim.points[:, 2] - scale * profile.wheel_radius_m
    found = []
    for axle_x in both_x:
        is_on_edge = np.abs(np.hypot(x - axle_x, z) - scale * profile.arch_radius_m) < _ON_EDGE_M
        found.append(edges[is_on_edge[edges].all(axis=1)])
    outer = trim.points[np.concatenate(found)]
    inner, deep = outer.copy(), vehicle.width / 2 - OUTER_M - _INTO_HOUSING_M
    inner[..., 1] = np.clip(inner[..., 1], -deep, deep)
    points = np.concatenate([outer, inner], axis=1).reshape(-1, 3)
    corners = np.array([[0, 1, 2], [1, 3, 2]], np.int64)
    triangles = (4 * np.arange(len(outer))[:, None, None] + corners).reshape(-1, 3)
    return Surface(points, np.tile([0.0, 0.0, -1.0], (len(points), 1)), triangles)


def _shell(profile: BodyProfile) -> Painted:
    """Lower body: cross-sections lofted along x, with its decals."""
    if not profile.stations:
        return []
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
    """Make the greenhouse: horizontal outlines lofted upwards, with its windows."""
    net = np.array([_outline(level, profile.cabin_bow_m) for level in profile.cabin])
    return _engrave(_paint(loft(net, 36, 113), profile.cabin_decals), profile.cabin_shut_lines)


def _blocks(blocks: tuple[RoundedBlock, ...]) -> Painted:
    """Make boxes with rounded edges: a cargo box, rails, a tank."""
    painted: Painted = []
    for block in blocks:
        painted += _block(block, 1.0)
        if block.on_both_sides:
            painted += _block(block, -1.0)
    return painted


def _block(block: RoundedBlock, side: float) -> Painted:
    low, high = np.array(block.low), np.array(block.high)
    if side < 0.0:
        low[1], high[1] = -high[1], -low[1]
    painted = _engrave([("paint", rounded_box(low, high, block.round_m))], block.shut_lines)
    return [(block.material if material == "paint" else material, mesh) for material, mesh in painted]


def _outline(level: CabinOutline, bow_m: float) -> Points:
    """Control points (k, 3) of a cabin outline: a rounded, bowed rectangle, once round from the rear."""
    front, rear, w = level.x_front, level.x_rear, level.half_width
    bow = bow_m * min(1.0, (front - rear) / 1.0)
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


def _paint(mesh: Surface, decals: tuple[Decal, ...]) -> Painted:
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


def _flat(mesh: Surface, plane: Plane) -> Points:
    """Return the coordinates (n, 2) of the points in a plane, with |y| in place of y."""
    points = mesh.points
    along = {"x": points[:, 0], "y": np.abs(points[:, 1]), "z": points[:, 2]}
    return np.stack([along[axis] for axis in plane], axis=1)


def _away(mesh: Surface, facing: Facing) -> Points:
    """Return values that are positive where the surface faces away from `facing`, in metres for the sake of a smooth
    cut."""
    normals = mesh.normals
    share = {
        "+x": normals[:, 0],
        "-x": -normals[:, 0],
        "|y|": np.abs(normals[:, 1]),
        "+z": normals[:, 2],
        "-z": -normals[:, 2],
    }
    return np.asarray((_MIN_FACING[facing] - share[facing]) * _FACING_METRES)


def _fit(painted: Painted, vehicle: Vehicle) -> Painted:
    """Stretch all parts together to the vehicle's length and width, centred, and its height."""
    points = np.concatenate([mesh.points for _, mesh in painted])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = np.array([vehicle.length, vehicle.width, vehicle.height]) / (high - [low[0], low[1], 0.0])
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0.0])
    return [(material, mesh.placed((mesh.points - middle) * scale)) for material, mesh in painted]


def _open_arches(painted: Painted, axles: Axles, profile: BodyProfile, scale: float) -> Painted:
    """Cut the wheel arches out of everything near the sides and edge them with a dark lip.

    The cut ends within the wheel housings, so that the body stays closed: nothing gets in or out beside a wheel.
    """
    arch_m, wheel_m, lip_m = (
        scale * length for length in (profile.arch_radius_m, profile.wheel_radius_m, profile.arch_lip_m)
    )
    opened: Painted = []
    for material, mesh in painted:
        for x, reach_m in axles:
            if not len(mesh.triangles):
                continue
            from_axle = np.hypot(mesh.points[:, 0] - x, mesh.points[:, 2] - wheel_m)
            inner = reach_m + _OVERLAP_M - np.abs(mesh.points[:, 1])
            lip, mesh = cut(mesh, np.maximum(from_axle - arch_m - lip_m, inner))
            if len(lip.triangles):
                _, lip = cut(lip, np.hypot(lip.points[:, 0] - x, lip.points[:, 2] - wheel_m) - arch_m)
                opened.append(("trim", lip))
        opened.append((material, mesh))
    return opened


def _mirrors(profile: BodyProfile, vehicle: Vehicle) -> Painted:
    """Return two door mirrors: rounded housings next to the foot of the windscreen, on arms if they are off the
    body."""
    scale = np.array([vehicle.length, vehicle.width, vehicle.height])
    scale = scale / [profile.length_m, profile.width_m, profile.height_m]
    arms = _blocks(profile.mirror_arms)
    painted = [(material, arm.placed(arm.points * scale)) for material, arm in arms]
    for side in (1.0, -1.0):
        housing = superellipsoid(profile.mirror_radii_m, 0.6)
        points = housing.points + np.array(profile.mirror_m) * [1.0, side, 1.0]
        for material, part in _paint(housing.placed(points), profile.mirror_decals):
            painted.append((material, part.placed(part.points * scale)))
    return painted
