"""Footprints of a rig as plain data: lengths in metres, outlines in the vehicle frame, angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from riglens.core.footprint.detail import MEASURED, focal_mm, pixel_um, pixels_on, px_per_deg
from riglens.core.footprint.ground import EN_62676_4, Footprint, footprint, has_footprint
from riglens.core.footprint.overlap import bearings, overlaps
from riglens.core.plain import to_plain
from riglens.core.rig.model import FORMAT_VERSION, Camera, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.vehicle.housings import with_housings
from riglens.core.vehicle.solid import Solid, solid_of

_ON_AXIS = np.array([[1.0, 0.0, 0.0]])


def solid_rig(rig: Rig) -> Solid | None:
    """Return the solid car of a rig with its housings, or None if its mesh has not been read."""
    return None if rig.vehicle.lacks_mesh else with_housings(solid_of(rig.vehicle), rig.obstacles)


def footprints_of(rig: Rig, limits: Sequence[float] = EN_62676_4) -> tuple[Footprint, ...]:
    """Return the footprints of the enabled sensors that have one, without what the car hides."""
    solid = solid_rig(rig)
    return tuple(
        footprint(sensor, limits, solid) for sensor in rig.sensors if sensor.enabled and has_footprint(sensor)
    )


def footprints_document(rig: Rig, found: Sequence[Footprint]) -> dict[str, Any]:
    """Return footprints, and the bearings that neighbouring cameras share."""
    return {
        "riglens": FORMAT_VERSION,
        "rig": identity_of(rig),
        "sensors": [_sensor(one) for one in found],
        "overlaps": [to_plain(one) for one in overlaps(rig.enabled_cameras())],
    }


def _sensor(found: Footprint) -> dict[str, Any]:
    sensor, reach = found.sensor, found.reach_m
    document: dict[str, Any] = {
        "name": sensor.name,
        "kind": sensor.kind,
        "ground_from_m": None if reach is None else round(reach[0], 6),
        "ground_to_m": None if reach is None else round(reach[1], 6),
        "area_m2": round(found.area_m2, 6),
        "bands": [
            {
                "title": band.title,
                "px_per_m": None if math.isnan(band.limit) else band.limit,
                "area_m2": round(band.area_m2, 6),
                "outlines_m": [patch.round(4).tolist() for patch in band.patches],
            }
            for band in found.bands
        ],
    }
    return document | (_camera(sensor) if isinstance(sensor, Camera) else {})


def _camera(camera: Camera) -> dict[str, Any]:
    horizon = bearings(camera)
    return {
        "px_per_deg": float(px_per_deg(camera, _ON_AXIS)[0]),
        "focal_px": camera.intrinsics_px()[0],
        "focal_mm": focal_mm(camera),
        "pixel_um": pixel_um(camera),
        "bearings_deg": None if horizon is None else [horizon.from_deg, horizon.to_deg],
        "pixels_on": [
            {
                "class": one.cls,
                "distance_m": one.distance_m,
                "width_px": _known(one.width_px),
                "height_px": _known(one.height_px),
            }
            for cls in MEASURED
            for one in pixels_on(camera, cls)
        ],
    }


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
