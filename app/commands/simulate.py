"""`riglens simulate`: data sets of simulated sweeps and pictures, each started only when all fit on the disk."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from riglens.app.commands.options import (
    SCENE,
    BodyArguments,
    Dask,
    RigArguments,
    RigNames,
    Surroundings,
    TrafficArguments,
    Whole,
    Workers,
    number,
)
from riglens.app.terminal.console import advice, note, progress_bar, results
from riglens.app.terminal.loading import load_rig, load_rigs
from riglens.app.terminal.resumable import workers_for
from riglens.core.errors import InputError
from riglens.core.pieces import work as pieces
from riglens.core.pieces.backend import Backend
from riglens.core.pieces.folder import sole_run
from riglens.core.rig.library import use_libraries
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
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import left_out
from riglens.evaluation.traffic import car_poses, load_traffic

SWEEPS = Group("Sweeps", sort_key=20)
FILES = Group("Files", sort_key=25)
CARLA = Group("CARLA", sort_key=40)
_Number = number(SWEEPS)
_Switch = Parameter(group=SWEEPS)


@Parameter(name="*")
@dataclass(frozen=True)
class SweepArguments:
    """Settings of the simulated measurements."""

    clutter: Annotated[int, _Number] = 60
    """Number of bushes, bins, poles and walls around the car in each frame, the same for every rig."""
    road: Annotated[Literal["uneven", "flat", "none"], _Switch] = "uneven"
    """uneven: with waves of a few centimetres; flat; or none."""
    noise: Annotated[float, Parameter(group=SWEEPS, metavar="M")] = 0.02
    """Standard deviation of a range, in metres."""
    dropout: Annotated[float, Parameter(group=SWEEPS, metavar="SHARE")] = 0.05
    """Share of returns lost at random."""
    shape: Annotated[Literal["class", "box"], _Switch] = "class"
    """class: cars have glass and a gap below, cyclists and pedestrians are slim; box: plain boxes."""
    range_law: Annotated[Literal["on", "off"], _Switch] = "on"
    """on: returns from far or oblique surfaces may get lost."""
    phase: Annotated[Literal["random", "0"], _Switch] = "random"
    """random: each LiDAR is rotated in each frame by a fraction of its azimuth step; 0: azimuths as listed."""
    seed: Annotated[int, _Number] = 0
    """Seed of all random draws."""

    @property
    def settings(self) -> SimulationSettings:
        """The settings of the simulation; raise InputError for numbers out of their limits."""
        range_law = self.range_law == "on"
        return SimulationSettings(
            self.seed, self.shape, range_law, self.phase, self.noise, self.dropout, self.clutter, self.road
        )


def simulate(
    *rigs: RigNames,
    out: Annotated[Path, Parameter(metavar="DIR")],
    scene: TrafficArguments = TrafficArguments(),
    surroundings: Surroundings = None,
    every: Annotated[Whole, Parameter(group=SCENE)] = None,
    sequences: Annotated[Whole, Parameter(group=SCENE)] = None,
    sweeps: SweepArguments = SweepArguments(),
    score: BodyArguments = BodyArguments(),
    pictures: Annotated[Literal["on", "off"], Parameter(group=FILES)] = "on",
    points: Annotated[Literal["parquet"] | None, Parameter(group=FILES)] = None,
    workers: Workers = None,
    dask: Dask = None,
    carla: Annotated[str | None, Parameter(group=CARLA, metavar="HOST:PORT")] = None,
    reading: RigArguments = RigArguments(),
) -> None:
    """Simulate what rigs measure in traffic, as data sets in nuScenes' format.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    out
        A new or an empty folder; with several rigs, each gets a subfolder of its name.
    surroundings
        Let houses, walls and poles hide objects (block, where they are known).
    every
        Simulate every Nth frame of each sequence (1).
    sequences
        Number of sequences, the first of the data (all).
    pictures
        on: also draw the cameras' pictures, with labels and depth, at their native size.
    points
        parquet: also write the points of each frame with the object that each is on.
    workers
        Processes that simulate at the same time (as many as cores).
    carla
        Collect from the CARLA simulator at this address instead: --frames N (200), one in --every N ticks of 0.05 s.
    """
    extras, backend = Extras(pictures == "on", points is not None), Backend(workers, dask)
    job = DataSetJob(out, scene, sweeps.settings, extras, backend, every, sequences)
    if carla is not None:
        use_libraries(reading.libraries)
        collect_in_carla(rigs, carla, job)
        return
    job = replace(job, scene=scene.surrounded(surroundings, in_town=True))
    make_data_sets(load_rigs(rigs, score, reading.libraries, reading.housings), score, job)


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


def make_data_sets(rigs: Sequence[Rig], score: ScoreOptions, job: DataSetJob) -> list[Path]:
    """Make a data set of each rig and return their folders."""
    paths = _paths(job.out, rigs)
    for rig, path in zip(rigs, paths, strict=True):
        require_channels(rig, job.extras)
        require_own(path)
    traffic, scenes = _load(job.scene, job.every or 1, job.sequences)
    poses = _poses(job.scene, traffic)
    sets = [
        Dataset(rig, replace(job.settings, body=score.body_of(rig)), job.extras, traffic, scenes, poses)
        for rig in rigs
    ]
    for one in sets:
        _remark_on(one)
    _make_all(sets, paths, job)
    return paths


def _make_all(sets: Sequence[Dataset], paths: Sequence[Path], job: DataSetJob) -> None:
    """Make the missing parts of data sets, after checking that they fit on the disk."""
    folders = [DatasetFolder(path, one) for path, one in zip(paths, sets, strict=True)]
    with ExitStack() as locks:
        for folder in folders:
            if not folder.is_complete:
                locks.callback(_remove_if_empty, folder.path)
                locks.enter_context(sole_run(folder.work))
        with progress_bar("Checking existing parts") as progress:
            todo = [[] if folder.is_complete else folder.missing(progress) for folder in folders]
        require_room(sum(bytes_needed(one, keys) for one, keys in zip(sets, todo, strict=True)), job.out)
        try:
            for one, folder, keys in zip(sets, folders, todo, strict=True):
                _make(one, folder, keys, job.backend)
        except KeyboardInterrupt as error:
            kept = error.args or (
                f"finished parts are kept in {job.out}: run the same command again to continue",
            )
            raise KeyboardInterrupt(*kept) from error


def _remove_if_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def collect_in_carla(rigs: Sequence[Rig | str], address: str, job: DataSetJob) -> None:
    """Collect a data set of one rig; InputError for options of other data, or of processes, that are not None."""
    from riglens.app.commands.carla import collect  # a program of its own
    from riglens.core.simulate.carla_collection import Wanted

    scene = job.scene
    for name, value in {"boxes": scene.boxes, "occluders": scene.occluders, **asdict(job.backend)}.items():
        if value is not None:
            raise InputError(
                "does not apply to a simulator with its own traffic: omit it with", name, "carla"
            )
    if len(rigs) != 1:
        raise InputError(f"is for one rig (got {len(rigs)} rigs)", "carla")
    rig = rigs[0] if isinstance(rigs[0], Rig) else load_rig(rigs[0])
    said = {"frames": scene.frames, "every": job.every}
    wanted = Wanted(**{name: value for name, value in said.items() if value is not None})
    collect(rig, job.out, address, wanted, job.settings, job.extras)


def _load(scene: SceneOptions, every: int, sequences: int | None) -> tuple[Traffic, list[Scene]]:
    with progress_bar("Reading boxes") as progress:
        traffic = load_traffic(scene, EVERYWHERE_M, progress)
    if traffic.frames == 0:
        raise InputError(f"{traffic.data.source}: must hold at least one frame")
    scenes = scenes_of(traffic, every, sequences)
    for line in left_out(traffic.data, advice):
        note(line)
    empty = [name for name in CLASSES if not traffic.data.boxes.get(name)]
    if empty:
        note(f"no boxes of class {', '.join(empty)}: none in the data set")
    labels = traffic.data.labels
    if labels is not None and len(labels.frame) < traffic.frames:
        left = traffic.frames - len(labels.frame)
        what = "frame without boxes is" if left == 1 else "frames without boxes are"
        note(f"{left} {what} of unknown sequence: left out")
    if not any(scene.is_val for scene in scenes):
        count = f"{len(scenes)} sequence{'s' * (len(scenes) != 1)}"
        note(f"{count} only: all frames are for training (riglens_train), none for validation (riglens_val)")
    return traffic, scenes


def _poses(options: SceneOptions, traffic: Traffic) -> dict[int, MapPose]:
    """Return the pose of the car in each frame; only the origin where poses are unknown."""
    labels, known = traffic.data.labels, car_poses(options)
    if labels is None or not known:
        return {}
    named = {frame: labels.of(frame) for frame in range(len(labels.frame))}
    return {frame: known[name] for frame, name in named.items() if name in known}


def _remark_on(one: Dataset) -> None:
    """Print remarks on a rig's data set."""
    if not any(channel.modality == "lidar" for channel in one.channels):
        note(f"{one.rig.name}: no LiDARs: pictures and labels only; the kit's evaluation needs LIDAR_TOP")
    bent = [camera.name for camera in one.rig.enabled_cameras() if camera.distortion is not None]
    if bent and one.extras.pictures:
        note(
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


def _make(one: Dataset, folder: DatasetFolder, keys: Sequence[str], backend: Backend) -> None:
    console = results()
    if folder.is_complete:
        console.print(f"{folder.path}: already complete", soft_wrap=True)
        return
    if len(keys) < len(one.spans):
        note(f"{folder.path}: resuming; {len(one.spans) - len(keys)} of {len(one.spans)} parts exist")
    with (
        progress_bar(f"Simulating {one.rig.name}") as progress,
        workers_for(folder.work, backend, len(keys)) as workers,
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
    )
