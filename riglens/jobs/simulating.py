"""Simulate data sets of sweeps and pictures, each started only when all fit on the disk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import NamedTuple

from riglens.core.errors import InputError
from riglens.core.monitor import Monitor
from riglens.core.pieces import work as pieces
from riglens.core.pieces.backend import Backend
from riglens.core.pieces.folder import sole_run
from riglens.core.pieces.resumable import workers_for
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.occluders import MapPose
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
from riglens.core.simulate.tables import Scene
from riglens.core.simulate.units import Extras
from riglens.core.targets.traffic import EVERYWHERE_M, Traffic
from riglens.evaluation.loading import load_rig
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import left_out
from riglens.evaluation.traffic import car_poses, load_traffic


class Made(NamedTuple):
    """Folder of a data set that is complete, and a line on it."""

    folder: Path
    line: str


@dataclass(frozen=True)
class DataSetJob:
    """Data sets to make: the folder, the traffic, what is measured and written, one frame in `every` of the first
    sequences, and where that is computed. InputError for numbers below 1."""

    out: Path
    scene: SceneOptions
    settings: SimulationSettings
    extras: Extras
    backend: Backend
    every: int | None = None
    sequences: int | None = None

    def __post_init__(self) -> None:
        for name, value in (("every", self.every), ("sequences", self.sequences)):
            if value is not None and value < 1:
                raise InputError(f"must be an integer ≥ 1 (got {value})", name)


def make_data_sets(
    rigs: Sequence[Rig], score: ScoreOptions, job: DataSetJob, monitor: Monitor
) -> Iterator[Made]:
    """Make a data set of each rig, and yield each when it is complete."""
    paths = _paths(job.out, rigs)
    for rig, path in zip(rigs, paths, strict=True):
        require_channels(rig, job.extras)
        require_own(path)
    traffic, scenes = _load(job.scene, job.every or 1, job.sequences, monitor)
    poses = _poses(job.scene, traffic)
    sets = [
        Dataset(rig, replace(job.settings, body=score.body_of(rig)), job.extras, traffic, scenes, poses)
        for rig in rigs
    ]
    for one in sets:
        _remark_on(one, monitor)
    yield from _make_all(sets, paths, job, monitor)


def _make_all(
    sets: Sequence[Dataset], paths: Sequence[Path], job: DataSetJob, monitor: Monitor
) -> Iterator[Made]:
    """Make the missing parts of data sets, after checking that they fit on the disk."""
    folders = [DatasetFolder(path, one) for path, one in zip(paths, sets, strict=True)]
    with ExitStack() as locks:
        for folder in folders:
            if not folder.is_complete:
                locks.callback(_remove_if_empty, folder.path)
                locks.enter_context(sole_run(folder.work))
        with monitor.stage("Checking existing parts") as progress:
            todo = [[] if folder.is_complete else folder.missing(progress) for folder in folders]
        require_room(sum(bytes_needed(one, keys) for one, keys in zip(sets, todo, strict=True)), job.out)
        try:
            for one, folder, keys in zip(sets, folders, todo, strict=True):
                yield Made(folder.path, _make(one, folder, keys, job.backend, monitor))
        except KeyboardInterrupt as error:
            kept = error.args or (
                f"finished parts are kept in {job.out}: run the same command again to continue",
            )
            raise KeyboardInterrupt(*kept) from error


def _remove_if_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def collect_in_carla(rigs: Sequence[Rig | str], address: str, job: DataSetJob, monitor: Monitor) -> Made:
    """Collect a data set of one rig; InputError for options of other data, or of processes, that are not None."""
    from riglens.core.simulate.carla_collection import Wanted
    from riglens.jobs.collecting import collect  # a program of its own

    scene = job.scene
    for name, value in {"boxes": scene.boxes, "occluders": scene.occluders, **asdict(job.backend)}.items():
        if value is not None:
            raise InputError(
                "does not apply to a simulator with its own traffic: omit it with", name, "carla"
            )
    if len(rigs) != 1:
        raise InputError(f"is for one rig (got {len(rigs)} rigs)", "carla")
    rig = rigs[0] if isinstance(rigs[0], Rig) else load_rig(rigs[0], monitor)
    said = {"frames": scene.frames, "every": job.every}
    wanted = Wanted(**{name: value for name, value in said.items() if value is not None})
    return Made(job.out, collect(rig, job.out, address, wanted, job.settings, job.extras, monitor))


def _load(
    scene: SceneOptions, every: int, sequences: int | None, monitor: Monitor
) -> tuple[Traffic, list[Scene]]:
    with monitor.stage("Reading boxes") as progress:
        traffic = load_traffic(scene, EVERYWHERE_M, progress)
    if traffic.frames == 0:
        raise InputError(f"{traffic.data.source}: must hold at least one frame")
    scenes = scenes_of(traffic, every, sequences)
    for line in left_out(traffic.data, monitor.advice):
        monitor.note(line)
    empty = [name for name in CLASSES if not traffic.data.boxes.get(name)]
    if empty:
        monitor.note(f"no boxes of class {', '.join(empty)}: none in the data set")
    labels = traffic.data.labels
    if labels is not None and len(labels.frame) < traffic.frames:
        left = traffic.frames - len(labels.frame)
        what = "frame without boxes is" if left == 1 else "frames without boxes are"
        monitor.note(f"{left} {what} of unknown sequence: left out")
    if not any(scene.is_val for scene in scenes):
        count = f"{len(scenes)} sequence{'s' * (len(scenes) != 1)}"
        monitor.note(
            f"{count} only: all frames are for training (riglens_train), none for validation (riglens_val)"
        )
    return traffic, scenes


def _poses(options: SceneOptions, traffic: Traffic) -> dict[int, MapPose]:
    """Return the pose of the car in each frame; only the origin where poses are unknown."""
    labels, known = traffic.data.labels, car_poses(options)
    if labels is None or not known:
        return {}
    named = {frame: labels.of(frame) for frame in range(len(labels.frame))}
    return {frame: known[name] for frame, name in named.items() if name in known}


def _remark_on(one: Dataset, monitor: Monitor) -> None:
    """Note remarks on a rig's data set."""
    if not any(channel.modality == "lidar" for channel in one.channels):
        monitor.note(
            f"{one.rig.name}: no LiDARs: pictures and labels only; the kit's evaluation needs LIDAR_TOP"
        )
    bent = [camera.name for camera in one.rig.enabled_cameras() if camera.distortion is not None]
    if bent and one.extras.pictures:
        monitor.note(
            f"{one.rig.name}: pictures of {', '.join(bent)} keep the lens distortion, which the tables cannot express"
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
                f"{out}: the rigs '{other}' and '{rig.name}' would share the folder '{name}'; rename one of them"
            )
        owners[name] = rig.name
    return [out / name for name in owners]


