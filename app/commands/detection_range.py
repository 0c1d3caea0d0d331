"""Detection range by class and direction; part of `riglens review`, alone as `riglens card`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import (
    Json,
    RigArguments,
    RigName,
    SolidBody,
    ThreadArguments,
    number,
)
from riglens.app.commands.options import (
    command as by_options,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import results
from riglens.app.terminal.loading import load_rigs
from riglens.app.terminal.tables import table
from riglens.core.files import require_ending, write_file
from riglens.core.shown_text import visible
from riglens.core.targets.detection_range import DetectionRange, RangePlan, RangeRow, around
from riglens.core.targets.detection_range_table import range_document, range_lines
from riglens.core.targets.detection_range_text import HEADINGS, bearing_text, reach_text, stop_text
from riglens.evaluation.options import ScoreOptions
from riglens.jobs.reviewing import detection_range
from riglens.studies.files import csv_text

DETECTION = Group("Detection", sort_key=20)
BRAKING = Group("Braking", sort_key=21)


@by_options
def command(
    rig: RigName,
    /,
    *,
    min_points: Annotated[int, number(DETECTION)] = 5,
    min_height: Annotated[float, Parameter(group=DETECTION, metavar="PX")] = 25.0,
    directions: Annotated[int, number(DETECTION)] = 8,
    to: Annotated[float, Parameter(group=DETECTION, metavar="M")] = 150.0,
    reaction: Annotated[float, Parameter(group=BRAKING, metavar="S")] = 1.0,
    deceleration: Annotated[float, Parameter(group=BRAKING, metavar="MPS2")] = 5.0,
    score: ThreadArguments = ScoreOptions(),
    body: SolidBody = None,
    reading: RigArguments = RigArguments(),
    csv: Annotated[Path | None, Parameter(metavar="FILE.csv")] = None,
    chart: Annotated[Path | None, Parameter(metavar="FILE.png|.svg")] = None,
    json: Json = None,
) -> None:
    """Report the detection range of a rig for one object in the open, next to stopping distances. The car is solid.

    Parameters
    ----------
    min_points
        LiDAR points that detect an object.
    min_height
        Height in native pixels at which a camera detects an object.
    directions
        Number of directions around the car, the first one ahead.
    to
        Maximum distance, in metres.
    reaction
        Reaction time until the car brakes, in seconds (our choice).
    deceleration
        Deceleration in m/s2 (our choice).
    csv
        Also write the ranges as a table.
    chart
        Also draw a chart: distance by direction.
    json
        Also write them as JSON to a file; with - to standard output, instead of the table.
    """
    score = score.solid(body)
    plan = RangePlan(
        min_points,
        min_height,
        around(directions),
        to,
        reaction_s=reaction,
        deceleration_mps2=deceleration,
    )
    require_ending("chart", chart, ".png", ".svg")
    (opened,) = load_rigs([rig], score, reading.libraries, reading.housings)
    require_outputs((rig,), csv, chart, json)
    found = detection_range(opened, plan, score.threads)
    if csv is not None:
        write_file(csv, csv_text(range_lines(found)))
    if chart is not None:
        from riglens.studies.detection_range_chart import range_figure  # matplotlib
        from riglens.studies.pictures import write_picture

        write_picture(chart, range_figure(found))
    deliver(range_document(found), json, lambda: print_range(found))


def print_range(ranges: DetectionRange) -> None:
    """Print the distances, what they mean, and the stopping distances, on standard output."""
    console = results()
    console.print(
        Text(f"{visible(ranges.rig.name)}: first distance in metres with too little"), soft_wrap=True
    )
    console.print(_table(ranges))
    for line in _explanation(ranges):
        console.print(line, soft_wrap=True)
    console.print(_stops(ranges))


def _explanation(ranges: DetectionRange) -> Iterator[str]:
    """Yield the lines that explain the figures."""
    plan = ranges.plan
    yield (
        f"LiDARs: fewer than {plan.min_points} points, as worst/median/best over the object's position between the "
        f"beams (gap {ranges.gap_deg:.2g} deg). Cameras: less than {plan.min_height_px:g} pixels tall. More is better."
    )
    yield (
        f"Alone on flat ground, body {plan.settings.as_dict()['body']}; distance from the middle of the car to "
        f"the middle of the object, up to {plan.to_m:g} m."
    )
    yield (
        f"Stops from: speed from which the car stops before it, {plan.reaction_s:g} s of reaction and "
        f"{plan.deceleration_mps2:g} m/s2 (our choice), at the least distance."
    )


def _table(ranges: DetectionRange) -> Table:
    titles = ("object", *map(bearing_text, ranges.plan.bearings_deg), "stops from")
    made = table(*titles, dense=True, wraps=range(len(titles)))
    rows = list(dict.fromkeys((row.cls, row.heading_deg) for row in ranges.rows))
    for cls, heading in rows:
        mine = [row for row in ranges.rows if (row.cls, row.heading_deg) == (cls, heading)]
        for kind in mine[0].reaches:
            made.add_row(f"{cls} {HEADINGS[heading]}, {kind}", *_cells(ranges, mine, kind))
    return made


def _cells(ranges: DetectionRange, rows: list[RangeRow], kind: str) -> Iterator[str]:
    ahead = ""
    for row in rows:
        reach = row.reaches[kind]
        yield reach_text(reach, ranges.plan.to_m)
        ahead = ahead or stop_text(ranges.stops_from_kmh(row, reach))
    yield ahead


def _stops(ranges: DetectionRange) -> Table:
    made = table("speed (km/h)", *(f"{speed:g}" for speed in ranges.plan.speeds_kmh), dense=True)
    made.add_row(
        "stops within (m)", *(f"{ranges.plan.stopping_m(speed):.0f}" for speed in ranges.plan.speeds_kmh)
    )
    return made
