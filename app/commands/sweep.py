"""`riglens sweep`: figures of many rigs that differ in some fields, as one Parquet table."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Group, Parameter
from rich import box
from rich.table import Table as Printed

from riglens.app.commands.options import (
    CountArguments,
    Dask,
    EverythingArguments,
    Json,
    RigArguments,
    RigNames,
    ScoreArguments,
    Surroundings,
    Workers,
    all_of,
    command,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import TERMINAL, results
from riglens.core.files import require_ending
from riglens.core.pieces.backend import Backend
from riglens.core.shown_text import visible
from riglens.core.sweep.table import (
    better_of,
    document_of,
    doubles,
    header_of,
    main_figures,
    near_best,
)
from riglens.evaluation.loading import load_rigs
from riglens.evaluation.options import CountOptions, SceneOptions, ScoreOptions
from riglens.jobs.sweeping import DesignOptions, swept

if TYPE_CHECKING:
    from pyarrow import Table

DESIGN = Group("Design", sort_key=5)
DesignArguments = Annotated[DesignOptions, all_of(DesignOptions, DESIGN, {"compute": None, "blind_m": None})]


@command
def sweep(
    *rigs: RigNames,
    out: Annotated[Path, Parameter(metavar="FILE.parquet")],
    how: DesignArguments = DesignOptions(),
    chart: Annotated[Path | None, Parameter(metavar="FILE.png|.svg")] = None,
    figure: Annotated[tuple[str, ...], Parameter(metavar="COLUMN", show_default=False)] = (),
    scene: EverythingArguments = SceneOptions(),
    surroundings: Surroundings = None,
    count: CountArguments = CountOptions(sample=100),
    reading: RigArguments = RigArguments(),
    score: ScoreArguments = ScoreOptions(),
    workers: Workers = None,
    dask: Dask = None,
    json: Json = None,
) -> None:
    """Evaluate many rigs that differ in some fields, and store one row for each in a Parquet file.

    Each of several rigs gets every value.

    Parameters
    ----------
    out
        File to store the table in. Finished parts are kept next to it, in FILE.parts, until all rigs are done.
    chart
        Also draw the figures over the one or two varied fields, with their noise.
    figure
        Column to draw, such as car.lidar.seen; may be repeated (on target of the classes).
    json
        Also write data, settings and rows as JSON to a file; with - to standard output, instead of the table.
    """
    backend = Backend(workers, dask)
    require_ending("out", out, ".parquet")
    require_ending("chart", chart, ".png", ".svg")
    require_outputs((*rigs, *scene.files, *([how.table] if how.table else [])), out, chart, json)
    design = how.design()
    loaded = load_rigs(rigs, score, TERMINAL, reading.libraries, reading.housings)
    scene = scene.surrounded(surroundings)
    figures = how.figures(scene, count, score)

    def check(header: Mapping[str, Any]) -> None:
        if chart is not None:
            from riglens.studies.sweep_chart import require_drawable  # matplotlib

            require_drawable(header, figure)

    found = swept(loaded, design, figures, scene, count.within_m, score, out, backend, TERMINAL, check)
    if chart is not None:
        from riglens.studies.pictures import write_picture
        from riglens.studies.sweep_chart import sweep_figure  # matplotlib

        write_picture(chart, sweep_figure(found, figure))
    deliver(document_of(found), json, lambda: print_figures(found, out))


def print_figures(found: Table, out: Path) -> None:
    """Print the least, the greatest and the best of the main figures."""
    console = results(out)
    console.print(f"{out}: {found.num_rows:,} rigs, {found.num_columns} columns", soft_wrap=True)
    printed = Printed(box=box.SIMPLE_HEAD, pad_edge=False)
    for title in ("figure", "better", "least", "greatest", "noise floor", "best with"):
        printed.add_column(title, justify="left" if title in ("figure", "better", "best with") else "right")
    header = header_of(found)
    for name in main_figures(found):
        values = doubles(found, name)
        if np.isnan(values).all():
            continue
        best = int(near_best(name, values).argmax())
        fields = (f"{field} {found[field][best].as_py():g}" for field in header["design"]["fields"])
        where = ", ".join(fields) or found["rig"][best].as_py()
        if near_best(name, values, header["noise_floor"][name]).all():
            where = "all within the noise"
        limits = np.nanmin(values), np.nanmax(values), header["noise_floor"][name]
        row = (better_of(name), *(f"{one:.4f}" for one in limits))
        printed.add_row(name, *row, visible(where))
    console.print(printed)
