"""`riglens study stability`: judge methods and metric in two tables, write CSV and a page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import NamedTuple

from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.metric.entropy import EntropyField
from riglens.core.monitor import Monitor
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.shown_tables import Block, Paragraph, ShownTable, Style, Styled, table
from riglens.core.shown_tables import Cell as ShownCell
from riglens.core.study.stability_edits import EDITS, QUICK_EDITS, method_rows
from riglens.core.study.stability_methods import METHOD_NAMES, MethodRow
from riglens.core.study.stability_metric import (
    DEFAULT_LATTICE,
    LETTERS,
    MetricStudy,
    Ranking,
    RayLattice,
    Setting,
    StabilityPlan,
    agreement,
    study_metric,
)
from riglens.evaluation.loading import load_scene
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import load_scenario, source_of
from riglens.studies.accuracy_text import edge_text
from riglens.studies.files import csv_text, require_folder
from riglens.studies.pages import page
from riglens.studies.stability_findings import (
    TITLES,
    conclusion,
    findings,
    methods_verdict,
    setting_text,
)

QUICK = StabilityPlan(
    edge_factors=(4.0, 2.0), lattices=(RayLattice((176, 64)), RayLattice((704, 256))), resamples=5
)
MAX_EDITS = 1_000_000
FILES = ("stability.html", "stability-methods.csv", "stability-metric.csv")
STYLES: dict[str, Style] = {"ok": "green", "fails": "bold red", "n.a.": "dim"}
WORDS = {"ok": "holds", "fails": "fails", "n.a.": "n.a."}
READING_THE_TABLE = (
    "τ (Kendall) and ρ (Spearman) compare S-MS of the eight rigs with the first row, class by class. The "
    f"letters are the groups by S-MIG, lowest first: {', '.join(map(' '.join, LETTERS.items()))}. "
    "'Least' is the lowest correlation and the rarest order."
)


def study(
    scene: SceneOptions,
    score: ScoreOptions,
    folder: Path,
    quick: bool,
    edits: int | None,
    monitor: Monitor,
) -> list[Block]:
    """Run both parts of the study, write the results into a folder and return them."""
    if edits is not None and not 1 <= edits <= MAX_EDITS:
        raise InputError(f"must be an integer from 1 to {MAX_EDITS} (got {edits})", "edits")
    require_folder(folder, FILES)
    field = load_scene(scene, monitor)[1]
    plan = replace(
        QUICK if quick else StabilityPlan(),
        voxel_m=field.grid.voxel_m,
        camera_weight=score.camera_weight,
        threads=score.threads,
    )
    with monitor.stage("Trying the methods") as progress:
        rows = method_rows(quick, edits or (QUICK_EDITS if quick else EDITS), score.threads, progress)
    if scene.pog is not None:
        monitor.note(
            f"--pog {scene.pog} holds one grid and no frames: δ is not varied and no frames are resampled"
        )
    source = None if scene.pog is not None else source_of(scene)
    with monitor.stage("Ranking the paper's rigs") as progress:
        metric = study_metric(field, _grids(scene, monitor), source, plan, progress)
    described = caption(metric, field.data.short_source)
    texts = (page_of(rows, metric, described), methods_csv(rows), metric_csv(metric))
    for name, text in zip(FILES, texts, strict=True):
        write_file(folder / name, text)
    return [
        methods_table(rows),
        "plain method: DDA in doubles, voxel by voxel; without rays, the obvious implementation",
        *map(Paragraph, methods_verdict(rows)),
        "",
        Paragraph(described),
        orders_table(metric),
        Paragraph(READING_THE_TABLE),
        "",
        findings_table(metric),
        "",
        *map(Paragraph, conclusion(metric)),
        f"{', '.join(FILES)} in {folder}",
    ]


def _grids(scene: SceneOptions, monitor: Monitor) -> Callable[[float, Progress], EntropyField | None]:
    """Return a function for the scene at other voxel edges, as far as they fit into the ROI and the memory."""

    def at(voxel_m: float, progress: Progress) -> EntropyField | None:
        if scene.pog is not None:
            return None
        try:
            return load_scenario(replace(scene, voxel_m=voxel_m), progress).field
        except InputError as error:
            monitor.note(f"{edge_text(voxel_m)} is left out: {error}")
            return None

    return at


# ---------------------------------------------------------------- tables


def methods_csv(rows: Sequence[MethodRow]) -> str:
    """Return part 1 as CSV: per method the verdict, its result, and voxels found, missed and extra."""
    return csv_text(
        [
            {"case": row.case, "why": row.why, "rays": row.rays, "exact": row.exact}
            | {
                f"{method}_{name}": value
                for method in METHOD_NAMES
                for name, value in row.outcomes[method]._asdict().items()
            }
            for row in rows
        ]
    )


def metric_csv(study: MetricStudy) -> str:
    """Return part 2 as CSV, full precision: a line per setting and class; every resample on its own."""
    lines = []
    for varied, value, ranking in (Setting("default", "covered", study.reference), *study.others):
        for cls in CLASSES:
            tau, rho = agreement(ranking, study.reference, cls)
            setting = "" if varied == "default" else setting_text(varied, value)
            line: dict[str, object] = {"varied": varied, "setting": setting, "class": cls}
            line |= {"kendall_tau": tau, "spearman_rho": rho}
            line |= {
                f"order_{of}": " < ".join(ranking.order(of, cls)) for of in ("lidars", "cameras", "rigs")
            }
            line |= {f"s_mig_{letter}": repr(ranking.s_mig[letter][cls]) for letter in LETTERS}
            lines.append(line | {f"s_ms_{rig}": repr(ranking.s_ms[rig][cls]) for rig in ranking.s_ms})
    return csv_text(lines)


def methods_table(rows: Sequence[MethodRow], with_why: bool = False) -> ShownTable:
    """Tabulate part 1: a case per row, the results of the methods next to the right answer."""
    titles = ("case", "rays", "exact", *(TITLES[method] for method in METHOD_NAMES), *["why"] * with_why)
    made = table(*titles, words={*range(len(titles))} - {1})
    for row in rows:
        rays = "" if row.rays is None else f"{row.rays:,}"
        outcomes = (row.outcomes[method] for method in METHOD_NAMES)
        cells = (Styled(one.says, STYLES[one.verdict]) for one in outcomes)
        made.add_row(row.case, rays, row.exact, *cells, *[row.why] * with_why)
    return made


class Cell(NamedTuple):
    """Correlations with the default and orders of the groups as letters; None and "" without one."""

    tau: float | None
    rho: float | None
    lidars: str
    cameras: str


def order_lines(study: MetricStudy) -> Iterator[tuple[str, list[Cell]]]:
    """Yield the default, every other setting, and the resampled frames in two lines: a cell for each class."""

    def cells(ranking: Ranking) -> list[Cell]:
        orders = (
            [*map("".join, (ranking.order(of, cls) for of in ("lidars", "cameras")))] for cls in CLASSES
        )
        found = (agreement(ranking, study.reference, cls) for cls in CLASSES)
        return [Cell(*taus, *letters) for taus, letters in zip(found, orders, strict=True)]

    weight = study.plan.camera_weight
    yield f"default: {edge_text(study.plan.voxel_m)}, λ {weight:g}", cells(study.reference)
    edges = sorted(study.along("δ"), key=lambda other: -float(str(other.value)))
    for other in (*edges, *(one for axis in ("rays", "reading", "λ") for one in study.along(axis))):
        yield setting_text(other.axis, other.value), cells(other.ranking)
    by_class = [*zip(*(cells(drawn.ranking) for drawn in study.along("frames")), strict=True)]
    for name, is_least in (("median", False), ("least", True)) if by_class else ():
        resampled = f"frames resampled {len(by_class[0])} times: {name}"
        yield resampled, [_summary(drawn, is_least) for drawn in by_class]


def _summary(cells: Sequence[Cell], is_least: bool) -> Cell:
    """Return the median or least correlations, with the most frequent or the rarest order."""
    pick = min if is_least else median
    taus = [cell.tau for cell in cells if cell.tau is not None]
    rhos = [cell.rho for cell in cells if cell.rho is not None]
    lidars, cameras = (
        Counter(names).most_common()[-is_least][0]
        for names in ([cell.lidars for cell in cells], [cell.cameras for cell in cells])
    )
    return Cell(pick(taus) if taus else None, pick(rhos) if rhos else None, lidars, cameras)


def orders_table(study: MetricStudy) -> ShownTable:
    """Return the rows of part 2: a setting per row; for each class the correlations and the orders of LiDARs and
    cameras."""
    titles = [title for cls in CLASSES for title in ("\nτ", "\nρ", f"{cls}\norders")]
    made = table("\nsetting", *titles, words={0, 3, 6, 9})
    default: list[Cell] | None = None
    for setting, cells in order_lines(study):
        default = default or cells
        texts = list[ShownCell]()
        for cell, usual in zip(cells, default, strict=True):
            texts += ["—" if figure is None else f"{figure:.2f}".replace("-", "−") for figure in cell[:2]]
            lidars, cameras = (
                Styled(mine or "—", "" if mine == theirs else "red")
                for mine, theirs in zip(cell[2:], usual[2:], strict=True)
            )
            texts.append((lidars, " ", cameras))
        made.add_row(setting, *texts)
    return made


def findings_table(metric: MetricStudy) -> ShownTable:
    """Tabulate the expectations of the metric, each after its verdict."""
    made = table("", "", words={0, 1}, wraps={0, 1}, bare=True)
    for finding in findings(metric):
        verdict = Styled(WORDS[finding.verdict], STYLES[finding.verdict])
        made.add_row(verdict, (Styled(finding.claim, "bold"), f": {finding.evidence}"))
    return made


def caption(study: MetricStudy, source: str) -> str:
    """Describe the inputs of the orders in one line."""
    plan, (columns, rows) = study.plan, DEFAULT_LATTICE.cast
    return (
        f"{source}, {study.frames:,} frames · {edge_text(plan.voxel_m)}, λ {plan.camera_weight:g}, "
        f"{columns} × {rows} rays per camera, {DEFAULT_LATTICE.azimuths} azimuths per LiDAR, reading covered"
    )


def page_of(rows: Sequence[MethodRow], metric: MetricStudy, described: str) -> str:
    """Return both parts of the study as an HTML document."""
    blocks: tuple[str | Styled | ShownTable, ...] = (
        described,
        Styled("1. Methods: cases that break simple ones", "bold"),
        "Every voxel counts in these cases. The right answer comes from rational arithmetic. A method "
        "fails when it misses a voxel that a ray runs through, or adds one that no ray runs through. The plain "
        "method is DDA in doubles, voxel by voxel; where no rays are compared, the obvious implementation.",
        *methods_verdict(rows),
        methods_table(rows, with_why=True),
        Styled("2. The metric: what it promises on this scene", "bold"),
        findings_table(metric),
        *conclusion(metric),
        Styled("3. Orders of the paper’s eight rigs", "bold"),
        f"{READING_THE_TABLE} Red: the order differs from the default.",
        orders_table(metric),
    )
    return page("How stable are the methods, and the metric?", blocks)
