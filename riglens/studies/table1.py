"""`riglens study table1`: score the paper's eight rigs next to the published figures, write CSV.

Published detection against our figures is in `table2`, what the paper claims in `paper_claims`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from riglens.core.engine.engine import Engine
from riglens.core.files import require_writable, write_file
from riglens.core.metric.scores import DEFAULT_LAMBDA
from riglens.core.monitor import Monitor
from riglens.core.rig.presets import PAPER_RIGS, preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_tables import Block, ShownTable, Styled, table
from riglens.core.shown_values import thousands
from riglens.core.study.paper_claims import claims, sweeps
from riglens.core.study.table1 import MEASURES, Measure, Table1, Table1Row, published_table1, table1
from riglens.evaluation.loading import load_scene
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import settings_of
from riglens.evaluation.scene_words import scene_lines
from riglens.studies.files import csv_text
from riglens.studies.paper_claims import CameraScores, camera_scores, claims_shown
from riglens.studies.table2 import compare_papers, papers_shown, write_papers

MEASURE_TITLES: dict[Measure, str] = {
    "camera_s_mig": "Camera S-MIG",
    "lidar_s_mig": "LiDAR S-MIG",
    "s_ms": "S-MS",
}


def study(
    scene: SceneOptions,
    score: ScoreOptions,
    csv_target: Path | None,
    detection_csv: Path | None,
    sheet_target: Path | None,
    monitor: Monitor,
) -> list[Block]:
    """Return the paper's Tables I and II next to our figures, the agreement of the orders, and what the paper claims;
    also write tables as CSV, and its groups as a sheet."""
    for target in (csv_target, detection_csv, sheet_target):
        if target is not None:
            require_writable(target, scene.files)
    rigs = [preset(name) for name in PAPER_RIGS]
    _, field = load_scene(scene, monitor, rigs, score)
    engine = Engine(field, score.threads)
    with monitor.stage("Casting rays") as progress:
        found = table1(engine, settings_of(score), progress)
    papers = compare_papers(engine, scene, monitor)
    if detection_csv is not None:
        write_papers(papers, detection_csv)
    if csv_target is not None:
        write_file(csv_target, table1_csv(found))
    if sheet_target is not None:
        from riglens.studies.paper_sheet import sheet  # matplotlib
        from riglens.studies.pictures import write_picture

        write_picture(sheet_target, sheet())
    published = published_table1()
    ours = {row.rig: row.ours for row in found.rows}
    voxels = _camera_scores(engine, field.grid.voxel_m, scene, score, monitor)
    return [
        *scene_lines(field, rigs, score),
        figures_table(found),
        orders_table(found),
        *verdict(found),
        *papers_shown(papers),
        *claims_shown(
            claims(papers[0].paper, published, DEFAULT_LAMBDA),
            sweeps(papers[0].paper, ours, DEFAULT_LAMBDA),
            voxels,
        ),
    ]


def _camera_scores(
    engine: Engine, voxel_m: float, scene: SceneOptions, score: ScoreOptions, monitor: Monitor
) -> list[CameraScores]:
    """Score the cameras on the voxels of the scene, and on twice as large ones where the scene can be filled again."""
    found = [camera_scores(engine, voxel_m, settings_of(score))]
    if scene.pog is None:
        coarse = replace(scene, voxel_m=2.0 * voxel_m, tolerance_pp=None)
        field = load_scene(coarse, monitor)[1]
        found.append(camera_scores(Engine(field, score.threads), 2.0 * voxel_m, settings_of(score)))
    return found


def table1_csv(found: Table1) -> str:
    """Return the table as CSV, one line per rig and class, full precision, in nats."""
    return csv_text([_csv_line(row, cls) for row in found.rows for cls in CLASSES])


def _csv_line(row: Table1Row, cls: str) -> dict[str, object]:
    line: dict[str, object] = {"rig": row.rig, "class": cls}
    line |= {measure: repr(row.ours[cls].of(measure)) for measure in MEASURES}
    line |= {f"published_{measure}": repr(row.published[cls].of(measure)) for measure in MEASURES}
    return line


def figures_table(found: Table1) -> ShownTable:
    """Tabulate the paper's Table I with its three blocks one below the other: our figures next to the published, 10³
    nat."""
    titles = [title for name in CLASSES for title in (f"{name}\nours", "\npaper")]
    shown = table("10³ nat", *titles, dim=range(2, 1 + len(titles), 2))
    for measure in MEASURES:
        shown.add_row(Styled(MEASURE_TITLES[measure], "bold"))
        for row in found.rows:
            shown.add_row(f"  {row.rig}", *_beside(row, measure))
        shown.add_section()
    return shown


def _beside(row: Table1Row, measure: Measure) -> Iterable[str]:
    for name in CLASSES:
        yield thousands(row.ours[name].of(measure), 2)
        yield thousands(row.published[name].of(measure), 2)


def orders_table(found: Table1) -> ShownTable:
    """Return the order of groups and rigs for each class, lowest first, and the paper's where it differs."""
    shown = table("class", "order of", "lowest first", "agrees", "τ", words=range(5))
    for order in found.orders:
        ours = " < ".join(order.ours)
        lines = ours if order.agrees else f"{ours}\npaper: {' < '.join(order.published)}"
        verdict = Styled("yes", "green") if order.agrees else Styled("no", "bold red")
        by = "rigs, S-MS" if order.what == "rigs" else order.what
        tau = "-" if order.kendall_tau is None else f"{order.kendall_tau:.2f}"
        shown.add_row(order.cls if order.what == "LiDAR groups" else "", by, lines, verdict, tau)
        if order.what == "rigs":
            shown.add_section()
    return shown


def verdict(found: Table1) -> Iterable[str]:
    """Yield how many orders agree, and the conclusion."""
    same = sum(order.agrees for order in found.orders)
    yield f"{same} of {len(found.orders)} orders are the paper's; τ is Kendall's rank correlation with it."
    yield "Compare orders, not figures: those depend on the traffic, the voxel edge and the number of rays."
