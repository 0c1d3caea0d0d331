"""Make a report in a separate process."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from riglens.app.background.own_process import OwnProcess, Tell
from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.evaluation.options import ReportOptions, SceneOptions, ScoreOptions

WORK = "riglens.app.commands.report:serve"


@dataclass(frozen=True)
class ReportJob:
    """Request for a report: its rigs, scene, score, output file, and what it holds."""

    rigs: tuple[Rig, ...]
    scene: SceneOptions
    score: ScoreOptions
    out: Path
    holds: ReportOptions
    why: dict[str, Any] | None = None
    """The search that proposed the rig, by the names of `WhyHere`."""


def make_report(job: ReportJob, tell: Tell, work: str = WORK) -> Path:
    """Write a report and return its file; `tell` gets share and stage, and may raise to cancel.

    Raise InputError with the line that the command line would give.
    """
    process = OwnProcess(work)
    try:
        process.pipe.send(job)
        said: str = process.result(tell)
    except (EOFError, OSError) as error:
        raise process.lost("the report's process") from error
    if said:
        raise InputError(said)
    return job.out
