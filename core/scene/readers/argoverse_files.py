"""Recognise and locate the files of Argoverse 2 without loading the reader."""

from __future__ import annotations

from pathlib import Path

from riglens.core.geometry import Vec3

REAR_AXLE_M: Vec3 = (-1.34, 0.0, 0.33)
"""Place of the ego frame's origin in the vehicle frame, about: the centre of the rear axle. It is 0.33 m above the
ground (a maintainer in issue 286 of argoverse-api); the car is a Ford Fusion Hybrid, 4.87 m long."""

FILE_NAME = "annotations.feather"
_FEATHER_MAGIC = b"ARROW1"


def is_feather(path: Path) -> bool:
    """Return whether a file is a Feather file, by its first bytes or its name."""
    if path.suffix.lower() == ".feather":
        return True
    with path.open("rb") as file:
        return file.read(len(_FEATHER_MAGIC)) == _FEATHER_MAGIC


def find_logs(folder: Path) -> list[Path]:
    """Return the annotation files of a log, of a folder of logs, or of a folder of splits of logs; sorted."""
    for pattern in (FILE_NAME, f"*/{FILE_NAME}", f"*/*/{FILE_NAME}"):
        if found := sorted(file for file in folder.glob(pattern) if file.is_file()):
            return found
    return []
