"""A car body from a mesh file as plain arrays, and its placement in the vehicle frame."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.config import JsonDict

from riglens.core.geometry import rotation_from_rpy_deg
from riglens.core.plain import Frozen
from riglens.core.sensors.base import Angles3, Position

METRES: JsonDict = {"unit": "m", "step": 0.05}


class MeshPlacement(Frozen):
    """Placement of a mesh file in the vehicle frame: scaled about its origin, rotated, then moved (metres)."""

    scale: Annotated[
        float,
        Field(
            allow_inf_nan=False, ge=1e-6, le=1e6, title="Mesh scale", description="0.001 for a mesh in millimetres.",
            json_schema_extra={"step": 0.1},
        ),
    ] = 1.0  # fmt: skip
    rpy_deg: Annotated[
        Angles3, Field(title="Mesh turned", description="Roll, pitch, yaw.", json_schema_extra={"step": 5.0})
    ] = (0.0, 0.0, 0.0)
    offset: Annotated[
        Position,
        Field(title="Mesh moved", description="x, y, z; after scale and turn.", json_schema_extra=METRES),
    ] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """Triangles (m, 3) int32 over points (n, 3) in metres with unit normals (n, 3), float32, and colours.

    `colours` are (n, 3) uint8, or None if the file says nothing about them; `parts` (m,) uint8, numbers in
    `core/vehicle/parts.py`, or None if it names none.
    """

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    triangles: NDArray[np.int32]
    colours: NDArray[np.uint8] | None = None
    parts: NDArray[np.uint8] | None = None

    @cached_property
    def sha256(self) -> str:
        """Hash of the shape: points and triangles."""
        return hashlib.sha256(self.points.tobytes() + self.triangles.tobytes()).hexdigest()

    def placed(self, placement: MeshPlacement) -> BodyMesh:
        """Return the mesh in the vehicle frame, metres: scaled about its origin, rotated, then moved."""
        rotation = rotation_from_rpy_deg(placement.rpy_deg)
        points = placement.scale * (self.points.astype(np.float64) @ rotation.T) + placement.offset
        normals = self.normals @ rotation.T.astype(np.float32)
        return BodyMesh(points.astype(np.float32), normals, self.triangles, self.colours, self.parts)

    def coarse(self, cells: int) -> BodyMesh:
        """Return about the same shape from fewer points: those within a cell of a lattice become one.

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
        some = (a != b) & (b != c) & (c != a)
        kept, parts = triangles[some], None if self.parts is None else self.parts[some]
        colours = None if self.colours is None else self.colours[first]
        return BodyMesh(self.points[first], self.normals[first], kept, colours, parts)
