"""Make a report in a separate process: page, PDF, and pictures of its pages."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from riglens.app.background.own_process import PROGRAM, Tell, run_in_process
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.core.rig.model import Rig

PAGE, PDF = "report.html", "report.pdf"


@dataclass(frozen=True)
class ReportJob:
    """Request for a report: its rigs, scene, score, and output folder."""

    rigs: tuple[Rig, ...]
    scene: SceneOptions
    score: ScoreOptions
    folder: Path
    why: dict[str, Any] | None = None
    """The search that proposed the rig, by the names of `WhyHere`."""


def page_picture(folder: Path, number: int) -> Path:
    """Return where the picture of a page lies, from 1 on."""
    return folder / f"{number:03}.png"


def make_report(job: ReportJob, tell: Tell, program: str = PROGRAM) -> list[Path]:
    """Make a report and return the pictures of its pages; `tell` gets share and stage, and may raise to cancel.

    Raise InputError."""
    run_in_process("riglens.app.commands.report:prepare", job, tell, program)
    return sorted(job.folder.glob("*.png"))
