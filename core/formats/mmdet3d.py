"""MMDetection3D: infos of version 1, as JSON (import).

The infos are pickles, which are never loaded: a script in docs/formats-exchange.md writes them as JSON. An entry of
data_list holds images with cam2img (3 rows of 3 or 4) and cam2ego or lidar2cam, lidar_points with lidar2ego, (4, 4);
metres, cameras in optical axes. The ego frame is that of nuScenes, on the ground under the rear axle; infos without one
are in the axes of the LiDAR, x forward, y left, z up.
Source: MMDetection3D, tools/dataset_converters/update_infos_to_v2.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical, inverse
from riglens.core.formats.lenses import pinhole
from riglens.core.formats.matrices import projected, rigid
from riglens.core.formats.mounts import ON_ROOF, REAR_AXLE, Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened


def recognises(source: Source) -> bool:
    """Return whether this is a JSON mapping with a data_list whose entries have images or LiDAR points."""
    entries = source.json.raw.get("data_list") if source.json.is_mapping else None
    first = entries[0] if isinstance(entries, list) and entries else None
    return isinstance(first, dict) and bool({"images", "lidar_points"} & first.keys())


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras and the LiDAR of one entry: that of the index `options.token`, or the first."""
    notes = mounting.notes
    info = _entry(source, mounting.options.token, notes)
    points = info.get("lidar_points")
    has_ego = points is not None and "lidar2ego" in points
    mounting.origin = REAR_AXLE if has_ego else ON_ROOF
    root_SE3_lidar = (
        rigid(points.item("lidar2ego"), "lidar", notes) if points is not None and has_ego else np.eye(4)
    )
    for name, value in info.item("images").items() if "images" in info else ():
        _add_camera(name, value, root_SE3_lidar, mounting)
    if points is not None:
        mounting.add("lidar", "lidar", root_SE3_lidar)
    notes.converted("cameras from optical axes")
    return mounting.rig(source.name)


def _entry(source: Source, token: str | None, notes: Notes) -> Value:
    entries = source.json.item("data_list").elements()
    if token is not None and not (token.isdecimal() and int(token) < len(entries)):
        raise InputError(
            f"{source.where}: token must be an index from 0 to {len(entries) - 1} (got '{shortened(token)}')"
        )
    notes.read(f"entry {token or 0} of {len(entries)}", field="token" if len(entries) > 1 else "")
    return entries[int(token or 0)]


def _add_camera(name: str, value: Value, root_SE3_lidar: Matrix, mounting: Mounting) -> None:
    """Add a camera; one without a matrix or without a place is reported."""
    notes = mounting.notes
    if "cam2img" not in value or not ("cam2ego" in value or "lidar2cam" in value):
        notes.ignored("no cam2img, or neither cam2ego nor lidar2cam", name)
        return
    if "cam2ego" in value:
        pose = rigid(value.item("cam2ego"), name, notes)
    else:
        pose = root_SE3_lidar @ inverse(rigid(value.item("lidar2cam"), name, notes))
    rows = value.item("cam2img").elements()
    projection = np.array([row.numbers(len(rows[0].elements())) for row in rows[:3]])
    if projection.shape not in ((3, 3), (3, 4)):
        value.item("cam2img").refuse("a matrix of 3 rows of 3 or 4 numbers", "another one")
    pose = pose @ projected(value.item("cam2img"), projection)
    lens: dict[str, Any] = pinhole(projection)
    has_size = "width" in value and "height" in value
    lens["image"] = value.image() if has_size else mounting.unknown_image(name, (1600, 900), lens)
    mounting.add("camera", name, from_optical(pose), **lens)


MMDET3D = Format("mmdet3d", "MMDetection3D infos", (".json",), recognises, read)
