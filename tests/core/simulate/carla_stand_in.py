"""Stand-in for CARLA's Python client: the part of its interface that is used, and a small world behind it.

Left-handed as CARLA is: x ahead, y to the right, z up, degrees, positive yaw to the right, positive pitch up. The
matrix of a transform is that of the client's version 0.9.16, with which it was compared. LiDARs return the middle and
eight points near the corners of every other actor; cameras show its middle in one pixel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class Location:
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass
class Rotation:
    pitch: float = 0.0
    yaw: float = 0.0
    roll: float = 0.0


@dataclass
class Transform:
    location: Location = field(default_factory=Location)
    rotation: Rotation = field(default_factory=Rotation)

    def get_matrix(self) -> list[list[float]]:
        it, at = self.rotation, self.location
        cy, sy = math.cos(math.radians(it.yaw)), math.sin(math.radians(it.yaw))
        cp, sp = math.cos(math.radians(it.pitch)), math.sin(math.radians(it.pitch))
        cr, sr = math.cos(math.radians(it.roll)), math.sin(math.radians(it.roll))
        return [
            [cp * cy, cy * sp * sr - sy * cr, -cy * sp * cr - sy * sr, at.x],
            [cp * sy, sy * sp * sr + cy * cr, -sy * sp * cr + cy * sr, at.y],
            [sp, -cp * sr, cp * cr, at.z],
            [0.0, 0.0, 0.0, 1.0],
        ]


def box(x: float, y: float, z: float, middle_z: float) -> SimpleNamespace:
    """A bounding box of half sizes, its middle so high above the actor."""
    return SimpleNamespace(
        extent=Location(x, y, z), location=Location(0.0, 0.0, middle_z), rotation=Rotation()
    )


class Actor:
    def __init__(self, world: World, number: int, type_id: str, at: Transform, **attributes: str) -> None:
        self.world, self.id, self.type_id, self.at, self.attributes = world, number, type_id, at, attributes
        self.bounding_box, self.speed, self.is_driving, self.is_there = (
            box(2.2, 0.9, 0.75, 0.75),
            0.0,
            False,
            True,
        )

    def get_transform(self) -> Transform:
        return self.at

    def set_autopilot(self, enabled: bool) -> None:
        self.is_driving = enabled

    def destroy(self) -> bool:
        self.is_there = False
        self.world.actors.remove(self)
        return True


class Sensor(Actor):
    def __init__(self, world: World, number: int, blueprint: Blueprint, at: Transform, parent: Actor) -> None:
        super().__init__(world, number, blueprint.id, at, **blueprint.attributes)
        self.parent = parent
        self.send: Callable[[Any], object] = lambda _: None

    def listen(self, callback: Callable[[Any], object]) -> None:
        self.send = callback

    def stop(self) -> None:
        self.send = lambda _: None


class Blueprint:
    def __init__(self, name: str, **attributes: str) -> None:
        self.id, self.attributes = name, dict(attributes)

    def set_attribute(self, name: str, value: str) -> None:
        assert isinstance(value, str)
        self.attributes[name] = value

    def has_attribute(self, name: str) -> bool:
        return name in self.attributes

    def get_attribute(self, name: str) -> str:
        return self.attributes[name]


class Found(list[Any]):
    def filter(self, pattern: str) -> Found:
        return Found(
            one for one in self if (getattr(one, "type_id", None) or one.id).startswith(pattern.rstrip("*"))
        )

    def find(self, name: str) -> Blueprint:
        return Blueprint(next(one for one in self if one.id == name).id)


class World:
    """A town with a place to start; `silent`: the kind of sensor that sends nothing."""

    def __init__(self) -> None:
        self.actors, self.frame, self.numbers, self.silent = Found(), 100, 0, ""
        self.settings = SimpleNamespace(synchronous_mode=False, fixed_delta_seconds=None)
        self.start = Transform(Location(20.0, -7.0, 0.3), Rotation(pitch=3.0, yaw=40.0, roll=-2.0))

    def add(
        self, type_id: str, at: Transform, shape: SimpleNamespace, speed: float = 0.0, **attributes: str
    ) -> Actor:
        self.numbers += 1
        actor = Actor(self, self.numbers, type_id, at, **attributes)
        actor.bounding_box, actor.speed = shape, speed
        self.actors.append(actor)
        return actor

    def get_settings(self) -> SimpleNamespace:
        return SimpleNamespace(**vars(self.settings))

    def apply_settings(self, settings: SimpleNamespace) -> None:
        self.settings = settings

    def get_map(self) -> SimpleNamespace:
        return SimpleNamespace(name="Carla/Maps/Town10HD", get_spawn_points=lambda: [self.start])

    def get_actors(self) -> Found:
        return self.actors

    def get_blueprint_library(self) -> Found:
        kinds = ("rgb", "semantic_segmentation", "depth")
        sensors = [
            Blueprint("sensor.lidar.ray_cast"),
            *(Blueprint(f"sensor.camera.{kind}") for kind in kinds),
        ]
        cars = [
            Blueprint("vehicle.bh.crossbike", number_of_wheels="2"),
            Blueprint("vehicle.tesla.model3", number_of_wheels="4"),
        ]
        return Found([*cars, *sensors])

    def try_spawn_actor(self, blueprint: Blueprint, at: Transform) -> Actor:
        return self.add(blueprint.id, at, box(2.4, 1.0, 0.7, 0.7), 0.0, **blueprint.attributes)

    def spawn_actor(self, blueprint: Blueprint, at: Transform, attach_to: Actor) -> Sensor:
        self.numbers += 1
        sensor = Sensor(self, self.numbers, blueprint, at, attach_to)
        self.actors.append(sensor)
        return sensor

    def tick(self) -> int:
        assert self.settings.synchronous_mode and self.settings.fixed_delta_seconds == 0.05
        self.frame += 1
        for actor in self.actors:
            ahead = np.array(actor.at.get_matrix())[:3, 0] * actor.speed * 0.05
            at = actor.at.location
            actor.at = Transform(
                Location(at.x + ahead[0], at.y + ahead[1], at.z + ahead[2]), actor.at.rotation
            )
        for sensor in [one for one in self.actors if isinstance(one, Sensor)]:
            if self.silent and sensor.type_id.endswith(self.silent):
                continue
            late = SimpleNamespace(frame=self.frame - 1)  # what was still on its way
            sensor.send(late)
            sensor.send(self._lidar(sensor) if "lidar" in sensor.type_id else self._camera(sensor))
        return self.frame

    def _seen(self, sensor: Sensor, shares: NDArray[np.float64]) -> list[tuple[Actor, NDArray[np.float64]]]:
        """Points of the boxes of others, given by shares of their half sizes, in the sensor's own axes."""
        world_from = np.array(sensor.parent.at.get_matrix()) @ np.array(sensor.at.get_matrix())
        found = []
        for actor in self.actors:
            if isinstance(actor, Sensor) or actor is sensor.parent:
                continue
            shape = actor.bounding_box
            half = np.array([shape.extent.x, shape.extent.y, shape.extent.z])
            own = shares * half + [shape.location.x, shape.location.y, shape.location.z]
            there = np.column_stack([own, np.ones(len(own))]) @ np.array(actor.at.get_matrix()).T
            found.append((actor, (there @ np.linalg.inv(world_from).T)[:, :3]))
        return found

    def _lidar(self, sensor: Sensor) -> SimpleNamespace:
        """The highest channel has all middles, the lowest all corners."""
        corners = 0.95 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
        middles = [points for _, points in self._seen(sensor, np.zeros((1, 3)))]
        others = [points for _, points in self._seen(sensor, corners)]
        points = np.concatenate([np.zeros((0, 3)), *middles, *others])
        channels = int(sensor.attributes["channels"])
        counts = {0: len(middles), channels - 1: 8 * len(others)}
        records = np.column_stack([points, np.full(len(points), 0.5)]).astype(np.float32)
        return SimpleNamespace(
            frame=self.frame,
            raw_data=records.tobytes(),
            channels=channels,
            get_point_count=lambda k: counts.get(k, 0),
        )

    def _camera(self, sensor: Sensor) -> SimpleNamespace:
        width, height = int(sensor.attributes["image_size_x"]), int(sensor.attributes["image_size_y"])
        focal = width / 2 / math.tan(math.radians(float(sensor.attributes["fov"])) / 2)
        kind = sensor.type_id.rsplit(".", 1)[-1]
        image = np.zeros((height, width, 4), np.uint8)
        image[:] = {"rgb": (200, 150, 100, 255), "semantic_segmentation": (0, 0, 1, 255)}.get(
            kind, (255,) * 4
        )
        for actor, points in self._seen(sensor, np.zeros((1, 3))):
            x, y, z = points[0]
            if x <= 0.0:
                continue
            u, v = int(width / 2 + focal * y / x), int(height / 2 - focal * z / x)
            if 0 <= u < width and 0 <= v < height:
                image[v, u] = self._pixel(kind, actor, x)
        return SimpleNamespace(frame=self.frame, raw_data=image.tobytes(), width=width, height=height)

    @staticmethod
    def _pixel(kind: str, actor: Actor, depth_m: float) -> tuple[int, int, int, int]:
        if kind == "depth":
            code = round(depth_m / 1000.0 * (256**3 - 1))
            return code >> 16, (code >> 8) & 255, code & 255, 255
        two = actor.attributes.get("number_of_wheels") == "2"
        tag = 12 if actor.type_id.startswith("walker") else 19 if two else 14
        return (0, 0, tag, 255) if kind == "semantic_segmentation" else (10, 20, 30, 255)


