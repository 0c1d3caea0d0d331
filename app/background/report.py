"""Make a report in a separate process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from riglens.app.background.own_process import OwnProcess
from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.evaluation.options import ReportOptions, SceneOptions, ScoreOptions

WORK = "riglens.app.commands.report:serve"
LOOK_S = 0.2
"""Seconds between checks whether the report is still wanted."""
Tell = Callable[[float, str], None]
"""Takes the share done, and the stage, empty for the same as before."""


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
        said: tuple[float, str] | str = (0.0, "")
        while isinstance(said, tuple):
            tell(*said)
            while not process.pipe.poll(LOOK_S):
                tell(said[0], "")
            said = process.receive()
    except (EOFError, OSError) as error:
        raise InputError("the process exited without a message") from error
    finally:
        process.end()
    if said:
        raise InputError(said)
    return job.out
