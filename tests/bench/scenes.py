"""What the benchmarks work on: the bundled scenario on a grid, the rig W+T, sensors that move a little."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.assets import asset_path
from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine
from riglens.core.geometry import Pose
from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.library import Library, read_entries, sensor_from_model
from riglens.core.rig.model import Camera, LinearAngles, Rig, Sensor
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, build_pog
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.sensing.rays import farthest_m, sensor_rays
from tests.bench.yardsticks import PlainDda

THREADS = 2
NATIVE_CAST = (1600, 900)
DENSE_AZIMUTHS = LinearAngles(from_=-180.0, to=180.0, count=3600)
DENSE_BEAMS = LinearAngles(from_=-25.0, to=25.0, count=128)
TILT_DEG = (3.0, -4.0, 0.0)
POSES_DEG = {"upright": (0.0, 0.0, 8.0), "tilted": (2.0, -3.0, 8.0)}
"""How sensors of the library are turned: roll, pitch, yaw."""
_STEP_M = np.array([0.618034, 0.414214, 0.732051])
_REACH_M = 0.2
GridRays = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True)
class Scene:
    """The bundled scenario on one grid."""

    pog: Pog
    field: EntropyField

    @property
    def edge(self) -> str:
        """The voxel edge for a line of the table."""
        return f"δ {self.field.grid.voxel_m:g} m"

    def engine(self, threads: int = THREADS) -> Engine:
        """A new engine, by default with the number of threads of the bars."""
        return Engine(self.field, threads)

    @cached_property
    def plain(self) -> PlainDda:
        """The yardstick with its dense arrays."""
        return PlainDda([self.dense(self.field.entropy_nat(cls)) for cls in range(len(CLASSES))])

    def dense(self, values: NDArray[np.float64]) -> NDArray[np.float32]:
        """Values of the informative voxels as a dense array (nx, ny, nz)."""
        result = np.zeros(self.field.grid.shape, np.float32)
        i, j, k = self.field.index.ijk().T
        result[i, j, k] = values
        return result


@dataclass
class Scenes:
    """Scenes by voxel edge; `coarsen` multiplies every edge that is asked for."""

    coarsen: float = 1.0
    _built: dict[float, Scene] = field(default_factory=dict)

    def at(self, voxel_m: float) -> Scene:
        """The scene on a grid of that edge in metres, times `coarsen`."""
        edge_m = voxel_m * self.coarsen
        if edge_m not in self._built:
            pog = build_pog(bundled_source(), VoxelGrid(edge_m))
            self._built[edge_m] = Scene(pog, EntropyField.from_pog(pog))
        return self._built[edge_m]


@dataclass(frozen=True)
class Move:
    """A rig in which one sensor has moved, and the rays of that sensor for the yardstick."""

    rig: Rig
    sensor: Sensor
    origin: NDArray[np.float64]
    directions: NDArray[np.float64]


def wide_trapezoid(change: Callable[[Sensor], Sensor] = lambda sensor: sensor) -> Rig:
    """W+T, each sensor changed."""
    rig = preset("W+T")
    return rig.model_copy(update={"sensors": tuple(change(sensor) for sensor in rig.sensors)})


def tilted(sensor: Sensor) -> Sensor:
    """The sensor rolled and pitched by a few degrees."""
    roll, pitch, yaw = (a + b for a, b in zip(sensor.rpy_deg, TILT_DEG, strict=True))
    return sensor.model_copy(update={"rpy_deg": (roll, pitch, yaw)})


def dense_rays(sensor: Sensor) -> Sensor:
    """A camera that casts all its pixels, a LiDAR with 128 beams and 3,600 azimuths."""
    if isinstance(sensor, Camera):
        return sensor.model_copy(update={"cast": NATIVE_CAST})
    return sensor.model_copy(update={"elevations_deg": DENSE_BEAMS, "azimuths_deg": DENSE_AZIMUTHS})


def names_of(rig: Rig, kind: str) -> list[str]:
    """Names of the sensors of a kind, in order."""
    return [sensor.name for sensor in rig.sensors if sensor.kind == kind]


@lru_cache
def car(name: str) -> Rig:
    """Return a car that is built, or a larger one, by its name; its body is solid."""
    if name == "60 sensors":
        production = preset("production car")
        more = [
            one.model_copy(update={"name": f"{one.name}_{turn}"})
            for turn in "ABC"
            for one in production.sensors
        ]
        return production.model_copy(update={"sensors": tuple(more[:60])})
    if name not in ("production car", "Waymo car"):
        corners = [(1.8, 0.7), (1.8, -0.7), (-1.8, 0.7), (-1.8, -0.7)]
        lidars = [
            sensor_from_model(
                "ouster-os1-128", f"LIDAR_{number}", Pose((x, y, 1.7), (2.0, 3.0, 90.0 * number))
            )
            for number, (x, y) in enumerate(corners)
        ]
        cameras = [
            sensor_from_model(
                "generic-front-8mp-120", f"CAM_{number}", Pose((0.0, 0.0, 1.6), (0.0, 4.0, 45.0 * number))
            )
            for number in range(8)
        ]
        return preset("production car").model_copy(update={"name": name, "sensors": (*lidars, *cameras)})
    return preset(name)


def moved(sensor: Sensor, number: int) -> Sensor:
    """The sensor at another place within some centimetres of the old one, never the same twice."""
    shift_m = ((number * _STEP_M) % 1.0 - 0.5) * _REACH_M
    x, y, z = (float(p + s) for p, s in zip(sensor.position, shift_m, strict=True))
    return sensor.model_copy(update={"position": (x, y, z)})


def moves(scene: Scene, rig: Rig, names: Sequence[str]) -> Iterator[Move]:
    """The rig with one sensor moved a little, then the next one, without end; the yardstick is cleared."""
    start, number = rig, 0
    while True:
        number += 1
        name = names[number % len(names)]
        sensor = moved(start.sensor(name), number)
        rig = rig.with_sensor(name, sensor)
        scene.plain.clear()
        yield Move(rig, sensor, *grid_rays(scene, sensor))


def grid_rays(scene: Scene, sensor: Sensor) -> GridRays:
    """Origin (3,) in grid units and directions (n, 3) of a sensor's rays."""
    return np.array(scene.field.grid.to_grid(sensor.position)), sensor_rays(sensor).directions


