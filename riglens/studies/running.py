"""The studies by name: what each is given, its options, and how it runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from riglens.core.errors import InputError
from riglens.core.monitor import Monitor
from riglens.core.option_help import OptionHelp
from riglens.core.pieces.backend import Backend
from riglens.core.rig.library import use_libraries
from riglens.core.shown_tables import Block
from riglens.core.study.true_points import Recorder
from riglens.evaluation.options import DASK, GRID, LIBRARY, PAPER_RIG, READING, SceneOptions, ScoreOptions
from riglens.studies import (
    accuracy,
    detection,
    external,
    predicted,
    sensor_methods,
    stability,
    table1,
    targets,
)

Library = Annotated[tuple[Path, ...], LIBRARY]
Quick = Annotated[bool, OptionHelp("", "Smaller cases and fewer settings: a preview, not a measurement.")]


class Job(NamedTuple):
    """Inputs of every study: a scene, a score, the folder of its files and a monitor."""

    scene: SceneOptions
    score: ScoreOptions
    out: Path
    monitor: Monitor


class Findings(NamedTuple):
    """Findings of a study: what is printed, its JSON where it has one, and a file that may be standard output."""

    blocks: list[Block]
    document: dict[str, Any] | None = None
    beside: Path | None = None


@dataclass(frozen=True)
class Table1Options:
    """Options of the study of the paper's Tables I and II."""

    csv: Annotated[Path | None, OptionHelp("FILE", "Also write Table I as CSV.")] = None
    detection_csv: Annotated[
        Path | None, OptionHelp("FILE", "Also write published average precision and our figures as CSV.")
    ] = None
    sheet: Annotated[
        Path | None,
        OptionHelp("FILE", "Also draw the groups of the paper's Fig. 1 as one picture (.png or .svg)."),
    ] = None


def _table1(options: Table1Options, job: Job, /) -> Findings:
    targets = options.csv, options.detection_csv, options.sheet
    return Findings(table1.study(job.scene, job.score, *targets, job.monitor), beside=options.csv)


@dataclass(frozen=True)
class AccuracyOptions:
    """Options of the study of time and error of methods."""

    sensor: Annotated[
        tuple[str, ...],
        OptionHelp(
            "NAME",
            "Compare methods for this library model, in the place of the rig's first one of its kind; may be repeated.",
        ),
    ] = ()
    library: Library = ()
    quick: Annotated[
        bool,
        OptionHelp("", "One run of each instead of five, and fewer settings: a preview, not a measurement."),
    ] = False


def _accuracy(options: AccuracyOptions, job: Job, /, rig: str = PAPER_RIG) -> Findings:
    use_libraries(options.library)
    if options.sensor:
        return Findings(
            sensor_methods.study(
                rig, options.sensor, job.scene, job.score, job.out, options.quick, job.monitor
            )
        )
    return Findings(accuracy.study(rig, job.scene, job.score, job.out, options.quick, job.monitor))


@dataclass(frozen=True)
class StabilityOptions:
    """Options of the study of where methods break, and how reliable the order of rigs is."""

    edits: Annotated[
        int | None,
        OptionHelp("N", "Number of random edits that are compared with an evaluation from scratch (1000)."),
    ] = None
    quick: Quick = False


def _stability(options: StabilityOptions, job: Job, /) -> Findings:
    return Findings(stability.study(job.scene, job.score, job.out, options.quick, options.edits, job.monitor))


@dataclass(frozen=True)
class TargetsOptions:
    """Options of the study of predicted against true points."""

    rig: Annotated[
        str | None, OptionHelp("RIG", "The rig that recorded all of it, in the vehicle frame.")
    ] = None
    rigs: Annotated[
        Path | None,
        OptionHelp(
            "FILE.json",
            "Or a rig per sequence, as nuScenes has them: {sequence: {sensor: {translation, rotation_wxyz}}}.",
        ),
    ] = None
    model: Annotated[str, OptionHelp("NAME", "With --rigs: model of the LiDARs in the library.")] = (
        "velodyne-hdl-32e"
    )
    azimuths: Annotated[int, OptionHelp("N", "With --rigs: azimuths of a turn.")] = 1085
    library: Library = ()

    def __post_init__(self) -> None:
        if self.azimuths < 1:
            raise InputError(f"must be an integer ≥ 1 (got {self.azimuths})", "azimuths")


def _targets(options: TargetsOptions, job: Job, /, boxes: Path) -> Findings:
    use_libraries(options.library)
    scene, recorder = replace(job.scene, boxes=boxes), Recorder(options.model, options.azimuths)
    return Findings(
        targets.study(scene, options.rig, options.rigs, recorder, job.score.threads, job.out, job.monitor)
    )


@dataclass(frozen=True)
class ExternalOptions:
    """Options of the study of published changes of sensors."""

    nuscenes: Annotated[
        Path | None,
        OptionHelp(
            "PATH",
            "Boxes of nuScenes: its folder, or a table in the frame of the rear axle (the bundled town).",
        ),
    ] = None
    kitti: Annotated[
        Path | None,
        OptionHelp(
            "PATH",
            "Boxes of KITTI: a folder of labels, or a table in the frame of the Velodyne (the bundled town).",
        ),
    ] = None
    frames: Annotated[int, OptionHelp("N", "Number of frames to sample from each.")] = external.FRAMES

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise InputError(f"must be an integer ≥ 1 (got {self.frames})", "frames")


def _external(options: ExternalOptions, job: Job, /) -> Findings:
    found = external.study(
        options.nuscenes, options.kitti, job.score.threads, options.frames, job.out, job.monitor
    )
    blocks = [*external.shown(found), f"{job.out}: {external.NAME}"]
    return Findings(blocks, external.document(found))


