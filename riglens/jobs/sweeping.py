"""Evaluate many rigs that differ in some fields, into one table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from riglens.core.errors import InputError
from riglens.core.monitor import Monitor
from riglens.core.pieces.backend import Backend
from riglens.core.pieces.resumable import parts_folder, resumable
from riglens.core.rig.model import Rig
from riglens.core.sweep.design import Design, Span, grid, sobol, table
from riglens.core.sweep.rows import SweepFigures
from riglens.core.sweep.table import write
from riglens.evaluation.loading import note_data
from riglens.evaluation.options import CountOptions, SceneOptions, ScoreOptions
from riglens.evaluation.scenario import settings_of
from riglens.evaluation.sweeping import LoadedSweep, SweepOptions, piece_folder

if TYPE_CHECKING:
    from pyarrow import Table


def design_of(spans: Sequence[Span], points: int | None, seed: int, path: Path | None) -> Design:
    """Return the design that was asked for; raise InputError for contradicting ones."""
    if path is not None:
        if spans or points is not None:
            raise InputError("cannot be combined with", "table", "vary" if spans else "sobol")
        return table(path)
    return grid(spans) if points is None else sobol(spans, points, seed)


def sweep_options(
    rigs: Sequence[Rig],
    scene: SceneOptions,
    count: CountOptions,
    score: ScoreOptions,
    compute: Literal["score", "targets"] | None = None,
    blind_m: float | None = None,
) -> SweepOptions:
    """Return what rows are computed from; raise InputError for options that contradict."""
    if blind_m is not None and not 0.05 <= blind_m <= 2.0:
        raise InputError(f"must be between 0.05 and 2 m (got {blind_m:g})", "blind_m")
    if compute != "score" and scene.pog is not None:
        raise InputError("holds no objects to count: leave it out, or choose score for", "pog", "compute")
    figures = SweepFigures(
        None if compute == "targets" else settings_of(score),
        None if compute == "score" else count.settings(score.body),
        count.sample,
        blind_m,
    )
    scene = replace(
        scene.for_rigs(rigs, score),
        boxes=scene.boxes and scene.boxes.resolve(),  # workers elsewhere have another working folder
        pog=scene.pog and scene.pog.resolve(),
        occluders=scene.occluders and (scene.occluders[0].resolve(), scene.occluders[1].resolve()),
    )
    return SweepOptions(scene, count.within_m, figures, rigs[0])


def run_sweep(sweep: LoadedSweep, out: Path, backend: Backend, monitor: Monitor) -> Table:
    """Compute all rows, write them into a file, and return them."""
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
