"""Size and unit of a car body from a mesh file."""

from __future__ import annotations

import numpy as np

from riglens.core.geometry import Vec3
from riglens.core.rig.body_mesh import BodyMesh, MeshPlacement
from riglens.core.rig.model import Vehicle

LEAST_CAR_M, MOST_CAR_M = 1.0, 30.0
"""Outside these lengths a mesh is most likely in another unit than metres; our choice."""
UNITS_M = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048, "metres": 1.0}
"""Units that mesh files are in, as scales of `vehicle.mesh`."""


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
    """Return a remark on an implausible size of a mesh, with a remedy; empty for that of a car."""
    if is_car_size(size_m):
        return ""
    units = unit_scales(size_m, placement)
    hints = [f"{scale:g} if the file is in {unit}" for unit, scale in units.items()]
    return f"the mesh is {size_text(size_m)}; set vehicle.mesh.scale" + (
        f": {', '.join(hints)}" if hints else ""
    )
