"""The ego car's parametric body as VTK draws it: one mesh per material."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import pyvista as pv

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.body import arch_walls, body_parts
from riglens.widgets.drawing.surface import drawn, join

Parts = Mapping[str, pv.PolyData]
"""Surfaces by the name of their material."""


@lru_cache(maxsize=4)
def drawn_parts(vehicle: Vehicle) -> Parts:
    """Return the surfaces of `riglens.core.vehicle.body.body_parts`, with closed wheel arches; raise InputError for an
    unknown body."""
    parts = {material: drawn(surface) for material, surface in body_parts(vehicle)}
    return parts | {"dark": join([parts["dark"], *map(drawn, arch_walls(vehicle))])}
