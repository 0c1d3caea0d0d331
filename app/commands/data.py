"""`riglens data build` and `riglens data show`: box data, built into a POG or described."""

from __future__ import annotations

import hashlib
import math
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import psutil
from cyclopts import Parameter
from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import Dask, GridArguments, Json, Out, ReadingArguments, Workers
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.evaluation.scenario import boxes_of, grid_of, remarks_on
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.resumable import resumable
from riglens.app.terminal.scores import data_line
from riglens.core.files import is_stream, require_writable
from riglens.core.geometry import Vec3
from riglens.core.pieces.where import Where
from riglens.core.pieces.work import Workers as Workforce
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import BYTES_PER_VOXEL, Pog, build_pog
from riglens.core.scene.pog_parts import build_in_parts, groups_of, part_folder
from riglens.core.scene.pog_store import save_pog
from riglens.core.scene.readers import together
from riglens.core.scene.readers.opening import has_known_origin
from riglens.core.scene.survey import RINGS_M, SECTORS, Ground, Survey, survey
from riglens.core.shown_text import visible

GROUND_IS_RIGHT_M = 0.2
"""Bottoms of labelled boxes are rarely nearer to the road than that; the ROI starts at z = 0."""

SHOWN_UNMAPPED = 20
LONGEST_NAME_BYTES = 240
"""File systems allow 255, some with encryption 143, which `require_writable` finds out."""


BoxPaths = Annotated[Path, Parameter(name="BOXES", required=True)]


# ---------------------------------------------------------------- riglens data build


def build(
    *boxes: BoxPaths,
    out: Out,
    scene: GridArguments = GridArguments(),
    workers: Workers = None,
    dask: Dask = None,
) -> None:
    """Build the POG of one or more box data sets together and store it for --pog.

    A build of many logs or tables works on several of them at once. When it is interrupted, the same command goes
    on where it was.

    Parameters
    ----------
    boxes
        Box data sets: tables, nuScenes, Argoverse 2, KITTI or CARLA folders.
    out
        Where to store it (.npz). Finished parts are kept beside it, in FILE.parts, until all is done.
    workers
        Processes that build parts at the same time (as many as cores, parts and memory allow).
    """
    where = Where(workers, dask)
    require_writable(out, boxes)
    grid = grid_of(scene)
    # workers elsewhere have another working folder
    source = boxes_of(scene, [path.resolve() for path in boxes] if dask else boxes)
    groups = groups_of(source)
    with progress_bar("Building the POG") as progress:
        if len(groups) == 1 and dask is None:
            pog = _stored(build_pog(source, grid, progress), boxes, out)
        else:
            with _parts_folder(out) as folder, _workers(folder, len(groups), grid, where) as workforce:
                parts = part_folder(folder)
                pog = _stored(build_in_parts(source, groups, grid, parts, workforce, progress), boxes, out)
                parts.clear()
    _print_pog(pog, out)


def _stored(pog: Pog, paths: Sequence[Path], out: Path) -> Pog:
    pog = replace(pog, data=replace(pog.data, source=together(paths)))
    save_pog(pog, out)
    return pog


@contextmanager
def _parts_folder(out: Path) -> Iterator[Path]:
    """Return the folder of finished parts, next to the output; a pipe or device has none."""
    if is_stream(out):
        with tempfile.TemporaryDirectory(prefix="riglens-") as folder:
            yield Path(folder) / "parts"
        return
    name = os.fsencode(out.name)
    if len(name) > LONGEST_NAME_BYTES:
        name = name[:200] + hashlib.sha256(name).hexdigest()[:16].encode()
    yield out.with_name(os.fsdecode(name) + ".parts")


@contextmanager
def _workers(folder: Path, groups: int, grid: VoxelGrid, where: Where) -> Iterator[Workforce]:
    if where.dask is None:
        count = min(where.workers or _fitting(grid), groups)
        where = replace(where, workers=count)
        if count > 1:
            grid.require_memory(BYTES_PER_VOXEL * (count + 1), f"{count} workers")
    with resumable(folder, where, groups) as workers:
        yield workers


def _fitting(grid: VoxelGrid) -> int:
    """Return the number of cores, or fewer if half of the free memory does not hold that many grids and one more."""
    one = grid.voxel_count * BYTES_PER_VOXEL
    room = int(psutil.virtual_memory().available / 2 / one) - 1
    return max(1, min(os.cpu_count() or 1, room))


def _print_pog(pog: Pog, out: Path) -> None:
    for line in remarks_on(pog.data):
        note(line)
    console = results(out)
    console.print(data_line(pog.data, pog.data.short_source), soft_wrap=True, markup=False)
    console.print(
        f"{out}: {pog.index.count:,} occupied voxels of {pog.grid.voxel_m:g} m", soft_wrap=True, markup=False
    )


# ---------------------------------------------------------------- riglens data show


def show(*boxes: BoxPaths, scene: ReadingArguments = ReadingArguments(), json: Json = None) -> None:
    """Show the contents of box data: classes, directions, distances, sizes, the ground, and unmapped names.

    Parameters
    ----------
    boxes
        Box data sets: tables, nuScenes, Argoverse 2, KITTI or CARLA folders.
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the tables.
    """
    require_outputs(boxes, json)
    source = boxes_of(scene, boxes)
    with progress_bar("Reading boxes") as progress:
        found = survey(source, progress)
    is_known = scene.origin_m is None and all(has_known_origin(path) for path in boxes)
    document = data_document(found, source.origin_m, is_known)
    deliver(document, json, lambda: _print_survey(found, source.origin_m, is_known))


