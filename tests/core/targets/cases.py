"""Random and hand-made traffic and rigs for the tests of the targets engine."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.figures.objects import ClassParts, ObjectFigure, Part, parts_by_class, parts_by_sector
from riglens.core.figures.registry import object_figures
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, LinearAngles, Rig, Sensor
from riglens.core.scene.boxes import CLASSES, DataReport, rotations_from_yaw
from riglens.core.sensors.base import HALVES
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.core.targets.counts import Counted
from riglens.core.targets.traffic import Traffic, traffic_of

Box = tuple[int, int, tuple[float, float, float], tuple[float, float, float], float]
"""Frame, class, centre, size, yaw (radians)."""


def traffic(boxes: Sequence[Box], frames: int = 1) -> Traffic:
    """Traffic of these boxes, in the order of their frames."""
    frame = np.array([box[0] for box in boxes], np.int64)
    cls = np.array([box[1] for box in boxes], np.uint8)
    centre = np.array([box[2] for box in boxes], np.float64).reshape(-1, 3)
    size = np.array([box[3] for box in boxes], np.float64).reshape(-1, 3)
    turn = rotations_from_yaw(np.array([box[4] for box in boxes], np.float64))
    return traffic_of(_report(frames), frame, cls, centre, size, turn)


def random_traffic(rng: np.random.Generator, frames: int, most: int = 12) -> Traffic:
    """Road users around the car, some tilted, some overlapping, some around the sensors, some far away."""
    number = rng.integers(0, most, frames)
    total = int(number.sum())
    centre = rng.uniform([-40.0, -30.0, 0.0], [40.0, 30.0, 2.0], (total, 3))
    centre[rng.random(total) < 0.15] *= 0.1
    centre[rng.random(total) < 0.05] *= 4.0
    size = rng.uniform([0.3, 0.3, 0.5], [12.0, 3.0, 3.5], (total, 3))
    turn = rotations_from_yaw(rng.uniform(-np.pi, np.pi, total))
    turn[rng.random(total) < 0.2] = np.eye(3)
    tilted = rng.random(total) < 0.2
    turn[tilted] = turn[tilted] @ _about_x(rng.uniform(-0.4, 0.4, int(tilted.sum())))
    frame = np.repeat(np.arange(frames), number)
    return traffic_of(_report(frames), frame, rng.integers(0, 3, total).astype(np.uint8), centre, size, turn)


def _about_x(angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    turn = np.zeros((len(angle_rad), 3, 3))
    turn[:, 0, 0] = 1.0
    turn[:, 1, 1] = turn[:, 2, 2] = np.cos(angle_rad)
    turn[:, 2, 1], turn[:, 1, 2] = np.sin(angle_rad), -np.sin(angle_rad)
    return turn


def _report(frames: int) -> DataReport:
    return DataReport("made up", frames, dict.fromkeys(CLASSES, 0))


def random_rig(rng: np.random.Generator, sensors: int = 4) -> Rig:
    """A rig of all kinds of rays: upright, tilted, with offsets, listed, sectors, pinholes, lenses with distortion."""
    made = [_random_sensor(rng).model_copy(update={"name": f"S{number}"}) for number in range(sensors)]
    return Rig(name="random", sensors=tuple(made))


def _random_sensor(rng: np.random.Generator) -> Sensor:
    position = tuple(rng.uniform([-2.5, -1.5, 0.2], [2.5, 1.5, 3.0]).tolist())
    rpy = (0.0, 0.0, float(rng.uniform(-180.0, 180.0)))
    if rng.random() < 0.5:
        rpy = tuple(rng.uniform([-60.0, -60.0, -180.0], [60.0, 60.0, 180.0]).tolist())
    near = float(rng.choice([0.0, 0.9, 6.0]))
    place: dict[str, Any] = {
        "name": "S",
        "position": position,
        "rpy_deg": rpy,
        "range_m": (near, float(rng.choice([np.inf, 20.0 + near]))),
    }
    return _random_lidar(rng, place) if rng.random() < 0.55 else _random_camera(rng, place)


def rig_of_every_kind(rng: np.random.Generator, sensors: int = 4) -> Rig:
    """As `random_rig`, with a radar of two scans and an ultrasonic sensor, near the car's height."""
    few = random_rig(rng, sensors).sensors
    places: list[dict[str, Any]]
    places = [{"position": tuple(rng.uniform([-2.3, -1.2, 0.3], [2.3, 1.2, 1.6]).tolist())} for _ in range(2)]
    for place in places:
        place["rpy_deg"] = tuple((rng.uniform(-1.0, 1.0, 3) * [12.0, 15.0, 180.0]).tolist())
    scans = [
        RadarScan(
            **_random_sector(rng), range_m=float(rng.uniform(8.0, 50.0)), resolution_deg=9.0, resolution_m=3.0
        )
        for _ in range(2)
    ]
    radar = Radar(name="R", **places[0], range_m=(0.4, 60.0), scans=tuple(scans))
    reach = float(rng.uniform(4.0, 12.0))
    sonic = Ultrasonic(
        name="U", **places[1], **_random_sector(rng), range_m=(float(rng.choice([0.15, 2.0])), 14.0),
        pole_range_m=reach, wall_range_m=2.0 * reach, blocked=(HALVES["left"],) if rng.random() < 0.2 else (),
    )  # fmt: skip
    return Rig(name="random", sensors=(*few, radar, sonic))


