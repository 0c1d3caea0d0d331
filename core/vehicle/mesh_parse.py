"""Read a mesh file and print its arrays: the part of reading that runs in a separate process.

A mesh file is foreign input and may make a parser loop, eat memory or crash; then only this process ends.
Run as `python -m riglens.core.vehicle.mesh_parse FILE`; the arrays go to standard output as an npz archive, a
complaint to standard error with exit code 2.
"""

from __future__ import annotations

import io
import logging
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.resolvers import Resolver

from riglens.core.errors import InputError
from riglens.core.limited_process import serve
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.vehicle.mesh_structure import GLTF, require_readable_structure
from riglens.core.vehicle.parts import part_called

MAX_BYTES = 200_000_000
MAX_TRIANGLES = 500_000
MAX_MEMORY_BYTES = 6 << 30
_PICTURES = (
    ".png",
    ".jpg",
    ".jpeg",
    ".webp",
    ".bmp",
    ".tga",
    ".tif",
    ".tiff",
    ".gif",
    ".ktx2",
    ".dds",
    ".hdr",
)
_Y_UP = np.array([[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
_PLAIN = 170
FARTHEST = 1e9
Arrays = dict[str, NDArray[Any]]


class FolderResolver(Resolver):
    """Resolver that gives a parser the files that a mesh names, if they lie in its folder or below; textures are not
    read.

    Parsers silently skip files that they are refused, so the first refusal is kept in `refused`.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder.resolve()
        self._left = MAX_BYTES
        self.refused = ""

    def get(self, key: Any) -> bytes:
        """Return the content of a file; OSError when it is missing or not needed."""
        name = unquote(str(key)).strip().replace("\\", "/")
        path = (self._folder / name).resolve()
        if urlparse(name).scheme or not path.is_relative_to(self._folder):
            self._refuse(f"must refer to files in its own folder (got '{name[:80]}')")
        if path.suffix.lower() in _PICTURES:
            raise FileNotFoundError(f"{name}: textures are not read")
        if not path.is_file():
            raise FileNotFoundError(name)
        self._left -= path.stat().st_size
        if self._left < 0:
            self._refuse(f"names files of more than {MAX_BYTES / 1e6:g} MB")
        return path.read_bytes()

    def _refuse(self, why: str) -> None:
        self.refused = self.refused or why
        raise PermissionError(why)

    def keys(self) -> list[str]:
        """Return the names of the available files; parsers never need the list."""
        return []

    def namespaced(self, namespace: str) -> FolderResolver:
        """Return this resolver, since the same rules hold below a subfolder."""
        return self

    def write(self, name: str, data: Any) -> None:
        """Raise PermissionError, since reading writes nothing."""
        raise PermissionError(name)


def parse_mesh(path: Path) -> Arrays:
    """Return the arrays points, normals, triangles, perhaps colours and parts of a mesh file; InputError with the
    reason."""
    resolver = FolderResolver(path.parent)
    suffix = path.suffix.lower()
    try:
        content = path.read_bytes()
        require_readable_structure(content, suffix)
        scene = trimesh.load_scene(
            io.BytesIO(content), file_type=suffix[1:], resolver=resolver, allow_remote=False, process=False
        )
        if resolver.refused:
            raise InputError(resolver.refused)
        parts = _parts(scene, merges=suffix not in GLTF)
        if not parts:
            raise InputError("contains no triangles")
        return _joined(parts, upright=suffix in GLTF)
    except InputError:
        raise
    except MemoryError as error:
        raise InputError("needs more memory than a car body may take") from error
    except Exception as error:  # a parser fed with damaged bytes raises a dozen kinds of error
        why = shortened(f"{type(error).__name__}: {error}", 160)
        raise InputError(resolver.refused or f"not a readable {suffix} file ({why})") from error


def _parts(scene: Any, merges: bool) -> list[tuple[Any, NDArray[np.float64], int]]:
    """Return every mesh of the scene with its place in it, (4, 4), and the part of the car that node, mesh or material
    are called after; instances count as often as they are drawn.

    merges: whether vertices of the same place become one, as formats need that write a vertex for each triangle.
    """
    parts, triangles = [], 0
    for name, mesh in scene.geometry.items():
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            _check_indices(mesh, str(name))
            if merges:
                mesh.process()
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            triangles += len(mesh.faces)
            if triangles > MAX_TRIANGLES:
                raise InputError(f"has more than {MAX_TRIANGLES:,} triangles; simplify it first")
            material = getattr(getattr(mesh.visual, "material", None), "name", None)
            called = (part_called(str(one)) for one in (material or "", name, node))
            parts.append((mesh, np.asarray(place, dtype=np.float64), next(filter(None, called), 0)))
    return parts


def _check_indices(mesh: Any, name: str) -> None:
    """Raise InputError when a triangle names a vertex that is not there; numpy counts negative ones from the end."""
    faces, count = np.asarray(mesh.faces), len(mesh.vertices)
    wrong = np.argwhere((faces < 0) | (faces >= count))
    if len(wrong):
        row, corner = wrong[0]
        where = f"mesh '{shortened(name, 40)}': triangle {row + 1} of {len(faces):,}"
        raise InputError(f"{where}: vertex numbers must be 0 to {count - 1} (got {faces[row, corner]})")


def _joined(parts: list[tuple[Any, NDArray[np.float64], int]], upright: bool) -> Arrays:
    """Return all parts as one mesh; glTF's y up, z ahead and x left become z up, x ahead and y left."""
    pieces: dict[str, list[NDArray[Any]]] = {
        "points": [],
        "normals": [],
        "triangles": [],
        "colours": [],
        "parts": [],
    }
    count, coloured = 0, any(_colours(mesh) is not None for mesh, *_ in parts)
    for mesh, place, part in parts:
        place = _Y_UP @ place if upright else place
        corners, normals, triangles = _creased(mesh)
        points = mesh.vertices[corners] @ place[:3, :3].T + place[:3, 3]
        turned = normals @ np.linalg.pinv(place[:3, :3])
        found = _colours(mesh)
        colours = np.full((len(mesh.vertices), 3), _PLAIN, np.uint8) if found is None else found
        pieces["points"].append(points)
        pieces["normals"].append(turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12))
        pieces["triangles"].append(triangles + count)
        pieces["colours"].append(colours[corners])
        pieces["parts"].append(np.full(len(triangles), part))
        count += len(points)
    types = {
        "points": np.float32, "normals": np.float32, "triangles": np.int32, "colours": np.uint8, "parts": np.uint8,
    }  # fmt: skip
    arrays = {name: np.concatenate(pieces[name]).astype(kind) for name, kind in types.items()}
    if not coloured:
        del arrays["colours"]
    if not arrays["parts"].any():
        del arrays["parts"]
    if not np.isfinite(arrays["points"]).all() or np.abs(arrays["points"]).max() > FARTHEST:
        raise InputError(f"has points that are not finite numbers, or beyond {FARTHEST:g}")
    return arrays


def _creased(mesh: Any) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices as (vertex numbers, normals, triangles over them), doubled where an edge is sharp.

    A corner whose face leans away from the vertex normal by more than 40 degrees is shaded flat.
    """
    faces, flat, smooth = np.asarray(mesh.faces), mesh.face_normals, mesh.vertex_normals
    is_sharp = (flat[:, None, :] * smooth[faces]).sum(axis=2) < np.cos(np.radians(40.0))
    triangles = faces.copy()
    triangles[is_sharp] = len(smooth) + np.arange(int(is_sharp.sum()))
    own = np.broadcast_to(flat[:, None, :], (*faces.shape, 3))[is_sharp]
    corners = np.concatenate([np.arange(len(smooth)), faces[is_sharp]])
    return corners, np.concatenate([smooth, own]), triangles


def _colours(mesh: Any) -> NDArray[np.uint8] | None:
    """Colour per vertex (n, 3) from vertices, faces or the material's plain colour; textures are not read."""
    visual = mesh.visual
    if visual.kind in ("vertex", "face"):
        return np.asarray(visual.vertex_colors[:, :3], dtype=np.uint8)
    material = getattr(visual, "material", None)
    if material is None:
        return None
    return np.tile(np.asarray(material.main_color[:3], dtype=np.uint8), (len(mesh.vertices), 1))


def packed_mesh(path: Path) -> bytes:
    """Return the arrays of a mesh file as an npz archive; InputError with the reason."""
    packed = io.BytesIO()
    np.savez(packed, **parse_mesh(path))  # type: ignore[arg-type]
    return packed.getvalue()


if __name__ == "__main__":
    logging.disable()
    sys.exit(serve(lambda: packed_mesh(Path(sys.argv[1])), MAX_MEMORY_BYTES))
