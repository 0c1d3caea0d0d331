"""What `riglens redundancy` does: evaluate once, tell what failures cost, as tables, as JSON or as both."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import settings_of
from riglens.app.evaluation.traffic import load_traffic
from riglens.app.studies.files import write_text
from riglens.app.terminal.console import note, progress_bar
from riglens.app.terminal.redundancy import print_redundancy
from riglens.app.terminal.scores import load_with_progress, meshes_called, rig_called
from riglens.core.engine.engine import Engine
from riglens.core.engine.evaluation_json import to_text
from riglens.core.files import require_writable
from riglens.core.metric.entropy import EntropyField
from riglens.core.review.redundancy import NO_EVIDENCE, Coverage, target_coverage, voxel_coverage
from riglens.core.review.redundancy_json import coverage_document
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import rig_sha256
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.vehicle.mesh import BodyMesh


class Asked(NamedTuple):
    """Whether road users are counted, how near, by what; where JSON goes, "-" for standard output."""

    road_users: bool
    within_m: float
    settings: TargetSettings
    json: str | None


class Found(NamedTuple):
    """Coverage of voxels, and of road users where they were counted."""

    rig: Rig
    body: str
    field: EntropyField
    voxels: Coverage
    targets: Coverage | None


def redundancy(name: str, scene: SceneOptions, score: ScoreOptions, asked: Asked) -> None:
    """Print what a rig loses with its sensors, also written to a JSON file; with "-" as JSON alone."""
    rig = rig_called(name)
    (mesh,) = meshes_called([name], [rig], score)
    if asked.json not in (None, "-"):
        require_writable(asked.json, (name, *scene.files))
    for line in missing_rays(rig):
        note(line)
    found = coverage_of(rig, mesh, scene, score, asked)
    text = to_text(document_of(found, asked.settings.min_points))
    if asked.json == "-":
        sys.stdout.write(text)
        return
    if asked.json is not None:
        write_text(Path(asked.json), text)
    print_redundancy(rig, found.body, found.voxels, found.targets)


def coverage_of(
    rig: Rig, mesh: BodyMesh | None, scene: SceneOptions, score: ScoreOptions, asked: Asked
) -> Found:
    """Load the scene and find what the rig covers."""
    settings = settings_of(score)
    _, field = load_with_progress(scene.for_rigs([rig], score))
    with progress_bar("Casting rays"):
        engine = Engine(field, score.threads)
        engine.evaluate(rig, settings, False, mesh)
        voxels = voxel_coverage(engine, rig, settings.method, score.threads)
    targets = None
    if asked.road_users and scene.pog is None:
        with progress_bar("Counting road users") as progress:
            traffic = load_traffic(scene, asked.within_m, progress)
            how = replace(asked.settings, body=settings.body)
            counts = TargetEngine(traffic, score.threads).evaluate(rig, how, mesh=mesh)
            targets = target_coverage(traffic, rig, counts.objects, how.min_points)
    elif asked.road_users:
        note("road users are not counted: a stored POG has none")
    return Found(rig, score.body_of(rig), field, voxels, targets)


def document_of(found: Found, min_points: int) -> dict[str, Any]:
    """The redundancy of a rig as plain data."""
    targets = found.targets
    return {
        "riglens": FORMAT_VERSION,
        "body": found.body,
        "note": NO_EVIDENCE,
        "rig": {"name": found.rig.name, "sha256": rig_sha256(found.rig)},
        "data": {"source": found.field.data.source, "sha256": found.field.data.sha256},
        "voxel_m": found.field.grid.voxel_m,
        "min_points": min_points,
        "voxels": coverage_document(found.voxels, "nat"),
        "road_users": None if targets is None else coverage_document(targets, "road users"),
    }
