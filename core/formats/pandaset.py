"""PandaSet: static_extrinsic_calibration.yaml, and its JSON twin (import).

Every entry holds the transform from the Pandar64 on the roof to the sensor: p_sensor = R p_lidar + t, quaternions
w, x, y, z, metres; cameras in optical axes. The Pandar64 has x to the left, y BACKWARDS and z up. How high it
stands on the car is not in the file.
Source: pandaset-devkit, docs/static_extrinsic_calibration.yaml, whose cameras look where their names say only so.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical, inverse, rotation_from_wxyz, se3
from riglens.core.formats.lenses import brown_conrady
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.report import Notes
from riglens.core.formats.source import YAML, Source, Value
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Rig, Vehicle

PACIFICA = Vehicle(body="van", length=5.17, width=2.02, height=1.78, rear_axle_x=-1.5)
MAIN_LIDAR_M: Vec3 = (0.0, 0.0, 2.0)
"""Assumed position of the Pandar64: over the body centre, on a rack over the roof of a 1.78 m high car."""

IMAGE = (1920, 1080)
BODY_R_LIDAR: Matrix = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""From the Pandar64 (x left, y backwards, z up) to x forward, y left, z up."""

FRONT_GT = "front_gt"
GT_R_BODY: Matrix = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""From x forward, y left to the PandarGT's x right, y forward: its transform's y axis is what points ahead."""
_MODELS = {"main_pandar64": "Hesai Pandar64", FRONT_GT: "Hesai PandarGT"}


def recognises(source: Source) -> bool:
    """Return whether this is a YAML or JSON mapping whose entries have an extrinsic.transform."""
    root = source.json if source.suffix == ".json" else source.yaml
    entries = list(root.raw.values()) if root.is_mapping else []
    return bool(entries) and all(_has_transform(entry) for entry in entries)


def _has_transform(entry: object) -> bool:
    extrinsic = entry.get("extrinsic") if isinstance(entry, dict) else None
    return isinstance(extrinsic, dict) and "transform" in extrinsic


def read(source: Source, mounting: Mounting) -> Rig:
    """Return cameras and LiDARs around the Pandar64."""
    root = source.json if source.suffix == ".json" else source.yaml
    for name, value in root.items():
        _add(name, value, mounting)
    mounting.notes.converted(
        "from x left, y backwards and optical axes, quaternions w x y z and inverse transforms"
    )
    return mounting.rig("PandaSet")


def _add(name: str, value: Value, mounting: Mounting) -> None:
    transform = value.item("extrinsic").item("transform")
    rotation = transform.item("rotation")
    wxyz = rotation.field_numbers("w", "x", "y", "z")
    position = transform.item("translation").field_numbers("x", "y", "z")
    sensor_SE3_lidar = se3(rotation_from_wxyz(rotation, wxyz), np.array(position))
    root_SE3_sensor = se3(BODY_R_LIDAR, (0.0, 0.0, 0.0)) @ inverse(sensor_SE3_lidar)
    intrinsic = value.get("intrinsic")
    if intrinsic is None:
        if name == FRONT_GT:
            root_SE3_sensor = root_SE3_sensor @ se3(GT_R_BODY, (0.0, 0.0, 0.0))
            mounting.notes.converted("its own x right and y forward to x forward and y left", name)
        mounting.add("lidar", name, root_SE3_sensor, said=_MODELS.get(name))
        return
    lens = _lens(intrinsic, name, mounting.notes)
    lens["image"] = mounting.unknown_image(name, IMAGE, lens)
    mounting.add("camera", name, from_optical(root_SE3_sensor), **lens)


def _lens(intrinsic: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return image and lens from K, a list of 9 row by row, and D in the order of OpenCV: k1 k2 p1 p2 k3."""
    k = intrinsic.item("K").numbers(9)
    lens: dict[str, Any] = {"fx": k[0], "fy": k[4], "cx": k[2], "cy": k[5]}
    distortion = intrinsic.get("D")
    if distortion is None:
        return lens
    return lens | brown_conrady(distortion, distortion.numbers(), name, notes)


PANDASET = Format(
    "pandaset", "PandaSet calibration", (*YAML, ".json"), recognises, read, vehicle=PACIFICA,
    car="size of a Chrysler Pacifica, the car of PandaSet", origin=Origin("the Pandar64", lambda _: MAIN_LIDAR_M),
)  # fmt: skip
