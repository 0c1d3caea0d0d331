"""Write the thirteen tables of nuScenes, and splits and 2D boxes with them, record by record.

Source of the format: docs/schema_nuscenes.md of the nuScenes development kit.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.scene.occluders import MapPose
from riglens.core.simulate.channels import Channel, ego_origin_m, quaternions
from riglens.core.simulate.units import Notes
from riglens.core.simulate.world import TrueBoxes, Worlds

Record = dict[str, Any]
CATEGORIES = {
    "vehicle.car": "Motor vehicles on four or more wheels.",
    "vehicle.bicycle": "Bicycles and motorcycles, ridden or not.",
    "human.pedestrian.adult": "People.",
}
"""Categories in the order of the classes, and their meaning here."""
ATTRIBUTES = (
    "vehicle.moving", "vehicle.stopped", "vehicle.parked", "cycle.with_rider", "cycle.without_rider",
    "pedestrian.sitting_lying_down", "pedestrian.standing", "pedestrian.moving",
)  # fmt: skip
VISIBLE = ("v0-40", "v40-60", "v60-80", "v80-100")
SAMPLE_S = 0.5
"""Time between frames in the tables, as in nuScenes; the data do not say it."""
_START_US = 1_600_000_000_000_000
MAP_FILE = "maps/plain.png"
TRAIN, VAL = "riglens_train", "riglens_val"
VAL_EVERY = 5
"""One of this many sequences is for validation."""


@dataclass(frozen=True)
class Scene:
    """A sequence: its number and name in the data, and the frames of it that are simulated, in order of time; of each
    its place in the sequence; and the time between two places, seconds."""

    number: int
    name: str
    frames: tuple[int, ...]
    places: tuple[int, ...]
    step_s: float = SAMPLE_S

    @property
    def is_val(self) -> bool:
        """Return whether it is for validation."""
        return self.number % VAL_EVERY == VAL_EVERY - 1

    def time_us(self, place: int) -> int:
        """Return the time stamp of a frame by its place in the sequence."""
        return _START_US + self.number * 100_000_000_000 + round(place * self.step_s * 1e6)

    def stem(self, place: int) -> str:
        """Return the stem of the names of a frame's files; `{}` stands for the channel."""
        return f"{self.name}__{{}}__{self.time_us(place)}"


