"""`riglens study stability`: judge methods and metric, print both tables, write CSV and HTML."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import load_field, source_of
from riglens.app.studies.accuracy_text import edge_text
from riglens.app.studies.files import require_folder, write_text
from riglens.app.studies.stability_files import methods_csv, metric_csv, page
from riglens.app.studies.stability_text import (
    READING_THE_TABLE,
    TITLES,
    Cell,
    Line,
    caption,
    conclusion,
    findings,
    lines,
    methods_verdict,
)
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.loading import load_scene
from riglens.core.errors import InputError
from riglens.core.metric.entropy import EntropyField
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.study.stability_checks import EDITS, QUICK_EDITS, method_rows
from riglens.core.study.stability_methods import METHODS, MethodRow, Outcome
from riglens.core.study.stability_metric import MetricStudy, RayLattice, StabilityPlan, study_metric

QUICK = StabilityPlan(
    edge_factors=(4.0, 2.0), lattices=(RayLattice((176, 64)), RayLattice((704, 256))), resamples=5
)
MAX_EDITS = 1_000_000
FILES = ("stability.html", "stability-methods.csv", "stability-metric.csv")
STYLES = {"ok": "green", "fails": "bold red", "n.a.": "dim"}
WORDS = {"ok": "holds", "fails": "fails", "n.a.": "n.a."}


def study(scene: SceneOptions, score: ScoreOptions, folder: Path, quick: bool, edits: int | None) -> None:
    """Run both parts of the study and write the results into a folder."""
    if edits is not None and not 1 <= edits <= MAX_EDITS:
        raise InputError(f"--edits must be an integer from 1 to {MAX_EDITS} (got {edits})")
    require_folder(folder, FILES)
    field = load_scene(scene)[1]
    plan = replace(
        QUICK if quick else StabilityPlan(),
        voxel_m=field.grid.voxel_m,
        camera_weight=score.camera_weight,
        threads=score.threads,
    )
    with progress_bar("Trying the methods") as progress:
        rows = method_rows(quick, edits or (QUICK_EDITS if quick else EDITS), score.threads, progress)
    if scene.pog is not None:
        note(f"--pog {scene.pog} holds one grid and no frames: δ is not varied and no frames are resampled")
    source = None if scene.pog is not None else source_of(scene)
    with progress_bar("Ranking the paper's rigs") as progress:
        metric = study_metric(field, _grids(scene), source, plan, progress)
    _write(rows, metric, field.data.short_source, folder)
    _print(rows, metric, field.data.short_source, folder)


def _grids(scene: SceneOptions) -> Callable[[float, Progress], EntropyField | None]:
    """Return a function for the scene at other voxel edges, as far as they fit into the ROI and the memory."""

    def at(voxel_m: float, progress: Progress) -> EntropyField | None:
        if scene.pog is not None:
            return None
        try:
            return load_field(replace(scene, voxel_m=voxel_m), progress)[1]
        except InputError as error:
            note(f"{edge_text(voxel_m)} is left out: {error}")
            return None

    return at


def _write(rows: Sequence[MethodRow], metric: MetricStudy, source: str, folder: Path) -> None:
    texts = (page(rows, metric, source), methods_csv(rows), metric_csv(metric))
    for name, text in zip(FILES, texts, strict=True):
        write_text(folder / name, text)


def _print(rows: Sequence[MethodRow], metric: MetricStudy, source: str, folder: Path) -> None:
    console = results()

    def say(*sentences: str) -> None:
        for sentence in sentences:
            console.print(sentence, markup=False)

    console.print(methods_table(rows))
    say("plain method: DDA in doubles, voxel by voxel; without rays, the obvious implementation")
    say(*methods_verdict(rows), "", caption(metric, source))
    console.print(orders_table(lines(metric)))
    say(READING_THE_TABLE, "")
    console.print(findings_table(metric))
    say("", *conclusion(metric))
    console.print(f"{', '.join(FILES)} in {folder}", soft_wrap=True, markup=False)


def findings_table(metric: MetricStudy) -> Table:
    """Tabulate the expectations of the metric, each after its verdict."""
    table = Table.grid(padding=(0, 1))
    for finding in findings(metric):
        verdict = Text(WORDS[finding.verdict], STYLES[finding.verdict])
        table.add_row(verdict, Text.assemble((finding.claim, "bold"), f": {finding.evidence}"))
    return table


def methods_table(rows: Sequence[MethodRow]) -> Table:
    """Tabulate part 1: a case per row, the results of the methods next to the right answer."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("case", no_wrap=True)
    table.add_column("rays", justify="right", no_wrap=True)
    for title in ("exact", *(TITLES[method] for method in METHODS)):
        table.add_column(title, no_wrap=True)
    for row in rows:
        rays = "" if row.rays is None else f"{row.rays:,}"
        outcomes = (_outcome(row.outcomes[method]) for method in METHODS)
        table.add_row(Text(row.case), rays, Text(row.exact), *outcomes)
    return table


def _outcome(outcome: Outcome) -> Text:
    return Text(outcome.text, STYLES[outcome.verdict])


def orders_table(found: Iterator[Line]) -> Table:
    """Part 2: a setting per row; for each class the correlations and the orders of LiDARs and cameras."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("\nsetting", no_wrap=True)
    for cls in CLASSES:
        table.add_column("\nτ", justify="right", no_wrap=True)
        table.add_column("\nρ", justify="right", no_wrap=True)
        table.add_column(f"{cls}\norders", no_wrap=True)
    for line in found:
        table.add_row(Text(line.setting), *(text for cell in line.cells for text in _cells(cell)))
    return table


def _cells(cell: Cell) -> tuple[Text, ...]:
    figures = [Text("-" if figure is None else f"{figure:.2f}") for figure in (cell.tau, cell.rho)]
    lidars = (cell.lidars or "-", "" if cell.lidars_as_default else "red")
    cameras = (cell.cameras or "-", "" if cell.cameras_as_default else "red")
    return *figures, Text.assemble(lidars, " ", cameras)
