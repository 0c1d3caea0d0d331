"""Write the measurements of a CARLA session as a data set of the same files as a simulated one, and as tables of boxes.

The boxes and poses of the car are also written as tables that other commands read.
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import atomic_write, write_files
from riglens.core.rig.model import Camera, Lidar, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES, DataReport, FrameLabels, Progress
from riglens.core.scene.occluders import MapPose
from riglens.core.simulate.carla_session import CAMERAS, STEP_S, Session, Tick, mirrored
from riglens.core.simulate.channels import Channel, channels_of
from riglens.core.simulate.dataset import PLAN, require_channels, write_tables
from riglens.core.simulate.pictures import LABELS
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import GROUND, Sweep
from riglens.core.simulate.tables import Scene, Tables
from riglens.core.simulate.units import DEPTH_PER_M, Drawn, Extras, Notes, files_of_frame
from riglens.core.simulate.world import TrueBoxes, Worlds
from riglens.core.targets.traffic import Traffic, traffic_of

WITHIN_M = 120.0
"""Objects farther away are left out."""
BOX_COLUMNS = ("seq", "frame", "cls", "x", "y", "z", "length", "width", "height", "yaw")
POSE_COLUMNS = ("seq", "frame", "map", "x", "y", "z", "yaw")
_TAGS = {
    "car": (14, 15, 16),
    "bicycle": (13, 18, 19),
    "pedestrian": (12,),
    "ground": (1, 2, 10, 24, 25),
    "sky": (11,),
    "none": (0,),
}
"""CARLA's tags (CityObjectLabel from version 0.9.14 on) that are not static; riders belong to their bicycle."""
_FARTHEST_M = 1000.0
"""Largest depth of CARLA."""


@dataclass(frozen=True)
class Wanted:
    """Frames to collect: one in `every` ticks."""

    frames: int = 200
    every: int = 10

    def __post_init__(self) -> None:
        if not 1 <= self.frames <= 1_000_000:
            raise InputError(f"must be an integer from 1 to 1,000,000 (got {self.frames})", "frames")
        if self.every < 1:
            raise InputError(f"must be an integer ≥ 1 (got {self.every})", "every")


@dataclass
class Collection:
    """Frames collected so far, whose files are complete; `sequence` is their name."""

    rig: Rig
    settings: SimulationSettings
    extras: Extras
    folder: Path
    sequence: str
    every: int
    ticks: list[Tick] = field(default_factory=list)
    notes: dict[int, Notes] = field(default_factory=dict)

    @property
    def scene(self) -> Scene:
        """All frames as one scene."""
        frames = tuple(range(len(self.ticks)))
        return Scene(0, f"sim-0000-{self.sequence}", frames, frames, self.every * STEP_S)

    def add(self, tick: Tick) -> None:
        """Write the files of a tick, and remember its boxes."""
        number = len(self.ticks)
        stem, channels = self.scene.stem(number), require_channels(self.rig, self.extras)
        truth, sweep = true_boxes(tick), sweep_of(tick, self.rig)
        cameras = self.rig.enabled_cameras() if self.extras.pictures else ()
        drawn = [_drawn(tick, camera) for camera in cameras]
        files, counted = files_of_frame(stem, channels, self.rig, truth, sweep, drawn)
        write_files(self.folder, files)
        inside = counted.tolist()
        self.ticks.append(Tick(tick.rotation, tick.place_m, tick.actors, {}))
        self.notes[number] = {
            "points": len(sweep.object),
            "inside": inside,
            "hits": inside,
            "visible": [None] * len(inside),
            "boxes_2d": [[] for _ in self.rig.enabled_cameras()],
            "track": [actor.number for actor in _near(tick)],
        }

    def finish(self) -> None:
        """Write the tables of the data set, and those of boxes and poses."""
        traffic, scenes = self.traffic(), [self.scene]
        poses = {number: self._pose(tick) for number, tick in enumerate(self.ticks)}
        worlds, channels = Worlds(traffic, self.settings), channels_of(self.rig, self.extras.pictures)
        tables = Tables(f"{self.rig.name} carla", self.rig, channels, scenes, worlds, poses, self.notes)
        write_tables(self.folder, tables)
        self._write_boxes()
        with atomic_write(self.folder / PLAN, "w") as stream:
            stream.write(json.dumps(self._plan(channels), indent=1) + "\n")

    def traffic(self) -> Traffic:
        """Return the objects of all frames."""
        truths = [true_boxes(tick) for tick in self.ticks]
        frames, numbers = len(truths), np.arange(len(truths))
        cls = np.concatenate([np.zeros(0, np.uint8), *(truth.cls for truth in truths)])
        counts = {name: int(np.count_nonzero(cls == k)) for k, name in enumerate(CLASSES)}
        labels = FrameLabels((self.sequence,), np.zeros(frames, np.int64), numbers)
        return traffic_of(
            DataReport("CARLA", frames, counts, labels=labels),
            np.repeat(numbers, [len(truth.cls) for truth in truths]),
            cls,
            np.concatenate([np.zeros((0, 3)), *(truth.centre_m for truth in truths)]),
            np.concatenate([np.zeros((0, 3)), *(truth.size_m for truth in truths)]),
            np.concatenate([np.zeros((0, 3, 3)), *(truth.rotation for truth in truths)]),
        )

    def _write_boxes(self) -> None:
        with atomic_write(self.folder / "boxes.csv", "w") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(BOX_COLUMNS)
            for number, tick in enumerate(self.ticks):
                truth = true_boxes(tick)
                for user, cls in enumerate(truth.cls.tolist()):
                    place, size = truth.centre_m[user].tolist(), truth.size_m[user].tolist()
                    numbers = (f"{value:.4f}" for value in (*place, *size, truth.yaw_rad[user]))
                    writer.writerow([self.sequence, number, CLASSES[cls], *numbers])
        with atomic_write(self.folder / "poses.csv", "w") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(POSE_COLUMNS)
            for number, tick in enumerate(self.ticks):
                pose = self._pose(tick)
                numbers = (f"{value:.5f}" for value in (*pose.position_m, pose.yaw_rad))
                writer.writerow([self.sequence, number, pose.map, *numbers])

    def _pose(self, tick: Tick) -> MapPose:
        """Return the place and yaw of the car; that it leans with the road is in the boxes alone."""
        x, y, z = tick.place_m.tolist()
        yaw_rad = float(np.arctan2(tick.rotation[1, 0], tick.rotation[0, 0]))
        return MapPose(self.sequence, (x, y, z), yaw_rad)

    def _plan(self, channels: list[Channel]) -> dict[str, Any]:
        return {
            "riglens": 1,
            "carla": {
                "town": self.sequence,
                "frames": len(self.ticks),
                "step_s": self.every * STEP_S,
                "noise_m": self.settings.noise_m,
                "dropout": self.settings.dropout,
                "pictures": self.extras.pictures,
            },
            "rig": identity_of(self.rig),
            "channels": [channel.name for channel in channels],
            "labels": list(LABELS),
            "depth": "centimetres along the axis of the camera, 0: none",
            "classes": list(CLASSES),
        }


