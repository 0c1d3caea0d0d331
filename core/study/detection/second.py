"""The rigs and protocols of the second study, docs/study-detection-2.md: drawn by a stated seed before it ran."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library, sensor_from_model
from riglens.core.rig.model import Lidar, Rig
from riglens.core.rig.presets import preset
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.study.detection.protocol import Protocol
from riglens.core.study.detection.published import LATER

SEED = 20261123
"""Of all draws of rigs."""
BUDGETS = (28_800, 57_600, 115_200)
"""LiDAR rays of a frame, of rigs that cost alike; 10 frames a second make a tenth of the points per second."""
APART = 0.15
"""Rigs of a budget differ from it by at most this share."""
DRAWN = (6, 6, 4)
"""Rigs drawn at each budget."""
PERIOD_S = 2.0
"""Time between two frames of the bundled town."""

Place = tuple[float, float, float, float]
"""x, y, z in metres and yaw in degrees."""
_ROOF: Place = (0.0, 0.0, 1.9, 0.0)
MOUNTS: dict[int, tuple[tuple[Place, ...], ...]] = {
    1: ((_ROOF,), ((2.4, 0.0, 0.7, 0.0),)),
    2: (
        ((0.0, 0.6, 1.7, 0.0), (0.0, -0.6, 1.7, 0.0)),
        ((0.7, 0.0, 1.8, 0.0), (-0.9, 0.0, 1.8, 0.0)),
        ((2.4, 0.0, 0.7, 0.0), (-2.4, 0.0, 0.7, 180.0)),
    ),
    3: (
        (_ROOF, (2.3, 0.95, 0.8, 90.0), (2.3, -0.95, 0.8, -90.0)),
        (_ROOF, (2.4, 0.0, 0.7, 0.0), (-2.4, 0.0, 0.7, 180.0)),
    ),
    4: (
        ((0.5, 0.6, 1.7, 0.0), (0.5, -0.6, 1.7, 0.0), (-0.9, 0.6, 1.7, 0.0), (-0.9, -0.6, 1.7, 0.0)),
        (
            (2.3, 0.95, 0.8, 45.0),
            (2.3, -0.95, 0.8, -45.0),
            (-2.3, 0.95, 0.8, 135.0),
            (-2.3, -0.95, 0.8, -135.0),
        ),
    ),
}
"""Places of 1 to 4 equal LiDARs: on the roof, above the bumpers, at the corners."""
_FRONT: Place = (2.4, 0.0, 0.7, 0.0)
_LEFT, _RIGHT, _REAR = (2.3, 0.95, 0.8, 90.0), (2.3, -0.95, 0.8, -90.0), (-2.4, 0.0, 0.7, 180.0)
_MIXED: tuple[tuple[tuple[tuple[str, Place], ...], ...], ...] = (
    (
        (("livox-mid-360", _ROOF), ("hesai-jt16", _FRONT)),
        (("hesai-jt16", _ROOF), ("hesai-ft120", _FRONT)),
    ),
    (
        (("velodyne-vlp-16", _ROOF), ("hesai-jt16", _LEFT), ("hesai-jt16", _RIGHT), ("hesai-jt16", _REAR)),
        (("ouster-os0-32", _ROOF), ("velodyne-vlp-16", _FRONT)),
    ),
    (
        (("velodyne-vlp-32c", _ROOF), ("velodyne-vlp-16", _LEFT), ("velodyne-vlp-16", _RIGHT)),
        (("robosense-helios-1615", _ROOF), ("velodyne-vlp-32c", _FRONT)),
        tuple(("robosense-e1", place) for place in MOUNTS[4][1]),
    ),
)
"""Rigs of several models, or of LiDARs that look one way, at each budget: our choice."""
_LOOKS_DOWN_DEG = -5.0
"""Models whose lowest beam is above this are not drawn: upright, they see no ground."""

Arm = Literal["pillars", "range", "one-sweep", "painted"]
PROTOCOL = Protocol(
    seeds=1,
    epochs=4,
    train_frames=150,
    test_frames=140,
    simulation=SimulationSettings(clutter=120, body="blocks"),
    sweeps=3,
)
PROTOCOLS: dict[Arm, Protocol] = {
    "pillars": PROTOCOL,
    "range": replace(PROTOCOL, detector="range", train_frames=75),
    "one-sweep": replace(PROTOCOL, sweeps=1),
    "painted": replace(PROTOCOL, sweeps=1, cameras="usual"),
}
"""Parts of the study, in the order in which they run; the first decides the hypotheses."""
PAINTED_LIDARS, PAINTED_CAMERAS = ("58k 1:", "58k 2:", "58k 3:"), ("Wide", "Narrow")


def rigs_of(arm: Arm) -> tuple[Rig, ...]:
    """Return the rigs of a part: all, or three with wide and with narrow cameras and without."""
    rigs = second_rigs()
    if arm != "painted":
        return rigs
    chosen = [rig for rig in rigs if rig.name.startswith(PAINTED_LIDARS)]
    groups = [(name, preset(name).enabled_cameras()) for name in PAINTED_CAMERAS]
    return tuple(
        rig.model_copy(update={"name": f"{rig.name}, {name}", "sensors": (*rig.sensors, *cameras)})
        for rig in chosen
        for name, cameras in (("none", ()), *groups)
    )


def second_rigs() -> tuple[Rig, ...]:
    """Return the rigs: at each budget those drawn, then those of several models."""
    rng = np.random.default_rng(SEED)
    found: list[Rig] = []
    for place, (budget, count) in enumerate(zip(BUDGETS, DRAWN, strict=True)):
        drawn = [*_draw(budget, count, rng), *_MIXED[place]]
        found += [rig_of(f"{round(budget / 1000)}k {k}", lidars) for k, lidars in enumerate(drawn, 1)]
    return tuple(found)


def _draw(budget: int, count: int, rng: np.random.Generator) -> list[tuple[tuple[str, Place], ...]]:
    """Draw turning models of the bundled library, none twice, each in a number that makes up the budget, and places."""
    fitting: dict[str, list[int]] = {}
    for entry in default_library().entries("lidar"):
        sensor = entry.sensor("LIDAR", Pose())
        assert isinstance(sensor, Lidar)
        turns = sensor.rays is None and np.ptp(sensor.azimuths()) > 350.0
        if (
            not turns
            or sensor.elevations().min() > _LOOKS_DOWN_DEG
            or entry.maker in ("Data sets", "Generic")
            or entry.name in LATER
        ):
            continue
        numbers = [n for n in MOUNTS if abs(n * sensor.ray_count / budget - 1.0) <= APART]
        if numbers:
            fitting[entry.name] = numbers
    chosen = rng.choice(sorted(fitting), count, replace=False).tolist()
    found = []
    for model in chosen:
        mounts = MOUNTS[int(rng.choice(fitting[model]))]
        places = mounts[int(rng.integers(len(mounts)))]
        found.append(tuple((str(model), place) for place in places))
    return found


def rig_of(name: str, lidars: Sequence[tuple[str, Place]]) -> Rig:
    """Return a rig of models at places, with these words in its name."""
    models = dict.fromkeys(model for model, _ in lidars)
    words = " + ".join(f"{sum(one == model for one, _ in lidars)} x {model}" for model in models)
    where = {True: "roof", False: "low"}
    sides = "/".join(dict.fromkeys(where[place[2] > 1.5] for _, place in lidars))
    sensors = [
        sensor_from_model(model, f"LIDAR_{number}", Pose((x, y, z), (0.0, 0.0, yaw)))
        for number, (model, (x, y, z, yaw)) in enumerate(lidars, 1)
    ]
    return Rig(name=f"{name}: {words}, {sides}", self_occlusion=False, sensors=tuple(sensors))


def budgets(names: Sequence[str]) -> dict[str, list[int]]:
    """Return the places of rigs of a budget by their names."""
    starts = [f"{round(budget / 1000)}k" for budget in BUDGETS]
    return {
        f"budget {start}": [
            k for k, name in enumerate(names) if name.startswith(f"{start} ") and ": " in name
        ]
        for start in starts
    }
