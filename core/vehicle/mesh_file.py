"""Mesh files of car bodies: where they lie, and reading them without trusting them."""

from __future__ import annotations

import contextlib
import io
import stat
from collections.abc import Callable
from pathlib import Path

import numpy as np

from riglens.core.errors import InputError
from riglens.core.limited_process import answer_of
from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import Rig
from riglens.core.vehicle.mesh import mesh_size_m, size_remark

MAX_BYTES = 200_000_000
SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".stl")
TIME_LIMIT_S = 120.0


def mesh_path(body: str, folder: Path | None) -> Path:
    """Return the path of a vehicle's mesh file; `vehicle.body` is relative to the folder of the rig file."""
    path = Path(body)
    with contextlib.suppress(RuntimeError):  # ~name where nobody has that name: a folder may be called so
        path = path.expanduser()
    return path if path.is_absolute() or folder is None else folder / path


def mesh_name(path: Path, folder: Path | None) -> str:
    """Return how a rig file in a folder names a mesh: relative to the folder if it lies below it, else in full."""
    path = path.absolute()
    if folder is not None and path.is_relative_to(folder.absolute()):
        path = path.relative_to(folder.absolute())
    return path.as_posix()


def with_full_mesh_path(rig: Rig, folder: Path | None) -> Rig:
    """Return the rig of a file in a folder, whose mesh, if it has one, is found from any folder."""
    vehicle = rig.vehicle
    if not vehicle.has_mesh_file or folder is None:
        return rig
    body = str(mesh_path(vehicle.body, folder).resolve())
    return rig.model_copy(update={"vehicle": vehicle.model_copy(update={"body": body})})


def read_mesh(path: Path, still_wanted: Callable[[], object] = lambda: None) -> BodyMesh:
    """Read a mesh file in a separate process; the numbers are in the file's unit, z up, x forward.

    `still_wanted` is called repeatedly in the meantime; an exception from it stops the reading. Raises InputError
    that names the file: missing, of another kind, too large, damaged, or too slow to read.
    """
    where = f"vehicle.body: {path}" if str(path).isprintable() else f"vehicle.body: {str(path)!r}"
    if path.suffix.lower() not in SUFFIXES:
        accepted = "sedan, suv, van, truck or the path of a mesh file: " + ", ".join(SUFFIXES)
        raise InputError(f"vehicle.body must be {accepted} (got '{path.name}')")
    try:
        status = path.stat()
    except (OSError, ValueError) as error:
        raise InputError(f"{where}: no such file") from error
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{where}: cannot be read to its end")
    if status.st_size > MAX_BYTES:
        raise InputError(f"{where}: larger than {MAX_BYTES / 1e6:g} MB")
    packed = answer_of(
        "riglens.core.vehicle.mesh_parse", str(path.absolute()),
        where=where, time_limit_s=TIME_LIMIT_S, still_wanted=still_wanted,
    )  # fmt: skip
    return _unpacked(packed, where)


def _unpacked(packed: bytes, where: str) -> BodyMesh:
    try:
        with np.load(io.BytesIO(packed), allow_pickle=False) as arrays:
            return BodyMesh(
                arrays["points"], arrays["normals"], arrays["triangles"],
                arrays.get("colours"), arrays.get("parts"),
            )  # fmt: skip
    except Exception as error:  # the other process ended in the middle of its answer
        raise InputError(f"{where}: cannot be read: the reading process was interrupted") from error


def with_mesh_read(rig: Rig, folder: Path, tell: Callable[[str], object]) -> Rig:
    """Read the mesh that a rig of this folder names for its vehicle, None without one; an implausible size is reported
    in one line. InputError when it cannot be read."""
    vehicle = rig.vehicle
    if not vehicle.has_mesh_file:
        return rig
    mesh = read_mesh(mesh_path(vehicle.body, folder))
    remark = size_remark(mesh_size_m(mesh, vehicle.mesh), vehicle.mesh)
    if remark:
        tell(f"vehicle.body: {vehicle.body}: {remark}")
    return rig.with_body_mesh(mesh)
