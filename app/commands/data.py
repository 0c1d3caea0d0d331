"""`riglens data build` and `riglens data show`: box data, built into a POG or described."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import (
    Dask,
    GridArguments,
    JsonFigures,
    Out,
    ReadingArguments,
    Workers,
    command,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import TERMINAL, note, progress_bar, results
from riglens.app.terminal.tables import table
from riglens.core.pieces.backend import Backend
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.statistics import RINGS_M, SECTORS
from riglens.core.scene.survey import Survey
from riglens.core.shown_text import visible
from riglens.evaluation.described import Described, described
from riglens.evaluation.names import option_with
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scene_words import data_line
from riglens.jobs.building import build as build_file

SHOWN_UNMAPPED = 20


BoxPaths = Annotated[Path, Parameter(name="BOXES", required=True)]


# ---------------------------------------------------------------- riglens data build


@command
def build(
    *boxes: BoxPaths,
    out: Out,
    scene: GridArguments = SceneOptions(),
    workers: Workers = None,
    dask: Dask = None,
) -> None:
    """Build the POG of one or more box data sets together and store it for --pog.

    Parameters
    ----------
    boxes
        Box data sets: tables, or folders of nuScenes, Argoverse 2, KITTI, ONCE, ZOD, DAIR-V2X, OPV2V or CARLA.
    out
        File to store it in (.npz). Finished parts are kept next to it, in FILE.parts, until the build is complete.
    """
    pog = build_file(boxes, out, scene, Backend(workers, dask), TERMINAL)
    console = results(out)
    console.print(data_line(pog.data, pog.data.short_source), soft_wrap=True)
    console.print(f"{out}: {pog.index.count:,} occupied voxels of {pog.grid.voxel_m:g} m", soft_wrap=True)


# ---------------------------------------------------------------- riglens data show


@command
def show(*boxes: BoxPaths, scene: ReadingArguments = SceneOptions(), json: JsonFigures = None) -> None:
    """Show the contents of box data: classes, directions, distances, sizes, the ground, and unmapped names.

    Parameters
    ----------
    boxes
        Box data sets: tables, or folders of nuScenes, Argoverse 2, KITTI, ONCE, ZOD, DAIR-V2X, OPV2V or CARLA.
    """
    require_outputs(boxes, json)
    with progress_bar("Reading boxes") as progress:
        found = described(scene, boxes, progress)
    deliver(found.document(option_with), json, lambda: _print_survey(found))


def _print_survey(shown: Described) -> None:
    console, found, data = results(), shown.survey, shown.survey.data
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
    elif found.ground is not None and found.statistics.is_origin_known:
        ground += " (an estimate; the data's own origin is kept)"
    console.print(Text.assemble(("Ground  ", "bold"), ground))
    console.print(_direction_table(found))
    console.print(_distance_table(found))
    if data.unmapped:
        console.print(_unmapped_table(found))
    for line in shown.warnings(option_with):
        console.print(Text.assemble(("warning: ", "bold yellow"), line), soft_wrap=True)
    for line in data.notes:
        note(line)


def _direction_table(found: Survey) -> Table:
    """Boxes by class and quarter, with the usual size of one."""
    made = table("boxes", "all", *SECTORS, "median size, m")
    for cls, name in enumerate(CLASSES):
        counts = found.counts[cls].sum(axis=1).tolist()
        size = " × ".join(f"{edge:.2f}" for edge in found.sizes_m[cls].tolist())
        made.add_row(name, *(f"{n:,}" for n in (sum(counts), *counts)), size if sum(counts) else "-")
    counts = found.counts.sum(axis=(0, 2))
    made.add_row("share", "", *(f"{n / max(1, counts.sum()):.1%}" for n in counts), "", style="dim")
    return made


def _distance_table(found: Survey) -> Table:
    """Boxes by class and ring of distance."""
    rings = [
        f"{low:g}-{high:g} m" if math.isfinite(high) else f"from {low:g} m" for low, high in pairwise(RINGS_M)
    ]
    made = table("distance", *rings)
    for cls, name in enumerate(CLASSES):
        made.add_row(name, *(f"{n:,}" for n in found.counts[cls].sum(axis=0).tolist()))
    return made


def _unmapped_table(found: Survey) -> Table:
    made = table("not mapped", "boxes")
    most = found.data.unmapped.most_common(SHOWN_UNMAPPED)
    for name, count in most:
        made.add_row(Text(visible(name) if len(name) <= 60 else visible(name[:60]) + "…"), f"{count:,}")
    rest = sum(found.data.unmapped.values()) - sum(count for _, count in most)
    if rest:
        made.add_row(f"{len(found.data.unmapped) - len(most)} more names", f"{rest:,}", style="dim")
    return made
