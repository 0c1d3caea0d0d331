"""The car's surfaces in the user's cache folder: nothing would delay the first picture more than building them."""

from __future__ import annotations

import json
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np

from riglens.core.cache_folder import digest_of_files, stored
from riglens.core.vehicle.profile import BODIES
from riglens.core.vehicle.surface import Painted, Surface

_MADE_BY = ("body.py", "profile.py", "wheels.py", "surface.py")
"""The sources that the surfaces are made by, relative to this folder; beside them, the bodies."""


def stored_surfaces(name: str, build: Callable[[], Painted], of: object = None) -> Painted:
    """Return the result of `build` without empty meshes; from the cache if the same code built it from the same `of`.

    There is one file per name; the text of `of` says what the surfaces depend on besides the code and numpy.
    """
    sources = (Path(__file__).parent / module for module in _MADE_BY)
    maker = f"{np.__version__} {digest_of_files((BODIES, *sources))} {of!r}"
    return _unpacked(stored(f"car-{name}", maker, lambda: _packed(build())))


def _packed(painted: Painted) -> bytes:
    kept = [(material, mesh) for material, mesh in painted if len(mesh.triangles)]
    parts = [(material, len(mesh.points), len(mesh.triangles)) for material, mesh in kept]
    stream = BytesIO()
    np.savez(
        stream,
        parts=np.array(json.dumps(parts)),
        points=np.concatenate([mesh.points for _, mesh in kept]),
        normals=np.concatenate([mesh.normals for _, mesh in kept]),
        triangles=np.concatenate([mesh.triangles for _, mesh in kept]),
    )
    return stream.getvalue()


def _unpacked(content: bytes) -> Painted:
    with np.load(BytesIO(content), allow_pickle=False) as arrays:
        points, normals, triangles = arrays["points"], arrays["normals"], arrays["triangles"]
        parts = json.loads(str(arrays["parts"]))
    painted: Painted = []
    for material, point_count, count in parts:
        mesh = Surface(points[:point_count].copy(), normals[:point_count].copy(), triangles[:count].copy())
        points, normals, triangles = points[point_count:], normals[point_count:], triangles[count:]
        painted.append((str(material), mesh))
    return painted
