"""Make one piece of a study, on a worker that may share no folder with the study.

A worker is sent the study and the state of the net that the piece continues. Sweeps come from the study's folder,
or, where that is out of reach, are simulated by the worker, the very same ones, and kept for its next piece.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.net import State, detect, machine, train, use_one_thread
from riglens.core.detect.pillars import Sample, Samples, pillars
from riglens.core.errors import InputError
from riglens.core.simulate.painting import QUALITIES, Painter, Quality
from riglens.core.simulate.sweeps import Simulator, Sweep
from riglens.core.simulate.world import TrueBoxes, Worlds
from riglens.core.study.detection.pieces import (
    Columns,
    Job,
    Net,
    Study,
    packed,
    piece_folder,
    samples_of,
)
from riglens.core.study.detection.protocol import Entrant, train_frames


def make(study: Study, job: Job, folder: Path, state: State | None) -> bytes:
    """Make a piece in this process; InputError where PyTorch differs from the study's.

    folder: the study's, for sweeps. state: of the net after the pass before.
    """
    use_one_thread()
    here = machine(study.machine.device)
    if here != study.machine:
        raise InputError(f"this machine must be {study.machine}, whose figures the study holds (got {here})")
    if job.net is None:
        assert job.rig is not None
        return packed(sweeps_of(study, job.rig))
    if job.rig is None:
        return packed(_pass(study, job.net, job.epoch, folder, state))
    assert state is not None
    samples = samples_of(_sweeps_at_hand(study, job.rig, folder), "test")
    return packed(detect(state, samples, study.protocol.region, study.machine)._asdict())


def _pass(study: Study, net: Net, epoch: int, folder: Path, state: State | None) -> State:
    """Train a net for one pass over its samples."""
    sets = [samples_of(_sweeps_at_hand(study, one, folder), "train") for one in net.trains]
    training = study.protocol.training(net.seed)
    return train(sets, study.protocol.region, training, study.machine, state, until=epoch)


# ---------------------------------------------------------------- sweeps


@dataclass(frozen=True)
class _Looks:
    """A rig's data of a frame: objects, a sweep, and camera scores of its points where cameras take part."""

    simulator: Simulator
    painter: Painter | None

    @classmethod
    def of(cls, entrant: Entrant, worlds: Worlds, cameras: Quality | None) -> _Looks:
        how = None if cameras is None else QUALITIES[cameras]
        painter = None if how is None else Painter(entrant.rig, worlds, how)
        return cls(Simulator(entrant.rig, worlds), painter)

    def at(self, frame: int) -> tuple[TrueBoxes, Sweep, NDArray[np.float64] | None]:
        sweep = self.simulator.sweep(frame)
        painted = None if self.painter is None else self.painter.scores(frame, sweep.points_m)
        return self.simulator.truth(frame), sweep, painted


def sweeps_of(study: Study, entrant: Entrant) -> Columns:
    """Simulate a rig in its frames for training and in those of the test."""
    worlds = Worlds(study.traffic, study.protocol.simulation)
    looks = _Looks.of(entrant, worlds, study.protocol.cameras)
    held: Columns = {}
    parts = {"train": train_frames(entrant, study.split, study.protocol), "test": study.split.test}
    for name, frames in parts.items():
        samples = Samples.of(frames.tolist(), _samples(study, looks, frames))
        held |= {f"{name}.{field.name}": getattr(samples, field.name) for field in fields(Samples)}
    return held


def _samples(study: Study, looks: _Looks, frames: NDArray[np.int64]) -> Iterator[Sample]:
    region = study.protocol.region
    for frame in frames.tolist():
        truth, sweep, painted = looks.at(frame)
        inside = region.holds(truth.centre_m[:, :2])
        yield Sample(
            *pillars(sweep.points_m, sweep.intensity, region, painted),
            truth.cls[inside].astype(np.uint8),
            truth.centre_m[inside, :2],
            sweep.hits(len(truth.cls))[inside],
        )


def _sweeps_at_hand(study: Study, entrant: Entrant, folder: Path) -> Columns:
    key = Job(None, entrant).key(study)
    found = piece_folder(folder).load(key)
    if found is not None:
        return found
    with _own_folder() as own:
        store = piece_folder(own)
        found = store.load(key)
        return store.keep(key, packed(sweeps_of(study, entrant))) if found is None else found


@contextmanager
def _own_folder() -> Iterator[Path]:
    """Return the folder of this Dask worker, deleted when it ends, or a temporary folder elsewhere."""
    try:
        from distributed import get_worker

        there = Path(get_worker().local_directory) / "riglens-pieces"
    except (ImportError, ValueError):
        with TemporaryDirectory() as name:
            yield Path(name)
        return
    yield there
