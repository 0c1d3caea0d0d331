"""The car's surfaces in the user's cache folder: nothing would delay the first picture more than building them."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.cache_folder import cache_folder, keep
from riglens.core.files import atomic_write, open_regular
from riglens.core.vehicle.surface import Painted, Surface

_MADE_BY = ("body.py", "profile.py", "profiles.py", "wheels.py", "surface.py")
"""The sources that the surfaces are made by, relative to this folder."""
Arrays = dict[str, NDArray[Any]]


def stored_surfaces(name: str, build: Callable[[], Painted], of: object = None) -> Painted:
    """Return the result of `build` without empty meshes; from the cache if the same code built it from the same `of`.

    There is one file per name. It is replaced when the code changes, or `of`, whose text says what the surfaces depend
    on, and when it is damaged.
    """
    path = cache_folder() / f"car-{name}.npz"
    maker = f"{_maker()} {of!r}"
    with contextlib.suppress(Exception):  # damaged bytes make numpy and zipfile raise a dozen kinds of error
        return _load(path, maker)
    painted = [(material, mesh) for material, mesh in build() if len(mesh.triangles)]
    keep(path, lambda place: _save(place, maker, painted))
    return painted


def _maker() -> str:
    """Return a checksum of everything that the surfaces depend on: the modules that model them, and numpy."""
    digest = hashlib.sha256(np.__version__.encode())
    for name in _MADE_BY:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest.hexdigest()


def _save(path: Path, maker: str, painted: Painted) -> None:
    meshes = [mesh for _, mesh in painted]
    parts = [(material, len(mesh.points), len(mesh.triangles)) for material, mesh in painted]
    arrays: Arrays = {
        "parts": np.array(json.dumps(parts)),
        "points": np.concatenate([mesh.points for mesh in meshes]),
        "normals": np.concatenate([mesh.normals for mesh in meshes]),
        "triangles": np.concatenate([mesh.triangles for mesh in meshes]),
    }
    with atomic_write(path, "wb") as file:
        np.savez(file, check=np.array(_check(maker, arrays)), **arrays)  # type: ignore[arg-type]


def _load(path: Path, maker: str) -> Painted:
    with open_regular(path, "a cached car body") as file, np.load(file, allow_pickle=False) as archive:
        arrays: Arrays = {name: archive[name] for name in ("parts", "points", "normals", "triangles")}
        if str(archive["check"]) != _check(maker, arrays):
            raise ValueError("damaged, or made by other code")
    points, normals, triangles = arrays["points"], arrays["normals"], arrays["triangles"]
    painted: Painted = []
    for material, point_count, count in json.loads(str(arrays["parts"])):
        mesh = Surface(points[:point_count].copy(), normals[:point_count].copy(), triangles[:count].copy())
        points, normals, triangles = points[point_count:], normals[point_count:], triangles[count:]
        painted.append((str(material), mesh))
    return painted


def _check(maker: str, arrays: Arrays) -> str:
    digest = hashlib.sha256(maker.encode())
    for array in arrays.values():
        digest.update(array.tobytes())
    return digest.hexdigest()
