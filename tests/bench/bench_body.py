"""An edit with a solid car against the same edit without one, for sensors where they sit on real cars; one thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import pytest

from riglens.core.engine.audit import audit
from riglens.core.engine.engine import Engine
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Camera, Rig, Sensor, Vehicle
from riglens.core.rig.presets import preset
from riglens.core.vehicle.profile import reference_vehicle
from tests.bench.race import Goal, Race
from tests.bench.scenes import Scenes, competent_edit, dense_rays, models, moved, moves

ROUNDS = 7
BLOCKS, IGNORED = MetricSettings(body="blocks"), MetricSettings(body="ignored")


@dataclass(frozen=True)
class Place:
    """Where on the car a sensor sits: ahead of the middle as a share of the half length, to the left of it as a share
    of the half width and metres more, and metres above the ground, or above the roof; how it is turned."""

    name: str
    ahead: float
    left: float
    beside_m: float
    above_m: float
    on_roof: bool
    rpy_deg: tuple[float, float, float]

    def pose(self, vehicle: Vehicle) -> Pose:
        """The pose on a car."""
        x, y = self.ahead * vehicle.length / 2, self.left * vehicle.width / 2 + self.beside_m
        z = self.above_m + (vehicle.height if self.on_roof else 0.0)
        return Pose(position_m=(x, y, z), rpy_deg=self.rpy_deg)


ROOF = Place("on the roof", 0.0, 0.0, 0.0, 0.15, True, (0.0, 0.0, 8.0))
TILTED = Place("on the roof, tilted", 0.0, 0.0, 0.0, 0.15, True, (2.0, -3.0, 8.0))
CORNER = Place("at a front corner", 0.87, 1.0, 0.05, 0.9, False, (0.0, 0.0, 45.0))
LEANING = Place("at a front corner, tilted", 0.87, 1.0, 0.05, 0.9, False, (3.0, 5.0, 45.0))
SIDE = Place("beside a door", 0.2, 1.0, 0.1, 0.8, False, (-90.0, 0.0, 0.0))
WINDSCREEN = Place("behind the windscreen", 0.24, 0.0, 0.0, -0.15, True, (0.0, 2.0, 0.0))
BROW = Place("above the windscreen", 0.22, 0.0, 0.0, 0.05, True, (0.5, 6.0, 0.0))
SENSORS = (
    ("dense", ROOF),
    ("dense", TILTED),
    ("velodyne-vls-128", ROOF),
    ("velodyne-vlp-16", ROOF),
    ("hesai-xt32", CORNER),
    ("hesai-xt32", LEANING),
    ("velodyne-vlp-32c", CORNER),
    ("robosense-bpearl", SIDE),
    ("native", WINDSCREEN),
    ("native", BROW),
    ("pandaset-wide", BROW),
)
"""Models of the library; `dense`: 128 beams of 3600 azimuths, `native`: a camera that casts 1920 x 1080 pixels."""


def sensor_at(model: str, place: Place, vehicle: Vehicle) -> Sensor:
    """A sensor on a car."""
    pose = place.pose(vehicle)
    if model == "native":
        return Camera(
            name="s", position=pose.position_m, rpy_deg=pose.rpy_deg, hfov_deg=60.0, image=(1920, 1080),
            cast=(1920, 1080),
        )  # fmt: skip
    sensor = models().entry("ouster-os1-128" if model == "dense" else model).sensor("s", pose)
    return dense_rays(sensor.replace(azimuth_offsets_deg=None)) if model == "dense" else sensor


def edits(rig: Rig) -> Iterator[Rig]:
    """The rig with its sensors moved a little in turn, without end."""
    for number in count(1):
        sensor = rig.sensors[number % len(rig.sensors)]
        yield rig.with_sensor(sensor.name, moved(sensor, number))


def race_edits(race: Race, scenes: Scenes, rig: Rig, work: str) -> None:
    """An edit with `blocks` against the same edit with `ignored`."""
    scene = scenes.at(0.1)
    solid, hollow = scene.engine(1), scene.engine(1)
    solid.evaluate(rig, BLOCKS), hollow.evaluate(rig, IGNORED)
    race.run(
        Goal("body", f"edit, {work}, one thread, {scene.edge}", 1.5, "lower"),
        edits(rig),
        lambda edited: solid.evaluate(edited, BLOCKS, with_seen=False),
        lambda edited: hollow.evaluate(edited, IGNORED, with_seen=False),
        rounds=ROUNDS,
    )


@pytest.mark.parametrize("body", ["sedan", "suv"])
@pytest.mark.parametrize(("model", "place"), SENSORS, ids=lambda value: getattr(value, "name", value))
def test_body_edit(race: Race, scenes: Scenes, model: str, place: Place, body: str) -> None:
    vehicle = reference_vehicle(body)
    rig = Rig(vehicle=vehicle, sensors=(sensor_at(model, place, vehicle),))
    race_edits(race, scenes, rig, f"{model} {place.name} of a {body}")


def test_body_edit_of_the_paper(race: Race, scenes: Scenes) -> None:
    race_edits(race, scenes, preset("W+T"), "W+T")


def test_audit(race: Race, scenes: Scenes) -> None:
    """An audit of W+T, all rays of all sensors, against plain DDA of as many rays: one sensor, times the others."""
    scene, rig = scenes.at(0.1), preset("W+T")
    cases = moves(scene, rig, ["LIDAR_1"])
    rays = sum(sensor.ray_count for sensor in rig.sensors)
    race.run(
        Goal("body", f"audit of W+T ({rays} rays), one thread, {scene.edge}", 1.0, "higher"),
        cases,
        lambda _: audit(Engine(scene.field, 1), rig),
        lambda move: competent_edit(scene, move),
        scale=rays / rig.sensor("LIDAR_1").ray_count,
        rounds=ROUNDS,
    )