def _folder_name(rig: Rig) -> str:
    name = "".join(sign if sign.isalnum() or sign in "+-_. " else "-" for sign in rig.name)[:80]
    return name.strip(". ") or "rig"


def _make(
    one: Dataset, folder: DatasetFolder, keys: Sequence[str], backend: Backend, monitor: Monitor
) -> str:
    """Make the missing parts of a data set, and return a line on it."""
    if folder.is_complete:
        return f"{folder.path}: already complete"
    if len(keys) < len(one.spans):
        monitor.note(f"{folder.path}: resuming; {len(one.spans) - len(keys)} of {len(one.spans)} parts exist")
    with (
        monitor.stage(f"Simulating {one.rig.name}") as progress,
        workers_for(folder.work, backend, len(keys), monitor) as workers,
    ):
        folder.begin()
        made = pieces.results([one.piece(key) for key in keys], folder, workers)
        for done, _ in enumerate(made, 1):
            progress(done / len(keys))
        points = folder.finish()
    splits = one.plan["splits"]
    return (
        f"{folder.path}: {one.frames:,} frames, {points / one.frames:,.0f} points in each, channels "
        f"{', '.join(channel.name for channel in one.channels)}; tables in {VERSION}, "
        f"scenes: {', '.join(f'{count} in {name}' for name, count in splits.items())}"
    )
