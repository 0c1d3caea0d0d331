"""What rigs get onto road users as tables in the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.core.metric.scores import common_body
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible
from riglens.core.targets.scores import Estimate, Row, TargetScores
from riglens.core.targets.settings import HEIGHT_PX
from riglens.core.targets.traffic import Traffic


def print_targets(traffic: Traffic, scores: Sequence[TargetScores]) -> None:
    """Print figures of rigs in the same traffic, and what they were counted on, on standard output."""
    console = results()
    for line in heading(traffic, scores):
        console.print(line, soft_wrap=True)
    console.print(targets_table(scores))
    for text in explanation(scores[0]):
        console.print(text, soft_wrap=True)


def heading(traffic: Traffic, every: Sequence[TargetScores]) -> Iterator[Text]:
    """Data and assumptions, in two lines."""
    scores = every[0]
    settings = scores.settings
    frames = f"{scores.frames:,} frames"
    if scores.frames_used < scores.frames:
        frames = f"{scores.frames_used:,} of {scores.frames:,} frames"
    objects = ", ".join(f"{name} {scores.classes[name].total.objects:,}" for name in CLASSES)
    source = visible(traffic.data.short_source)
    yield _line("Data", f"{source}: {frames}; road users within {traffic.within_m:g} m: {objects}")
    around = "block" if traffic.surroundings_sha256 else "ignored"
    shape = "plain boxes" if settings.shape == "box" else "class shapes"
    law = "range law" if settings.range_law else "no range law"
    phase = f"random (seed {settings.seed})" if settings.phase == "random" else "as listed"
    body = common_body(one.settings.body for one in every)
    by_rig = ", ".join(f"{one.settings.body} for {visible(one.rig.name)}" for one in every)
    yield _line("Count", f"body {body or by_rig}, {shape}, {law}, spin phase {phase}, surroundings {around}")


def explanation(scores: TargetScores) -> Iterable[str]:
    """What the columns are."""
    points = scores.settings.min_points
    yield (
        "on target = mean of 1 - exp(-cells/5), cells of 0.2 m hit by LiDARs; visible = pixels seen of those it would "
        "have alone."
    )
    yield (
        f"both = at least {points} points, and {HEIGHT_PX} pixels tall; neither = less of each. More is better, but for"
        " neither."
    )
    if scores.frames_used < scores.frames:
        yield "± is one standard error of the sample of frames."


def targets_table(scores: Sequence[TargetScores]) -> Table:
    """Rigs as rows, one section per class, with the rings of distance below where there is one rig."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    points = scores[0].settings.min_points
    table.add_column("in %, but for\nobjects and medians", no_wrap=True, overflow="ellipsis", max_width=22)
    for title in (
        "\nobjects", "LiDAR\non target", "LiDAR\n≥ 1 pt", f"LiDAR\n≥ {points} pts", "median\npts",
        "camera\nvisible", f"camera\n≥ {HEIGHT_PX} px", "median\npx", "\nboth", "\nneither",
    ):  # fmt: skip
        table.add_column(title, justify="right", no_wrap=True)
    for name in CLASSES:
        table.add_row(Text(name, "bold"))
        for one in scores:
            table.add_row(Text(f"  {visible(one.rig.name)}"), *_figures(one.classes[name].total))
            for ring in one.classes[name].rings if len(scores) == 1 else ():
                table.add_row(Text(f"    {ring.from_m:g} to {ring.to_m:g} m", "dim"), *_figures(ring))
        table.add_section()
    return table


def _figures(row: Row) -> list[str]:
    if not row.objects:
        return ["0", *["–"] * 9]
    return [
        f"{row.objects:,}",
        _share(row.on_target),
        _share(row.share_1),
        _share(row.share_n),
        f"{row.median_points:g}",
        _share(row.visible),
        _share(row.share_25px),
        f"{row.median_height_px:.0f}",
        _share(row.both),
        _share(row.neither),
    ]


def _share(found: Estimate) -> str:
    """Percent, with its standard error where it comes from a sample."""
    if found.se == 0.0:
        return f"{100.0 * found.value:.1f}"
    return f"{100.0 * found.value:.1f}±{100.0 * found.se:.1f}"


def _line(label: str, text: str) -> Text:
    return Text.assemble((f"{label:<8}", "bold"), text)
