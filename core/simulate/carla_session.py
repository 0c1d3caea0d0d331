"""CARLA through its Python client: sensors of a rig on a car, one tick after the other, and who drives around.

CARLA's axes are left-handed, x ahead, y to the RIGHT, z up, and its angles turn accordingly: everything that leaves
this file is right-handed. The client's package is imported when a session is opened, and never before.
"""

from __future__ import annotations

import queue
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import singledispatch
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.formats.carla_lidar import rays_to_write
from riglens.core.formats.lens_export import centred_pinhole, report_lens
from riglens.core.formats.report import Notes
from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Sensor
from riglens.core.sensors.registry import kind_of

Doubles = NDArray[np.float64]
STEP_S = 0.05
"""Time of a tick; LiDARs turn once in it."""
ANSWER_S = 20.0
"""Timeout for an answer of the simulator, and for a sensor to send the data of a tick."""
CAMERAS = ("rgb", "semantic_segmentation", "depth")
EGO_ROLES = ("hero", "ego_vehicle", "ego")
_ADDRESS = re.compile(r"(?P<host>[^\s:/]+):(?P<port>\d{1,5})")
_MIRRORED = np.diag([1.0, -1.0, 1.0])


@dataclass(frozen=True)
class Address:
    """Address of the simulator."""

    host: str
    port: int

    @classmethod
    def of(cls, text: str) -> Address:
        """Read HOST:PORT; InputError for anything else."""
        match = _ADDRESS.fullmatch(text)
        if match is None or not 0 < int(match["port"]) < 1 << 16:
            raise InputError(f"must be HOST:PORT, such as localhost:2000 (got '{text}')", "carla")
        return cls(match["host"], int(match["port"]))


@dataclass(frozen=True)
class Actor:
    """Object at a tick: number in the simulator, index into CLASSES, and its box in the world, right-handed."""

    number: int
    cls: int
    centre_m: Doubles
    size_m: Doubles
    rotation: Doubles


@dataclass(frozen=True)
class Tick:
    """State at a tick: pose of the car in the world, the other objects, the data of each sensor by its name, cameras by
    name and kind."""

    rotation: Doubles
    place_m: Doubles
    actors: tuple[Actor, ...]
    data: dict[str, Any]


def world_pose(transform: Any) -> tuple[Doubles, Doubles]:
    """Return the rotation (3, 3) and place (3,) of a transform of CARLA in right-handed axes."""
    matrix = np.array(transform.get_matrix(), np.float64)
    return _MIRRORED @ matrix[:3, :3] @ _MIRRORED, _MIRRORED @ matrix[:3, 3]


def mirrored(points: Doubles) -> Doubles:
    """Convert points (n, 3) from left-handed to right-handed axes, or back."""
    return np.asarray(points * np.array([1.0, -1.0, 1.0]))


def castable(rig: Rig, notes: Notes) -> Rig:
    """Return the rig as CARLA can simulate it: beams and azimuths evenly spaced, cameras as centred pinholes; `notes`
    reports it."""
    made = (_castable(sensor, notes) for sensor in rig.sensors if sensor.enabled)
    return rig.replace(sensors=tuple(sensor for sensor in made if sensor is not None))


@singledispatch
def _castable(sensor: Sensor, notes: Notes) -> Sensor | None:
    notes.ignored(f"{kind_of(sensor).title}: there is none in CARLA", sensor.name)
    return None


@_castable.register
def _(camera: Camera, notes: Notes) -> Sensor | None:
    pinhole = centred_pinhole(camera)
    report_lens(camera, pinhole, "a pinhole of one focal length in the middle of its image", notes)
    return pinhole


@_castable.register
def _(lidar: Lidar, notes: Notes) -> Sensor | None:
    rays = rays_to_write(lidar, notes)
    half_deg = rays.get("horizontal_fov", 360.0) / 2.0
    return lidar.replace(
        elevations_deg=LinearAngles(
            from_=rays["lower_fov"], to=rays["upper_fov"], count=len(lidar.elevations())
        ),
        azimuths_deg=LinearAngles(from_=-half_deg, to=half_deg, count=len(lidar.azimuths())),
        azimuth_offsets_deg=None,
        rays=None,
        range_m=(0.0, rays["range"]),
    )


