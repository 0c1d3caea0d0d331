"""`riglens study accuracy`: measure; table and findings, chart and CSV."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.metric.entropy import EntropyField
from riglens.core.monitor import Monitor
from riglens.core.shown_tables import Block, ShownTable, Styled, table
from riglens.core.shown_text import visible
from riglens.core.study.accuracy import (
    AccuracyPlan,
    AccuracyStudy,
    Point,
    require_sensors,
    study_accuracy,
)
from riglens.core.study.simple_methods import unknown_to_rough
from riglens.evaluation.loading import load_rig, load_scene
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import load_scenario
from riglens.studies.accuracy_chart import chart
from riglens.studies.accuracy_text import (
    accuracy_csv,
    caption,
    edge_text,
    percent,
    point_text,
    verdicts,
)
from riglens.studies.files import require_folder
from riglens.studies.pictures import PICTURES, write_pictures

OTHER_EDGES = (0.5, 2.0, 4.0)
"""Further voxel edges, as multiples of the requested one; the first is the reference of S-MS."""
QUICK = AccuracyPlan(repetitions=1, lattices=("1/2", "1/4"))
FILES = (*(f"accuracy.{file_format}" for file_format in PICTURES), "accuracy.csv")


def study(
    rig_name: str,
    scene: SceneOptions,
    score: ScoreOptions,
    folder: Path,
    quick: bool,
    monitor: Monitor,
) -> list[Block]:
    """Measure time and error of all methods and settings for one rig, write the results into a folder and return
    them."""
    rig = load_rig(rig_name, monitor)
    require_sensors(rig)
    require_folder(folder, FILES)
    if odd := unknown_to_rough(rig):
        names = ", ".join(map(visible, odd))
        monitor.note(
            f"{names}: lens distortion or azimuth offsets; bounding rectangles and voxel centres are left out"
        )
    plan = replace(
        QUICK if quick else AccuracyPlan(), threads=score.threads, camera_weight=score.camera_weight
    )
    _, field = load_scene(scene, monitor)
    edges = OTHER_EDGES[1:] if quick else OTHER_EDGES
    fields = {field.grid.voxel_m: field, **_other_fields(scene, field.grid.voxel_m, edges, monitor)}
    with monitor.stage("Measuring") as progress:
        found = study_accuracy(fields, field.grid.voxel_m, rig, plan, progress)
    source = field.data.short_source
    _write(found, source, folder)
    files = f"{', '.join(FILES)} in {folder}"
    return [accuracy_table(found), *verdicts(found), "", caption(found, source), files]


def _other_fields(
    scene: SceneOptions, voxel_m: float, edges: tuple[float, ...], monitor: Monitor
) -> dict[float, EntropyField]:
    """Yield the same scene with other voxel edges, as far as they fit into the ROI and the memory."""
    if scene.pog is not None:
        monitor.note(f"--pog {scene.pog} holds one grid only: other voxel edges are not measured")
        return {}
    fields = {}
    for factor in edges:
        other = replace(scene, voxel_m=factor * voxel_m)
        try:
            with monitor.stage(f"Building the POG at {edge_text(factor * voxel_m)}") as progress:
                fields[factor * voxel_m] = load_scenario(other, progress).field
        except InputError as error:
            monitor.note(f"{edge_text(factor * voxel_m)} is left out: {error.message}")
    return fields


def _write(found: AccuracyStudy, source: str, folder: Path) -> None:
    write_file(folder / "accuracy.csv", accuracy_csv(found))
    write_pictures(chart(found, source), folder, "accuracy")


def accuracy_table(found: AccuracyStudy) -> ShownTable:
    """Return all points, the fastest last per kind; ● marks the Pareto fronts."""
    voxels, errors = ("missed\nvoxels", "extra\nvoxels", ""), ("S-MS error\ngrid", "S-MS error\nshortcut", "")
    made = table("method and setting", "rays", "median\nms", *voxels, *errors)
    for point in found.points:
        name = Styled(point_text(point, found), "bold" if point is found.own else "")
        made.add_row(
            name, f"{point.rays:,}", f"{point.median_ms:.3g}", *_voxel_cells(point), *_score_cells(point)
        )
    return made


def _voxel_cells(point: Point) -> tuple[str, str, str]:
    if point.wrong is None:
        return "n/a", "n/a", ""
    return percent(point.wrong.missed), percent(point.wrong.extra), "●" if point.on_voxel_front else ""


def _score_cells(point: Point) -> tuple[str, str, str]:
    """Return the two parts of the error for the class with the largest sum."""
    known = [error for error in point.errors.values() if error.both is not None]
    if not known:
        return "n/a", "n/a", ""
    worst = max(known, key=lambda error: error.both or 0.0)
    mark = "●" if point.on_score_front else ""
    return percent(worst.grid_error or 0.0), percent(worst.shortcut_error or 0.0), mark