def collect(session: Session, to: Collection, wanted: Wanted, progress: Progress) -> None:
    """Collect frames up to the requested number."""
    while len(to.ticks) < wanted.frames:
        for _ in range(wanted.every - 1):
            session.tick()
        to.add(session.tick())
        progress(len(to.ticks) / wanted.frames)


# ---------------------------------------------------------------- from a tick to what the files hold


def _near(tick: Tick) -> list[Any]:
    return [actor for actor in tick.actors if np.hypot(*(actor.centre_m - tick.place_m)[:2]) <= WITHIN_M]


def true_boxes(tick: Tick) -> TrueBoxes:
    """Return the objects around the car in the vehicle frame."""
    actors = _near(tick)
    centres = np.array([actor.centre_m for actor in actors]).reshape(-1, 3)
    return TrueBoxes(
        np.array([actor.cls for actor in actors], np.uint8),
        (centres - tick.place_m) @ tick.rotation,
        np.array([actor.size_m for actor in actors]).reshape(-1, 3),
        tick.rotation.T @ np.array([actor.rotation for actor in actors]).reshape(-1, 3, 3),
        np.arange(len(actors)),
    )


def sweep_of(tick: Tick, rig: Rig) -> Sweep:
    """Return the points of all LiDARs in the vehicle frame; their surfaces are unknown: all are GROUND."""
    parts = [_points_of(lidar, tick.data[lidar.name]) for lidar in rig.enabled_lidars()]
    counts = [len(points) for points, _, _ in parts]
    empty = (np.zeros((0, 3)), np.zeros(0), np.zeros(0, np.int64))
    points, bright, ring = (np.concatenate(columns) for columns in zip(empty, *parts, strict=True))
    sensor = np.repeat(np.arange(len(parts)), counts).astype(np.int16)
    nobody = np.zeros(0, np.int64)
    return Sweep(
        points.astype(np.float32),
        bright.astype(np.float32),
        ring.astype(np.int16),
        np.zeros(len(points), np.float32),
        sensor,
        np.full(len(points), GROUND, np.int32),
        nobody,
        nobody,
    )


def _points_of(lidar: Lidar, sent: Any) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return places in the vehicle frame, intensities of 0 to 255, and beams as the rig lists them; CARLA sends channel
    by channel, the highest beam first."""
    records = np.frombuffer(sent.raw_data, np.float32).reshape(-1, 4).astype(np.float64)
    places = mirrored(records[:, :3]) @ lidar.pose.rotation().T + np.array(lidar.position)
    counts = [int(sent.get_point_count(channel)) for channel in range(lidar.beam_count)]
    from_above = np.argsort(-lidar.elevations(), kind="stable")
    ring = np.repeat(from_above, counts) if sum(counts) == len(records) else np.zeros(len(records), np.int64)
    return places, 255.0 * records[:, 3], ring


def _drawn(tick: Tick, camera: Camera) -> Drawn:
    rgb, tags, depth = (_pixels(tick.data[f"{camera.name} {kind}"]) for kind in CAMERAS)
    return Drawn(np.ascontiguousarray(rgb[:, :, 2::-1]), labels_of(tags), depth_of(depth))


def _pixels(sent: Any) -> NDArray[np.uint8]:
    return np.frombuffer(sent.raw_data, np.uint8).reshape(sent.height, sent.width, 4)


def labels_of(bgra: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the places in LABELS of CARLA's tags, which are in the red channel."""
    table = np.full(256, LABELS.index("static"), np.uint8)
    for name, tags in _TAGS.items():
        table[list(tags)] = LABELS.index(name)
    return np.asarray(table[bgra[:, :, 2]])


def depth_of(bgra: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Convert CARLA's depth in three channels to centimetres along the axis of the camera, 0 where there is nothing."""
    blue, green, red = (bgra[:, :, channel].astype(np.float64) for channel in (0, 1, 2))
    metres = (red + 256.0 * green + 65536.0 * blue) / (256.0**3 - 1.0) * _FARTHEST_M
    return np.where(metres < 655.0, metres * DEPTH_PER_M + 0.5, 0.0).astype(np.uint16)
