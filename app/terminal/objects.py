"""Points and pixels of rigs on objects in the terminal, and as a table of objects in a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.core.figures.figure import SE_FACTOR, Estimate
from riglens.core.figures.objects import ObjectFigure, Part, parts_by_class, parts_by_sector
from riglens.core.figures.predicted import FOUND, found_text
from riglens.core.figures.registry import object_figures
from riglens.core.files import atomic_write
from riglens.core.metric.scores import common_body
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import further_kinds, kind_of
from riglens.core.shown_text import numbered, visible
from riglens.core.shown_values import NONE
from riglens.core.targets.counts import Counted
from riglens.core.targets.object_table import object_table
from riglens.studies.files import write_csv

Parts = Literal["ring", "sector"]
"""Split of a table of objects, for a single rig."""
_ROWS_AT_ONCE = 10_000
"""Of an object table that is written as CSV."""


def print_objects(every: Sequence[Counted], by: Parts) -> None:
    """Print figures of objects of rigs in the same traffic, and what they were counted on, on standard output."""
    present = {s.kind for one in every for s in one.rig.sensors if s.enabled}
    wanted = tuple(figure for figure in object_figures(present) if figure is not FOUND)  # said in words
    console = results()
    for line in _heading(every):
        console.print(line, soft_wrap=True)
    console.print(_table(every, wanted, _parts(every, wanted, by)))
    for text in _explanation(every, wanted):
        console.print(text, soft_wrap=True)


def write_objects(path: Path, counted: Counted) -> None:
    """Write a row per object as CSV or Parquet, whichever the name ends in."""
    table = object_table(counted)
    if path.suffix.lower() == ".parquet":
        from pyarrow import parquet

        with atomic_write(path) as stream:
            parquet.write_table(table, stream)
        return
    with atomic_write(path, "w") as stream:
        parts = table.to_batches(max_chunksize=_ROWS_AT_ONCE)
        columns = ([column.to_pylist() for column in part.columns] for part in parts)
        write_csv(stream, table.column_names, (row for part in columns for row in zip(*part, strict=True)))


# ---------------------------------------------------------------- tables


def _parts(
    every: Sequence[Counted], wanted: Sequence[ObjectFigure], by: Parts
) -> Mapping[str, Mapping[str, Part]]:
    """Return the parts of each class by their titles; none for several rigs."""
    if len(every) > 1:
        return {name: {} for name in CLASSES}
    if by == "sector":
        return parts_by_sector(every[0], wanted)
    return {
        name: {f"{ring.from_m:g} to {ring.to_m:g} m": ring for ring in found.rings}
        for name, found in parts_by_class(every[0], wanted, with_rings=True).items()
    }


def _heading(every: Sequence[Counted]) -> Iterator[Text]:
    """Data and assumptions, in three lines."""
    counted = every[0]
    settings, traffic = counted.settings, counted.traffic
    frames = f"{counted.frames:,} frames"
    if not counted.is_whole:
        frames = f"{counted.frames_used:,} of {counted.frames:,} frames"
    numbers = np.bincount(counted.groups.cls, minlength=len(CLASSES)).tolist()
    objects = ", ".join(f"{name} {number:,}" for name, number in zip(CLASSES, numbers, strict=True))
    source = visible(traffic.data.short_source)
    yield _line("Data", f"{source}: {frames}; objects within {traffic.within_m:g} m: {objects}")
    around = "block" if traffic.surroundings_sha256 else "ignored"
    shape = "plain boxes" if settings.shape == "box" else "class shapes"
    law = "range law" if settings.range_law else "no range law"
    phase = f"random (seed {settings.seed})" if settings.phase == "random" else "as listed"
    body = common_body(one.settings.body for one in every)
    by_rig = ", ".join(
        f"{one.settings.body} for {title}" for one, title in zip(every, _titles(every), strict=True)
    )
    calibration = counted.calibration
    yield _line(
        "Predict",
        f"{calibration.predicts} by '{visible(calibration.name)}', fitted {calibration.domain.region}, by "
        f"{' and '.join(kind_of(kind).plural for kind in calibration.kinds)}",
    )
    yield _line("Count", f"body {body or by_rig}, {shape}, {law}, spin phase {phase}, surroundings {around}")


def _explanation(every: Sequence[Counted], wanted: Sequence[ObjectFigure]) -> Iterable[str]:
    """Yield the lines that explain the columns."""
    first = every[0]
    for figure in wanted:
        calibration = figure.calibrated(first)
        if calibration is not None:
            yield f"{_heading_of(figure)}: by this detector: {visible(calibration.detector)}."
        elif not figure.leads:
            yield f"{_heading_of(figure)}: {figure.tip}"
    further = further_kinds(kind for one in every for kind in one.objects.returns)
    yield (
        f"An object is detected by {first.settings.min_points} LiDAR points, or half of it in a picture"
        f"{''.join(f', or {k.hits.threshold:g} {k.hits.label} of {k.plural}' for k in further)}."
    )
    if recall := first.settings.recall:
        for one, title in zip(every, _titles(every), strict=True):
            if text := found_text(one, SE_FACTOR):
                reason = one.outside(recall)
                outside = f"; outside its domain: {reason}" if reason else ""
                yield f"{title}: {text[0].lower()}{text[1:]}{outside}."
        yield (
            f"found = by this detector: {visible(recall.detector)}; ± two standard errors. It does not predict your "
            "stack."
        )
    if len(every) > 1:
        for figure in wanted:
            if figure.resolved:
                yield (
                    f"Differences of less than {100.0 * figure.resolved:g} in {_heading_of(figure)} do not tell rigs "
                    "apart."
                )
    sample = "" if first.is_whole else "of the sample of frames and "
    yield f"± is two standard errors {sample}of the calibration."


def _titles(every: Sequence[Counted]) -> tuple[str, ...]:
    """Return the names of rigs, those of one name with numbers."""
    return numbered([visible(one.rig.name) for one in every])


def _table(
    every: Sequence[Counted],
    wanted: Sequence[ObjectFigure],
    parts: Mapping[str, Mapping[str, Part]],
) -> Table:
    """Rigs as rows, one section per class, with its parts below."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=0)
    table.add_column("in %, except\nobjects and medians", no_wrap=True, overflow="ellipsis", max_width=20)
    for title in ("objects", *(figure.short for figure in wanted)):
        stacked = _stacked(title)
        widest = max(map(len, stacked.split()))
        # without room, ± goes below the value
        table.add_column(stacked, justify="right", min_width=max(5, widest))
    totals = [parts_by_class(one, wanted) for one in every]
    titles = _titles(every)
    for name in CLASSES:
        table.add_row(Text(name, "bold"))
        for rig_title, found in zip(titles, totals, strict=True):
            table.add_row(Text(f"  {rig_title}"), *_cells(found[name].total, wanted))
        for title, part in parts[name].items():
            table.add_row(Text(f"    {title}", "dim"), *_cells(part, wanted))
        table.add_section()
    return table


def _heading_of(figure: ObjectFigure) -> str:
    """Return a figure's heading within a sentence."""
    return figure.short if figure.short[:2].isupper() else f"{figure.short[0].lower()}{figure.short[1:]}"


def _stacked(words: str) -> str:
    """Return a heading of two lines."""
    first, _, last = words.rpartition(" ")
    return f"{first}\n{last}"


def _cells(part: Part, wanted: Sequence[ObjectFigure]) -> list[str]:
    return [f"{part.objects:,}", *(_text(figure, part[figure.key]) for figure in wanted)]


def _text(figure: ObjectFigure, found: Estimate) -> str:
    """Percent, with two standard errors where it is a sample or a prediction; numbers as they are."""
    if not found.exists:
        return NONE
    if figure.unit != "share":
        return f"{found.value:g}" if figure.unit == "points" else f"{found.value:.0f}"
    if found.se == 0.0:
        return f"{100.0 * found.value:.1f}"
    return f"{100.0 * found.value:.1f} ±{100.0 * SE_FACTOR * found.se:.1f}"


def _line(label: str, text: str) -> Text:
    return Text.assemble((f"{label:<8}", "bold"), text)
