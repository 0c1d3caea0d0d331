"""Define the pieces of a study and the folder that stores them: sweeps of a rig, passes of a net's training, its
detections.

A piece's key holds a hash of all that decides it. So a study that was stopped at any moment resumes, and ends with
the same figures; a folder may hold pieces of several studies.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.net import Machine
from riglens.core.detect.pillars import Samples
from riglens.core.detect.precision import Detections, Matched, Truth
from riglens.core.detect.views import Views
from riglens.core.errors import InputError
from riglens.core.pieces.folder import PieceFolder
from riglens.core.scene.boxes import CLASSES
from riglens.core.simulate.motion import Motion
from riglens.core.study.detection.protocol import Entrant, Protocol, Split, key_of, references, split
from riglens.core.targets.traffic import Traffic

Columns = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Study:
    """Everything that determines the figures: the rigs, their order, the protocol, the traffic, the machine, and the
    motion in the traffic where there are several sweeps."""

    compared: tuple[Entrant, ...]
    protocol: Protocol
    traffic: Traffic
    machine: Machine
    motion: Motion | None = None

    @cached_property
    def split(self) -> Split:
        """Frames for training and test."""
        return split(self.traffic.data, self.protocol)

    @cached_property
    def tested(self) -> Traffic:
        """The frames of the test alone."""
        return self.traffic.frames_alone(np.flatnonzero(np.isin(self.traffic.frame, self.split.test)))

    @cached_property
    def judged(self) -> NDArray[np.bool_]:
        """Return the boxes of `tested` that average precision is over, (n,): those in the region."""
        return self.protocol.region.holds(self.tested.centre_m[:, :2])

    @cached_property
    def trained_on(self) -> tuple[Entrant, ...]:
        """The rigs that have sweeps for training: the compared ones, and the references in a shared net."""
        if self.protocol.mode == "per-rig":
            return self.compared
        known = {entrant.key for entrant in self.compared}
        return (*self.compared, *(one for one in references(self.protocol.kinds) if one.key not in known))

    @cached_property
    def nets(self) -> tuple[Net, ...]:
        """The nets to train, seed by seed."""
        seeds = range(self.protocol.seeds)
        if self.protocol.mode == "shared":
            return tuple(Net(seed, self.trained_on, self.compared) for seed in seeds)
        return tuple(Net(seed, (one,), (one,)) for seed in seeds for one in self.compared)

    def sweeps_key(self, entrant: Entrant) -> str:
        """Return the hash of all inputs that determine the sweeps of a rig."""
        return self._sweeps_keys[entrant.key]

    @cached_property
    def _sweeps_keys(self) -> dict[str, str]:
        data = {"boxes": self.traffic.data.sha256, "around": self.traffic.surroundings_sha256}
        data |= {} if self.motion is None else {"motion": self.motion.sha256}
        decides = {k: v for k, v in self.protocol.as_dict().items() if k in _OF_SWEEPS}
        return {one.key: key_of(rig=one.key, data=data, **decides) for one in self.trained_on}

    def net_key(self, net: Net) -> str:
        """Return the hash of what decides a trained net."""
        on = [self.sweeps_key(one) for one in net.trains]
        training = asdict(self.protocol.training(net.seed))
        return key_of(sweeps=on, training=training, machine=asdict(self.machine))

    def found_key(self, net: Net, entrant: Entrant) -> str:
        """Return the hash of everything that determines a net's detections in the test sweeps of a rig."""
        return key_of(net=self.net_key(net), sweeps=self.sweeps_key(entrant))


_OF_SWEEPS = (
    "train_frames",
    "test_frames",
    "region",
    "simulation",
    "painting",
    "sweeps",
    "panorama",
    "pictures",
)


@dataclass(frozen=True)
class Net:
    """Net to train: its seed, the rigs whose sweeps it learns from, and those that it is tested on."""

    seed: int
    trains: tuple[Entrant, ...]
    judges: tuple[Entrant, ...]


