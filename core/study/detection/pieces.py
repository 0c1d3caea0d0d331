"""The pieces of a study and the folder that keeps them: sweeps of a rig, a net of a seed, what it found for a rig.

A piece's name holds a hash of all that decides it, and files appear whole or not at all. So a study that was stopped at
any moment goes on where it was, and ends with the same figures; a folder may hold pieces of several studies.
"""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.net import Machine, State, detect, train
from riglens.core.detect.pillars import Sample, Samples, pillars
from riglens.core.detect.precision import Detections, Matched, Truth
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.scene.boxes import CLASSES
from riglens.core.simulate.painting import QUALITIES, Painter, Quality
from riglens.core.simulate.sweeps import Simulator, Sweep
from riglens.core.simulate.world import TrueBoxes, Worlds
from riglens.core.study.detection.protocol import (
    Entrant,
    Protocol,
    Split,
    key_of,
    references,
    split,
    train_frames,
)
from riglens.core.targets.traffic import Traffic

Tell = Callable[[float], None]
"""Told the share done of a piece; it may raise to cancel."""


@dataclass(frozen=True)
class Study:
    """All that decides the figures: the rigs, their order, the protocol, the traffic, and what is computed on."""

    compared: tuple[Entrant, ...]
    protocol: Protocol
    traffic: Traffic
    machine: Machine

    @cached_property
    def split(self) -> Split:
        """Frames for training and test."""
        return split(self.traffic.data, self.protocol)

    @property
    def has_cameras(self) -> bool:
        """Whether cameras take part: points get the classes that they show."""
        return self.protocol.cameras is not None

    @cached_property
    def trained_on(self) -> tuple[Entrant, ...]:
        """The rigs that have sweeps for training: the compared ones, and the references in a shared net."""
        if self.protocol.mode == "per-rig":
            return self.compared
        known = {entrant.key for entrant in self.compared}
        return (*self.compared, *(one for one in references(self.has_cameras) if one.key not in known))

    @cached_property
    def nets(self) -> tuple[Net, ...]:
        """The nets to train, seed by seed."""
        seeds = range(self.protocol.seeds)
        if self.protocol.mode == "shared":
            return tuple(Net(seed, self.trained_on, self.compared) for seed in seeds)
        return tuple(Net(seed, (one,), (one,)) for seed in seeds for one in self.compared)

    def sweeps_key(self, entrant: Entrant) -> str:
        """Name of the piece with the sweeps of a rig."""
        if entrant.key not in self._sweeps_keys:
            self._sweeps_keys[entrant.key] = self._new_sweeps_key(entrant)
        return self._sweeps_keys[entrant.key]

    @cached_property
    def _sweeps_keys(self) -> dict[str, str]:
        return {}

    def _new_sweeps_key(self, entrant: Entrant) -> str:
        data = {"boxes": self.traffic.data.sha256, "around": self.traffic.surroundings_sha256}
        decides = {k: v for k, v in self.protocol.as_dict().items() if k in _OF_SWEEPS}
        return key_of(rig=entrant.key, data=data, **decides)

    def net_key(self, net: Net) -> str:
        """Name of the piece with a trained net."""
        on = [self.sweeps_key(one) for one in net.trains]
        training = asdict(self.protocol.training(net.seed))
        return key_of(sweeps=on, training=training, machine=asdict(self.machine))

    def found_key(self, net: Net, entrant: Entrant) -> str:
        """Name of the piece with what a net found in the test sweeps of a rig."""
        return key_of(net=self.net_key(net), sweeps=self.sweeps_key(entrant))


_OF_SWEEPS = ("train_frames", "test_frames", "region", "simulation", "painting")


@dataclass(frozen=True)
class Net:
    """A net: its seed, the rigs whose sweeps it learns from, and those that it is judged on."""

    seed: int
    trains: tuple[Entrant, ...]
    judges: tuple[Entrant, ...]


@dataclass(frozen=True)
class _Looks:
    """What a rig measures in a frame: road users, a sweep, and what cameras say of its points where they take part."""

    simulator: Simulator
    painter: Painter | None

    @classmethod
    def of(cls, entrant: Entrant, worlds: Worlds, cameras: Quality | None) -> _Looks:
        how = None if cameras is None else QUALITIES[cameras]
        painter = None if how is None else Painter(entrant.rig, worlds, how, entrant.mesh)
        return cls(Simulator(entrant.rig, worlds, mesh=entrant.mesh), painter)

    def at(self, frame: int) -> tuple[TrueBoxes, Sweep, NDArray[np.float64] | None]:
        sweep = self.simulator.sweep(frame)
        painted = None if self.painter is None else self.painter.scores(frame, sweep.points_m)
        return self.simulator.truth(frame), sweep, painted


