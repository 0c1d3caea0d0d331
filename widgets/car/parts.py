"""The ego car's parametric body as VTK draws it: one mesh per material."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import pyvista as pv

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.body import body_parts
from riglens.widgets.drawing.surface import drawn

Parts = Mapping[str, pv.PolyData]
"""Surfaces by the name of their material."""


@lru_cache(maxsize=4)
def drawn_parts(vehicle: Vehicle) -> Parts:
    """Return the surfaces of `riglens.core.vehicle.body.body_parts`; raise InputError for an unknown body."""
    return {material: drawn(surface) for material, surface in body_parts(vehicle)}
