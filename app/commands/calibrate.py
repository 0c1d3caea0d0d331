"""`riglens calibrate`: recall of a detector by points and class, for predicted detection."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter
from rich.table import Table

from riglens.app.commands.options import BoxArguments, Libraries, Out, command
from riglens.app.commands.output import require_outputs
from riglens.app.terminal.console import TERMINAL, note, progress_bar, results
from riglens.app.terminal.tables import table
from riglens.core.figures.figure import SE_FACTOR
from riglens.core.files import write_file
from riglens.core.rig.library import use_libraries
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.survey import doubtful
from riglens.core.study.calibrating import Rules
from riglens.core.targets.calibration import MATCH_M, MIN_SCORE, WITHIN_M, Calibration
from riglens.evaluation.calibrating import calibrated
from riglens.evaluation.loading import load_rig
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.traffic import load_traffic

SHOWN_AT = (1, 5, 10, 20, 50, 100)


@command
def calibrate(
    detections: Annotated[Path, Parameter(name="DETECTIONS")],
    /,
    *,
    scene: BoxArguments = SceneOptions(),
    out: Out,
    within: Annotated[float, Parameter(metavar="M")] = WITHIN_M,
    min_score: Annotated[float, Parameter(metavar="X")] = MIN_SCORE,
    match: Annotated[float, Parameter(metavar="M")] = MATCH_M,
    name: Annotated[str | None, Parameter(metavar="TEXT")] = None,
    rig: Annotated[str | None, Parameter(metavar="RIG")] = None,
    camera_results: Annotated[Path | None, Parameter(metavar="RESULTS")] = None,
    libraries: Libraries = (),
) -> None:
    """Fit a detector's recall by points and class, for predicted detection of rigs.

    Parameters
    ----------
    detections
        Results of nuScenes' detection task. With a table: in the frame of its boxes, sample tokens SEQ/FRAME.
    out
        File for the calibration, YAML.
    within
        Count objects within this distance of the car, in metres.
    min_score
        Lowest score of a detection that counts.
    match
        A detection finds an object whose centre is nearer than this on the ground, in metres.
    name
        Name of the detector (that of the file).
    rig
        Count the points that RigLens predicts for this rig, instead of the true points of the boxes.
    camera_results
        Results of a detector of the rig's pictures alone: fits what cameras add. Needs --rig.
    """
    use_libraries(libraries)
    require_outputs((detections, *scene.files, *filter(None, (camera_results,))), out)
    rules = Rules(min_score, match)
    opened = None if rig is None else load_rig(rig, TERMINAL)
    with progress_bar("Reading boxes") as progress:
        traffic = load_traffic(scene, within, progress)
    for line in doubtful(traffic.data, TERMINAL.advice):
        note(line)
    found = calibrated(detections, scene, traffic, rules, name, opened, camera_results)
    write_file(out, found.text())
    console = results()
    console.print(_table(found))
    if found.camera is not None:
        console.print(f"Cameras: s {found.camera.s:.2f}, d0 {found.camera.d0_m:.1f} m")
    console.print(f"{out}: objects {found.domain.region}", soft_wrap=True)


def _table(found: Calibration) -> Table:
    """Recall by points, in percent, and ± two standard errors on sequences left out."""
    shown = table("recall, %", "objects", *(f"{n} pts" for n in SHOWN_AT), "±")
    for class_name in CLASSES:
        curve = found.classes.of(class_name)
        if curve is None:
            shown.add_row(class_name, *["—"] * (len(SHOWN_AT) + 2))
            continue
        values = [
            f"{100.0 * value:.1f}"
            for value in (*curve.at(np.array(SHOWN_AT, np.float64)), SE_FACTOR * curve.error)
        ]
        shown.add_row(class_name, f"{curve.objects:,}", *values)
    return shown
