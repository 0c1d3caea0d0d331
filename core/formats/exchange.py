"""Rig formats by name: detecting, reading and writing them."""

from __future__ import annotations

import difflib
import os
import time
from functools import cache
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.extensions import extended, first_fitting
from riglens.core.files import atomic_folder, atomic_write
from riglens.core.formats.a2d2 import A2D2
from riglens.core.formats.airsim import AIRSIM
from riglens.core.formats.apollo import APOLLO
from riglens.core.formats.argoverse import ARGOVERSE
from riglens.core.formats.autoware import AUTOWARE
from riglens.core.formats.basalt import BASALT
from riglens.core.formats.base import Exported, Format
from riglens.core.formats.boreas import BOREAS
from riglens.core.formats.carla_agent import CARLA_AGENT
from riglens.core.formats.carla_objects import CARLA
from riglens.core.formats.carla_toml import CARLA_TOML
from riglens.core.formats.datasets import DAIR, DDAD, ONCE, OPV2V, ZOD
from riglens.core.formats.driveworks import DRIVEWORKS
from riglens.core.formats.euroc import EUROC
from riglens.core.formats.fast_livo import FAST_LIVO
from riglens.core.formats.kalibr import KALIBR
from riglens.core.formats.kitti import KITTI
from riglens.core.formats.kitti360 import KITTI_360
from riglens.core.formats.lgsvl import LGSVL
from riglens.core.formats.mmdet3d import MMDET3D
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.nuscenes import NUSCENES
from riglens.core.formats.opencv_yaml import OPENCV
from riglens.core.formats.osi import OSI
from riglens.core.formats.pandaset import PANDASET
from riglens.core.formats.report import OpenedRig
from riglens.core.formats.riglens import RIGLENS
from riglens.core.formats.sdf_model import SDF
from riglens.core.formats.slam import LIO_SAM, ORB_SLAM, R3LIVE, VLCAL
from riglens.core.formats.source import FOREIGN_ENDINGS, YAML, Source
from riglens.core.formats.urdf import URDF
from riglens.core.reading_time import MAX_RIG_S, Clock, ReadingTime
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened, shown_path
from riglens.core.scene.readers.common import BoxFormat

FORMATS = {
    format_.name: format_
    for format_ in (
        RIGLENS, NUSCENES, AUTOWARE, URDF, CARLA, CARLA_TOML, DRIVEWORKS, PANDASET, ARGOVERSE, KALIBR, EUROC,
        FAST_LIVO, APOLLO, OPENCV, KITTI, KITTI_360, BOREAS, AIRSIM, MMDET3D, CARLA_AGENT, OSI, BASALT, A2D2,
        SDF, ONCE, ZOD, DDAD, DAIR, OPV2V, LGSVL, ORB_SLAM, LIO_SAM, R3LIVE, VLCAL,
    )
}  # fmt: skip
"""The built-in formats by name on the command line; RigLens' own comes first."""
GROUP = "riglens.formats"


@cache
def formats() -> dict[str, Format]:
    """Return the built-in formats by name, then those of installed packages."""
    return extended(GROUP, FORMATS, Format, beside=(BoxFormat,))


def readable() -> tuple[str, ...]:
    """Return the names of the formats that can be read."""
    return tuple(name for name, format_ in formats().items() if format_.reads)


def writable() -> tuple[str, ...]:
    """Return the names of the formats that can be written."""
    return tuple(name for name, format_ in formats().items() if format_.writes)


def endings() -> tuple[str, ...]:
    """Return the endings of files that may hold a rig."""
    return tuple(dict.fromkeys(suffix for format_ in formats().values() for suffix in format_.suffixes))


def detect(source: Source) -> Format:
    """Return the format of a file or folder; a YAML file that could be a rig is read as one, for its error message.

    Raise InputError when there is no such file, and when no format fits.
    """
    if not source.path.exists():
        raise InputError(f"{source.where}: no such file or folder")
    if RIGLENS.fits(source):
        return RIGLENS
    found = next((format_ for format_ in FORMATS.values() if format_.fits(source)), None)
    if found is None:
        added = (format_ for name, format_ in formats().items() if name not in FORMATS)
        found = first_fitting(GROUP, added, lambda format_: format_.fits(source))
    if found is not None:
        return found
    if _is_clearpath(source):
        raise InputError(
            f"{source.where}: a robot.yaml of Clearpath names the mounts of its sensors, not their places: write the "
            "robot with 'ros2 run clearpath_generator_common generate_description -s FOLDER' and 'xacro "
            "robot.urdf.xacro -o robot.urdf', and read robot.urdf"
        )
    if not source.is_folder and source.suffix not in FOREIGN_ENDINGS and not _is_other_yaml(source):
        return RIGLENS
    inside = _rig_inside(source) if source.is_folder else None
    if inside is not None:
        raise InputError(f"{source.where}: a folder; name the rig in it, such as {inside.path.name}")
    raise InputError(f"{source.where}: not a rig in a known format (known: {', '.join(readable())})")


