"""The car's body as triangles that hide what is behind them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Vehicle
from riglens.widgets.car.body import body_parts


@lru_cache(maxsize=2)
def body_triangles(vehicle: Vehicle) -> NDArray[np.float32]:
    """Return triangles (t, 3, 3) of everything but glass, metres, vehicle frame; raise InputError for unknown bodies.

    The same vehicle gives the same array, so that what is built from it need not be rebuilt.
    """
    found = [np.zeros((0, 3, 3), np.float32)]
    for part in body_parts(vehicle):
        if part.material != "glass":
            mesh = part.mesh.triangulate()
            found.append(np.asarray(mesh.points, np.float32)[mesh.regular_faces])
    return np.concatenate(found)
