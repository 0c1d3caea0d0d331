"""A study of detection made in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from riglens.app.background.own_process import PROGRAM, run_in_process
from riglens.app.evaluation.options import SceneOptions
from riglens.core.errors import InputError
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress

CHART, PAIRS = "detection.png", "detection-pairs.png"


@dataclass(frozen=True)
class DetectionJob:
    """Which rigs are compared, in which traffic, how long, and the folder for results and for what is done so far."""

    rigs: tuple[Rig, ...]
    scene: SceneOptions
    body: Body | None
    folder: Path
    quick: bool = True
    workers: int = 1


def study(job: DetectionJob, progress: Progress, hear: Callable[[str], None], program: str = PROGRAM) -> Path:
    """Run a study to its end and return its folder; `hear` is told of each piece that is done.

    `progress` may raise to cancel: the process ends, and what it has done is kept. Raise InputError.
    """
    if job.scene.pog is not None:
        raise InputError("a stored POG holds no road users: choose box data in the Scene panel")

    def tell(share: float, line: str) -> None:
        progress(share)
        if line:
            hear(line)

    run_in_process("riglens.app.studies.detection:study_job", job, tell, program)
    return job.folder
