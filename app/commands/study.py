"""`riglens study`: studies of the paper, and of the metric itself."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import (
    BUILD,
    BodyArguments,
    BoxArguments,
    JsonFigures,
    ReadingArguments,
    RigName,
    SceneArguments,
    ScoreArguments,
    ThreadArguments,
    WeightArguments,
    all_of,
    command,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import TERMINAL, show
from riglens.evaluation.options import PAPER_RIG, SceneOptions, ScoreOptions
from riglens.studies.running import (
    STUDIES,
    AccuracyOptions,
    DetectionOptions,
    ExternalOptions,
    Job,
    PredictedOptions,
    StabilityOptions,
    Table1Options,
    TargetsOptions,
)

AccuracyArguments = Annotated[AccuracyOptions, all_of(AccuracyOptions)]
DetectionArguments = Annotated[
    DetectionOptions, all_of(DetectionOptions, None, {"workers": BUILD, "dask": BUILD})
]
ExternalArguments = Annotated[ExternalOptions, all_of(ExternalOptions)]
PredictedArguments = Annotated[PredictedOptions, all_of(PredictedOptions)]
StabilityArguments = Annotated[StabilityOptions, all_of(StabilityOptions)]
Table1Arguments = Annotated[Table1Options, all_of(Table1Options)]
TargetsArguments = Annotated[TargetsOptions, all_of(TargetsOptions)]
Folder = Annotated[Path, Parameter(metavar="DIR")]
USUAL_SCENE, USUAL_SCORE = SceneOptions(), ScoreOptions()


def _run(
    name: str,
    options: object,
    *inputs: object,
    scene: SceneOptions = USUAL_SCENE,
    score: ScoreOptions = USUAL_SCORE,
    out: Path = Path("out"),
    beside: Path | None = None,
    json: str | None = None,
) -> None:
    """Run a study and print what it returns; `beside`: a file that may be standard output."""
    found = STUDIES[name].run(options, Job(scene, score, out, TERMINAL), *inputs)
    if found.document is None:
        show(found.blocks, beside)
    else:
        deliver(found.document, json, lambda: show(found.blocks))


@command
def table1(
    *,
    scene: SceneArguments = SceneOptions(),
    score: ScoreArguments = ScoreOptions(),
    options: Table1Arguments = Table1Options(),
) -> None:
    """Score the paper's eight rigs next to its Tables I and II, and to published detection."""
    _run("table1", options, scene=scene, score=score, beside=options.csv)


@command
def accuracy(
    rig: RigName = PAPER_RIG,
    /,
    *,
    options: AccuracyArguments = AccuracyOptions(),
    scene: SceneArguments = SceneOptions(),
    score: WeightArguments = ScoreOptions(),
    out: Folder = Path("out"),
) -> None:
    """Compare time and error of methods to score a rig: methods, voxel edges, ray lattices; chart and CSV.

    Parameters
    ----------
    out
        Folder for accuracy.png, accuracy.svg and accuracy.csv; with --sensor accuracy-sensors.*, also .json.
    """
    _run("accuracy", options, rig, scene=scene, score=score, out=out)


@command
def targets(
    boxes: Annotated[Path, Parameter(name="BOXES")],
    /,
    *,
    options: TargetsArguments = TargetsOptions(),
    scene: ReadingArguments = SceneOptions(),
    score: ThreadArguments = ScoreOptions(),
    out: Folder = Path("out"),
) -> None:
    """Compare predicted with true points on the objects of a recording: ranks, ratios, chart and CSV.

    Parameters
    ----------
    boxes
        Table with a column num_lidar_pts, or annotations.feather of an Argoverse 2 log (num_interior_pts).
    out
        Folder for targets.csv, targets-objects.csv and targets.png.
    """
    _run("targets", options, boxes, scene=scene, score=score, out=out)


@command
def detection(
    *rigs: Annotated[str, Parameter(name="RIG")],
    options: DetectionArguments = DetectionOptions(),
    scene: BoxArguments = SceneOptions(),
    score: BodyArguments = ScoreOptions(),
    out: Folder = Path("out"),
) -> None:
    """Compare scores with detection: simulate the rigs' LiDARs and train a small detector on them.

    Parameters
    ----------
    rigs
        Rig files or preset names; cameras are left out without --cameras.
    out
        Folder for detection*.csv, detection.json, detection*.png and the pieces that are done.
    """
    _run("detection", options, *rigs, scene=scene, score=score, out=out)


@command
def external(
    *,
    options: ExternalArguments = ExternalOptions(),
    score: ThreadArguments = ScoreOptions(),
    json: JsonFigures = None,
    out: Folder = Path("out"),
) -> None:
    """Compare published changes of LiDARs and cameras with predicted AP and other figures of the same rigs.

    Parameters
    ----------
    out
        Folder for external.csv.
    """
    require_outputs([path for path in (options.nuscenes, options.kitti) if path is not None], json)
    _run("external", options, score=score, out=out, json=json)


@command
def stability(
    *,
    options: StabilityArguments = StabilityOptions(),
    scene: SceneArguments = SceneOptions(),
    score: WeightArguments = ScoreOptions(),
    out: Folder = Path("out"),
) -> None:
    """Find where traversal methods break, and how reliable the order of the paper's rigs is.

    Parameters
    ----------
    out
        Folder for stability.html, stability-methods.csv and stability-metric.csv.
    """
    _run("stability", options, scene=scene, score=score, out=out)


@command
def predicted(
    detection: Annotated[Path, Parameter(name="DETECTION.csv")],
    /,
    *,
    options: PredictedArguments = PredictedOptions(),
    out: Folder = Path("out"),
) -> None:
    """Fit the calibration of predicted detection to the average precision of the published study.

    Parameters
    ----------
    detection
        detection.csv of `riglens study detection --published`; docs/data holds it.
    out
        Folder for two tables (predicted-detection*.csv) and the calibrations study.yaml and recall.yaml.
    """
    _run("predicted", options, detection, out=out)
