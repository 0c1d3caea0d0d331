"""The rigs of the studies that are published in docs/study-detection.md: drawn by a stated seed before they ran."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.library import default_library, sensor_from_model
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.rig.presets import CAMERA_GROUPS, CARS, LIDAR_GROUPS, PAPER_LIDAR_GROUPS, preset
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.study.detection.protocol import Protocol

SEED = 20261122
"""Of all draws of rigs: the day on which they were drawn."""
FOUR_16_RAYS = 4 * 16 * 360
ROOF_M: Vec3 = (0.0, 0.0, 1.9)
LIBRARY_RIGS, RANDOM_RIGS = 5, 8
_RAYS = (10_000, 300_000)
_STUDIED_CARS = 4
"""The first of the presets' cars: those that there were when the rigs were drawn, as were no LiDARs of data sets."""
_AS_RUN: dict[str, dict[str, object]] = {
    "generic-16": {"range_m": (0.0, math.inf)},
    "robosense-rs-lidar-32": {"range_m": (0.4, 230.0)},
    "nuscenes-lidar-top": {
        "model": "velodyne-hdl-32e",
        "azimuths_deg": LinearAngles(from_=-180.0, to=180.0, count=2170),
    },
}
"""The library's fields of these models when the studies ran: the rigs stay those that were measured."""
LATER = frozenset({"ouster-os0-64"})
"""Models that the library had not when rigs were drawn from it."""

PROTOCOL = Protocol(
    seeds=5, epochs=4, train_frames=200, test_frames=500, simulation=SimulationSettings(clutter=120)
)
CAMERA_PROTOCOL = Protocol(
    seeds=3,
    epochs=4,
    train_frames=150,
    test_frames=300,
    simulation=SimulationSettings(clutter=120),
    cameras="usual",
)
"""Of the study of wide against narrow cameras."""


def camera_rigs() -> tuple[Rig, ...]:
    """Return the paper's eight rigs of wide or narrow cameras, and their LiDARs without any."""
    groups = [group for group in LIDAR_GROUPS if group.name in PAPER_LIDAR_GROUPS]
    pairs = [preset(f"{cameras.letters}+{group.letters}") for group in groups for cameras in CAMERA_GROUPS]
    return (*(preset(group.name) for group in groups), *pairs)


def published_rigs() -> tuple[Rig, ...]:
    """Return the rigs: LiDAR groups of the paper and its code, cars of data sets, LiDARs of the library alone on the
    roof, plain steps from poor to good, and four LiDARs at random."""
    rng = np.random.default_rng(SEED)
    groups = [preset(group.name) for group in LIDAR_GROUPS]
    cars = [preset(car.name) for car in CARS[:_STUDIED_CARS]]
    models = ["velodyne-vlp-32c", *_library_draw(rng)]
    alone = [_rig(model, (model, ROOF_M)) for model in models]
    drawn = [_random_rig(number, rng) for number in range(1, RANDOM_RIGS + 1)]
    return tuple(map(_as_run, (*groups, *cars, *alone, *_steps(), *drawn)))


def _as_run(rig: Rig) -> Rig:
    sensors = (one.replace(**_AS_RUN.get(one.model or "", {})) for one in rig.sensors)
    return rig.model_copy(update={"sensors": tuple(sensors)})


def _steps() -> list[Rig]:
    corners = [(2.2, 0.9, 0.6), (2.2, -0.9, 0.6), (-2.2, 0.9, 0.6), (-2.2, -0.9, 0.6)]
    return [
        _rig("1 x 16 low in front", ("generic-16", (2.3, 0.0, 0.6))),
        _rig("1 x 16 on the roof", ("generic-16", ROOF_M)),
        _rig("2 x 16 on the roof", ("generic-16", (0.0, 0.5, 1.9)), ("generic-16", (0.0, -0.5, 1.9))),
        _rig("4 low corners", *(("generic-16", corner) for corner in corners)),
    ]


def _library_draw(rng: np.random.Generator) -> list[str]:
    """Draw turning LiDARs of the bundled library that cast beams, without those that are rigs already."""
    names = []
    known = (entry for entry in default_library().entries("lidar") if entry.name not in LATER)
    entries = [entry for entry in known if entry.maker != "Data sets"]
    for entry in entries:
        sensor = entry.sensor("LIDAR", Pose())
        assert isinstance(sensor, Lidar)
        turn = sensor.azimuths()
        if sensor.rays is None and np.ptp(turn) > 350.0 and _RAYS[0] <= sensor.ray_count <= _RAYS[1]:
            names.append(entry.name)
    names = [name for name in names if name not in ("velodyne-vlp-32c", "generic-16")]
    return [str(name) for name in rng.choice(names, LIBRARY_RIGS, replace=False)]


def _random_rig(number: int, rng: np.random.Generator) -> Rig:
    """Draw four generic LiDARs of 16 beams, each on the roof (two of three) or at a corner, tilted up to 10 degrees."""
    sensors = []
    for place in range(1, 5):
        on_roof = rng.random() < 2 / 3
        low, high = ((-1.2, -0.7, 1.6), (0.6, 0.7, 2.6)) if on_roof else ((2.0, 0.7, 0.5), (2.3, 0.95, 1.0))
        x, y, z = rng.uniform(low, high)
        ahead, left = (1.0, 1.0) if on_roof else rng.choice([-1.0, 1.0], 2)
        roll, pitch = rng.uniform(-10.0, 10.0, 2)
        rounded = [round(float(value), 2) for value in (x * ahead, y * left, z, roll, pitch)]
        pose = Pose((rounded[0], rounded[1], rounded[2]), (rounded[3], rounded[4], 0.0))
        sensors.append(sensor_from_model("generic-16", f"LIDAR_{place}", pose))
    return Rig(name=f"random {number}", self_occlusion=False, sensors=tuple(sensors))


def _rig(name: str, *lidars: tuple[str, Vec3]) -> Rig:
    names = ["LIDAR_TOP"] if len(lidars) == 1 else [f"LIDAR_{number}" for number in range(1, len(lidars) + 1)]
    sensors = [
        sensor_from_model(model, at, Pose(position))
        for at, (model, position) in zip(names, lidars, strict=True)
    ]
    return Rig(name=name, self_occlusion=False, sensors=tuple(sensors))


def equal_rays(rays: list[int]) -> list[int]:
    """Return the places of the rigs that cast as many rays as the paper's."""
    return [place for place, count in enumerate(rays) if count == FOUR_16_RAYS]


def families(names: Sequence[str]) -> dict[str, list[int]]:
    """Return the places of rigs of a kind: the LiDAR groups of the paper and its code, and those drawn at random."""
    groups = {group.name for group in LIDAR_GROUPS}
    return {
        "LiDAR groups": [place for place, name in enumerate(names) if name in groups],
        "random rigs": [place for place, name in enumerate(names) if name.startswith("random ")],
    }
