"""The ego car's parametric body as VTK draws it: one mesh per material."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import pyvista as pv

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.body import body_parts
from riglens.widgets.drawing.surface import drawn


@dataclass(frozen=True)
class DrawnPart:
    """All surfaces of one material, as in `riglens.core.vehicle.body.BodyPart`."""

    material: str
    mesh: pv.PolyData


@lru_cache(maxsize=4)
def drawn_parts(vehicle: Vehicle) -> tuple[DrawnPart, ...]:
    """Return the surfaces of `riglens.core.vehicle.body.body_parts`; raise InputError for an unknown body."""
    return tuple(DrawnPart(part.material, drawn(part.surface)) for part in body_parts(vehicle))