@dataclass(frozen=True)
class Pieces:
    """The pieces in a folder. What is asked for again is not made again."""

    study: Study
    folder: Path

    # ------------------------------------------------------------------ what is there
    def has_sweeps(self, entrant: Entrant) -> bool:
        """Whether the sweeps of a rig are there."""
        return self.sweeps_file(entrant).exists()

    def has_net(self, net: Net) -> bool:
        """Whether a net is trained to the end."""
        path = self.net_file(net)
        return path.exists() and int(_read(path, "epoch")["epoch"]) >= self.study.protocol.epochs

    def has_found(self, net: Net, entrant: Entrant) -> bool:
        """Whether a rig is judged by a net."""
        return self.found_file(net, entrant).exists()

    # ------------------------------------------------------------------ making them
    def make_sweeps(self, entrant: Entrant, worlds: Worlds, tell: Tell) -> None:
        """Simulate a rig in its frames for training and in those of the test."""
        frames = train_frames(entrant, self.study.split, self.study.protocol)
        parts = {"train": frames, "test": self.study.split.test}
        looks = _Looks.of(entrant, worlds, self.study.protocol.cameras)
        total = sum(map(len, parts.values()))
        held: dict[str, NDArray[Any]] = {}
        before = 0
        for name, part in parts.items():
            samples = Samples.of(part.tolist(), self._samples(looks, part, before, total, tell))
            held |= {f"{name}.{field.name}": getattr(samples, field.name) for field in fields(Samples)}
            before += len(part)
        _write(self.sweeps_file(entrant), held)

    def _samples(
        self, looks: _Looks, frames: NDArray[np.int64], before: int, total: int, tell: Tell
    ) -> Iterator[Sample]:
        region = self.study.protocol.region
        for done, frame in enumerate(frames.tolist(), 1):
            truth, sweep, painted = looks.at(frame)
            inside = region.holds(truth.centre_m[:, :2])
            yield Sample(
                *pillars(sweep.points_m, sweep.intensity, region, painted),
                truth.cls[inside].astype(np.uint8),
                truth.centre_m[inside, :2],
                sweep.hits(len(truth.cls))[inside],
            )
            tell((before + done) / total)

    def make_net(self, net: Net, tell: Tell) -> None:
        """Train a net, from where it was stopped; each pass over the samples is kept."""
        path, study = self.net_file(net), self.study
        state: State | None = _read(path) if path.exists() else None
        sets = [self.samples(one, "train") for one in net.trains]
        train(
            sets, study.protocol.region, study.protocol.training(net.seed), study.machine, state,
            after_epoch=lambda done: _write(path, done), progress=tell,
        )  # fmt: skip

    def make_found(self, net: Net, entrant: Entrant, tell: Tell) -> None:
        """Have a trained net look at the test sweeps of a rig."""
        found = detect(
            _read(self.net_file(net)),
            self.samples(entrant, "test"),
            self.study.protocol.region,
            self.study.machine,
        )
        _write(self.found_file(net, entrant), found._asdict())
        tell(1.0)

    # ------------------------------------------------------------------ what they say
    def samples(self, entrant: Entrant, part: str) -> Samples:
        """The samples of a rig, "train" or "test"."""
        columns = _read(self.sweeps_file(entrant), part)
        return Samples(**{field.name: columns[f"{part}.{field.name}"] for field in fields(Samples)})

    def matched(self, net: Net, entrant: Entrant, hit_only: bool) -> tuple[Matched, ...]:
        """Which detections of a net on a rig are right, by class; hit_only: objects without a point do not count."""
        columns = _read(self.sweeps_file(entrant), "test")
        starts, points = columns["test.object_starts"], columns["test.points"]
        frame = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
        truth = Truth(frame, columns["test.cls"], columns["test.centre_m"], points)
        truth = truth.where(points > 0) if hit_only else truth
        found = Detections(**_read(self.found_file(net, entrant)))
        sequence = self.study.split.sequence
        return tuple(Matched.of(truth, found, number, sequence) for number in range(len(CLASSES)))

    # ------------------------------------------------------------------ files
    def sweeps_file(self, entrant: Entrant) -> Path:
        """Where the sweeps of a rig are kept."""
        return self.folder / f"sweeps-{self.study.sweeps_key(entrant)}.npz"

    def net_file(self, net: Net) -> Path:
        """Where a net is kept, trained to the end or not."""
        return self.folder / f"net-{net.seed}-{self.study.net_key(net)}.npz"

    def found_file(self, net: Net, entrant: Entrant) -> Path:
        """Where it is kept what a net found for a rig."""
        return self.folder / f"found-{net.seed}-{self.study.found_key(net, entrant)}.npz"


def _write(path: Path, columns: dict[str, Any]) -> None:
    with atomic_write(path) as stream:
        np.savez(stream, **columns)


def _read(path: Path, begins: str = "") -> dict[str, NDArray[Any]]:
    """The arrays of a piece whose names begin so; nothing is unpickled. Raise InputError for a damaged file."""
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as held:
            return {name: held[name] for name in held.files if name.startswith(begins)}
    except (
        OSError,
        ValueError,
        EOFError,
        TypeError,
        AttributeError,
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        raise InputError(f"{path}: damaged; delete it, and it is made again") from error