def reach_of(scene: Scene, sensor: Sensor) -> tuple[float, float]:
    """From where to where a sensor's rays go, in voxels; without end where they leave the grid before it."""
    grid = scene.field.grid
    near, far = (limit / grid.voxel_m for limit in (sensor.range_m[0], farthest_m(sensor)))
    place, shape = np.array(grid.to_grid(sensor.position)), np.array(grid.shape)
    farthest = float(np.linalg.norm(np.maximum(np.abs(place), np.abs(shape - place))))
    return near, far if far < farthest else math.inf


def plain_edit(scene: Scene, move: Move) -> list[float]:
    """The yardstick of an edit: cast the moved sensor, then sum over all voxels for three classes."""
    scene.plain.cast(move.origin, move.directions, reach_of(scene, move.sensor))
    return scene.plain.sums()


def competent_edit(scene: Scene, move: Move) -> list[float]:
    """The same by a competent program: one sum over all three classes that skips what is not seen."""
    scene.plain.cast(move.origin, move.directions, reach_of(scene, move.sensor))
    return scene.plain.sums_at_once()


@lru_cache(maxsize=1)
def models() -> Library:
    """The sensor models that ship with the program, and no others."""
    return Library(read_entries(asset_path("library.yaml"), "library.yaml"))


def with_model(model: str, pose: str) -> tuple[Rig, str]:
    """W+T with a model of the library in the place of its first sensor of that kind, or its first LiDAR, turned by
    `POSES_DEG`; its name."""
    entry, rig = models().entry(model), wide_trapezoid()
    name = (names_of(rig, entry.kind) or names_of(rig, "lidar"))[0]
    place = Pose(position_m=rig.sensor(name).position, rpy_deg=POSES_DEG[pose])
    return rig.with_sensor(name, entry.sensor(name, place)), name


def way_taken(scene: Scene, sensor: Sensor) -> str:
    """The way by which the engine casts a sensor, as its caster says it: the first one whose turn comes."""
    witness = _Witness(scene.field)
    words = np.zeros_like(scene.field.index.words)
    witness.mark(sensor, "exact", witness.window(sensor), words)
    return witness.ways[0]


class _Witness(Caster):
    """A caster that notes the ways it takes."""

    def __init__(self, field: EntropyField) -> None:
        super().__init__(field)
        self.ways: list[str] = []

    def _mark_fan(self, *arguments: Any) -> bool:
        self.ways.append("fan")
        return super()._mark_fan(*arguments)

    def _mark_frustum(self, *arguments: Any) -> bool:
        self.ways.append("voxels")
        return super()._mark_frustum(*arguments)

    def _mark_mesh(self, *arguments: Any) -> bool:
        self.ways.append("mesh")
        return super()._mark_mesh(*arguments)

    def _mark_sheets(self, *arguments: Any) -> bool:
        self.ways.append("sheets")
        return super()._mark_sheets(*arguments)

    def _mark_rays(self, *arguments: Any) -> bool:
        self.ways.append("rays")
        return super()._mark_rays(*arguments)


def require_same_answer(scene: Scene, sensor: Sensor) -> None:
    """Fail when engine and yardstick do not see the same entropy with this sensor alone."""
    evaluation = scene.engine().evaluate(Rig(sensors=(sensor,)))
    scene.plain.clear()
    scene.plain.cast(*grid_rays(scene, sensor), reach_of(scene, sensor))
    sums = scene.plain.sums()
    assert np.allclose(sums, scene.plain.sums_at_once(), rtol=1e-9)
    for name, plain_nat in zip(CLASSES, sums, strict=True):
        score = evaluation.scores.classes[name]
        ours_nat = -score.kinds[sensor.kind].s_mig
        assert abs(ours_nat - plain_nat) <= 1e-4 * max(1.0, plain_nat), (name, ours_nat, plain_nat)
