"""A study that takes seconds: eight short sequences of a few road users, rigs of a few rays, a small region."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from riglens.core.detect.net import Machine
from riglens.core.detect.pillars import Region
from riglens.core.geometry import Pose
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.scene.boxes import CLASSES, DataReport, FrameLabels, rotations_from_yaw
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.study.detection.protocol import Protocol, entrants
from riglens.core.targets.traffic import Traffic, traffic_of

SEQUENCES, FRAMES_EACH = 8, 4
PROTOCOL = Protocol(
    seeds=2,
    epochs=2,
    train_frames=12,
    test_frames=10,
    region=Region(16.0, 16.0),
    simulation=SimulationSettings(clutter=10),
)
NOWHERE = Machine("cpu", False, "not asked")
"""For studies of which nothing is computed."""
_SIZES = np.array([[4.4, 1.9, 1.5], [1.8, 0.7, 1.7], [0.6, 0.6, 1.8]])


def traffic(sequences: int = SEQUENCES, frames_each: int = FRAMES_EACH, classes: int = 3) -> Traffic:
    """Frames with three road users each, of the first `classes` classes."""
    rng = np.random.default_rng(1)
    frames = sequences * frames_each
    frame = np.repeat(np.arange(frames), 3)
    cls = rng.integers(0, classes, len(frame)).astype(np.uint8)
    size = _SIZES[cls]
    ring = rng.uniform(3.5, 7.5, len(frame)) * np.exp(1j * rng.uniform(0, 2 * np.pi, len(frame)))
    centre = np.stack([ring.real, ring.imag, size[:, 2] / 2], axis=1)
    boxes = {name: int((cls == number).sum()) for number, name in enumerate(CLASSES)}
    number = np.arange(frames)
    names = tuple(f"drive {place}" for place in range(sequences))
    labels = FrameLabels(names, number // frames_each, number % frames_each)
    report = DataReport("small", frames, boxes, sha256="small", sequences=sequences, labels=labels)
    return traffic_of(report, frame, cls, centre, size, rotations_from_yaw(rng.uniform(-3, 3, len(frame))))


def rig(name: str, beams: int = 8, height_m: float = 2.0) -> Rig:
    """One LiDAR on the roof."""
    lidar = sensor_from_model("generic-16", "LIDAR", Pose((0.0, 0.0, height_m), (0.0, 0.0, 0.0)))
    assert isinstance(lidar, Lidar)
    lidar = lidar.replace(
        elevations_deg=LinearAngles(from_=-25.0, to=5.0, count=beams),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=90),
    )
    return Rig(name=name, sensors=(lidar,))


def digest(parts: Mapping[str, Protocol], rigs_of: Callable[[str], Sequence[Rig]]) -> str:
    """The SHA-256 of everything that was fixed before a study: rigs and protocols of all parts."""
    plain = {
        part: {
            "protocol": how.as_dict(),
            "rigs": [one.key for one in entrants(rigs_of(part), how.kinds)],
        }
        for part, how in parts.items()
    }
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()
