"""`riglens study`: studies of the paper, and of the metric itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from riglens.app.commands.options import (
    BodyArguments,
    BoxArguments,
    Dask,
    JsonFigures,
    Libraries,
    ReadingArguments,
    RigName,
    SceneArguments,
    ScoreArguments,
    ThreadArguments,
    WeightArguments,
    Whole,
    Workers,
    number,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.core.errors import InputError
from riglens.core.pieces.backend import Backend
from riglens.core.rig.library import use_libraries
from riglens.core.study.true_points import Recorder
from riglens.evaluation.options import PAPER_RIG
from riglens.studies import accuracy as study_accuracy
from riglens.studies import detection as study_detection
from riglens.studies import external as study_external
from riglens.studies import predicted as study_predicted
from riglens.studies import sensor_methods
from riglens.studies import stability as study_stability
from riglens.studies import table1 as study_table1
from riglens.studies import targets as study_targets

Folder = Annotated[Path, Parameter(metavar="DIR")]


def table1(
    *,
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    csv: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    detection_csv: Annotated[Path | None, Parameter(metavar="FILE")] = None,
) -> None:
    """Score the paper's eight rigs next to its Tables I and II, and to published detection.

    Parameters
    ----------
    csv
        Also write Table I as CSV.
    detection_csv
        Also write published average precision and our figures as CSV.
    """
    study_table1.study(scene, score, csv, detection_csv)


def accuracy(
    rig: RigName = PAPER_RIG,
    /,
    *,
    sensor: Annotated[
        tuple[str, ...], Parameter(name="--sensor", metavar="NAME", show_default=False, negative=())
    ] = (),
    scene: SceneArguments = SceneArguments(),
    libraries: Libraries = (),
    score: WeightArguments = WeightArguments(),
    out: Folder = Path("out"),
    quick: bool = False,
) -> None:
    """Compare time and error of methods to score a rig: methods, voxel edges, ray lattices; chart and CSV.

    Parameters
    ----------
    sensor
        Compare methods for this library model, in the place of the rig's first one of its kind; may be repeated.
    out
        Folder for accuracy.png, accuracy.svg and accuracy.csv; with --sensor accuracy-sensors.*, also .json.
    quick
        One run of each instead of five, and fewer settings: a preview, not a measurement.
    """
    use_libraries(libraries)
    if sensor:
        sensor_methods.study(rig, sensor, scene, score, out, quick)
    else:
        study_accuracy.study(rig, scene, score, out, quick)


def targets(
    boxes: Annotated[Path, Parameter(name="BOXES")],
    /,
    *,
    rig: Annotated[str | None, Parameter(name="--rig", metavar="RIG")] = None,
    rigs: Annotated[Path | None, Parameter(metavar="FILE.json")] = None,
    scene: ReadingArguments = ReadingArguments(),
    model: Annotated[str, Parameter(metavar="NAME")] = "velodyne-hdl-32e",
    azimuths: Annotated[int, number()] = 1085,
    libraries: Libraries = (),
    score: ThreadArguments = ThreadArguments(),
    out: Folder = Path("out"),
) -> None:
    """Compare predicted with true points on the objects of a recording: ranks, ratios, chart and CSV.

    Parameters
    ----------
    boxes
        Table with a column num_lidar_pts, or annotations.feather of an Argoverse 2 log (num_interior_pts).
    rig
        The rig that recorded all of it, in the vehicle frame.
    rigs
        Or a rig per sequence, as nuScenes has them: {sequence: {sensor: {translation, rotation_wxyz}}}.
    model
        With --rigs: model of the LiDARs in the library.
    azimuths
        With --rigs: azimuths of a turn.
    out
        Folder for targets.csv, targets-objects.csv and targets.png.
    """
    use_libraries(libraries)
    if azimuths < 1:
        raise InputError(f"must be an integer ≥ 1 (got {azimuths})", "azimuths")
    study_targets.study(replace(scene, boxes=boxes), rig, rigs, Recorder(model, azimuths), score.threads, out)


def detection(
    *rigs: Annotated[str, Parameter(name="RIG")],
    scene: BoxArguments = BoxArguments(),
    libraries: Libraries = (),
    score: BodyArguments = BodyArguments(),
    quick: bool = False,
    per_rig: bool = False,
    published: bool = False,
    second: Annotated[
        Literal["pillars", "range", "one-sweep", "painted"] | None, Parameter(show_default=False)
    ] = None,
    cameras: Annotated[Literal["good", "usual", "poor"] | None, Parameter(show_default=False)] = None,
    seeds: Whole = None,
    workers: Workers = None,
    dask: Dask = None,
    device: Annotated[Literal["cpu", "cuda"] | None, Parameter(show_default=False)] = None,
    out: Folder = Path("out"),
) -> None:
    """Compare scores with detection: simulate the rigs' LiDARs and train a small detector on them.

    Parameters
    ----------
    rigs
        Rig files or preset names; cameras are left out without --cameras.
    quick
        One seed, 4 epochs, half of the frames: a preview, not a measurement.
    per_rig
        A net for each rig, as in the paper, instead of one that all rigs share.
    published
        The rigs and the protocol of docs/study-detection.md instead of RIG; with --cameras its rigs with cameras.
    second
        A part of the study of docs/study-detection-2.md instead of RIG, with its rigs and protocol.
    cameras
        Give points the classes that the cameras show, by a simulated segmentation of this quality.
    seeds
        Number of nets trained from different first weights (3).
    workers
        Processes, of one thread each (1).
    device
        Device of the training: CUDA if available, or cpu.
    out
        Folder for detection*.csv, detection.json, detection*.png and the pieces that are done.
    """
    use_libraries(libraries)
    backend = Backend(1 if workers is None and dask is None else workers, dask)
    plan = study_detection.Plan(
        quick, per_rig, published, second, seeds, backend, device, score.body, cameras
    )
    study_detection.study(rigs, scene, plan, out)


def external(
    *,
    nuscenes: Annotated[Path | None, Parameter(metavar="PATH")] = None,
    kitti: Annotated[Path | None, Parameter(metavar="PATH")] = None,
    frames: Annotated[int, number()] = study_external.FRAMES,
    score: ThreadArguments = ThreadArguments(),
    json: JsonFigures = None,
    out: Folder = Path("out"),
) -> None:
    """Compare published experiments with fewer beams or points with predicted AP and other figures of the same rigs.

    Parameters
    ----------
    nuscenes
        Boxes of nuScenes: its folder, or a table in the frame of the rear axle (the bundled town).
    kitti
        Boxes of KITTI: a folder of labels, or a table in the frame of the Velodyne (the bundled town).
    frames
        Number of frames to sample from each.
    out
        Folder for external.csv.
    """
    if frames < 1:
        raise InputError(f"must be an integer ≥ 1 (got {frames})", "frames")
    require_outputs([path for path in (nuscenes, kitti) if path is not None], json)
    found = study_external.study(nuscenes, kitti, score.threads, frames, out)
    deliver(study_external.document(found), json, lambda: study_external.show(found, out))


def stability(
    *,
    scene: SceneArguments = SceneArguments(),
    score: WeightArguments = WeightArguments(),
    edits: Whole = None,
    out: Folder = Path("out"),
    quick: bool = False,
) -> None:
    """Find where traversal methods break, and how reliable the order of the paper's rigs is.

    Parameters
    ----------
    edits
        Number of random edits that are compared with an evaluation from scratch (1000).
    out
        Folder for stability.html, stability-methods.csv and stability-metric.csv.
    quick
        Smaller cases and fewer settings: a preview, not a measurement.
    """
    study_stability.study(scene, score, out, quick, edits)


def predicted(
    detection: Annotated[Path, Parameter(name="DETECTION.csv")],
    /,
    *,
    recall: Annotated[Path | None, Parameter(metavar="FILE.csv")] = None,
    out: Folder = Path("out"),
) -> None:
    """Fit the calibration of predicted detection to the average precision of the published study.

    Parameters
    ----------
    detection
        detection.csv of `riglens study detection --published`; docs/data holds it.
    recall
        detection-recall-points.csv of `riglens study detection --second one-sweep`, to fit recall too.
    out
        Folder for two tables (predicted-detection*.csv) and the calibrations study.yaml and recall.yaml.
    """
    study_predicted.study(detection, recall, out)