@dataclass(frozen=True)
class DetectionOptions:
    """Options of the study of scores against detection."""

    library: Library = ()
    quick: Annotated[
        bool, OptionHelp("", "One seed, 4 epochs, half of the frames: a preview, not a measurement.")
    ] = False
    per_rig: Annotated[
        bool, OptionHelp("", "A net for each rig, as in the paper, instead of one that all rigs share.")
    ] = False
    published: Annotated[
        bool,
        OptionHelp(
            "",
            "The rigs and the protocol of docs/study-detection.md instead of RIG; with --cameras its rigs with "
            "cameras.",
        ),
    ] = False
    second: Annotated[
        Literal["pillars", "range", "one-sweep", "painted"] | None,
        OptionHelp(
            "", "A part of the study of docs/study-detection-2.md instead of RIG, with its rigs and protocol."
        ),
    ] = None
    third: Annotated[
        Literal["lidars", "cameras"] | None,
        OptionHelp(
            "", "A part of the study of docs/study-detection-3.md instead of RIG, with its rigs and protocol."
        ),
    ] = None
    cameras: Annotated[
        Literal["good", "usual", "poor"] | None,
        OptionHelp(
            "", "Give points the classes that the cameras show, by a simulated segmentation of this quality."
        ),
    ] = None
    seeds: Annotated[
        int | None, OptionHelp("N", "Number of nets trained from different first weights (3).")
    ] = None
    workers: Annotated[int | None, OptionHelp("N", "Processes, of one thread each (1).")] = None
    dask: Annotated[str | None, DASK] = None
    device: Annotated[
        Literal["cpu", "cuda"] | None, OptionHelp("", "Device of the training: CUDA if available, or cpu.")
    ] = None


def _detection(options: DetectionOptions, job: Job, /, *rigs: str) -> Findings:
    use_libraries(options.library)
    backend = Backend(
        1 if options.workers is None and options.dask is None else options.workers, options.dask
    )
    plan = detection.Plan(
        options.quick, options.per_rig, options.published, options.second, options.third, options.seeds,
        backend,
        options.device, job.score.body, options.cameras,
    )  # fmt: skip
    return Findings(detection.study(rigs, job.scene, plan, job.out, job.monitor))


@dataclass(frozen=True)
class PredictedOptions:
    """Options of the calibration of predicted detection."""

    recall: Annotated[
        Path | None,
        OptionHelp(
            "FILE.csv",
            "detection-recall-points.csv of `riglens study detection --second one-sweep`, to fit recall too.",
        ),
    ] = None


def _predicted(options: PredictedOptions, job: Job, /, detection: Path) -> Findings:
    return Findings(predicted.study(detection, options.recall, job.out, job.monitor))


# ---------------------------------------------------------------- all of them

TABLE1_FILES = ("table1.csv", "table1-detection.csv", "table1-groups.png")
RIG = OptionHelp("RIG", "Rig file or preset name.")
_SCENE = ("boxes", *GRID, "pog", "tolerance_pp")


@dataclass(frozen=True)
class Study:
    """A study: its options, those of scene and score that it takes, and what runs it.

    `run` takes the options, the job, and what the study is given by place, which has help of its own. `files`: that it
    writes, the main table first among tables; `folder`: the same in words, for --out.
    """

    options: type
    run: Callable[..., Findings]
    files: tuple[str, ...]
    folder: str = ""
    scene: tuple[str, ...] = ()
    score: tuple[str, ...] = ()
    given: OptionHelp = RIG
    has_json: bool = False


STUDIES: dict[str, Study] = {
    "table1": Study(
        Table1Options,
        _table1,
        TABLE1_FILES,
        scene=_SCENE,
        score=("method", "reading", "camera_weight", "threads", "body"),
    ),
    "accuracy": Study(
        AccuracyOptions,
        _accuracy,
        accuracy.FILES,
        "accuracy.png, accuracy.svg and accuracy.csv; with --sensor accuracy-sensors.*, also .json",
        _SCENE,
        ("camera_weight", "threads"),
    ),
    "stability": Study(
        StabilityOptions,
        _stability,
        stability.FILES,
        "stability.html, stability-methods.csv and stability-metric.csv",
        _SCENE,
        ("camera_weight", "threads"),
    ),
    "targets": Study(
        TargetsOptions,
        _targets,
        targets.NAMES,
        "targets.csv, targets-objects.csv and targets.png",
        READING,
        ("threads",),
        OptionHelp(
            "BOXES",
            "Table with a column num_lidar_pts, or annotations.feather of an Argoverse 2 log (num_interior_pts).",
        ),
    ),
    "external": Study(
        ExternalOptions, _external, (external.NAME,), external.NAME, score=("threads",), has_json=True
    ),
    "detection": Study(
        DetectionOptions,
        _detection,
        detection.NAMES,
        "detection*.csv, detection.json, detection*.png and the pieces that are done",
        ("boxes", *READING),
        ("body",),
        OptionHelp("RIG", "Rig files or preset names; cameras are left out without --cameras."),
    ),
    "predicted": Study(
        PredictedOptions,
        _predicted,
        predicted.NAMES,
        "two tables (predicted-detection*.csv) and the calibrations study.yaml and recall.yaml",
        given=OptionHelp(
            "DETECTION.csv",
            "detection.csv of `riglens study detection --published`; docs/data holds it.",
        ),
    ),
}


def files_of(name: str, options: object) -> tuple[str, ...]:
    """Return the names of the files that a study with these options writes, the main table first among tables."""
    if isinstance(options, AccuracyOptions) and options.sensor:
        return sensor_methods.FILES
    return STUDIES[name].files
