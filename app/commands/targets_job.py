"""What `riglens targets` does: count for rigs and say it as a table, as JSON, as a table of objects."""

from __future__ import annotations

import csv
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import remarks_on
from riglens.app.evaluation.traffic import load_traffic
from riglens.app.terminal.console import note, progress_bar
from riglens.app.terminal.scores import meshes_called, rig_called
from riglens.app.terminal.targets import print_targets
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, require_writable
from riglens.core.rig.model import Rig
from riglens.core.shown_text import spreadsheet_cell
from riglens.core.targets.engine import TargetEngine, warm_up
from riglens.core.targets.object_table import Columns, object_table
from riglens.core.targets.scores import TargetScores
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.targets_json import targets_document
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh import BodyMesh


@dataclass(frozen=True)
class Counting:
    """How to count: settings, up to which distance, in how many frames (None: all); `score` says threads and body."""

    settings: TargetSettings
    within_m: float
    sample: int | None
    score: ScoreOptions

    def __post_init__(self) -> None:
        if self.sample is not None and self.sample < 1:
            raise InputError(f"--sample: found {self.sample}, accepted is a whole number of frames from 1 up")

    @property
    def how(self) -> TargetSettings:
        """The settings with the body of this run."""
        return replace(self.settings, body=self.score.body)


def targets(
    names: Sequence[str], scene: SceneOptions, counting: Counting, objects: Path | None, json: str | None
) -> None:
    """Print what some rigs get as a table, also written to files; with "-" as JSON alone."""
    rigs = [rig_called(name) for name in names]
    meshes = meshes_called(names, rigs, counting.score)
    reads: tuple[str | Path, ...] = (*names, *scene.files)
    if json not in (None, "-"):
        require_writable(json, reads)
    if objects is not None:
        _check_objects(objects, rigs)
        require_writable(objects, reads)
    for line in (line for rig in rigs for line in missing_rays(rig)):
        note(line)
    traffic = _load(scene, counting)
    scores = _count(rigs, meshes, traffic, counting)
    if objects is not None:
        write_objects(objects, object_table(traffic, scores[0]))
    text = to_text(targets_document(traffic, scores))
    if json == "-":
        sys.stdout.write(text)
        return
    if json is not None:
        with atomic_write(json, "w") as stream:
            stream.write(text)
    print_targets(traffic, scores)


def _check_objects(objects: Path, rigs: Sequence[Rig]) -> None:
    if objects.suffix.lower() not in (".csv", ".parquet"):
        raise InputError(f"--objects {objects}: found another ending, accepted are .csv and .parquet")
    if len(rigs) > 1:
        raise InputError(f"--objects {objects}: found {len(rigs)} rigs, accepted is one")


def _load(scene: SceneOptions, counting: Counting) -> Traffic:
    with progress_bar("Reading boxes") as progress:
        traffic = load_traffic(scene, counting.within_m, progress)
    for line in remarks_on(traffic.data):
        note(line)
    return traffic


def _count(
    rigs: Sequence[Rig], meshes: Sequence[BodyMesh | None], traffic: Traffic, counting: Counting
) -> list[TargetScores]:
    """Each rig from scratch, so that their times can be compared."""
    scores = []
    threads = counting.score.threads
    warm_up(threads)
    with progress_bar("Casting rays") as progress:
        for number, (rig, mesh) in enumerate(zip(rigs, meshes, strict=True), 1):
            engine = TargetEngine(traffic, threads)
            scores.append(engine.evaluate(rig, counting.how, counting.sample, mesh))
            progress(number / len(rigs))
    return scores


def write_objects(path: Path, columns: Columns) -> None:
    """Write columns as CSV or Parquet, whichever the name ends in."""
    if path.suffix.lower() == ".parquet":
        import pyarrow as pa
        from pyarrow import parquet

        with atomic_write(path) as stream:
            parquet.write_table(pa.table(columns), stream)
        return
    with atomic_write(path, "w") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([spreadsheet_cell(name) for name in columns])
        names = [spreadsheet_cell(name) for name in columns["seq"]]
        writer.writerows(zip(names, *list(columns.values())[1:], strict=True))
