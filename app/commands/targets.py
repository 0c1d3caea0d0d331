"""Hit coverage: points and pixels of rigs on objects; part of `riglens evaluate`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import CountArguments, Parts
from riglens.app.commands.output import require_outputs
from riglens.app.terminal.console import progress_bar, results
from riglens.core.errors import InputError
from riglens.core.figures.documents import objects_document
from riglens.core.figures.figure import SE_FACTOR, Estimate
from riglens.core.figures.objects import ObjectFigure, Part, parts_by_class, parts_by_sector
from riglens.core.figures.predicted import FOUND, found_text
from riglens.core.figures.registry import object_figures
from riglens.core.files import atomic_write, require_ending
from riglens.core.metric.scores import common_body
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import AnyKind, further_kinds
from riglens.core.shown_text import visible
from riglens.core.shown_values import NONE
from riglens.core.targets.calibration import read_calibration
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine, warm_up
from riglens.core.targets.object_table import object_table
from riglens.core.targets.settings import HEIGHT_PX, TargetSettings
from riglens.core.targets.traffic import Traffic, require_within
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.studies.files import write_csv

if TYPE_CHECKING:
    import pyarrow as pa

_ROWS_AT_ONCE = 10_000
"""Of an object table that is written as CSV."""


@dataclass(frozen=True)
class HitCoverage:
    """Figures of rigs in the same traffic."""

    counted: list[Counted]

    def document(self) -> dict[str, Any]:
        """Return the figures as plain data."""
        return objects_document(self.counted)

    def show(self, by: Parts) -> None:
        """Print figures, and what they were counted on, on standard output."""
        console, wanted = results(), self._figures
        for line in _heading(self.counted):
            console.print(line, soft_wrap=True)
        console.print(_table(self.counted, wanted, self._parts(by, wanted)))
        for text in _explanation(self.counted, wanted):
            console.print(text, soft_wrap=True)

    @property
    def _figures(self) -> tuple[ObjectFigure, ...]:
        """The figures of the kinds of sensors that any of the rigs has; recall is said in words."""
        present = {s.kind for one in self.counted for s in one.rig.sensors if s.enabled}
        return tuple(figure for figure in object_figures(present) if figure is not FOUND)

    def _parts(self, by: Parts, wanted: Sequence[ObjectFigure]) -> dict[str, dict[str, Part]]:
        """Return the parts of each class by their titles; none for several rigs."""
        if len(self.counted) > 1:
            return {name: {} for name in CLASSES}
        only = self.counted[0]
        if by == "sector":
            return parts_by_sector(only, wanted)
        return {
            name: {f"{ring.from_m:g} to {ring.to_m:g} m": ring for ring in found.rings}
            for name, found in parts_by_class(only, wanted, with_rings=True).items()
        }


def require_count_outputs(
    count: CountArguments, rigs: Sequence[Rig], reads: Sequence[str | Path], json: str | None, by: Parts
) -> None:
    """Raise InputError when a file that is named cannot be written, or what is asked for is for one rig."""
    require_ending("objects", count.objects, ".csv", ".parquet")
    of_one = {"objects": count.objects is not None, "by": by != "ring"}
    for name in (name for name, said in of_one.items() if said and len(rigs) > 1):
        raise InputError(f"is for one rig (got {len(rigs)} rigs)", name)
    require_outputs(reads, json, count.objects)


def require_countable(scene: SceneOptions, count: CountArguments) -> None:
    """Raise InputError for a scene without objects, or a distance within which none can be."""
    if scene.pog is not None:
        raise InputError("needs a box data set: a stored POG holds no objects", "targets")
    require_within(count.within_m)


def count_hits(
    rigs: Sequence[Rig], traffic: Traffic, how: TargetSettings, count: CountArguments, score: ScoreOptions
) -> HitCoverage:
    """Count for each rig from scratch, so that their times can be compared."""
    found = []
    warm_up(score.threads)
    with progress_bar("Casting rays") as progress:
        for number_, rig in enumerate(rigs, 1):
            engine = TargetEngine(traffic, score.threads)
            found.append(engine.evaluate(rig, how, count.sample))
            progress(number_ / len(rigs))
    if count.objects is not None:
        _write_objects(count.objects, object_table(found[0]))
    return HitCoverage(found)


def count_settings(count: CountArguments, score: ScoreOptions) -> TargetSettings:
    """Return the settings of counting; raise InputError for a calibration that cannot be read."""
    return TargetSettings(
        count.shape, count.range_law == "on", count.phase, count.seed, count.min_points, score.body,
        None if count.calibration is None else read_calibration(count.calibration),
    )  # fmt: skip


def _write_objects(path: Path, table: pa.Table) -> None:
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
    by_rig = ", ".join(f"{one.settings.body} for {visible(one.rig.name)}" for one in every)
    calibration = counted.calibration
    yield _line(
        "Predict",
        f"{calibration.predicts} by '{visible(calibration.name)}', objects {calibration.domain.region}, LiDARs alone",
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
    yield (
        f"An object is detected by {first.settings.min_points} LiDAR points, or {HEIGHT_PX} px of height in a picture"
        f"{''.join(f', or {k.hits.threshold:g} {k.hits.label} of {k.plural}' for k in _further(every))}."
    )
    if recall := first.settings.recall:
        for one in every:
            if text := found_text(one, SE_FACTOR):
                reason = one.outside(recall)
                outside = f"; outside its domain: {reason}" if reason else ""
                yield f"{visible(one.rig.name)}: {text[0].lower()}{text[1:]}{outside}."
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
    for name in CLASSES:
        table.add_row(Text(name, "bold"))
        for one, found in zip(every, totals, strict=True):
            table.add_row(Text(f"  {visible(one.rig.name)}"), *_cells(found[name].total, wanted))
        for title, part in parts[name].items():
            table.add_row(Text(f"    {title}", "dim"), *_cells(part, wanted))
        table.add_section()
    return table


def _further(every: Sequence[Counted]) -> tuple[AnyKind, ...]:
    return further_kinds(kind for one in every for kind in one.objects.returns)


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