class Session:
    """A car with sensors in CARLA's world; see `session`."""

    def __init__(self, carla: Any, world: Any, ego: Any) -> None:
        self._carla, self._world, self._ego = carla, world, ego
        self._sensors, self._queues = list[Any](), dict[str, queue.Queue[Any]]()

    @property
    def map_name(self) -> str:
        """Name of the town."""
        return str(self._world.get_map().name).rsplit("/", 1)[-1]

    def mount(self, rig: Rig, noise_m: float, dropout: float, with_cameras: bool) -> None:
        """Attach the sensors of a castable rig to the car."""
        for lidar in rig.enabled_lidars():
            rays = rays_to_write(lidar, Notes())
            turns = 1.0 / STEP_S
            fields = {
                **rays,
                "rotation_frequency": turns,
                "points_per_second": round(lidar.ray_count * turns),
                "noise_stddev": noise_m,
                "dropoff_general_rate": dropout,
            }
            self._spawn(lidar.name, "sensor.lidar.ray_cast", fields, lidar.pose)
        for camera in rig.enabled_cameras() if with_cameras else ():
            width, height = camera.image
            fields = {"image_size_x": width, "image_size_y": height, "fov": camera.hfov_deg or 90.0}
            for kind in CAMERAS:
                self._spawn(f"{camera.name} {kind}", f"sensor.camera.{kind}", fields, camera.pose)

    def _spawn(self, name: str, kind: str, fields: dict[str, Any], pose: Pose) -> None:
        blueprint = self._world.get_blueprint_library().find(kind)
        for key, value in fields.items():
            blueprint.set_attribute(key, f"{value:.10g}" if isinstance(value, float) else str(value))
        (x, y, z), (roll, pitch, yaw) = pose.position_m, pose.rpy_deg
        carla = self._carla
        place = carla.Transform(
            carla.Location(x=x, y=-y, z=z), carla.Rotation(roll=roll, pitch=-pitch, yaw=-yaw)
        )
        sensor = self._world.spawn_actor(blueprint, place, attach_to=self._ego)
        self._sensors.append(sensor)
        received = self._queues[name] = queue.Queue[Any]()
        sensor.listen(received.put)

    def tick(self) -> Tick:
        """Advance the world by STEP_S and return its state. ChildProcessError when a sensor stays silent."""
        number = self._world.tick()
        data = {name: self._of_tick(name, number) for name in self._queues}
        rotation, place_m = world_pose(self._ego.get_transform())
        return Tick(rotation, place_m, tuple(self._actors()), data)

    def _of_tick(self, name: str, number: int) -> Any:
        while True:
            try:
                sent = self._queues[name].get(timeout=ANSWER_S)
            except queue.Empty:
                raise ChildProcessError(f"CARLA: sensor {name} sent nothing for {ANSWER_S:g} s") from None
            if sent.frame == number:
                return sent

    def _actors(self) -> Iterator[Actor]:
        """Yield all others whose box has a size: some two-wheelers in old versions have none."""
        actors = self._world.get_actors()
        for pattern in ("vehicle.*", "walker.pedestrian.*"):
            for actor in actors.filter(pattern):
                box = actor.bounding_box
                size = 2.0 * np.array([box.extent.x, box.extent.y, box.extent.z])
                if actor.id == self._ego.id or not (size > 0.0).all():
                    continue
                rotation, place_m = world_pose(actor.get_transform())
                own, offset_m = world_pose(self._carla.Transform(box.location, box.rotation))
                yield Actor(
                    int(actor.id), _class_of(actor), place_m + rotation @ offset_m, size, rotation @ own
                )

    def close(self) -> None:
        """Remove the sensors."""
        for sensor in self._sensors:
            with suppress(RuntimeError):
                sensor.stop()
                sensor.destroy()
        self._sensors.clear()


def _class_of(actor: Any) -> int:
    """Return the place in CLASSES: walkers, two-wheelers, and all other vehicles."""
    if str(actor.type_id).startswith("walker."):
        return 2
    return 1 if str(actor.attributes.get("number_of_wheels", "4")) == "2" else 0


@contextmanager
def session(address: Address) -> Iterator[Session]:
    """Yield a session with a simulator that waits for our ticks while the block runs, and continues as before
    afterwards.

    The car is the one called hero or ego_vehicle, else a new one that drives by itself. InputError when the package is
    missing, no simulator answers, or there is no place for a car.
    """
    carla = _carla()
    where = f"CARLA at {address.host}:{address.port}"
    try:
        client = carla.Client(address.host, address.port)
        client.set_timeout(ANSWER_S)
        world = client.get_world()
    except RuntimeError as error:
        raise InputError(f"{where}: no simulator answers ({' '.join(str(error).split())[:200]})") from error
    before, now = world.get_settings(), world.get_settings()
    now.synchronous_mode, now.fixed_delta_seconds = True, STEP_S
    world.apply_settings(now)
    made: Any = None
    try:
        ego = _ego_in(world)
        if ego is None:
            ego = made = _new_ego(world, where)
        world.tick()  # a new car is where it belongs from the first tick on
        opened = Session(carla, world, ego)
        try:
            yield opened
        finally:
            opened.close()
    except RuntimeError as error:
        raise ChildProcessError(f"{where}: {' '.join(str(error).split())[:200]}") from error
    finally:
        with suppress(RuntimeError):
            if made is not None:
                made.destroy()
            world.apply_settings(before)


def _ego_in(world: Any) -> Any:
    """Return the car that others made for this."""
    cars = {str(car.attributes.get("role_name", "")): car for car in world.get_actors().filter("vehicle.*")}
    return next((cars[role] for role in EGO_ROLES if role in cars), None)


def _new_ego(world: Any, where: str) -> Any:
    library = world.get_blueprint_library()
    cars = [one for one in library.filter("vehicle.*") if _wheels(one) == 4]
    usual = [one for one in cars if one.id == "vehicle.tesla.model3"]
    for blueprint in (usual or cars)[:1]:
        blueprint.set_attribute("role_name", EGO_ROLES[0])
        for place in world.get_map().get_spawn_points():
            car = world.try_spawn_actor(blueprint, place)
            if car is not None:
                car.set_autopilot(True)
                return car
    raise InputError(f"{where}: no free place for a car: choose another town, or spawn a car named hero")


def _wheels(blueprint: Any) -> int:
    return (
        int(blueprint.get_attribute("number_of_wheels")) if blueprint.has_attribute("number_of_wheels") else 4
    )


def _carla() -> Any:
    try:
        import carla
    except ImportError as error:
        raise InputError(
            "needs CARLA's package carla; install it with: pip install 'riglens[carla]'", "carla"
        ) from error
    return carla
