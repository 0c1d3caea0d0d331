"""A small data set for the tests: few frames, two sequences, a car with LiDARs and a camera."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.pieces.folder import sole_run
from riglens.core.pieces.work import OwnProcess, Workers, results
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Sensor
from riglens.core.scene.boxes import FrameLabels
from riglens.core.scene.occluders import MapPose
from riglens.core.simulate.dataset import Dataset, DatasetFolder, scenes_of
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.units import Extras
from riglens.core.targets.traffic import Traffic
from tests.core.targets.cases import Box, traffic

SETTINGS = SimulationSettings(seed=3, clutter=20)
BARE = SimulationSettings(noise_m=0.0, dropout=0.0, clutter=0, ground="none")
"""Only objects: as many points on them as the targets engine counts."""


def lidar(name: str, x_m: float, yaw_deg: float = 0.0) -> Lidar:
    return Lidar(
        name=name,
        position=(x_m, 0.3, 1.9),
        rpy_deg=(1.0, -2.0, yaw_deg),
        elevations_deg=LinearAngles(from_=-24.0, to=4.0, count=16),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=360),
        range_m=(0.5, 100.0),
    )


CAMERA = Camera(name="CAM_FRONT", position=(1.2, 0.0, 1.5), hfov_deg=80.0, image=(160, 90), cast=(80, 45))


def rig(*sensors: Sensor) -> Rig:
    return Rig(name="small", sensors=sensors or (lidar("left", -0.5), lidar("right", 0.5, 30.0), CAMERA))


def road_users(frames: int = 8, users: int = 9) -> Traffic:
    """Two sequences; none in the second frame; cars, bicycles and pedestrians of usual sizes around the car."""
    rng = np.random.default_rng(11)
    sizes = ((4.4, 1.8, 1.6), (1.8, 0.6, 1.7), (0.6, 0.6, 1.75))
    boxes: list[Box] = []
    for frame in range(frames):
        for user in range(0 if frame == 1 else users):
            far, turn = rng.uniform(6.0, 35.0), rng.uniform(-np.pi, np.pi)
            size = sizes[user % 3]
            place = (float(far * np.cos(turn)), float(far * np.sin(turn)), size[2] / 2)
            boxes.append((frame, user % 3, place, size, float(rng.uniform(-np.pi, np.pi))))
    found, half = traffic(boxes, frames=frames), frames // 2
    sequence = (np.arange(frames) >= half).astype(np.int64)
    labels = FrameLabels(("first run", "2/b"), sequence, np.arange(frames) - half * sequence)
    return replace(found, data=replace(found.data, labels=labels))


def dataset(traffic: Traffic | None = None, of: Rig | None = None, points: bool = True) -> Dataset:
    """Five scenes' worth of splits would take five sequences: the second of these is made one for validation."""
    world = road_users() if traffic is None else traffic
    poses = {
        frame: MapPose("town", (100.0 + 3.0 * frame, 50.0, 0.0), 0.3 * frame) for frame in range(world.frames)
    }
    scenes = scenes_of(world)
    scenes = [replace(scene, number=4 * scene.number) for scene in scenes]
    return Dataset(of or rig(), SETTINGS, Extras(True, points), world, scenes, poses)


def points_m(path: Path) -> NDArray[np.float64]:
    """Points (n, 3) of a sweep's file, in the frame of its LiDAR."""
    return np.fromfile(path, np.float32).reshape(-1, 5)[:, :3].astype(np.float64)


def make(
    path: Path,
    what: Dataset,
    progress: Callable[[float], None] = lambda _: None,
    workers: Workers | None = None,
) -> list[str]:
    """The whole data set, in this process unless there are workers; which parts were made."""
    folder = DatasetFolder(path, what)
    missing = folder.missing()
    with sole_run(folder.work):
        folder.begin()
        made = results([what.piece(key) for key in missing], folder, workers or OwnProcess())
        for done, _ in enumerate(made, 1):
            progress(done / len(missing))
        folder.finish()
    return missing
