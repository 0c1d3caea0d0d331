"""Define the protocol of a detection study: frames, seeds, training and sweeps."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.net import Training
from riglens.core.detect.panorama import Panorama
from riglens.core.detect.pillars import Region
from riglens.core.detect.views import FEATURES as PICTURE_FEATURES
from riglens.core.detect.views import LEAST_PX
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import rig_sha256
from riglens.core.scene.boxes import DataReport
from riglens.core.simulate.painting import QUALITIES, Quality
from riglens.core.simulate.settings import SimulationSettings

Mode = Literal["shared", "per-rig"]
Detector = Literal["pillars", "range", "pictures"]
Kinds = Literal["lidars", "lidars and cameras", "cameras"]
"""Sensors of a rig that take part."""
Ids = NDArray[np.int64]

WORDING = "simulated LiDAR, small detector trained here: compares rigs, does not predict the AP of your stack"
LEAST_FRAMES, LEAST_SEQUENCES = 20, 4
TRAIN_SHARE = 0.6
CLUTTER = 120
"""Number of things in a frame that are not objects: pedestrians are then hard to tell even for the best rigs."""
MOST_SEEDS, MOST_EPOCHS = 100, 1000
_VERSION = 2
"""Counts up when pieces of before must not be used again."""


@dataclass(frozen=True)
class Protocol:
    """mode: one net for all rigs and the reference rigs, or one for each rig as in the paper. train_frames: of each
    rig, a draw of its own from the sequences for training; test_frames: the same for all rigs, spread evenly over the
    other sequences. Seeds are of the training: first weights, order, mirroring; sweeps are the same for all of them.
    cameras: how well they are segmented whose classes points get; None: cameras are left out. sweeps: how many of a
    rig make a sample, the last one at the frame. detector: a net over pillars, over a range image, or over pictures
    without LiDAR points.
    """

    mode: Mode = "shared"
    seeds: int = 3
    epochs: int = 12
    train_frames: int = 300
    test_frames: int = 500
    region: Region = field(default_factory=Region)
    simulation: SimulationSettings = field(default_factory=lambda: SimulationSettings(clutter=CLUTTER))
    cameras: Quality | None = None
    sweeps: int = 1
    detector: Detector = "pillars"

    def __post_init__(self) -> None:
        if not 1 <= self.seeds <= MOST_SEEDS:
            raise InputError(f"must be an integer from 1 to {MOST_SEEDS} (got {self.seeds})", "seeds")

    def quick(self) -> Protocol:
        """Return the protocol of a quick trial: one seed, a third of the passes, half of the frames."""
        return replace(
            self, seeds=1, epochs=4, train_frames=self.train_frames // 2, test_frames=self.test_frames // 2
        )

    def per_rig(self) -> Protocol:
        """Return a net for each rig, which sees as many frames as it can get."""
        return replace(self, mode="per-rig", train_frames=5 * self.train_frames)

    @property
    def panorama(self) -> Panorama | None:
        """Return the range image of the detector; None for pillars."""
        return Panorama() if self.detector == "range" else None

    @property
    def kinds(self) -> Kinds:
        """Return the sensors that take part."""
        if self.detector == "pictures":
            return "cameras"
        return "lidars" if self.cameras is None else "lidars and cameras"

    def training(self, seed: int) -> Training:
        """Return the training settings of a seed."""
        return Training(epochs=self.epochs, seed=seed)

    def as_dict(self) -> dict[str, object]:
        """Return the protocol as plain data."""
        plain: dict[str, object] = {
            "mode": self.mode,
            "seeds": self.seeds,
            "epochs": self.epochs,
            "train_frames": self.train_frames,
        }
        plain |= {"test_frames": self.test_frames}
        if self.cameras is not None:
            plain |= {"painting": {"quality": self.cameras} | QUALITIES[self.cameras].as_dict()}
        if self.sweeps > 1:
            plain |= {"sweeps": self.sweeps}
        if self.panorama is not None:
            plain |= {"panorama": asdict(self.panorama)}
        if self.detector == "pictures":
            plain |= {"pictures": {"least_px": LEAST_PX, "features": PICTURE_FEATURES}}
        return plain | {"region": asdict(self.region), "simulation": self.simulation.as_dict()}


@dataclass(frozen=True)
class Split:
    """Frames for training (a,) and for the test (b,), numbered over the data; sequence (b,) of each test frame,
    numbered among the test sequences, whose names are `sequences`."""

    train: Ids
    test: Ids
    sequence: Ids
    sequences: tuple[str, ...]


def split(data: DataReport, protocol: Protocol) -> Split:
    """Draw whole sequences for training or test by seed 0; raise InputError where there are too few."""
    labels = data.labels
    frames = 0 if labels is None else len(labels.sequence)
    of_frame = np.zeros(0, np.int64) if labels is None else labels.sequence
    there = np.unique(of_frame)
    if labels is None or frames < LEAST_FRAMES or len(there) < LEAST_SEQUENCES:
        count = max(1, len(there))
        raise InputError(
            f"{data.source}: must hold at least {LEAST_FRAMES} frames in at least {LEAST_SEQUENCES} named sequences, "
            f"of which two fifths are kept for the test (got {data.frames} in {count})"
        )
    drawn = np.random.default_rng(0).permutation(there)
    count = min(len(there) - 2, round(TRAIN_SHARE * len(there)))
    test_sequences = np.sort(drawn[count:])
    train = np.flatnonzero(np.isin(of_frame, drawn[:count]))
    pool = np.flatnonzero(np.isin(of_frame, test_sequences))
    test = pool[
        np.unique(np.linspace(0, len(pool) - 1, min(protocol.test_frames, len(pool))).round().astype(int))
    ]
    sequence = np.searchsorted(test_sequences, of_frame[test])
    return Split(train, test, sequence, tuple(labels.names[number] for number in test_sequences))


@dataclass(frozen=True)
class Entrant:
    """A rig of the study, under the name that is shown, with the sensors that take part."""

    name: str
    rig: Rig

    @cached_property
    def key(self) -> str:
        """Return a key of everything that determines its sweeps."""
        plain, mesh = rig_sha256(self.rig.model_copy(update={"name": "rig"})), self.rig.vehicle.body_mesh
        return plain if mesh is None else hashlib.sha256(f"{plain} {mesh.sha256}".encode()).hexdigest()

    @property
    def lidars_key(self) -> str:
        """Return a key of everything that determines its points: the same for rigs that differ in cameras alone."""
        return Entrant(self.name, self.rig.with_lidars_alone()).key

    @property
    def rays(self) -> int:
        """LiDAR rays of a frame."""
        return sum(lidar.ray_count for lidar in self.rig.enabled_lidars())


def entrants(rigs: Sequence[Rig], kinds: Kinds = "lidars") -> tuple[Entrant, ...]:
    """Return the rigs as they take part, without disabled sensors and those of other kinds; names are made unique.

    Raise InputError for a rig without LiDARs where these take part.
    """
    found: list[Entrant] = []
    for rig in rigs:
        if kinds != "cameras" and not rig.enabled_lidars():
            raise InputError(
                f"rig '{rig.name}' must have an enabled LiDAR: hit coverage says what cameras see"
            )
        taken = sum(one.name == rig.name or one.name.startswith(f"{rig.name} (") for one in found)
        name = f"{rig.name} ({taken + 1})" if taken else rig.name
        lidars = () if kinds == "cameras" else rig.enabled_lidars()
        cameras = () if kinds == "lidars" else rig.enabled_cameras()
        found.append(Entrant(name, rig.model_copy(update={"name": name, "sensors": (*lidars, *cameras)})))
    return tuple(found)


def references(kinds: Kinds = "lidars") -> tuple[Entrant, ...]:
    """Return four rigs that are always trained along, so that a net knows many even if few are compared; with the
    paper's wide cameras where points are painted. None for cameras alone."""
    if kinds == "cameras":
        return ()
    roof = Pose((0.0, 0.0, 1.9), (0.0, 0.0, 0.0))
    alone = [
        Rig(
            name=f"reference {model}",
            self_occlusion=False,
            sensors=(sensor_from_model(model, "LIDAR_TOP", roof),),
        )
        for model in ("velodyne-vlp-16", "velodyne-vlp-32c")
    ]
    groups = [
        preset(name).model_copy(update={"name": f"reference {name}"}) for name in ("Trapezoid", "Center")
    ]
    wide = preset("Wide").enabled_cameras()
    rigs = [rig.model_copy(update={"sensors": (*rig.sensors, *wide)}) for rig in (*alone, *groups)]
    return entrants(rigs, kinds)


def train_frames(entrant: Entrant, of: Split, protocol: Protocol) -> Ids:
    """Return the frames that a rig trains on, in order: a draw that its LiDARs decide, or the cameras of a rig without
    any."""
    key = entrant.key if protocol.kinds == "cameras" else entrant.lidars_key
    seed = int(key[:16], 16)
    count = min(protocol.train_frames, len(of.train))
    return np.sort(np.random.default_rng(seed).choice(of.train, count, replace=False))


def key_of(**parts: object) -> str:
    """Return a name for a piece that is another one as soon as any of the parts is."""
    plain = json.dumps({"version": _VERSION} | parts, sort_keys=True, default=str)
    return hashlib.sha256(plain.encode()).hexdigest()[:20]
