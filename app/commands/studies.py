"""`riglens study`: studies of the paper, and of the metric itself."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import SCORE, LibraryArguments, Rig, SceneArguments, ScoreArguments, Whole
from riglens.app.evaluation.options import DEFAULT_RIG, ScoreOptions


def table1(
    *,
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    csv: Annotated[Path | None, Parameter(metavar="FILE")] = None,
) -> None:
    """The paper's Table I: its eight rigs scored here, beside the published figures, with their orders.

    Parameters
    ----------
    csv
        Also write the table as CSV.
    """
    options, metric = scene.options(), score.options()
    from riglens.app.studies import table1 as study_table1

    study_table1.study(options, metric, csv)


def accuracy(
    rig: Rig = DEFAULT_RIG,
    /,
    *,
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
    camera_weight
        Weight of the cameras in S-MS.
    threads
        Threads to use (all cores).
    out
        Folder for accuracy.png, accuracy.svg and accuracy.csv.
    quick
        One run of each instead of five, and fewer settings: a look, not a measurement.
    """
    libraries.use()
    options, metric = scene.options(), ScoreOptions(camera_weight=camera_weight, threads=threads)
    from riglens.app.studies import accuracy as study_accuracy

    study_accuracy.study(rig, options, metric, out, quick)


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
