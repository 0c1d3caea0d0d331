"""A car body from a mesh file as plain arrays, and its placement in the vehicle frame."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3, rotation_from_rpy_deg
from riglens.core.rig.model import MeshPlacement, Vehicle

LEAST_CAR_M, MOST_CAR_M = 1.0, 30.0
"""Outside these lengths a mesh is most likely in another unit than metres; our choice."""
UNITS_M = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048, "metres": 1.0}
"""Units that mesh files are in, as scales of `vehicle.mesh`."""


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """Triangles (m, 3) int32 over points (n, 3) in metres with unit normals (n, 3), float32, and colours.

    `colours` are (n, 3) uint8, or None where the file says nothing about them.
    """

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    triangles: NDArray[np.int32]
    colours: NDArray[np.uint8] | None = None

    @cached_property
    def sha256(self) -> str:
        """Hash of the shape: points and triangles."""
        return hashlib.sha256(self.points.tobytes() + self.triangles.tobytes()).hexdigest()

    def placed(self, placement: MeshPlacement) -> BodyMesh:
        """The mesh in the vehicle frame, metres: scaled about its origin, turned, then moved."""
        rotation = rotation_from_rpy_deg(placement.rpy_deg)
        points = placement.scale * (self.points.astype(np.float64) @ rotation.T) + placement.offset
        normals = self.normals @ rotation.T.astype(np.float32)
        return BodyMesh(points.astype(np.float32), normals, self.triangles, self.colours)

    def coarse(self, cells: int) -> BodyMesh:
        """About the same shape from fewer points: those within a cell of a lattice become one.

        `cells` is how many cells the longest side of the mesh has. Rossignac and Borrel, "Multi-resolution 3D
        approximations for rendering complex scenes" (1993).
        """
        low = self.points.min(axis=0)
        edge = float(np.ptp(self.points, axis=0).max()) / cells or 1.0
        place = np.floor((self.points - low) / edge).astype(np.int64)
        key = (place[:, 0] << 42) | (place[:, 1] << 21) | place[:, 2]
        _, first, cluster = np.unique(key, return_index=True, return_inverse=True)
        triangles = cluster.reshape(-1)[self.triangles].astype(np.int32)
        a, b, c = triangles.T
        kept = triangles[(a != b) & (b != c) & (c != a)]
        colours = None if self.colours is None else self.colours[first]
        return BodyMesh(self.points[first], self.normals[first], kept, colours)


def mesh_size_m(mesh: BodyMesh, placement: MeshPlacement) -> Vec3:
    """Return length, width and height of a placed mesh: its extents along x, y and z of the vehicle frame, metres."""
    length_m, width_m, height_m = np.ptp(mesh.placed(placement).points.astype(np.float64), axis=0).tolist()
    return length_m, width_m, height_m


def is_car_size(size_m: Vec3) -> bool:
    """Return whether something of this length, width and height (metres) can be a car, whichever way it is turned."""
    return LEAST_CAR_M <= max(size_m) <= MOST_CAR_M


def fitted_scale(mesh: BodyMesh, vehicle: Vehicle) -> float | None:
    """Return the scale that makes a mesh as long as the vehicle, to six digits; None for a mesh without length."""
    length_m = mesh_size_m(mesh, vehicle.mesh)[0]
    scale = float(f"{vehicle.mesh.scale * vehicle.length / length_m:.6g}") if length_m > 0.0 else 0.0
    return scale if 1e-6 <= scale <= 1e6 else None


def unit_scales(size_m: Vec3, placement: MeshPlacement) -> dict[str, float]:
    """Return the units in which a mesh of this placed size would be a car's size, with the scale that each needs."""
    largest = max(size_m) / placement.scale
    return {unit: scale for unit, scale in UNITS_M.items() if is_car_size((largest * scale, 0.0, 0.0))}


def size_text(size_m: Vec3) -> str:
    """Return a size as "4.60 × 1.90 × 1.45 m"."""
    return " × ".join(f"{side_m:,.2f}" if side_m >= 0.1 else f"{side_m:.3g}" for side_m in size_m) + " m"


def size_remark(size_m: Vec3, placement: MeshPlacement) -> str:
    """Return what is odd about the size of a mesh, and what to do about it; empty for that of a car."""
    if is_car_size(size_m):
        return ""
    units = unit_scales(size_m, placement)
    hints = [f"{scale:g} if the file is in {unit}" for unit, scale in units.items()]
    return f"the mesh is {size_text(size_m)}; set vehicle.mesh.scale" + (
        f": {', '.join(hints)}" if hints else ""
    )