_MOST_TRIED = 16


def _rig_inside(folder: Source) -> Source | None:
    """Return the first file of a folder that is a rig of a known format, None without one."""
    paths = sorted(path for path in folder.path.iterdir() if path.suffix in endings() and path.is_file())
    files = map(folder.another, paths[:_MOST_TRIED])
    return next((one for one in files if any(known.fits(one) for known in formats().values())), None)


def _is_other_yaml(source: Source) -> bool:
    """Return whether this is a YAML mapping without any field that identifies a rig."""
    own = {"riglens", "vehicle", "sensors", "name"}
    return source.suffix in YAML and source.yaml.is_mapping and not own & source.yaml.raw.keys()


def _is_clearpath(source: Source) -> bool:
    """Return whether this is Clearpath's robot.yaml; its mounts stand where descriptions in ROS packages have them.

    Source: docs.clearpathrobotics.com, Robot YAML: serial_number, version, system, platform, sensors.
    """
    if source.is_folder or source.suffix not in YAML or not source.yaml.is_mapping:
        return False
    keys = source.yaml.raw.keys()
    return "serial_number" in keys and bool({"system", "platform", "mounts", "sensors"} & keys)


def may_be_foreign(source: Source) -> bool:
    """Return whether an existing file or folder may hold a rig of another program, without parsing it."""
    is_data = source.is_folder or source.suffix in endings()
    return source.path.exists() and is_data and not RIGLENS.fits(source)


def read_rig(
    path: str | os.PathLike[str] | Source,
    name: str | None = None,
    options: ReadOptions | None = None,
    clock: Clock = time.monotonic,
) -> OpenedRig:
    """Return the rig in a file or folder and the report on it; the format is detected unless `name` gives it.

    All its files together may take MAX_RIG_S by the `clock`.

    Raise InputError with file, field, what was found and what is accepted.
    """
    if not isinstance(path, Source):
        path = Source(path, ReadingTime(shown_path(path), MAX_RIG_S, clock))
    source = path
    format_ = detect(source) if name is None else format_called(name, readable())
    if not source.path.exists():
        raise InputError(f"{source.where}: no such file or folder")
    if options is not None and options.kit is not None and format_ is not AUTOWARE:
        raise InputError(f"applies to an Autoware kit only (got {format_.title})", "kit")
    return format_.read(source, options or ReadOptions())


def write_rig(rig: Rig, path: str | os.PathLike[str], name: str | None = None) -> Exported:
    """Write a rig; the format follows from the ending of the path unless `name` gives it.

    One file, or a folder written whole or not at all. Raise InputError when it cannot be written.
    """
    format_ = format_for(Path(path)) if name is None else format_called(name, writable())
    exported = format_.write(rig)
    if format_.is_folder:
        atomic_folder(path, {file: text.encode("utf-8") for file, text in exported.files.items()})
    else:
        (text,) = exported.files.values()
        with atomic_write(path) as stream:
            stream.write(text.encode("utf-8"))
    return exported


def format_called(name: str, accepted: tuple[str, ...]) -> Format:
    """Return the format of that name; raise an InputError that lists the accepted ones."""
    if name in accepted:
        return formats()[name]
    close = difflib.get_close_matches(name, accepted, n=1)
    hint = f"did you mean {close[0]}?; " if close else ""
    raise InputError(f"unknown format '{shortened(name)}' ({hint}known: {', '.join(accepted)})")


def format_for(path: Path) -> Format:
    """Return the format of a file's ending; raise InputError when several write files of that ending, or none."""
    for format_ in formats().values():
        if format_.writes and path.name.lower().endswith(format_.endings or ("\n",)):
            return format_
    raise InputError(
        f"must name the format, which the ending of {shown_path(path)} does not: {', '.join(writable())}",
        "target_format",
    )
