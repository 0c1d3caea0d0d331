"""Find spots where sensors may be mounted: on the car's skin, or in a box in the air."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.solid import MATERIALS, Solid, solid_of
from riglens.core.vehicle.standing import mount_status, skin_of

if TYPE_CHECKING:
    from riglens.core.kernels.body.solid import Tree

Doubles = NDArray[np.float64]
SKIN = ("paint", "panel", "trim")
"""Materials that carry sensors; the bodies of mesh files are of paint."""
WINDSCREEN_TOP, WINDSCREEN_MIDDLE = 0.5, 0.2
"""Part of the windscreen behind which cameras stand: share of its height from the top, and of the car's width to either
side of the middle. Our choice of "above the rear view mirror" (Tesla, "Model 3 Owner's Manual")."""
_FORWARD = 0.2
_SAMPLES_A_M2 = 4000.0
_MOST_SAMPLES = 400_000
_UNDERSIDE = -0.35
_LIFT_M = 0.005
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Spot:
    """A place on the skin and its outward unit normal, both (3,); a free one is where the middle of a sensor is, a
    middle one is for single sensors among pairs; at one behind glass a sensor stands inside."""

    point_m: Doubles
    normal: Doubles
    is_free: bool = False
    is_middle: bool = False
    behind_glass: bool = False


def spots_of(
    vehicle: Vehicle,
    solid: Solid,
    box_m: Sequence[tuple[float, float]] | None,
    spacing_m: float,
    seed: int,
    with_middle: bool,
) -> tuple[list[Spot], int]:
    """Return the spots of a search and how many of them are for the left sensors of pairs: those in a box, or on the
    skin and behind the windscreen, with their images and, if requested, those near the middle plane moved onto it."""
    if box_m is not None:
        spots = box_spots(box_m, spacing_m, solid)
        return spots, len(spots)
    half = [*skin_spots(vehicle, spacing_m, seed), *windscreen_spots(vehicle, spacing_m, seed)]
    flip = np.array([1.0, -1.0, 1.0])
    spots = [
        *half,
        *(replace(s, point_m=s.point_m * flip, normal=s.normal * flip) for s in half if s.point_m[1] > 0.05),
    ]
    for spot in half if with_middle else ():
        if 0.0 < spot.point_m[1] <= spacing_m / 2.0:
            x, _, z = skin_of(solid).nearest(spot.point_m * [1.0, 0.0, 1.0]).tolist()
            normal = spot.normal * [1.0, 0.0, 1.0]
            normal /= np.linalg.norm(normal)
            spots.append(replace(spot, point_m=np.array([x, 0.0, z]), normal=normal, is_middle=True))
    return spots, len(half)


def windscreen_spots(vehicle: Vehicle, spacing_m: float, seed: int = 0) -> list[Spot]:
    """Return spots at the top of the windscreen's left half, around the mirror, behind its glass."""
    wide_m = WINDSCREEN_MIDDLE * vehicle.width
    panes = skin_spots(vehicle, spacing_m, seed, ("glass",))
    panes = [one for one in panes if one.normal[0] > _FORWARD and one.point_m[1] <= wide_m]
    heights_m = [float(one.point_m[2]) for one in panes]
    low, high = min(heights_m, default=0.0), max(heights_m, default=0.0)
    return [
        replace(one, behind_glass=True)
        for one in panes
        if one.point_m[2] >= high - WINDSCREEN_TOP * (high - low)
    ]


def skin_spots(
    vehicle: Vehicle, spacing_m: float, seed: int = 0, materials: Sequence[str] = SKIN
) -> list[Spot]:
    """Return spots on the left half of a car's skin, at least `spacing_m` apart, in the order of their draw.

    Points are drawn evenly by area; each one that sees the sky or the road straight ahead of the surface and keeps its
    distance is taken (Poisson-disk sampling by dart throwing).
    """
    from scipy.spatial import KDTree  # slow to load

    solid = solid_of(vehicle)
    corners = solid.triangles_m[np.isin(solid.materials, [MATERIALS.index(name) for name in materials])]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(across, axis=1)
    if not len(corners):
        return []
    rng = np.random.default_rng(seed)
    number = min(_MOST_SAMPLES, math.ceil(double.sum() / 2.0 * _SAMPLES_A_M2 * (0.2 / spacing_m) ** 2))
    chosen = rng.choice(len(corners), number, p=double / double.sum())
    share = rng.random((number, 2))
    share = np.where(share.sum(axis=1, keepdims=True) > 1.0, 1.0 - share, share)
    a, b, c = corners[chosen].transpose(1, 0, 2)
    points = a + share[:, :1] * (b - a) + share[:, 1:] * (c - a)
    normals = (across / double[:, None])[chosen]
    open_ = (points[:, 1] >= 0.0) & (normals[:, 2] > _UNDERSIDE)
    points, normals, spots = points[open_], normals[open_], list[Spot]()
    every, is_far, around = np.ones(solid.count, np.bool_), np.ones(len(points), np.bool_), KDTree(points)
    for place, (point, normal) in enumerate(zip(points, normals, strict=True)):
        if is_far[place] and _is_free(point, normal, solid.tree, every):
            spots.append(Spot(point, normal))
            near = np.array(around.query_ball_point(point, spacing_m * (1.0 + _ROUNDING)))
            is_far[near[((points[near] - point) ** 2).sum(axis=1) < spacing_m**2]] = False
    return spots


def box_spots(box_m: Sequence[tuple[float, float]], spacing_m: float, solid: Solid) -> list[Spot]:
    """Return free spots on a lattice in a box, outside of the car's body, that face away from its middle."""
    axes = [
        low + spacing_m * np.arange(math.floor((high - low) / spacing_m + 1e-9) + 1) for low, high in box_m
    ]
    spots = list[Spot]()
    for x, y, z in np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3).round(6).tolist():
        status = mount_status((x, y, z), solid)
        if not (status.inside or status.below_ground):
            spots.append(Spot(np.array([x, y, z]), np.array([x, y, 0.0]) / (math.hypot(x, y) or 1.0), True))
    return spots


def _is_free(point_m: Doubles, normal: Doubles, tree: Tree, every: NDArray[np.bool_]) -> bool:
    """Return whether nothing of the car lies ahead of a surface."""
    from riglens.core.kernels.body.solid import meet_listed  # the compiler

    most = np.full(1, np.inf)
    met = meet_listed(point_m + _LIFT_M * normal, normal[None], tree, every, most, 0.0)[0]
    return bool(np.isinf(met[0]))