class Client:
    world = World()

    def __init__(self, host: str, port: int) -> None:
        self.port = port

    def set_timeout(self, seconds: float) -> None:
        assert seconds > 0.0

    def get_world(self) -> World:
        if self.port == 1:
            raise RuntimeError("time-out of 20000ms while waiting for the simulator")
        return self.world


def module(world: World) -> ModuleType:
    """The module `carla`, with a client that leads to this world."""
    made = ModuleType("carla")
    client = type("Client", (Client,), {"world": world})
    for name, it in {
        "Location": Location,
        "Rotation": Rotation,
        "Transform": Transform,
        "Client": client,
    }.items():
        setattr(made, name, it)
    return made


def town() -> World:
    """A car, a bicycle and a pedestrian around where a new car starts; the car drives."""
    world = World()
    start = world.start.location
    world.add(
        "vehicle.audi.tt", Transform(Location(start.x + 14.0, start.y + 6.0, 0.5), Rotation(2.0, 100.0, 1.0)),
        box(2.1, 0.95, 0.7, 0.72), speed=5.0, number_of_wheels="4",
    )  # fmt: skip
    world.add(
        "vehicle.bh.crossbike", Transform(Location(start.x + 5.0, start.y + 9.0, 0.4), Rotation(0.0, -30.0, 0.0)),
        box(0.8, 0.35, 0.85, 0.85), number_of_wheels="2",
    )  # fmt: skip
    world.add(
        "walker.pedestrian.0001", Transform(Location(start.x + 9.0, start.y + 2.0, 1.3), Rotation(0.0, 77.0, 0.0)),
        box(0.3, 0.3, 0.9, 0.0),
    )  # fmt: skip
    world.add(
        "walker.pedestrian.0002", Transform(Location(start.x + 400.0, start.y, 1.0)), box(0.3, 0.3, 0.9, 0.0)
    )
    world.add("vehicle.old.bike", Transform(Location(start.x + 3.0, start.y - 3.0)), box(0.0, 0.0, 0.0, 0.0))
    return world
