"""Build the POG of box data sets together and store it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import psutil

from riglens.core.files import require_writable
from riglens.core.monitor import Monitor
from riglens.core.pieces.backend import Backend
from riglens.core.pieces.resumable import parts_folder, resumable
from riglens.core.pieces.work import Workers as Workforce
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import BYTES_PER_VOXEL, Pog, build_pog
from riglens.core.scene.pog_parts import build_in_parts, groups_of, part_folder
from riglens.core.scene.pog_store import save_pog
from riglens.core.scene.readers import together
from riglens.evaluation.loading import note_data
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import boxes_of, grid_of


def build(boxes: Sequence[Path], out: Path, scene: SceneOptions, backend: Backend, monitor: Monitor) -> Pog:
    """Build the POG of one or more box data sets in a file, and return it; finished parts are kept next to it until
    then."""
    require_writable(out, boxes)
    grid = grid_of(scene)
    # workers elsewhere have another working folder
    source = boxes_of(scene, [path.resolve() for path in boxes] if backend.dask else boxes)
    groups = groups_of(source)
    with monitor.stage("Building the POG") as progress:
        if len(groups) == 1 and backend.dask is None:
            pog = _stored(build_pog(source, grid, progress), boxes, out)
        else:
            with (
                parts_folder(out) as folder,
                _workers(folder, len(groups), grid, backend, monitor) as workforce,
            ):
                parts = part_folder(folder)
                pog = _stored(build_in_parts(source, groups, grid, parts, workforce, progress), boxes, out)
                parts.clear()
    note_data(pog.data, monitor)
    return pog


def _stored(pog: Pog, paths: Sequence[Path], out: Path) -> Pog:
    pog = replace(pog, data=replace(pog.data, source=together(paths)))
    save_pog(pog, out)
    return pog


@contextmanager
def _workers(
    folder: Path, groups: int, grid: VoxelGrid, backend: Backend, monitor: Monitor
) -> Iterator[Workforce]:
    if backend.dask is None:
        count = min(backend.workers or _fitting(grid), groups)
        backend = replace(backend, workers=count)
        if count > 1:
            grid.require_memory(BYTES_PER_VOXEL * (count + 1), f"{count} workers")
    with resumable(folder, backend, groups, monitor) as workers:
        yield workers


def _fitting(grid: VoxelGrid) -> int:
    """Return the number of cores, or fewer if half of the free memory does not hold that many grids and one more."""
    one = grid.voxel_count * BYTES_PER_VOXEL
    room = int(psutil.virtual_memory().available / 2 / one) - 1
    return max(1, min(os.cpu_count() or 1, room))
