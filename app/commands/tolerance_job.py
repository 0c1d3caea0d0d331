"""What `riglens tolerance` does: draw errors, measure, and say how much figures spread."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import settings_of
from riglens.app.evaluation.traffic import load_traffic
from riglens.app.studies.files import write_text
from riglens.app.terminal.console import note, progress_bar
from riglens.app.terminal.scores import load_with_progress, meshes_called, rig_called
from riglens.app.terminal.tolerance import print_tolerance
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.files import require_writable
from riglens.core.review.measures import ON_TARGET, SEEN, Measures
from riglens.core.review.tolerance import MAX_DRAWS, profile_called, worst_rig
from riglens.core.review.tolerance import tolerance as tolerance_of
from riglens.core.review.tolerance_json import tolerance_document
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.traffic import WITHIN_M


class Asked(NamedTuple):
    """Which errors, how many draws of which seed, in how many frames; where the rig of the worst draw by a figure goes,
    and where JSON goes, "-" for standard output."""

    profile: str
    draws: int
    seed: int
    sample: int | None
    sensitivities: bool
    worst: Path | None
    figure: str
    json: str | None


def tolerance(name: str, scene: SceneOptions, score: ScoreOptions, asked: Asked) -> None:
    """Print how much a rig's figures spread, also written to a JSON file; with "-" as JSON alone."""
    profile = profile_called(asked.profile)
    if not 1 <= asked.draws <= MAX_DRAWS:
        raise InputError(f"--draws: found {asked.draws}, accepted is a whole number, 1 to {MAX_DRAWS}")
    if not 0 <= asked.seed < 1 << 63:
        raise InputError(f"--seed: found {asked.seed}, accepted is a whole number from 0 up to 2^63 - 1")
    rig = rig_called(name)
    (mesh,) = meshes_called([name], [rig], score)
    for path in (asked.worst, None if asked.json in (None, "-") else asked.json):
        if path is not None:
            require_writable(path, (name, *scene.files))
    figures = [f"{kind} {cls}" for kind in (SEEN, ON_TARGET) for cls in CLASSES]
    if asked.figure not in figures:
        raise InputError(f"--figure: found '{asked.figure}', accepted is one of {', '.join(figures)}")
    for line in missing_rays(rig):
        note(line)
    settings = settings_of(score)
    _, field = load_with_progress(scene.for_rigs([rig], score))
    traffic = None
    if asked.sample != 0 and scene.pog is None:
        with progress_bar("Reading boxes") as progress:
            traffic = load_traffic(scene, WITHIN_M, progress)
    with progress_bar("Drawing errors") as progress:
        measure = Measures(field, traffic, settings, mesh, asked.sample, score.threads, designed=rig)
        found = tolerance_of(rig, profile, measure, asked.draws, asked.seed, asked.sensitivities, progress)
    if asked.worst is not None:
        write_text(asked.worst, dumps(worst_rig(found, asked.figure)))
    text = to_text(tolerance_document(found, score.body_of(rig), measure))
    if asked.json == "-":
        sys.stdout.write(text)
        return
    if asked.json is not None:
        write_text(Path(asked.json), text)
    print_tolerance(found, score.body_of(rig))