def _random_sector(rng: np.random.Generator) -> dict[str, Any]:
    middle, up = float(rng.uniform(-80.0, 80.0)), float(rng.uniform(-8.0, 8.0))
    wide, tall = rng.uniform([2.0, 1.0], [14.0, 6.0]).tolist()
    return {"azimuth_deg": (middle - wide, middle + wide), "elevation_deg": (up - tall, up + tall)}


def _random_lidar(rng: np.random.Generator, place: dict[str, Any]) -> Lidar:
    beams = int(rng.integers(1, 9))
    elevations = tuple(rng.uniform(-40.0, 30.0, beams).tolist())
    turn: LinearAngles | tuple[float, ...] = LinearAngles(
        from_=-180.0, to=180.0, count=int(rng.integers(1, 200))
    )
    if rng.random() < 0.3:
        turn = LinearAngles(from_=-60.0, to=70.0, count=90)
    elif rng.random() < 0.3:
        turn = tuple(rng.uniform(-180.0, 180.0, 50).tolist())
    offsets = tuple(rng.uniform(-9.0, 9.0, beams).tolist()) if rng.random() < 0.4 else None
    return Lidar(**place, elevations_deg=elevations, azimuths_deg=turn, azimuth_offsets_deg=offsets)


def _random_camera(rng: np.random.Generator, place: dict[str, Any]) -> Camera:
    cast = (int(rng.integers(1, 60)), int(rng.integers(1, 40)))
    if rng.random() < 0.5:
        return Camera(**place, hfov_deg=float(rng.uniform(10.0, 175.0)), cast=cast)
    lens: dict[str, Any] = {"fx": 600.0, "fy": 620.0, "cx": 790.0, "cy": 460.0}
    if rng.random() < 0.5:
        return Camera(**place, **lens, cast=cast, distortion=BrownConrady(k1=-0.3, p1=1e-3))
    fish: dict[str, Any] = {"fx": 420.0, "fy": 420.0, "cx": 800.0, "cy": 450.0}
    return Camera(**place, **fish, cast=cast, distortion=KannalaBrandt(k1=-0.02, k2=0.004))


def parts(counted: Counted) -> dict[str, ClassParts]:
    """Return every figure of objects of a rig, by class and ring."""
    return parts_by_class(counted, figures_of(counted), with_rings=True)


def by_sector(counted: Counted) -> dict[str, dict[str, Part]]:
    """Return every figure of objects of a rig, by class and sector."""
    return parts_by_sector(counted, figures_of(counted))


def figures_of(counted: Counted) -> tuple[ObjectFigure, ...]:
    """Return the figures of objects that a rig's kinds of sensors have."""
    return object_figures(sensor.kind for sensor in counted.rig.sensors if sensor.enabled)
