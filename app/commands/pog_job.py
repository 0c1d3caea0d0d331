"""What `riglens pog` does: build the POG of box data, in parts when there are many, and store it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import psutil

from riglens.app.commands import tables
from riglens.app.commands.console import note, progress_bar, results
from riglens.app.evaluation.options import SceneOptions
from riglens.app.evaluation.scenario import boxes_of, grid_of, remarks_on
from riglens.core.errors import InputError
from riglens.core.files import require_writable
from riglens.core.scene.boxes import Progress
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import BYTES_PER_VOXEL, Pog, build_pog
from riglens.core.scene.pog_cluster import cluster_workers
from riglens.core.scene.pog_parts import OwnProcess, PartsPlan, Workers, build_in_parts
from riglens.core.scene.pog_processes import worker_processes
from riglens.core.scene.pog_store import save_pog
from riglens.core.scene.readers import together


def build_pog_file(
    options: SceneOptions, paths: Sequence[Path], out: Path, workers: int | None, dask: str | None
) -> None:
    """Build a POG and store it; when interrupted, the old file stays and finished parts wait for the next run."""
    if workers is not None and workers < 1:
        raise InputError(f"--workers: found {workers}, accepted is a whole number from 1 up")
    if workers is not None and dask is not None:
        raise InputError("--workers and --dask: the cluster has its own workers; give only one of the two")
    require_writable(out, paths)
    grid = grid_of(options)
    # workers elsewhere have another working folder
    source = boxes_of(options, [path.resolve() for path in paths] if dask else paths)
    plan = PartsPlan.of(source, grid, out.with_name(f"{out.name}.parts"))
    with progress_bar("Building the POG") as progress:
        if len(plan.groups) == 1 and dask is None:
            pog = build_pog(source, grid, progress)
        else:
            pog = _in_parts(plan, grid, workers, dask, progress)
    pog = replace(pog, data=replace(pog.data, source=together(paths)))
    save_pog(pog, out)
    plan.store.clear()
    _say(pog, out)


def _in_parts(
    plan: PartsPlan, grid: VoxelGrid, workers: int | None, dask: str | None, progress: Progress
) -> Pog:
    try:
        with _workers(plan, grid, workers, dask) as where:
            return build_in_parts(plan, grid, where, progress)
    except KeyboardInterrupt:
        kept = plan.store.count()
        if kept:
            note(f"{kept} of {len(plan.groups)} parts are kept in {plan.store.folder}; run it again to go on")
        raise


@contextmanager
def _workers(plan: PartsPlan, grid: VoxelGrid, workers: int | None, dask: str | None) -> Iterator[Workers]:
    """Where the parts are built: on a cluster, in processes, or here."""
    if dask is not None:
        with cluster_workers(dask) as elsewhere:
            yield elsewhere
        return
    count = min(workers or _fitting(grid), len(plan.groups))
    if count == 1:
        yield OwnProcess()
        return
    grid.require_memory(BYTES_PER_VOXEL * (count + 1), f"{count} workers")
    with worker_processes(count) as processes:
        yield processes


def _fitting(grid: VoxelGrid) -> int:
    """As many workers as there are cores, as long as half of the free memory holds their grids and one more."""
    one = grid.voxel_count * BYTES_PER_VOXEL
    room = int(psutil.virtual_memory().available / 2 / one) - 1
    return max(1, min(os.cpu_count() or 1, room))


def _say(pog: Pog, out: Path) -> None:
    for line in remarks_on(pog.data):
        note(line)
    console = results()
    console.print(tables.data_line(pog.data, pog.data.short_source), soft_wrap=True, markup=False)
    console.print(
        f"{out}: {pog.index.count:,} occupied voxels of {pog.grid.voxel_m:g} m", soft_wrap=True, markup=False
    )
