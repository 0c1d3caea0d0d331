"""Audi A2D2: cams_lidars.json with cameras and LiDARs around the car (import).

Each sensor has a `view`: its origin, x-axis and y-axis in the car's frame, x forward, y left, z up, metres; cameras
look along their x-axis. CamMatrix is that of undistorted pictures; those of the camera, which are read here, have
CamMatrixOriginal and Distortion: k1 k2 p1 p2 k3 of a Telecam, k1 to k4 of a Fisheye. The box of the car in that frame
is its `ego-dimensions`. LiDARs are VLP-16 (Geyer et al., A2D2, arXiv 2004.06320).
Source: A2D2 tutorial, "Working with the configuration file" and "Working with view objects".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, se3
from riglens.core.formats.lenses import brown_conrady, kannala_brandt, pinhole
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.rig.model import Rig, Vehicle

Q7 = Vehicle(body="suv", length=5.05, width=1.97, height=1.74, rear_axle_x=-1.5)


def recognises(source: Source) -> bool:
    """Return whether this is a JSON mapping with cameras and LiDARs that have views."""
    root = source.json
    named = [root.get(key) for key in ("cameras", "lidars")] if root.is_mapping else []
    sensors = [one for group in named if group is not None and group.is_mapping for _, one in group.items()]
    return bool(sensors) and all("view" in one for one in sensors)


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras and LiDARs."""
    root, notes = source.json, mounting.notes
    if "vehicle" in root:
        _take_box(root.item("vehicle"), mounting)
    for name, value in root.item("cameras").items() if "cameras" in root else ():
        mounting.add("camera", name, _pose(value), **_lens(value, name, notes))
    for name, value in root.item("lidars").items() if "lidars" in root else ():
        mounting.add("lidar", name, _pose(value), said="Velodyne VLP-16")
    notes.converted("views from their x and y axes to roll, pitch, yaw")
    return mounting.rig(f"A2D2 {source.name}")


def _take_box(vehicle: Value, mounting: Mounting) -> None:
    """Take the car's size, and where the origin is in it, from its box."""
    sizes = vehicle.get("ego-dimensions")
    if sizes is None:
        return
    (back, front), (right, left), (low, high) = (sizes.item(f"{axis}-range").numbers(2) for axis in "xyz")
    if not (0.5 < front - back < 50.0 and 0.5 < left - right < 50.0 and 0.1 < high - low < 50.0):
        sizes.refuse("ranges of a car's length, width and height in metres", "others")
    rear_axle_x = round(-(back + front) / 2.0, 9)  # the origin is over the rear axle
    car = Vehicle(
        body="suv", length=round(front - back, 9), width=round(left - right, 9), height=round(high - low, 9),
        rear_axle_x=rear_axle_x,
    )  # fmt: skip
    mounting.found(car)
    mounting.origin = Origin(
        "the middle of the rear axle", lambda found: (found.rear_axle_x, 0.0, -low), True
    )
    mounting.notes.read("size of the car, and its place around the origin, from ego-dimensions")


def _pose(value: Value) -> Matrix:
    """Return the transform of a view: x along its x-axis, y in the plane of both axes, as the tutorial has it."""
    view = value.item("view")
    x, y = (np.array(view.item(f"{axis}-axis").vector()) for axis in "xy")
    z = np.cross(x, y)
    if min(np.linalg.norm(x), np.linalg.norm(z)) < 1e-6:
        view.refuse("an x-axis and a y-axis that differ", "others")
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    return se3(np.stack([x, np.cross(z, x), z], axis=1), view.item("origin").vector())


def _lens(value: Value, name: str, notes: Notes) -> dict[str, Any]:
    width, height = (side.whole(1, 20_000) for side in value.item("Resolution").elements(2))
    lens = {"image": (width, height), **pinhole(value.item("CamMatrixOriginal").matrix(3, 3))}
    rows = value.item("Distortion")
    bend = rows.elements()[0] if rows.elements() and rows.elements()[0].is_list else rows
    if value.item("Lens", "Telecam").text().lower() == "fisheye":
        return lens | kannala_brandt(bend, bend.numbers(4), name, notes)
    return lens | brown_conrady(bend, bend.numbers(), name, notes)


A2D2 = Format(
    "a2d2", "Audi A2D2 configuration", (".json",), recognises, read, vehicle=Q7,
    car="size of an Audi Q7, the car of A2D2",
    origin=Origin("the middle of the rear axle", lambda car: (car.rear_axle_x, 0.0, 0.35)),
    harmless="CamMatrix|tstamp_delay|view",
)  # fmt: skip
