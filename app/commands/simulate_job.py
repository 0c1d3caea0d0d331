"""What `riglens simulate` does: plan the data sets of rigs, see that they fit on the disk, and make them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import left_out
from riglens.app.evaluation.traffic import car_poses, load_traffic
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.resumable import resumable
from riglens.app.terminal.scores import meshes_called, rig_called
from riglens.core.errors import InputError
from riglens.core.pieces import work as pieces
from riglens.core.pieces.where import Where
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.simulate.dataset import (
    VERSION,
    Dataset,
    DatasetFolder,
    bytes_needed,
    require_channels,
    require_own,
    require_room,
    scenes_of,
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
    with progress_bar("Checking what is there") as progress:
        todo = [[] if folder.is_complete else folder.missing(progress) for folder in folders]
    require_room(sum(bytes_needed(one, keys) for one, keys in zip(sets, todo, strict=True)), out)
    for one, folder, keys in zip(sets, folders, todo, strict=True):
        _make(one, folder, keys, where)


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
    """Return a folder for each rig; InputError for two rigs that would share one."""
    if len(rigs) == 1:
        return [out]
    owners = dict[str, str]()
    for rig in rigs:
        name = _folder_name(rig)
        # some file systems do not tell A from a
        other = next((owner for taken, owner in owners.items() if taken.casefold() == name.casefold()), None)
        if other is not None:
            raise InputError(
                f"--out {out}: the rigs '{other}' and '{rig.name}' would share the folder '{name}'; rename one of them"
            )
        owners[name] = rig.name
    return [out / name for name in owners]


def _folder_name(rig: Rig) -> str:
    name = "".join(sign if sign.isalnum() or sign in "+-_. " else "-" for sign in rig.name)[:80]
    return name.strip(". ") or "rig"


def _make(one: Dataset, folder: DatasetFolder, keys: Sequence[str], where: Where) -> None:
    console = results()
    if folder.is_complete:
        console.print(f"{folder.path}: complete already, nothing to do", soft_wrap=True, markup=False)
        return
    if len(keys) < len(one.spans):
        note(f"{folder.path}: goes on; {len(one.spans) - len(keys)} of {len(one.spans)} parts are there")
    with (
        progress_bar(f"Simulating {one.rig.name}") as progress,
        resumable(folder.work, where, len(keys)) as workers,
    ):
        folder.begin()
        made = pieces.results([one.piece(key) for key in keys], folder, workers)
        for done, _ in enumerate(made, 1):
            progress(done / len(keys))
        points = folder.finish()
    splits = one.plan["splits"]
    console.print(
        f"{folder.path}: {one.frames:,} frames, {points / one.frames:,.0f} points in each, channels "
        f"{', '.join(channel.name for channel in one.channels)}; tables in {VERSION}, "
        f"scenes: {', '.join(f'{count} in {name}' for name, count in splits.items())}",
        soft_wrap=True,
        markup=False,
    )
