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

from riglens.core.detect.net import State, detect, machine, train, use_one_thread
from riglens.core.detect.panorama import Panorama
from riglens.core.detect.pillars import Region, Sample, Samples, pillars
from riglens.core.errors import InputError
from riglens.core.simulate.painting import QUALITIES, Painter
from riglens.core.simulate.sweeps import Simulator
from riglens.core.simulate.world import Worlds
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
    samples, how = samples_of(_sweeps_at_hand(study, job.rig, folder), "test"), study.protocol
    return packed(detect(state, samples, how.region, study.machine, how.panorama)._asdict())


def _pass(study: Study, net: Net, epoch: int, folder: Path, state: State | None) -> State:
    """Train a net for one pass over its samples."""
    sets = [samples_of(_sweeps_at_hand(study, one, folder), "train") for one in net.trains]
    how = study.protocol
    return train(
        sets, how.region, how.training(net.seed), study.machine, state, until=epoch, panorama=how.panorama
    )


# ---------------------------------------------------------------- sweeps


@dataclass(frozen=True)
class _Looks:
    """A rig's data of a frame: its sweeps, the last one first, and camera scores of points where cameras take part."""

    simulator: Simulator
    painter: Painter | None
    sweeps: int

    @classmethod
    def of(cls, entrant: Entrant, study: Study) -> _Looks:
        worlds = Worlds(study.traffic, study.protocol.simulation, study.motion)
        cameras = study.protocol.cameras
        painter = None if cameras is None else Painter(entrant.rig, worlds, QUALITIES[cameras])
        return cls(Simulator(entrant.rig, worlds), painter, study.protocol.sweeps)

    def sample(self, frame: int, region: Region, panorama: Panorama | None) -> Sample:
        """Return the frame as the net sees it; with several sweeps, the age of points is one more figure of theirs."""
        truth = self.simulator.worlds.truth(frame)
        inside = region.holds(truth.centre_m[:, :2])
        sweeps = [self.simulator.sweep(frame, ago) for ago in range(self.sweeps)]
        points_m, intensity = (
            np.concatenate([getattr(one, name) for one in sweeps]) for name in ("points_m", "intensity")
        )
        more = np.zeros((len(points_m), 0))
        if self.sweeps > 1:
            more = np.repeat(np.linspace(0.0, 1.0, self.sweeps), [len(one.points_m) for one in sweeps])[
                :, None
            ]
        if self.painter is not None:
            more = np.column_stack([more, self.painter.scores(frame, points_m)])
        if panorama is None:
            image = pillars(points_m, intensity, region, more)
        else:
            image = panorama.pixels(points_m, intensity, region, more)
        hits = np.sum([one.hits(len(truth.cls)) for one in sweeps], axis=0)
        return Sample(*image, truth.cls[inside].astype(np.uint8), truth.centre_m[inside, :2], hits[inside])


def sweeps_of(study: Study, entrant: Entrant) -> Columns:
    """Simulate a rig in its frames for training and in those of the test."""
    looks, how = _Looks.of(entrant, study), study.protocol
    held: Columns = {}
    parts = {"train": train_frames(entrant, study.split, how), "test": study.split.test}
    for name, frames in parts.items():
        drawn = (looks.sample(frame, how.region, how.panorama) for frame in frames.tolist())
        samples = Samples.of(frames.tolist(), drawn)
        held |= {f"{name}.{field.name}": getattr(samples, field.name) for field in fields(Samples)}
    return held


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
