"""Hit coverage: points and pixels of rigs on objects; part of `riglens evaluate`, also a command of its own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import (
    CountArguments,
    JsonFigures,
    Parts,
    RigArguments,
    RigNames,
    RunArguments,
    Surroundings,
    TrafficArguments,
    command,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.loading import load_rigs, load_traffic
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, require_ending
from riglens.core.metric.scores import common_body
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import AnyKind, further_kinds
from riglens.core.shown_text import visible
from riglens.core.targets.calibration import read_calibration
from riglens.core.targets.engine import TargetEngine, warm_up
from riglens.core.targets.object_table import object_table
from riglens.core.targets.quantities import RESOLVED, SURE
from riglens.core.targets.scores import Estimate, Row, TargetScores, sectors_of
from riglens.core.targets.settings import HEIGHT_PX, TargetSettings
from riglens.core.targets.targets_json import targets_document
from riglens.core.targets.traffic import Traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.scenario import remarks_on
from riglens.studies.files import write_csv

if TYPE_CHECKING:
    import pyarrow as pa

_ROWS_AT_ONCE = 10_000
"""Of an object table that is written as CSV."""


@dataclass(frozen=True)
class HitCoverage:
    """Figures of rigs in the same traffic."""

    traffic: Traffic
    scores: list[TargetScores]

    def document(self) -> dict[str, Any]:
        """Return the figures as plain data."""
        return targets_document(self.traffic, self.scores)

    def show(self, by: Parts) -> None:
        """Print figures, and what they were counted on, on standard output."""
        console = results()
        for line in _heading(self.traffic, self.scores):
            console.print(line, soft_wrap=True)
        console.print(_table(self.scores, self._parts(by)))
        for text in _explanation(self.scores):
            console.print(text, soft_wrap=True)

    def _parts(self, by: Parts) -> dict[str, dict[str, Row]]:
        """Return the rows of parts of each class by their titles; none for several rigs."""
        if len(self.scores) > 1:
            return {name: {} for name in CLASSES}
        only = self.scores[0]
        if by == "sector":
            return sectors_of(self.traffic, only)
        return {
            name: {f"{ring.from_m:g} to {ring.to_m:g} m": ring for ring in found.rings}
            for name, found in only.classes.items()
        }


@command
def targets(
    *rigs: RigNames,
    scene: TrafficArguments = SceneOptions(),
    surroundings: Surroundings = None,
    by: Parts = "ring",
    count: CountArguments = CountArguments(),
    score: RunArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    json: JsonFigures = None,
) -> None:
    """Count the points and pixels of rigs on objects, including occlusion by traffic.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    surroundings
        block: houses, walls and poles of the bundled scenario hide objects too (ignored).
    by
        Parts of the table, for one rig: rings of 10 m of distance, or sectors of 45° around the car.
    """
    loaded = load_rigs(rigs, score, reading.libraries, reading.housings)
    require_count_outputs(count, loaded, (*rigs, *scene.files), json, by)
    found = count_hits(loaded, scene.surrounded(surroundings), count, score)
    deliver(found.document(), json, lambda: found.show(by))


def require_count_outputs(
    count: CountArguments, rigs: Sequence[Rig], reads: Sequence[str | Path], json: str | None, by: Parts
) -> None:
    """Raise InputError when a file that is named cannot be written, or what is asked for is for one rig."""
    require_ending("objects", count.objects, ".csv", ".parquet")
    of_one = {"objects": count.objects is not None, "by": by != "ring"}
    for name in (name for name, said in of_one.items() if said and len(rigs) > 1):
        raise InputError(f"is for one rig (got {len(rigs)} rigs)", name)
    require_outputs(reads, json, count.objects)


def count_hits(
    rigs: Sequence[Rig], scene: SceneOptions, count: CountArguments, score: ScoreOptions
) -> HitCoverage:
    """Load the traffic and count for each rig from scratch, so that their times can be compared."""
    if scene.pog is not None:
        raise InputError("needs a box data set: a stored POG holds no objects", "targets")
    how = count_settings(count, score)
    traffic = load_traffic(scene, count.within_m)
    for line in remarks_on(traffic.data):
        note(line)
    found = []
    warm_up(score.threads)
    with progress_bar("Casting rays") as progress:
        for number_, rig in enumerate(rigs, 1):
            engine = TargetEngine(traffic, score.threads)
            found.append(engine.evaluate(rig, how, count.sample))
            progress(number_ / len(rigs))
    if count.objects is not None:
        _write_objects(count.objects, object_table(traffic, found[0]))
    return HitCoverage(traffic, found)


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


def _heading(traffic: Traffic, every: Sequence[TargetScores]) -> Iterator[Text]:
    """Data and assumptions, in two lines."""
    scores = every[0]
    settings = scores.settings
    frames = f"{scores.frames:,} frames"
    if scores.frames_used < scores.frames:
        frames = f"{scores.frames_used:,} of {scores.frames:,} frames"
    objects = ", ".join(f"{name} {scores.classes[name].total.objects:,}" for name in CLASSES)
    source = visible(traffic.data.short_source)
    yield _line("Data", f"{source}: {frames}; objects within {traffic.within_m:g} m: {objects}")
    around = "block" if traffic.surroundings_sha256 else "ignored"
    shape = "plain boxes" if settings.shape == "box" else "class shapes"
    law = "range law" if settings.range_law else "no range law"
    phase = f"random (seed {settings.seed})" if settings.phase == "random" else "as listed"
    body = common_body(one.settings.body for one in every)
    by_rig = ", ".join(f"{one.settings.body} for {visible(one.rig.name)}" for one in every)
    calibration = scores.calibration
    yield _line(
        "Predict",
        f"{calibration.predicts} by '{visible(calibration.name)}', objects {calibration.domain.region}, LiDARs alone",
    )
    yield _line("Count", f"body {body or by_rig}, {shape}, {law}, spin phase {phase}, surroundings {around}")


def _explanation(every: Sequence[TargetScores]) -> Iterable[str]:
    """Yield the lines that explain the columns."""
    scores = every[0]
    points = scores.settings.min_points
    yield (
        "on target = mean of 1 - exp(-cells/5), cells of 0.2 m hit by LiDARs; visible = pixels seen "
        "of those without occlusion."
    )
    yield (
        f"both = at least {points} points, and {HEIGHT_PX} pixels tall; neither = less of each. More is better, "
        "except for neither."
    )
    for kind in _further(every):
        yield (
            f"{kind.plural} = at least {kind.hits.threshold:g} {kind.hits.label}; one more kind in both and neither."
        )
    predicted = scores.calibration
    yield (
        f"predicted {predicted.predicts} = what a detector would reach on these objects: "
        f"{visible(predicted.detector)}; ± is two standard errors, of calibration and sample."
    )
    for one in every:
        if one.predicted_outside:
            yield f"{visible(one.rig.name)}: outside the domain of the prediction: {one.predicted_outside}."
    if recall := scores.settings.recall:
        for one in every:
            if said := one.of_100(SURE):
                outside = f"; outside its domain: {one.found_outside}" if one.found_outside else ""
                yield f"{visible(one.rig.name)}: {said[0].lower()}{said[1:]}{outside}."
        yield (
            f"found = by this detector: {visible(recall.detector)}; ± two standard errors. It does not predict your "
            "stack."
        )
    if len(every) > 1:
        yield (
            f"Differences of less than {100.0 * RESOLVED:g} in on target or predicted {predicted.predicts} do not tell "
            "rigs apart."
        )
    if scores.frames_used < scores.frames:
        yield "± of the others is two standard errors of the sample of frames."


def _table(scores: Sequence[TargetScores], parts: Mapping[str, Mapping[str, Row]]) -> Table:
    """Rigs as rows, one section per class, with its parts below."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=0)
    points = scores[0].settings.min_points
    table.add_column("in %, except\nobjects and medians", no_wrap=True, overflow="ellipsis", max_width=20)
    further = _further(scores)
    for title in (
        "\nobjects", f"predicted\n{scores[0].calibration.predicts}", "LiDAR\non target", "LiDAR\n≥ 1 pt",
        f"LiDAR\n≥ {points} pts", "median\npts",
        "camera\nvisible", f"camera\n≥ {HEIGHT_PX} px", "median\npx",
        *(_stacked(kind.plural) for kind in further), "\nboth", "\nneither",
    ):  # fmt: skip
        widest = max(map(len, title.split()))
        table.add_column(
            title, justify="right", min_width=max(5, widest)
        )  # without room, ± goes below the value
    for name in CLASSES:
        table.add_row(Text(name, "bold"))
        for one in scores:
            table.add_row(Text(f"  {visible(one.rig.name)}"), *_figures(one.classes[name].total, further))
        for title, part in parts[name].items():
            table.add_row(Text(f"    {title}", "dim"), *_figures(part, further))
        table.add_section()
    return table