class Tables:
    """Writer of the tables of a data set whose tokens begin with `key`, from the notes of its frames."""

    def __init__(
        self,
        key: str,
        rig: Rig,
        channels: Sequence[Channel],
        scenes: Sequence[Scene],
        worlds: Worlds,
        poses: Mapping[int, MapPose],
        notes: Mapping[int, Notes],
    ) -> None:
        self._key, self._rig, self._channels, self._scenes = key, rig, channels, scenes
        self._worlds, self._poses, self._notes = worlds, poses, notes

    def token(self, *what: object) -> str:
        """Return a token that belongs to something of this data set."""
        return hashlib.sha256(f"{self._key} {what}".encode()).hexdigest()[:32]

    def all(self) -> Iterator[tuple[str, Iterator[Record]]]:
        """Yield names and records of the tables, and of image_annotations."""
        yield "category", self._categories()
        yield (
            "attribute",
            ({"token": self.token("attribute", n), "name": n, "description": ""} for n in ATTRIBUTES),
        )
        yield "visibility", self._visibility()
        yield "sensor", self._sensors()
        yield "calibrated_sensor", self._calibrated()
        yield "log", self._logs()
        yield "map", self._maps()
        yield "scene", self._scene_records()
        yield "sample", self._samples()
        yield "sample_data", self._sample_data()
        yield "ego_pose", self._ego_poses()
        yield "instance", self._instances()
        yield "sample_annotation", self._annotations()
        yield "image_annotations", self._boxes_2d()

    def splits(self) -> dict[str, list[str]]:
        """Return the names of the scenes for training and validation."""
        return {
            TRAIN: [scene.name for scene in self._scenes if not scene.is_val],
            VAL: [scene.name for scene in self._scenes if scene.is_val],
        }

    # ---------------------------------------------------------------- what does not depend on frames

    def _categories(self) -> Iterator[Record]:
        for number, (name, words) in enumerate(CATEGORIES.items()):
            yield {
                "token": self.token("category", number),
                "name": name,
                "description": words,
                "index": number,
            }

    def _visibility(self) -> Iterator[Record]:
        for number, level in enumerate(VISIBLE, 1):
            words = f"visibility of whole object is between {level[1:].replace('-', ' and ')}%"
            yield {"token": str(number), "level": level, "description": words}

    def _sensors(self) -> Iterator[Record]:
        for one in self._channels:
            yield {"token": self.token("sensor", one.name), "channel": one.name, "modality": one.modality}

    def _calibrated(self) -> Iterator[Record]:
        turns = quaternions(np.array([one.rotation for one in self._channels]))
        for one, turn in zip(self._channels, turns, strict=True):
            yield {
                "token": self.token("calibrated", one.name),
                "sensor_token": self.token("sensor", one.name),
                "translation": one.place_m.tolist(),
                "rotation": turn.tolist(),
                "camera_intrinsic": [] if one.intrinsic is None else one.intrinsic.tolist(),
            }

    def _logs(self) -> Iterator[Record]:
        for scene in self._scenes:
            yield {
                "token": self.token("log", scene.number),
                "logfile": scene.name,
                "vehicle": self._rig.name,
                "date_captured": "2020-09-13",
                "location": "simulated",
            }

    def _maps(self) -> Iterator[Record]:
        yield {
            "token": self.token("map"),
            "log_tokens": [self.token("log", scene.number) for scene in self._scenes],
            "category": "semantic_prior",
            "filename": MAP_FILE,
        }

    # ---------------------------------------------------------------- frames

    def _scene_records(self) -> Iterator[Record]:
        for scene in self._scenes:
            yield {
                "token": self.token("scene", scene.number),
                "log_token": self.token("log", scene.number),
                "nbr_samples": len(scene.frames),
                "first_sample_token": self.token("sample", scene.frames[0]),
                "last_sample_token": self.token("sample", scene.frames[-1]),
                "name": scene.name,
                "description": f"simulated, rig {self._rig.name}",
            }

    def _moments(self) -> Iterator[tuple[Scene, int, int, int | None, int | None]]:
        """Yield scene, frame, place in it, and the frames before and after."""
        for scene in self._scenes:
            beside = (None, *scene.frames, None)
            for k, (frame, place) in enumerate(zip(scene.frames, scene.places, strict=True)):
                yield scene, frame, place, beside[k], beside[k + 2]

    def _beside(self, kind: str, frame: int | None, *more: object) -> str:
        return "" if frame is None else self.token(kind, frame, *more)

    def _samples(self) -> Iterator[Record]:
        for scene, frame, place, before, after in self._moments():
            yield {
                "token": self.token("sample", frame),
                "timestamp": scene.time_us(place),
                "prev": self._beside("sample", before),
                "next": self._beside("sample", after),
                "scene_token": self.token("scene", scene.number),
            }

    def _sample_data(self) -> Iterator[Record]:
        for one in self._channels:
            for scene, frame, place, before, after in self._moments():
                yield {
                    "token": self.token("data", frame, one.name),
                    "sample_token": self.token("sample", frame),
                    "ego_pose_token": self.token("pose", frame),
                    "calibrated_sensor_token": self.token("calibrated", one.name),
                    "timestamp": scene.time_us(place),
                    "fileformat": "jpg" if one.modality == "camera" else "pcd",
                    "is_key_frame": True,
                    "height": one.size_px[1],
                    "width": one.size_px[0],
                    "filename": f"samples/{one.name}/{scene.stem(place).format(one.name)}{one.ending}",
                    "prev": self._beside("data", before, one.name),
                    "next": self._beside("data", after, one.name),
                }

    def _ego_poses(self) -> Iterator[Record]:
        for scene, frame, place, _, _ in self._moments():
            rotation, place_m = self._world_from_ego(frame)
            yield {
                "token": self.token("pose", frame),
                "timestamp": scene.time_us(place),
                "rotation": quaternions(rotation[None])[0].tolist(),
                "translation": place_m.tolist(),
            }

    def _world_from_ego(self, frame: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        pose = self._poses.get(frame, MapPose("", (0.0, 0.0, 0.0), 0.0))
        rotation = rotations_from_yaw(np.array([pose.yaw_rad]))[0]
        return rotation, np.array(pose.position_m) + rotation @ ego_origin_m(self._rig)

    # ---------------------------------------------------------------- objects

    def _users(self) -> Iterator[tuple[int, TrueBoxes, Notes]]:
        for _, frame, _, _, _ in self._moments():
            yield frame, self._worlds.truth(frame), self._notes[frame]

    @cached_property
    def _chains(self) -> list[list[tuple[int, int]]]:
        """Return frames and indices of each tracked object; one of each where identities are unknown."""
        followed, found = dict[object, list[tuple[int, int]]](), list[list[tuple[int, int]]]()
        for scene, frame, _, _, _ in self._moments():
            notes = self._notes[frame]
            for user, _ in enumerate(notes["inside"]):
                if "track" not in notes:
                    found.append([(frame, user)])
                    continue
                key = (scene.number, notes["track"][user])
                if key not in followed:
                    followed[key] = []
                    found.append(followed[key])
                followed[key].append((frame, user))
        return found

    @cached_property
    def _chain_of(self) -> dict[tuple[int, int], tuple[int, int]]:
        """Return the chain of each annotation, and its place in the chain."""
        return {one: (number, k) for number, chain in enumerate(self._chains) for k, one in enumerate(chain)}

    def _instances(self) -> Iterator[Record]:
        classes = {frame: truth.cls for frame, truth, _ in self._users()}
        for chain in self._chains:
            frame, user = chain[0]
            yield {
                "token": self.token("instance", *chain[0]),
                "category_token": self.token("category", int(classes[frame][user])),
                "nbr_annotations": len(chain),
                "first_annotation_token": self.token("annotation", *chain[0]),
                "last_annotation_token": self.token("annotation", *chain[-1]),
            }

    def _followed(self, frame: int, user: int) -> dict[str, str]:
        """Return the tokens of the instance of an annotation, and of those before and after it."""
        number, k = self._chain_of[frame, user]
        chain = self._chains[number]
        return {
            "instance_token": self.token("instance", *chain[0]),
            "prev": self.token("annotation", *chain[k - 1]) if k > 0 else "",
            "next": self.token("annotation", *chain[k + 1]) if k + 1 < len(chain) else "",
        }

    def _annotations(self) -> Iterator[Record]:
        for frame, truth, notes in self._users():
            if not len(truth.cls):
                continue
            rotation, place_m = self._world_from_ego(frame)
            centre = (truth.centre_m - ego_origin_m(self._rig)) @ rotation.T + place_m
            turns = quaternions(rotation @ truth.rotation)
            for user in range(len(truth.cls)):
                length, width, height = truth.size_m[user].tolist()
                yield {
                    "token": self.token("annotation", frame, user),
                    "sample_token": self.token("sample", frame),
                    **self._followed(frame, user),
                    "visibility_token": visibility_bin(notes["visible"][user]),
                    "attribute_tokens": [],
                    "translation": centre[user].tolist(),
                    "size": [width, length, height],
                    "rotation": turns[user].tolist(),
                    "num_lidar_pts": notes["inside"][user],
                    "num_radar_pts": 0,
                    "riglens_hits": notes["hits"][user],
                    "riglens_visible": notes["visible"][user],
                }

    def _boxes_2d(self) -> Iterator[Record]:
        """Yield the records of the kit's export_2d_annotations_as_json, but around the pixels that can be seen."""
        names = list(CATEGORIES)
        cameras = [one for one in self._channels if one.modality == "camera"]
        stems = {frame: scene.stem(place) for scene, frame, place, _, _ in self._moments()}
        for frame, truth, notes in self._users():
            for one in cameras:
                assert one.sensor is not None
                for user, x0, y0, x1, y1, pixels, alone in notes["boxes_2d"][one.sensor]:
                    yield {
                        "sample_data_token": self.token("data", frame, one.name),
                        "sample_annotation_token": self.token("annotation", frame, user),
                        **self._followed(frame, user),
                        "category_name": names[int(truth.cls[user])],
                        "attribute_tokens": [],
                        "visibility_token": visibility_bin(notes["visible"][user]),
                        "bbox_corners": [x0, y0, x1, y1],
                        "filename": f"samples/{one.name}/{stems[frame].format(one.name)}{one.ending}",
                        "num_lidar_pts": notes["inside"][user],
                        "num_radar_pts": 0,
                        "riglens_pixels": pixels,
                        "riglens_pixels_unhidden": alone,
                    }


def visibility_bin(share: float | None) -> str:
    """Return the token of nuScenes' bin of a visible share; objects that no sensor could see are in the lowest."""
    return "1" if share is None else str(1 + sum(share >= edge for edge in (0.4, 0.6, 0.8)))
