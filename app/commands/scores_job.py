"""What `riglens evaluate` does: score rigs and say it as a table, as JSON or as both."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence

from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import settings_of
from riglens.app.terminal.console import is_standard_output, note
from riglens.app.terminal.scores import (
    load_with_progress,
    meshes_called,
    print_scores,
    rig_called,
    score_rigs,
)
from riglens.core.engine.evaluation_json import evaluation_document, to_text
from riglens.core.files import atomic_write, require_writable
from riglens.core.rig.model import Rig
from riglens.core.sensing.rays import missing_ray_count
from riglens.core.vehicle.mesh import BodyMesh
from riglens.core.vehicle.solid import CarBody
from riglens.core.vehicle.standing import problems_in_short, stands_of


def evaluate(names: Sequence[str], scene: SceneOptions, score: ScoreOptions, json_target: str | None) -> None:
    """Print the scores of some rigs as a table, also written to a JSON file; with "-" as JSON alone."""
    if json_target is not None and is_standard_output(json_target):
        json_target = "-"
    rigs = [rig_called(name) for name in names]
    meshes = meshes_called(names, rigs, score)
    if json_target not in (None, "-"):
        require_writable(json_target, (*names, *scene.files))
    for line in (line for rig in rigs for line in missing_rays(rig)):
        note(line)
    _, field = load_with_progress(scene.for_rigs(rigs, score))
    for line in wrong_places(rigs, meshes):  # what is refused is refused in one line
        note(line)
    evaluations = score_rigs(rigs, field, score, meshes=meshes)
    document = evaluation_document(field, settings_of(score), evaluations)
    if json_target == "-":
        sys.stdout.write(to_text(document))
        return
    if json_target is not None:
        with atomic_write(json_target, "w") as stream:
            stream.write(to_text(document))
    print_scores(evaluations, field, score)


def wrong_places(rigs: Sequence[Rig], meshes: Sequence[BodyMesh | None]) -> Iterator[str]:
    """One line for each thing that is wrong with where sensors of a rig stand; nothing of a body that was not read."""
    for rig, mesh in zip(rigs, meshes, strict=True):
        if mesh is not None or not rig.vehicle.has_mesh_file:
            for line in problems_in_short(stands_of(rig, CarBody(rig.vehicle, mesh))):
                yield f"{rig.name}: {line}"


def missing_rays(rig: Rig) -> Iterator[str]:
    """One line for each enabled camera whose lens model gives some of its pixels no direction."""
    for camera in rig.cameras():
        missing = missing_ray_count(camera)
        if missing:
            share = f"{missing:,} of {camera.ray_count:,} rays lie beyond what its lens model can say"
            yield f"{rig.name}: {camera.name}: {share}, and are left out"
