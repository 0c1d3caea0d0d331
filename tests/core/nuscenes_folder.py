"""Writes nuScenes tables whose boxes are known in the ego frame; the maths is scipy's, not the product's."""

import gzip
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

CATEGORIES = (
    "vehicle.car",
    "vehicle.bicycle",
    "human.pedestrian.adult",
    "static_object.bicycle_rack",
    "movable_object.trafficcone",
)


@dataclass(frozen=True)
class EgoBox:
    """One annotation as it should come out: scene, sample in it, category, and the box in the ego frame."""

    scene: int
    sample: int
    category: str
    centre_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    rotation: Rotation


def random_boxes(scenes: int, samples: int, per_sample: int, seed: int = 1) -> list[EgoBox]:
    """Boxes around the car, turned anyhow."""
    random = np.random.default_rng(seed)
    return [
        EgoBox(
            scene,
            sample,
            CATEGORIES[int(random.integers(len(CATEGORIES)))],
            random.uniform([-40, -30, 0], [40, 30, 2]),
            random.uniform([0.5, 0.5, 0.5], [6, 2, 2]),
            Rotation.random(random_state=int(random.integers(1 << 31))),
        )
        for scene in range(scenes)
        for sample in range(samples)
        for _ in range(per_sample)
    ]


def write_tables(folder: Path, boxes: list[EgoBox], scenes: int, samples: int, seed: int = 2) -> Path:
    """The tables that hold `boxes`; annotations stand grouped by object, samples in any order, as in the original."""
    random = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    poses = {
        (scene, sample): (
            Rotation.from_euler("ZYX", random.uniform([-180, -3, -3], [180, 3, 3]), degrees=True),
            random.uniform([300, 700, 0], [1800, 1900, 0]),
        )
        for scene in range(scenes)
        for sample in range(samples)
    }
    tables: dict[str, list[dict[str, object]]] = {
        "sensor": [
            {"token": "s-lidar", "channel": "LIDAR_TOP", "modality": "lidar"},
            {"token": "s-cam", "channel": "CAM_FRONT", "modality": "camera"},
        ],
        "calibrated_sensor": [
            {"token": f"c-{kind}-{scene}", "sensor_token": f"s-{kind}", "translation": [0.9, 0.0, 1.8]}
            for scene in range(scenes)
            for kind in ("lidar", "cam")
        ],
        "category": [{"token": f"k-{name}", "name": name} for name in CATEGORIES],
        "sample": [],
        "sample_data": [],
        "ego_pose": [],
        "instance": [],
        "sample_annotation": [],
    }
    for (scene, sample), (rotation, place) in poses.items():
        _write_sample(tables, scene, sample, rotation, place, random)
    for number, box in enumerate(boxes):
        _write_annotation(tables, number, box, *poses[box.scene, box.sample])
    for name in ("sample", "sample_data", "ego_pose", "instance"):
        random.shuffle(tables[name])
    tables["sample_annotation"].sort(key=lambda record: str(record["instance_token"])[::-1])
    for name, records in tables.items():
        (folder / f"{name}.json").write_text(json.dumps(records, indent=0), encoding="utf-8")
    return folder


def _write_sample(tables, scene, sample, rotation, place, random) -> None:  # type: ignore[no-untyped-def]
    """A sample, its key frames of LiDAR and camera, and a sweep between; each has a pose of its own."""
    token = f"sample-{scene}-{sample}"
    tables["sample"].append(
        {
            "token": token,
            "timestamp": 10**15 + scene * 10**9 + sample * 500_000,
            "scene_token": f"scene-{scene}",
        }
    )
    for kind, key_frame in (("lidar", True), ("lidar", False), ("cam", True)):
        is_it = kind == "lidar" and key_frame
        turn = rotation if is_it else Rotation.random(random_state=int(random.integers(1 << 31)))
        pose = f"pose-{kind}-{key_frame}-{token}"
        tables["sample_data"].append(
            {
                "token": f"data-{pose}",
                "sample_token": token,
                "ego_pose_token": pose,
                "calibrated_sensor_token": f"c-{kind}-{scene}",
                "is_key_frame": key_frame,
                "filename": "…",
            }
        )
        where = place if is_it else random.uniform(0, 900, 3)
        tables["ego_pose"].append(
            {"token": pose, "timestamp": 1, "rotation": _wxyz(turn), "translation": where.tolist()}
        )


def _write_annotation(tables, number, box, rotation, place) -> None:  # type: ignore[no-untyped-def]
    instance = f"instance-{number % 7}-{box.category}"
    if all(record["token"] != instance for record in tables["instance"]):
        tables["instance"].append({"token": instance, "category_token": f"k-{box.category}"})
    length, width, height = box.size_m.tolist()
    tables["sample_annotation"].append(
        {
            "token": f"annotation-{number}",
            "sample_token": f"sample-{box.scene}-{box.sample}",
            "instance_token": instance,
            "attribute_tokens": [],
            "translation": (rotation.apply(box.centre_m) + place).tolist(),
            "size": [width, length, height],
            "rotation": _wxyz(rotation * box.rotation),
        }
    )


def _wxyz(rotation: Rotation) -> list[float]:
    x, y, z, w = rotation.as_quat().tolist()
    return [w, x, y, z]


def compress(folder: Path) -> None:
    """Turn every table into a gzip-compressed one."""
    for file in folder.glob("*.json"):
        file.with_suffix(".json.gz").write_bytes(gzip.compress(file.read_bytes()))
        file.unlink()
