"""Tables for the terminal: scores of rigs, presets, the paper's Table I. At most 100 columns wide."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.commands.figures import decimals, percent, thousands
from riglens.core.engine.engine import Evaluation
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings, Reading
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.study.table1 import MEASURES, Measure, Table1, Table1Row

EXPLANATION: dict[Reading, str] = {
    "covered": "S-MIG = minus the entropy that is seen, so S-MS falls as a rig sees more; "
    "'seen' says how much, in % of H(Ω).",
    "residual": "S-MIG = minus the entropy left unseen, so S-MS rises towards 0 as a rig sees more.",
    "hits": "S-MIG counts a voxel once per ray through it; 'seen' still counts every voxel once.",
}


def scene_lines(field: EntropyField, settings: MetricSettings, source: str) -> Iterable[Text]:
    """What was scored, in three lines: grid, data, metric."""
    nx, ny, nz = field.grid.shape
    length, width, height = field.grid.roi_m
    yield _line(
        "Grid",
        f"{nx} × {ny} × {nz} voxels of {field.grid.voxel_m:g} m ({length:g} × {width:g} × {height:g} m), "
        f"{field.index.count:,} informative",
    )
    yield _line("Data", data_line(field.data, source))
    yield _line(
        "Metric",
        f"{settings.method} traversal, reading {settings.reading}, λ = {settings.camera_weight:g}: "
        f"S-MS = λ · S-MIG(camera) + S-MIG(LiDAR)",
    )


def data_line(data: DataReport, source: str) -> str:
    """Name, frames and boxes of a data set in one line."""
    boxes = ", ".join(f"{name} {data.boxes.get(name, 0):,}" for name in CLASSES)
    return f"{source}: {data.frames:,} frames; boxes: {boxes}"


def _line(label: str, text: str) -> Text:
    return Text.assemble((f"{label:<8}", "bold"), text)


def score_table(evaluations: Sequence[Evaluation]) -> Table:
    """Rigs as rows, one section per class: S-MIG of cameras and LiDARs, S-MS, and what is seen."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("10³ nat", no_wrap=True, overflow="ellipsis", max_width=28)
    for title in ("S-MIG\ncamera", "S-MIG\nLiDAR", "\nS-MS", "seen\ncamera", "seen\nLiDAR", "seen\nany"):
        table.add_column(title, justify="right", no_wrap=True)
    for name in CLASSES:
        h_total = evaluations[0].scores.classes[name].h_total
        digits = decimals(h_total)
        table.add_row(Text(f"{name}, H(Ω) {thousands(h_total, digits)}", "bold"))
        for evaluation in evaluations:
            table.add_row(Text(f"  {evaluation.rig.name}"), *_figures(evaluation, name, digits))
        table.add_section()
    return table


def _figures(evaluation: Evaluation, name: str, digits: int) -> list[str]:
    scores = evaluation.scores.classes[name]
    entropies = (scores.camera.s_mig, scores.lidar.s_mig, scores.s_ms)
    shares = (scores.camera.seen, scores.lidar.seen, scores.any_seen)
    return [*(thousands(value, digits) for value in entropies), *(percent(share) for share in shares)]


def preset_table(presets: Iterable[tuple[str, str, int, int]]) -> Table:
    """Built-in rigs: name, description, cameras, LiDARs."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("preset", no_wrap=True)
    table.add_column("cameras", justify="right")
    table.add_column("LiDARs", justify="right")
    table.add_column("what it is")
    for name, description, cameras, lidars in presets:
        table.add_row(Text(name, "bold"), str(cameras), str(lidars), Text(description))
    return table


MEASURE_TITLES: dict[Measure, str] = {
    "camera_s_mig": "Camera S-MIG",
    "lidar_s_mig": "LiDAR S-MIG",
    "s_ms": "S-MS",
}


def table1_figures(table: Table1) -> Table:
    """The paper's Table I with its three blocks one below the other: ours beside the published, 10³ nat."""
    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    shown.add_column("10³ nat", no_wrap=True)
    for name in CLASSES:
        shown.add_column(f"{name}\nours", justify="right", no_wrap=True)
        shown.add_column("\npaper", justify="right", no_wrap=True, style="dim")
    for measure in MEASURES:
        shown.add_row(Text(MEASURE_TITLES[measure], "bold"))
        for row in table.rows:
            shown.add_row(f"  {row.rig}", *_beside(row, measure))
        shown.add_section()
    return shown


def _beside(row: Table1Row, measure: Measure) -> Iterable[str]:
    for name in CLASSES:
        yield thousands(row.ours[name].of(measure), 2)
        yield thousands(row.published[name].of(measure), 2)


def table1_orders(table: Table1) -> Table:
    """For each class the order of groups and rigs, lowest first; the paper's as well where it is another."""
    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for title in ("class", "order of", "lowest first", "agrees", "τ"):
        shown.add_column(title, no_wrap=True)
    for order in table.orders:
        ours = " < ".join(order.ours)
        lines = ours if order.agrees else f"{ours}\npaper: {' < '.join(order.published)}"
        verdict = Text("yes", "green") if order.agrees else Text("no", "bold red")
        by = "rigs, S-MS" if order.what == "rigs" else order.what
        tau = "-" if order.kendall_tau is None else f"{order.kendall_tau:.2f}"
        shown.add_row(order.cls if order.what == "LiDAR groups" else "", by, lines, verdict, tau)
        if order.what == "rigs":
            shown.add_section()
    return shown


def table1_verdict(table: Table1) -> Iterable[str]:
    """How many orders agree, and what to make of it."""
    same = sum(order.agrees for order in table.orders)
    yield f"{same} of {len(table.orders)} orders are the paper's; τ is Kendall's rank correlation with it."
    yield "Compare orders, not figures: those depend on the traffic, the voxel edge and the number of rays."
