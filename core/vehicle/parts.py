"""Name the parts of a car that a triangle belongs to, and find those that a housing covers. Vehicle frame, metres."""

from __future__ import annotations

import re
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.profile import BodyProfile, Region, profile_of
from riglens.core.vehicle.surface import polygon_distance
from riglens.core.vehicle.wheels import axles_x

Doubles = NDArray[np.float64]
Labels = NDArray[np.uint8]
PARTS = (
    "body", "glass", "head lamp", "tail lamp", "number plate", "shut line", "wheel", "wheel arch", "door", "lid",
    "door mirror",
)  # fmt: skip
"""Parts by number; "body" is the rest. Lids: bonnet, boot, tailgate, rear doors of a van or a box."""
_OF_MATERIAL = {
    "glass": "glass", "lamp": "head lamp", "tail": "tail lamp", "plate": "number plate", "gap": "shut line",
    "tyre": "wheel", "rim": "wheel",
}  # fmt: skip
_WORDS = (
    ("door mirror", r"mirror"),
    ("tail lamp", r"(tail|brake|rear|stop|reversing).?(lamp|light)"),
    ("head lamp", r"(head|fog|front|turn|day).?(lamp|light)|lamps?|lights|indicator"),
    ("number plate", r"(number|licen[cs]e|registration).?plate"),
    ("glass", r"glass|wind(ow|screen|shield)"),
    ("wheel arch", r"(wheel.?)?arch"),
    ("wheel", r"wheel|tyre|tire|rim"),
    ("lid", r"hood|bonnet|trunk|boot|tail.?gate|hatch|lid"),
    ("door", r"door"),
    ("shut line", r"shut.?line|panel.?gap"),
)
"""Words by which meshes and materials of a file name parts, the first that fits: our choice."""
_SIDES, _MIRROR_M, _ARCH_M = 0.45, 0.03, 0.01
"""Share of a normal that makes a surface a side, and margins of mirrors and arches."""


def part_called(name: str) -> int:
    """Return the number of the part that a mesh or a material of a file is called after; 0 for the rest."""
    found = (part for part, words in _WORDS if re.search(rf"(?<![a-z])({words})s?(?![a-z])", name.lower()))
    return PARTS.index(next(found, "body"))


def parts_of_profile(
    vehicle: Vehicle, triangles_m: Doubles, materials: Collection[str], of: Labels
) -> Labels:
    """Return the parts (t,) of the triangles (t, 3, 3) of a built-in body with materials `of` (t,)."""
    profile = profile_of(vehicle.body)
    scale = np.array([vehicle.length, vehicle.width, vehicle.height])
    scale = scale / [profile.length_m, profile.width_m, profile.height_m]
    corners = triangles_m / scale
    middles = corners.mean(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    found = np.zeros(len(middles), np.uint8)
    for name, regions in (("door", profile.doors), ("lid", profile.lids)):
        for region in regions:
            found[_in_region(region, middles, normals)] = PARTS.index(name)
    found[_in_arch(profile, vehicle, triangles_m.mean(axis=1))] = PARTS.index("wheel arch")
    for number, material in enumerate(materials):
        if material in _OF_MATERIAL:
            found[of == number] = PARTS.index(_OF_MATERIAL[material])
    found[_in_mirror(profile, middles)] = PARTS.index("door mirror")
    return found


def _in_region(region: Region, middles: Doubles, normals: Doubles) -> NDArray[np.bool_]:
    along = {"x": middles[:, 0], "y": np.abs(middles[:, 1]), "z": middles[:, 2]}
    flat = np.stack([along[axis] for axis in region.plane], axis=1)
    axis, sign = "xyz".index(region.facing.strip("+-|")), -1.0 if region.facing[0] == "-" else 1.0
    share, away = sign * normals[:, axis], sign * middles[:, axis]
    if region.facing == "|y|":
        share, away = np.abs(share), np.abs(away)
    inside = polygon_distance(flat, region.polygon) <= 0.0
    return np.asarray(inside & (share >= _SIDES) & (away >= region.beyond_m))


def _in_arch(profile: BodyProfile, vehicle: Vehicle, middles_m: Doubles) -> NDArray[np.bool_]:
    """Return which places lie within a wheel arch or on its lip."""
    scale = vehicle.height / profile.height_m
    reach = scale * (profile.arch_radius_m + profile.arch_lip_m) + _ARCH_M
    inner = vehicle.width / 2.0 - scale * (max(profile.wheel_width_m) + 0.15)
    found = np.zeros(len(middles_m), np.bool_)
    for x in axles_x(profile, vehicle):
        away = np.hypot(middles_m[:, 0] - x, middles_m[:, 2] - scale * profile.wheel_radius_m)
        found |= (away <= reach) & (np.abs(middles_m[:, 1]) >= inner)
    return found


def _in_mirror(profile: BodyProfile, middles: Doubles) -> NDArray[np.bool_]:
    """Return which places lie in a door mirror or on an arm of it."""
    middle, radii = np.array(profile.mirror_m), np.array(profile.mirror_radii_m) + _MIRROR_M
    boxes = [(middle - radii, middle + radii)]
    boxes += [(np.array(arm.low), np.array(arm.high)) for arm in profile.mirror_arms]
    places = middles * [1.0, 0.0, 1.0] + np.abs(middles) * [0.0, 1.0, 0.0]
    inside = [((places >= low) & (places <= high)).all(axis=1) for low, high in boxes]
    return np.asarray(np.any(inside, axis=0))


def overlaps(half_m: Doubles, triangles_m: Doubles) -> NDArray[np.bool_]:
    """Return which triangles (t, 3, 3) meet a box of half sides (3,) around the origin, along the axes.

    Two convex bodies are apart where an axis separates them: one of the box's, the triangle's normal, or the product
    of an axis with an edge (Akenine-Möller, "Fast 3D triangle-box overlap testing", 2001).
    """
    met = (triangles_m.min(axis=1) <= half_m).all(axis=1) & (triangles_m.max(axis=1) >= -half_m).all(axis=1)
    some = triangles_m[met]
    edges = np.roll(some, -1, axis=1) - some
    normals = np.cross(edges[:, 0], edges[:, 1])[:, None]
    products = np.cross(np.eye(3)[:, None], edges[:, None]).reshape(-1, 9, 3)
    axes = np.concatenate([normals, products], axis=1)
    along, reach = np.einsum("tck,tak->tac", some, axes), np.abs(axes) @ half_m
    met[met] = ((along.min(axis=2) <= reach) & (along.max(axis=2) >= -reach)).all(axis=1)
    return np.asarray(met)