@dataclass(frozen=True)
class Job:
    """Piece to make: sweeps of a rig, a pass of a net's training, or a net's detections for a rig."""

    net: Net | None
    rig: Entrant | None
    epoch: int = 0

    @property
    def is_pass(self) -> bool:
        """Return whether it is a pass of a training; `epoch` counts them from 1."""
        return self.rig is None

    @property
    def is_found(self) -> bool:
        """Return whether the piece holds a net's detections for a rig."""
        return self.net is not None and self.rig is not None

    @property
    def title(self) -> str:
        """The piece in words."""
        if self.net is None:
            assert self.rig is not None
            return f"sweeps of {self.rig.name}"
        of = f"seed {self.net.seed + 1}"
        if self.rig is not None:
            return f"{self.rig.name}, {of}"
        of = f"net of {of}" if len(self.net.judges) > 1 else f"net of {self.net.judges[0].name}, {of}"
        return f"{of}, pass {self.epoch}"

    def key(self, study: Study) -> str:
        """Return the key of the piece."""
        if self.net is None:
            assert self.rig is not None
            return f"sweeps-{study.sweeps_key(self.rig)}"
        if self.rig is None:
            return f"net-{self.net.seed}-{study.net_key(self.net)}-{self.epoch}"
        return f"found-{self.net.seed}-{study.found_key(self.net, self.rig)}"

    def after(self, study: Study) -> list[Job]:
        """Return the pieces that it is made from."""
        if self.net is None:
            return []
        sweeps = [Job(None, one) for one in (self.net.trains if self.rig is None else (self.rig,))]
        before = self.epoch - 1 if self.rig is None else study.protocol.epochs
        return [*sweeps, Job(self.net, None, before)] if before else sweeps


def jobs(study: Study) -> list[Job]:
    """Return all pieces of a study, in an order in which they can be made."""
    sweeps = [Job(None, one) for one in study.trained_on]
    passes = [Job(net, None, epoch) for net in study.nets for epoch in range(1, study.protocol.epochs + 1)]
    return [*sweeps, *passes, *(Job(net, one) for net in study.nets for one in net.judges)]


@dataclass(frozen=True)
class Pieces:
    """The finished pieces of a study in a folder."""

    study: Study
    folder: Path

    @cached_property
    def store(self) -> PieceFolder[Columns]:
        """The files."""
        return piece_folder(self.folder)

    def of(self, job: Job) -> Columns:
        """Return a finished piece; InputError when it is missing or damaged."""
        found = self.store.load(job.key(self.study))
        if found is None:
            raise InputError(f"{self.folder}: {job.title}: missing or damaged; run the same command again")
        return found

    def has_found(self, net: Net, entrant: Entrant) -> bool:
        """Return whether a rig is judged by a net."""
        return self.store.load(Job(net, entrant).key(self.study)) is not None

    def judged(self, net: Net, entrant: Entrant) -> tuple[Truth, Detections]:
        """Return the objects of the test frames with a rig's points on them, and what a net detects there."""
        return self._truth(entrant), Detections(**self.of(Job(net, entrant)))

    def matched(self, net: Net, entrant: Entrant, hit_only: bool) -> tuple[Matched, ...]:
        """Return which detections of a net on a rig are right, by class; hit_only: objects without a point do not
        count."""
        truth, found = self.judged(net, entrant)
        truth = truth.where(truth.points > 0) if hit_only else truth
        sequence = self.study.split.sequence
        return tuple(Matched.of(truth, found, number, sequence) for number in range(len(CLASSES)))

    def _truth(self, entrant: Entrant) -> Truth:
        if entrant.key not in self._truths:
            sweeps = self.of(Job(None, entrant))
            starts, *objects = (
                sweeps[f"test.{name}"] for name in ("object_starts", "cls", "centre_m", "points")
            )
            frame = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
            self._truths[entrant.key] = Truth(frame, *objects)
        return self._truths[entrant.key]

    @cached_property
    def _truths(self) -> dict[str, Truth]:
        return {}


# ---------------------------------------------------------------- content


def piece_folder(folder: Path) -> PieceFolder[Columns]:
    """Return the store of pieces in a folder, as arrays by name."""
    return PieceFolder(folder, lambda _, content: _unpacked(content))


def packed(columns: dict[str, Any]) -> bytes:
    """Return the content of a piece, which is the same each time for the same arrays."""
    stream = BytesIO()
    np.savez(stream, **columns)
    return stream.getvalue()


def _unpacked(content: bytes) -> Columns:
    with np.load(BytesIO(content), allow_pickle=False) as held:
        return {name: held[name] for name in held.files}


def samples_of(sweeps: Columns, part: str) -> Samples:
    """Return the samples of a rig, "train" or "test"."""
    return Samples(**{field.name: sweeps[f"{part}.{field.name}"] for field in fields(Samples)})


def views_of(pictures: Columns, part: str) -> Views:
    """Return the pictures of a rig, "train" or "test"."""
    return Views(**{field.name: pictures[f"{part}.{field.name}"] for field in fields(Views)})
