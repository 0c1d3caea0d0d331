"""Rigs and sensor models: presets, files, formats of other programs, and the library."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from riglens.arguments import StrPath, require_kind, warn
from riglens.core.errors import InputError
from riglens.core.files import require_apart
from riglens.core.formats.opening import open_rig as open_any_rig
from riglens.core.geometry import Pose, triple
from riglens.core.rig import library
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig
from riglens.core.rig.plausible import implausible
from riglens.core.rig.presets import PRESETS
from riglens.core.rig.yaml.file import load_rig, new_rig_file
from riglens.core.sensors.base import Sensor
from riglens.results import Listing

if TYPE_CHECKING:
    from riglens.core.formats.report import Report


def open_rig(name_or_path: StrPath) -> Rig:
    """Open a preset by its name ("W+T"), a rig file, or a rig in another program's format, which is detected.

    What another program's file leaves open or RigLens cannot say, and what is implausible about the rig, is reported
    as a `RigLensWarning`. Raises InputError when there is no such preset or file, or when the file is wrong.
    """
    opened = open_any_rig(os.fspath(name_or_path))
    _warn_of_losses(opened.report)
    _warn_of_doubts(opened.rig)
    return opened.rig


def presets() -> tuple[str, ...]:
    """List the names of the built-in rigs."""
    return tuple(PRESETS)


def save_rig(rig: Rig, path: StrPath) -> None:
    """Write a rig file (YAML) that reads back to the same rig, bit for bit.

    Comments and layout of a rig file that is there already are kept. Raises InputError when the rig is not valid or
    the file cannot be written; an old file stays as it was then.
    """
    try:
        file = load_rig(path)
    except InputError:
        file = new_rig_file(rig)
    file.save(path, rig)


def convert(
    source: StrPath | Rig,
    target: StrPath,
    *,
    source_format: str | None = None,
    target_format: str | None = None,
    vehicle: Rig | None = None,
    rear_axle_x: float | None = None,
    origin_m: ArrayLike | None = None,
    token: str | None = None,
    kit: StrPath | None = None,
) -> Rig:
    """Write a rig in another program's format; return the rig that was written.

    What is approximated or left out is reported as a `RigLensWarning`. Raises InputError when reading or writing fails.

    Parameters
    ----------
    source, target
        A rig, or what `open_rig` takes; the file or folder to write.
    source_format, target_format
        Formats, named as for `riglens convert`, where the files do not determine them.
    vehicle, rear_axle_x, origin_m
        Rig with the vehicle to use, where the source has none; its rear axle, and the origin of the source in the
        vehicle frame, metres.
    token, kit
        Which rig of several in the source; folder of an Autoware kit's description.
    """
    from riglens.core.formats.mounts import ReadOptions  # many formats, which a preset does not need
    from riglens.jobs.converting import converted

    options = ReadOptions(
        None if vehicle is None else vehicle.vehicle,
        rear_axle_x,
        None if origin_m is None else triple(origin_m),
        token,
        None if kit is None else Path(kit),
    )
    if not isinstance(source, Rig):
        require_apart(target, (source,))
    rig, read, written = converted(source, source_format, target, target_format, options)
    _warn_of_losses(read)
    _warn_of_losses(written)
    _warn_of_doubts(rig)
    return rig


def _warn_of_losses(report: Report | None) -> None:
    if report is not None:
        for remark in (*report.of_kind("approximated"), *report.of_kind("ignored")):
            warn(f"{report.title}: {remark.kind}: {remark.sentence()}")


def _warn_of_doubts(rig: Rig) -> None:
    for line in implausible(rig):
        warn(f"{rig.name}: {line}")


# ---------------------------------------------------------------- sensor models


def sensors(kind: str | None = None) -> Listing:
    """List the sensor models of the library, all or those of a kind, with every figure and its source."""
    require_kind(kind)
    library = default_library()
    entries = library.entries(kind)
    rows = [{"model": one.name, "kind": one.kind, "maker": one.maker, "title": one.title} for one in entries]
    return Listing(f"Sensor models: {len(entries)}", library.document(entries), rows)


def use_libraries(*paths: StrPath) -> None:
    """Add sensor libraries of your own, as --library does, for this process and those that it starts."""
    library.use_libraries(Path(path) for path in paths)


def sensor(model: str, name: str, position_m: ArrayLike, rpy_deg: ArrayLike = (0.0, 0.0, 0.0)) -> Sensor:
    """Return a sensor of a library model in a pose; raise InputError for an unknown model."""
    return default_library().entry(model).sensor(name, Pose(position_m, rpy_deg))
