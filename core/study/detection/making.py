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

from riglens.core.detect.net import State, detect, machine, train, train_task, use_one_thread
from riglens.core.detect.panorama import Panorama
from riglens.core.detect.picture_net import PictureTask, detect_in
from riglens.core.detect.pillars import Region, Sample, Samples, pillars
from riglens.core.detect.views import Lenses, Marks, Views, marks_of
from riglens.core.errors import InputError
from riglens.core.simulate.painting import QUALITIES, Painter
from riglens.core.simulate.pictures import Cameras
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
    views_of,
)
from riglens.core.study.detection.protocol import Entrant, Ids, train_frames


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
    sweeps, how = _sweeps_at_hand(study, job.rig, folder), study.protocol
    if how.kinds == "cameras":
        found = detect_in(state, views_of(sweeps, "test"), how.region, study.machine)
    else:
        found = detect(state, samples_of(sweeps, "test"), how.region, study.machine, how.panorama)
    return packed(found._asdict())


def _pass(study: Study, net: Net, epoch: int, folder: Path, state: State | None) -> State:
    """Train a net for one pass over its samples."""
    held = [_sweeps_at_hand(study, one, folder) for one in net.trains]
    how = study.protocol
    if how.kinds == "cameras":
        task = PictureTask([views_of(one, "train") for one in held])
        return train_task(task, how.training(net.seed), study.machine, state, until=epoch)
    sets = [samples_of(one, "train") for one in held]
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
    """Simulate a rig in its frames for training and in those of the test: sweeps, or pictures of cameras alone."""
    how = study.protocol
    parts = {"train": train_frames(entrant, study.split, how), "test": study.split.test}
    held: Columns = {}
    for name, frames in parts.items():
        if how.kinds == "cameras":
            made: Samples | Views = _views(study, entrant, frames)
        else:
            looks = _Looks.of(entrant, study)
            drawn = (looks.sample(frame, how.region, how.panorama) for frame in frames.tolist())
            made = Samples.of(frames.tolist(), drawn)
        held |= {f"{name}.{field.name}": getattr(made, field.name) for field in fields(made)}
    return held


def _views(study: Study, entrant: Entrant, frames: Ids) -> Views:
    """Take the pictures of a rig in some frames."""
    worlds = Worlds(study.traffic, study.protocol.simulation)
    eyes, cameras = entrant.rig.enabled_cameras(), Cameras(entrant.rig, worlds, False)
    pixels, marks, objects = [], [], []
    for frame in frames.tolist():
        truth = worlds.truth(frame)
        shown = [cameras.picture(number, frame) for number in range(len(eyes))]
        pixels.append(np.stack([one.rgb for one in shown]))
        marks += [
            marks_of(eye, one.pixels, one.bounds_px, truth.cls, truth.centre_m)
            for eye, one in zip(eyes, shown, strict=True)
        ]
        inside = study.protocol.region.holds(truth.centre_m[:, :2])
        seen = np.sum([one.pixels for one in shown], axis=0)
        objects.append(
            (truth.cls[inside].astype(np.uint8), truth.centre_m[inside, :2], seen[inside].astype(np.int64))
        )
    lenses = Lenses.of(eyes)
    return Views(
        frames,
        np.stack(pixels),
        lenses.rays,
        lenses.place_m,
        lenses.focal_px,
        np.cumsum([0, *(len(one.cls) for one in marks)]),
        *Marks(*(np.concatenate(column) for column in zip(*marks, strict=True))),
        np.cumsum([0, *(len(cls) for cls, *_ in objects)]),
        *(np.concatenate(column) for column in zip(*objects, strict=True)),
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
