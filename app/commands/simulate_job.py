"""What `riglens simulate` does: plan the data sets of rigs, see that they fit on the disk, and make them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import left_out
from riglens.app.evaluation.traffic import car_poses, load_traffic
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.scores import meshes_called, rig_called
from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.pog_cluster import cluster_workers
from riglens.core.scene.pog_parts import OwnProcess
from riglens.core.scene.pog_processes import worker_processes
from riglens.core.simulate.dataset import (
    VERSION,
    Dataset,
    DatasetFolder,
    Workers,
    bytes_needed,
    require_channels,
    require_own,
    require_room,
    scenes_of,
    simulate_pieces,
)
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.tables import EgoPose, Scene
from riglens.core.simulate.units import Extras
from riglens.core.targets.traffic import Traffic

EVERYWHERE_M = 1e6
"""All boxes of the data are road users of the data set, however far away."""


@dataclass(frozen=True)
class Frames:
    """Which frames: one in `every` of the first `sequences`, None: of all."""

    every: int = 1
    sequences: int | None = None

    def __post_init__(self) -> None:
        if self.every < 1:
            raise InputError(f"--every: found {self.every}, accepted is a whole number from 1 up")
        if self.sequences is not None and self.sequences < 1:
            raise InputError(f"--sequences: found {self.sequences}, accepted is a whole number from 1 up")


@dataclass(frozen=True)
class Asked:
    """What is to be simulated, the same for all rigs; `score` says what the body does."""

    scene: SceneOptions
    frames: Frames
    settings: SimulationSettings
    extras: Extras
    score: ScoreOptions


@dataclass(frozen=True)
class Where:
    """Processes here, or a cluster."""

    workers: int | None = None
    dask: str | None = None

    def __post_init__(self) -> None:
        if self.workers is not None and self.workers < 1:
            raise InputError(f"--workers: found {self.workers}, accepted is a whole number from 1 up")
        if self.workers is not None and self.dask is not None:
            raise InputError(
                "--workers and --dask: the cluster has its own workers; give only one of the two"
            )


def simulate(names: Sequence[str], out: Path, asked: Asked, where: Where) -> None:
    """Make the data set of each rig, all after it is known that they fit on the disk."""
    rigs = [rig_called(name) for name in names]
    paths = _paths(out, rigs)
    for rig, path in zip(rigs, paths, strict=True):
        require_channels(rig, asked.extras)
        require_own(path)
    score = asked.score
    meshes = meshes_called(names, rigs, score)
    traffic, scenes = _load(asked)
    poses = _poses(asked.scene, traffic)
    sets = [
        Dataset(
            rig, mesh, replace(asked.settings, body=score.body_of(rig)), asked.extras, traffic, scenes, poses
        )
        for rig, mesh in zip(rigs, meshes, strict=True)
    ]
    for one in sets:
        _remark_on(one)
    folders = [DatasetFolder(path, one) for path, one in zip(paths, sets, strict=True)]
    todo = [list(range(len(one.pieces))) for one in sets]
    for number, folder in enumerate(folders):
        todo[number] = [] if folder.is_complete else folder.missing()
    needed = sum(
        bytes_needed(one, [one.pieces[place] for place in places])
        for one, places in zip(sets, todo, strict=True)
    )
    require_room(needed, out)
    for one, folder, places in zip(sets, folders, todo, strict=True):
        _make(one, folder, places, where)


def _load(asked: Asked) -> tuple[Traffic, list[Scene]]:
    with progress_bar("Reading boxes") as progress:
        traffic = load_traffic(asked.scene, EVERYWHERE_M, progress)
    if traffic.frames == 0:
        raise InputError(f"{traffic.data.source}: found no frame, accepted are box data with one at least")
    scenes = scenes_of(traffic, asked.frames.every, asked.frames.sequences)
    for line in left_out(traffic.data):
        note(line)
    empty = [name for name in CLASSES if not traffic.data.boxes.get(name)]
    if empty:
        note(f"no boxes of class {', '.join(empty)}: nothing of it is in the data set")
    labels = traffic.data.labels
    if labels is not None and len(labels.frame) < traffic.frames:
        left = traffic.frames - len(labels.frame)
        what = "frame without boxes is" if left == 1 else "frames without boxes are"
        note(f"{left} {what} of no sequence that is known: left out")
    if not any(scene.is_val for scene in scenes):
        count = f"{len(scenes)} sequence{'s' * (len(scenes) != 1)}"
        note(f"{count} only: all frames are for training (riglens_train), none for validation (riglens_val)")
    return traffic, scenes


def _poses(options: SceneOptions, traffic: Traffic) -> dict[int, EgoPose]:
    """Where the car is in each frame; nowhere else than at the origin where nobody knows."""
    labels, known = traffic.data.labels, car_poses(options)
    if labels is None or not known:
        return {}
    found = {}
    for frame in range(len(labels.frame)):
        pose = known.get(labels.of(frame))
        if pose is not None:
            found[frame] = EgoPose(pose.position_m, pose.yaw_rad)
    return found


def _remark_on(one: Dataset) -> None:
    """What a user has to know about a rig's data set."""
    if not any(channel.modality == "lidar" for channel in one.channels):
        note(f"{one.rig.name}: no LiDARs: pictures and labels alone; the kit's evaluation needs LIDAR_TOP")
    bent = [camera.name for camera in one.rig.cameras() if camera.distortion is not None]
    if bent and one.extras.pictures:
        note(
            f"{one.rig.name}: pictures of {', '.join(bent)} are bent as by the lens, which the tables cannot say"
        )


def _paths(out: Path, rigs: Sequence[Rig]) -> list[Path]:
    """A folder for each rig; InputError for two of the same name."""
    if len(rigs) == 1:
        return [out]
    names = [
        "".join(sign if sign.isalnum() or sign in "+-_. " else "-" for sign in rig.name)[:80] for rig in rigs
    ]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(
            f"--out {out}: found two rigs named {twice[0]}, accepted are rigs of different names"
        )
    return [out / (name.strip(". ") or "rig") for name in names]


def _make(one: Dataset, folder: DatasetFolder, places: Sequence[int], where: Where) -> None:
    console = results()
    if folder.is_complete:
        console.print(f"{folder.path}: complete already, nothing to do", soft_wrap=True, markup=False)
        return
    folder.begin()
    if len(places) < len(one.pieces):
        note(f"{folder.path}: goes on; {len(one.pieces) - len(places)} of {len(one.pieces)} parts are there")
    try:
        with progress_bar(f"Simulating {one.rig.name}") as progress, _workers(where, len(places)) as workers:
            simulate_pieces(folder, one, places, workers, progress)
    except KeyboardInterrupt:
        note(f"{folder.path}: what is finished is kept; run the same command again to go on")
        raise
    points = folder.finish()
    splits = one.plan["splits"]
    console.print(
        f"{folder.path}: {one.frames:,} frames, {points / one.frames:,.0f} points in each, channels "
        f"{', '.join(channel.name for channel in one.channels)}; tables in {VERSION}, "
        f"scenes: {', '.join(f'{count} in {name}' for name, count in splits.items())}",
        soft_wrap=True,
        markup=False,
    )


@contextmanager
def _workers(where: Where, pieces: int) -> Iterator[Workers]:
    """Where pieces are simulated: on a cluster, in processes, or here."""
    if where.dask is not None:
        with cluster_workers(where.dask) as elsewhere:
            yield elsewhere
        return
    count = min(where.workers or os.cpu_count() or 1, pieces)
    if count <= 1:
        yield OwnProcess()
        return
    with worker_processes(count) as processes:
        yield processes
