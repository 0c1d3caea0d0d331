"""A car body from a mesh file as plain arrays, and its placement in the vehicle frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import rotation_from_rpy_deg
from riglens.core.rig.model import MeshPlacement


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """Triangles (m, 3) int32 over points (n, 3) in metres with unit normals (n, 3), float32, and colours.

    `colours` are (n, 3) uint8, or None where the file says nothing about them.
    """

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    triangles: NDArray[np.int32]
    colours: NDArray[np.uint8] | None = None

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
