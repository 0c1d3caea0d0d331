"""Evaluate many rigs that differ in some fields, into one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from riglens.core.errors import InputError
from riglens.core.monitor import Monitor
from riglens.core.option_help import OptionHelp
from riglens.core.pieces.backend import Backend
from riglens.core.pieces.resumable import parts_folder, resumable
from riglens.core.rig.model import Rig
from riglens.core.sweep.design import Design, Span, Sweep, grid, sobol, table
from riglens.core.sweep.rows import SweepFigures
from riglens.core.sweep.table import write
from riglens.evaluation.loading import note_data
from riglens.evaluation.options import CountOptions, SceneOptions, ScoreOptions
from riglens.evaluation.scenario import settings_of
from riglens.evaluation.sweeping import LoadedSweep, SweepOptions, piece_folder

if TYPE_CHECKING:
    from pyarrow import Table


@dataclass(frozen=True)
class DesignOptions:
    """Options of the rigs of a sweep, and of what is evaluated of each."""

    vary: Annotated[
        tuple[str, ...],
        OptionHelp(
            "FIELD=FROM:TO:N",
            "Field and its values, such as LIDAR_TOP.z=1.6:2.2:13 (metres, degrees); repeated: all combinations.",
        ),
    ] = ()
    sobol: Annotated[
        int | None,
        OptionHelp("N", "Vary all fields at once instead, over this number of points of a Sobol sequence."),
    ] = None
    table: Annotated[
        Path | None,
        OptionHelp(
            "FILE",
            "Take the values from a CSV or Parquet file with a column per field and a row per rig.",
        ),
    ] = None
    design_seed: Annotated[int, OptionHelp("N", "Seed of the Sobol sequence.")] = 0
    compute: Annotated[
        Literal["score", "targets"] | None,
        OptionHelp("", "Compute scores alone, or points on objects alone."),
    ] = None
    blind_m: Annotated[
        float | None,
        OptionHelp("M", "Also measure the area where an object of this height is in no sensor's view."),
    ] = None

    def __post_init__(self) -> None:
        if self.blind_m is not None and not 0.05 <= self.blind_m <= 2.0:
            raise InputError(f"must be between 0.05 and 2 m (got {self.blind_m:g})", "blind_m")

    def design(self, spans: Sequence[Span] | None = None) -> Design:
        """Return the design, of these spans in place of the words; raise InputError for contradicting options."""
        spans = [Span.parsed(text) for text in self.vary] if spans is None else spans
        if self.table is not None:
            if spans or self.sobol is not None:
                raise InputError("cannot be combined with", "table", "vary" if spans else "sobol")
            return table(self.table)
        return grid(spans) if self.sobol is None else sobol(spans, self.sobol, self.design_seed)

    def figures(self, scene: SceneOptions, count: CountOptions, score: ScoreOptions) -> SweepFigures:
        """Return what is evaluated; raise InputError for objects of a stored POG."""
        if self.compute != "score" and scene.pog is not None:
            raise InputError("holds no objects to count: leave it out, or choose score for", "pog", "compute")
        return SweepFigures(
            None if self.compute == "targets" else settings_of(score),
            None if self.compute == "score" else count.settings(score.body),
            count.sample,
            self.blind_m,
        )


def swept(
    rigs: Sequence[Rig],
    design: Design,
    figures: SweepFigures,
    scene: SceneOptions,
    within_m: float,
    score: ScoreOptions,
    out: Path,
    backend: Backend,
    monitor: Monitor,
    check: Callable[[Mapping[str, Any]], object] = lambda header: None,
) -> Table:
    """Compute all rows, write them into a file, and return them; an interrupted sweep resumes.

    check: gets the header of the table before the rows are computed, and may raise.
    """
    scene = replace(
        scene.for_rigs(rigs, score),
        boxes=scene.boxes and scene.boxes.resolve(),  # workers elsewhere have another working folder
        pog=scene.pog and scene.pog.resolve(),
        occluders=scene.occluders and (scene.occluders[0].resolve(), scene.occluders[1].resolve()),
    )
    options = SweepOptions(scene, within_m, figures, rigs[0])
    sweep = LoadedSweep(Sweep.of(rigs, design), options, design.kind, score.threads)
    check(sweep.header)
    for data in sweep.data:
        note_data(data, monitor)
    spans = sweep.spans()
    with monitor.stage("Evaluating rigs") as progress, parts_folder(out) as folder:
        store = piece_folder(folder)
        with resumable(folder, backend, len(spans), monitor) as workers:
            # a machine of a cluster has a worker for each core
            found = sweep.table(store, workers, spans, None if backend.dask is None else 1, progress)
            write(found, out)
            store.clear()
    return found
