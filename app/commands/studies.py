"""`riglens study`: studies of the paper, and of the metric itself."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from riglens.app.commands.options import (
    BODY,
    SCENE,
    SCORE,
    BoxArguments,
    LibraryArguments,
    Rig,
    SceneArguments,
    ScoreArguments,
    Whole,
    whole_number,
)
from riglens.app.evaluation.options import PAPER_RIG, SceneOptions, ScoreOptions
from riglens.core.errors import InputError
from riglens.core.metric.scores import Body


def table1(
    *,
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    csv: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    detection_csv: Annotated[Path | None, Parameter(metavar="FILE")] = None,
) -> None:
    """The paper's Tables I and II: its eight rigs scored here, beside the published scores and detection.

    Detection is compared with Place3D's published figures as well.

    Parameters
    ----------
    csv
        Also write Table I as CSV.
    detection_csv
        Also write published average precision and our figures as CSV.
    """
    options, metric = scene.options(), score.options()
    from riglens.app.studies import table1 as study_table1

    study_table1.study(options, metric, csv, detection_csv)


def accuracy(
    rig: Rig = PAPER_RIG,
    /,
    *,
    sensor: Annotated[
        tuple[str, ...], Parameter(name="--sensor", metavar="NAME", show_default=False, negative=())
    ] = (),
    scene: SceneArguments = SceneArguments(),
    libraries: LibraryArguments = LibraryArguments(),
    camera_weight: Annotated[float, Parameter(name="--lambda", group=SCORE, metavar="X")] = 0.1,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    out: Annotated[Path, Parameter(metavar="DIR")] = Path("out"),
    quick: bool = False,
) -> None:
    """Time against error of ways to score a rig: methods, voxel edges, ray lattices; chart and CSV.

    Parameters
    ----------
    rig
        Rig file or preset name.
    sensor
        Instead of the rig, a model of the library, upright and tilted, where the rig has its first sensor of this
        kind; may be given many times.
    camera_weight
        Weight of the cameras in S-MS.
    threads
        Threads to use (all cores; with --sensor one).
    out
        Folder for accuracy.png, accuracy.svg and accuracy.csv; with --sensor accuracy-sensors.*, also .json.
    quick
        One run of each instead of five, and fewer settings: a look, not a measurement.
    """
    libraries.use()
    options, metric = scene.options(), ScoreOptions(camera_weight=camera_weight, threads=threads)
    if sensor:
        from riglens.app.studies import sensor_methods

        sensor_methods.study(rig, sensor, options, metric, out, quick)
        return
    from riglens.app.studies import accuracy as study_accuracy

    study_accuracy.study(rig, options, metric, out, quick)


def targets(
    boxes: Annotated[Path, Parameter(name="BOXES")],
    /,
    *,
    rig: Annotated[str | None, Parameter(name="--rig", metavar="RIG")] = None,
    rigs: Annotated[Path | None, Parameter(metavar="FILE.json")] = None,
    how: BoxArguments = BoxArguments(),
    model: Annotated[str, Parameter(metavar="NAME")] = "velodyne-hdl-32e",
    azimuths: Annotated[int, Parameter(converter=whole_number, metavar="N")] = 1085,
    libraries: LibraryArguments = LibraryArguments(),
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    out: Annotated[Path, Parameter(metavar="DIR")] = Path("out"),
) -> None:
    """Predicted against true points on the road users of a recording: ranks, ratios, chart and CSV.

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
    threads
        Threads to use (all cores).
    out
        Folder for targets.csv, targets-objects.csv and targets.png.
    """
    libraries.use()
    ScoreOptions(threads=threads)
    scene = SceneOptions(boxes, how.origin, how.frames, how.classes, find_ground=how.ground == "auto")
    if azimuths < 1:
        raise InputError(f"--azimuths: found {azimuths}, accepted is a whole number from 1 up")
    from riglens.app.studies import targets as study_targets
    from riglens.core.study.true_points import Recorder

    study_targets.study(scene, rig, rigs, Recorder(model, azimuths), threads, out)


def detection(
    *rigs: Annotated[str, Parameter(name="RIG")],
    boxes: Annotated[Path | None, Parameter(metavar="PATH", group=SCENE, show_default=False)] = None,
    how: BoxArguments = BoxArguments(),
    libraries: LibraryArguments = LibraryArguments(),
    body: Annotated[Body | None, BODY] = None,
    quick: bool = False,
    per_rig: bool = False,
    published: bool = False,
    cameras: Annotated[Literal["good", "usual", "poor"] | None, Parameter(show_default=False)] = None,
    seeds: Whole = None,
    workers: Whole = None,
    dask: Annotated[str | None, Parameter(metavar="ADDRESS", show_default=False)] = None,
    device: Annotated[Literal["cpu", "cuda"] | None, Parameter(show_default=False)] = None,
    out: Annotated[Path, Parameter(metavar="DIR")] = Path("out"),
) -> None:
    """Score against detection: simulates the rigs' LiDARs, trains a small detector, compares what it finds.

    Simulated LiDAR, small detector trained here: compares rigs, does not predict the AP of your stack. Takes about an
    hour of one core for two rigs; stopped at any moment, the same command goes on where it was.

    Parameters
    ----------
    rigs
        Rig files or preset names; cameras are left out unless --cameras is said.
    boxes
        Box data set with named sequences. Without it: the bundled scenario.
    body
        Whether rays end at the cars' own bodies (as each rig says).
    quick
        One seed, 4 epochs, half of the frames: a look, not a measurement.
    per_rig
        A net for each rig, as in the paper, instead of one that all rigs share.
    published
        The rigs and the protocol of docs/study-detection.md, instead of RIG; with --cameras those of its cameras.
    cameras
        Points get the classes that the cameras show, by a simulated segmentation of this quality.
    seeds
        How many nets are trained from other first weights (3).
    workers
        Processes, of one thread each (1).
    dask
        Make the pieces on the Dask cluster whose scheduler listens there, such as tls://10.0.0.1:8786. It is trusted:
        whoever takes part in it can run code here (docs/security.md).
    device
        Where nets are trained: CUDA where there is one, unless cpu is said.
    out
        Folder for detection*.csv, detection.json, detection*.png and the pieces that are done.
    """
    libraries.use()
    scene = SceneOptions(boxes, how.origin, how.frames, how.classes, find_ground=how.ground == "auto")
    from riglens.app.studies import detection as study_detection
    from riglens.core.pieces.where import Where

    where = Where(1 if workers is None and dask is None else workers, dask)
    plan = study_detection.Plan(quick, per_rig, published, seeds, where, device, body, cameras)
    study_detection.study(rigs, scene, plan, out)


def stability(
    *,
    scene: SceneArguments = SceneArguments(),
    camera_weight: Annotated[float, Parameter(name="--lambda", group=SCORE, metavar="X")] = 0.1,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    edits: Whole = None,
    out: Annotated[Path, Parameter(metavar="DIR")] = Path("out"),
    quick: bool = False,
) -> None:
    """Where methods of traversal break, and how far the order of the paper's rigs can be relied on.

    Parameters
    ----------
    camera_weight
        Weight of the cameras in S-MS.
    threads
        Threads to use (all cores).
    edits
        Number of random edits that are compared with an evaluation from scratch (1000).
    out
        Folder for stability.html, stability-methods.csv and stability-metric.csv.
    quick
        Smaller cases and fewer settings: a look, not a measurement.
    """
    options, metric = scene.options(), ScoreOptions(camera_weight=camera_weight, threads=threads)
    from riglens.app.studies import stability as study_stability

    study_stability.study(options, metric, out, quick, edits)