def _further(scores: Sequence[TargetScores]) -> tuple[AnyKind, ...]:
    return further_kinds(kind for one in scores for kind in one.objects.returns)


def _stacked(words: str) -> str:
    """Return one or two words as a heading of two lines."""
    return words.replace(" ", "\n") if " " in words else f"\n{words}"


def _figures(row: Row, further: Sequence[AnyKind]) -> list[str]:
    if not row.objects:
        return ["0", *["–"] * (10 + len(further))]
    return [
        f"{row.objects:,}",
        "–" if row.predicted is None else _share(row.predicted),
        _share(row.on_target),
        _share(row.share_1),
        _share(row.share_n),
        f"{row.median_points:g}",
        _share(row.visible),
        _share(row.share_25px),
        f"{row.median_height_px:.0f}",
        *(_share(row.by_kind.get(kind.name, Estimate())) for kind in further),
        _share(row.both),
        _share(row.neither),
    ]


def _share(found: Estimate) -> str:
    """Percent, with two standard errors where it comes from a sample."""
    if found.se == 0.0:
        return f"{100.0 * found.value:.1f}"
    return f"{100.0 * found.value:.1f} ±{100.0 * SURE * found.se:.1f}"


def _line(label: str, text: str) -> Text:
    return Text.assemble((f"{label:<8}", "bold"), text)
