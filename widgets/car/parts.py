"""The ego car's parametric body as VTK draws it: one mesh per material."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
import pyvista as pv

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.profile import profile_of
from riglens.core.vehicle.surface import Surface
from riglens.core.vehicle.wheels import OUTER_M, axles_x
from riglens.widgets.drawing.surface import drawn, join

Parts = Mapping[str, pv.PolyData]
"""Surfaces by the name of their material."""
_ON_EDGE_M, _INTO_HOUSING_M = 5e-3, 0.05


@lru_cache(maxsize=4)
def drawn_parts(vehicle: Vehicle) -> Parts:
    """Return the surfaces of `riglens.core.vehicle.body.body_parts`, with closed wheel arches; raise InputError for an
    unknown body."""
    surfaces = dict(body_parts(vehicle))
    parts = {material: drawn(surface) for material, surface in surfaces.items()}
    return parts | {"dark": join([parts["dark"], drawn(_arch_walls(surfaces["trim"], vehicle))])}


def _arch_walls(trim: Surface, vehicle: Vehicle) -> Surface:
    """Return walls from the edges of the wheel arches into the housings.

    The skin is drawn from outside alone: without them a look past a wheel goes through the car.
    """
    profile = profile_of(vehicle.body)
    scale = vehicle.height / profile.height_m
    edges = trim.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    x, z = trim.points[:, 0], trim.points[:, 2] - scale * profile.wheel_radius_m
    found = []
    for axle_x in axles_x(profile, vehicle):
        is_on_edge = np.abs(np.hypot(x - axle_x, z) - scale * profile.arch_radius_m) < _ON_EDGE_M
        found.append(edges[is_on_edge[edges].all(axis=1)])
    outer = trim.points[np.concatenate(found)]
    inner, deep = outer.copy(), vehicle.width / 2 - OUTER_M - _INTO_HOUSING_M
    inner[..., 1] = np.clip(inner[..., 1], -deep, deep)
    points = np.concatenate([outer, inner], axis=1).reshape(-1, 3)
    corners = np.array([[0, 1, 2], [1, 3, 2]], np.int64)
    triangles = (4 * np.arange(len(outer))[:, None, None] + corners).reshape(-1, 3)
    return Surface(points, np.tile([0.0, 0.0, -1.0], (len(points), 1)), triangles)