def data_document(found: Survey, origin_m: Vec3 | None, is_known: bool) -> dict[str, Any]:
    """The figures as plain data; lengths in metres, boxes as counts by quarter and ring of distance."""
    data = found.data
    return {
        "riglens": FORMAT_VERSION,
        "data": {
            "source": data.source,
            "frames": data.frames,
            "sequences": data.sequences,
            "boxes": {name: data.boxes[name] for name in CLASSES},
            "unmapped": dict(data.unmapped.most_common()),
            "sha256": data.sha256,
            "notes": list(data.notes),
            "origin_m": None if origin_m is None else list(origin_m),
        },
        "frames_with_boxes": found.frames_with_boxes,
        "boxes_per_frame": {"mean": found.boxes_per_frame, "most": found.most_in_a_frame},
        "rings_m": [limit if math.isfinite(limit) else None for limit in RINGS_M],
        "classes": {name: _class(found, cls) for cls, name in enumerate(CLASSES)},
        "ground": _ground(found.ground),
        "warnings": list(warnings(found, origin_m, is_known)),
    }


def _class(found: Survey, cls: int) -> dict[str, Any]:
    sizes = [None if math.isnan(edge) else edge for edge in found.sizes_m[cls].tolist()]
    return {
        "boxes": int(found.counts[cls].sum()),
        "sectors": {name: found.counts[cls, place].tolist() for place, name in enumerate(SECTORS)},
        "median_size_m": dict(zip(("length", "width", "height"), sizes, strict=True)),
    }


def _ground(ground: Ground | None) -> dict[str, Any] | None:
    if ground is None:
        return None
    return {
        "height_m": ground.height_m,
        "half_between_m": list(ground.between_m),
        "boxes": ground.boxes,
        "class": ground.cls,
        "certain": ground.is_certain,
    }


def warnings(found: Survey, origin_m: Vec3 | None, is_known: bool) -> Iterator[str]:
    """Yield warnings on directions without boxes, and on a ground that is not at z = 0.

    A known height of the data's origin (`is_known`) is better than any estimate.
    """
    bare = found.bare_sectors()
    if bare:
        listed = ", ".join(f"{name} ({count:,})" for name, count in bare.items())
        yield (
            f"almost no boxes {listed}: the data may not cover every side, and coverage there gains almost nothing"
        )
    ground = found.ground
    if ground is not None and not is_known and ground.is_certain and abs(ground.height_m) > GROUND_IS_RIGHT_M:
        advice = "use --ground auto"
        if origin_m is not None:
            x, y, z = origin_m
            advice += f" or --origin {x:g} {y:g} {z + ground.lift_m:.4g}"
        yield f"the ground is not at z = 0 but at {ground.height_m:.2f} m: {advice}"


def _print_survey(found: Survey, origin_m: Vec3 | None, is_known: bool) -> None:
    console, data = results(), found.data
    console.print(Text.assemble(("Data    ", "bold"), visible(data.source)), soft_wrap=True)
    console.print(
        Text.assemble(
            ("Frames  ", "bold"),
            f"{data.frames:,} in {data.sequences:,} sequence{'s' * (data.sequences != 1)}, "
            f"{found.frames_with_boxes:,} of them with boxes; {found.boxes_per_frame:.1f} boxes per frame, at most "
            f"{found.most_in_a_frame:,}",
        )
    )
    ground = "unknown: no boxes nearby" if found.ground is None else found.ground.text()
    if found.ground is not None and not found.ground.is_certain:
        ground += " (not certain)"
    elif found.ground is not None and is_known:
        ground += " (an estimate; the data's own origin is kept)"
    console.print(Text.assemble(("Ground  ", "bold"), ground))
    console.print(_direction_table(found))
    console.print(_distance_table(found))
    if data.unmapped:
        console.print(_unmapped_table(found))
    for line in warnings(found, origin_m, is_known):
        console.print(Text.assemble(("warning: ", "bold yellow"), line), soft_wrap=True)
    for line in data.notes:
        note(line)


def _table(first: str, *titles: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(first, no_wrap=True)
    for title in titles:
        table.add_column(title, justify="right", no_wrap=True)
    return table


def _direction_table(found: Survey) -> Table:
    """Boxes by class and quarter, with the usual size of one."""
    table = _table("boxes", "all", *SECTORS, "median size, m")
    for cls, name in enumerate(CLASSES):
        counts = found.counts[cls].sum(axis=1).tolist()
        size = " × ".join(f"{edge:.2f}" for edge in found.sizes_m[cls].tolist())
        table.add_row(name, *(f"{n:,}" for n in (sum(counts), *counts)), size if sum(counts) else "-")
    counts = found.counts.sum(axis=(0, 2))
    table.add_row("share", "", *(f"{n / max(1, counts.sum()):.1%}" for n in counts), "", style="dim")
    return table


def _distance_table(found: Survey) -> Table:
    """Boxes by class and ring of distance."""
    rings = [
        f"{low:g}-{high:g} m" if math.isfinite(high) else f"from {low:g} m" for low, high in pairwise(RINGS_M)
    ]
    table = _table("distance", *rings)
    for cls, name in enumerate(CLASSES):
        table.add_row(name, *(f"{n:,}" for n in found.counts[cls].sum(axis=0).tolist()))
    return table


def _unmapped_table(found: Survey) -> Table:
    table = _table("not mapped", "boxes")
    most = found.data.unmapped.most_common(SHOWN_UNMAPPED)
    for name, count in most:
        table.add_row(Text(visible(name) if len(name) <= 60 else visible(name[:60]) + "…"), f"{count:,}")
    rest = sum(found.data.unmapped.values()) - sum(count for _, count in most)
    if rest:
        table.add_row(f"{len(found.data.unmapped) - len(most)} more names", f"{rest:,}", style="dim")
    return table
